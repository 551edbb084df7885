"""What scripts/reproduce.py can make: each experiment's name, what it shows, and what it renders."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from harness.paper import ablation, comparisons, cost, figure_2, figure_4, motion, table_1

#: Microseconds a pixel and frame on two cores (lavapipe, benchmarks/results/restir_pt_cost.md), for --list
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
    calls: Callable = lambda paper: (0, 0)  # of a Paper: how many Calls, and how many frames in all


def _directions(paper):
    scenes, kinds = len(paper.scenes("door_ajar_diffuse")), len(figure_4.KINDS)
    return scenes * (kinds + 1), scenes * kinds * paper.size.seeds * paper.size.frames


def _cells(paper):
    scenes = len(paper.scenes())
    return scenes, 12 * scenes * paper.size.seeds


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
        "figure 6", "initial candidates alone, unguided against guided",
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
    Experiment("table 1", "samples a cell and frame, ReSTIR against raw", table_1.run, calls=_cells),
    Experiment(
        "cost", "time of passes, the guide's overhead, memory (figure 5's runs)",
        cost.run, lambda paper: (comparisons.study_5(paper),), _cells,
    ),
    Experiment(
        "motion", "swinging door, and a camera on a circle, as figure 7",
        motion.run, lambda paper: tuple(motion.studies_motion(paper).values()),
    ),
    Experiment(
        "ablation", "alpha, lobes, cell size, final edges, training data",
        ablation.run, lambda paper: tuple(ablation.study(paper, shown) for shown in ablation.SHOWN),
    ),
)  # fmt: skip
BY_NAME = {experiment.name: experiment for experiment in EXPERIMENTS}


def jobs_and_minutes(paper, experiments):
    """How many jobs the experiments are together, shared ones once, and about how many minutes on two
    cores."""
    size = paper.size
    pixels = size.size[0] * size.size[1]
    studies = dict.fromkeys(study for experiment in experiments for study in experiment.studies(paper))
    runs = {  # a method is what it renders, whatever a figure calls it
        (replace(method, label=""), scene, study.changes)
        for study in studies
        for method in study.methods
        for scene in study.scenes
    }
    references = {
        (scene, study.changes): (
            study.views,
            dict(study.changes).get("reference_frames", size.reference_frames),
        )
        for study in studies
        for scene in study.scenes
    }
    counts = dict.fromkeys((experiment.calls, experiment.calls(paper)) for experiment in experiments)
    calls, call_frames = (sum(values[at] for _, values in counts) for at in (0, 1))
    seconds = START_COST * (len(runs) + len(references) + calls)
    seconds += 1e-6 * pixels * REUSE_COST * (len(runs) * size.seeds * size.frames + call_frames)
    seconds += 1e-6 * pixels * PATH_COST * sum(views * frames for views, frames in references.values())
    jobs = (
        len(runs) * size.seeds
        + calls
        + size.reference_batches * sum(views for views, _ in references.values())
    )
    return jobs, seconds / 60
