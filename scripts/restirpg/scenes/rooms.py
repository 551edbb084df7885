"""Rooms lit the hard way: lamps that shine at the ceiling from within tubes, and daylight through windows."""

import math

import numpy as np

from . import architecture, furniture, shapes, textures
from .gltf import Material, SceneFile, emitter, glass, lambert, metal, rotation

COVERS = tuple(
    Material(f"Cover{k}", color, roughness=0.6)
    for k, color in enumerate(((0.36, 0.06, 0.05), (0.05, 0.11, 0.24), (0.32, 0.24, 0.11), (0.06, 0.18, 0.10),
                               (0.58, 0.53, 0.43), (0.15, 0.06, 0.16))))

TUBE_LAMP = (0.6, 2.15, 1.1)  # out of the camera's sight, its mouth turned away from it


def _bookcase(scene, name, material, width, height, boards, seed, at, turn=0.0):
    """A bookcase full of books; one board holds a vase instead."""
    case, tops = furniture.shelf(width, height, boards)
    node = scene.add(name, (case, material), at=at, turn=rotation((0, 1, 0), turn))
    for k, top in enumerate(tops[:-1]):
        if k == boards // 2:
            scene.add("ShelfVase",
                      (furniture.vase(0.22), Material("Glaze", (0.10, 0.25, 0.35), roughness=0.15)),
                      at=(-0.2 * width, top + 0.0005, 0.14),
                      parent=node)
            continue
        row = furniture.books(width - 0.07 - 0.2 * (k % 3 == 1), seed + k, 0.2)
        by_cover = [(shapes.join(*row[c::len(COVERS)]), COVERS[c]) for c in range(min(len(COVERS), len(row)))]
        scene.add("Books", *by_cover, at=(-width / 2 + 0.03, top + 0.0005, 0.13), parent=node)


def _picture(scene, name, texture, size, frame, at, turn=0.0):
    parts = furniture.picture(*size)
    scene.add(name, (parts["canvas"], lambert(f"{name}Canvas", texture=texture)), (parts["frame"], frame),
              at=at, turn=rotation((0, 1, 0), turn))


def _study(scene):
    """Shell of the study: 4.6 x 4.4 m, 2.6 m high, with boards on the floor and a panelled dado."""
    left, right, back, front, height = -2.3, 2.3, -2.0, 2.4, 2.6
    oak = Material("Parquet", (1.0,) * 3,
                   roughness=0.3,
                   texture=textures.planks((0.16, 0.08, 0.035), (0.42, 0.24, 0.11)),
                   texture_scale=(0.7, 0.7))
    scene.add("Floor", (shapes.room_quad((left, 0, front), (right - left, 0, 0), (0, 0, back - front)), oak))
    scene.add("Ceiling", (shapes.quad((left, height, back), (right - left, 0, 0), (0, 0, front - back)),
                          lambert("Ceiling", (0.84, 0.82, 0.78))))
    paper = lambert("Wallpaper", texture=textures.plaster((0.60, 0.62, 0.52), 61, contrast=0.2))
    corners = [(left, back), (right, back), (right, front), (left, front)]
    sides = list(zip(corners, corners[1:] + corners[:1]))
    scene.add("Walls",
              (shapes.join(*(architecture.wall((a[0], 0, a[1]), (b[0] - a[0], 0, b[1] - a[1]), height)
                             for a, b in sides)), paper))
    white = Material("Woodwork", (0.72, 0.70, 0.64), roughness=0.35)
    boards = [architecture.skirting(a, b, 0.12) for a, b in sides]
    boards += [architecture.skirting(a, b, 0.05, 0.03).moved(0, 0.9, 0) for a, b in sides]
    boards += [architecture.skirting(a, b, 0.08, 0.06).moved(0, height - 0.08, 0) for a, b in sides]
    scene.add("Woodwork", (shapes.join(*boards), white))


def _uplighter(scene):
    """A standing tube lamp: its glowing disc lies at the tube's bottom and sees the ceiling only."""
    steel = metal("LampSteel", (0.56, 0.55, 0.53), 0.3)
    foot = shapes.lathe(
        furniture.rounded_outline([(0, 0), (0.15, 0), (0.15, 0.02), (0.02, 0.035), (0.014, 0.06),
                                   (0.014, 1.38), (0, 1.38)], 1), 48)
    lamp = scene.add("Uplighter", (foot, steel), (furniture.cup_lamp(0.115, 0.36).moved(0, 1.37, 0), steel),
                     at=(-1.55, 0, -1.35))
    scene.add("UplighterGlow", (furniture.disc(0.10), emitter("UplighterGlow", (1700.0, 1450.0, 1100.0))),
              at=(0, 1.415, 0),
              parent=lamp)


