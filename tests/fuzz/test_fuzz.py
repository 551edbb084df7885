"""A minute of fuzzing: every reader of files, under AddressSanitizer and UndefinedBehaviorSanitizer."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TARGETS = ["gltf", "image", "exr", "hdr", "graph"]


@pytest.mark.skipif(
    not shutil.which("clang++"), reason="clang++ and libclang-rt-dev are not installed: no reader is fuzzed"
)
def test_a_minute_of_fuzzing_finds_nothing():
    before = {target: len(list((ROOT / "build/fuzz/corpus" / target).glob("*"))) for target in TARGETS}
    done = subprocess.run([ROOT / "scripts" / "fuzz", "1"], text=True, capture_output=True, timeout=1800, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = [line.split() for line in done.stdout.splitlines()[1:]]
    assert [row[0] for row in rows] == TARGETS
    for row in rows:
        assert row[-1] == "ok"
        # More than the seeds, and than the files that were kept: less would mean that inputs are not read at all. A busy
        # machine, too, reads all that is there before it looks at the time.
        assert int(row[1]) > max(10, before[row[0]]), done.stdout


def test_wrong_arguments_are_one_line():
    for arguments in ([], ["0"], ["x"], ["1", "png"]):
        done = subprocess.run([ROOT / "scripts" / "fuzz", *arguments], text=True, capture_output=True, check=False)
        assert done.returncode == 2
        assert re.fullmatch(r"fuzz: .*\n", done.stderr), done.stderr
