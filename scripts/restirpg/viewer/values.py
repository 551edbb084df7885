"""Values of the page's messages, checked."""

import math

from restirpg.harness import UserError


def as_number(value, low=-1e6, high=1e6):
    """The number, clamped to low..high."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise UserError(f"{value!r} is no number")
    return min(high, max(low, value))
