"""A glass pavilion beside a pool, under sun and sky."""

import math

import numpy as np

from . import furniture, shapes, textures
from .gltf import Material, SceneFile, glass, lambert, metal, rotation

POOL = (-6.5, -1.0, 0.6, 4.6)  # x from, to, z from, to; m
ROOF = (-3.2, 6.6, -4.6, 0.4)  # the same of the roof slab
PODIUM, CEILING = 0.3, 3.2  # heights of the floor and of the roof's underside, m


def _podium(scene):
    """Travertine around the pool, the pool's basin and its water, and the lawn around it all."""
    stone = Material("Travertine", (1.0,) * 3, roughness=0.4,
                     texture=textures.tiles((0.60, 0.53, 0.42), (0.30, 0.26, 0.20), 2, 101, variation=0.12),
                     texture_scale=(0.5, 0.5))
    x0, x1, z0, z1 = -9.0, 8.0, -6.5, 6.5
    a, b, c, d = POOL
    blocks = [shapes.box((x0, -0.5, z0), (x1, PODIUM, c)), shapes.box((x0, -0.5, d), (x1, PODIUM, z1)),
              shapes.box((x0, -0.5, c), (a, PODIUM, d)), shapes.box((b, -0.5, c), (x1, PODIUM, d))]
    scene.add("Podium", (shapes.join(*blocks), stone))
    pebbles = lambert("Pebbles", texture=textures.plaster((0.16, 0.19, 0.17), 102, contrast=1.2))
    scene.add("PoolFloor", (shapes.room_quad((a, -0.45, d), (b - a, 0, 0), (0, 0, c - d)), pebbles))
    scene.add("Water", (_water(), glass("PoolWater", ior=1.33, tint=(0.62, 0.86, 0.84), tint_distance=1.2)))
    grass = lambert("Lawn", texture=textures.plaster((0.10, 0.17, 0.05), 103, contrast=0.9))
    scene.add("Lawn", (shapes.room_quad((-40, -0.001, 40), (80, 0, 0), (0, 0, -80)), grass))


def _water(columns=96, rows=64):
    """A closed block of water, a hair inside the basin, whose top has small waves."""
    a, b, c, d = POOL[0] + 1e-3, POOL[1] - 1e-3, POOL[2] + 1e-3, POOL[3] - 1e-3
    bottom, level = -0.448, PODIUM - 0.12

    def wave(u, v):
        x, z = a + (b - a) * u, d + (c - d) * v
        shore = np.sin(math.pi * np.clip(u, 0, 1)) * np.sin(math.pi * np.clip(v, 0, 1))
        height = np.sin(5.1 * x + 2.3 * z) + np.sin(-3.7 * x + 6.1 * z +
                                                    1) + 0.6 * np.sin(9.3 * x - 4.9 * z + 2)
        return np.stack([x, level + 0.004 * height * np.minimum(1, 4 * shore) * (shore > 1e-9), z], -1)

    top = shapes.surface(wave, columns, rows)
    xs, zs = np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1)
    rims = [wave(xs, np.zeros_like(xs)), wave(np.ones_like(zs), zs), wave(xs[::-1], np.ones_like(xs)),
            wave(np.zeros_like(zs), zs[::-1])]
    sides = []
    for rim, normal in zip(rims, ((0, 0, 1.0), (1.0, 0, 0), (0, 0, -1.0), (-1.0, 0, 0))):
        foot = rim * (1, 0, 1) + (0, bottom, 0)
        sides.append(shapes.Mesh(np.concatenate([foot, rim]), np.tile(normal, (2 * len(rim), 1)),
                                 np.concatenate([foot, rim])[:, :2], shapes.grid_triangles(2, len(rim))))
    base = top.positions * (1, 0, 1) + (0, bottom, 0)
    floor = shapes.Mesh(base, np.tile((0.0, -1.0, 0.0), (len(base), 1)), top.uvs, top.triangles[:, ::-1])
    return shapes.join(top, floor, *sides)


def _structure(scene):
    """Roof slab on cross-shaped chrome columns, marble walls, and panes of glass."""
    x0, x1, z0, z1 = ROOF
    white = lambert("RoofWhite", (0.80, 0.79, 0.76))
    scene.add("RoofSlab", (shapes.rounded_box((x0, CEILING, z0), (x1, CEILING + 0.28, z1), 0.01), white))
    chrome = metal("Chrome", (0.75, 0.76, 0.77), 0.08)
    height = CEILING - PODIUM
    cross = shapes.join(shapes.rounded_box((-0.09, 0, -0.022), (0.09, height, 0.022), 0.01, 2),
                        shapes.rounded_box((-0.022, 0, -0.09), (0.022, height, 0.09), 0.01, 2))
    places = [(x, PODIUM, z) for x in (-2.4, 0.3, 3.0, 5.7) for z in (-3.8, -0.4)]
    scene.add("Columns", (shapes.copies(cross, places), chrome))
    onyx = Material("Onyx", (1.0,) * 3,
                    roughness=0.1,
                    texture=textures.marble((0.62, 0.30, 0.12), (0.85, 0.62, 0.36), 104))
    verde = Material("GreenMarble", (1.0,) * 3, roughness=0.12,
                     texture=textures.marble((0.03, 0.10, 0.07), (0.32, 0.45, 0.36), 105))
    scene.add("OnyxWall", (shapes.box((0.9, PODIUM, -2.62), (4.4, CEILING, -2.44)).with_uvs(0.4), onyx))
    scene.add("GreenWall", (shapes.box((-8.4, PODIUM, -4.3), (-1.2, CEILING, -4.12)).with_uvs(0.4), verde))
    scene.add("EndWall", (shapes.box((6.0, PODIUM, -4.5), (6.18, CEILING, 0.2)).with_uvs(0.4), verde))
    pane = Material("ThinGlass", (1.0,) * 3, roughness=0.0, transmission=1.0, double_sided=True)
    panes = [shapes.quad((x, PODIUM, -0.02), (1.78, 0, 0), (0, height, 0)) for x in (0.4, 2.2, 4.0)]
    panes += [shapes.quad((x, PODIUM, -4.4), (1.78, 0, 0), (0, height, 0)) for x in (-1.0, 0.8, 2.6, 4.2)]
    scene.add("Panes", (shapes.join(*panes), pane))
    mullions = [
        shapes.rounded_box((x - 0.02, PODIUM, z - 0.03), (x + 0.02, CEILING, z + 0.03), 0.004)
        for z, xs in ((-0.02, (0.39, 2.19, 3.99, 5.79)), (-4.4, (-1.01, 0.79, 2.59, 4.39, 5.99))) for x in xs
    ]
    scene.add("Mullions", (shapes.join(*mullions), chrome))


