"""The clone that these programs lie in. To import this puts its package restirpg on Python's path, as the programs of
scripts/ have it: they run without PYTHONPATH, and the package finds its build by itself."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

sys.path.insert(0, str(ROOT / "scripts"))


def program():
    """The file of the program restirpg, of the build that the binding module is from. Raises UserError."""
    from restirpg.harness import UserError, render

    render.find_package()
    file = render.native_file().parents[2] / "bin" / "restirpg"
    if not file.is_file():
        raise UserError(
            f"{file}: no such program; build it with scripts/run, or name its build folder in RESTIRPG_BUILD"
        )
    return file
