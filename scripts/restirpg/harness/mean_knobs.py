"""The knobs that the mean of many frames depends on: pictures that differ in them converge to different ones."""

import json

_WORDS = {"bounces": "bounce cap", "jitter": "pixel filter (jitter)"}


def mean_of(knobs):
    """{knob: value} of those that a graph has, the largest of any pass. knobs: of Renderer.knobs()."""
    found = {name: [own[name] for own in knobs.values() if name in own] for name in _WORDS}
    return {name: max(values) for name, values in found.items() if values}


def differences(own, other, whose):
    """{knob: what is to be said} where both mean_of() know a knob and differ. whose: the other."""
    return {
        name: f"its {words} is {json.dumps(own[name])}, that of {whose} is {json.dumps(other[name])}"
        for name, words in _WORDS.items()
        if name in own and name in other and own[name] != other[name]
    }
