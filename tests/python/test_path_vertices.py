"""The bounces that guides are trained on, against rays cast by brute force through the Cornell box
[shaders/README: Learning: the splat]: the vertices of a pixel are those of one path, the one its reservoir holds, as it
stands in this pixel. Nothing here is statistical.

Stored positions are rounded to 2 x 10^-6 radii of the scene, directions to 3 x 10^-5: bounds are ten times
that.
"""

import guiding_oracle as oracle
import numpy as np
import pytest
from renderer_scenes import ROOT, make_renderer, restirpg
from triangles import load_triangles

from restirpg.records import record

FRAMES = 4
PORTS = ["paths.vertices", "reuse.vertices"]
#: Length of the edges that are tested, m: on shorter ones the rounding of positions shows.
LONG = 0.02


@pytest.fixture(scope="module")
def box(scene_file):
    return load_triangles(scene_file)


@pytest.fixture(scope="module", params=[1, 3], ids=["one tree", "three trees"])
def frames(scene, request):
    """[(camera, {port: vertices (pixels, bounces), positions (pixels, bounces, 3)}, reservoirs)] of a camera
    that moves, with so many path trees per pixel."""
    graph = restirpg.load_graph(ROOT / "graphs" / "restir_pg.py").description
    graph["outputs"] += [
        {"name": f"{p}_{o}", "pass": p, "output": o}
        for p, o in (("paths", "vertices"), ("reuse", "vertices"), ("reuse", "reservoirs"))
    ]
    renderer = make_renderer(scene, graph, seed=11)
    renderer.set("paths.trees", request.param)
    result = []
    for frame in range(FRAMES):
        renderer.move_camera(position=(0.03 * frame, 1, 4.35), target=(0.03 * frame, 1, 0))
        renderer.render(1)
        header = oracle.read_table(renderer.read_port("splat.statistics"), oracle.SUMS)[0]
        grid = oracle.grid_of(header, renderer.get("splat.smallest_cell"))
        vertices = {port: renderer.read_port(port).view(oracle.VERTEX).reshape(32 * 32, -1) for port in PORTS}
        positions = {port: grid.positions(v["position"].ravel()).reshape(*v.shape, 3) for port, v in vertices.items()}
        reservoirs = renderer.read_port("reuse.reservoirs").view(record("PathReservoir"))
        result.append((renderer.camera, grid, vertices, positions, reservoirs))
    return result


def valid(vertices):
    return oracle.is_valid(vertices)


def test_the_grid_spans_the_scene(frames, box):
    for _, grid, *_ in frames:
        assert np.isclose(grid.radius, box.radius, rtol=1e-5)
        assert np.allclose(grid.corner, box.center - 2 * box.radius, atol=1e-5)


@pytest.mark.parametrize("port", PORTS)
def test_vertices_lie_on_surfaces_of_their_material_and_face(frames, box, port):
    for _, _, vertices, positions, _ in frames:
        here = valid(vertices[port])
        points, surface = positions[port][here], vertices[port]["surface"][here]
        distance, triangle = box.distances(points)
        assert distance.max() < 2e-5 * box.radius
        alone = box.distances(points + 1e-3)[1] == box.distances(points - 1e-3)[1]  # not at an edge of two surfaces
        same = box.material[triangle] == (surface & 0xFFFF)
        assert same[alone].all()
        axis = oracle.vertex_face(vertices[port][here]) >> 1
        assert np.array_equal(np.abs(box.normals[triangle]).argmax(-1)[alone], axis[alone])


@pytest.mark.parametrize("port", PORTS)
def test_the_first_vertex_is_what_the_pixel_sees(frames, box, port):
    y, x = np.divmod(np.arange(32 * 32), 32)
    for camera, _, vertices, positions, _ in frames:
        here = valid(vertices[port])[:, 0]
        extent = np.tan(camera["yfov"] / 2)
        rays = np.stack(
            [(2 * (x + 0.5) / 32 - 1) * extent, (1 - 2 * (y + 0.5) / 32) * extent, np.full(32 * 32, -1.0)], -1
        )
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        origin = np.broadcast_to(camera["position"], rays.shape)
        distance, triangle = box.cast(origin, rays)
        seen = origin + distance[:, None] * rays
        assert here.sum() > 300 and (triangle[here] >= 0).all()
        assert np.linalg.norm(seen - positions[port][:, 0], axis=-1)[here].max() < 2e-4


@pytest.mark.parametrize("port", PORTS)
def test_every_direction_points_at_the_next_vertex(frames, port):
    """The bounce before the reconnection vertex is aimed anew in each pixel: a copy of the source pixel's
    direction would miss."""
    tested = 0
    for _, _, vertices, positions, _ in frames:
        both = valid(vertices[port])[:, :-1] & valid(vertices[port])[:, 1:]
        edge = (positions[port][:, 1:] - positions[port][:, :-1])[both]
        length = np.linalg.norm(edge, axis=-1)
        w = oracle.unpack_direction(vertices[port]["direction"][:, :-1][both])
        cosine = (edge * w).sum(-1) / length
        tested += (length > LONG).sum()
        assert cosine[length > LONG].min() > 1 - 1e-5
    assert tested > 1000


