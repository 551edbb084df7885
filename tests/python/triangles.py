"""The triangles of a small glTF binary in world space, and rays cast at all of them: an oracle for where
paths may have been.

For files of scripts/make_scenes.py without rotation or animation; brute force, so for some hundred triangles.
"""

import json
import struct
from dataclasses import dataclass

import numpy as np


@dataclass
class Triangles:
    """`corners` (n, 3, 3), m; `emissive` (n,); `material` (n,): index in the file."""

    corners: np.ndarray
    emissive: np.ndarray
    material: np.ndarray

    @property
    def center(self):
        """Of the bounding sphere as the renderer takes it: the bounding box's."""
        points = self.corners.reshape(-1, 3)
        return (points.min(0) + points.max(0)) / 2

    @property
    def radius(self):
        points = self.corners.reshape(-1, 3)
        return np.linalg.norm(np.ptp(points, axis=0)) / 2

    @property
    def normals(self):
        n = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        return n / np.linalg.norm(n, axis=-1, keepdims=True)

    def distances(self, points):
        """Distance of points (m, 3) from the nearest triangle's plane within it, and that triangle, (m,)."""
        best, which = np.full(len(points), np.inf), np.zeros(len(points), int)
        for t, (corner, normal) in enumerate(zip(self.corners, self.normals)):
            offset = (points - corner[0]) @ normal
            sides = [
                np.cross(corner[(i + 1) % 3] - corner[i], points - offset[:, None] * normal - corner[i]) @ normal
                for i in range(3)
            ]
            away = np.where(np.min(sides, 0) > -1e-4, np.abs(offset), np.inf)
            which, best = np.where(away < best, t, which), np.minimum(away, best)
        return best, which

    def cast(self, origins, directions):
        """Distance along rays (m, 3) to the nearest triangle, and that triangle (-1: none), (m,).  [Moeller &
        Trumbore 1997]"""
        best, which = np.full(len(origins), np.inf), np.full(len(origins), -1)
        for t, (a, b, c) in enumerate(self.corners):
            p = np.cross(directions, c - a)
            with np.errstate(divide="ignore", invalid="ignore"):
                inverse = 1 / (p @ (b - a))
                u = ((origins - a) * p).sum(-1) * inverse
                q = np.cross(origins - a, b - a)
                v, distance = (directions * q).sum(-1) * inverse, q @ (c - a) * inverse
            hit = (u >= -1e-6) & (v >= -1e-6) & (u + v <= 1 + 1e-6) & (distance > 1e-4) & (distance < best)
            best, which = np.where(hit, distance, best), np.where(hit, t, which)
        return best, which


def load_triangles(file):
    """The Triangles of a .glb."""
    data = file.read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    gltf, binary = json.loads(data[20 : 20 + size]), data[28 + size :]

    def array(index):
        accessor = gltf["accessors"][index]
        view = gltf["bufferViews"][accessor["bufferView"]]
        dtype = np.dtype({5123: "<u2", 5125: "<u4", 5126: "<f4"}[accessor["componentType"]])
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(binary, dtype, accessor["count"] * width, start).reshape(-1, width)

    corners, emissive, material = [], [], []
    for node in gltf["nodes"]:
        if "mesh" not in node:
            continue
        assert "rotation" not in node and "matrix" not in node and "scale" not in node
        for primitive in gltf["meshes"][node["mesh"]]["primitives"]:
            points = array(primitive["attributes"]["POSITION"]).astype(float) + node.get("translation", (0, 0, 0))
            mine = points[array(primitive["indices"]).reshape(-1, 3)]
            corners.append(mine)
            emission = gltf["materials"][primitive["material"]].get("emissiveFactor", (0, 0, 0))
            emissive += [any(emission)] * len(mine)
            material += [primitive["material"]] * len(mine)
    return Triangles(np.concatenate(corners), np.array(emissive), np.array(material))
