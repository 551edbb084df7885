#!/usr/bin/python3
"""Image means of scenes with their own materials, ours against Mitsuba's, seed by seed; the table behind
results/mitsuba.

    image_means.py SCENE.glb ... --mitsuba-python VENV/bin/python --csv FILE [--only ours|mitsuba|literal] [--seeds 1-8]
                   [--frames 256] [--samples 256] [--size 64x36] [--bounces 4]
    image_means.py --csv FILE            # the table alone

Mitsuba's materials are the renderer's model, written again as a plug-in (gltf_bsdf.py). Each seed is one independent
run of one renderer and one row of the CSV file, to which further calls append what it lacks. The ratio's standard error comes from
the spread of the runs: it needs several seeds on both sides. `literal` is Mitsuba with the diffuse lobe of glTF's
sample implementation, from which the renderer deviates (head of bsdf_model.glsl).
"""

import argparse
import functools
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import requirements
from compare_with_mitsuba import check_scenes, prepare, render_mitsuba, render_ours
from finished_rows import append_row, read_rows
from gltf_edits import environment_of, read_glb

from restirpg.harness import UserError, program, report
from restirpg.harness.jobs import digest
from restirpg.harness.render import find_package, refusals

#: What tells runs apart; a file from before the last four were noted has none of them. `content`: a hash of the scene
#: and its environment.
KEY = (
    "scene",
    "renderer",
    "seed",
    "width",
    "height",
    "bounces",
    "samples",
    "environment",
    "backend",
    "commit",
    "content",
)
#: A table has one row for each of these at most: others would count the same random numbers twice.
RUN = ("renderer", "width", "height", "seed")
COLUMNS = (*KEY, "r", "g", "b", "seconds")
HEADER = (
    "| scene | cap | runs and paths, ours | Mitsuba | image mean, ours | Mitsuba | ours / Mitsuba "
    "| ours / literal glTF |\n" + "| --- " * 8 + "|"
)


@functools.cache
def content_of(path, environment):
    """A hash of a scene and of the image around it."""
    image = environment or environment_of(read_glb(path)[0])
    file = (Path(environment) if environment else path.parent / image) if isinstance(image, str) else None
    return digest(path.read_bytes() + (file.read_bytes() if file and file.is_file() else b""))[:16]


commit = functools.cache(report.commit)


def key_of(path, renderer, seed, options):
    """The columns KEY of a run, "" where there is nothing to be said. Mitsuba has no back ends."""
    ours = renderer == "ours"
    samples, backend = (options.frames, options.backend) if ours else (options.samples, None)
    return (
        path.stem,
        renderer,
        seed,
        *options.size,
        options.bounces,
        samples,
        options.environment or "",
        backend or "",
        commit(),
        content_of(path, options.environment),
    )


def is_finished(path, renderer, seed, options):
    """Is this run in the CSV file already?"""
    run = tuple(map(str, key_of(path, renderer, seed, options)))
    return run in {tuple(row.get(name, "") for name in KEY) for row in read_rows(options.csv)}


def run_seed(path, renderer, seed, options):
    """Render one run of a scene and append its mean."""
    options.seed = seed
    with tempfile.TemporaryDirectory(prefix="mitsuba-") as temporary:
        folder = Path(temporary)
        scene_file, environment = prepare(path, folder, options)
        start = time.monotonic()
        if renderer == "ours":
            runs = render_ours(scene_file, environment, options)
        else:
            options.materials = "literal" if renderer == "literal" else "gltf"
            runs = render_mitsuba(scene_file, environment, folder, options)
    mean = runs[0].mean(axis=(0, 1), dtype=float)
    row = (
        *key_of(path, renderer, seed, options),
        *(f"{value:.7g}" for value in mean),
        f"{time.monotonic() - start:.1f}",
    )
    append_row(options.csv, COLUMNS, row)
    print(path.stem, renderer, seed, mean.mean(), flush=True)


def mean_and_error(rows):
    """Mean over runs of the image mean (of the three channels), weighted by their paths, and its standard error."""
    values = np.array([[float(row[channel]) for channel in "rgb"] for row in rows]).mean(axis=1)
    weights = np.array([float(row["samples"]) * float(row["width"]) * float(row["height"]) for row in rows])
    mean = np.average(values, weights=weights)
    variance_of_one = np.sum(weights * (values - mean) ** 2) / (len(values) - 1)  # of one path
    return mean, np.sqrt(variance_of_one / weights.sum())


