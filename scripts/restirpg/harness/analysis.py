"""From runs to findings: the numbers that the tables, the plots and the report show."""

import importlib.util
from dataclasses import dataclass, field

import numpy as np

from restirpg.colour import luminance
from restirpg.harness import denoised, tiles
from restirpg.harness import reference as references
from restirpg.harness import statistics as st
from restirpg.harness.equal_cost import EqualCost

METRICS = ("mape", "relmse")
SETTLED = 0.5  # of the measured frames, the last ones, count as single frames: reuse and guide have settled


@dataclass
class MethodFindings:
    """One method on one scene. Curves are (seeds, measured frames), or (tiles, measured frames) of means over seeds."""

    label: str
    frames: np.ndarray
    curves: dict  # metric -> curve; relmse without the reference's own noise; "single": MAPE of that frame alone
    gpu_ms: np.ndarray  # summed since the start, as curves
    wall_ms: np.ndarray
    frame_ms: np.ndarray  # GPU time of a frame by seed, of tiles too: the mean over all frames
    frame_wall_ms: np.ndarray
    flip: np.ndarray | None  # of the last frame alone, by seed; None: of tiles, or flip_evaluator is not installed
    single: (
        np.ndarray
    )  # MAPE of settled single frames by seed, with `at` of all those frames; of tiles of them by tile;
    # NaN where none is known
    equal_frame: dict  # metric -> (mean, standard error) after the last frame
    equal_time: dict  # metric -> (mean, standard error) at SceneFindings.common_ms; NaN: the first frame takes longer
    bias: st.Test  # relative to the reference's mean
    block_p: np.ndarray  # p-value of each 8x8 block's bias
    spatial_image: tuple  # block correlation of the final picture: ratio, standard error
    spatial_frame: tuple  # of single frames
    temporal: tuple  # autocorrelation at lag 1: mean, standard error
    passes: dict  # pass -> ms per frame, mean over seeds
    memory: dict  # resource -> bytes
    against: (
        dict  # (metric, "frame", "time", "single" or a frame of `at`), ("denoised", "frame" or "image") -> paired
        # Test against the baseline, which has none
    )
    images: dict  # "image" (first seed), "mean" (of all seeds), "frame" (first seed's last frame alone); of tiles their
    # stacks, and "whole", the first seed's last frame
    denoised: dict = field(default_factory=dict)  # as denoised.of_runs(); empty: not asked for
    adjusted: dict = field(default_factory=dict)  # as `against`, and "bias", "blocks" -> corrected p-value
    biased_blocks: int = 0  # after the same correction as "blocks"


@dataclass
class SceneFindings:
    """One scene: its reference, the time all methods are compared at, and the methods, the baseline first."""

    scene: str
    reference: dict
    noise: dict
    common_ms: float
    methods: list
    descriptions: dict
    warnings: list
    seeds: int  # how many independent samples: seeds, or tiles
    bias_tests: int = 1  # in the family that the smallest detectable bias is corrected for
    at: tuple = ()  # frames whose own pictures were measured, no times compared; (): the mean of all frames was
    unit: str = "seed"  # of the samples that tests are paired by: "seed" or "tile"
    reference_se: dict = field(default_factory=dict)  # of tiles, by label: standard error that the reference's noise
    # gives MAPE, and its ratio to the first method's
    equal_cost: EqualCost | None = None  # at equal frame time: as SceneRuns has it
    origin: dict = field(default_factory=dict)  # given_reference.origin()
    raised: dict = field(default_factory=dict)  # (method label, value of the knob) -> MethodFindings, not tested


def settled_frames(values):
    """Indices of what counts as settled single frames, of one value per measured frame: the last half."""
    return np.arange(len(values) - max(1, round(SETTLED * len(values))), len(values))


def single_frames(run, every=False):
    """Mean MAPE of a run's settled single frames, or of every measured one."""
    errors = run["frame_mape"]
    return float(np.mean(errors if every else errors[settled_frames(errors)]))


