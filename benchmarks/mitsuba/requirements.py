"""What the comparisons need that is not in this repository: Mitsuba 3, and a converter of scenes."""

import os
import shutil
import subprocess
from pathlib import Path

from clone import ROOT

from restirpg.harness import UserError


def add_options(parser, required=False):
    """The options that name them."""
    add = parser.add_argument
    add("--mitsuba-python", required=required, help="the Python of an environment that has Mitsuba 3")
    add(
        "--converter",
        type=Path,
        default=ROOT.parent / "shared" / "tools" / "gltf_to_mitsuba.py",
        help="glTF to Mitsuba 3; not in this repository (default: ../shared/tools/gltf_to_mitsuba.py)",
    )


def check(options):
    """Raise UserError where one of them is missing."""
    if not options.converter.is_file():
        raise UserError(
            f"{options.converter}: there is no converter; name a program that renders a .glb with Mitsuba in --converter "
            "(benchmarks/README.md says how it is called)"
        )
    python = options.mitsuba_python
    if not python or not shutil.which(python):
        raise UserError(f"{python}: no such program; name the Python that has Mitsuba 3 in --mitsuba-python")
    environment = {**os.environ, "PYTHONPATH": ""}
    if subprocess.run([python, "-c", "import mitsuba"], capture_output=True, env=environment).returncode != 0:
        raise UserError(f"{python}: it cannot import mitsuba; name the Python that has Mitsuba 3 in --mitsuba-python")
