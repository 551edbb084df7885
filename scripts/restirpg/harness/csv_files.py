"""Findings as CSV files, numbers in full."""

import csv
import io
import math
from pathlib import Path

from restirpg.harness import equal_time, files
from restirpg.harness import statistics as st
from restirpg.harness.analysis import METRICS
from restirpg.harness.tables import error_of, test_of


def write_csv(findings, folder):
    """Write runs.csv (every seed and measured frame) and summary.csv (every method) into `folder`.

    Where single frames are measured, frames.csv too: every method and frame. Where they are measured in tiles,
    tiles.csv too: every method, all frames together; `seed` counts tiles in runs.csv. Errors after denoising are in
    denoised.csv alone.
    """
    folder = Path(folder)
    if any(scene.at for scene in findings):
        _write_frames(findings, folder / "frames.csv")
    if any(method.denoised for scene in findings for method in scene.methods):
        _write_denoised(findings, folder / "denoised.csv")
    if any(scene.brackets for scene in findings):
        _write_equal_time(findings, folder / "equal_time.csv")
    if any(scene.unit == "tile" for scene in findings):
        _write_tiles(findings, folder / "tiles.csv")
    names = ("mape", "relmse", "bias")
    rows = [
        [
            scene.scene,
            method.label,
            seed,
            int(frame),
            *(f"{method.curves[name][seed, at]:.9g}" for name in names),
            f"{method.gpu_ms[seed, at]:.6g}",
            f"{method.wall_ms[seed, at]:.6g}",
        ]
        for scene in findings
        for method in scene.methods
        for seed in range(scene.seeds)
        for at, frame in enumerate(method.frames)
    ]
    _write(folder / "runs.csv", ["scene", "method", "seed", "frame", *names, "gpu_ms", "wall_ms"], rows)
    header, rows = ["scene", "method", "common_gpu_ms"], []
    for mode in ("frame", "time"):
        for metric in METRICS:
            header += [f"{metric}_{mode}", f"{metric}_{mode}_se", f"{metric}_{mode}_p"]
    header += [
        "mape_single",
        "mape_single_se",
        "mape_single_p",
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
    _write(folder / "summary.csv", header, rows)


def _write_denoised(findings, file):
    """MAPE after denoising of every seed's last frame and mean of all frames."""
    rows = [
        [scene.scene, method.label, seed, *(f"{method.denoised[kind][seed]:.9g}" for kind in ("frame", "image"))]
        for scene in findings
        for method in scene.methods
        if method.denoised
        for seed in range(scene.seeds)
    ]
    _write(file, ["scene", "method", "seed", "mape_denoised_frame", "mape_denoised_image"], rows)


def _write_equal_time(findings, file):
    """Single frames' MAPE at equal frame time, with the knob's value and the ratios of frame times that it lies
    between, and the frame time in the runs that were compared, as a share of the dearest
    method's."""
    header = ["scene", "method", "setting", "ratio_below", "ratio_above", "time_in_runs"]
    header += ["mape", "mape_se", "change", "change_se", "p"]
    rows = []
    for scene in findings:
        for own in equal_time.compare(scene.brackets, scene.methods):
            ratios = scene.brackets[own.label].ratios if own.label in scene.brackets else (1, 1)
            numbers = [*ratios, own.time, *st.mean_se(own.values), own.ratio[0] - 1, own.ratio[1], own.p]
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
        "gpu_ms",
        "wall_ms",
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
            times = [float(each[:, -1].mean() / method.frames[-1]) for each in (method.gpu_ms, method.wall_ms)]
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
    writer = csv.writer(stream)
    writer.writerow(header)
    writer.writerows(rows)
    files.write(path, stream.getvalue())
