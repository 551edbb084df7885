"""Door ajar: a room lit only through a slightly open door. E. Veach's difficulty, in our own design."""

import math

import numpy as np

from . import furniture, shapes, textures
from .architecture import reveal, skirting, wall
from .gltf import (
    Material,
    SceneFile,
    as_given,
    as_lambert,
    as_polished,
    emitter,
    glass,
    lambert,
    metal,
    rotation,
)

# The front room, and a back room behind a wall 0.14 m thick, that holds the lamp; metres.
LEFT, RIGHT, BACK, FRONT, HEIGHT = -2.3, 2.3, -2.2, 2.9, 2.7
WALL, FAR = 0.14, -5.0
DOORWAY = (0.75, 1.65, 0.0, 2.05)  # left, right, bottom, top, from the left wall
TABLE_TOP = 0.72


def _rooms(scene):
    """Shell of both rooms, with the doorway's lining and the skirting boards."""
    paint = Material("WallPaint", (1.0, 1.0, 1.0), roughness=0.9, specular=0.5,
                     texture=textures.plaster((0.74, 0.69, 0.60)))
    back_paint = lambert("BackRoomPaint", (0.78, 0.74, 0.66))
    ceiling = lambert("Ceiling", (0.80, 0.79, 0.76))
    floor = Material("Floor", (1.0, 1.0, 1.0),
                     roughness=0.28,
                     texture=textures.checker((0.035, 0.035, 0.04), (0.70, 0.66, 0.58)),
                     texture_scale=(1.25, 1.25))
    width, depth = RIGHT - LEFT, FRONT - BACK
    behind = BACK - WALL
    scene.add("Floor", (shapes.room_quad((LEFT, 0, FRONT), (width, 0, 0), (0, 0, FAR - FRONT)), floor))
    scene.add("Ceiling", (shapes.join(
        shapes.quad((LEFT, HEIGHT, BACK), (width, 0, 0), (0, 0, depth)),
        shapes.quad((LEFT, HEIGHT, FAR), (width, 0, 0), (0, 0, behind - FAR))), ceiling))
    scene.add("Walls", (shapes.join(
        wall((LEFT, 0, BACK), (width, 0, 0), HEIGHT, [DOORWAY]),
        reveal((LEFT, 0, BACK), (width, 0, 0), DOORWAY, WALL, sill=False),
        wall((LEFT, 0, FRONT), (0, 0, -depth), HEIGHT), wall((RIGHT, 0, BACK), (0, 0, depth), HEIGHT),
        wall((RIGHT, 0, FRONT), (-width, 0, 0), HEIGHT)), paint))
    mirrored = (width - DOORWAY[1], width - DOORWAY[0], *DOORWAY[2:])
    scene.add("BackRoom", (shapes.join(wall(
        (RIGHT, 0, behind), (-width, 0, 0), HEIGHT, [mirrored]), wall(
            (LEFT, 0, FAR), (width, 0, 0), HEIGHT), wall(
                (LEFT, 0, behind),
                (0, 0, FAR - behind), HEIGHT), wall((RIGHT, 0, FAR),
                                                    (0, 0, behind - FAR), HEIGHT)), back_paint))
    gap = (LEFT + DOORWAY[0] - 0.08, LEFT + DOORWAY[1] + 0.08)
    woodwork = Material("Woodwork", (0.74, 0.71, 0.64), roughness=0.35)
    scene.add("Skirting", (shapes.join(
        skirting((LEFT, BACK), (gap[0], BACK)), skirting((gap[1], BACK), (RIGHT, BACK)),
        skirting((RIGHT, BACK), (RIGHT, FRONT)), skirting((LEFT, FRONT), (LEFT, BACK))), woodwork))
    frame = furniture.door_frame(DOORWAY[1] - DOORWAY[0], DOORWAY[3], WALL)
    scene.add("DoorFrame", (frame.moved(LEFT + DOORWAY[0], 0, BACK - WALL / 2), woodwork))


def _door(scene, angle):
    """The door, hinged on its left, opening into the back room; returns its node."""
    parts = furniture.door_leaf(DOORWAY[1] - DOORWAY[0] - 0.03, DOORWAY[3] - 0.02)
    return scene.add("Door", (parts["wood"], Material("DoorPaint", (0.36, 0.42, 0.38), roughness=0.4)),
                     (parts["metal"], metal("Brass", (0.90, 0.68, 0.32), 0.25)),
                     at=(LEFT + DOORWAY[0] + 0.016, 0.006, BACK - WALL + 0.022),
                     turn=rotation((0, 1, 0), angle))


