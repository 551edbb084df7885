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

from restirpg.harness.guiding import LEARNT, with_learnt_paths
from restirpg.records import constant, record

FRAMES = 4
#: Smooth bounces of a path that its reservoir tells wherever x_k is, and bounces that it tells at most.
PREFIX, TOLD = constant("PATH_PREFIX"), constant("PATH_TOLD")
#: Length of the edges that are tested, m: on shorter ones the rounding of positions shows.
LONG = 0.02
VERTICES = f"{LEARNT}.vertices"


@pytest.fixture(scope="module")
def box(scene_file):
    return load_triangles(scene_file)


def with_outputs(*ports):
    """ReSTIR PG with these ports as outputs."""
    graph = with_learnt_paths(restirpg.load_graph(ROOT / "graphs" / "restir_pg.py").description)
    for port in ports:
        name, output = port.split(".")
        graph["outputs"].append({"name": f"{name}_{output}", "pass": name, "output": output})
    return graph


def read_vertices(renderer):
    return renderer.read_port(VERTICES).view(oracle.VERTEX).reshape(-1, TOLD)


def read_reservoirs(renderer):
    """Of the last frame: reservoirs, D and k."""
    reservoirs = renderer.read_port("reuse.reservoirs").view(record("PathReservoir"))
    shape = reservoirs["shape"].astype(int)
    return reservoirs, shape & 0x7F, shape >> 8 & 0xFF


def without_reuse(renderer):
    """Each pixel's path is its candidate."""
    renderer.set("reuse.temporal", False)
    renderer.set("reuse.rounds", 0)


@pytest.fixture(
    scope="module",
    params=[(1, False), (1, True), (3, True)],
    ids=["candidates", "one tree", "three trees"],
)
def frames(scene, request):
    """[(camera, grid, vertices (pixels, bounces), positions (pixels, bounces, 3), reservoirs, D, k)] of a camera that
    moves, with so many path trees per pixel, with or without reuse."""
    renderer = make_renderer(scene, with_outputs(VERTICES, "reuse.reservoirs"), seed=11)
    trees, reuses = request.param
    renderer.set("paths.trees", trees)
    if not reuses:
        without_reuse(renderer)
    result = []
    for frame in range(FRAMES):
        renderer.move_camera(position=(0.03 * frame, 1, 4.35), target=(0.03 * frame, 1, 0))
        renderer.render(1)
        header = oracle.read_table(renderer.read_port("splat.statistics"), oracle.SUMS)[0]
        grid = oracle.grid_of(header, renderer.get("splat.smallest_cell"))
        vertices = read_vertices(renderer)
        positions = grid.positions(vertices["position"].ravel()).reshape(*vertices.shape, 3)
        result.append((renderer.camera, grid, vertices, positions, *read_reservoirs(renderer)))
    return result


def valid(vertices):
    return oracle.is_valid(vertices)


def test_the_grid_spans_the_scene(frames, box):
    for _, grid, *_ in frames:
        assert np.isclose(grid.radius, box.radius, rtol=1e-5)
        assert np.allclose(grid.corner, box.center - 2 * box.radius, atol=1e-5)


def test_vertices_lie_on_surfaces_of_their_material_and_face(frames, box):
    for _, _, vertices, positions, *_ in frames:
        here = valid(vertices)
        points, surface = positions[here], vertices["surface"][here]
        distance, triangle = box.distances(points)
        assert distance.max() < 2e-5 * box.radius
        alone = box.distances(points + 1e-3)[1] == box.distances(points - 1e-3)[1]  # not at an edge of two surfaces
        same = box.material[triangle] == (surface & 0xFFFF)
        assert same[alone].all()
        axis = oracle.vertex_face(vertices[here]) >> 1
        assert np.array_equal(np.abs(box.normals[triangle]).argmax(-1)[alone], axis[alone])


