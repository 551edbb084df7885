"""What the tests of ReSTIR DI share: scenes of lights, independent runs, and z-tests against the path tracer.

Statistics. A run is a few frames that begin without history (the knob `temporal` is off for the first one),
so that runs are independent; frame k of each run is one sample. Null hypothesis: the mean over runs of every
4 x 4 block of pixels is the path tracer's. |z| of a block is compared with the two-sided quantile of
Student's t at a false-alarm rate of 1% for the whole test (Bonferroni over blocks and values of k). Block
means of 16 pixels and 64 runs are close to normal; random numbers are hashes of pixel, frame and seed, so no
two runs share any.
"""

import sys
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from renderer_scenes import ROOT, make_renderer, restirpg

sys.path.insert(0, str(ROOT / "scripts"))

from scenes import shapes  # noqa: E402
from scenes.gltf import Material, SceneFile, Texture, emitter, glass, lambert  # noqa: E402

BLOCK = 4
FALSE_ALARMS = 0.01
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


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
    panel = emitter("Panel", (6.0, 5.0, 4.0), double_sided=True,
                    emission_texture=Texture(np.repeat(squares[..., None], 3, axis=2)))
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
    direct = graph.add("direct", "ReSTIRDI", surface=gbuffer.surface, motion=gbuffer.motion,
                       previous_surface=restirpg.prev("gbuffer.surface"),
                       history=restirpg.prev("direct.reservoirs"), **knobs)
    graph.output("radiance", direct.radiance)
    return graph


@dataclass
class Reference:
    """The path tracer's direct light through lobes that are not deltas."""

    mean: np.ndarray  # (H, W), luminance
    variance: np.ndarray  # (H, W), of the error of `mean`


def make_reference(scene, frames, prepare=None, seed=99):
    """Direct light by NEE and BSDF sampling. `prepare`(renderer) may move the camera or nodes."""
    graph = restirpg.Graph("Direct light by path tracing")
    gbuffer = graph.add("gbuffer", "GBuffer", jitter=False)
    for name, direct in (("all", True), ("delta", False)):
        paths = graph.add(name, "PathTracerGuided", surface=gbuffer.surface, direct=direct)
        mean = graph.add(f"mean_{name}", "Accumulate", indirect=paths.radiance,
                         history=restirpg.prev(f"mean_{name}.sums"))
        graph.output(f"{name}_mean", mean.mean)
        graph.output(f"{name}_variance", mean.variance)
    renderer = make_renderer(scene, graph, seed=seed)
    renderer.set_everywhere("bounces", 0)
    if prepare:
        prepare(renderer)
    renderer.render(frames)
    outputs = {name: renderer.output(name).astype(float) for name in renderer.output_names}
    # The standard deviation of a luminance is at most that of fully correlated channels.
    variance = sum((np.sqrt(outputs[f"{name}_variance"]) @ LUMINANCE) ** 2 for name in ("all", "delta"))
    return Reference((outputs["all_mean"] - outputs["delta_mean"]) @ LUMINANCE, variance / frames)


def independent_runs(renderer, runs, frames, before_frame=None):
    """Luminance of the given frames (counted from 1) of each run: {k: (runs, H, W)}.

    `before_frame`(renderer, k) may move the camera or nodes.
    """
    samples = {k: [] for k in frames}
    for _ in range(runs):
        for k in range(1, max(frames) + 1):
            renderer.set("direct.temporal", k > 1)
            if before_frame:
                before_frame(renderer, k)
            renderer.render(1)
            if k in samples:
                samples[k].append(renderer.output("radiance").astype(float) @ LUMINANCE)
    return {k: np.array(images) for k, images in samples.items()}


def block_means(images):
    """Means over blocks of BLOCK x BLOCK pixels of (..., H, W)."""
    height, width = images.shape[-2:]
    return images.reshape(*images.shape[:-2], height // BLOCK, BLOCK, width // BLOCK, BLOCK).mean((-3, -1))


def student_quantile(probability, freedom):
    """Quantile of Student's t: the first term of its expansion about the normal's (Cornish and Fisher)."""
    z = NormalDist().inv_cdf(probability)
    return z + (z ** 3 + z) / (4 * freedom)


@dataclass
class Verdict:
    """Outcome of a z-test."""

    worst: float  # largest |z|, over the largest that chance explains: above 1 the null hypothesis falls
    mean: float  # |z| of the image mean
    bias: float  # of the image mean, relative
    detectable: float  # smallest relative bias of the image mean that a z of 3 would show

    def __str__(self):
        return (f"worst block {self.worst:.2f} of the limit, image z {self.mean:.2f}, "
                f"bias {self.bias:+.3%}, detectable {self.detectable:.3%}")


def compare(samples, reference, tests=1):
    """z-test of samples (runs, H, W) against the reference; so many `tests` share the false-alarm rate."""
    runs = len(samples)
    differences = block_means(samples - reference.mean)
    error = np.sqrt(differences.var(0, ddof=1) / runs + block_means(reference.variance) / BLOCK ** 2)
    seen = error > 0
    limit = student_quantile(1 - FALSE_ALARMS / 2 / tests / seen.sum(), runs - 1)
    worst = np.abs(differences.mean(0)[seen] / error[seen]).max() / limit
    assert np.all(differences.mean(0)[~seen] == 0)
    means = samples.mean((1, 2))
    expected = reference.mean.mean()
    error = np.sqrt(means.var(ddof=1) / runs + reference.variance.mean() / reference.variance.size)
    bias = means.mean() - expected
    return Verdict(worst, abs(bias) / error, bias / expected, 3 * error / expected)