def _desk(scene):
    """A desk with the glass egg, which a narrow tube under the ceiling lights, a paperweight and books."""
    walnut = Material("Walnut", (1.0,) * 3,
                      roughness=0.28,
                      texture=textures.wood((0.10, 0.045, 0.02), (0.30, 0.16, 0.075), 62))
    desk = furniture.table(1.6, 0.8)
    scene.add("Desk", (desk["top"], walnut), (desk["legs"], walnut), at=(0.45, 0, -0.15))
    top = 0.7205
    scene.add("GlassEgg", (furniture.egg(0.21), glass("EggGlass")), at=(0.28, top, 0.0))
    outline = furniture.rounded_outline(
        [(0, 0), (0.07, 0), (0.13, 0.012), (0.13, 0.016), (0.07, 0.008), (0, 0.008)], 1)
    porcelain = Material("Porcelain", (0.78, 0.77, 0.74), roughness=0.15)
    scene.add("Plate", (shapes.lathe(outline, 64), porcelain), at=(0.86, top, 0.02))
    scene.add("Paperweight",
              (shapes.icosphere(0.045, 4), glass("GreenGlass", tint=(0.3, 0.8, 0.5), tint_distance=0.1)),
              at=(0.86, top + 0.0535, 0.02))
    pile = [
        shapes.rounded_box((-0.12, 0.035 * k, -0.085), (0.12, 0.035 * k + 0.034, 0.085),
                           0.004).turned("y", 9 * k * (-1) ** k) for k in range(3)
    ]
    scene.add("Pile", *((book, COVERS[k]) for k, book in enumerate(pile)), at=(-0.08, top, -0.28))
    sheet = shapes.surface(
        lambda u, v: np.stack([0.21 * (u - 0.5), 0.002 + 0.006 * u * v, 0.297 * (0.5 - v)], -1), 8, 8)
    scene.add("Paper", (sheet, lambert("Paper", (0.82, 0.81, 0.77))),
              at=(0.55, top, 0.10),
              turn=rotation((0, 1, 0), 14))
    chair = furniture.chair()
    scene.add("Chair", (chair["wood"], walnut), (chair["cushion"], lambert("Felt", (0.10, 0.22, 0.14))),
              at=(0.5, 0, -0.85),
              turn=rotation((0, 1, 0), 18))
    brass = metal("Brass", (0.91, 0.72, 0.38), 0.22)
    aim = np.array((0.28, top + 0.10, 0.0)) - TUBE_LAMP
    yaw = math.degrees(math.atan2(aim[0], aim[2]))
    pitch = math.degrees(math.acos(aim[1] / np.linalg.norm(aim)))
    spot = scene.add("TubeLamp", at=TUBE_LAMP, turn=rotation((0, 1, 0), yaw))
    tilt = scene.add("TubeLampHead", (furniture.cup_lamp(0.045, 0.36).moved(0, -0.05, 0), brass), parent=spot,
                     turn=rotation((1, 0, 0), pitch))
    scene.add("TubeLampGlow", (furniture.disc(0.022), emitter("TubeLampGlow", (14000.0, 12600.0, 10400.0))),
              at=(0, -0.005, 0),
              parent=tilt)
    scene.add("TubeLampArm", (shapes.tube([TUBE_LAMP, (TUBE_LAMP[0], 2.6, TUBE_LAMP[2])], 0.01, 12),
                              brass))


def bidirectional_room():
    """Study: a tube lamp shines at the ceiling, a beam at a glass egg: indirect light and a caustic."""
    scene = SceneFile("bidirectional_room", 8)
    _study(scene)
    _uplighter(scene)
    _desk(scene)
    case = Material("CaseWood", (1.0,) * 3,
                    roughness=0.4,
                    texture=textures.wood((0.22, 0.12, 0.06), (0.50, 0.32, 0.17), 63))
    _bookcase(scene, "Bookcase", case, 1.3, 2.0, 6, 64, (1.45, 0, -1.995))
    _picture(scene, "Landscape", textures.painting(65), (1.0, 0.75), metal("Gilt", (0.83, 0.61, 0.29), 0.35),
             (-0.35, 1.55, -1.999))
    rug = shapes.quad((-1.1, 0.01, 1.3), (2.4, 0, 0), (0, 0, -2.6))
    scene.add(
        "Rug",
        (rug, lambert("Rug", texture=textures.rug((0.06, 0.11, 0.20), (0.55, 0.45, 0.28),
                                                  (0.30, 0.06, 0.05)))))
    armchair = furniture.sofa(0.95, 0.85)
    cloth = lambert("Armchair", texture=textures.woven((0.50, 0.30, 0.16)))
    scene.add("Armchair", (armchair["frame"].with_uvs(3.0), cloth), (armchair["seat"].with_uvs(3.0), cloth),
              (armchair["feet"], case), at=(-1.45, 0, -0.25), turn=rotation((0, 1, 0), 55))
    scene.add_camera((0.25, 1.5, 2.25), (-0.05, 0.92, -0.8), 48.0)
    return scene


