#!/usr/bin/python3
"""Error over wall time, ours against Mitsuba 3's `path`: whole processes, start, loading and compiling included.

    error_over_time.py SCENE.glb --size 160x90 --bounces 4 --mitsuba-python VENV/bin/python --csv FILE
                       [--methods mitsuba path_tracer restir_pg] [--samples 4 16 64 256] [--seeds 2]
                       [--references FOLDER] [--reference-samples 2048]
    error_over_time.py --csv FILE        # the tables alone

Each run is a process of its own and one row of the CSV file, to which further calls append; the methods take turns.
`mitsuba` is its `path` by `llvm_ad_rgb`, the others are graphs of this repository, with pixels sampled by a box filter
as Mitsuba's. All have emitter sampling, multiple importance sampling, no roulette and the same cap (Mitsuba's max_depth
is two more). Ours have the file's materials, Mitsuba those that the converter makes of them. They are not quite the
same, so that each renderer is measured against a reference of its own, by Mitsuba and by path_tracer, whose seed no run
has. The first run of each method is not counted: it fills the caches of kernels. References are kept, named by the
scene's content, size, cap, samples and our code's hash; with another Mitsuba or converter, give another folder. Runs that
the CSV file has already are not made again: with other references, give another CSV file.
"""

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import clone
import numpy as np
import requirements
from finished_rows import append_row, read_rows
from gltf_edits import environment_of, read_glb

import restirpg
from restirpg.colour import luminance, mape_scale
from restirpg.harness import UserError, files, program
from restirpg.harness.render import code_version, find_package, refusals
from restirpg.harness.statistics import mean_se

COLUMNS = ("scene", "method", "size", "bounces", "samples", "seed", "seconds", "mape")
MITSUBA, PATH_TRACER = "mitsuba", "path_tracer"
REFERENCE_SEED = 1000


def render(method, scene, samples, seed, out, options):
    """One picture by a process of its own; returns its wall time, s."""
    if method == MITSUBA:
        command = [options.mitsuba_python, options.converter, scene, out, "--spp", samples]
        command += ["--depth", options.bounces + 2, "--res", options.size, "--seed", seed]
    else:
        command = [
            clone.program(),
            "render",
            clone.ROOT / "graphs" / f"{method}.py",
            "--scene",
            scene,
            "--size",
            options.size,
        ]
        command += ["--bounces", options.bounces, "--frames", samples, "--seed", seed, "-o", out]
        command += ["--output", "image", "--set", "gbuffer.jitter=true"]
    start = time.monotonic()
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, env={**os.environ, "PYTHONPATH": ""})
    seconds = time.monotonic() - start
    if done.returncode != 0:
        sys.stderr.write(done.stderr)
        raise UserError(f"{scene}: {method} failed on it, as it says above")
    return seconds


def mape_of(image, reference):
    """MAPE of luminance."""
    truth = luminance(reference)
    return float((np.abs(luminance(image) - truth) / mape_scale(truth)).mean())


def read_image(file):
    """(H, W, 3) of an EXR file of either renderer."""
    return restirpg.read_exr(file)[..., :3].astype(float)


def check(options):
    """Raise UserError where something is missing, before anything long starts."""
    for scene in options.scenes:
        if environment_of(read_glb(scene)[0]):
            raise UserError(
                f"{scene}: it has an environment, which the converter would have to be given; give another scene"
            )
    if options.scenes:
        requirements.check(options)
        files.make_folder(options.references, "--references")


def measure(scene, options):
    """Append the rows of one scene."""
    with tempfile.TemporaryDirectory(dir=options.references, prefix="unfinished-") as folder:
        measure_in(Path(folder), scene, options)


