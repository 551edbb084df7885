"""Every mistake of tests/mutants applies to the sources, says what it breaks, and has a test that must find it."""

import ast
import re

import pytest
from mutants import PATCHES, mutant_folder, patched_sources
from renderer_scenes import ROOT

NAMES = sorted(patch.stem for patch in PATCHES.glob("*.patch"))


def table():
    """Rows of "Mistakes that are found" in tests/README.md: (names of mutants, tests as (file, function))."""
    section = (ROOT / "tests/README.md").read_text().partition("## Mistakes that are found")[2]
    rows = [line.split("|")[1:3] for line in section.splitlines() if line.startswith("| `")]
    return [(re.findall(r"`(\w+)`", mutants), re.findall(r"`(\w+)::(\w+)`", tests)) for mutants, tests in rows]


def source_of(file, function):
    """The text of a test with what it is parametrized by."""
    text = (ROOT / f"tests/python/{file}.py").read_text()
    [own] = [node for node in ast.parse(text).body if getattr(node, "name", None) == function]
    return "\n".join(ast.get_source_segment(text, node) for node in (*own.decorator_list, own))


@pytest.mark.parametrize("name", NAMES)
def test_the_patch_applies_and_says_what_it_breaks(tmp_path, name):
    patch = PATCHES / f"{name}.patch"
    patched_sources(patch, tmp_path)
    heading = patch.read_text().partition("\n---")[0]
    assert re.fullmatch(r"Property: .+\.\nMistake: .+\.\n", heading)


def test_a_patch_that_no_longer_applies_fails_with_a_line(tmp_path):
    patch = tmp_path / "old.patch"
    text = (PATCHES / "reuse_mis.patch").read_text()
    patch.write_text(
        text.replace(" float share", " float share_of_long_ago", 1).replace("-    float share", "-    float gone")
    )
    with pytest.raises(
        pytest.fail.Exception, match=r"^old.patch no longer applies \(patch failed: passes/.*glsl:\d+\); make the"
    ):
        patched_sources(patch, tmp_path / "copies")


@pytest.mark.parametrize(
    ("name", "including", "plugins"),
    [
        ("reuse_sharp_density", ["ShiftProbe"], {"PathTracerGuided", "ShiftProbe"}),
        ("reuse_mis", ["ReSTIRReuse"], {"ReSTIRReuse"}),
        ("reuse_visibility", [], set()),  # in the shader library, which all plug-ins include
    ],
)
def test_every_plugin_whose_sources_are_patched_is_copied(name, including, plugins):
    found = (mutant_folder(name, *including) / "plugins").glob("*.so")
    assert {file.stem.removeprefix("restirpg-pass-") for file in found} == plugins


def test_the_table_names_every_mutant_and_a_test_that_uses_it():
    rows = table()
    assert sorted(name for names, _ in rows for name in names) == NAMES
    for names, tests in rows:
        assert tests
        for file, function in tests:
            text = source_of(file, function)
            assert all(f'"{name}"' in text for name in names), (names, function)