def ratio(rows, others):
    """Ratio of two image means with its standard error; None and None where there are too few runs."""
    if min(len(rows), len(others)) < 2:
        return None, None
    (a, a_error), (b, b_error) = mean_and_error(rows), mean_and_error(others)
    return a / b, a / b * np.hypot(a_error / a, b_error / b)


def paths(rows):
    """Runs, and the paths that they have together."""
    count = sum(int(row["samples"]) * int(row["width"]) * int(row["height"]) for row in rows)
    return f"{len(rows)}, {count / 1e6:.2g} M"


def check_runs(rows, file):
    """Raise UserError where two rows of what is compared are the same run under other settings."""
    found = {}
    for row in rows:
        other = found.setdefault(tuple(row[name] for name in RUN), row)
        if other is not row:
            changed = [
                f"{name} {other.get(name) or 'none'} and {row.get(name) or 'none'}"
                for name in KEY
                if (other.get(name) or "") != (row.get(name) or "")
            ]
            raise UserError(
                f"{file}: {row['scene']}: two rows are of {row['renderer']}, {row['width']}x{row['height']}, seed "
                f"{row['seed']}: {', '.join(changed) or 'and alike'}; remove one of them, or give another file in --csv"
            )


def print_table(rows, file):
    """One row a scene, environment and cap with two runs of each renderer or more, of whatever size. Raises UserError."""
    print(HEADER)

    def shown(row):
        return ", ".join(filter(None, [row["scene"], row.get("environment")])), row["bounces"]

    for scene, bounces in dict.fromkeys(map(shown, rows)):
        chosen = [row for row in rows if shown(row) == (scene, bounces)]
        check_runs(chosen, file)
        ours, theirs = ([row for row in chosen if row["renderer"] == name] for name in ("ours", "mitsuba"))
        if min(len(ours), len(theirs)) < 2:
            continue
        literal = [row for row in chosen if row["renderer"] == "literal"]
        counts = [paths(side) for side in (ours, theirs)]
        means = [f"{value:.5f} +- {error:.5f}" for value, error in map(mean_and_error, (ours, theirs))]
        ratios = [
            f"{value:.4f} +- {error:.4f}" for value, error in (ratio(ours, theirs), ratio(ours, literal)) if value
        ]
        print("|", " | ".join([scene, bounces, *counts, *means, *ratios, *[""] * (2 - len(ratios))]), "|")


def seeds(text):
    """A range such as 1-8, or one number."""
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def parse_arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", type=Path)
    parser.add_argument("--csv", type=Path, required=True)
    requirements.add_options(parser)
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba; LLVM's needs DRJIT_LIBLLVM_PATH")
    parser.add_argument("--only", choices=("ours", "mitsuba", "literal"))
    parser.add_argument("--environment", help="r,g,b or an .exr or .hdr file; default: what the scene names")
    parser.add_argument("--backend", help="software or rayquery")
    parser.add_argument("--seeds", type=seeds, default=range(1, 9))
    parser.add_argument("--frames", type=program.positive, default=256, help="samples a pixel of a run of ours")
    parser.add_argument("--samples", type=program.positive, default=256, help="of Mitsuba's")
    parser.add_argument("--size", type=program.size, default=(64, 36))
    parser.add_argument("--bounces", type=program.bounces, default=4)
    options = parser.parse_args()
    options.runs = options.mitsuba_runs = 1
    options.materials = "gltf"
    if options.scenes and options.only != "ours" and not options.mitsuba_python:
        parser.error("--mitsuba-python is missing")
    return options


def measure(options):
    """Render what is asked for, then print the table of all runs in the file. Returns the exit code."""
    check_scenes(options)
    if options.scenes and options.only != "ours":
        requirements.check(options)
    for path in options.scenes:
        for renderer in (options.only,) if options.only else ("ours", "mitsuba"):
            for seed in options.seeds:
                if not is_finished(path, renderer, seed, options):
                    run_seed(path, renderer, seed, options)
    print_table(read_rows(options.csv), options.csv)
    return 0


def main():
    """The command line. Returns the exit code."""
    options = parse_arguments()

    def body(_):
        find_package()
        with refusals():
            return measure(options)

    return program.run("image_means.py", body)


if __name__ == "__main__":
    sys.exit(main())