def references_of(scene, folder, options):
    """{method: its reference}, rendered where there is none yet."""
    references = {}
    for method in (MITSUBA, PATH_TRACER):
        code = "" if method == MITSUBA else f"_{code_version()[:16]}"
        content = hashlib.sha256(scene.read_bytes()).hexdigest()[:8]
        name = f"{scene.stem}_{content}_{options.size}_cap{options.bounces}_{options.reference_samples}_{method}{code}"
        file = options.references / f"{name}.exr"
        if not file.is_file():
            unfinished = folder / file.name
            render(method, scene, options.reference_samples, REFERENCE_SEED, unfinished, options)
            unfinished.replace(file)
        references[method] = read_image(file)
    return references


def measure_in(folder, scene, options):
    """The same, with what is being written in a folder of this process's own."""
    references = references_of(scene, folder, options)
    finished = {tuple(row[name] for name in COLUMNS[:6]) for row in read_rows(options.csv)}
    runs = [
        (scene.stem, method, options.size, options.bounces, samples, seed)
        for seed in range(1, options.seeds + 1)
        for samples in options.samples
        for method in options.methods
    ]
    runs = [run for run in runs if tuple(map(str, run)) not in finished]
    for method in dict.fromkeys(run[1] for run in runs):
        render(method, scene, 2, 0, folder / "warm.exr", options)
    for run in runs:
        _, method, *_, samples, seed = run
        file = folder / "run.exr"
        seconds = render(method, scene, samples, seed, file, options)
        mape = mape_of(read_image(file), references[MITSUBA if method == MITSUBA else PATH_TRACER])
        append_row(options.csv, COLUMNS, (*run, f"{seconds:.3f}", f"{mape:.5f}"))


def shown(runs):
    """Wall time and MAPE of a method's rows, with standard errors over seeds where there are several."""
    parts = []
    for name, scale, unit in (("seconds", 1, ""), ("mape", 100, "%")):
        mean, error = mean_se([scale * float(row[name]) for row in runs])
        parts.append(f"{mean:.1f}{'' if np.isnan(error) else f' ± {error:.1f}'}{unit}")
    return ", ".join(parts)


def print_tables(path):
    """A table per scene, size and cap: rows are numbers of samples; wall time and MAPE of each method, over seeds."""
    cases = {}
    for row in read_rows(path):
        cases.setdefault((row["scene"], row["size"], row["bounces"]), []).append(row)
    for (scene, size, bounces), rows in cases.items():
        methods = list(dict.fromkeys(row["method"] for row in rows))
        titles = " | ".join(f"{method}: s, MAPE" for method in methods)
        print(f"\n| {scene}, {size}, cap {bounces}: samples | {titles} |")
        print("| --- " * (1 + len(methods)) + "|")
        for samples in sorted({int(row["samples"]) for row in rows}):
            runs = [[row for row in rows if (row["method"], int(row["samples"])) == (m, samples)] for m in methods]
            print(f"| {samples} | {' | '.join(shown(some) if some else '' for some in runs)} |")


def parse_arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", type=Path)
    requirements.add_options(parser)
    parser.add_argument("--csv", type=Path, required=True)
    parser.add_argument("--methods", nargs="+", default=[MITSUBA, PATH_TRACER, "restir_pg"])
    parser.add_argument("--size", default="160x90")
    parser.add_argument("--bounces", type=program.bounces, default=4)
    parser.add_argument("--samples", type=program.positive, nargs="+", default=[4, 16, 64, 256])
    parser.add_argument("--seeds", type=program.positive, default=2)
    parser.add_argument("--references", type=Path, default=clone.ROOT / "out" / "mitsuba_references")
    parser.add_argument("--reference-samples", type=program.positive, default=2048)
    options = parser.parse_args()
    if options.scenes and not options.mitsuba_python:
        parser.error("--mitsuba-python is needed to render")
    return options


def main():
    """Measure, then print what is in the CSV file. Returns the exit code."""
    options = parse_arguments()

    def body(_):
        find_package()
        check(options)
        with refusals():
            for scene in options.scenes:
                measure(scene, options)
        print_tables(options.csv)
        return 0

    return program.run("error_over_time.py", body)


if __name__ == "__main__":
    sys.exit(main())
