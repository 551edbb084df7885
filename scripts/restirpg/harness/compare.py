"""Compare light transport methods on equal terms: same scene, seeds, clock and reference. A warning tells
where methods differ in bounce cap or pixel filter.

    scripts/compare.py GRAPH[@SETTING=VALUE,...]... --scenes SCENE... [--size 160x90] [--frames 32] [--seeds
    8]
    scripts/compare.py GRAPH... --scenes SCENE... --at 1,8,9,10,12,16 [--fps 8] [--circle 0.02]

Each GRAPH is one method; the first is the baseline that the others are tested against. Settings are knobs
(`paths.nee=false`, or `bounces=2` on every pass that has it) and label, output, device, backend. Prints
tables and writes report.html, CSV and EXR files into the folder --out. Finished runs are kept: the same
command again, after any interruption, goes on where it stopped. Exit code: 0; 1 when a run failed (the others
are reported); 2 for a mistake in what was asked; 130 after Ctrl-C, 143 after SIGTERM.
"""

import argparse
import os
import sys
import time
from pathlib import Path

from restirpg import commands
from restirpg.harness import UserError, analysis, csv_files, files, printed, program, render, selftest
from restirpg.harness.comparison import PATH_TRACER, Comparison, Settings
from restirpg.harness.jobs import made_from, parse_method
from restirpg.harness.motion import Motion

OUTPUTS = ("report.html", "tables.txt", "*.csv", "images/*.exr", files.WRITTEN)  # below --out


def parse(arguments):
    """The command line as a namespace."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("methods", nargs="*", metavar="GRAPH[@SETTING=VALUE,...]", help="a method; the first is the baseline")
    add(
        "--scenes",
        nargs="+",
        metavar="FILE",
        default=["out/scenes/door_ajar.glb"],
        help=".glb or .gltf (%(default)s)",
    )
    add_options(parser)
    add(
        "--self-test",
        action="store_true",
        help="measure the harness: false alarms between equal methods, power to find a 1%% error of energy",
    )
    add("--trials", type=program.positive, default=60, help="of the self-test (%(default)s)")
    return commands.parsed(parser, arguments)


def add_options(parser, **own):
    """How methods are compared, wherever the methods and the scenes are from. own: defaults, where they are not this
    program's."""

    def told(name, default=""):
        """The option's default, for its help."""
        return f" ({own.get(name, default)})" if own.get(name, default) else ""

    _add_measured(parser, told, "" if "at" in own else "32, or ")
    program.add_motion(parser)
    _add_runs(parser)
    _add_scene_options(parser)
    _add_reference(parser, told)
    parser.add_argument(
        "--brief", action="store_true", help="print the verdict and one narrow table; tables.txt has them all"
    )
    program.add_runner(parser, "out/compare")
    parser.set_defaults(**own)


def _add_measured(parser, told, frames):
    """What is measured, and at what cost."""
    add = parser.add_argument
    add("--size", type=program.size, default="160x90", metavar="WxH", help="pixels (%(default)s)")
    add("--frames", type=program.positive, help=f"frames of a run ({frames}the last of --at)")
    add(
        "--at",
        type=program.frame_numbers,
        default=(),
        metavar="K,K,...",
        help="measure the pictures of these frames alone, each against a reference of its own time and camera, "
        f"in place of the mean of all frames{told('at')}",
    )
    add(
        "--tiles",
        type=program.positive,
        default=0,
        metavar="N",
        help="render the reference, and measure errors, in so many random tiles of the picture alone; with --at"
        + told("tiles"),
    )
    add(
        "--tile-size",
        type=program.positive,
        default=24,
        metavar="PIXELS",
        help="side of a tile; it divides both sides of --size (%(default)s)",
    )
    add(
        "--equal-frame-time",
        metavar="PASS.KNOB",
        help="for each faster method, raise this knob (a whole number, such as reuse.neighbours) until a frame takes as long "
        "as the slowest method's, and compare single frames there. The value found is kept like a run; another --cache "
        "measures times again",
    )
    add(
        "--denoise",
        action="store_true",
        help="also measure the error after denoising by Open Image Denoise (needs the package pyoidn)",
    )


def _add_runs(parser):
    add = parser.add_argument
    add("--seeds", type=program.positive, default=8, help="independent runs of each method (%(default)s)")
    add(
        "--base-seed",
        type=int,
        default=0,
        help="seed from which the seeds of all runs are derived (%(default)s)",
    )


def _add_scene_options(parser):
    """How a scene is loaded and seen."""
    add = parser.add_argument
    add(
        "--bounces",
        type=program.bounces,
        help="bounce cap of every pass and of the reference; 0: direct light alone (default: the scene's, or the graph's "
        "own)",
    )
    add("--environment", metavar="FILE|R,G,B", help="environment light in place of the scene's")
    program.add_allow_outside(parser)
    add("--camera", type=program.whole(0), default=0, help="number of the scene's camera (%(default)s)")
    add(
        "--energy-compensation",
        action="store_true",
        help="rough metal and glass give back the light that single-scattering GGX loses",
    )


def _add_reference(parser, told):
    """What errors are measured against."""
    add = parser.add_argument
    add("--reference", metavar="EXR", help="a picture to use as the reference, in place of a rendered one")
    add(
        "--reference-graph",
        default=PATH_TRACER,
        metavar="GRAPH",
        help="the graph that renders the reference (%(default)s)",
    )
    add(
        "--reference-frames",
        type=program.positive,
        metavar="N",
        help=f"frames of the reference, over all its batches{told('reference_frames', '32 times --frames')}",
    )
    add(
        "--reference-batches",
        type=program.positive,
        default=16,
        metavar="R",
        help="independent batches of the reference, from which its own standard error is estimated (%(default)s)",
    )


