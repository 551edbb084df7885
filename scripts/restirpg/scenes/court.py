"""A courtyard lit by sun and sky: arcades in shadow beside walls in full sun."""

import math

import numpy as np

from . import architecture, furniture, shapes, textures
from .gltf import Material, SceneFile, glass, lambert, metal, rotation

MODULE, ARCHES, DEPTH, TOP = 1.6, 5, 0.36, 3.3  # an arcade's bay, bays a side, pillar depth, wall height (m)
HALF = MODULE * ARCHES / 2
AISLE = 1.9  # depth of the covered walk, m


def _arcade(scene, name, turn, stone, plaster, wood):
    """One side: arches on the court, the walk behind, an upper storey with shuttered windows."""
    side = scene.add(name, turn=rotation((0, 1, 0), turn))
    bay = architecture.arch(1.2, 1.85, TOP, DEPTH, (MODULE - 1.2) / 2)
    centers = [-HALF + MODULE * (k + 0.5) for k in range(ARCHES)]
    scene.add("Arches", (shapes.copies(bay, [(x, 0, -HALF - DEPTH / 2) for x in centers]), plaster),
              parent=side)
    impost = shapes.rounded_box((-0.23, 1.80, -DEPTH / 2 - 0.03), (0.23, 1.90, DEPTH / 2 + 0.03), 0.02, 2)
    foot = shapes.rounded_box((-0.24, 0, -DEPTH / 2 - 0.04), (0.24, 0.16, DEPTH / 2 + 0.04), 0.02, 2)
    piers = [(-HALF + MODULE * k, 0, -HALF - DEPTH / 2) for k in range(ARCHES + 1)]
    scene.add("Imposts", (shapes.copies(shapes.join(impost, foot), piers), stone), parent=side)
    back = -HALF - DEPTH - AISLE
    outer = HALF + DEPTH + AISLE
    scene.add("Walk", (shapes.join(
        architecture.wall((-outer, 0, back), (2 * outer, 0, 0), TOP),
        shapes.room_quad((-outer, TOP - 0.25, back), (2 * outer, 0, 0),
                         (0, 0, -HALF - DEPTH - back))), plaster),
              parent=side)
    windows = [(x + HALF - 0.4, x + HALF + 0.4, 0.55, 1.85) for x in centers]
    corner = (-HALF, TOP, -HALF)
    upper = [architecture.wall(corner, (2 * HALF, 0, 0), 2.6, windows)]
    upper += [architecture.reveal(corner, (2 * HALF, 0, 0), window, 0.16) for window in windows]
    scene.add("UpperStorey", (shapes.join(*upper), plaster), parent=side)
    sills = [
        shapes.rounded_box((x - 0.48, TOP + 0.47, -HALF - 0.15), (x + 0.48, TOP + 0.55, -HALF + 0.07), 0.01)
        for x in centers
    ]
    string = shapes.rounded_box((-HALF - 0.02, TOP - 0.08, -HALF), (HALF + 0.02, TOP + 0.04, -HALF + 0.08),
                                0.02, 2)
    cornice = shapes.rounded_box((-HALF - 0.02, TOP + 2.45, -HALF), (HALF + 0.02, TOP + 2.65, -HALF + 0.22),
                                 0.04, 3)
    scene.add("Mouldings", (shapes.join(string, cornice, *sills), stone), parent=side)
    scene.add("Shutters", (_shutters(centers), wood), parent=side)
    scene.add("Roof", (_roof_tiles(), lambert("Terracotta", (0.45, 0.19, 0.10))), parent=side)
    scene.add("RoofSlab", (shapes.room_quad((-outer, TOP + 2.64, -HALF), (2 * outer, 0, 0),
                                            (0, 0, back + HALF)), plaster),
              parent=side)


def _shutters(centers):
    """Louvred leaves in every window of the upper storey."""
    leaf = [shapes.rounded_box((x, 0, 0), (x + 0.05, 1.28, 0.03), 0.004) for x in (0.0, 0.34)]
    leaf += [shapes.rounded_box((0.05, y, 0), (0.34, y + 0.05, 0.03), 0.004) for y in (0.0, 0.615, 1.23)]
    louvre = shapes.box((0.05, -0.025, -0.004), (0.34, 0.025, 0.004)).turned("x", 35)
    leaf += [
        louvre.moved(0, y, 0.015)
        for y in np.concatenate([np.arange(0.09, 0.6, 0.045),
                                 np.arange(0.70, 1.22, 0.045)])
    ]
    leaf = shapes.join(*leaf)
    return shapes.copies(leaf,
                         [(x + dx, TOP + 0.56, -HALF - 0.12) for x in centers for dx in (-0.395, 0.005)])