def _table(scene, pot_finishes):
    """The table with the three teapots, a candlestick and a bowl of fruit, and a chair."""
    oak = Material("Oak", (1.0, 1.0, 1.0),
                   roughness=0.32,
                   texture=textures.wood((0.26, 0.14, 0.065), (0.58, 0.38, 0.20)))
    table = furniture.table(1.5, 0.85, TABLE_TOP)
    scene.add("Table", (table["top"], oak), (table["legs"], oak), at=(0.35, 0, 0.25))
    pot = furniture.teapot()
    places = ((-0.10, 0.26, 205), (0.34, 0.06, 155), (0.76, 0.34, 140))
    for (name, finish), (x, z, angle) in zip(pot_finishes, places):
        scene.add(name, (pot, finish),
                  at=(x, TABLE_TOP + 0.0005, z),
                  turn=rotation((0, 1, 0), angle),
                  scale=1.15)
    candlestick = furniture.candlestick()
    scene.add("Candlestick", (candlestick["metal"], metal("OldBrass", (0.80, 0.60, 0.30), 0.3)),
              (candlestick["wax"], lambert("Wax", (0.80, 0.74, 0.60))), at=(0.16, TABLE_TOP, 0.36))
    porcelain = Material("Porcelain", (0.75, 0.74, 0.70), roughness=0.12)
    scene.add("Bowl", (furniture.bowl(0.13), porcelain), at=(0.40, TABLE_TOP - 0.003, 0.50))
    orange = Material("Orange", (0.85, 0.30, 0.03), roughness=0.45)
    fruit = shapes.sphere(0.036, 16, 32)
    scene.add("Fruit", (shapes.copies(fruit, [(0.042, 0.047, 0.01), (-0.04, 0.047, 0.025),
                                              (0.0, 0.047, -0.045), (0.0, 0.098, 0.0)]), orange),
              at=(0.40, TABLE_TOP - 0.003, 0.50))
    chair = furniture.chair()
    cloth = lambert("Cloth", texture=textures.woven((0.42, 0.10, 0.08)))
    scene.add("Chair", (chair["wood"], oak), (chair["cushion"], cloth),
              at=(0.75, 0, -0.62),
              turn=rotation((0, 1, 0), -24))


def _furnishings(scene):
    """Painting, sideboard with books and a vase, a standing lamp that is off, and a rug."""
    gilt = metal("Gilt", (0.83, 0.61, 0.29), 0.38)
    painting = furniture.picture(1.2, 0.9)
    scene.add("Painting",
              (painting["canvas"], Material("Canvas",
                                            (1.0,) * 3, roughness=0.6, texture=textures.painting())),
              (painting["frame"], gilt),
              at=(0.75, 1.62, BACK + 0.001))
    small = furniture.picture(0.42, 0.56, border=0.04)
    scene.add("SmallPainting",
              (small["canvas"], lambert("SmallCanvas", texture=textures.abstract_painting())),
              (small["frame"], Material("BlackFrame", (0.02,) * 3, roughness=0.3)),
              at=(LEFT + 0.001, 1.5, -0.6),
              turn=rotation((0, 1, 0), 90))
    walnut = Material("Walnut", (1.0,) * 3,
                      roughness=0.3,
                      texture=textures.wood((0.06, 0.028, 0.014), (0.2, 0.1, 0.05), 21))
    doors = [
        shapes.rounded_box((x + 0.01, 0.14, 0.415), (x + 0.49, 0.70, 0.435), 0.005, 2)
        for x in (-0.75, -0.25, 0.25)
    ]
    body = shapes.join(shapes.rounded_box((-0.75, 0.12, 0.0), (0.75, 0.74, 0.42)),
                       shapes.rounded_box((-0.78, 0.74, -0.01), (0.78, 0.77, 0.45), 0.006, 2), *doors,
                       shapes.copies(shapes.rounded_box((-0.03, 0, -0.03), (0.03, 0.12, 0.03)),
                                     [(x, 0, z) for x in (-0.68, 0.68) for z in (0.06, 0.36)]))
    side = scene.add("Sideboard", (body, walnut), at=(0.95, 0, BACK + 0.03))
    knobs = shapes.copies(shapes.sphere(0.014, 12, 24), [(x, 0.44, 0.446) for x in (-0.3, -0.2, 0.7)])
    scene.add("Knobs", (knobs, gilt), parent=side)
    scene.add("Vase", (furniture.vase(), Material("Celadon", (0.16, 0.36, 0.29), roughness=0.1)),
              at=(0.48, 0.77, 0.21),
              parent=side)
    covers = [Material(f"Cover{k}", color, roughness=0.6) for k, color in enumerate(
        ((0.35, 0.05, 0.04), (0.04, 0.10, 0.22), (0.30, 0.22, 0.10), (0.05, 0.16, 0.08), (0.55, 0.50, 0.40)))]
    scene.add("Books",
              *((book, covers[k % 5]) for k, book in enumerate(furniture.books(0.5, 4))),
              at=(-0.6, 0.77, 0.2),
              parent=side)
    lamp = furniture.floor_lamp()
    scene.add("FloorLamp", (lamp["metal"], metal("Bronze", (0.45, 0.30, 0.16), 0.35)),
              (lamp["shade"], lambert("Shade", (0.75, 0.66, 0.50))), at=(-1.85, 0, -0.05))
    rug = shapes.surface(lambda u, v: _rug_point(u, v), 24, 36)
    scene.add(
        "Rug",
        (rug, lambert("Rug", texture=textures.rug((0.30, 0.05, 0.04), (0.62, 0.48, 0.28),
                                                  (0.05, 0.06, 0.14)))),
        at=(-0.2, 0, 0.0))


