"""What the READMEs tell a newcomer to type, typed as it stands: the blocks marked "tutorial", in a copy of the
repository.

One shell runs them all, so that a file that one of them writes is there for the next. No network is needed.
"""

import csv
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BUILD = Path(os.environ.get("RESTIRPG_BUILD", ROOT / "build"))
PAGES = ("README.md", "graphs/README.md", "passes/README.md")
BLOCK = re.compile(r"<!-- tutorial -->\n```sh\n(.*?)^```$", re.DOTALL | re.MULTILINE)


@pytest.fixture(scope="module")
def repository(tmp_path_factory):
    """A copy of the repository's files, built: its folder after all commands."""
    folder = tmp_path_factory.mktemp("clone") / "restirpg"
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
    (folder / "build").symlink_to(BUILD.resolve())
    blocks = [block for page in PAGES for block in BLOCK.findall((ROOT / page).read_text())]
    assert len(blocks) == 9
    blocks.insert(0, "scripts/make_scenes.py door_ajar\n")  # as scripts/run does, which a reader has run by then
    own = {name: value for name, value in os.environ.items() if not name.startswith(("RESTIRPG_", "PYTHON"))}
    run = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", "".join(blocks)],
        cwd=folder,
        env=own,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=600,
    )
    (folder / "output.txt").write_text(run.stdout)
    assert run.returncode == 0, run.stdout
    return folder


def summary(folder):
    """summary.csv of a comparison: method -> row."""
    with open(folder / "summary.csv") as file:
        return {row["method"]: row for row in csv.DictReader(file)}


def test_the_first_page_renders_and_compares(repository):
    assert (repository / "out/picture.png").stat().st_size > 0
    assert set(summary(repository / "out/first")) == {"restir_pt", "restir_pg"}
    assert "My path tracer" in (repository / "output.txt").read_text()


def test_the_method_in_a_graph_file_is_compared(repository):
    assert set(summary(repository / "out/mine")) == {"restir_pg", "mine", "fewer"}
    assert (repository / "out/mine/report.html").stat().st_size > 0


def test_the_pass_out_of_tree_does_what_the_text_says(repository):
    assert "Largest radiance" in (repository / "output.txt").read_text()  # described
    rows = summary(repository / "out/clamped")
    bias = {method: float(row["bias"]) for method, row in rows.items()}
    assert bias["lower"] < bias["clamped"] < bias["path_tracer"]
    found = {method for method, row in rows.items() if float(row["bias_p"]) < 0.01}
    assert found == {"clamped", "lower"}


def test_the_guide_out_of_tree_is_compared(repository):
    assert set(summary(repository / "out/lobes_compared")) == {"restir_pt", "lobes"}
