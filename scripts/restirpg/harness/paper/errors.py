"""Errors of a study's methods by seed, and their tables: single frames, as the paper shows, and means of
all."""

import numpy as np

from restirpg.harness import analysis
from restirpg.harness import statistics as st
from restirpg.harness.paper.page import Table, estimate, percent
from restirpg.harness.paper.paper import name_of


def by_seed(runs, measure):
    """{label: (seeds,)} of a SceneRuns; `measure`: "frame", single frames, or "mean", of all frames
    together."""
    value = analysis.single_frames if measure == "frame" else lambda run: float(run["mape"][-1])
    return {label: np.array([value(run) for run in seeds]) for label, seeds in runs.runs.items()}


def change(values, baseline):
    """Ratio of the means less one, and its standard error, of values paired by seed."""
    quotient, error = st.ratio(values, baseline)
    return percent(quotient - 1, error)


def verdicts(groups):
    """Words for [(values, baseline)], both by seed: tests paired by seed, corrected (Holm) over all of
    them."""
    tests = [st.paired(values, baseline) for values, baseline in groups]
    words = []
    for test, p in zip(tests, st.holm([test.p for test in tests]) if tests else []):
        if np.isnan(p):
            words.append("not tested")
        elif p >= st.LEVEL:
            words.append(f"not different (p = {p:.2g})")
        else:
            words.append(f"{'lower' if test.difference < 0 else 'higher'} (p = {max(p, 1e-99):.2g})")
    return words


def compared(values, first, last):
    """Cells under heads() for each method, None for a verdict, and what the verdicts are about.

    values: {label: MAPE by seed}, without methods that failed. Changes are against the method `first` and
    from each method to `last`; that from the first to the last is tested once, in the last one's row.
    """
    cells, groups = {}, []
    for label, own in values.items():
        row = [percent(*st.mean_se(own)), "", "baseline", "", ""]
        if label != first:
            row[1:3] = [change(own, values[first]), None]
            groups.append((own, values[first]))
        if label != last and last in values:
            row[3] = change(values[last], own)
            if label != first:
                row[4] = None
                groups.append((values[last], own))
        cells[label] = row
    return cells, groups


def heads(last, what="single frames"):
    """The heads over what compared() gives; `what`: of which pictures the errors are."""
    return (
        f"MAPE, {what}", f"change, {what}", f"tested, {what}", f"change from it to {last}",
        f"tested, to {last}",
    )  # fmt: skip


def filled(rows, groups):
    """The rows with the verdicts where they have None."""
    words = iter(verdicts(groups))
    return [[next(words) if cell is None else cell for cell in row] for row in rows]


def table(name, title, results, methods):
    """Scenes and methods by rows: MAPE of single frames, of the mean of all, and at equal time.

    Changes are against the first method of each scene's runs, and from each method to the last. Words are
    about single frames.
    """
    last = methods[-1].label
    header = (
        "scene", "method", *heads(last), "MAPE, mean of all frames", "change, mean", "MAPE at equal time",
        "GPU ms/frame",
    )  # fmt: skip
    rows, groups = [], []
    for runs, findings in zip(results.runs, results.findings):
        frame, mean = by_seed(runs, "frame"), by_seed(runs, "mean")
        first = findings.methods[0].label
        found = {method.label: method for method in findings.methods}
        shown = [method.label for method in methods if method.label in found]
        cells, tested = compared({label: frame[label] for label in shown}, first, last)
        groups += tested
        for label in shown:
            own = found[label]
            row = [name_of(runs.scene), label, *cells[label], percent(*st.mean_se(mean[label]))]
            row.append("" if label == first else change(mean[label], mean[first]))
            rows.append([*row, percent(*own.equal_time["mape"]), milliseconds(own)])
    return Table(name, title, header, filled(rows, groups))


def milliseconds(method):
    """GPU time of a frame, over seeds."""
    return estimate(method.gpu_ms[:, -1] / method.frames[-1])
