"""Methods compared at equal frame time: a knob of each cheaper one is raised until its frame costs what the dearest
one's does.

What a user sees of a real-time method is a single frame, so that cheaper frames are no use unless they can be made
better for the difference. A whole number hardly ever hits the time: both neighbouring settings are run, and
their errors are interpolated by their frame times. A method whose frames stay cheaper up to the knob's largest value is
compared there, and the table says so.
"""

import json
import math
from dataclasses import dataclass

import numpy as np

import restirpg
from restirpg.harness import statistics as st
from restirpg.harness.jobs import Call, without_places

WARM_UP = 3  # frames after a knob was set
ROUNDS = 6  # frames of each that are timed, taking turns


@dataclass(frozen=True)
class Bracket:
    """Two neighbouring settings of a method between which its frame costs as much as the dearest method's, or the last
    two of the knob's range, with which it is still cheaper.
    """

    knob: str
    low: int
    ratios: tuple  # of frame time to the dearest method's, at `low` and at `low` + 1
    labels: tuple  # of the runs with either

    @property
    def weight(self):
        """Of the upper setting."""
        below, above = self.ratios
        return (1 - below) / (above - below) if above > 1 else 1.0

    @property
    def found(self):
        """The knob's value, between two whole numbers."""
        return self.low + self.weight

    @property
    def setting(self):
        """The knob with the value found; where it is the largest, with the share of the dearest method's frame time."""
        _, above = self.ratios
        return f"{self.knob}={self.found:.2f}" + (f", the largest: {above:.2f} of the time" if above < 1 else "")


def label_at(label, knob, value):
    """What the method is called with that setting."""
    return f"{label} {knob}={value}"


def dearest(runs):
    """The label of the method whose frame takes longest; runs: label -> finished results."""
    return max(runs, key=lambda label: np.median([run["gpu_ms"][-1] / run["frames"][-1] for run in runs[label]]))


def search_call(cheaper, other, knob, start):
    """The Call of search() for two Jobs on one scene."""
    settings = (("cheaper", _plain(cheaper)), ("other", _plain(other)), ("knob", knob), ("start", start))
    return Call(
        search, other.scene, other.scene_hash, settings, other.code, other.allow_outside,
        label=f"{cheaper.label}: equal frame time", camera=other.camera, environment=other.environment,
    )  # fmt: skip


def _plain(job):
    return (
        without_places(job.description),
        job.size,
        job.seed,
        job.bounces,
        job.knobs,
        job.device,
        job.backend,
        job.energy_compensation,
    )


def _renderer(scene, description, size, seed, bounces, knobs, device, backend, energy_compensation):
    renderer = restirpg.Renderer(
        scene, json.loads(description), size=tuple(size), seed=seed, device=device, backend=backend,
        energy_compensation=energy_compensation, bounces=bounces,
    )  # fmt: skip
    for name, value in knobs:
        (renderer.set if "." in name else renderer.set_everywhere)(name, value)
    return renderer


def _largest(description, path):
    """The end of a knob's range."""
    name, _, own = path.partition(".")
    kind = next(each["type"] for each in description["passes"] if each["name"] == name)
    return next(each.get("maximum", math.inf) for each in restirpg.describe_pass(kind)["knobs"] if each["name"] == own)


def search(scene, cheaper, other, knob, start):
    """The least whole number `high` of the knob, from `start` on, with which a frame of `cheaper` takes at least the
    time of one of `other`, or else the largest of its range, in `meta`, and the `ratios` of their times at `high` - 1
    and there.
    """
    largest = _largest(json.loads(cheaper[0]), knob)
    other, own = _renderer(scene, *other), _renderer(scene, *cheaper)
    measured = {}

    def ratio(value):
        if value not in measured:
            own.set(knob, value)
            measured[value] = _time_ratio(own, other)
        return measured[value]

    if ratio(start) >= 1:  # it was hardly cheaper
        return {"ratios": np.array([np.nan, ratio(start)]), "meta": {"high": start}}
    low, step = start, 1
    while low + step < largest and ratio(low + step) < 1:
        low, step = low + step, 2 * step
    high = min(low + step, largest)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if ratio(middle) < 1 else (low, middle)
    return {"ratios": np.array([ratio(high - 1), ratio(high)]), "meta": {"high": high}}


def _time_ratio(own, other):
    """Median ratio of the GPU times of frames that take turns."""
    for renderer in (own, other):
        renderer.render(WARM_UP)
    return float(np.median([_frame(own) / _frame(other) for _ in range(ROUNDS)]))


def _frame(renderer):
    before = sum(renderer.total_gpu_times().values())
    renderer.render(1)
    return sum(renderer.total_gpu_times().values()) - before


def start_of(knobs, path):
    """The knob's own value, or None where the method has none that could be raised."""
    name, _, own = path.partition(".")
    value = knobs.get(name, {}).get(own)
    return value if isinstance(value, int) and not isinstance(value, bool) else None


def interpolated(bracket, methods, value):
    """`value` of a MethodFindings between the two settings of a Bracket; methods: by label."""
    low, high = (value(methods[label]) for label in bracket.labels)
    return (1 - bracket.weight) * low + bracket.weight * high


def frame_ms(method):
    """GPU time of a frame, ms: the mean over the runs of a MethodFindings, its first frames too."""
    return float(np.mean(method.gpu_ms[:, -1] / method.frames[-1]))


@dataclass(frozen=True)
class Equal:
    """A method at equal frame time."""

    label: str
    setting: str  # the knob with the value found, or "own"
    values: np.ndarray  # MAPE of single frames by seed or tile
    time: float  # of a frame in the compared runs, of the dearest method's: how well the search has hit it
    ratio: tuple  # to the first method's, and its standard error
    p: float  # corrected over the methods of the scene; NaN: the first itself


def bracket_of(answer, label, knob):
    """The Bracket that search() found, or None where the method's own setting takes as long already."""
    low, ratios = answer["meta"]["high"] - 1, tuple(map(float, answer["ratios"]))
    return (
        Bracket(knob, low, ratios, tuple(label_at(label, knob, value) for value in (low, low + 1)))
        if ratios[0] < 1
        else None
    )


def compare(brackets, methods):
    """[Equal] of a scene's methods (MethodFindings, the first first) of which none was added for a Bracket."""
    by_label = {method.label: method for method in methods}
    added = {label for bracket in brackets.values() for label in bracket.labels}
    values, times = {}, {}
    for method in methods:
        if method.label in added:
            continue
        bracket = brackets.get(method.label)
        values[method.label], times[method.label] = (
            interpolated(bracket, by_label, value) if bracket else value(method)
            for value in (lambda each: each.single, frame_ms)
        )
    first = next(iter(values.values()))
    tests = [st.paired(own, first).p for own in list(values.values())[1:]]
    corrected = [float("nan"), *st.holm(tests)]
    return [
        Equal(
            label,
            brackets[label].setting if label in brackets else "own",
            own,
            times[label] / max(times.values()),
            st.ratio(own, first),
            float(p),
        )
        for (label, own), p in zip(values.items(), corrected)
    ]
