"""What only a picture shows of a scene's file: sixteen quads under one directional light, each with its exact radiance.

Nothing here is random but the place of the sample in its pixel: a Lambert surface of albedo a, lit by an irradiance of
pi along the unit vector d, has the radiance a (n . -d).
"""

import base64
import json
import math
import struct
import zlib

import numpy as np
import pytest
from furnace_scenes import run_means
from renderer_scenes import make_renderer, restirpg, write_outside

ALBEDO = 0.8
TO_LIGHT = np.array([0.3, 0.4, math.sqrt(0.75)])
TEXEL = (190, 90, 230)  # of the normal map, everywhere
MAPPED = np.array(TEXEL) / 255 * 2 - 1
FLAT = ALBEDO * TO_LIGHT[2]
NORMAL_MAP = {"normalTexture": {"index": 0}}


def mapped_radiance(tangent, bitangent):
    """Radiance of a quad that faces +z with the normal map, whose image's right and top point along these."""
    normal = MAPPED[0] * np.array(tangent) + MAPPED[1] * np.array(bitangent) + MAPPED[2] * np.array([0, 0, 1])
    return ALBEDO * normal @ TO_LIGHT / np.linalg.norm(normal)


def turned(degrees, right=1, up=1):
    """Tangent and bitangent of a quad scaled by (right, up, 1), then turned about z."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return (right * c, right * s, 0), (-up * s, up * c, 0)


class Quads:
    """Builds the file: each quad in its cell of a 4 x 4 grid, all in the plane z = 0."""

    def __init__(self):
        self.bytes = bytearray()
        self.expected = []
        self.document = {
            "asset": {"version": "2.0"},
            "accessors": [],
            "bufferViews": [],
            "meshes": [],
            "materials": [],
            "nodes": [],
            "skins": [],
        }

    def view(self, data):
        self.document["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data + bytes(-len(data) % 4)
        return len(self.document["bufferViews"]) - 1

    def accessor(self, rows, kind, component=5126):
        code = {5126: "f", 5121: "B", 5125: "I"}[component]
        data = struct.pack(f"<{sum(map(len, rows))}{code}", *(value for row in rows for value in row))
        self.document["accessors"].append(
            {"bufferView": self.view(data), "componentType": component, "count": len(rows), "type": kind}
        )
        return len(self.document["accessors"]) - 1

    def add(
        self, expected, half=0.45, node=None, material=None, mirrored_uv=False, attributes=None, targets=None, **mesh
    ):
        """A quad in the next cell; returns its node, to be changed."""
        cell = len(self.expected)
        self.expected.append(expected)
        corners = [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)]
        uv = [(0, 1), (1, 1), (1, 0), (0, 0)]
        primitive = {
            "attributes": {
                "POSITION": self.accessor(corners, "VEC3"),
                "NORMAL": self.accessor([(0, 0, 1)] * 4, "VEC3"),
                "TEXCOORD_0": self.accessor([(1 - u, v) if mirrored_uv else (u, v) for u, v in uv], "VEC2"),
                **{name: self.accessor(*value) for name, value in (attributes or {}).items()},
            },
            "indices": self.accessor([(0, 1, 2, 0, 2, 3)], "SCALAR", 5125),
            "material": len(self.document["materials"]),
        }
        self.document["accessors"][primitive["indices"]]["count"] = 6
        if targets:
            primitive["targets"] = [{"POSITION": self.accessor(targets, "VEC3")}]
        material = dict(material or {})
        base = material.pop("base", [ALBEDO] * 3 + [1])
        self.document["materials"].append(
            {
                "pbrMetallicRoughness": {"baseColorFactor": base, "metallicFactor": 0},
                "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
                **material,
            }
        )
        self.document["meshes"].append({"primitives": [primitive], **mesh})
        place = [cell % 4 - 1.5, 1.5 - cell // 4, 0]
        self.document["nodes"].append({"mesh": len(self.document["meshes"]) - 1, "translation": place, **(node or {})})
        return self.document["nodes"][-1]

    def write(self, file):
        header = struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)
        image = b"\x89PNG\r\n\x1a\n"
        for kind, data in ((b"IHDR", header), (b"IDAT", zlib.compress(bytes([0, *TEXEL]))), (b"IEND", b"")):
            image += struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        document = self.document
        document["images"] = [{"bufferView": self.view(image), "mimeType": "image/png"}]
        document["textures"] = [{"source": 0}]
        document["buffers"] = [
            {"byteLength": len(self.bytes), "uri": "data:;base64," + base64.b64encode(self.bytes).decode()}
        ]
        document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 2 * math.atan(2 / 50), "znear": 1}}]
        # A light shines along its node's -z: turn z to the light.
        axis, angle = np.cross([0, 0, 1], TO_LIGHT), math.acos(TO_LIGHT[2])
        axis = axis / np.linalg.norm(axis) * math.sin(angle / 2)
        document["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": math.pi}]}}
        document["nodes"] += [
            {"camera": 0, "translation": [0, 0, 50]},
            {"rotation": [*axis, math.cos(angle / 2)], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ]
        file.write_text(json.dumps(document))
        return file


def turn(degrees):
    return [0, 0, math.sin(math.radians(degrees) / 2), math.cos(math.radians(degrees) / 2)]


def all_quads():
    quads = Quads()
    tangents = {"TANGENT": ([(1, 0, 0, 1)] * 4, "VEC4")}
    quads.add(mapped_radiance(*turned(0)), material=NORMAL_MAP)
    quads.add(mapped_radiance(*turned(0, -1)), material=NORMAL_MAP, node={"scale": [-1, 1, 1]})
    quads.add(mapped_radiance(*turned(0, -1)), material=NORMAL_MAP, node={"scale": [-1, 1, 1]}, attributes=tangents)
    quads.add(mapped_radiance(*turned(0, 1, -1)), material=NORMAL_MAP, node={"scale": [1, -1, 1]})
    quads.add(mapped_radiance(*turned(180)), material=NORMAL_MAP, node={"scale": [-1, -1, 1]}, attributes=tangents)
    quads.add(mapped_radiance(*turned(90, -1)), material=NORMAL_MAP, node={"scale": [-1, 1, 1], "rotation": turn(90)})
    quads.add(mapped_radiance(*turned(0, -1)), material=NORMAL_MAP, mirrored_uv=True)
    quads.add(mapped_radiance(*turned(0)), material=NORMAL_MAP, mirrored_uv=True, node={"scale": [-1, 1, 1]})
    colours = lambda *value: {"COLOR_0": ([value] * 4, f"VEC{len(value)}")}  # noqa: E731
    quads.add(0, material={"alphaMode": "MASK"}, attributes=colours(1, 1, 1, 0.2))
    quads.add(FLAT / 2, material={"alphaMode": "MASK", "alphaCutoff": 0.8}, attributes=colours(0.5, 0.5, 0.5, 0.8))
    quads.add(FLAT, attributes=colours(2, 2, 2))
    quads.add(TO_LIGHT[2], material={"base": [5, 5, 5, 1]})
    quads.add(FLAT, node={"scale": [1, 1, 0]})
    quads.add(
        FLAT,
        half=4.5,
        node={"skin": 0},
        attributes={"JOINTS_0": ([(0, 0, 0, 0)] * 4, "VEC4", 5121), "WEIGHTS_0": ([(1, 0, 0, 0)] * 4, "VEC4")},
    )
    quads.add(FLAT, node={"translation": [0.5, -1.5, 100]}, targets=[(0, 0, -200)] * 4, weights=[0.5])
    quads.add(0, node={"scale": [0, 0, 0]})
    joint = {"scale": [0.1] * 3, "translation": [-0.5, -1.5, 0]}
    quads.document["nodes"].append(joint)
    quads.document["skins"] = [{"joints": [len(quads.document["nodes"]) - 1]}]
    return quads


@pytest.mark.parametrize("backend", ["software", "rayquery"])
def test_each_quad_has_its_radiance(tmp_path, backend):
    quads = all_quads()
    renderer = make_renderer(restirpg.load_scene(quads.write(tmp_path / "quads.gltf")), size=(16, 16), backend=backend)
    renderer.set_everywhere("bounces", 0)
    renderer.render(4)
    picture = renderer.output("image")[..., 0].reshape(4, 4, 4, 4)
    inner = picture[:, 1:3, :, 1:3].mean(axis=(1, 3))
    np.testing.assert_allclose(inner.ravel(), quads.expected, rtol=2e-3, atol=1e-6)
    # The quads differ: a cell taken for another would be seen.
    assert len({round(value, 3) for value in quads.expected}) >= 7


def half_masked_lamp(file):
    """A lamp over a wall; half of it is taken away by the alpha of its corners."""
    quads = Quads()
    quads.add(0, half=2)
    corners = [(1, 1, 1, 0), (1, 1, 1, 1), (1, 1, 1, 1), (1, 1, 1, 0)]
    lamp = {"base": [0, 0, 0, 1], "alphaMode": "MASK", "emissiveFactor": [1, 1, 1]}
    facing_the_wall = {"translation": [-1.5, 1.5, 0.6], "rotation": [0, 1, 0, 0]}
    quads.add(0, node=facing_the_wall, material=lamp, attributes={"COLOR_0": (corners, "VEC4")})
    quads.write(file)
    document = json.loads(file.read_text())
    document["nodes"].pop()  # the directional light
    del document["extensions"]
    file.write_text(json.dumps(document))
    return file


def test_a_lamp_gives_no_light_from_where_a_mask_has_taken_it_away(tmp_path):
    """Null hypothesis: emitter sampling and scattering alone have one expected image mean. 24 independent runs each, 4
    standard errors of Welch's difference: a false alarm of 0.02%. Emitter sampling that does not see the mask doubles
    the light."""
    file = half_masked_lamp(tmp_path / "lamp.gltf")
    sampled, found = (run_means(file, 24, 32, seed=seed, bounces=0, nee=nee) for seed, nee in enumerate((True, False)))
    error = np.sqrt((sampled.var(ddof=1) + found.var(ddof=1)) / 24)
    assert error < 0.05 * found.mean() and abs(sampled.mean() - found.mean()) < 4 * error


def test_a_scene_reads_outside_of_its_folder_only_where_that_is_allowed(tmp_path):
    inside = all_quads().write(tmp_path / "quads.gltf")
    outside = write_outside(inside)
    with pytest.raises(restirpg.Error, match="lies outside of the scene's folder"):
        restirpg.load_scene(outside)
    allowed = restirpg.load_scene(outside, allow_outside=True)
    assert allowed.triangles == restirpg.load_scene(inside).triangles
