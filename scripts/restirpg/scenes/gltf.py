"""Writing glTF 2.0 binary files: the materials, lights, cameras and node animation that the renderer reads.

Units are glTF's: metres, radians, +y up; radiance in W/sr/m^2, linear sRGB. Equal calls give equal bytes.
"""

import functools
import json
import math
import struct
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from restirpg.harness import files

from .images import encode_hdr, encode_png

FLOAT, UINT16, UINT32 = 5126, 5123, 5125
VERTEX_BUFFER, INDEX_BUFFER = 34962, 34963
NEAREST, LINEAR, LINEAR_MIPMAP_LINEAR = 9728, 9729, 9987


@dataclass(frozen=True, eq=False)
class Texture:
    """An 8-bit image (H, W, 3 or 4), rows from the top; sRGB when used as a colour. Repeats."""

    pixels: np.ndarray
    nearest: bool = False  # no filtering: crisp texels

    @functools.cached_property
    def png(self):
        """Bytes of the image's PNG file."""
        return encode_png(self.pixels)


@dataclass(frozen=True)
class Material:
    """glTF metallic-roughness with the KHR extensions that the renderer supports. Colours are linear sRGB.

    `specular` 0 with `metallic` 0 is exactly Lambert. `thickness` > 0 makes a transmissive material a solid.
    """

    name: str
    color: tuple = (0.8, 0.8, 0.8)
    roughness: float = 0.8
    metallic: float = 0.0
    specular: float = 1.0
    emission: tuple = (0.0, 0.0, 0.0)  # radiance, W/sr/m^2
    transmission: float = 0.0
    ior: float = 1.5
    thickness: float = 0.0
    attenuation_color: tuple = (1.0, 1.0, 1.0)
    attenuation_distance: float = math.inf  # m
    double_sided: bool = False
    alpha_cutoff: float | None = None  # the surface is absent where the texture's alpha is below
    texture: Texture | None = None  # base colour, multiplies `color`
    texture_scale: tuple = (1.0, 1.0)  # KHR_texture_transform of the base colour
    roughness_texture: Texture | None = None  # roughness in g, metallic in b
    normal_texture: Texture | None = None
    emission_texture: Texture | None = None  # multiplies `emission`


def lambert(name, color=(1.0, 1.0, 1.0), **options):
    """A material without any specular reflection."""
    return Material(name, tuple(color), roughness=1.0, specular=0.0, **options)


def metal(name, color, roughness):
    """A conductor: reflectance `color` at normal incidence; roughness 0 is a perfect mirror."""
    return Material(name, tuple(color), roughness=roughness, metallic=1.0)


def glass(name, ior=1.5, roughness=0.0, tint=(1.0, 1.0, 1.0), tint_distance=math.inf):
    """A solid dielectric; `tint` is the transmittance over `tint_distance` metres. Only for closed meshes."""
    return Material(name, (1.0, 1.0, 1.0), roughness=roughness, transmission=1.0, ior=ior, thickness=1.0,
                    attenuation_color=tuple(tint), attenuation_distance=tint_distance)


def as_given(material):
    """The material itself."""
    return material


def as_lambert(material):
    """The material's Lambert counterpart: its colour, without any specular reflection or transmission."""
    return replace(material, metallic=0.0, roughness=1.0, specular=0.0, transmission=0.0, thickness=0.0,
                   roughness_texture=None, normal_texture=None)


def as_polished(material):
    """The material under a smooth finish: specular, of at most a quarter of its roughness."""
    if max(material.emission) > 0:
        return material
    return replace(material, specular=1.0, roughness=0.25 * material.roughness)


def emitter(name, radiance, **options):
    """A light that reflects nothing and emits `radiance` from its front side."""
    return lambert(name, (0.0, 0.0, 0.0), emission=tuple(radiance), **options)


def rotation(axis, degrees):
    """Quaternion (x, y, z, w) of a turn about an axis."""
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    half = math.radians(degrees) / 2
    return (*(axis * math.sin(half)).tolist(), math.cos(half))


def look_at(position, target, up=(0.0, 1.0, 0.0)):
    """Quaternion that turns -z towards `target`, as glTF cameras and lights look."""
    z = np.subtract(position, target).astype(float)
    z /= np.linalg.norm(z)
    x = np.cross(up, z)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    w = math.sqrt(max(1.0 + x[0] + y[1] + z[2], 0.0)) / 2
    if w > 1e-3:
        return ((y[2] - z[1]) / (4 * w), (z[0] - x[2]) / (4 * w), (x[1] - y[0]) / (4 * w), w)
    if x[0] >= max(y[1], z[2]):  # half a turn: the trace vanishes, so start from the largest diagonal entry
        s = 2 * math.sqrt(1.0 + x[0] - y[1] - z[2])
        return (s / 4, (x[1] + y[0]) / s, (z[0] + x[2]) / s, (y[2] - z[1]) / s)
    if y[1] >= z[2]:
        s = 2 * math.sqrt(1.0 + y[1] - x[0] - z[2])
        return ((x[1] + y[0]) / s, s / 4, (y[2] + z[1]) / s, (z[0] - x[2]) / s)
    s = 2 * math.sqrt(1.0 + z[2] - x[0] - y[1])
    return ((z[0] + x[2]) / s, (y[2] + z[1]) / s, s / 4, (x[1] - y[0]) / s)


