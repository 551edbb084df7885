"""Reproduce the evaluation of ReSTIR PG [Zeng et al. 2025]: figures, tables, costs and ablations.

    scripts/reproduce.py WHAT... [--quick | --full] [--scenes NAME|FILE...] [--out out/reproduce]
    scripts/reproduce.py --paper-size FILE...       (the paper's comparison at 1920x1080; --paper-size --help)

WHAT is one or more of: figure 1, 2, 4, 5, 6, 7 or 8 (`figure 5 6`), `table 1`, `cost`, `ablation`, `motion`,
or `all`. Writes report.html, which needs no network, and beside it PNG, CSV and EXR files. Finished runs are
kept and shared by all figures: the same command again, after any interruption, goes on where it stopped.
Embedded scenes are named as by `scripts/make_scenes.py --list`; a FILE is any .glb or .gltf. Exit code: 0; 1
when a run failed (the others are reported); 2 for a mistake in what was asked; 130 after Ctrl-C, 143 after
SIGTERM.
"""

import argparse
import sys
import time
from dataclasses import replace

from restirpg import commands
from restirpg.harness import UserError, files, program, render
from restirpg.harness.paper import experiments, full_size, page, paper

PAPER_SIZE = "--paper-size"

OUTPUTS = [
    f"{folder}*.{kind}" for folder in ("", "*/", "*/*/") for kind in ("html", "png", "csv", "exr")
]  # below --out


def parse(arguments):
    """The command line as a namespace."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("what", nargs="*", metavar="WHAT", help="see above; --list explains each")
    add("--list", action="store_true", help="say what each shows, how many runs it needs, and about how long it takes")
    add("--scenes", nargs="+", metavar="NAME|FILE", help="scenes in place of the figures' own")
    program.add_allow_outside(parser)
    sizes = parser.add_mutually_exclusive_group()
    for size in (paper.QUICK, paper.FULL):
        sizes.add_argument(f"--{size.name}", dest="preset", action="store_const", const=size, help=describe(size))
    parser.set_defaults(preset=paper.DEFAULT)
    add(
        "--size",
        type=program.size,
        metavar="WxH",
        help=f"pixels ({describe(paper.DEFAULT)} without --quick, --full)",
    )
    for name, what in (("frames", "frames of a run"), ("seeds", "independent runs of each method")):
        add(f"--{name}", type=program.positive, metavar="N", help=what)
    add(
        "--reference-frames",
        type=program.positive,
        metavar="N",
        help="frames of each reference, over all its batches; of each frame of figure 7 and motion a quarter of them",
    )
    add("--reference-batches", type=program.positive, metavar="R", help="independent batches of each reference (16)")
    add("--reference-graph", metavar="GRAPH", help="the graph that renders the references (graphs/path_tracer.py)")
    add("--bounces", type=program.bounces, metavar="N", help="bounce cap (default: each scene's, or the graphs' own)")
    program.add_runner(parser, "out/reproduce")
    return commands.parsed(parser, arguments)


def describe(size):
    """A preset in a line."""
    return f"{size.size[0]}x{size.size[1]}, {len(size.scenes)} scenes, {size.seeds} seeds, {size.frames} frames"


def chosen(words):
    """The experiments that the words name, in the order of the report; raises UserError."""
    names, group = [], None
    for word, after in zip(words, [*words[1:], ""]):
        if word in ("figure", "table"):
            if not after.isdigit():
                raise UserError(f"say which {word}; there are: {', '.join(experiments.BY_NAME)}, all")
            group = word
            continue
        name = f"{group} {word}" if group and word.isdigit() else word
        group = group if word.isdigit() else None
        if name == "all":
            names += experiments.BY_NAME
        elif name in experiments.BY_NAME:
            names.append(name)
        else:
            raise UserError(f"there is no '{name}'; there are: {', '.join(experiments.BY_NAME)}, all")
    if not names:
        raise UserError("say what to reproduce, as in scripts/reproduce.py figure 5 --quick; --list says what there is")
    return [experiment for experiment in experiments.EXPERIMENTS if experiment.name in names]


def size_from(options):
    """The preset with what the command line changes."""
    names = ("size", "frames", "seeds", "reference_frames", "reference_batches", "reference_graph", "bounces")
    changes = {name: getattr(options, name) for name in names}
    return replace(options.preset, **{name: value for name, value in changes.items() if value is not None})


def print_list(evaluation):
    """What there is."""
    print(f"{'':10} {'jobs':>5} {'minutes':>7}   at {describe(evaluation.size)}")
    for name, several in [(one.name, [one]) for one in experiments.EXPERIMENTS] + [("all", experiments.EXPERIMENTS)]:
        jobs, minutes = experiments.jobs_and_minutes(evaluation, several)
        shows = several[0].shows if len(several) == 1 else "all of these; what figures share is run once"
        print(f"{name:10} {jobs:5} {minutes:7.0f}   {shows}")


def evaluation_of(options, cache, pool, display):
    """The Paper that the command line asks for."""
    return paper.Paper(size_from(options), options.out, cache, pool, display, options.scenes, options.allow_outside)


def reproduce(options, cache, pool, display):
    """Run the experiments and write the report. Returns the exit code."""
    started = time.monotonic()
    evaluation = evaluation_of(options, cache, pool, display)
    wanted = chosen(options.what)
    for scene in evaluation.chosen:
        evaluation.file(scene)  # a wrong name is told before anything long starts
    sections = []
    for experiment in wanted:
        display.message(f"{experiment.name}: {experiment.shows}")
        sections.append(experiment.run(evaluation))
    report = evaluation.out / "report.html"
    page.write(sections, evaluation, report, "scripts/reproduce.py")
    for failure in evaluation.failures:
        print(f"failed: {failure}", file=sys.stderr)
    print(
        f"{report}: the report, after {time.monotonic() - started:.0f} s; PNG and CSV files lie beside it, "
        "EXR files in a folder a figure"
    )
    return 1 if evaluation.failures else 0


def main(arguments):
    """The command line. Returns the exit code."""
    if PAPER_SIZE in arguments:
        return full_size.main([argument for argument in arguments if argument != PAPER_SIZE])
    options = parse(arguments)

    def body(display):
        render.find_package()
        if options.list:
            print_list(evaluation_of(options, None, None, display))
            return 0
        chosen(options.what)
        files.refuse_inputs_among([*(options.scenes or ()), options.reference_graph], options.out, OUTPUTS)
        files.make_folder(options.out, "--out")
        with program.runner(options, display) as (cache, pool):
            return reproduce(options, cache, pool, display)

    return program.run("reproduce.py", body)
