#!/usr/bin/python3
"""Look at a scene through graphs, live in a browser, from a clone: `scripts/view.py --help`. The program is
restirpg/viewer/start.py."""
# PYTHON_ARGCOMPLETE_OK

import sys

from restirpg.commands import view

if __name__ == "__main__":
    sys.exit(view())