def _furniture(scene):
    """Low chairs and a glass table before the onyx wall, a bronze knot by the pool, planting behind."""
    leather = Material("WhiteLeather", (0.75, 0.72, 0.66), roughness=0.4)
    chrome = metal("ChairChrome", (0.75, 0.76, 0.77), 0.08)
    seat = furniture.sofa(0.95, 0.85)
    for x, turn in ((1.5, 12), (2.75, -4), (3.95, -16)):
        scene.add("Chair", (seat["frame"], leather), (seat["seat"], leather), (seat["feet"], chrome),
                  at=(x, PODIUM, -1.75), turn=rotation((0, 1, 0), turn))
    slab = shapes.rounded_box((-0.5, 0.40, -0.35), (0.5, 0.418, 0.35), 0.004)
    legs = shapes.join(*(shapes.tube([(sx * 0.4, 0, sz * 0.26), (-sx * 0.4, 0.399, -sz * 0.26)], 0.012)
                         for sx in (-1, 1) for sz in (-1, 1)))
    scene.add("GlassTable", (slab, glass("TableGlass", tint=(0.75, 0.92, 0.85), tint_distance=0.1)),
              (legs, chrome),
              at=(2.2, PODIUM, -0.75))
    scene.add("Teapot", (furniture.teapot(), metal("Silver", (0.95, 0.93, 0.88), 0.1)),
              at=(2.1, PODIUM + 0.4185, -0.72),
              turn=rotation((0, 1, 0), 150),
              scale=0.8)
    carpet = lambert("Carpet", texture=textures.woven((0.05, 0.05, 0.055), 106))
    scene.add("Carpet", (shapes.rounded_box((0.9, PODIUM, -2.3),
                                            (4.6, PODIUM + 0.015, -0.25), 0.004).with_uvs(3.0), carpet))
    plinth = shapes.rounded_box((-0.3, 0, -0.3), (0.3, 0.7, 0.3), 0.01)
    travertine = Material("Plinth", (0.60, 0.54, 0.44), roughness=0.5)
    scene.add("Plinth", (plinth, travertine), at=(-7.5, PODIUM, -2.4))
    scene.add("Sculpture", (furniture.trefoil_knot(0.16, 0.07), metal("Bronze", (0.55, 0.38, 0.20), 0.25)),
              at=(-7.5, PODIUM + 1.22, -2.4))
    hedge = lambert("Hedge", texture=textures.plaster((0.035, 0.075, 0.02), 108, contrast=1.6))
    blocks = [shapes.rounded_box(low, high, 0.3, 3) for low, high in (
        ((-38, 0, -15), (38, 2.6, -13)), ((14, 0, -13), (16, 2.2, 30)), ((-18, 0, -13), (-16, 2.2, 30)),
        ((-38, 0, -27), (10, 4.6, -24)), ((2, 0, -33), (38, 6.0, -29)))]
    scene.add("Hedges", (shapes.join(*blocks), hedge))
    leaf = Material("Leaf", (1.0,) * 3,
                    roughness=0.45,
                    double_sided=True,
                    alpha_cutoff=0.5,
                    texture=textures.leaf())
    stems = lambert("Stems", (0.12, 0.09, 0.05))
    shrub = furniture.plant(107, 260, 1.0, 2.4)
    for k in range(14):
        at = (-9.5 + 1.35 * k + 0.3 * math.sin(3 * k), 0, -7.6 - 0.5 * math.cos(2 * k))
        scene.add("Shrub", (shrub["stems"], stems), (shrub["leaves"], leaf),
                  at=at,
                  turn=rotation((0, 1, 0), 51 * k),
                  scale=1.1 + 0.3 * math.sin(k))


def glass_pavilion():
    """Pavilion of glass and polished stone by a pool, under sun and sky: long chains of reflections."""
    scene = SceneFile("glass_pavilion", 9, environment=0.45 * textures.sky(38.0, 205.0))
    _podium(scene)
    _structure(scene)
    _furniture(scene)
    scene.add_camera((-5.6, 1.75, 7.6), (0.6, 1.35, -1.2), 42.0)
    return scene


FAMILY = (glass_pavilion,)
