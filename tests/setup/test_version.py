"""framework/cmake/version.cmake: the commit that the program and its pictures tell."""

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def git(folder, *arguments):
    command = ["git", "-C", folder, "-c", "user.name=a", "-c", "user.email=a@example.org", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


@pytest.fixture
def repository(tmp_path):
    folder = tmp_path / "repository"
    (folder / "vendor/restirpg").mkdir(parents=True)
    git(folder, "init", "-q")
    git(folder, "commit", "-q", "--allow-empty", "-m", "first")
    return folder


def commit_of(source, out, **environment):
    """What a build of the sources in a folder would say."""
    definitions = [f"-DSOURCE={source}", "-DVERSION=1", f"-DOUTPUT={out / 'version.cpp'}"]
    command = ["/usr/bin/cmake", *definitions, "-P", ROOT / "framework/cmake/version.cmake"]
    subprocess.run(command, check=True, env=os.environ | environment)
    return re.search(r'COMMIT = "(.*)"', (out / "version.cpp").read_text())[1]


def test_a_clone_has_its_own_commit(repository, tmp_path):
    assert commit_of(repository, tmp_path) == git(repository, "rev-parse", "--short=10", "HEAD")
    (tmp_path / "link").symlink_to(repository)
    assert commit_of(tmp_path / "link", tmp_path) == git(repository, "rev-parse", "--short=10", "HEAD")


def test_sources_in_another_project_s_repository_do_not_have_its_commit(repository, tmp_path):
    assert commit_of(repository / "vendor/restirpg", tmp_path) == "unknown"


def test_without_git_or_a_commit_it_is_unknown(repository, tmp_path):
    assert commit_of(repository, tmp_path, PATH="/nowhere") == "unknown"
    empty = tmp_path / "empty"
    empty.mkdir()
    git(empty, "init", "-q")
    assert commit_of(empty, tmp_path) == "unknown"