def _bright_room(scene):
    """Shell of the living room: 6 x 5.4 m, 2.75 m high, with two tall windows on the left."""
    left, right, back, front, height = -3.0, 3.0, -2.6, 2.8, 2.75
    boards = Material("Boards", (1.0,) * 3,
                      roughness=0.32,
                      texture=textures.planks((0.30, 0.17, 0.08), (0.58, 0.38, 0.21), 71),
                      texture_scale=(0.5, 0.5))
    scene.add("Floor", (shapes.room_quad((left, 0, front), (right - left, 0, 0),
                                         (0, 0, back - front)), boards))
    scene.add("Ceiling", (shapes.quad((left, height, back), (right - left, 0, 0), (0, 0, front - back)),
                          lambert("Ceiling", (0.85, 0.84, 0.82))))
    paint = lambert("Paint", texture=textures.plaster((0.74, 0.71, 0.64), 72))
    windows = [(0.7, 2.1, 0.25, 2.35), (3.1, 4.5, 0.25, 2.35)]
    shell = [architecture.wall((left, 0, front), (0, 0, back - front), height, windows)]
    shell += [architecture.reveal((left, 0, front), (0, 0, back - front), window, 0.3) for window in windows]
    shell += [architecture.wall((left, 0, back), (right - left, 0, 0), height),
              architecture.wall((right, 0, back), (0, 0, front - back), height),
              architecture.wall((right, 0, front), (left - right, 0, 0), height)]
    scene.add("Walls", (shapes.join(*shell), paint))
    white = Material("WhiteLacquer", (0.78, 0.78, 0.76), roughness=0.25)
    trim = [architecture.skirting(a, b, 0.12) for a, b in (
        ((left, back), (right, back)), ((right, back), (right, front)), ((left, front), (left, back)))]
    linen = lambert("Linen", texture=textures.woven((0.66, 0.60, 0.50), 73))
    for low, high, sill, top in windows:
        z0, z1 = front - high, front - low
        bars = [(z0, z0 + 0.06), (z1 - 0.06, z1), ((z0 + z1) / 2 - 0.04, (z0 + z1) / 2 + 0.04)]
        trim += [shapes.rounded_box((left - 0.16, sill, a), (left - 0.10, top, b)) for a, b in bars]
        trim += [
            shapes.rounded_box((left - 0.155, y, z0), (left - 0.105, y + 0.05, z1))
            for y in (sill, 1.0, 1.65, top - 0.05)
        ]
        trim.append(
            shapes.rounded_box((left - 0.29, sill - 0.03, z0 - 0.05), (left + 0.10, sill + 0.01, z1 + 0.05),
                               0.01, 2))
        for z in (z0 - 0.32, z1 - 0.10):
            cloth = furniture.curtain(0.42, 2.5, 5, 0.045, seed=int(100 * (z + 9)))
            scene.add("Curtain",
                      (cloth.with_uvs(2, 10).turned("y", 90).moved(left + 0.10, 0.02, z + 0.42), linen))
        rod = shapes.tube([(left + 0.1, 2.53, z0 - 0.42), (left + 0.1, 2.53, z1 + 0.42)], 0.014)
        scene.add("Rod", (rod, metal("RodBrass", (0.85, 0.65, 0.35), 0.3)))
    scene.add("Trim", (shapes.join(*trim), white))
    return white


