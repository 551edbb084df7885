"""The embedded scenes: the same bytes on every run, sound accessors, normals, winding, closed glass."""

import json
import pathlib
import struct
import subprocess
import sys

import numpy as np
import pytest

from restirpg.scenes import SCENES, furniture, implicit, shapes, textures
from restirpg.scenes.gltf import SceneFile, glass, lambert, look_at
from restirpg.scenes.images import encode_hdr, encode_png

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "scripts"
ANALYTIC = {"cornell_box", "cornell_glass", "furnace_environment", "furnace_closed"}
COMPONENTS = {5123: np.uint16, 5125: np.uint32, 5126: np.float32}
COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Glb:
    """A .glb as read back, independently of the writer."""

    def __init__(self, data, environment=None):
        self.data, self.environment = data, environment
        magic, version, length, json_length, kind = struct.unpack_from("<4sIII4s", data)
        assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
        self.json = json.loads(data[20 : 20 + json_length])
        self.binary = data[20 + json_length + 8 :]
        assert len(self.binary) >= self.json["buffers"][0]["byteLength"]

    def accessor(self, index):
        """Values of an accessor, (count, columns)."""
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        dtype, columns = COMPONENTS[accessor["componentType"]], COLUMNS[accessor["type"]]
        assert view["byteOffset"] % 4 == 0
        assert accessor["count"] * columns * np.dtype(dtype).itemsize == view["byteLength"]
        values = np.frombuffer(self.binary, dtype, accessor["count"] * columns, view["byteOffset"])
        return values.reshape(-1, columns)

    def primitives(self):
        """(mesh name, primitive, positions, normals, triangles) of every primitive."""
        for mesh in self.json["meshes"]:
            for primitive in mesh["primitives"]:
                attributes = primitive["attributes"]
                yield (
                    mesh["name"],
                    primitive,
                    self.accessor(attributes["POSITION"]).astype(float),
                    self.accessor(attributes["NORMAL"]).astype(float),
                    self.accessor(primitive["indices"]).reshape(-1, 3).astype(int),
                )

    def triangle_count(self):
        """Triangles of all placed meshes."""
        counts = [
            sum(self.json["accessors"][p["indices"]]["count"] // 3 for p in mesh["primitives"])
            for mesh in self.json["meshes"]
        ]
        return sum(counts[node["mesh"]] for node in self.json["nodes"] if "mesh" in node)


@pytest.fixture(scope="module")
def glbs():
    """Every scene, encoded once."""
    scenes = [build() for build in SCENES.values()]
    return {
        scene.name: Glb(scene.encode(), None if np.ndim(scene.environment) < 3 else encode_hdr(scene.environment))
        for scene in scenes
    }


def each_scene(test):
    """Run a test once a scene."""
    return pytest.mark.parametrize("name", SCENES)(test)


def open_edges(positions, triangles):
    """Number of directed edges without an opposite one, vertices joined where their positions are equal."""
    _, weld = np.unique(positions, axis=0, return_inverse=True)
    corners = weld.reshape(-1)[triangles]
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    count = corners.max() + 1
    forward = np.sort(edges[:, 0] * count + edges[:, 1])
    backward = np.sort(edges[:, 1] * count + edges[:, 0])
    return int((forward != backward).sum())


def face_normals(positions, triangles):
    """Twice the area, and the unit normal by winding, of each triangle."""
    corners = positions[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1)
    return area, normals / np.maximum(area, 1e-30)[:, None]


def test_another_process_with_another_hash_seed_gives_the_same_bytes(glbs, tmp_path):
    subprocess.run(
        [sys.executable, SCRIPTS / "make_scenes.py", "--out", tmp_path],
        check=True,
        stdout=subprocess.DEVNULL,
        env={"PYTHONHASHSEED": "1"},
    )
    assert {path.stem for path in tmp_path.glob("*.glb")} == set(SCENES)
    for name, glb in glbs.items():
        assert (tmp_path / f"{name}.glb").read_bytes() == glb.data, name
        if glb.environment is not None:
            assert (tmp_path / f"{name}.hdr").read_bytes() == glb.environment, name


@each_scene
def test_accessors_state_their_true_bounds_and_hold_finite_values(glbs, name):
    for index, accessor in enumerate(glbs[name].json["accessors"]):
        values = glbs[name].accessor(index)
        assert np.isfinite(values).all()
        assert (values.min(axis=0) == np.array(accessor["min"], values.dtype)).all()
        assert (values.max(axis=0) == np.array(accessor["max"], values.dtype)).all()


@each_scene
def test_indices_stay_within_their_vertices(glbs, name):
    for mesh, _, positions, _, triangles in glbs[name].primitives():
        assert triangles.max() < len(positions), mesh


@each_scene
def test_normals_are_unit_and_agree_with_the_winding(glbs, name):
    for mesh, _, positions, normals, triangles in glbs[name].primitives():
        assert np.abs(np.linalg.norm(normals, axis=1) - 1).max() < 1e-5, mesh
        area, faces = face_normals(positions, triangles)
        assert area.min() > 0, f"{mesh}: degenerate triangle"
        agreement = np.einsum("ik,ijk->ij", faces, normals[triangles])
        assert agreement.min() > 0.1, f"{mesh}: {agreement.min()}"


@each_scene
def test_glass_solids_are_closed_outward_and_single_sided(glbs, name):
    for mesh, primitive, positions, _, triangles in glbs[name].primitives():
        material = glbs[name].json["materials"][primitive["material"]]
        if "KHR_materials_volume" not in material.get("extensions", {}):
            continue
        assert not material.get("doubleSided"), mesh
        assert open_edges(positions, triangles) == 0, mesh
        a, b, c = (positions[triangles[:, k]] for k in range(3))
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() > 0, f"{mesh}: inside out"


@each_scene
def test_a_place_has_20000_triangles_and_an_analytic_scene_few(glbs, name):
    count = glbs[name].triangle_count()
    assert count <= 25_000 if name in ANALYTIC else 20_000 <= count <= 1_000_000


@each_scene
def test_a_scene_has_a_camera_a_bounce_cap_and_light(glbs, name):
    document = glbs[name].json
    own = document["asset"]["extras"]["restirpg"]
    assert document["cameras"] and 1 <= own["bounces"] <= 32
    assert (
        own.get("environment")
        or "extensions" in document
        or any(max(m.get("emissiveFactor", [0])) > 0 for m in document["materials"])
    )


@each_scene
def test_every_extension_in_use_is_declared(glbs, name):
    document = glbs[name].json
    used = set()

    def walk(value):
        if isinstance(value, dict):
            used.update(value.get("extensions", {}))
            value = value.values()
        if not isinstance(value, str) and hasattr(value, "__iter__"):
            for item in value:
                walk(item)

    walk(document)
    assert used == set(document.get("extensionsUsed", []))


def test_the_diffuse_variant_has_lambert_materials_only(glbs):
    for material in glbs["door_ajar_diffuse"].json["materials"]:
        assert material["pbrMetallicRoughness"]["metallicFactor"] == 0
        assert material["extensions"]["KHR_materials_specular"]["specularFactor"] == 0
        assert "KHR_materials_transmission" not in material["extensions"]


@pytest.mark.parametrize("name", ["door_ajar_animated", "door_ajar_box_light"])
def test_animations_loop(glbs, name):
    (animation,) = glbs[name].json["animations"]
    keys = glbs[name].accessor(animation["samplers"][0]["output"])
    assert np.abs(keys[0] - keys[-1]).max() < 1e-6 and np.ptp(keys, axis=0).max() > 0.1


@pytest.mark.parametrize(
    "mesh",
    [
        shapes.box((0, 0, 0), (1, 2, 3)),
        shapes.rounded_box((0, 0, 0), (1, 2, 3), 0.05, 3),
        shapes.cylinder(1, 2, bevel=0.1),
        shapes.sphere(1),
        shapes.icosphere(1, 2),
        furniture.trefoil_knot(),
        shapes.tube(shapes.bezier([(0, 0, 0), (1, 0, 0), (1, 1, 0)], 12), 0.1),
        implicit.mesh_isosurface(lambda p: np.linalg.norm(p, axis=-1) - 1, (-1.2,) * 3, (1.2,) * 3, 0.1),
    ],
)
def test_solids_are_closed_and_wound_outward(mesh):
    assert open_edges(mesh.positions.astype(np.float32), mesh.triangles) == 0
    _, faces = face_normals(mesh.positions, mesh.triangles)
    assert np.einsum("ik,ijk->ij", faces, mesh.normals[mesh.triangles]).min() > 0.5
    corners = mesh.positions[mesh.triangles]
    assert np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() > 0


def test_the_closedness_check_sees_a_missing_triangle():
    mesh = shapes.icosphere(1, 2)
    assert open_edges(mesh.positions, mesh.triangles[1:]) > 0


@pytest.mark.parametrize("target", [(0, 0, 1), (0, 0, -1), (1, 0.2, 0), (-1, -0.7, 0.3), (0.2, 0.95, 0.1)])
def test_look_at_turns_minus_z_to_the_target_and_keeps_up_upright(target):
    x, y, z, w = look_at((0, 0, 0), target)
    forward = -np.array((2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)))
    right_y = 2 * (x * y + z * w)
    assert np.abs(forward - np.array(target) / np.linalg.norm(target)).max() < 1e-9 and abs(right_y) < 1e-9