def _rug_point(u, v):
    """A rug 1.9 x 2.8 m with slight waves."""
    y = 0.008 + 0.004 * np.sin(9 * u + 2) * np.sin(7 * v)
    return np.stack([1.9 * (u - 0.5), y, 2.8 * (0.5 - v)], -1)


def _build(name, finish=as_given, panel=True):
    """The whole scene, and its door's node. `panel`: with the light under the back room's ceiling."""
    scene = SceneFile(name, 4, finish=finish)
    _rooms(scene)
    door = _door(scene, 18)
    _table(scene, (("GlassTeapot", glass("PotGlass", tint=(0.80, 0.93, 0.88), tint_distance=0.3)),
                   ("MetalTeapot", metal("Copper", (0.93, 0.60, 0.45), 0.15)),
                   ("ClayTeapot", lambert("Clay", (0.82, 0.80, 0.75)))))
    _furnishings(scene)
    if panel:
        light = shapes.quad((-0.5, HEIGHT - 0.02, -4.4), (1.1, 0, 0), (0, 0, 1.1))
        scene.add("BackRoomLight", (light, emitter("Light", (1300.0, 1130.0, 860.0))))
    scene.add_camera((0.50, 1.34, 2.0), (0.06, 0.84, -0.6), 45.0)
    return scene, door


def door_ajar():
    """Room lit through a door ajar: indirect light only; teapots of glass, copper and clay."""
    return _build("door_ajar")[0]


def door_ajar_diffuse():
    """Door ajar with every material exactly Lambert, to compare with other renderers."""
    return _build("door_ajar_diffuse", as_lambert)[0]


def door_ajar_glossy():
    """Door ajar with every surface polished: indirect light by way of glossy reflections."""
    return _build("door_ajar_glossy", as_polished)[0]


def door_ajar_animated():
    """Door ajar whose door swings, in a loop of four seconds: the light moves everywhere."""
    scene, door = _build("door_ajar_animated")
    angles = (18, 22, 29, 36, 40, 36, 29, 22, 16, 13, 18)
    scene.animate(door, "rotation", _loop_times(angles), [rotation((0, 1, 0), angle) for angle in angles])
    return scene


def door_ajar_box_light():
    """Door ajar whose lamp, a glowing box, wanders about the back room in a loop of four seconds."""
    places = [(0.85 * math.sin(a) - 0.1, 1.9 + 0.35 * math.sin(2 * a), -3.7 + 0.6 * math.cos(a))
              for a in np.linspace(0, 2 * math.pi, 17)]
    scene, lamp = _box_light("door_ajar_box_light", places[0])
    scene.animate(lamp, "translation", _loop_times(places), places)
    return scene


def door_ajar_light_cut():
    """Door ajar whose lamp, a glowing box, jumps after one second: how soon does a method recover?"""
    places = [(0.3, 2.4, -3.0), (0.4, 0.5, -3.0)]  # under the ceiling and over the floor: about as much light
    scene, lamp = _box_light("door_ajar_light_cut", places[0])
    scene.animate(lamp, "translation", (0.0, 1.0), places, "STEP")
    return scene


def _box_light(name, place):
    """The scene lit by a glowing box instead of the panel, and the box's node."""
    scene, _ = _build(name, panel=False)
    box = shapes.box((-0.16, -0.16, -0.16), (0.16, 0.16, 0.16))
    return scene, scene.add("BoxLight", (box, emitter("BoxLight", (1500.0, 1300.0, 1000.0))), at=place)


def _loop_times(keys):
    """Times of equally spaced keys of a loop of four seconds."""
    return [4.0 * k / (len(keys) - 1) for k in range(len(keys))]


FAMILY = (door_ajar, door_ajar_diffuse, door_ajar_glossy, door_ajar_animated, door_ajar_box_light,
          door_ajar_light_cut)
