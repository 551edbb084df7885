"""Findings as CSV files, numbers in full."""

import csv
import io
import math
from pathlib import Path

from restirpg.harness import denoised, equal_cost, files
from restirpg.harness import statistics as st
from restirpg.harness.analysis import METRICS
from restirpg.harness.tables import error_of, test_of


def write_csv(findings, folder):
    """Write runs.csv and summary.csv into `folder`, and what else was asked for; scripts/README.md says what the columns
    are. Returns the names of the files.
    """
    wanted = {
        "summary.csv": (_write_summary, True),
        "runs.csv": (_write_runs, True),
        "frames.csv": (_write_frames, any(scene.at for scene in findings)),
        "tiles.csv": (_write_tiles, any(scene.unit == "tile" for scene in findings)),
        "equal_time.csv": (_write_equal_time, any(scene.equal_cost for scene in findings)),
        "equal_time_runs.csv": (_write_raised, any(scene.raised for scene in findings)),
        "denoised.csv": (_write_denoised, any(method.denoised for scene in findings for method in scene.methods)),
    }
    written = [name for name, (_, is_wanted) in wanted.items() if is_wanted]
    for name in written:
        wanted[name][0](findings, Path(folder) / name)
    return written


def _write_runs(findings, file):
    """Every seed, or tile, and measured frame."""
    flip = any(method.flip is not None for scene in findings for method in scene.methods)
    rows = [
        [scene.scene, method.label, *numbers]
        for scene in findings
        for method in scene.methods
        for numbers in _run_rows(scene, method, flip)
    ]
    _write(file, ["scene", "method", *_run_header(findings, flip)], rows)


def _write_raised(findings, file):
    """As runs.csv, of the settings between which equal_time.csv interpolates."""
    flip = any(method.flip is not None for scene in findings for method in scene.raised.values())
    rows = [
        [scene.scene, label, scene.equal_cost.brackets[label].knob, value, *numbers]
        for scene in findings
        for (label, value), method in scene.raised.items()
        if label in scene.equal_cost.brackets
        for numbers in _run_rows(scene, method, flip)
    ]
    _write(file, ["scene", "method", "knob", "value", *_run_header(findings, flip)], rows)


def _run_header(findings, flip):
    own = [findings[0].unit if findings else "seed", "frame", "mape", "mape_single", "relmse", "bias"]
    return [*own, *(["flip"] if flip else []), "gpu_ms_total", "wall_ms_total"]


def _run_rows(scene, method, flip):
    """The cells of _run_header() for every seed, or tile, and measured frame; FLIP is of the last frame alone."""
    last = len(method.frames) - 1
    for seed in range(scene.seeds):
        for at, frame in enumerate(method.frames):
            errors = [f"{method.curves[name][seed, at]:.9g}" for name in ("mape", "single", "relmse", "bias")]
            if flip:
                errors.append(f"{method.flip[seed]:.9g}" if at == last and method.flip is not None else "")
            times = [f"{each[seed, at]:.6g}" for each in (method.gpu_ms, method.wall_ms)]
            yield [seed, int(frame), *errors, *times]


def _write_summary(findings, file):
    """Every method, over all seeds."""
    flip = any(method.flip is not None for scene in findings for method in scene.methods)
    header, rows = ["scene", "method", "common_gpu_ms"], []
    for mode in ("frame", "time"):
        for metric in METRICS:
            header += [f"{metric}_{mode}", f"{metric}_{mode}_se", f"{metric}_{mode}_p"]
    header += [
        "mape_single",
        "mape_single_se",
        "mape_single_p",
        *(["flip", "flip_se"] if flip else []),
        "gpu_ms_per_frame",
        "gpu_ms_per_frame_se",
        "bias",
        "bias_se",
        "bias_p",
        "detectable_bias",
        "blocks_p",
        "spatial_frame",
        "spatial_frame_se",
        "spatial_image",
        "spatial_image_se",
        "temporal",
        "temporal_se",
    ]
    for scene in findings:
        for method in scene.methods:
            row = [scene.scene, method.label, f"{scene.common_ms:.6g}"]
            for mode, values in (("frame", method.equal_frame), ("time", method.equal_time)):
                for metric in METRICS:
                    row += [*values[metric], method.adjusted.get((metric, mode), float("nan"))]
            row += [*st.mean_se(method.single), method.adjusted.get(("mape", "single"), float("nan"))]
            if flip:
                row += st.mean_se(method.flip) if method.flip is not None else (math.nan, math.nan)
            row += st.mean_se(method.frame_ms)
            row += [
                method.bias.difference,
                method.bias.se,
                method.adjusted["bias"],
                method.bias.smallest_detectable(scene.bias_tests),
                method.adjusted["blocks"],
                *method.spatial_frame,
                *method.spatial_image,
                *method.temporal,
            ]
            rows.append([value if isinstance(value, str) else f"{float(value):.9g}" for value in row])
    _write(file, header, rows)


