#!/usr/bin/python3
"""Sweep a guide's knobs: errors of single frames with ReSTIR PT on, and of the candidates that it makes.

    benchmarks/guide_sweep.py out/scenes/door_ajar.glb graphs/restir_pt.py \\
        graphs/raw_pt_derevyannykh2022.py@guide.neighbours=4,guide.product=false

Each further argument is a graph of graphs/pipeline.py with settings as for scripts/compare.py, but no output. All are
rendered with the same seeds and compared with the path tracer, the pixel filter off. Columns, each with its standard
error over seeds, and its change against the first graph, paired by seed:
    frame       mean MAPE of single frames, from frame --skip + 1 on
    mean        MAPE of the mean of all frames
    candidates  MAPE of the mean of the candidates without any reuse, from frame --skip + 1 on
"""

import argparse
import sys

import numpy as np
from clone import ROOT

from restirpg.colour import luminance, mape_scale
from restirpg.harness import UserError, program, render
from restirpg.harness.guiding import passes_of
from restirpg.harness.jobs import parse_methods
from restirpg.harness.mean_knobs import differences, mean_of
from restirpg.harness.statistics import ratio

GRAPHS = ROOT / "graphs"

COLUMNS = ("frame", "mean", "candidates")
ALONE = "candidates_without_reuse"  # a pass
NO_REUSE = {"temporal": False, "rounds": 0}  # its knobs


def parse():
    """The command line."""
    layout = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=layout)
    parser.add_argument("scene")
    parser.add_argument("graphs", nargs="+", metavar="GRAPH[@SETTING=VALUE,...]")
    parser.add_argument("--size", type=program.size, default=(96, 54), help="pixels (96x54)")
    parser.add_argument("--bounces", type=program.bounces, help="bounce cap (the scene's, or the graphs' own)")
    for name, number, least in (("frames", 24, 1), ("skip", 8, 0), ("seeds", 4, 2), ("reference-frames", 3000, 1)):
        parser.add_argument(f"--{name}", type=program.whole(least), default=number, help="(%(default)s)")
    return parser.parse_args()


def make_renderer(arguments, scene, graph, **options):
    """A renderer of one graph at the sweep's bounce cap."""
    import restirpg

    return restirpg.Renderer(scene, graph, size=arguments.size, bounces=arguments.bounces, **options)


def make_reference(arguments, scene, cap):
    """The path tracer's picture at a bounce cap, float32 (H, W, 3), through pixel centres."""
    import restirpg

    renderer = make_renderer(arguments, scene, restirpg.load_graph(GRAPHS / "path_tracer.py"))
    renderer.set("gbuffer.jitter", False)
    renderer.set("paths.bounces", cap)
    renderer.seed = 987654
    renderer.cut()
    renderer.render(arguments.reference_frames)
    image = renderer.output("image")
    deviation = np.sqrt(renderer.output("variance") / arguments.reference_frames)
    # The mean absolute value of a normal variable is 0.8 standard deviations.
    noise = (0.8 * deviation / mape_scale(luminance(image))[..., None]).mean()
    print(f"reference: its own noise has a MAPE of about {noise:.3f}", flush=True)
    return image


def make_graph(file):
    """A graph's description that shows the parts of each frame."""
    graph = render.describe_graph(file)
    types = ("GBuffer", "ReSTIRDI", "PathTracerGuided", "Accumulate")
    gbuffer, direct, paths, accumulate = passes_of(graph, *types)
    [indirect] = [own["inputs"]["indirect"] for own in graph["passes"] if own["name"] == accumulate]
    inputs = {"surface": {"pass": gbuffer, "output": "surface"}, "candidates": {"pass": paths, "output": "candidates"}}
    graph["passes"].append({"name": ALONE, "type": "ReSTIRReuse", "inputs": inputs, "knobs": dict(NO_REUSE)})
    shown = {
        "direct": (direct, "radiance"),
        "emission": (gbuffer, "emission"),
        "indirect": (indirect["pass"], indirect["output"]),  # another ReSTIRReuse may teach the guide
        "candidates": (ALONE, "radiance"),
    }
    graph["outputs"] += [{"name": name, "pass": owner, "output": output} for name, (owner, output) in shown.items()]
    return graph


def make_method(arguments, scene, method):
    """A renderer of a jobs.Method that shows the parts of each frame."""
    graph = make_graph(method.graph)
    renderer = make_renderer(arguments, scene, graph, device=method.device, backend=method.backend)
    render.apply_knobs(renderer, method.knobs, method.graph)
    for knob, value in NO_REUSE.items():  # `rounds=2` sets that of every pass
        renderer.set(f"{ALONE}.{knob}", value)
    return renderer


def bounce_cap(arguments, scene, methods):
    """Of the reference: the sweep's, the scene's, or the largest of the methods'. Each method is made once, so that a mistake
    in the last of them is told before the reference is rendered."""
    means = {}
    for method in methods:
        with make_method(arguments, scene, method) as renderer:
            means[method.label] = mean_of(renderer.knobs())
    asked = scene.bounce_cap if arguments.bounces is None else arguments.bounces
    cap = max(own["bounces"] for own in means.values()) if asked is None else asked
    for label, own in means.items():
        for words in differences(own, {"bounces": cap}, "the reference").values():
            print(f"{label}: {words}: the difference counts as error", file=sys.stderr)
    return cap


def errors_of_run(arguments, renderer, seed, reference):
    """The COLUMNS of one run."""
    import restirpg

    def mape(image):
        return restirpg.measure_errors(np.asarray(image, np.float32), reference)["mape"]

    renderer.seed = seed
    renderer.cut()
    frames, total, candidates = [], 0, 0
    for k in range(arguments.frames):
        renderer.render(1)
        rest = renderer.output("direct") + renderer.output("emission")
        image = rest + renderer.output("indirect")
        total = total + image
        if k >= arguments.skip:
            frames.append(mape(image))
            candidates = candidates + rest + renderer.output("candidates")
    return np.mean(frames), mape(total / arguments.frames), mape(candidates / len(frames))


def describe(errors, first):
    """Mean and standard error of each of the COLUMNS of (seeds, COLUMNS), and its change in percent from
    `first`, which is alike."""
    root = np.sqrt(len(errors))
    for name, error, before in zip(COLUMNS, errors.T, first.T):
        quotient, se = ratio(error, before)
        yield (
            f"{name} {error.mean():.4f} +- {error.std(ddof=1) / root:.4f} "
            f"({100 * (quotient - 1):+.1f} +- {100 * se:.1f}%)"
        )


def sweep(arguments):
    """Print one line a graph."""
    import restirpg

    methods = parse_methods(arguments.graphs, useless=("output",))
    scene = restirpg.load_scene(arguments.scene)
    reference = make_reference(arguments, scene, bounce_cap(arguments, scene, methods))
    first = None
    for method in methods:
        renderer = make_method(arguments, scene, method)
        errors = np.array(
            [errors_of_run(arguments, renderer, 7919 * (i + 1), reference) for i in range(arguments.seeds)]
        )
        first = errors if first is None else first
        print(f"{method.label}: {', '.join(describe(errors, first))}", flush=True)


def main():
    """The command line. Returns the exit code."""
    arguments = parse()

    def body(_):
        render.find_package()
        if arguments.skip >= arguments.frames:
            raise UserError(f"--skip {arguments.skip} leaves none of --frames {arguments.frames}")
        with render.refusals():
            sweep(arguments)
        return 0

    return program.run("guide_sweep.py", body)


if __name__ == "__main__":
    sys.exit(main())