def test_the_first_vertex_is_what_the_pixel_sees(frames, box):
    y, x = np.divmod(np.arange(32 * 32), 32)
    for camera, _, vertices, positions, *_ in frames:
        here = valid(vertices)[:, 0]
        extent = np.tan(camera["yfov"] / 2)
        rays = np.stack(
            [(2 * (x + 0.5) / 32 - 1) * extent, (1 - 2 * (y + 0.5) / 32) * extent, np.full(32 * 32, -1.0)], -1
        )
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        origin = np.broadcast_to(camera["position"], rays.shape)
        distance, triangle = box.cast(origin, rays)
        seen = origin + distance[:, None] * rays
        assert here.sum() > 300 and (triangle[here] >= 0).all()
        assert np.linalg.norm(seen - positions[:, 0], axis=-1)[here].max() < 2e-4


def test_every_direction_points_at_the_next_vertex(frames):
    """The bounce before the reconnection vertex is aimed anew in each pixel: a copy of the source pixel's
    direction would miss."""
    tested = 0
    for _, _, vertices, positions, *_ in frames:
        both = valid(vertices)[:, :-1] & valid(vertices)[:, 1:]
        edge = (positions[:, 1:] - positions[:, :-1])[both]
        length = np.linalg.norm(edge, axis=-1)
        w = oracle.unpack_direction(vertices["direction"][:, :-1][both])
        cosine = (edge * w).sum(-1) / length
        tested += (length > LONG).sum()
        assert cosine[length > LONG].min() > 1 - 1e-5
    assert tested > 1000


def test_paths_end_on_the_light_and_nowhere_before(frames, box):
    """The last vertex of a path that is told to its end, and no other, is marked, and its direction leads to the lamp
    unhindered."""
    for _, _, vertices, positions, reservoirs, edges, _ in frames:
        surface, here = vertices["surface"], valid(vertices)
        final = surface & oracle.FINAL != 0
        count = here.sum(-1)
        assert np.array_equal(here, np.arange(here.shape[1]) < count[:, None])  # no sharp bounce in this scene
        whole = (reservoirs["ucw"] > 0) & (count == edges - 1)
        assert np.array_equal(final.argmax(-1)[whole], count[whole] - 1)
        assert np.array_equal(final.sum(-1), whole)
        assert not (surface[~final] & oracle.LIGHT_SAMPLED).any()
        w = oracle.unpack_direction(vertices["direction"][final])
        _, triangle = box.cast(positions[final] + 1e-4 * w, w)
        assert (
            box.emissive[triangle].mean() > 0.995
        )  # rays that graze the lamp's rim miss it by the rounding of directions


def told_by(reservoirs, edges, k):
    """(pixels, TOLD): which bounces a reservoir tells. The first that it does not ends the walk: a smooth one beyond the
    prefix that is neither at x_{k-1} nor at x_k."""
    bounce, k = np.arange(1, TOLD + 1), k[:, None]
    sharp = reservoirs["labels"][:, None] >> (2 * bounce - 2).astype(np.uint32) & 3 != 0
    in_prefix = np.cumsum(~sharp, -1) <= PREFIX
    told = sharp | in_prefix | ((k > 0) & ((bounce == k - 1) | (bounce == k)))
    told = np.logical_and.accumulate(told, -1) & (bounce < edges[:, None])
    return told & (reservoirs["ucw"] > 0)[:, None]


def test_the_vertices_are_those_of_the_reservoirs_path(frames):
    """All bounces that the reservoir tells; none where it carries no light."""
    for _, _, vertices, _, reservoirs, edges, k in frames:
        told = told_by(reservoirs, edges, k)
        assert (reservoirs["ucw"] > 0).sum() > 300 and (told.sum(-1) > k).sum() > 30
        assert np.array_equal(valid(vertices), told)  # no sharp bounce in this scene


def cosines(vertices, others):
    """Between the directions of vertices."""
    return np.prod([oracle.unpack_direction(v["direction"]) for v in (vertices, others)], axis=0).sum(-1)