def flip(pictures, truth):
    """HDR-FLIP [Andersson et al. 2021] of each picture, 0 to 1, by NVIDIA's package; None where it is not installed."""
    if not importlib.util.find_spec("flip_evaluator"):
        return None
    import flip_evaluator

    clean = [
        np.maximum(np.nan_to_num(image, nan=0, posinf=0, neginf=0), 0).astype(np.float32)
        for image in (truth, *pictures)
    ]
    return np.array([flip_evaluator.evaluate(clean[0], image, "HDR", applyMagma=False)[1] for image in clean[1:]])


def analyse(scene_runs):
    """Findings of every scene.

    p-values are corrected (Holm) in three families, each over all scenes and methods: the comparisons with the
    baseline, those after denoising, and the tests of bias.
    """
    findings = [_scene(runs) for runs in scene_runs if runs.runs]
    methods = [method for scene in findings for method in scene.methods]
    for after in (False, True):
        _correct(
            [
                (method, kind, test.p)
                for method in methods
                for kind, test in method.against.items()
                if (kind[0] == "denoised") == after
            ]
        )
    tests = _correct_bias(methods)
    for scene in findings:
        scene.bias_tests = tests
    return findings


def _correct_bias(methods):
    """Set what is `adjusted` of bias, and `biased_blocks`; returns how many tests there are."""
    smallest = [_smallest_block_p(method) for method in methods]
    family = [(method, "bias", method.bias.p) for method in methods]
    family += [(method, "blocks", p) for method, p in zip(methods, smallest)]
    tests = _correct(family)
    for method, own in zip(methods, smallest):
        factor = sum(p >= own for _, _, p in family)  # by which Holm multiplies its smallest p
        if method.adjusted["blocks"] < st.LEVEL:
            method.biased_blocks = int(np.sum(method.block_p * method.block_p.size * factor < st.LEVEL))
    return tests


def _correct(family):
    """Set `adjusted` from a family of (method, kind, p-value); returns how many of them are tests."""
    p_values = [p for _, _, p in family]
    for (method, kind, _), adjusted in zip(family, st.holm(p_values)):
        method.adjusted[kind] = float(adjusted)
    return int(np.sum(~np.isnan(p_values)))


def _smallest_block_p(method):
    """Bonferroni over a method's own blocks."""
    return min(1.0, float(np.min(method.block_p)) * method.block_p.size) if method.block_p.size else np.nan


def _scene(runs):
    noise = references.noise(runs.reference)
    subtracted = noise["relmse"]  # from each measured relMSE
    if runs.at:
        noise["luminance_variance"] = np.mean([each["luminance_variance"] for each in runs.noise])
        subtracted = np.array([each["relmse"] for each in runs.noise])
    by_tile = any("tile_mape" in run for seeds in runs.runs.values() for run in seeds)
    times = {label: np.array([run["gpu_ms"] for run in seeds]) for label, seeds in runs.runs.items()}
    common = min(float(curve[:, -1].min()) for curve in times.values())
    if runs.at:
        common = float("nan")  # at one time, methods of different speed would show different things

    def found(label, seeds):
        return _method(label, seeds, runs.reference, noise, subtracted, common, bool(runs.at))

    methods = [found(label, seeds) for label, seeds in runs.runs.items()]
    for method in methods[1:]:
        method.against = {
            (metric, mode): st.paired(_values(method, metric, mode, common), _values(methods[0], metric, mode, common))
            for metric in METRICS
            for mode in ("frame", *(runs.at[:-1] if runs.at else ("time",)))
        }
        if by_tile or not runs.at:
            method.against["mape", "single"] = st.paired(method.single, methods[0].single)
    for method in methods:
        if runs.denoised:
            method.denoised = runs.denoised[method.label]
            method.images["denoised"] = method.denoised["picture"]
        if runs.denoised and method is not methods[0]:
            for kind in denoised.kinds(runs.at):
                test = st.paired(method.denoised[kind], methods[0].denoised[kind])
                method.against["denoised", kind] = test
    return SceneFindings(
        runs.scene,
        runs.reference,
        noise,
        common,
        methods,
        runs.descriptions,
        runs.warnings,
        len(methods[0].single),
        at=runs.at,
        unit="tile" if by_tile else "seed",
        reference_se=_reference_se(runs),
        equal_cost=runs.equal_cost,
        origin=runs.origin,
        raised={name: found(name[0], seeds) for name, seeds in runs.raised.items()},
    )


