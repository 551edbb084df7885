"""What guides the paths at a pixel of a graph in view: its cell's lobes, the directions of the last frame that they
learn from, and, on request, the true product. Maps are of the hemisphere about the normal, see
harness/guide_maps.py."""

import base64
from types import SimpleNamespace

import numpy as np

from restirpg.harness import UserError, guiding

from . import pictures

_LARGER = 10  # pixels of a bin's side


def at_pixel(pane, probe, scene, pixel, with_product):
    """{lobes: [(kappa, weight)], alpha, samples, side (m), age, maps: {name: PNG as base64}}. Raises UserError where
    the graph has no guide in the hash grid, or the pixel shows no surface."""
    from restirpg.harness import guide_maps  # matplotlib takes a second

    names = guiding.GuidedGraph(pane.description)
    grid = names.grid(pane.renderer)
    images = {"normal": "geometric_normal", "depth": "depth", "material": "material"}
    seen = SimpleNamespace(camera=pane.renderer.camera, output=lambda name: probe.renderer.output(images[name]))
    (point,) = guide_maps.find_points(seen, grid, [pixel], pane.renderer.size)
    guide = guiding.read_table(pane.renderer.read_port(f"{names.fit}.guide"), guiding.CELL, guiding.MEMORY)[1]
    maps, told = {}, {"side": float(grid.side(guiding.level_of(point.key)))}
    if with_product:
        maps["true product"] = guide_maps.products_at([point], scene, scene.bounce_cap or 8)[0]
    if point.key in guide:
        cell = guide[point.key][0]
        mixture = guiding.mixture_of(cell)
        maps["lobes"] = guide_maps.lobes_in(mixture, point)
        order = np.argsort(-mixture.weight)
        told.update(
            lobes=[(float(mixture.kappa[i]), float(mixture.weight[i])) for i in order],
            age=int(cell["age"]),
            alpha=guiding.alpha_of(cell),
            samples=float(cell["samples"]),
        )
    port = f"{names.reuse}.vertices"
    if port in pane.renderer.memory():
        directions, _, keys = guide_maps.splatted(pane.renderer, port, grid)
        mine = directions[keys == np.uint64(point.key)]
        told["directions"] = len(mine)
        if len(mine):
            maps["directions of this frame"] = point.histogram(guiding.unpack_direction(mine), np.ones(len(mine)))
    if not maps:
        raise UserError(f"nothing guides at pixel {pixel[0]} {pixel[1]} yet")
    return {**told, "maps": _encoded(maps)}


def _encoded(maps):
    """PNGs of densities on one scale, that of the first map."""
    limit = max(float(np.quantile(next(iter(maps.values())), 0.99)), 1e-12)
    larger = {name: np.kron(values, np.ones((_LARGER, _LARGER))) for name, values in maps.items()}
    return {
        name: base64.b64encode(pictures.png(pictures.heat(values, limit))).decode() for name, values in larger.items()
    }
