"""What scripts/reproduce.py can make: each experiment's name, what it shows, and what it renders."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from restirpg.harness.comparison import PATH_TRACER
from restirpg.harness.paper import (
    ablation,
    comparisons,
    cost,
    figure_2,
    figure_4,
    motion,
    resolution,
    table_1,
)
from restirpg.harness.paper.paper import OURS

#: Microseconds per pixel and frame on two cores (lavapipe, benchmarks/results/restir_pt_cost), for --list
#: alone.
REUSE_COST, PATH_COST = 18.0, 4.5
#: Seconds to make a renderer, kernels included.
START_COST = 5.0


@dataclass(frozen=True)
class Experiment:
    """A part of the evaluation."""

    name: str
    shows: str
    run: Callable  # of a Paper; returns a page.Section
    studies: Callable = lambda paper: ()  # of a Paper; its Studies
    calls: Callable = lambda paper: {}  # of a Paper: {what tells a Call from others: its pixels in all}


def _directions(paper):
    size = paper.size
    pixels = math.prod(size.size) * size.seeds * size.frames
    kinds = {"truth": 0} | dict.fromkeys(figure_4.KINDS, pixels)
    return {
        ("directions", scene, kind): number
        for scene in paper.scenes("door_ajar_diffuse")
        for kind, number in kinds.items()
    }


def _cells(paper, scenes, sizes, methods=(OURS,)):
    return {
        ("cells", scene, size, method.label): 12 * paper.size.seeds * math.prod(size)
        for scene in scenes
        for size in sizes
        for method in methods
    }


def _cells_of_table_1(paper):
    return _cells(paper, paper.scenes(), [tuple(paper.size.size)], table_1.METHODS)


def _cells_of_all(paper):
    return _cells(paper, paper.scenes(), [tuple(paper.size.size)])


def _cells_by_size(paper):
    return _cells(paper, resolution.scenes_of(paper), resolution.sizes_of(paper))


EXPERIMENTS = (
    Experiment(
        "figure 1", "teaser: crops of the four methods in the first scene (figure 5's runs)",
        comparisons.figure_1, lambda paper: (comparisons.study_5(paper),),
    ),
    Experiment("figure 2", "flatland: path-traced against resampled samples; no renderer", figure_2.run),
    Experiment(
        "figure 4", "directions splatted in a cell against the true product, and KL",
        figure_4.run, calls=_directions,
    ),
    Experiment(
        "figure 5", "the four methods: pictures, crops, MAPE",
        comparisons.figure_5, lambda paper: (comparisons.study_5(paper),),
    ),
    Experiment(
        "figure 6", "initial candidates alone: unguided, guided by ReSTIR PG and by ReSTIR PG+",
        comparisons.figure_6, lambda paper: (comparisons.study_6(paper),),
    ),
    Experiment(
        "figure 7", "moving light, and one that jumps: error of frames against their own references",
        motion.figure_7, lambda paper: tuple(motion.studies_7(paper).values()),
    ),
    Experiment(
        "figure 8", "the four methods on glossy surfaces",
        comparisons.figure_8, lambda paper: (comparisons.study_8(paper),),
    ),
    Experiment(
        "table 1", "samples per cell and frame, ReSTIR (PG and PG+) against raw", table_1.run, calls=_cells_of_table_1,
    ),
    Experiment(
        "cost", "time of passes, the guide's overhead, memory (figure 5's runs)",
        cost.run, lambda paper: (comparisons.study_5(paper),), _cells_of_all,
    ),
    Experiment(
        "motion", "swinging door, and a camera on a circle, as figure 7",
        motion.run, lambda paper: tuple(motion.studies_motion(paper).values()),
    ),
    Experiment(
        "ablation", "alpha, lobes, cell size, final edges, training data",
        ablation.run, lambda paper: tuple(ablation.study(paper, shown) for shown in ablation.SHOWN),
    ),
    Experiment(
        "resolution", "error and samples per cell from small pictures to large ones",
        resolution.run, lambda paper: tuple(resolution.studies(paper).values()), _cells_by_size,
    ),
)  # fmt: skip
BY_NAME = {experiment.name: experiment for experiment in EXPERIMENTS}


def jobs_and_minutes(paper, experiments):
    """How many jobs the experiments are together, shared ones once, and about how many minutes on two
    cores."""
    size = paper.size
    studies = dict.fromkeys(study for experiment in experiments for study in experiment.studies(paper))
    runs = {  # a method is what it renders, whatever a figure calls it
        (replace(method, label=""), scene, study.changes)
        for study in studies
        for method in study.methods
        for scene in study.scenes
    }
    references = {(scene, study.changes): study.views for study in studies for scene in study.scenes}
    calls = {name: number for experiment in experiments for name, number in experiment.calls(paper).items()}

    def of(changes, name):
        return dict(changes).get(name, getattr(size, name))

    def pixels(changes):
        return math.prod(of(changes, "size"))

    seconds = START_COST * (len(runs) + len(references) + len(calls))
    reused = sum(pixels(changes) for _, _, changes in runs) * size.seeds * size.frames
    seconds += 1e-6 * REUSE_COST * (reused + sum(calls.values()))
    rate = PATH_COST if size.reference_graph == PATH_TRACER else REUSE_COST
    seconds += (
        1e-6
        * rate
        * sum(pixels(changes) * views * of(changes, "reference_frames") for (_, changes), views in references.items())
    )
    jobs = len(runs) * size.seeds + len(calls) + size.reference_batches * sum(references.values())
    return jobs, seconds / 60
