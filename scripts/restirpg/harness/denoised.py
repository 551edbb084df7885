"""Errors after denoising: what Open Image Denoise leaves of a method's pictures. They stay apart from the pictures' own
errors.

`features` runs in workers.
"""

import numpy as np

import restirpg
from restirpg.harness.jobs import Call
from restirpg.harness.motion import Motion

GRAPH = {
    "name": "Features",
    "passes": [{"name": "gbuffer", "type": "GBuffer"}],
    "outputs": [{"name": name, "pass": "gbuffer", "output": name} for name in ("albedo", "normal")],
}


def features(scene, size, motion, frame):
    """`albedo` and `normal` (H, W, 3) of what is at the centre of each pixel in that frame."""
    renderer = restirpg.Renderer(scene, GRAPH, size=tuple(size))
    if motion:
        Motion(*motion).apply(renderer, renderer.camera, frame)
    renderer.render(1)
    return {**{name: np.array(renderer.output(name)) for name in ("albedo", "normal")}, "meta": {}}


def call(job):
    """The Call of the features that the last measured frame of a run of `job` shows."""
    motion = (job.motion.circle, job.motion.fps) if job.motion else None
    settings = {"size": tuple(job.size), "motion": motion, "frame": job.frames_measured()[-1] if motion else 0}
    return Call(
        features,
        job.scene,
        job.scene_hash,
        tuple(settings.items()),
        job.code,
        job.allow_outside,
        label=f"albedo and normals of {job.scene}",
        camera=job.camera,
        environment=job.environment,
    )


def kinds(at):
    """The pictures of a run that are denoised: the last "frame", and the "image", the mean of all, unless frames `at`
    are measured alone: then both are the same."""
    return ("frame",) if at else ("frame", "image")


def of_runs(runs, found, truth, at=()):
    """What denoising makes of a method's runs: MAPE by seed of each of kinds(at); "picture", the first seed's last
    frame. found: what `features` gave; truth: the reference (H, W, 3)."""
    errors = {kind: [] for kind in kinds(at)}
    first = None
    for run in runs:
        for kind, by_seed in errors.items():
            picture = restirpg.denoise(run[kind], found["albedo"], found["normal"])
            first = picture if first is None else first
            by_seed.append(restirpg.measure_errors(picture, truth)["mape"])
    return {**{kind: np.array(by_seed) for kind, by_seed in errors.items()}, "picture": first}
