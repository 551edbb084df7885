"""A wet street at night: lit windows, lanterns and strings of bulbs."""

import math

import numpy as np

from . import architecture, furniture, shapes, textures
from .gltf import Material, SceneFile, emitter, lambert, metal

HALF_WIDTH = 3.6  # from the street's middle to the house fronts, m
KERB = 2.3  # from the street's middle to the pavement's edge, m
STOREY = 3.0
END = -40.0  # the street runs from z = 6 to here


def _ground(scene):
    """Wet cobbles between two pavements."""
    wet = Material("WetCobbles", (1.0,) * 3, roughness=0.16,
                   normal_texture=textures.normals_of(textures.tile_relief(512, 8, 91), 5.0),
                   texture=textures.tiles((0.075, 0.075, 0.08), (0.03,) * 3, 8, 92, variation=0.5))
    road = shapes.room_quad((-KERB, 0, 8), (2 * KERB, 0, 0), (0, 0, END - 8))
    scene.add("Road", (road, wet))
    flags = Material("Flagstones", (1.0,) * 3, roughness=0.35,
                     texture=textures.tiles((0.20, 0.19, 0.18), (0.08,) * 3, 3, 93))
    width = HALF_WIDTH - KERB
    slabs = [shapes.rounded_box((x, -0.1, END), (x + width, 0.13, 8), 0.02) for x in (-HALF_WIDTH, KERB)]
    scene.add("Pavements", (shapes.join(*slabs), flags))


def _house(scene, side, front, width, storeys, random, palette):
    """A house front on x = side * HALF_WIDTH from z = `front` to `front` - `width`, windows lit or dark."""
    plaster, trim, frame, dark, lit = palette
    height = STOREY * storeys + 0.6
    corner = (side * HALF_WIDTH, 0.0, front if side < 0 else front - width)
    along = (0, 0, -width if side < 0 else width)
    bays = max(2, int(width / 1.7))
    centers = [width * (k + 0.5) / bays for k in range(bays)]
    door = int(random.integers(bays))
    openings = [(c - 0.45, c + 0.45, STOREY * s + 0.95, STOREY * s + 2.45) for s in range(1, storeys)
                for c in centers]
    openings += [(c - 0.5, c + 0.5, 0.13, 2.4) if k == door else (c - 0.6, c + 0.6, 0.8, 2.4)
                 for k, c in enumerate(centers)]
    parts = [architecture.wall(corner, along, height, openings)]
    parts += [architecture.reveal(corner, along, opening, 0.18) for opening in openings]
    node = scene.add("House", (shapes.join(*parts), plaster))
    panes = {}
    bars, sills = [], []
    for k, (left, right, bottom, top) in enumerate(openings):
        is_door = k == len(openings) - bays + door
        shop = k >= len(openings) - bays and not is_door
        finish = frame if is_door else lit[int(random.integers(len(lit)))] if random.random() < (
            0.75 if shop else 0.42) else dark
        panes.setdefault(finish, []).append((left, right, bottom, top))
        if not is_door:
            middle = (left + right) / 2
            bars += [(middle - 0.02, middle + 0.02, bottom, top), (left, right, bottom + 0.95, bottom + 0.99)]
            sills.append((left - 0.08, right + 0.08, bottom - 0.07, bottom + 0.01))

    def block(left, right, bottom, top, back, out):
        """A block on the front: from `back` behind it to `out` before it."""
        z = sorted((corner[2] + math.copysign(left, along[2]), corner[2] + math.copysign(right, along[2])))
        x = sorted((side * (HALF_WIDTH + back), side * (HALF_WIDTH - out)))
        return shapes.rounded_box((x[0], bottom, z[0]), (x[1], top, z[1]), 0.008)

    for finish, rectangles in panes.items():
        quads = []
        for left, right, bottom, top in rectangles:
            start = np.array(corner) + (side * 0.15, bottom, math.copysign(left, along[2]))
            quads.append(
                shapes.quad(start, (0, 0, math.copysign(right - left, along[2])), (0, top - bottom, 0)))
        scene.add("Panes", (shapes.join(*quads), finish), parent=node)
    scene.add("Bars", (shapes.join(*(block(*bar, 0.16, -0.10) for bar in bars)), frame), parent=node)
    mouldings = [block(*sill, 0.05, 0.10) for sill in sills]
    mouldings += [block(0, width, STOREY * s + 0.1, STOREY * s + 0.25, 0.05, 0.06) for s in range(1, storeys)]
    mouldings += [block(0, width, height - 0.25, height, 0.1, 0.25)]
    scene.add("Mouldings", (shapes.join(*mouldings), trim), parent=node)


