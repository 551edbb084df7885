#!/usr/bin/python3
"""What a frame of each method costs, on one idle machine.

    benchmarks/frame_costs.py GRAPH[@SETTING=VALUE,...]... --scene FILE [--size 160x90] [--warm 6] [--frames 5] [--turns 3]

In a round all methods get renderers of their own, and then render settled frames in turn, so that what else the machine
does meets all of them. The next round makes the renderers anew, in another order: of equal renderers the first made was
13% slower than the last of six, in every frame. In --turns times as many rounds as there are methods, each method is made
equally often at each place. Printed is the device's time of a frame, its mean ± one standard error over rounds, the ratio
to the first method of the same round, and each pass. --csv FILE has a row for each round, method and pass.
"""

import argparse
import csv
import io
import sys

import clone  # noqa: F401

import restirpg
from restirpg.harness import files, jobs, program, render, statistics


def parse(arguments):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add(
        "graphs", nargs="+", metavar="GRAPH", help="graph files, with settings as for scripts/compare.py, but no output"
    )
    add("--scene", required=True, help="a .glb or .gltf file")
    add("--size", type=program.size, default=(160, 90), metavar="WxH", help="pixels (160x90)")
    add("--bounces", type=program.bounces, metavar="N", help="bounce cap (the scene's, or the graphs' own)")
    add("--warm", type=program.positive, default=6, metavar="N", help="frames of each before those that count (6)")
    add("--frames", type=program.positive, default=5, metavar="N", help="frames of each that count, in a round (5)")
    add("--turns", type=program.whole(2), default=3, metavar="N", help="rounds for each method, two or more (3)")
    add("--csv", metavar="FILE", help="where the times are written")
    return parser.parse_args(arguments)


def settled(method, scene, options):
    """A renderer of the method with its history."""
    renderer = restirpg.Renderer(
        scene,
        restirpg.load_graph(method.graph),
        size=options.size,
        seed=1,
        bounces=options.bounces,
        device=method.device,
        backend=method.backend,
    )
    render.apply_knobs(renderer, method.knobs, method.graph)
    renderer.render(options.warm)
    return renderer


def one_round(methods, first, scene, options):
    """Milliseconds of each pass in a settled frame, for each method. `first`: the one whose renderer is made first."""
    order = [*range(first, len(methods)), *range(first)]
    renderers = {at: settled(methods[at], scene, options) for at in order}
    before = {at: dict(renderer.total_gpu_times()) for at, renderer in renderers.items()}
    for _ in range(options.frames):
        for renderer in renderers.values():
            renderer.render(1)
    return [
        {
            name: (after - before[at].get(name, 0.0)) / options.frames
            for name, after in renderers[at].total_gpu_times().items()
        }
        for at in range(len(methods))
    ]


def told(label, rounds, baseline):
    """A method's row of what is printed. rounds: {pass: milliseconds} of each round."""
    sums = [sum(passes.values()) for passes in rounds]
    mean, error = statistics.mean_se(sums)
    ratio, spread = statistics.ratio(sums, baseline)
    parts = ", ".join(f"{name} {statistics.mean_se([one[name] for one in rounds])[0]:.1f}" for name in rounds[0])
    return f"{label:24} {mean:8.1f} ± {error:5.1f} ms   x{ratio:.3f} ± {spread:.3f}   {parts}"


def measure(options):
    """Measure and print. Returns the exit code."""
    methods = jobs.parse_methods(options.graphs, useless=("output",))
    if options.csv:
        files.prepare(options.csv, [options.scene, *(method.graph for method in methods)], "--csv")
    scene = restirpg.load_scene(options.scene)
    firsts = [*range(len(methods))] * options.turns
    times = list(zip(*(one_round(methods, first, scene, options) for first in firsts)))  # times[method][round]
    baseline = [sum(passes.values()) for passes in times[0]]
    for method, rounds in zip(methods, times):
        print(told(method.label, rounds, baseline))
    if options.csv:
        rows = [
            (method.label, number, name, f"{value:.4g}")
            for method, rounds in zip(methods, times)
            for number, passes in enumerate(rounds)
            for name, value in passes.items()
        ]
        stream = io.StringIO(newline="")
        csv.writer(stream, lineterminator="\n").writerows([("method", "round", "pass", "gpu_ms"), *rows])
        files.write(options.csv, stream.getvalue())
    return 0


def main(arguments):
    """The command line. Returns the exit code."""
    options = parse(arguments)
    render.find_package()
    with render.refusals():
        return measure(options)


if __name__ == "__main__":
    sys.exit(program.run("frame_costs.py", lambda _: main(sys.argv[1:])))