def test_png_reads_back(tmp_path):
    image = pytest.importorskip("PIL.Image", reason="Pillow is not installed: nothing else here reads PNG")
    pixels = np.random.default_rng(1).integers(0, 256, (7, 13, 4), np.uint8)
    (tmp_path / "a.png").write_bytes(encode_png(pixels))
    assert (np.array(image.open(tmp_path / "a.png")) == pixels).all()


def test_hdr_scanlines_decode_within_the_shared_exponent_error():
    radiance = np.random.default_rng(2).random((3, 200, 3)) ** 8 * 1e4
    body = encode_hdr(radiance).split(b"\n", 4)[4]
    rows, at = [], 0
    for _ in range(3):
        assert body[at : at + 4] == bytes((2, 2, 0, 200))
        at, row = at + 4, []
        while len(row) < 800:
            count = body[at]
            assert 0 < count <= 128
            row += body[at + 1 : at + 1 + count]
            at += 1 + count
        rows.append(np.array(row).reshape(4, 200).T)
    rgbe = np.array(rows, float)
    decoded = (rgbe[..., :3] + 0.5) * 2.0 ** (rgbe[..., 3:] - 136)
    assert at == len(body)
    assert (np.abs(decoded - radiance) <= radiance.max(axis=2, keepdims=True) / 256 + 1e-12).all()


def test_the_sky_has_its_sun_where_it_was_asked_for():
    sky = textures.sky(40.0, 90.0, width=256)
    row, column = np.unravel_index(sky.sum(axis=2).argmax(), sky.shape[:2])
    assert abs(90 - 180 * (row + 0.5) / 128 - 40) < 2 and abs(360 * ((column + 0.5) / 256 - 0.5) - 90) < 2


def test_parts_placed_twice_share_their_geometry():
    scene, ball = SceneFile("shared", 1), shapes.icosphere(1, 1)
    for material in (lambert("A"), glass("B"), lambert("A")):
        scene.add("Ball", (ball, material))
    document = Glb(scene.encode()).json
    assert len(document["meshes"]) == 2 and len(document["accessors"]) == 4


@pytest.mark.parametrize(
    "arguments", [["no_such_scene"], ["--no-such-option"], ["cornell_box", "--out", "/dev/null/x"]]
)
def test_a_wrong_call_ends_with_one_line_and_exit_code_2(arguments):
    result = subprocess.run([sys.executable, SCRIPTS / "make_scenes.py", *arguments], capture_output=True, text=True)
    assert result.returncode == 2 and len(result.stderr.splitlines()) == 1, result.stderr
