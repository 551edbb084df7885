#!/usr/bin/python3
"""Write the embedded scenes from a clone: `scripts/make_scenes.py --help`. The program is restirpg/scenes/make.py."""
# PYTHON_ARGCOMPLETE_OK

import sys

from restirpg.commands import scenes

if __name__ == "__main__":
    sys.exit(scenes())
