#!/usr/bin/python3
"""Reproduce the paper's evaluation from a clone: `scripts/reproduce.py --help`. The program is
restirpg/harness/reproduce.py."""
# PYTHON_ARGCOMPLETE_OK

import sys

from restirpg.commands import reproduce

if __name__ == "__main__":
    sys.exit(reproduce())
