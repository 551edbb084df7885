"""Methods compared at equal frame time: a knob of each cheaper one is raised until its frame costs what the slowest
one's does.

What a user sees of a real-time method is a single frame. A cheaper frame is of use only if it can be made better for
the difference. A whole number hardly ever hits the time: both neighbouring settings are run, and their errors are
interpolated by their frame times. A method whose frames stay cheaper up to the knob's largest value is compared there,
and the table says so. There is no verdict on a method whose frames took another time in the runs than the slowest
method's: TOLERANCE.

The runs with raised knobs do not count as methods: they appear in no other table, and their tests are not part of the
correction for multiple tests. Their key is (label of the method, value of the knob).
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from restirpg.harness import statistics as st

TOLERANCE = 0.05  # of the slowest method's frame time: what took longer or less in the runs is not equal, however noisy


@dataclass(frozen=True)
class Bracket:
    """Two neighbouring settings of a method between which its frame costs as much as the slowest method's, or the last
    two of the knob's range, with which it is still cheaper.
    """

    knob: str
    low: int
    ratios: tuple  # of frame time to the slowest method's, at `low` and at `low` + 1

    def keys(self, label):
        """Of the method's runs with either setting."""
        return (label, self.low), (label, self.low + 1)

    @property
    def weight(self):
        """Of the upper setting; in no more digits than any time has, so that equal times give equal errors."""
        below, above = self.ratios
        return round((1 - below) / (above - below), 6) if above > 1 else 1.0

    @property
    def found(self):
        """The knob's value, between two whole numbers."""
        return self.low + self.weight

    @property
    def setting(self):
        """The knob with the value found; where it is the largest, with the share of the slowest method's frame time."""
        _, above = self.ratios
        return f"{self.knob}={self.found:.2f}" + (f", the largest: {above:.2f} of the time" if above < 1 else "")


@dataclass
class EqualCost:
    """What was found of the frame times of a scene's methods."""

    target: str  # label of the method whose frame takes longest
    brackets: dict = field(default_factory=dict)  # label of a method -> Bracket; its own setting where it has none


def slowest(runs):
    """The label of the method whose frame takes longest; runs: label -> finished results."""
    return max(runs, key=lambda label: np.median([run["gpu_ms"][-1] / run["frames"][-1] for run in runs[label]]))


def start_of(knobs, path):
    """The knob's own value, or None where the method has none that could be raised."""
    name, _, own = path.partition(".")
    value = knobs.get(name, {}).get(own)
    return value if isinstance(value, int) and not isinstance(value, bool) else None


def raised(job, knob, start, value):
    """The Job with the knob, which is `start` in it, set to that value."""
    knobs = (*(each for each in job.knobs if each[0] != knob), (knob, value))
    return replace(job, label=f"{job.label}, {knob} raised to {value}", knobs=job.knobs if value == start else knobs)


def interpolated(label, bracket, raised, value):
    """`value` of a MethodFindings between the two settings of a Bracket; raised: by (label, the knob's value)."""
    low, high = (value(raised[key]) for key in bracket.keys(label))
    return (1 - bracket.weight) * low + bracket.weight * high


@dataclass(frozen=True)
class Equal:
    """A method at equal frame time."""

    label: str
    setting: str  # the knob with the value found, or "own"
    values: np.ndarray  # MAPE of single frames by seed or tile
    time: tuple  # of a frame in the compared runs, first frames too, to the slowest method's, and its standard error
    ratio: tuple  # of the error to the first method's, and its standard error
    p: float = math.nan  # corrected over the methods of the scene; NaN: the first itself, or not at equal time with it

    @property
    def is_equal(self):
        """Whether its frames took as long as the slowest method's."""
        return abs(self.time[0] - 1) <= TOLERANCE


def bracket_of(answer, knob):
    """The Bracket that equal_time.search() found, or None where the method's own setting takes as long already."""
    ratios = tuple(map(float, answer["ratios"]))
    return Bracket(knob, answer["meta"]["high"] - 1, ratios) if ratios[0] < 1 else None


def compare(scene):
    """[Equal] of a SceneFindings' methods, the first first."""
    brackets = scene.equal_cost.brackets
    values, times = {}, {}
    for method in scene.methods:
        bracket = brackets.get(method.label)
        values[method.label], times[method.label] = (
            interpolated(method.label, bracket, scene.raised, value) if bracket else value(method)
            for value in (lambda each: each.single, lambda each: each.frame_ms)
        )
    first = next(iter(values.values()))
    found = [
        Equal(
            label,
            brackets[label].setting if label in brackets else "own",
            own,
            st.ratio(times[label], times[scene.equal_cost.target]),
            st.ratio(own, first),
        )
        for label, own in values.items()
    ]
    tested = [own.is_equal and found[0].is_equal and own is not found[0] for own in found]
    corrected = st.holm([st.paired(own.values, first).p if test else math.nan for own, test in zip(found, tested)])
    return [replace(own, p=float(p)) for own, p in zip(found, corrected)]
