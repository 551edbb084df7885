"""restirpg.records lays out every shared record as compiled kernels read it: offsets and sizes against SPIR-V's."""

import re
import subprocess

import numpy as np
import pytest
from renderer_scenes import ROOT

import restirpg
from restirpg import records
from restirpg.harness.guiding import Grid

SHADERS = ROOT / "framework" / "shaders"


def compiled_layouts(folder):
    """{record: ({member: offset}, size)} of a kernel that has an array of each record, from its disassembly."""
    names = records.names()
    files = [*SHADERS.rglob("*_types.h"), *(ROOT / "passes").glob("*/Shared.h")]
    headers = "".join(f'#include "{file.relative_to(ROOT)}"\n' for file in sorted(files))
    arrays = "".join(
        f"layout(set = 0, binding = {n}, scalar) buffer Array{n} {{ {name} at[]; }} array{n};\n"
        for n, name in enumerate(names)
    )
    uses = "".join(f"array{n}.at[0] = array{n}.at[1];\n" for n in range(len(names)))
    kernel = folder / "records.comp"
    kernel.write_text(
        "#version 460\n#extension GL_GOOGLE_include_directive : require\n"
        f'#include "prelude.glsl"\n{headers}{arrays}void main() {{\n{uses}}}\n'
    )
    options = [
        "-V",
        "--target-env",
        "vulkan1.2",
        f"-I{SHADERS}",
        f"-I{SHADERS.parent}",
        f"-I{ROOT}",
        "-o",
        folder / "records.spv",
    ]
    done = subprocess.run(["glslangValidator", *options, kernel], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    text = subprocess.run(
        ["spirv-dis", "--raw-id", folder / "records.spv"], capture_output=True, text=True, check=True
    ).stdout
    members = {key: {} for key in re.findall(r"OpMemberDecorate (%\d+) \d+ Offset", text)}
    for key, number, offset in re.findall(r"OpMemberDecorate (%\d+) (\d+) Offset (\d+)", text):
        [name] = re.findall(rf'OpMemberName {key} {number} "(\w+)"', text)
        members[key][name] = int(offset)
    strides = dict(re.findall(r"OpDecorate (%\d+) ArrayStride (\d+)", text))
    elements = dict(re.findall(r"(%\d+) = OpTypeRuntimeArray (%\d+)", text))
    found = {}
    for array, element in elements.items():
        [name] = re.findall(rf'OpName {element} "(\w+)"', text)
        found[name] = members[element], int(strides[array])
    return found


def test_every_record_lies_as_kernels_read_it(tmp_path):
    found = compiled_layouts(tmp_path)
    assert (
        {"PathVertex", "GuidingSums", "PathReservoir", "LightReservoir", "ChainState"}
        <= found.keys()
        == set(records.names())
    )
    for name, (offsets, size) in found.items():
        dtype = records.record(name)
        assert ({key: dtype.fields[key][1] for key in dtype.names}, dtype.itemsize) == (offsets, size), name


def test_constants_are_those_of_the_headers():
    assert records.constant("GUIDING_LOBES") == 4 and records.constant("VERTEX_LIGHT_SAMPLED") == 1 << 17
    assert records.constant("VERTEX_MATERIAL_MASK") == 0xFFFF


def test_constants_of_sums_and_of_one_line_are_read():
    rows, columns = records.constant("ENERGY_ROWS"), records.constant("ENERGY_COLUMNS")
    assert records.constant("ENERGY_TABLE") == 2 * rows * (columns + 1)
    assert records.constant("MAP_METALLIC_ROUGHNESS") == 1


@pytest.mark.parametrize(
    "read, name, words",
    [
        (records.record, "PathReservior", "no record 'PathReservior'; there are: .*; did you mean 'PathReservoir'?"),
        (records.constant, "GUIDING_LOBE", "no constant 'GUIDING_LOBE'; there are: .*; did you mean 'GUIDING_LOBES'?"),
    ],
)
def test_a_name_that_there_is_not_is_refused_with_those_that_there_are(read, name, words):
    with pytest.raises(restirpg.WrongValueError, match=re.escape(words).replace(r"\.\*", ".*")):
        read(name)


HEADER = """RESTIRPG_CONST OWN_SIDE = 3u;
struct OwnPart { float weight; };
struct OwnRecord {
    OwnPart parts[OWN_SIDE];  ///< as many
    uint count;
};
struct OddRecord {
    uint a, b;
};
"""


def test_records_of_a_pass_out_of_tree_are_found(tmp_path, monkeypatch):
    (tmp_path / "Shared.h").write_text(HEADER)
    monkeypatch.setattr(restirpg, "code_paths", lambda: [tmp_path / "restirpg-pass-Own.so", tmp_path], raising=False)
    dtype = records.record("OwnRecord")
    assert dtype["parts"].shape == (3,) and dtype.itemsize == 16
    with pytest.raises(restirpg.WrongValueError, match="record 'OddRecord': 'uint a, b' is not TYPE MEMBER"):
        records.record("OddRecord")


def test_keys_of_the_guide_are_laid_out_as_the_header_says():
    grid = Grid(camera=np.zeros(3), scale=1.0, origin=np.zeros(3), smallest=1.0, radius=1.0)
    point = [18.0, 6.0, 10.0]  # 21.4 m away: level 4, cells of 16 m
    [key] = map(int, grid.keys(np.array([point]), np.array([5]), np.array([300]))[0])
    parts = [
        key >> records.constant(name)
        for name in ("GUIDING_LEVEL_SHIFT", "GUIDING_FACE_SHIFT", "GUIDING_MATERIAL_SHIFT")
    ]
    assert (key & (1 << records.constant("GUIDING_INDEX_BITS")) - 1, parts[0] & 31, parts[1] & 7) == (1, 4, 5)
    assert parts[2] & 0xFFFF == 300


def test_a_view_keeps_the_layout():
    seen = records.record("GuidingCell", state=[("age", "<u2"), ("alpha", "<u2")])
    assert (
        seen.names == ("lobes", "age", "alpha", "samples") and seen.itemsize == records.record("GuidingCell").itemsize
    )
    assert records.record("GuidingSums", lanes="<i8")["lanes"] == np.dtype(("<i8", (16,)))
    with pytest.raises(AssertionError, match="state has 4 bytes"):
        records.record("GuidingCell", state="<u8")
    with pytest.raises(TypeError, match="no member age"):
        records.record("GuidingCell", age="<u2")
