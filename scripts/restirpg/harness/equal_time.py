"""The knob's value with which a method's frame costs what the slowest method's does: found by rendering frames of both
in turns.

equal_cost.py compares the methods there.
"""

import json
import math
from types import SimpleNamespace

import numpy as np

import restirpg
from restirpg.harness import render
from restirpg.harness.jobs import Call, without_places

WARM_UP = 3  # frames after a knob was set
ROUNDS = 6  # frames of each that are timed, taking turns


def search_call(cheaper, other, knob, start):
    """The Call of search() for two Jobs on one scene."""
    settings = (("cheaper", _plain(cheaper)), ("other", _plain(other)), ("knob", knob), ("start", start))
    return Call(
        search, other.scene, other.scene_hash, settings, other.code, other.allow_outside,
        label=f"{cheaper.label}: equal frame time", camera=other.camera, environment=other.environment,
    )  # fmt: skip


def _plain(job):
    """Pairs of a job's fields that its renderer depends on."""
    names = ("size", "seed", "bounces", "knobs", "output", "device", "backend", "energy_compensation")
    fields = {name: getattr(job, name) for name in names}
    return (("graph", "the graph"), ("description", without_places(job.description)), *fields.items())


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
    cheaper, other = (SimpleNamespace(**dict(fields)) for fields in (cheaper, other))
    largest = _largest(json.loads(cheaper.description), knob)
    other, own = render.new_renderer(scene, other), render.new_renderer(scene, cheaper)
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
