#!/usr/bin/python3
"""Record whether a method is unbiased: many independent runs against the path tracer, tested by block means.

    benchmarks/unbiased/record.py GRAPH[@SETTING=VALUE,...] --scene NAME|FILE [--size 48x48]
        [--frames 1,2,8,32] [--runs 400] [--circle 0.02] [--markdown FILE] [--json FILE]

Frame k of each run is one sample of every pixel; the reference is the path tracer with the same bounce cap
and pixel-centre jitter off, seen from where the camera stands at frame k. Null hypothesis: every block of
pixels has the reference's mean. Largest |z| against Student's t at 1%, Bonferroni over blocks and k; printed
with the ratio of the image means, the smallest biases that would have been found with a probability of 80%,
and Kolmogorov and Smirnov's p of the scores. Finished runs are kept in --out: the same command goes on where
it was interrupted, and --seconds spreads it (0: test what there is). Exit code: 0; 1 when a bias was found; 2
for a mistake in what was asked; 130 after Ctrl-C.
"""

import argparse
import sys
import time
from pathlib import Path

from clone import ROOT
from report import as_json, as_markdown, findings_of
from runs import Case, MethodRuns, ReferenceBatches

from restirpg.harness import UserError, files, program, render, scenes
from restirpg.harness.jobs import parse_method
from restirpg.harness.mean_knobs import mean_of
from restirpg.harness.motion import Motion
from restirpg.harness.unbiased import compare


def size(text):
    """`WxH` in pixels."""
    width, _, height = text.partition("x")
    edges = [int(edge) for edge in (width, height) if edge.isascii() and edge.isdigit() and len(edge) < 6]
    if len(edges) != 2 or any(edge < 4 or edge % 4 for edge in edges):
        raise argparse.ArgumentTypeError(f"'{text}' is not WIDTHxHEIGHT in multiples of 4, as in 48x48")
    return tuple(edges)


several = program.whole(2)


def parse(arguments):
    """The command line as a namespace."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    add = parser.add_argument
    add("method", metavar="GRAPH[@SETTING=VALUE,...]", help="as scripts/compare.py takes it")
    add("--scene", required=True, metavar="NAME|FILE", help="an embedded scene, or a .glb or .gltf file")
    add("--size", type=size, default=(48, 48), metavar="WxH", help="pixels, multiples of a block (48x48)")
    add(
        "--frames",
        type=program.frame_numbers,
        default=(1, 2, 8, 32),
        metavar="K,K,...",
        help="samples of a run (1,2,8,32)",
    )
    add("--runs", type=several, default=400, help="independent runs (%(default)s)")
    add(
        "--block",
        type=int,
        choices=(4, 8, 16),
        default=4,
        help="edge of a block, pixels: larger ones for scenes of rare bright samples (%(default)s)",
    )
    add("--bounces", type=program.bounces, help="bounce cap of method and reference (the scene's, or the graph's own)")
    program.add_motion(parser)
    add(
        "--reference-batches",
        type=several,
        default=64,
        metavar="N",
        help="independent parts of the reference (%(default)s)",
    )
    add("--batch-frames", type=several, default=256, metavar="N", help="samples a pixel of each part (%(default)s)")
    add("--seconds", type=float, default=float("inf"), help="test what there is after so long; the next call goes on")
    add("--out", type=Path, default=ROOT / "out" / "unbiased", help="folder of finished runs (out/unbiased)")
    add("--markdown", type=Path, help="file to append the table to")
    add("--json", type=Path, help="file to write the numbers to")
    return parser.parse_args(arguments)


def check_blocks(size, block):
    """Raise UserError where blocks would leave a part of the picture out."""
    if any(edge % block for edge in size):
        width, height = size
        raise UserError(f"--block {block}: {width}x{height} pixels are no whole blocks; choose multiples for --size")


def grow(what, source, count, deadline):
    """Render until there are `count` samples, or until the time is up, but never fewer than two."""
    at_first = len(source.samples)
    while len(source.samples) < count and (len(source.samples) < 2 or time.monotonic() < deadline):
        if len(source.samples) == at_first:
            source.samples.note_session()
        source.add()
        print(f"\r{what}: {len(source.samples)} of {count}", end="", file=sys.stderr, flush=True)
    print(f"\r{what}: {len(source.samples)} of {count}", file=sys.stderr)


def record(options):
    """Render what is missing, test, print and write. Returns the exit code."""
    deadline = time.monotonic() + options.seconds
    case = Case(
        parse_method(options.method),
        Path(scenes.file_of(options.scene, options.out / "scenes")),
        options.size,
        options.bounces,
        options.frames,
        Motion(options.circle, options.fps),
    )
    method = MethodRuns(case, options.out)
    bounces = mean_of(method.renderer.knobs()).get("bounces")
    references, samples = {}, []
    for k in case.frames:
        pose = case.motion.pose(k)
        if pose not in references:
            batches = ReferenceBatches(case, bounces, k, options.batch_frames, options.out)
            grow(f"reference of frame {k}", batches, options.reference_batches, deadline)
            references[pose] = batches.load(options.reference_batches)
            samples.append(min(len(batches.samples), options.reference_batches) * options.batch_frames)
    grow(case.method.label, method, options.runs, deadline)
    images, invalid = method.load(options.runs)
    verdicts = {
        k: compare(images[k], references[case.motion.pose(k)], len(case.frames), options.block) for k in case.frames
    }
    findings = findings_of(method, bounces, invalid, verdicts, min(samples), options.block)
    print(as_markdown(findings))
    if options.markdown:
        with open(options.markdown, "a") as file:
            file.write(as_markdown(findings))
    if options.json:
        files.write(options.json, as_json(findings))
    return 1 if findings["biased"] else 0


def main(arguments):
    """The command line. Returns the exit code."""
    options = parse(arguments)

    def body(_):
        render.find_package()
        check_blocks(options.size, options.block)
        for file, option in ((options.markdown, "--markdown"), (options.json, "--json")):
            if file:
                files.prepare(file, [options.scene, options.method.partition("@")[0]], option)
        with render.refusals():
            return record(options)

    return program.run("record.py", body)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
