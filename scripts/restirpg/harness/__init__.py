"""The A/B harness behind scripts/compare.py: jobs, their runner and cache, statistics, and the report."""


class UserError(Exception):
    """A mistake the user can mend: one line that names the place and the mend; the program exits with 2."""


class Halt(UserError):
    """One that every further run would meet as well: the program ends at once."""
