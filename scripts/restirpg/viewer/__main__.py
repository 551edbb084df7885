"""`python3 -m restirpg.viewer GRAPH ... --scene FILE`: what scripts/view.py and `restirpg view` do."""

import sys

from restirpg.commands import view

if __name__ == "__main__":
    sys.exit(view())