@pytest.mark.parametrize("port", PORTS)
def test_paths_end_on_the_light_and_nowhere_before(frames, box, port):
    """The last vertex, and no other, is marked, and its direction leads to the lamp unhindered."""
    for _, _, vertices, positions, _ in frames:
        surface, here = vertices[port]["surface"], valid(vertices[port])
        final = surface & oracle.FINAL != 0
        count = here.sum(-1)
        assert np.array_equal(here, np.arange(here.shape[1]) < count[:, None])  # no sharp bounce in this scene
        assert np.array_equal(final.argmax(-1)[count > 0], count[count > 0] - 1)
        assert np.array_equal(final.sum(-1), count > 0)
        assert not (surface[~final] & oracle.LIGHT_SAMPLED).any()
        w = oracle.unpack_direction(vertices[port]["direction"][final])
        _, triangle = box.cast(positions[port][final] + 1e-4 * w, w)
        assert (
            box.emissive[triangle].mean() > 0.995
        )  # rays that graze the lamp's rim miss it by the rounding of directions


def test_the_vertices_are_those_of_the_reservoirs_path(frames):
    """As many as the path has bounces; none where the reservoir carries no light."""
    for _, _, vertices, _, reservoirs in frames:
        lit = reservoirs["ucw"] > 0
        bounces = np.where(lit, (reservoirs["shape"] & 0xFF).astype(int) - 1, 0)
        assert lit.sum() > 300
        assert np.array_equal(valid(vertices["reuse.vertices"]).sum(-1), bounces)


def test_directions_of_another_pixel_are_found(frames):
    """What a guide would learn if paths were splatted as they stood in the pixel that they came from."""
    _, _, vertices, positions, _ = frames[-1]
    first, second = positions["reuse.vertices"][:, 0], np.roll(positions["reuse.vertices"][:, 1], -1, 0)
    here = valid(vertices["reuse.vertices"])[:, 1]
    here &= np.roll(here, -1)
    edge = (second - first)[here]
    w = oracle.unpack_direction(vertices["reuse.vertices"]["direction"][:, 0][here])
    assert ((edge * w).sum(-1) / np.linalg.norm(edge, axis=-1)).min() < 1 - 1e-5


def test_what_flies_away_takes_the_sphere_along_until_the_run_ends(scene, box):
    """In the frame in which the sphere becomes another, positions of the frame before mean nothing. A run that follows
    begins with the sphere that a new renderer has."""
    renderer = make_renderer(scene, restirpg.load_graph(ROOT / "graphs" / "restir_pg.py"), seed=13)

    def sphere():
        """Vertices' positions, and the radius that they are packed by."""
        header = oracle.read_table(renderer.read_port("splat.statistics"), oracle.SUMS)[0]
        grid = oracle.grid_of(header, renderer.get("splat.smallest_cell"))
        vertices = renderer.read_port("reuse.vertices").view(oracle.VERTEX)
        return grid.positions(vertices["position"][valid(vertices)]), grid.radius

    down = np.eye(4)
    down[1, 3] = -6  # below the floor, where no path gets
    renderer.render(3)
    renderer.move_node("Tower", down)
    renderer.render(1)
    points, radius = sphere()
    assert radius > 2 * box.radius and len(points) > 300
    assert np.linalg.norm(points - box.center, axis=-1).max() < 1.01 * box.radius
    renderer.move_node("Tower", np.eye(4))
    renderer.cut()
    renderer.render(1)
    assert sphere()[1] == pytest.approx(box.radius, rel=1e-5)


def test_paths_that_are_replayed_to_their_end_may_be_longer_than_what_is_kept(embedded):
    """From a wall through a glass sphere to the sky: every bounce behind the first is sharp and replayed, and the path
    has no reconnection vertex. With alpha = 1 the guide draws nothing: pictures do not depend on what is kept."""
    scene = restirpg.load_scene(embedded("cornell_glass"), environment="5,5,5")
    graph = restirpg.load_graph(ROOT / "graphs" / "restir_pg.py").description
    graph["outputs"] += [{"name": "reservoirs", "pass": "reuse", "output": "reservoirs"}]
    pictures = []
    for bounces in (64, 1):
        renderer = make_renderer(scene, graph, seed=12)
        renderer.set("paths.alpha", 1.0)
        renderer.set("paths.guided_bounces", bounces)
        renderer.render(4)
        pictures.append(renderer.output("image"))
        reservoirs = renderer.read_port("reuse.reservoirs").view(record("PathReservoir"))
    edges, reconnection = reservoirs["shape"] & 0xFF, reservoirs["shape"] >> 8 & 0xFF
    assert ((reservoirs["ucw"] > 0) & (edges > 3) & (reconnection == 0)).sum() > 20
    assert np.array_equal(*pictures)


def test_guided_bounces_are_the_first_ones_of_all(scene):
    """With alpha = 1 the guide draws nothing, so that paths do not depend on what it learns. Sizes follow the knob in
    every pass."""
    graph = restirpg.load_graph(ROOT / "graphs" / "restir_pg.py").description
    graph["outputs"] += [{"name": f"{p}_vertices", "pass": p, "output": "vertices"} for p in ("paths", "reuse")]
    renderer = make_renderer(scene, graph, seed=12)
    renderer.set("paths.alpha", 1.0)
    kept = {}
    for bounces in (64, 2):
        renderer.set("paths.guided_bounces", bounces)
        renderer.render(3)
        kept[bounces] = {port: renderer.read_port(port).view(oracle.VERTEX).reshape(32 * 32, -1) for port in PORTS}
    for port in PORTS:
        assert kept[64][port].shape[1] == 9 and kept[2][port].shape[1] == 2
        assert valid(kept[64][port])[:, 2:].any()
        assert np.array_equal(kept[64][port][:, :2], kept[2][port])