def _houses(scene):
    """Both rows of houses, and one that closes the street."""
    random = np.random.default_rng(94)
    colors = ((0.50, 0.32, 0.20), (0.42, 0.40, 0.35), (0.45, 0.22, 0.17), (0.30, 0.36, 0.36), (0.55, 0.46,
                                                                                               0.28))
    plasters = [
        lambert(f"Plaster{k}", texture=textures.plaster(c, 95 + k, contrast=0.3))
        for k, c in enumerate(colors)
    ]
    bricks = lambert("Brick",
                     texture=textures.bricks((0.33, 0.14, 0.09), (0.22, 0.20, 0.18), 96),
                     texture_scale=(0.5, 0.5))
    trim = Material("StoneTrim", (0.48, 0.45, 0.40), roughness=0.7)
    frames = [Material(f"Paint{k}", c, roughness=0.35) for k, c in enumerate(
        ((0.05, 0.10, 0.08), (0.14, 0.03, 0.03), (0.30, 0.28, 0.24)))]
    dark = Material("DarkPane", (0.012, 0.014, 0.018), roughness=0.04)
    lit = [emitter(f"Window{k}", c, emission_texture=textures.curtained_window(97 + k)) for k, c in enumerate(
        ((2.4, 1.5, 0.7), (1.5, 1.0, 0.5), (2.8, 2.1, 1.2), (0.8, 1.0, 1.4), (1.8, 0.8, 0.35)))]
    for side in (-1, 1):
        z, k = 6.0, 0 if side < 0 else 3
        while z > END:
            width = float(random.uniform(4.0, 7.0))
            walls = bricks if k % 4 == 2 else plasters[k % 5]
            _house(scene, side, z, width, int(random.integers(2, 5)), random,
                   (walls, trim, frames[k % 3], dark, lit))
            z, k = z - width, k + 1
    closing = architecture.wall((-HALF_WIDTH - 1, 0, END), (2 * HALF_WIDTH + 2, 0, 0), 9.0)
    scene.add("ClosingWall", (closing, bricks))


def _lanterns(scene):
    """Street lamps along both kerbs: four-sided glowing lanterns on turned posts."""
    iron = Material("Iron", (0.03, 0.03, 0.032), roughness=0.4, metallic=0.6)
    outline = [(0, 0), (0.13, 0), (0.12, 0.25), (0.06, 0.35), (0.045, 1.2), (0.06, 1.25), (0.035, 1.3),
               (0.03, 2.9), (0.08, 3.0), (0.02, 3.05), (0, 3.05)]
    post = shapes.lathe(furniture.rounded_outline(outline, 1), 24)
    roof = shapes.lathe([(0, 3.42), (0.21, 3.42), (0.05, 3.6), (0.015, 3.7), (0, 3.7)], 24)
    glow = shapes.lathe([(0, 3.06), (0.09, 3.06), (0.15, 3.41), (0, 3.41)], 8, crease=10).faceted()
    light = emitter("Lantern", (42.0, 26.0, 11.0))
    for k in range(7):
        side = 1 if k % 2 else -1
        at = (side * (KERB + 0.3), 0.13, 2.2 - 5.6 * k)
        scene.add("LampPost", (post, iron), (roof, iron), at=at)
        scene.add("Lantern", (glow, light), at=at)


