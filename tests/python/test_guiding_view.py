"""GuidingView: a pixel has the colour of the cell that its first bounce falls into, and black where no cell
guides."""

import guiding_oracle as oracle
import numpy as np
import pytest
from renderer_scenes import ROOT, make_renderer, restirpg

from restirpg.harness.guiding import LEARNT, with_learnt_paths
from restirpg.scenes import shapes
from restirpg.scenes.gltf import SceneFile, lambert


@pytest.fixture(scope="module")
def views(scene):
    """{what is shown: image}, each pixel's key (0: no bounce recorded) and the guide's cells, after four
    frames."""
    graph = restirpg.load_graph(ROOT / "graphs" / "restir_pg.py").description
    for show in ("cell", "age", "weight"):
        inputs = {
            "surface": {"pass": "gbuffer", "output": "surface"},
            "guide": {"pass": "fit", "output": "guide"},
        }
        graph["passes"].append({"name": show, "type": "GuidingView", "inputs": inputs, "knobs": {"show": show}})
        graph["outputs"].append({"name": show, "pass": show, "output": "image"})
    graph = with_learnt_paths(graph)
    graph["outputs"].append({"name": "vertices", "pass": LEARNT, "output": "vertices"})
    renderer = make_renderer(scene, graph, seed=2)
    renderer.set("splat.cell_size", 0.15)
    renderer.render(4)
    header, cells, _ = oracle.read_table(renderer.read_port("fit.guide"), oracle.CELL, oracle.MEMORY)
    grid, first = (
        oracle.grid_of(header, renderer.get("splat.smallest_cell")),
        renderer.read_port(f"{LEARNT}.vertices").view(oracle.VERTEX).reshape(32, 32, -1)[..., 0].ravel(),
    )
    keys, doubtful = grid.keys(grid.positions(first["position"]), oracle.vertex_face(first), first["surface"] & 0xFFFF)
    keys[~oracle.is_valid(first) | doubtful] = 0
    return {show: renderer.output(show).reshape(-1, 3) for show in ("cell", "age", "weight")}, keys, cells


def test_black_is_where_no_cell_guides(views):
    images, keys, cells = views
    for show in images:
        for pixel in np.flatnonzero(keys):
            guides = int(keys[pixel]) in cells and cells[int(keys[pixel])][0]["samples"] > 0
            assert images[show][pixel].any() == guides


def test_a_cell_has_one_colour_and_cells_differ(views):
    images, keys, cells = views
    colours = {
        int(key): images["cell"][keys == key] for key in np.unique(keys) if key and images["cell"][keys == key].any()
    }
    assert len(colours) > 30 and all((colour == colour[0]).all() for colour in colours.values())
    assert len({tuple(colour[0]) for colour in colours.values()}) == len(colours)


def test_a_fresh_cell_is_blue(views):
    """Age 0 is the lower end of the scale."""
    images, keys, cells = views
    fresh = [
        pixel
        for pixel in np.flatnonzero(keys)
        if int(keys[pixel]) in cells and images["cell"][pixel].any() and cells[int(keys[pixel])][0]["age"] == 0
    ]
    assert len(fresh) > 100 and (images["age"][fresh] == (0, 0, 1)).all()


@pytest.mark.parametrize("side", [1.9, 2.3, 3.1])
def test_a_sheet_through_the_scenes_middle_is_guided(tmp_path, side):
    """A lookup has the exact place, a sample a packed one: no border of cells may lie between the two."""
    scene = SceneFile("sheet", 6, environment=(1.0, 1.0, 1.0))
    for name, z in (("Back", -side / 2), ("Sheet", 0), ("Front", side / 2)):
        quad = shapes.quad((-side / 2, -side / 2, z), (side, 0, 0), (0, side, 0))
        scene.add(name, (quad, lambert("White", (0.8, 0.8, 0.8))))
    scene.add_camera((0, 0, 0.08 * side), (0, 0, 0), 60.0)
    graph = restirpg.load_graph(ROOT / "graphs" / "restir_pg.py").description
    inputs = {"surface": {"pass": "gbuffer", "output": "surface"}, "guide": {"pass": "fit", "output": "guide"}}
    graph["passes"].append({"name": "cell", "type": "GuidingView", "inputs": inputs})
    graph["outputs"].append({"name": "cell", "pass": "cell", "output": "image"})
    renderer = make_renderer(restirpg.load_scene(scene.write(tmp_path)), graph)
    renderer.render(4)
    assert renderer.output("cell").any(-1).mean() > 0.7
