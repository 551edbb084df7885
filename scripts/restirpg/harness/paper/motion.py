"""Figure 7, and sequences with a moving camera or door: errors of single frames, each against its own
reference."""

import numpy as np

from restirpg.harness import pictures, plots
from restirpg.harness import statistics as st
from restirpg.harness.motion import TURN, Motion
from restirpg.harness.paper import errors
from restirpg.harness.paper.comparisons import row_of
from restirpg.harness.paper.page import Picture, Section, Table, estimate, percent
from restirpg.harness.paper.paper import METHODS, SHOWN, Study, name_of

from matplotlib.figure import Figure  # isort: skip

# A film's. At 8, a whole loop of the embedded scenes in 32 frames, what reuse over frames keeps of light
# that has gone decides everything: 190 to 525% for all methods alike (benchmarks/results/paper_quick).
FPS = 24.0
CUT_SECONDS = 2.0  # of a run of door_ajar_light_cut, whose lamp jumps after one
CIRCLE = 0.02  # m, radius of the circle that the camera goes round
RECOVERED = 1.1  # times the error of the run's last frame


def moving(paper, scenes):
    """Scenes that play; four frames and the first are measured, each against a reference of its own."""
    frames = paper.size.frames
    at = tuple(sorted({1, *(max(1, frames * k // 4) for k in range(1, 5))}))
    return _study(paper, scenes, Motion(fps=FPS), at, len(at))


def cut(paper, scenes):
    """A lamp that jumps in the middle of the run; measured is every frame from the last one before."""
    frames = paper.size.frames
    jump = frames // 2 + 1
    at = tuple(range(max(1, jump - 1), frames + 1))
    return _study(paper, scenes, Motion(fps=2 * (frames // 2) / CUT_SECONDS or 1.0), at, 2)


def circling(paper, scenes):
    """A camera on a small circle; measured are frames in which it stands where the scene's own does."""
    at = tuple(range(2, paper.size.frames + 1, TURN)) or (1,)
    return _study(paper, scenes, Motion(circle=CIRCLE), at, 1)


def _study(paper, scenes, motion, at, views):
    changes = (("motion", motion), ("at", at), ("reference_frames", paper.size.motion_reference_frames))
    return Study(METHODS, scenes, changes, views)


def studies_7(paper):
    """{what moves: study} of figure 7; the jump needs the scene that has one."""
    found = {"moving light": moving(paper, paper.scenes("door_ajar_box_light"))}
    if not paper.chosen:
        found["light that jumps"] = cut(paper, ("door_ajar_light_cut",))
    return found


def studies_motion(paper):
    """{what moves: study} of the other sequences."""
    return {
        "swinging door" if not paper.chosen else "animation": moving(paper, paper.scenes("door_ajar_animated")),
        "camera on a circle": circling(paper, paper.scenes(paper.size.scenes[0])),
    }


def by_frame(runs):
    """{label: MAPE (seeds, frames of `at`)}."""
    return {label: np.array([run["mape"] for run in seeds]) for label, seeds in runs.runs.items()}


def table(name, title, sequences):
    """Frames by rows: [(what moves, SceneRuns)]; words are against the first method, corrected over the
    table."""
    labels = [method.label for method in SHOWN]
    rows, groups = [], []
    for moves, runs in sequences:
        values = by_frame(runs)
        first = next(iter(values))
        for at, frame in enumerate(runs.at):
            row = [f"{name_of(runs.scene)}, {moves}", f"{frame}"]
            for label in labels:
                if label not in values:
                    row += ["failed"] + ([""] * 2 if label != first else [])
                    continue
                row.append(percent(*st.mean_se(values[label][:, at])))
                if label != first:
                    row += [errors.change(values[label][:, at], values[first][:, at]), None]
                    groups.append((values[label][:, at], values[first][:, at]))
            rows.append(row)
    header = ["sequence", "frame"]
    for label in labels:
        header += [label] + ([f"change, {label}", f"tested, {label}"] if label != METHODS[0].label else [])
    return Table(name, title, tuple(header), errors.filled(rows, groups))


def means_table(name, title, sequences):
    """The mean MAPE of each sequence's measured frames but the first: [(what moves, SceneRuns)].

    Frames of one run are not independent; runs are.
    """
    rows, groups = [], []
    for moves, runs in sequences:
        found, begin = by_frame(runs), min(1, len(runs.at) - 1)
        values = {one.label: found[one.label][:, begin:].mean(1) for one in SHOWN if one.label in found}
        cells, tested = errors.compared(values, METHODS[0].label, SHOWN[-1].label)
        groups += tested
        rows += [[f"{name_of(runs.scene)}, {moves}", label, *row] for label, row in cells.items()]
    header = ("sequence", "method", *errors.heads(SHOWN[-1].label, "mean of single frames"))
    return Table(name, title, header, errors.filled(rows, groups))


def frames_to_recover(values):
    """By seed: frames from the jump, the second that is measured, until the error first falls to RECOVERED
    times that of the last frame. values: (seeds, frames)."""
    return (values[:, 1:] <= RECOVERED * values[:, -1:]).argmax(1) + 1


def recovery_table(name, runs):
    """Frames after the jump that each method needs."""
    values = by_frame(runs)
    rows = [
        [label, estimate(frames_to_recover(values[label]))]
        + [percent(*st.mean_se(values[label][:, at])) for at in (0, 1, -1)]
        for label in (method.label for method in SHOWN if method.label in values)
    ]
    header = (
        "method",
        f"frames to {RECOVERED:g} times the last error",
        "MAPE before",
        "MAPE at the jump",
        "MAPE at the end",
    )
    return Table(name, "Recovery after the light has jumped", header, rows)


def curves(sequences):
    """A panel a sequence: MAPE over frames, bands of one standard error."""
    figure = Figure(figsize=(15.4, 3.8))
    axes = figure.subplots(1, max(2, len(sequences)), squeeze=False)[0]
    for axis, (moves, runs) in zip(axes, sequences):
        values = by_frame(runs)
        for number, label in enumerate(method.label for method in SHOWN if method.label in values):
            mean, se = (100 * part for part in st.mean_se(values[label]))
            colour = plots.COLOURS[number]
            axis.plot(runs.at, mean, marker="o", markersize=3, color=colour, label=label)
            axis.fill_between(runs.at, mean - se, mean + se, color=colour, alpha=0.2, linewidth=0)
        axis.set(title=f"{name_of(runs.scene)}: {moves}", xlabel="frame", ylabel="MAPE of the frame, %")
        axis.legend(fontsize=8)
    for axis in axes[len(sequences) :]:
        axis.set_visible(False)
    return figure


def section(paper, name, title, text, studies):
    """The section of a set of sequences."""
    results = {moves: paper.compare(study, f"{name}/{moves.replace(' ', '_')}") for moves, study in studies.items()}
    sequences = [(moves, runs) for moves, found in results.items() for runs in found.runs]
    if not sequences:
        return Section(title, "Nothing was finished: see what failed.")
    drawn = [
        Picture(f"{name}_errors", f"{title}: error over frames.", curves(sequences)),
        Picture(
            name,
            f"{title}: last frame.",
            pictures.rows([row_of(runs, SHOWN, last_frame) for _, runs in sequences]),
        ),
    ]
    listed = [
        means_table(f"{name}_means", f"{title}: mean MAPE of the measured frames but the first", sequences),
        table(name, f"{title}: MAPE of single frames", sequences),
    ]
    listed += [
        recovery_table(f"{name}_recovery", runs)
        for moves, runs in sequences
        if moves == "light that jumps" and len(runs.at) > 1
    ]
    findings = [scene for found in results.values() for scene in found.findings]
    return Section(title, text, drawn, listed, findings)


def last_frame(runs):
    """{label: MAPE of the last measured frame by seed}."""
    return {label: values[:, -1] for label, values in by_frame(runs).items()}


def figure_7(paper):
    """The moving light."""
    text = (
        f"A glowing box wanders about the back room, played at {FPS:g} frames per second; each measured frame is "
        "compared with a reference of its own time. In door_ajar_light_cut the box jumps in the middle of the run. ± one "
        "standard error over seeds, ReSTIR PT is biased while things move "
        "(benchmarks/results/restir_pt)."
    )
    return section(paper, "figure_7", "Figure 7: moving light", text, studies_7(paper))


def run(paper):
    """The other sequences."""
    text = (
        f"A door that swings, played at {FPS:g} frames per second, and a camera that goes round a circle of "
        f"{100 * CIRCLE:g} cm in its own plane, {TURN} frames per turn."
    )
    return section(paper, "motion", "Motion", text, studies_motion(paper))