@pytest.mark.parametrize("name", ["cornell_box", "cornell_glass"])
def test_candidates_are_walked_as_they_were_traced(embedded, name):
    """PathTracerGuided notes each bounce of its tree as it goes (`samples`). The walk finds the same ones again, but for
    the last where a light sample has made it. Smooth, sharp, and delta bounces; with and without reconnection."""
    environment = {"environment": "5,5,5"} if name == "cornell_glass" else {}
    scene = restirpg.load_scene(embedded(name), **environment)
    renderer = make_renderer(scene, with_outputs(VERTICES, "reuse.reservoirs", "paths.samples"), seed=12)
    without_reuse(renderer)
    compared = {"beyond x_k": 0, "before x_k": 0, "without x_k": 0, "fifth bounce": 0}
    for _ in range(3):
        renderer.render(1)
        traced = renderer.read_port("paths.samples").view(oracle.SAMPLE).reshape(32 * 32, -1)[:, :TOLD]
        walked = read_vertices(renderer)
        reservoirs, edges, k = read_reservoirs(renderer)
        bounce, k = np.arange(1, TOLD + 1), k[:, None]
        told = told_by(reservoirs, edges, k[:, 0])
        assert not valid(walked)[~told].any()
        told &= bounce < edges[:, None] - 1
        assert np.array_equal(valid(walked)[told], valid(traced)[told])
        there = told & valid(traced)
        assert np.array_equal(walked["position"][there], traced["position"][there])
        assert np.array_equal(walked["surface"][there] & 0xFFFF, traced["surface"][there] & 0xFFFF)
        aimed = there & (bounce == k - 1)  # at x_k, not copied
        assert np.array_equal(walked["direction"][there & ~aimed], traced["direction"][there & ~aimed])
        assert cosines(walked[aimed], traced[aimed]).min() > 1 - 1e-6
        final = valid(walked) & (walked["surface"] & oracle.FINAL != 0)
        by_light_sample = walked["surface"] & oracle.LIGHT_SAMPLED != 0
        assert cosines(walked[final & ~by_light_sample], traced[final & ~by_light_sample]).min() > 1 - 1e-6
        other = final & by_light_sample
        assert other.sum() > 50 and (cosines(walked[other], traced[other]) < 1 - 1e-6).mean() > 0.99
        compared["fifth bounce"] += (there & (bounce > PREFIX) & (bounce < k - 1)).sum()
        for where, mask in (
            ("beyond x_k", (k > 0) & (bounce > k)),
            ("before x_k", bounce < k),
            ("without x_k", k == 0),
        ):
            compared[where] += (there & mask).sum()
    assert compared["beyond x_k"] > 100 and compared["before x_k"] > 100
    assert name == "cornell_box" or min(compared.values()) > 10


def test_directions_of_another_pixel_are_found(frames):
    """What a guide would learn if paths were splatted as they stood in the pixel that they came from."""
    _, _, vertices, positions, *_ = frames[-1]
    first, second = positions[:, 0], np.roll(positions[:, 1], -1, 0)
    here = valid(vertices)[:, 1]
    here &= np.roll(here, -1)
    edge = (second - first)[here]
    w = oracle.unpack_direction(vertices["direction"][:, 0][here])
    assert ((edge * w).sum(-1) / np.linalg.norm(edge, axis=-1)).min() < 1 - 1e-5


def test_what_flies_away_takes_the_sphere_along_until_the_run_ends(scene, box):
    """In the frame in which the sphere becomes another, positions of the frame before mean nothing. A run that follows
    begins with the sphere that a new renderer has."""
    renderer = make_renderer(scene, with_outputs(VERTICES), seed=13)

    def sphere():
        """Vertices' positions, and the radius that they are packed by."""
        header = oracle.read_table(renderer.read_port("splat.statistics"), oracle.SUMS)[0]
        grid = oracle.grid_of(header, renderer.get("splat.smallest_cell"))
        vertices = renderer.read_port(VERTICES).view(oracle.VERTEX)
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


def test_guided_bounces_are_the_first_ones_of_all(scene):
    """With alpha = 1 the guide draws nothing, so that paths do not depend on how many bounces there are to learn from."""
    renderer = make_renderer(scene, with_outputs("paths.samples"), seed=12)
    renderer.set("paths.alpha", 1.0)
    kept = {}
    for bounces in (64, 2):
        renderer.set("paths.guided_bounces", bounces)
        renderer.render(3)
        kept[bounces] = renderer.read_port("paths.samples").view(oracle.SAMPLE).reshape(32 * 32, -1)
    assert kept[64].shape[1] == 9 and kept[2].shape[1] == 2
    assert valid(kept[64])[:, 2:].any()
    assert np.array_equal(kept[64][:, :2], kept[2])
