"""Figures 1, 5, 6 and 8: pictures of the methods side by side, with crops and errors."""

import numpy as np

from restirpg.colour import relative_error
from restirpg.harness import pictures
from restirpg.harness import statistics as st
from restirpg.harness.paper import errors
from restirpg.harness.paper.page import Picture, Section, percent
from restirpg.harness.paper.paper import METHODS, SHOWN, Study, method, name_of

CANDIDATES = (
    method("candidates_unguided", "candidates, unguided"),
    method("candidates_guided", "candidates, guided"),
    method("candidates_guided_plus", "candidates, guided by ReSTIR PG+"),
)
METRIC = (
    "Pictures are single frames, the last of the first seed's run, as the paper's are; errors are MAPE (the "
    "paper's footnote 4) of single frames, averaged over the second half of each run, ± one standard error "
    "over seeds. Crops are where the methods' mean errors differ most."
)


def settled(runs):
    """{label: MAPE of settled single frames by seed}."""
    return errors.by_seed(runs, "frame")


def columns(runs, methods, measured=settled):
    """[pictures.Picture]: the reference and each method's last frame, and the crops where they differ most.

    measured(runs): the errors, by label and seed, that stand underneath.
    """
    truth = runs.reference["mean"].astype(float)
    values = measured(runs)
    known = [one for one in methods if one.label in runs.runs]
    frames = [np.nan_to_num([run["frame"] for run in runs.runs[one.label]]) for one in known]
    maps = [relative_error(each, truth).mean(axis=0) for each in frames]
    shown = [pictures.Picture("reference", truth, "MAPE")]
    shown += [
        pictures.Picture(one.label, runs.runs[one.label][0]["frame"], str(percent(*st.mean_se(values[one.label]))))
        for one in known
    ]
    return shown, pictures.crops_of(maps)


def row_of(runs, methods, measured=settled):
    """A scene's row for pictures.rows."""
    shown, crops = columns(runs, methods, measured)
    return name_of(runs.scene), pictures.exposure_of(runs.reference["mean"]), crops, shown


def section(paper, study, number, title, text, shown):
    """A figure of rows with its table."""
    name = f"figure_{number}"
    results = paper.compare(study, name)
    if not results.runs:
        return Section(f"Figure {number}: {title}", "Nothing was finished: see what failed.")
    drawing = pictures.rows([row_of(runs, shown) for runs in results.runs])
    return Section(
        f"Figure {number}: {title}",
        f"{text} {METRIC}",
        [Picture(name, f"Figure {number}: {title}.", drawing)],
        [errors.table(name, f"Figure {number}: errors", results, shown)],
        results.findings,
    )


def study_5(paper):
    """Four methods on all scenes."""
    return Study(METHODS, paper.scenes())


def figure_5(paper):
    """Four methods, all scenes."""
    text = "ReSTIR DI and ReSTIR PT are on for all methods; what differs is how the initial paths are guided."
    return section(paper, study_5(paper), 5, "the four methods", text, SHOWN)


def figure_1(paper):
    """The teaser: crops of the four methods in the first scene. Runs are figure 5's."""
    results = paper.compare(study_5(paper))
    if not results.runs:
        return Section("Figure 1: teaser", "Nothing was finished: see what failed.")
    runs = results.runs[0]
    shown, crops = columns(runs, SHOWN)
    exposure = pictures.exposure_of(runs.reference["mean"])
    truth = pictures.Picture(shown[0].title, shown[0].image, "")
    drawing = pictures.teaser(name_of(runs.scene), exposure, crops, shown[-1], [*shown[1:], truth])
    text = f"Crops of the four methods in {name_of(runs.scene)}. {METRIC}"
    return Section("Figure 1: teaser", text, [Picture("figure_1", "Figure 1: crops of the four methods.", drawing)])


def study_6(paper):
    """Candidates without and with guiding."""
    return Study(CANDIDATES, paper.scenes())


def figure_6(paper):
    """The initial candidates alone, unguided against guided."""
    text = (
        "The initial candidates are shown without resampling; where they are guided, the guide learns from "
        "what resampling selects. This is what a guide acts upon."
    )
    return section(paper, study_6(paper), 6, "candidates alone", text, CANDIDATES)


def study_8(paper):
    """Four methods in the glossy room."""
    return Study(METHODS, paper.scenes("door_ajar_glossy"))


def figure_8(paper):
    """Four methods, every surface polished."""
    text = "Every surface is polished: the product of BSDF and light has narrow lobes."
    return section(paper, study_8(paper), 8, "glossy surfaces", text, SHOWN)
