#!/usr/bin/python3
"""Write lights.glb: a Lambert room lit by a textured emitter, a point, a directional and a spot light.

    light_scene.py FOLDER

For compare_with_mitsuba.py. Mitsuba's spot falls off linearly in the angle, glTF's with the square in the cosine: a
black shroud stops the spot's light where they differ, and lets out only what leaves within the inner cone.
"""

import argparse
import math
import sys
from pathlib import Path

import clone  # noqa: F401
import numpy as np
from gltf_edits import read_glb, write_glb

from restirpg.harness import program
from restirpg.scenes import shapes
from restirpg.scenes.gltf import SceneFile, Texture, emitter, lambert, look_at


def room():
    """The room with its textured emitter, and the shroud of the spot: a black box about (0.7, 1.8, 0.3)."""
    scene = SceneFile("lights", 4, environment=(0.1, 0.12, 0.15))
    white = lambert("White", (0.7, 0.7, 0.7))
    scene.add("Floor", (shapes.quad((-1.5, 0, 1.5), (3, 0, 0), (0, 0, -3)), white))
    scene.add("Back", (shapes.quad((-1.5, 0, -1.5), (3, 0, 0), (0, 2, 0)), lambert("Rust", (0.6, 0.2, 0.1))))
    scene.add("Left", (shapes.quad((-1.5, 0, 1.5), (0, 0, -3), (0, 2, 0)), white))
    scene.add("Box", (shapes.box((-0.3, 0, -0.3), (0.3, 0.8, 0.3)).turned("y", 25), white))
    squares = np.kron(np.array([[255, 30, 120], [90, 200, 10]], np.uint8), np.ones((8, 8), np.uint8))
    pixels = np.stack([squares, squares[::-1], squares[:, ::-1]], axis=2)
    panel = emitter("Panel", (5.0, 4.0, 3.0), emission_texture=Texture(pixels))
    scene.add("Panel", (shapes.quad((-1.2, 0.5, -1.4), (0.9, 0, 0), (0, 0.6, 0)), panel))
    black = lambert("Black", (0.0, 0.0, 0.0))
    scene.add("Shroud", (shapes.box((0.5, 1.6, 0.1), (0.9, 1.9, 0.5)), black))
    scene.add_camera((0.3, 1.1, 3.6), (0, 0.7, 0), 40.0)
    return scene


def add_lights(document):
    """Append a point, a directional and a spot light."""
    cone = {"innerConeAngle": math.radians(70), "outerConeAngle": math.radians(85)}
    lights = [
        ("point", (-0.9, 1.5, 0.9), (0, 0, 0), 0.6, {}),
        ("directional", (2.0, 3.0, 2.0), (0, 0, 0), 0.5, {}),
        ("spot", (0.7, 1.8, 0.3), (0.7, 0.0, 0.3001), 2.0, {"spot": cone}),
    ]
    document["extensions"] = {
        "KHR_lights_punctual": {
            "lights": [
                {"type": kind, "intensity": intensity, "color": [1, 0.8, 0.6], **extra}
                for kind, _, _, intensity, extra in lights
            ]
        }
    }
    for index, (kind, position, target, _, _) in enumerate(lights):
        document["scenes"][0]["nodes"].append(len(document["nodes"]))
        document["nodes"].append(
            {
                "name": kind,
                "translation": list(position),
                "rotation": list(look_at(position, target)),
                "extensions": {"KHR_lights_punctual": {"light": index}},
            }
        )
    document["extensionsUsed"] = sorted({*document.get("extensionsUsed", []), "KHR_lights_punctual"})
    return document


def open_below(document, binary, name):
    """Drop the triangles of a mesh whose vertices all have the normal (0, -1, 0)."""
    primitive = next(mesh for mesh in document["meshes"] if mesh["name"] == name)["primitives"][0]

    def values(index, dtype, columns):
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(binary, dtype, accessor["count"] * columns, start).reshape(-1, columns), start

    normals, _ = values(primitive["attributes"]["NORMAL"], "<f4", 3)
    indices, start = values(primitive["indices"], "<u2", 1)
    triangles = indices.reshape(-1, 3)
    kept = triangles[(normals[triangles][..., 1] > -0.9).any(axis=1)].astype("<u2")
    document["accessors"][primitive["indices"]]["count"] = kept.size
    return binary[:start] + kept.tobytes() + binary[start + kept.nbytes :]


def main():
    """Write the scene to the folder given. Returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder

    def body(_):
        path = room().write(folder)
        document, binary = read_glb(path)
        print(write_glb(path, add_lights(document), open_below(document, binary, "Shroud")))
        return 0

    return program.run("light_scene.py", body)


if __name__ == "__main__":
    sys.exit(main())