def _seating(scene):
    """Sofa with pillows, coffee table with tumblers and a bowl, armchair, rug."""
    wool = lambert("Wool", texture=textures.woven((0.22, 0.26, 0.30), 74))
    dark = Material("DarkWood", (0.06, 0.035, 0.02), roughness=0.3)
    sofa = furniture.sofa(2.2)
    node = scene.add("Sofa", (sofa["frame"].with_uvs(3.0), wool), (sofa["seat"].with_uvs(3.0), wool),
                     (sofa["feet"], dark),
                     at=(0.25, 0, -2.05))
    for x, tilt, color in ((-0.7, 12, (0.65, 0.28, 0.06)), (0.62, -10, (0.55, 0.50, 0.38)),
                           (0.80, 6, (0.10, 0.28, 0.30))):
        pillow = furniture.cushion(0.42, 0.42, 0.15).turned("x", 66).turned("z", tilt)
        pillow = pillow.moved(x, 0.70, 0.02 + 0.08 * (x > 0.7))
        scene.add("Pillow", (pillow.with_uvs(3.0), lambert(f"Pillow{x}", texture=textures.woven(color, 75))),
                  parent=node)
    rug = shapes.quad((-1.4, 0.012, 0.75), (3.3, 0, 0), (0, 0, -2.1))
    scene.add("Rug", (rug,
                      lambert("Rug",
                              texture=textures.rug((0.55, 0.48, 0.38), (0.30, 0.12, 0.08),
                                                   (0.12, 0.14, 0.18), 768, 512))))
    top = Material("TableTop", (1.0,) * 3,
                   roughness=0.15,
                   texture=textures.wood((0.14, 0.07, 0.03), (0.36, 0.20, 0.10), 76))
    table = furniture.table(1.2, 0.6, 0.42, 0.03, 0.025)
    scene.add("CoffeeTable", (table["top"], top), (table["legs"], top), at=(0.2, 0, -0.55))
    scene.add(
        "GlassBowl",
        (shapes.lathe(_thick_bowl(), 64), glass("BowlGlass", tint=(0.5, 0.8, 0.85), tint_distance=0.06)),
        at=(0.42, 0.4205, -0.5))
    scene.add("Teapot", (furniture.teapot(), metal("Silver", (0.95, 0.93, 0.88), 0.12)),
              at=(-0.05, 0.4205, -0.58),
              turn=rotation((0, 1, 0), 215),
              scale=0.85)
    magazines = [
        shapes.rounded_box((-0.105, 0.006 * k, -0.14), (0.105, 0.006 * k + 0.0055, 0.14),
                           0.001).turned("y", 11 * k - 15) for k in range(4)
    ]
    scene.add("Magazines", *((m, COVERS[k]) for k, m in enumerate(magazines)), at=(0.60, 0.4205, -0.68))
    armchair = furniture.sofa(0.95, 0.85)
    leather = Material("Leather", (0.30, 0.12, 0.05), roughness=0.38)
    scene.add("Armchair", (armchair["frame"], leather), (armchair["seat"], leather), (armchair["feet"], dark),
              at=(2.15, 0, -0.35), turn=rotation((0, 1, 0), -62))


def _thick_bowl():
    """Profile of a heavy glass bowl."""
    return furniture.rounded_outline([(0, 0), (0.06, 0), (0.10, 0.03), (0.13, 0.10), (0.125, 0.105),
                                      (0.115, 0.10), (0.085, 0.045), (0.05, 0.022), (0, 0.02)])


def living_room():
    """Living room lit by sun and sky through two windows: most of the room sees little of the environment."""
    scene = SceneFile("living_room", 4, environment=4.0 * textures.sky(33.0, 238.0))
    white = _bright_room(scene)
    _seating(scene)
    _bookcase(scene, "Bookcase", white, 1.4, 2.1, 6, 77, (2.15, 0, -2.595))
    _picture(scene, "Abstract", textures.abstract_painting(78), (0.75, 1.0),
             Material("Black", (0.02,) * 3, roughness=0.25), (-0.45, 1.6, -2.599))
    _picture(scene, "Dusk", textures.painting(79), (0.8, 0.6), metal("Gilt", (0.83, 0.61, 0.29), 0.35),
             (0.75, 1.62, -2.599))
    lamp = furniture.floor_lamp(1.6)
    scene.add("FloorLamp", (lamp["metal"], metal("Bronze", (0.45, 0.30, 0.16), 0.35)),
              (lamp["shade"], lambert("Shade", (0.78, 0.70, 0.56))), at=(-1.45, 0, -2.15))
    pot = shapes.lathe([(0, 0), (0.15, 0), (0.19, 0.34), (0.17, 0.34), (0.16, 0.30), (0, 0.30)], 48)
    plant = furniture.plant(80, 170, 0.48, 1.15)
    leaf = Material("Leaf", (1.0,) * 3,
                    roughness=0.4,
                    double_sided=True,
                    alpha_cutoff=0.5,
                    texture=textures.leaf())
    scene.add("Plant", (pot, Material("Pot", (0.75, 0.73, 0.70), roughness=0.2)),
              (plant["stems"].moved(0, 0.3, 0), lambert("Stems", (0.10, 0.08, 0.03))),
              (plant["leaves"].moved(0, 0.3, 0), leaf),
              at=(-2.45, 0, -2.1))
    scene.add_camera((1.0, 1.42, 2.6), (-0.15, 0.95, -1.2), 50.0)
    return scene


FAMILY = (bidirectional_room, living_room)