def _write_denoised(findings, file):
    """MAPE after denoising of every seed's last frame and, where that is another picture, of its mean of all frames."""
    kinds = denoised.kinds(findings[0].at)
    rows = [
        [scene.scene, method.label, seed, *(f"{method.denoised[kind][seed]:.9g}" for kind in kinds)]
        for scene in findings
        for method in scene.methods
        if method.denoised
        for seed in range(scene.seeds)
    ]
    _write(file, ["scene", "method", "seed", *(f"mape_denoised_{kind}" for kind in kinds)], rows)


def _write_equal_time(findings, file):
    """Single frames' MAPE at equal frame time, with what it is interpolated from: the ratios of frame times at the two
    settings, and their MAPE. `time_in_runs`: the frame time in the runs that were compared, as a share of the slowest
    method's. `p` is NaN where the times are not equal."""
    header = ["scene", "method", "setting", "ratio_below", "ratio_above", "mape_below", "mape_above"]
    header += ["time_in_runs", "time_in_runs_se", "mape", "mape_se", "change", "change_se", "p"]
    rows = []
    for scene in findings:
        for own in equal_cost.compare(scene) if scene.equal_cost else ():
            bracket = scene.equal_cost.brackets.get(own.label)
            ratios = bracket.ratios if bracket else (1, 1)
            ends = (
                [scene.raised[key].single for key in bracket.keys(own.label)] if bracket else [own.values, own.values]
            )
            numbers = [*ratios, *(end.mean() for end in ends), *own.time, *st.mean_se(own.values)]
            numbers += [own.ratio[0] - 1, own.ratio[1], own.p]
            rows.append([scene.scene, own.label, own.setting, *(f"{float(value):.9g}" for value in numbers)])
    _write(file, header, rows)


def _write_tiles(findings, file):
    """MAPE over all measured frames, and its change from the first method's, with both standard errors."""
    header = [
        "scene",
        "method",
        "tiles",
        "frames",
        "mape",
        "mape_se",
        "mape_reference_se",
        "change",
        "change_se",
        "change_reference_se",
        "p",
        "gpu_ms_per_frame",
        "wall_ms_per_frame",
    ]
    rows = []
    for scene in findings:
        for method in scene.methods:
            own, against = scene.reference_se.get(method.label, (math.nan, math.nan))
            quotient, se = st.ratio(method.single, scene.methods[0].single)
            numbers = [
                *st.mean_se(method.single),
                own,
                quotient - 1,
                se,
                against,
                method.adjusted.get(("mape", "single"), math.nan),
            ]
            times = [float(each.mean()) for each in (method.frame_ms, method.frame_wall_ms)]
            rows.append(
                [
                    scene.scene,
                    method.label,
                    scene.seeds,
                    len(scene.at),
                    *(f"{float(value):.9g}" for value in numbers + times),
                ]
            )
    _write(file, header, rows)


def _write_frames(findings, file):
    """Errors of single frames: mean and standard error over seeds, corrected p against the first method."""
    header = ["scene", "method", "frame"]
    header += [name for metric in METRICS for name in (metric, f"{metric}_se", f"{metric}_p")]
    rows = []
    for scene in findings:
        for method in scene.methods:
            for frame in scene.at:
                row = [scene.scene, method.label, frame]
                for metric in METRICS:
                    p = method.adjusted.get((metric, test_of(scene, frame)), float("nan"))
                    row += [f"{float(value):.9g}" for value in (*error_of(method, metric, frame), p)]
                rows.append([*row, *(f"{float(value):.9g}" for value in error_of(method, "bias", frame))])
    _write(file, [*header, "bias", "bias_se"], rows)


def _write(path, header, rows):
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    files.write(path, stream.getvalue())
