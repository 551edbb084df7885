"""The C++ sources are formatted by .clang-format, and the check finds one that is not."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def check(root):
    return subprocess.run([root / "scripts" / "format", "--check"], text=True, capture_output=True, timeout=120)


def test_the_sources_are_formatted():
    result = check(ROOT)
    assert result.returncode == 0, f"{result.stderr[:2000]}\nscripts/format mends this"


def test_a_file_that_is_not_formatted_is_named(tmp_path):
    for name in ("scripts/format", ".clang-format"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    (tmp_path / "scripts" / "format").chmod(0o755)
    (tmp_path / "wrong.cpp").write_text("int  main( ) {return 0;}\n")
    subprocess.run("git init -q && git add -A", shell=True, cwd=tmp_path, check=True)
    result = check(tmp_path)
    assert result.returncode != 0 and "wrong.cpp" in result.stderr