#: Options that the self-test reads; its pictures, runs and reference are its own.
OF_SELF_TEST = {
    "self_test", "trials", "methods", "scenes", "reference_graph", "bounces", "base_seed", "camera", "environment",
    "allow_outside", "scheduler", "out", "cache",
}  # fmt: skip


#: Options of how a reference is rendered.
OF_RENDERED_REFERENCE = {"reference_graph", "reference_frames", "reference_batches"}


def refuse_ignored(options, defaults):
    """Raise UserError where the command line has an option that would change nothing. defaults: its namespace where
    nothing is given."""
    given = {name for name, value in vars(defaults).items() if value != getattr(options, name)}
    if options.self_test:
        return _refuse_ignored_by_self_test(options, given)
    if "trials" in given:
        raise UserError("--trials are those of --self-test; leave it out, or add --self-test")
    if "tile_size" in given and not options.tiles:
        raise UserError("--tile-size is that of --tiles; leave it out, or add --tiles")
    if options.at and options.frames and options.frames > options.at[-1]:
        raise UserError(f"--at ends the runs after frame {options.at[-1]}, before --frames does; leave out --frames")
    if options.reference and given & OF_RENDERED_REFERENCE:
        raise UserError(
            f"--reference takes the place of a rendered one; leave out {_flags(given & OF_RENDERED_REFERENCE)}"
        )


def _flags(names):
    """Options as the command line has them."""
    return ", ".join(f"--{name.replace('_', '-')}" for name in sorted(names))


def _refuse_ignored_by_self_test(options, given):
    if given - OF_SELF_TEST:
        raise UserError(f"--self-test chooses its own {_flags(given - OF_SELF_TEST)}; leave out what it does not read")
    for kind in ("methods", "scenes"):
        if len(getattr(options, kind)) > 1:
            raise UserError(
                f"--self-test reads one of the {kind}, not {len(getattr(options, kind))}; leave out the others"
            )
    if options.methods and "reference_graph" in given:
        raise UserError("--self-test reads --reference-graph where no method is given; leave out one of them")


def settings_from(options):
    """The namespace as Settings; raises UserError."""
    methods = tuple(parse_method(text) for text in options.methods)
    if not methods:
        raise UserError("no graph given; name one or more, as in scripts/compare.py graphs/path_tracer.py")
    frames = options.frames or (options.at[-1] if options.at else 32)
    if options.at and options.at[-1] > frames:
        raise UserError(f"--at asks for frame {options.at[-1]}, and --frames ends the runs after {frames}")
    return made_from(
        Settings,
        options,
        methods=methods,
        scenes=tuple(options.scenes),
        frames=frames,
        reference_frames=options.reference_frames or 32 * frames,
        motion=Motion(options.circle, options.fps) if options.circle or options.fps else None,
    )


def compare(options, cache, pool, display, name):
    """Run the comparison, print the tables and write the files. name: of the program, for the report. Returns the exit
    code."""
    started = time.monotonic()
    settings = settings_from(options)
    out = Path(options.out)
    inputs = [settings.reference, settings.environment, settings.reference_graph, *settings.scenes]
    files.refuse_inputs_among([*inputs, *(method.graph for method in settings.methods)], out, OUTPUTS)
    comparison = Comparison(settings, cache, pool, display)
    comparison.prepare()
    from restirpg.harness import report  # here, since matplotlib takes a second: --help and mistakes need none of it

    for device in dict.fromkeys(
        f"{device['name']}, {device['driver']}, {device['backend']}" for device in comparison.device.values()
    ):
        print(f"device: {device}")
    findings = analysis.analyse(comparison.run())
    text = printed.as_text(findings)
    files.write(out / "tables.txt", text)
    beside = ["tables.txt", *csv_files.write_csv(findings, out)]
    pictures = [f"images/{name}" for name in report.write_pictures(findings, out / "images")]
    report.write(findings, settings, comparison, out / "report.html", name)
    files.remove_earlier(out, ["report.html", *beside, *pictures])
    print(printed.in_brief(findings) if options.brief else text)
    for failure in comparison.failures:
        print(f"failed: {failure}", file=sys.stderr)
    print(
        f"{out / 'report.html'}: the report, after {time.monotonic() - started:.0f} s; "
        f"{', '.join(beside)}{' and images/*.exr' if pictures else ''} lie beside it"
    )
    return 1 if comparison.failures else 0


def main(arguments):
    """The command line. Returns the exit code."""
    return run(parse(arguments))


def run(options, name="compare.py", defaults=None):
    """Do what a command line's namespace says, of the program of that name. defaults: its namespace where nothing is
    given. Returns the exit code."""

    def body(display):
        refuse_ignored(options, defaults or parse([]))
        render.find_package()
        files.make_folder(options.out, "--out")
        # Nothing is timed in the self-test, and most of a small run is one core's work.
        with program.runner(options, display, os.cpu_count() if options.self_test else None) as (cache, pool):
            if options.self_test:
                return selftest.run(options, cache, pool, display)
            return compare(options, cache, pool, display, f"scripts/{name}")

    return program.run(name, body)
