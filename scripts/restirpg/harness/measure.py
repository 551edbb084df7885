"""One run of a job: frame after frame, timed, measured against the reference."""

import json
import time

import numpy as np

import restirpg
from restirpg.colour import luminance
from restirpg.harness import tiles
from restirpg.harness.render import Renderers, dropped_samples, frame_port

ERRORS = ("mape", "relmse", "rmse", "bias", "invalid")
LARGEST_HALF = 65504


def run(job, load=lambda key: None, tick=lambda frames: None, renderers=None):
    """Render the job, and measure its errors where it names references.

    load: gives the reference of a key, a result with `mean`. tick: called with 0 before the renderer is made, which
    may have to compile kernels first, and with 1 after each frame. renderers: where the job's renderer may be
    found, and stays.
    Returns arrays, one entry for each of job.frames_measured(): `frames`, `mape`, `relmse`, `rmse`, `bias`,
    `invalid`, `frame_mape` (of that frame alone), `gpu_ms` and `wall_ms` (both summed since the start); `image`
    and `frame` (float32, H x W x 3: the output after the last frame, and what the last frame alone gave to it;
    with job.at the latter is what is measured, and both); `temporal`, see TemporalSums; and `meta`. With job.tiles
    no errors, but `pictures`, the measured frames as stacks of tiles, whose errors measure_tiles() finds, and
    `whole`, the last of them in half floats.
    """
    if job.windows:
        return _run_windows(job, tick, renderers or Renderers())
    tick(0)
    renderer, home = (renderers or Renderers()).begin(job)
    port = frame_port(json.loads(job.description), job.output)
    errors, stacks = _Errors(load), []
    for frame, wall in _measured(renderer, home, job, tick):
        alone = _picture(renderer, port, job)
        image = alone if job.at else _picture(renderer, job.output, job)
        if job.tiles or job.reference_of(frame):
            errors.times.append([sum(renderer.total_gpu_times().values()), wall])
            if job.tiles:
                stacks.append(tiles.stack(alone, job.tiles, job.tile))
            else:
                errors.add(job.reference_of(frame), frame, image, alone)
    whole = {}
    if job.tiles:
        whole = {"whole": np.clip(alone, 0, LARGEST_HALF).astype(np.float16), "pictures": np.array(stacks)}
        image = alone = stacks[-1]
    return {
        "frames": np.array(job.frames_measured()),
        **errors.columns(),
        **whole,
        "image": image,
        "frame": alone,
        "temporal": errors.temporal.sums,
        "meta": {
            "passes": {name: ms / frame for name, ms in renderer.total_gpu_times().items()},
            "memory": dict(renderer.memory()),
            **_meta(renderer, image, wall, dropped_samples(renderer)),
        },
    }


def _measured(renderer, home, job, tick):
    """Render the run's frames; yields (frame, wall-clock ms of all so far) after each that is measured."""
    measured, wall = job.frames_measured(), 0.0
    for frame in range(1, measured[-1] + 1):
        if job.motion:
            job.motion.apply(renderer, home, job.still or frame)
        start = time.perf_counter()
        renderer.render(1)
        wall += 1e3 * (time.perf_counter() - start)
        tick(1)
        if frame in measured:
            yield frame, wall


def _run_windows(job, tick, renderers):
    """As run(), of the job's tiles alone, one after the other: their stack."""
    tick(0)
    renderer, home = renderers.begin(job)
    parts, dropped, start = [], 0, time.perf_counter()
    for corner in job.tiles:
        renderer.move_window(*corner)
        if job.motion:
            job.motion.apply(renderer, home, job.still or 1)
        renderer.render(job.frames)
        parts.append(_picture(renderer, job.output, job))
        dropped += dropped_samples(renderer)
        tick(job.frames / len(job.tiles))
    image = np.concatenate(parts)
    return {"image": image, "meta": _meta(renderer, image, 1e3 * (time.perf_counter() - start), dropped)}


def _meta(renderer, image, wall, dropped):
    """What both kinds of runs say of themselves."""
    return {
        "device": dict(renderer.device_info),
        "knobs": renderer.knobs(),
        "wall_ms": wall,
        "invalid": int(np.sum(~np.isfinite(image).all(axis=-1))),
        "dropped": dropped,
    }


def measure_tiles(result, truths, side):
    """Give a result with `pictures` its errors against those stacks, a frame each: as run() has them, and
    `tile_mape`, `tile_relmse` and `tile_bias` (tiles, frames).
    """
    found = _Errors(dict(enumerate({"mean": truth} for truth in truths)).get)
    for number, (frame, picture) in enumerate(zip(result["frames"], result["pictures"])):
        found.add(number, frame, picture, picture)
    columns = {name: values for name, values in found.columns().items() if not name.endswith("_ms")}
    by_tile = [tiles.errors(picture, truth, side) for picture, truth in zip(result["pictures"], truths)]
    by_tile = {f"tile_{name}": np.array([each[name] for each in by_tile]).T for name in tiles.METRICS}
    result.update(columns, **by_tile, temporal=found.temporal.sums)


def _picture(renderer, output, job):
    """An output's colours after the last frame, float32, with the gain of the job."""
    return np.asarray(renderer.output(output), np.float32)[..., :3] * np.float32(job.gain)


class _Errors:
    """Rows of errors and times, one a measured frame."""

    def __init__(self, load):
        self._load, self._key, self._truth = load, None, None
        self._rows, self._frame = [], 0
        self.times, self.temporal = [], TemporalSums()

    def add(self, key, frame, image, alone):
        """Measure a picture against the reference of that key."""
        if key != self._key:
            self._key, self._truth = key, self._load(key)["mean"]
        found = restirpg.measure_errors(image, self._truth)
        single = restirpg.measure_errors(alone, self._truth)["mape"]
        self._rows.append([*(found[name] for name in ERRORS), single])
        self.temporal.add(alone, self._truth, consecutive=frame == self._frame + 1)
        self._frame = frame

    def columns(self):
        """Arrays by name."""
        rows = np.array(self._rows, float).reshape(-1, len(ERRORS) + 1).T
        times = np.array(self.times, float).reshape(-1, 2).T
        return dict(zip((*ERRORS, "frame_mape", "gpu_ms", "wall_ms"), (*rows, *times)))


class TemporalSums:
    """Sums for the autocorrelation at lag 1 of a pixel's single frames, as deviations from the reference.

    `sums` = [sum of e_t e_(t+1), its number of terms, sum of e_t^2, its number of terms], over pixels,
    luminance.
    """

    def __init__(self):
        self._previous = None
        self.sums = np.zeros(4)

    def add(self, frame, reference, consecutive):
        """Add a frame; `consecutive`: it follows the one added last."""
        deviation = luminance(frame - reference)
        deviation[~np.isfinite(deviation)] = 0
        if consecutive and self._previous is not None:
            self.sums[:2] += np.sum(deviation * self._previous), deviation.size
        self.sums[2:] += np.sum(deviation**2), deviation.size
        self._previous = deviation
