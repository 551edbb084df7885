"""What guides the paths at a pixel of a graph in view: its cell's lobes, the directions of the last frame that they
learn from, and, on request, the true product. Maps are of the hemisphere about the normal, see
harness/guide_maps.py."""

import base64
from types import SimpleNamespace

import numpy as np

from restirpg.harness import UserError, guiding

from . import pictures

_LARGER = 10  # pixels of a bin's side
_KEPT = ("device", "backend", "validation", "energy_compensation")  # of a graph's options, what the product depends on


def at_pixel(pane, probe, session, pixel, with_product):
    """{lobes: [(kappa, weight)], alpha, samples, side (m), age, maps: {name: PNG as base64}}. Raises UserError where
    the graph has no guide in the hash grid, or the pixel shows no surface."""
    from restirpg.harness import guide_maps  # matplotlib takes a second

    chains = any(entry["type"] == "GuidingChain" for entry in pane.description["passes"])
    guide = _ChainGuide(pane) if chains else _MixtureGuide(pane)
    grid = guide.grid
    images = {"normal": "geometric_normal", "depth": "depth", "material": "material"}
    seen = SimpleNamespace(camera=pane.renderer.camera, output=lambda name: probe.renderer.output(images[name]))
    (point,) = guide_maps.find_points(seen, grid, [pixel], pane.renderer.size)
    maps, told = {}, {"side": float(grid.side(guiding.level_of(point.key)))}
    if with_product:
        kept = {name: session.options[name] for name in _KEPT if name in session.options}
        maps["true product"] = guide_maps.products_at([point], session.scene, pane.bounces, session.time, **kept)[0]
    if found := guide.at(point):
        mixture, learnt = found
        maps["lobes"] = guide_maps.lobes_in(mixture, point)
        order = [i for i in np.argsort(-mixture.weight, kind="stable") if mixture.weight[i] > 0]
        told.update(lobes=[(float(mixture.kappa[i]), float(mixture.weight[i])) for i in order], **learnt)
    splat, samples = guide.learns_from
    if samples is None or samples in pane.renderer.memory():
        directions, weights, keys = guide_maps.learnt(pane.renderer, grid, splat, samples)
        mine = directions[(keys == np.uint64(point.key)) & (weights > 0)]
        told["directions"] = len(mine)
        if len(mine):
            maps["directions of this frame"] = point.histogram(guiding.unpack_direction(mine), np.ones(len(mine)))
    if not maps:
        raise UserError(f"nothing guides at pixel {pixel[0]} {pixel[1]} yet")
    return {**told, "maps": _encoded(maps, guide_maps.top_of(maps.values()))}


class _MixtureGuide:
    """GuidingFit's: a mixture per cell."""

    def __init__(self, pane):
        names = guiding.GuidedGraph(pane.description)
        self.grid = names.grid(pane.renderer)
        self.learns_from = names.splat, None if pane.learnt_vertices else f"{names.paths}.samples"
        header, self._cells = guiding.read_guide(pane.renderer.read_port(f"{names.fit}.guide"))
        learns_alpha = header["options"] & guiding.LEARNS_ALPHA
        self._alpha = None if learns_alpha else float(pane.renderer.get(f"{names.paths}.alpha"))

    def at(self, point):
        """The Mixture at a point and what is told of it; None: there is none."""
        if point.key not in self._cells:
            return None
        cell = self._cells[point.key]
        alpha = guiding.alpha_of(cell) if self._alpha is None else self._alpha
        learnt = {"age": int(cell["age"]), "alpha": alpha, "samples": float(cell["samples"])}
        return guiding.mixture_of(cell), learnt


class _ChainGuide:
    """GuidingChain's: a lobe per chain of a cell."""

    def __init__(self, pane):
        chain, paths = guiding.passes_of(pane.description, "GuidingChain", "PathTracerGuided")
        raw = pane.renderer.read_port(f"{chain}.guide")
        self._header, self._cells = guiding.chain_header_of(raw), guiding.read_table(raw, guiding.CHAIN_CELL)[1]
        self.grid = guiding.grid_of(guiding.header_of(raw), pane.renderer.get(f"{chain}.smallest_cell"))
        self.learns_from = None, f"{paths}.samples"
        self._alpha = pane.renderer.get(f"{paths}.alpha")

    def at(self, point):
        """The Mixture at a point and what is told of it; None: there is none."""
        if point.key not in self._cells or not self._cells[point.key][0]["states"]["samples"].any():
            return None
        cell = self._cells[point.key][0]
        learnt = {
            "age": int(cell["age"]),
            "alpha": float(self._alpha),
            "samples": float(cell["states"]["samples"].sum()),
        }
        return guiding.chain_mixture_of(cell, point.place, self._header), learnt


def _encoded(maps, limit):
    """PNGs of densities from 0 to `limit`."""
    larger = {name: np.kron(values, np.ones((_LARGER, _LARGER))) for name, values in maps.items()}
    return {
        name: base64.b64encode(pictures.png(pictures.heat(values, limit))).decode() for name, values in larger.items()
    }
