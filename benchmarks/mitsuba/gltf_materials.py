"""The materials of a .glb file as GltfBsdf, and their place in a scene that gltf_to_mitsuba.py made. Import after
set_variant."""

import io
from pathlib import Path

import mitsuba as mi
import numpy as np
from gltf_bsdf import GltfBsdf
from gltf_edits import read_glb
from PIL import Image


def linear_from_srgb(encoded):
    """IEC 61966-2-1, values in [0, 1]."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


class Materials:
    """Reads the materials of one file."""

    def __init__(self, path):
        self.document, self.binary = read_glb(Path(path))
        self.images = {}

    def pixels(self, texture):
        """RGBA in [0, 1] of a textureInfo's image."""
        source = self.document["textures"][texture["index"]]["source"]
        if source not in self.images:
            view = self.document["bufferViews"][self.document["images"][source]["bufferView"]]
            start = view.get("byteOffset", 0)
            image = Image.open(io.BytesIO(self.binary[start : start + view["byteLength"]]))
            self.images[source] = np.asarray(image.convert("RGBA"), np.float32) / 255
        return self.images[source]

    def texture(self, info, values):
        """A Mitsuba texture of float values (H, W, 1 or 3) with a textureInfo's sampler and transform."""
        sampler = self.document["textures"][info["index"]].get("sampler")
        settings = self.document["samplers"][sampler] if sampler is not None else {}
        if (settings.get("wrapS", 10497), settings.get("wrapT", 10497)) != (10497, 10497):
            raise SystemExit("gltf_materials.py: only textures that repeat are known")
        transform = info.get("extensions", {}).get("KHR_texture_transform", {})
        cosine, sine = np.cos(transform.get("rotation", 0)), np.sin(transform.get("rotation", 0))
        to_uv = np.eye(4)
        to_uv[:2, :2] = np.array([[cosine, sine], [-sine, cosine]]) @ np.diag(transform.get("scale", [1, 1]))
        to_uv[:2, 3] = transform.get("offset", [0, 0])
        return mi.load_dict(
            {
                "type": "bitmap",
                "bitmap": mi.Bitmap(np.ascontiguousarray(values, np.float32)),
                "raw": True,
                "to_uv": mi.ScalarTransform4f(to_uv),
                "wrap_mode": "repeat",
                "filter_type": "nearest" if settings.get("magFilter") == 9728 else "bilinear",
            }
        )

    def number(self, factor, info, channel):
        """A factor, or its product with a channel of a texture."""
        return (
            float(factor)
            if info is None
            else self.texture(info, factor * self.pixels(info)[..., channel : channel + 1])
        )

    def color(self, factor, info):
        """The same of an sRGB texture."""
        factor = [float(value) for value in factor]
        return (
            factor
            if info is None
            else self.texture(info, linear_from_srgb(self.pixels(info)[..., :3]) * np.array(factor))
        )

    def arguments(self, index):
        """GltfBsdf's arguments for a material (None: glTF's default material)."""
        material = self.document["materials"][index] if index is not None else {}
        extensions, pbr = material.get("extensions", {}), material.get("pbrMetallicRoughness", {})
        base, base_map = pbr.get("baseColorFactor", [1, 1, 1, 1]), pbr.get("baseColorTexture")
        rough_map = pbr.get("metallicRoughnessTexture")
        specular = extensions.get("KHR_materials_specular", {})
        transmission = extensions.get("KHR_materials_transmission", {})
        made = {
            "base": self.color(base[:3], base_map),
            "metallic": self.number(pbr.get("metallicFactor", 1), rough_map, 2),
            "roughness": self.number(pbr.get("roughnessFactor", 1), rough_map, 1),
            "specular": self.number(specular.get("specularFactor", 1), specular.get("specularTexture"), 3),
            "specular_color": self.color(
                specular.get("specularColorFactor", [1, 1, 1]), specular.get("specularColorTexture")
            ),
            "transmission": self.number(
                transmission.get("transmissionFactor", 0), transmission.get("transmissionTexture"), 0
            ),
            "ior": float(extensions.get("KHR_materials_ior", {}).get("ior", 1.5)),
            "solid": extensions.get("KHR_materials_volume", {}).get("thicknessFactor", 0) > 0
            and transmission.get("transmissionFactor", 0) > 0,
        }
        if material.get("alphaMode", "OPAQUE") != "OPAQUE":  # BLEND is a mask with a cutoff of 0.5 in the renderer
            made["alpha_cutoff"] = float(material.get("alphaCutoff", 0.5)) if material["alphaMode"] == "MASK" else 0.5
            made["alpha"] = self.number(base[3], base_map, 3)
        if "normalTexture" in material:
            info = material["normalTexture"]
            made |= {
                "normal": self.texture(info, self.pixels(info)[..., :3]),
                "normal_scale": float(info.get("scale", 1)),
            }
        return made

    def medium(self, index):
        """The absorbing inside of a solid, or None."""
        volume = (self.document["materials"][index] if index is not None else {}).get("extensions", {})
        volume = volume.get("KHR_materials_volume", {})
        if volume.get("thicknessFactor", 0) <= 0 or "attenuationDistance" not in volume:
            return None
        sigma = -np.log(np.maximum(volume.get("attenuationColor", [1, 1, 1]), 1e-6)) / volume["attenuationDistance"]
        return {
            "type": "homogeneous",
            "albedo": 0.0,
            "sigma_t": {"type": "rgb", "value": [float(value) for value in sigma]},
        }


def put_materials(scene, path, literal):
    """Replace the materials of the converter's scene dictionary by the file's own; `volpath` where something absorbs or
    is masked.

    literal: as GltfBsdf has it.
    """
    materials = Materials(path)
    exact, volumes = {}, False
    for name in [key for key in scene if key.startswith("mat_")]:
        index = name.split("_")[1]
        index = None if index == "None" else int(index)
        del scene[name]
        arguments = materials.arguments(index)
        medium = materials.medium(index)
        volumes |= medium is not None or "alpha_cutoff" in arguments
        exact[f"m{index}_{name.split('_')[2]}"] = GltfBsdf(**arguments, literal=literal), medium
    for shape in scene.values():
        if isinstance(shape, dict) and shape.get("type") == "ply":
            bsdf, medium = exact[shape["bsdf"]["id"]]
            shape["bsdf"] = bsdf
            if medium is not None:
                shape["interior"] = medium
    if volumes:
        scene["integrator"]["type"] = "volpath"