def _roof_tiles():
    """The ends of the roof's hollow tiles along the eaves."""
    def point(u, v):
        return np.stack([-0.10 * np.cos(math.pi * (1 - u)), 0.10 * np.sin(math.pi * (1 - u)), 0.25 - 0.5 * v],
                        -1)

    tile = shapes.surface(point, 8, 1)
    rows = [(x, TOP + 2.64 + 0.12 * k, -HALF + 0.08 - 0.4 * k) for k in range(3)
            for x in np.arange(-HALF, HALF + 0.01, 0.22)]
    return shapes.copies(tile, rows)


def _fountain(scene, stone):
    """An octagonal basin of water around a tazza."""
    wall = [(1.02, 0), (1.12, 0), (1.12, 0.08), (1.05, 0.12), (1.05, 0.42), (1.14, 0.46), (1.14, 0.54),
            (0.90, 0.54), (0.90, 0.12), (0, 0.12)]
    basin = shapes.lathe(wall, 8, crease=10).faceted()
    stem = furniture.rounded_outline([(0, 0.1), (0.20, 0.1), (0.22, 0.2), (0.10, 0.35), (0.08, 0.7),
                                      (0.14, 0.85), (0.07, 0.92), (0.30, 1.02), (0.52, 1.16), (0.55, 1.22),
                                      (0.50, 1.22), (0.25, 1.10), (0, 1.06)])
    scene.add("Fountain", (basin, stone), (shapes.lathe(stem, 64), stone))
    water = glass("Water", ior=1.33, tint=(0.55, 0.80, 0.78), tint_distance=0.5)
    scene.add("Water", (_rippled_disc(0.895, 0.13, 0.44), water), (_rippled_disc(0.24, 1.102, 1.18), water))
    bronze = metal("Bronze", (0.50, 0.36, 0.20), 0.3)
    scene.add("Finial", (furniture.egg(0.2), bronze), at=(0, 1.06, 0))


def _rippled_disc(radius, bottom, top, segments=48):
    """A closed drum of water whose top has faint rings."""
    r = np.linspace(radius, 0, 40)
    surface = np.stack([r, top + 0.0025 * np.sin(40 * r) * (r < radius)], -1)
    surface[0, 1] = top
    return shapes.lathe(np.concatenate([[(0, bottom), (radius, bottom)], surface]), segments)


def _pots(scene):
    """Terracotta pots with leafy plants along the arcades."""
    pot = shapes.lathe([(0, 0), (0.17, 0), (0.25, 0.36), (0.29, 0.36), (0.29, 0.43), (0.25, 0.43),
                        (0.23, 0.36), (0, 0.36)], 48)
    clay = Material("Clay", (0.50, 0.22, 0.12), roughness=0.85)
    soil = lambert("Stems", (0.10, 0.07, 0.03))
    leaf = Material("Leaf", (1.0,) * 3,
                    roughness=0.45,
                    double_sided=True,
                    alpha_cutoff=0.5,
                    texture=textures.leaf())
    plants = [furniture.plant(seed, 130, 0.5, 1.1) for seed in (41, 42)]
    places = ((-3.4, -3.3), (-1.6, -3.45), (1.6, -3.45), (3.4, -3.3), (-3.45, 0.8), (3.45, 0), (-3.45, -1.6))
    for k, (x, z) in enumerate(places):
        plant = plants[k % 2]
        scene.add("Plant", (pot, clay), (plant["stems"].moved(0, 0.36, 0), soil),
                  (plant["leaves"].moved(0, 0.36, 0), leaf),
                  at=(x, 0, z),
                  turn=rotation((0, 1, 0), 77 * k))


def sky_court():
    """Courtyard under sun and sky, with arcades, water, leaves: an environment to be importance sampled."""
    sky = 0.45 * textures.sky(46.0, 128.0)
    scene = SceneFile("sky_court", 6, environment=sky)
    stone = Material("Limestone", (1.0,) * 3,
                     roughness=0.7,
                     texture=textures.plaster((0.62, 0.56, 0.46), 51, contrast=0.5))
    plaster = lambert("Ochre", texture=textures.plaster((0.70, 0.50, 0.30), 52, contrast=0.3))
    wood = Material("ShutterPaint", (0.06, 0.20, 0.17), roughness=0.5)
    floor = Material("Paving", (1.0,) * 3,
                     roughness=0.55,
                     texture=textures.tiles((0.50, 0.40, 0.30), (0.22, 0.19, 0.15)),
                     texture_scale=(0.6, 0.6))
    scene.add("Paving", (shapes.room_quad((-9, 0, 9), (18, 0, 0), (0, 0, -18)), floor))
    for name, turn in (("North", 0), ("West", 90), ("East", -90)):
        _arcade(scene, name, turn, stone, plaster, wood)
    _fountain(scene, stone)
    _pots(scene)
    scene.add_camera((2.3, 1.65, 6.3), (-0.35, 1.65, -1.0), 48.0)
    return scene


FAMILY = (sky_court,)