def _reference_se(runs):
    """{label: (standard error of MAPE, of its ratio to the first method's)} by the reference's noise."""
    if not runs.without:
        return {}
    mape = {label: found["mape"] for label, found in runs.without.items()}
    first = next(iter(mape.values()))
    return {label: (tiles.jackknife_se(own), tiles.jackknife_se(own / first)) for label, own in mape.items()}


def _values(method, metric, mode, common):
    """A metric by seed, after the last frame, at the common time, or of a frame of `at`."""
    curves = method.curves[metric]
    if mode == "frame":
        return curves[:, -1]
    if mode != "time":
        return curves[:, list(method.frames).index(mode)]
    return np.array([st.at_time(times, curve, common) for times, curve in zip(method.gpu_ms, curves)])


def _method(label, runs, truth, noise, subtracted, common, every):
    gather = {name: np.array([run[name] for run in runs]) for name in ("mape", "relmse", "bias", "gpu_ms", "wall_ms")}
    curves = {"mape": gather["mape"], "relmse": gather["relmse"] - subtracted, "bias": gather["bias"]}
    curves["single"] = np.array([run["frame_mape"] for run in runs])
    single = np.array([single_frames(run, every) for run in runs])
    if "tile_mape" in runs[0]:
        curves = {name: np.mean([run[f"tile_{name}"] for run in runs], axis=0) for name in ("mape", "relmse", "bias")}
        curves["single"] = curves["mape"]
        curves["relmse"] = curves["relmse"] - subtracted
        single = curves["mape"].mean(axis=1)
        for name in ("gpu_ms", "wall_ms"):
            gather[name] = np.broadcast_to(gather[name].mean(axis=0), curves["mape"].shape)
    pictures = np.array([np.nan_to_num(run["image"].astype(float), nan=0, posinf=0, neginf=0) for run in runs])
    frames = np.nan_to_num(luminance(np.array([run["frame"] for run in runs])), nan=0, posinf=0, neginf=0)
    brightness = luminance(pictures)
    temporal = [st.temporal_correlation(run["temporal"], noise["luminance_variance"]) for run in runs]
    scale = truth["batch_means"].mean()
    several = len(runs) > 1
    method = MethodFindings(
        label=label,
        frames=runs[0]["frames"],
        curves=curves,
        gpu_ms=gather["gpu_ms"],
        wall_ms=gather["wall_ms"],
        frame_ms=np.array([run["gpu_ms"][-1] / run["frames"][-1] for run in runs]),
        frame_wall_ms=np.array([run["wall_ms"][-1] / run["frames"][-1] for run in runs]),
        flip=None if "tile_mape" in runs[0] else flip([run["frame"] for run in runs], truth["mean"]),
        single=single,
        equal_frame={},
        equal_time={},
        bias=st.welch(pictures.mean(axis=(1, 2, 3)) / scale, truth["batch_means"] / scale),
        block_p=(
            st.block_bias_p_values(st.block_means(brightness), truth["batch_blocks"]) if several else np.array([])
        ),
        spatial_image=st.block_correlation(brightness),
        spatial_frame=st.block_correlation(frames),
        temporal=st.mean_se(temporal),
        passes={
            name: float(np.mean([run["meta"]["passes"][name] for run in runs])) for name in runs[0]["meta"]["passes"]
        },
        memory=runs[0]["meta"]["memory"],
        against={},
        images={
            "image": runs[0]["image"],
            "mean": pictures.mean(axis=0).astype(np.float32),
            "frame": runs[0]["frame"],
            **({"whole": runs[0]["whole"].astype(np.float32)} if "whole" in runs[0] else {}),
        },
    )
    for metric in METRICS:
        method.equal_frame[metric] = st.mean_se(_values(method, metric, "frame", common))
        method.equal_time[metric] = st.mean_se(_values(method, metric, "time", common))
    return method
