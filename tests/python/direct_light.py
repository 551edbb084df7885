"""What the tests of ReSTIR DI share: scenes of lights, their graph, and the path tracer's direct light.

The statistics, null hypothesis and false-alarm rate are those of scripts/restirpg/harness/unbiased.py: block means of
4 x 4 pixels over independent runs are tested together, at 1%, and the image mean at 1%. Block means of 16 pixels and 64
runs are close to normal.
"""

import numpy as np
from means import reference_of
from renderer_scenes import make_renderer, restirpg

from restirpg.harness.unbiased import Reference
from restirpg.scenes import shapes
from restirpg.scenes.gltf import Material, SceneFile, Texture, emitter, glass, lambert

TREES = 16  # per pixel and frame of a reference: as many paths as 16 frames, in less time


class LitScene(SceneFile):
    """A scene under construction that can hold every kind of punctual light."""

    def add_punctual(self, kind, position, target, intensity):
        """Add a point light (W/sr) or a directional one (W/m^2)."""
        node = self.add_spot(kind, position, target, intensity)
        light = self._json["extensions"]["KHR_lights_punctual"]["lights"][-1]
        del light["spot"]
        light["type"] = kind
        return node


def write_every_light(folder):
    """A glossy floor, a box and a slab of frosted glass under every kind of light; no delta lobe anywhere."""
    sky = np.full((8, 16, 3), 0.1, np.float32)
    sky[1:3, 3:6] = (4.0, 3.0, 1.0)
    scene = LitScene("every_light", 0, environment=sky)
    gloss = Material("Gloss", (0.5, 0.35, 0.2), roughness=0.35)
    squares = np.kron(np.array([[255, 40], [90, 200]], np.uint8), np.ones((4, 4), np.uint8))
    panel = emitter(
        "Panel", (6.0, 5.0, 4.0), double_sided=True, emission_texture=Texture(np.repeat(squares[..., None], 3, axis=2))
    )
    scene.add("Floor", (shapes.quad((-2, 0, 2), (4, 0, 0), (0, 0, -4)), gloss))
    scene.add("Wall", (shapes.quad((-2, 0, -1.2), (4, 0, 0), (0, 2.5, 0)), lambert("White", (0.7, 0.7, 0.7))))
    box = shapes.box((-0.3, 0, -0.3), (0.3, 0.9, 0.3)).turned("y", 30).moved(-0.5)
    scene.add("Box", (box, lambert("Clay", (0.6, 0.3, 0.2))))
    frost = glass("Frost", roughness=0.4, tint=(0.6, 0.9, 0.7), tint_distance=0.1)
    scene.add("Slab", (shapes.box((0.3, 0, 0.2), (1.1, 0.9, 0.3)), frost))
    scene.add("Panel", (shapes.quad((-0.25, -0.25, 0), (0.5, 0, 0), (0, 0.5, 0)), panel), at=(0.9, 0.8, -0.5))
    strip = shapes.quad((-1.3, 1.9, -0.3), (0.2, 0, 0), (0, 0, 0.6))
    scene.add("Strip", (strip, emitter("Strip", (5.0, 6.0, 9.0))))
    scene.add_spot("Spot", (1.2, 2.0, 1.0), (0.2, 0.0, 0.0), (2.0, 3.0, 2.0))
    scene.add_punctual("point", (-1.2, 0.7, 0.8), (0, 0, 0), (0.3, 0.2, 0.2))
    scene.add_punctual("directional", (2.0, 3.0, 2.0), (0, 0, 0), (0.3, 0.3, 0.5))
    scene.add_camera((0.2, 1.0, 3.4), (0.0, 0.6, 0), 36.0)
    return scene.write(folder)


def write_open_floor(folder):
    """A floor and a light that hides nothing from anything: visibility is 1 wherever the light goes."""
    scene = SceneFile("open_floor", 0)
    gloss = Material("Gloss", (0.6, 0.5, 0.4), roughness=0.5)
    scene.add("Floor", (shapes.quad((-3, 0, 3), (6, 0, 0), (0, 0, -6)), gloss))
    lamp = shapes.quad((-0.4, 0, -0.4), (0.8, 0, 0), (0, 0, 0.8))
    scene.add("Lamp", (lamp, emitter("Lamp", (9.0, 8.0, 7.0))), at=(0, 1.6, 0))
    scene.add_camera((0.0, 1.1, 3.4), (0.0, 0.2, 0), 36.0)
    return scene.write(folder)


def direct_graph(**knobs):
    """ReSTIR DI alone, every frame's radiance as output."""
    graph = restirpg.Graph("Direct light")
    gbuffer = graph.add("gbuffer", "GBuffer", jitter=False)
    direct = graph.add(
        "direct",
        "ReSTIRDI",
        surface=gbuffer.surface,
        motion=gbuffer.motion,
        previous_surface=restirpg.prev("gbuffer.surface"),
        history=restirpg.prev("direct.reservoirs"),
        **knobs,
    )
    graph.output("radiance", direct.radiance)
    return graph


def make_reference(scene, paths, prepare=None, deltas=False, seed=99):
    """Direct light by NEE and BSDF sampling, so many paths per pixel. `prepare`(renderer) may move the camera or nodes.
    `deltas`: whether the scene has delta lobes, by which ReSTIRDI finds nothing: what they find is taken away."""
    graph = restirpg.Graph("Direct light by path tracing")
    gbuffer = graph.add("gbuffer", "GBuffer", jitter=False)
    tracers = {"all": True} | ({"delta": False} if deltas else {})
    for name, direct in tracers.items():
        traced = graph.add(name, "PathTracerGuided", surface=gbuffer.surface, direct=direct, trees=TREES)
        mean = graph.add(
            f"mean_{name}", "Accumulate", indirect=traced.radiance, history=restirpg.prev(f"mean_{name}.sums")
        )
        graph.output(f"{name}_mean", mean.mean)
        graph.output(f"{name}_variance", mean.variance)
        graph.output(f"{name}_invalid", mean.invalid)
    renderer = make_renderer(scene, graph, seed=seed)
    renderer.set_everywhere("bounces", 0)
    if prepare:
        prepare(renderer)
    frames = paths // TREES
    renderer.render(frames)
    outputs = ("mean", "variance", "invalid")
    whole, *without = (reference_of(renderer, frames, *(f"{name}_{output}" for output in outputs)) for name in tracers)
    for part in without:
        whole = Reference(whole.mean - part.mean, whole.variance + part.variance)
    return whole
