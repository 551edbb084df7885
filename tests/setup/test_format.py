"""The sources are as clang-format, ruff and mypy want them (scripts/format --check), and the check finds what is
not."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def check(root):
    result = subprocess.run([root / "scripts" / "format", "--check"], text=True, capture_output=True, timeout=600)
    return result.returncode, result.stderr


def skip_without_ruff(said):
    for line in said.splitlines():
        if line.startswith("NOT CHECKED"):
            pytest.skip(line)


def test_the_sources_are_formatted_and_clean():
    code, said = check(ROOT)
    assert code == 0, f"{said[:2000]}\nscripts/format mends the format"
    skip_without_ruff(said)


@pytest.fixture
def clone(tmp_path):
    """A repository with nothing but what the check needs; it shares this one's ruff."""
    for name in ("scripts/format", ".clang-format", "pyproject.toml"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    (tmp_path / "scripts" / "format").chmod(0o755)
    (ROOT / ".cache").mkdir(exist_ok=True)
    (tmp_path / ".cache").symlink_to(ROOT / ".cache")
    return tmp_path


def commit(clone, name, text):
    (clone / name).parent.mkdir(exist_ok=True)
    (clone / name).write_text(text)
    subprocess.run("git init -q && git add -A", shell=True, cwd=clone, check=True)


def test_cpp_that_is_not_formatted_is_named(clone):
    commit(clone, "wrong.cpp", "int  main( ) {return 0;}\n")
    code, said = check(clone)
    assert code == 1 and "wrong.cpp" in said


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("x  = 1\n", "reformatted"),
        ("x = undefined\n", "F821"),
        ('x: int = "text"\n', "Incompatible types"),
    ],
)
def test_python_that_is_not_clean_is_named(clone, text, word):
    commit(clone, "scripts/restirpg/__init__.py", text)
    code, said = check(clone)
    skip_without_ruff(said)
    assert code == 1 and word in said and "__init__.py" in said
