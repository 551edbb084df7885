"""Edits of .glb files that make two renderers agree on what a material is."""

import json
import struct

import numpy as np


def read_glb(path):
    """The JSON document (dict) and binary chunk (bytes) of a .glb file."""
    data = path.read_bytes()
    try:
        (length,) = struct.unpack_from("<I", data, 12)
        document = json.loads(data[20 : 20 + length])
    except (struct.error, ValueError):
        raise OSError(f"{path}: no .glb file; give one, or pack the .gltf into one") from None
    return document, data[20 + length + 8 :]


def write_glb(path, document, binary):
    """Write a .glb file from its JSON document and binary chunk; returns `path`."""
    from restirpg.harness import files  # Mitsuba's Python, which has not this package, reads alone

    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    files.write(
        path,
        struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary))
        + struct.pack("<I4s", len(text), b"JSON")
        + text
        + struct.pack("<I4s", len(binary), b"BIN\0")
        + binary,
    )
    return path


def make_diffuse(document):
    """Rewrite every material as exactly Lambert and opaque: both renderers then mean the same by it.

    Base colour, its texture, emission and sidedness stay. What the renderers define differently goes: vertex normals
    (the directions between the hemispheres of shading and geometric normal) and alpha masks (glTF thresholds the
    filtered texture, the converter lets Mitsuba filter the thresholded one).
    """
    kept = ("KHR_materials_emissive_strength", "KHR_materials_unlit")
    for material in document.get("materials", []):
        pbr = material.setdefault("pbrMetallicRoughness", {})
        pbr.pop("metallicRoughnessTexture", None)
        pbr.update(metallicFactor=0.0, roughnessFactor=1.0)
        material.pop("normalTexture", None)
        material["alphaMode"] = "OPAQUE"
        extensions = {name: value for name, value in material.get("extensions", {}).items() if name in kept}
        material["extensions"] = extensions | {"KHR_materials_specular": {"specularFactor": 0.0}}
    for mesh in document.get("meshes", []):
        for primitive in mesh["primitives"]:
            primitive["attributes"].pop("NORMAL", None)
            primitive["attributes"].pop("TANGENT", None)
    document["extensionsUsed"] = sorted({*document.get("extensionsUsed", []), "KHR_materials_specular"})
    return document


def environment_settings(document):
    """The renderer's own settings in a document, a dictionary: environment, strength, rotation ..."""
    return document.get("asset", {}).get("extras", {}).get("restirpg", {})


def environment_of(document):
    """The scene's own environment: None, a list of three numbers, or a file name."""
    return environment_settings(document).get("environment")


def environment_for_mitsuba(radiance):
    """An equirectangular image (H, W, 3) resampled so that Mitsuba's `envmap` interpolates it to the same function.

    Mitsuba puts the first and last row on the poles, not half a texel from them, and starts u half a turn away. On
    2H + 1 rows the piecewise linear function in v is the same exactly; near the poles it is constant, as under
    clamp-to-edge.
    """
    height, width = radiance.shape[:2]
    at = np.arange(2 * height + 1) / 2 - 0.5
    low = np.clip(np.floor(at), 0, height - 1).astype(int)
    high = np.clip(np.ceil(at), 0, height - 1).astype(int)
    rows = 0.5 * (radiance[low] + radiance[high])
    return np.roll(rows, width // 2, axis=1).astype(np.float32)
