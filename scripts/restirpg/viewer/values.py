"""Values of the page's messages: checked on the way in, as JSON on the way out."""

import json
import math
import numbers
import sys

from restirpg.harness import UserError


def as_finite(value):
    """The number, which a float can hold."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real) or not abs(value) <= sys.float_info.max:
        raise UserError(f"{value!r} is no number")
    return value


def as_triple(value, name):
    """A list of three floats, of any sequence of three numbers."""
    try:
        triple = [float(as_finite(part)) for part in value]
    except TypeError:
        triple = []
    if len(triple) != 3:
        raise UserError(f"{name} is not three numbers")
    return triple


def as_number(value, low=-1e6, high=1e6):
    """The number, clamped to low..high: how far a hand goes at once."""
    return min(high, max(low, as_finite(value)))


def as_json(value):
    """JSON that a browser reads. It has no number that is not finite: such a one is a string, as JavaScript's Number()
    takes it."""
    try:
        return json.dumps(value, allow_nan=False)
    except ValueError:
        return json.dumps(_spelled(value), allow_nan=False)


def _spelled(value):
    if isinstance(value, dict):
        return {name: _spelled(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_spelled(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value
