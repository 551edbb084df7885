"""What a misspelt name may have meant."""

import difflib


def did_you_mean(name, names):
    """What a message ends with: "; did you mean 'x'?" of the nearest of the names, or nothing."""
    near = difflib.get_close_matches(name, list(names), n=1)
    return f"; did you mean '{near[0]}'?" if near else ""