@dataclass
class SceneFile:
    """A scene under construction; `write` saves it. `environment`: radiance (r, g, b) or image (H, W, 3)."""

    name: str
    bounces: int
    environment: object = None
    finish: Callable[[Material], Material] = as_given  # applied to every material, for variants of a scene
    _json: dict = field(default_factory=dict)
    _binary: bytearray = field(default_factory=bytearray)
    _cache: dict = field(default_factory=dict)  # key -> (index, the object the key names, kept alive)
    _extensions: set = field(default_factory=set)

    def _append(self, kind, value):
        self._json.setdefault(kind, []).append(value)
        return len(self._json[kind]) - 1

    def _once(self, key, owner, make):
        """Index of what `make` appends, made once a key. Holding `owner` keeps its id() from being reused."""
        if key not in self._cache:
            self._cache[key] = (make(), owner)
        return self._cache[key][0]

    def _view(self, data, target=None):
        self._binary += b"\0" * (-len(self._binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self._binary), "byteLength": len(data)}
        if target:
            view["target"] = target
        self._binary += data
        return self._append("bufferViews", view)

    def _accessor(self, values, target=None):
        values = np.ascontiguousarray(values)
        component = {"f": FLOAT, "u": UINT16 if values.itemsize == 2 else UINT32}[values.dtype.kind]
        columns = 1 if values.ndim == 1 else values.shape[1]
        table = values.reshape(len(values), columns)
        return self._append(
            "accessors", {
                "bufferView": self._view(values.tobytes(), target), "componentType": component, "count":
                len(values), "type": "SCALAR" if values.ndim == 1 else f"VEC{columns}", "min":
                table.min(axis=0).tolist(), "max": table.max(axis=0).tolist()
            })

    def _texture(self, texture):
        def make():
            filters = ({"magFilter": NEAREST, "minFilter": NEAREST} if texture.nearest
                       else {"magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR})
            sampler = self._once(("sampler", texture.nearest), None,
                                 lambda: self._append("samplers", filters))
            image = self._append("images", {"bufferView": self._view(texture.png),
                                            "mimeType": "image/png"})
            return self._append("textures", {"sampler": sampler, "source": image})
        return {"index": self._once(("texture", id(texture)), texture, make)}

    def _material(self, material):
        material = self.finish(material)
        return self._once(("material", material), material, lambda: self._append(
            "materials", self._material_json(material)))

    def _material_json(self, m):
        pbr = {"baseColorFactor": [*map(float, m.color), 1.0], "metallicFactor": m.metallic,
               "roughnessFactor": m.roughness}
        extensions = {}
        if m.texture:
            pbr["baseColorTexture"] = self._texture(m.texture)
            if m.texture_scale != (1.0, 1.0):
                self._extensions.add("KHR_texture_transform")
                pbr["baseColorTexture"]["extensions"] = {
                    "KHR_texture_transform": {"scale": list(m.texture_scale)}
                }
        if m.roughness_texture:
            pbr["metallicRoughnessTexture"] = self._texture(m.roughness_texture)
        out = {"name": m.name, "pbrMetallicRoughness": pbr}
        if m.normal_texture:
            out["normalTexture"] = self._texture(m.normal_texture)
        if max(m.emission) > 0:
            strength = max(m.emission)
            out["emissiveFactor"] = [e / strength for e in m.emission]
            extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
            if m.emission_texture:
                out["emissiveTexture"] = self._texture(m.emission_texture)
        if m.specular != 1.0:
            extensions["KHR_materials_specular"] = {"specularFactor": m.specular}
        if m.ior != 1.5:
            extensions["KHR_materials_ior"] = {"ior": m.ior}
        if m.transmission > 0:
            extensions["KHR_materials_transmission"] = {"transmissionFactor": m.transmission}
        if m.thickness > 0:
            volume = {"thicknessFactor": m.thickness}
            if math.isfinite(m.attenuation_distance):
                volume |= {
                    "attenuationDistance": m.attenuation_distance, "attenuationColor":
                    list(m.attenuation_color)
                }
            extensions["KHR_materials_volume"] = volume
        if m.double_sided:
            out["doubleSided"] = True
        if m.alpha_cutoff is not None:
            out |= {"alphaMode": "MASK", "alphaCutoff": m.alpha_cutoff}
        if extensions:
            self._extensions.update(extensions)
            out["extensions"] = extensions
        return out

    def _primitive(self, mesh, material):
        def make():
            index_type = np.uint16 if len(mesh.positions) < 65536 else np.uint32
            return ({"POSITION": self._accessor(mesh.positions.astype(np.float32), VERTEX_BUFFER),
                     "NORMAL": self._accessor(mesh.normals.astype(np.float32), VERTEX_BUFFER),
                     "TEXCOORD_0": self._accessor(mesh.uvs.astype(np.float32), VERTEX_BUFFER)},
                    self._accessor(mesh.triangles.astype(index_type).ravel(), INDEX_BUFFER))
        attributes, indices = self._once(("geometry", id(mesh)), mesh, make)
        return {"attributes": attributes, "indices": indices, "material": self._material(material)}

    def add(self, name, *parts, at=None, turn=None, scale=None, parent=None):
        """Add a node; returns its index. `parts`: (Mesh, Material) pairs; `turn`: a quaternion.

        The same parts (by identity) placed again share one mesh.
        """
        node = {"name": name}
        if parts:
            key = ("mesh", *((id(mesh), material) for mesh, material in parts))
            node["mesh"] = self._once(key, parts, lambda: self._append("meshes", {
                "name": name, "primitives": [self._primitive(*part) for part in parts]}))
        return self._add_node(node, at, turn, scale, parent)

    def _add_node(self, node, at, turn, scale=None, parent=None):
        if at is not None:
            node["translation"] = [float(x) for x in at]
        if turn is not None:
            node["rotation"] = [float(x) for x in turn]
        if scale is not None:
            node["scale"] = [float(scale)] * 3
        index = self._append("nodes", node)
        if parent is None:
            self._json.setdefault("scenes", [{"nodes": []}])[0]["nodes"].append(index)
        else:
            self._json["nodes"][parent].setdefault("children", []).append(index)
        return index

    def add_camera(self, position, target, yfov=40.0, name="Camera", up=(0.0, 1.0, 0.0)):
        """Add a perspective camera. `yfov`: vertical field of view in degrees."""
        camera = self._append("cameras", {"name": name, "type": "perspective",
                                          "perspective": {"yfov": math.radians(yfov), "znear": 0.01}})
        return self._add_node({"name": name, "camera": camera}, position, look_at(position, target, up))

    def add_spot(self, name, position, target, intensity, inner=15.0, outer=25.0, up=(0.0, 0.0, 1.0)):
        """Add a spot light (KHR_lights_punctual). `intensity`: (r, g, b), W/sr; half cone angles, degrees."""
        self._extensions.add("KHR_lights_punctual")
        strength = max(intensity)
        lights = (self._json.setdefault("extensions", {})
                  .setdefault("KHR_lights_punctual", {"lights": []})["lights"])
        lights.append({
            "name": name, "type": "spot", "color": [i / strength for i in intensity], "intensity": strength,
            "spot": {"innerConeAngle": math.radians(inner), "outerConeAngle": math.radians(outer)}
        })
        return self._add_node(
            {"name": name, "extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}}, position,
            look_at(position, target, up))

    def animate(self, node, path, times, values, interpolation="LINEAR"):
        """Animate "translation" or "rotation" of a node through keys at `times` (s); "STEP" jumps at them."""
        if "animations" not in self._json:
            self._append("animations", {"name": "Loop", "samplers": [], "channels": []})
        animation = self._json["animations"][0]
        animation["samplers"].append({"input": self._accessor(np.asarray(times, np.float32)),
                                      "output": self._accessor(np.asarray(values, np.float32)),
                                      "interpolation": interpolation})
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1,
                                      "target": {"node": node, "path": path}})

    def encode(self):
        """Bytes of the .glb file."""
        extras = {"bounces": self.bounces}
        if self.environment is not None:
            constant = np.ndim(self.environment) == 1
            extras["environment"] = list(map(float, self.environment)) if constant else f"{self.name}.hdr"
        document = {"asset": {"version": "2.0", "generator": "restirpg make_scenes.py",
                              "extras": {"restirpg": extras}},
                    "scene": 0, **self._json, "buffers": [{"byteLength": len(self._binary)}]}
        if self._extensions:
            document["extensionsUsed"] = sorted(self._extensions)
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        binary = bytes(self._binary) + b"\0" * (-len(self._binary) % 4)
        return (struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(binary)) +
                struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") +
                binary)

    def write(self, folder):
        """Write NAME.glb, and NAME.hdr where the environment is an image. Returns the .glb's path."""
        if self.environment is not None and np.ndim(self.environment) == 3:
            files.write(folder / f"{self.name}.hdr", encode_hdr(self.environment))
        path = folder / f"{self.name}.glb"
        files.write(path, self.encode())
        return path
