"""Mistakes built into copies of the passes' GLSL: tests/mutants/NAME.patch, one a mistake.

A plug-in finds its kernels in the folder of its name beside it. So a copy of the library beside patched sources, first
on the plug-in path, is the pass with the mistake; nothing is compiled but kernels. Every plug-in whose sources are
patched is copied, so that all of the mistake acts. Mistakes in the shader library are found by RESTIRPG_SHADERS.
"""

import atexit
import contextlib
import functools
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest
from renderer_scenes import ROOT

from restirpg.harness.render import native_file

PATCHES = ROOT / "tests" / "mutants"
BUILT = ("tests/passes", "lib/restirpg/passes")
SHADERS = "framework/shaders"
SOURCES = ("passes", "tests/restir", SHADERS)


def patched_sources(patch, folder):
    """Copies of the passes' sources, with the mistake, in `folder`; one line when the patch no longer applies."""
    for name in SOURCES:
        shutil.copytree(ROOT / name, folder / name)
    # The ceiling hides any repository around the folder: within one, git would leave the copies alone.
    done = subprocess.run(
        ["git", "apply", patch],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "GIT_CEILING_DIRECTORIES": str(folder.resolve().parent)},
    )
    if done.returncode:
        reason = done.stderr.splitlines()[0].removeprefix("error: ")
        pytest.fail(f"{patch.name} no longer applies ({reason}); make the mistake anew in the sources", pytrace=False)


def the_one(files):
    """The only one of these files and folders that exists."""
    [found] = filter(Path.exists, files)
    return found


def patched_plugins(patch):
    """Names of the plug-ins whose own folders a patch changes."""
    folders = "|".join(name for name in SOURCES if name != SHADERS)
    return set(re.findall(rf"^\+\+\+ b/(?:{folders})/(\w+)/", patch.read_text(), re.MULTILINE))


@functools.cache
def mutant_folder(name, *including):
    """A folder with sources that have the mistake `name`, and in `plugins`, beside them, copies of the libraries whose
    sources it changes, and of those that include such sources.

    It stays until this process ends, for a renderer may build its passes anew.
    """
    folder = Path(tempfile.mkdtemp(prefix=f"restirpg-{name}-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    patched_sources(PATCHES / f"{name}.patch", folder)
    plugins = folder / "plugins"
    plugins.mkdir()
    for plugin in patched_plugins(PATCHES / f"{name}.patch").union(including):
        library = the_one(native_file().parents[2] / place / f"restirpg-pass-{plugin}.so" for place in BUILT)
        shutil.copy(library, plugins)  # the loader would take a link for the library that it has
        (plugins / library.stem).symlink_to(the_one(folder / place / plugin for place in SOURCES))
    return folder


@contextlib.contextmanager
def mutant(name, *including):
    """Renderers and programs that start within have the mistake `name`, in the plug-ins `including` too: those that
    include its sources."""
    folder = mutant_folder(name, *including)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RESTIRPG_SHADERS", str(folder / SHADERS))
        patch.setenv("RESTIRPG_PLUGIN_PATH", str(folder / "plugins"), prepend=os.pathsep)
        yield
