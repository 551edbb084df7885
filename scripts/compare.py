#!/usr/bin/python3
"""Compare methods from a clone: `scripts/compare.py --help`. The program is restirpg/harness/compare.py."""
# PYTHON_ARGCOMPLETE_OK

import sys

from restirpg.commands import compare

if __name__ == "__main__":
    sys.exit(compare())
