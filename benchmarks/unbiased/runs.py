"""Rendering of what is recorded: runs of a method, and batches of its reference, seen as at a frame."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from samples import Samples

import restirpg
from restirpg.colour import luminance
from restirpg.harness import render, scenes
from restirpg.harness.jobs import Job, Method, digest
from restirpg.harness.motion import Motion
from restirpg.harness.render import ROOT
from restirpg.harness.unbiased import Reference, run_seed

REFERENCE = Method("reference", str(ROOT / "graphs" / "path_tracer.py"), (("gbuffer.jitter", False),))


@dataclass(frozen=True)
class Case:
    """One method on one scene: all that the runs depend on."""

    method: Method
    scene: str  # file
    size: tuple = (48, 48)  # width, height
    bounces: int | None = None  # None: the scene's, or the graph's own
    frames: tuple = (1, 2, 8, 32)  # counted from 1, ascending: each one's image is a sample
    motion: Motion = Motion()

    def job(self):
        """The case as the harness's Job, whose seed and frames count for nothing."""
        description = render.describe_graph(self.method.graph)
        job = Job(
            scene=str(self.scene),
            scene_hash="",
            graph=self.method.graph,
            description=json.dumps(description, sort_keys=True),
            size=self.size,
            frames=0,
            seed=0,
            code=code_of(description),
            knobs=self.method.knobs,
            output=self.method.output,
            device=self.method.device,
            backend=self.method.backend,
        )
        facts = scenes.facts_of(*render.load_scene(job))
        return replace(job, scene_hash=facts.hash, bounces=facts.bounces(self.bounces))


def code_of(description):
    """Hash of the shaders and of the kernels of the graph's own passes: a change of other passes leaves samples valid.
    Host code is not in it, whose library names its commit."""
    _, shaders, *passes = map(Path, restirpg.code_paths())
    own = {f"restirpg-pass-{entry['type']}" for entry in description["passes"]}
    folders = [shaders]
    folders += [kernels for library, kernels in zip(passes[::2], passes[1::2], strict=True) if library.stem in own]
    files = [file for folder in folders for file in sorted(folder.rglob("*")) if file.suffix in render.CODE]
    return digest(b"".join(digest(file.read_bytes()).encode() for file in files))


def device_of(renderer):
    """What pixels may depend on besides the code: the device that renders, its driver and the back end."""
    return {name: renderer.device_info[name] for name in ("name", "driver", "backend")}


class MethodRuns:
    """Runs of a method: of each, the frames named in the case, and how many samples were NaN or infinite."""

    def __init__(self, case, folder):
        self.case = case
        job = case.job()
        self._port = render.frame_port(json.loads(job.description), case.method.output)
        self._pixels = case.size[0] * case.size[1]
        self.renderer = render.make_renderer(job)
        identity = {
            "job": job.key,
            "device": device_of(self.renderer),
            "method": case.method.label,
            "scene": case.scene.stem,
            "frames": case.frames,
            "circle": case.motion.circle,
            "fps": case.motion.fps,
            "knobs": self.renderer.knobs(),
        }
        self.samples = Samples(folder, identity, [len(case.frames) * self._pixels + 1])
        self._home = self.renderer.camera

    def add(self):
        """Render one more run."""
        case, renderer = self.case, self.renderer
        renderer.seed = run_seed(len(self.samples))
        renderer.cut()
        images = []
        for k in range(1, max(case.frames) + 1):
            case.motion.apply(renderer, self._home, k)
            renderer.render(1)
            if k in case.frames:
                images.append(luminance(renderer.output(self._port)[..., :3]))
        images = np.array(images)
        invalid = render.dropped_samples(renderer) + np.sum(~np.isfinite(images))
        self.samples.append(np.append(images, invalid))

    def load(self, runs):
        """The first `runs` runs: {k: float (runs, H, W)}, and how many samples were NaN or infinite."""
        data = self.samples.load()[:runs].astype(float)
        width, height = self.case.size
        images = data[:, :-1].reshape(len(data), len(self.case.frames), height, width)
        return dict(zip(self.case.frames, images.swapaxes(0, 1))), int(data[:, -1].sum())


class ReferenceBatches:
    """The path tracer at pixel centres, with the bounce cap and the view of one frame of the case."""

    def __init__(self, case, bounces, frame, batch_frames, folder):
        self._frames = batch_frames
        width, height = case.size
        plain = replace(REFERENCE, device=case.method.device, backend=case.method.backend)
        job = replace(case, method=plain, bounces=bounces).job()
        self.renderer = render.make_renderer(job)
        pose = case.motion.pose(frame)
        identity = {
            "job": job.key,
            "device": device_of(self.renderer),
            "method": "reference",
            "scene": case.scene.stem,
            "frames": batch_frames,
            "circle": case.motion.circle if pose[0] else 0.0,
            "pose": pose,
        }
        self.samples = Samples(folder, identity, [height, width])
        case.motion.apply(self.renderer, self.renderer.camera, frame)

    def add(self):
        """Render one more batch."""
        self.renderer.seed = run_seed(len(self.samples), "reference")
        self.renderer.cut()
        self.renderer.render(self._frames)
        self.samples.append(luminance(self.renderer.output("image")))

    def load(self, batches):
        """Mean of the first batches, with the variance of its error."""
        data = self.samples.load()[:batches].astype(float)
        return Reference(data.mean(0), data.var(0, ddof=1) / len(data))
