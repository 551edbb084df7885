#!/usr/bin/python3
"""Draw what guides the paths at some pixels from a clone: `scripts/see_guide.py --help`. The program is
restirpg/harness/see_guide.py."""
# PYTHON_ARGCOMPLETE_OK

import sys

from restirpg.commands import see_guide

if __name__ == "__main__":
    sys.exit(see_guide())