def _strings(scene):
    """Strings of coloured bulbs from house to house, and shop awnings below."""
    cable = lambert("Cable", (0.02, 0.02, 0.02))
    bulb = shapes.icosphere(0.035, 1)
    colors = ((30.0, 17.0, 6.0), (26.0, 6.0, 3.0), (6.0, 22.0, 8.0), (5.0, 10.0, 28.0), (28.0, 22.0, 14.0))
    lights = [emitter(f"Bulb{k}", c) for k, c in enumerate(colors)]
    for k in range(12):
        z, sag = -0.6 - 3.1 * k, 0.7 + 0.25 * math.sin(2.3 * k)
        t = np.linspace(-1, 1, 27)
        slant = 0.8 * math.sin(1.7 * k)
        path = np.stack([HALF_WIDTH * t, 5.1 + 0.4 * math.cos(k) - sag * (1 - t * t), z + slant * t], -1)
        scene.add("String", (shapes.tube(path, 0.008, 6), cable))
        places = path[1:-1] - (0, 0.05, 0)
        for c in range(5):
            scene.add("Bulbs", (shapes.copies(bulb, places[c::5]), lights[c]))
    striped = [Material(f"Awning{k}", c, roughness=0.8, double_sided=True) for k, c in enumerate(
        ((0.45, 0.05, 0.04), (0.06, 0.22, 0.12), (0.50, 0.36, 0.10)))]
    awning = shapes.surface(
        lambda u, v: np.stack(
            [0.95 * (1 - v), 2.55 + 0.55 * v - 0.05 * np.sin(20 * math.pi * u) * (1 - v), 1.8 *
             (u - 0.5)], -1), 80, 6)
    for k, (side, z) in enumerate(((-1, 1.0), (1, -2.5), (-1, -8.2), (1, -11.0), (-1, -15.0), (1, -19.0))):
        placed = awning if side < 0 else awning.turned("y", 180)
        scene.add("Awning", (placed.moved(side * HALF_WIDTH, 0, z), striped[k % 3]))


def _tables(scene):
    """A cafe's tables and chairs on the pavement."""
    top = Material("MarbleTop", (0.55, 0.54, 0.52), roughness=0.12)
    steel = metal("Steel", (0.56, 0.57, 0.58), 0.3)
    chair = furniture.chair()
    wood = Material("ChairWood", (0.20, 0.10, 0.05), roughness=0.4)
    cloth = lambert("SeatCloth", (0.30, 0.05, 0.05))
    column = [(0, 0), (0.2, 0), (0.2, 0.02), (0.03, 0.05), (0.025, 0.69), (0, 0.69)]
    stand = shapes.lathe(column, 32)
    slab = shapes.cylinder(0.32, 0.03, 48, 0.006).moved(0, 0.69, 0)
    for k, z in enumerate((0.8, -1.0, -7.6, -9.0)):
        x = -HALF_WIDTH + 0.62
        scene.add("CafeTable", (slab, top), (stand, steel), at=(x, 0.13, z))
        for s in (-1, 1):
            placed = {part: mesh.turned("y", 90 + 90 * s + 13 * k) for part, mesh in chair.items()}
            scene.add("CafeChair", (placed["wood"], wood), (placed["cushion"], cloth),
                      at=(x, 0.13, z + 0.55 * s))


def night_street():
    """Wet street at night: hundreds of windows, lanterns and bulbs, most of them far or hidden."""
    scene = SceneFile("night_street", 6, environment=(0.006, 0.009, 0.018))
    _ground(scene)
    _houses(scene)
    _lanterns(scene)
    _strings(scene)
    _tables(scene)
    scene.add_camera((0.5, 1.65, 5.2), (-0.35, 2.05, -6.0), 52.0)
    return scene


FAMILY = (night_street,)
