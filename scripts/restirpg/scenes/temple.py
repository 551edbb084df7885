"""A columned hall with seventy small lamps and a shaft of sunlight."""

import math

import numpy as np

from . import architecture, furniture, shapes, textures
from .gltf import Material, SceneFile, emitter, glass, lambert, metal

HALF_WIDTH, LENGTH, HEIGHT = 4.2, 18.0, 6.2  # m; the hall runs from z = 0 to -LENGTH
COLUMN_X, COLUMN_STEP, COLUMN_HEIGHT = 2.5, 2.6, 4.9
OPENING = (-1.0, 1.0, -8.9, -7.1)  # of the roof: x from, to, z from, to


def _hall(scene):
    """Floor, walls and the roof with its opening."""
    marble = Material("Marble", (1.0,) * 3,
                      roughness=0.22,
                      texture=textures.checker((0.07, 0.09, 0.12), (0.62, 0.58, 0.50), 81),
                      texture_scale=(0.5, 0.5))
    stone = lambert("Stone", texture=textures.bricks((0.30, 0.16, 0.12), (0.14, 0.09, 0.07), 82))
    scene.add("Floor", (shapes.room_quad((-HALF_WIDTH, 0, 3), (2 * HALF_WIDTH, 0, 0),
                                         (0, 0, -LENGTH - 3)), marble))
    width = 2 * HALF_WIDTH
    scene.add("Walls", (shapes.join(
        architecture.wall((-HALF_WIDTH, 0, 3), (0, 0, -LENGTH - 3), HEIGHT),
        architecture.wall((HALF_WIDTH, 0, -LENGTH), (0, 0, LENGTH + 3), HEIGHT),
        architecture.wall((-HALF_WIDTH, 0, -LENGTH), (width, 0, 0), HEIGHT),
        architecture.wall((HALF_WIDTH, 0, 3), (-width, 0, 0), HEIGHT)).with_uvs(0.5), stone))
    x0, x1, z0, z1 = OPENING
    roof = [shapes.room_quad((a, HEIGHT, c), (b - a, 0, 0), (0, 0, d - c)) for a, b, c, d in (
        (-HALF_WIDTH, HALF_WIDTH, -LENGTH, z0), (-HALF_WIDTH, HALF_WIDTH, z1, 3),
        (-HALF_WIDTH, x0, z0, z1), (x1, HALF_WIDTH, z0, z1))]
    curb = [
        shapes.room_quad((x0, HEIGHT, z0), (0, 0.6, 0), (0, 0, z1 - z0)),
        shapes.room_quad((x1, HEIGHT, z0), (0, 0, z1 - z0), (0, 0.6, 0)),
        shapes.room_quad((x0, HEIGHT, z0), (x1 - x0, 0, 0), (0, 0.6, 0)),
        shapes.room_quad((x0, HEIGHT, z1), (0, 0.6, 0), (x1 - x0, 0, 0))
    ]
    plaster = lambert("RoofPlaster", (0.52, 0.46, 0.38))
    scene.add("Roof", (shapes.join(*roof, *curb), plaster))


def _columns(scene):
    """Two rows of fluted columns under architraves, and the roof's beams."""
    stone = Material("Sandstone", (1.0,) * 3,
                     roughness=0.75,
                     texture=textures.plaster((0.72, 0.66, 0.54), 83, contrast=0.3))
    column = architecture.column(COLUMN_HEIGHT, 0.36)
    zs = [-0.4 - COLUMN_STEP * k for k in range(7)]
    for side in (-1, 1):
        for z in zs:
            scene.add("Column", (column, stone), at=(side * COLUMN_X, 0, z))
        low, high = sorted((side * (COLUMN_X - 0.42), side * (COLUMN_X + 0.42)))
        scene.add("Architrave", (shapes.join(
            shapes.rounded_box((low, COLUMN_HEIGHT, -LENGTH), (high, COLUMN_HEIGHT + 0.5, 3), 0.02),
            shapes.rounded_box((low - 0.06, COLUMN_HEIGHT + 0.5, -LENGTH),
                               (high + 0.06, COLUMN_HEIGHT + 0.66, 3), 0.03, 2)), stone))
    wood = Material("Cedar", (1.0,) * 3,
                    roughness=0.6,
                    texture=textures.wood((0.10, 0.045, 0.02), (0.26, 0.13, 0.06), 84))
    beam = shapes.rounded_box((-HALF_WIDTH, HEIGHT - 0.4, -0.16), (HALF_WIDTH, HEIGHT, 0.16), 0.01)
    scene.add("Beams", (shapes.copies(beam, [(0, 0, z) for z in zs + [2.2, -17.2]]), wood))


def _sanctuary(scene):
    """Steps at the far end with a gilded orb in a niche, and a glass orb on a pedestal in the sun shaft."""
    stone = Material("PaleStone", (0.62, 0.57, 0.48), roughness=0.5)
    scene.add("Steps", (architecture.steps(4.4, 0.16, 0.34, 5), stone), at=(0, 0, -14.4))
    scene.add("Podium", (shapes.rounded_box((-2.2, 0, -LENGTH), (2.2, 0.8, -16.1), 0.01), stone))
    niche = architecture.arch(2.2, 2.2, 4.2, 0.5, 0.5, 32)
    scene.add("Niche", (niche, stone), at=(0, 0.8, -17.1))
    pedestal = shapes.lathe(
        furniture.rounded_outline([(0, 0), (0.55, 0), (0.55, 0.12), (0.36, 0.2), (0.30, 0.5), (0.34, 0.8),
                                   (0.46, 0.9), (0.46, 1.0), (0, 1.0)], 1), 64)
    scene.add("AltarPedestal", (pedestal, stone), at=(0, 0.8, -16.9))
    scene.add("GoldenOrb", (shapes.icosphere(0.5, 5), metal("Gold", (1.0, 0.72, 0.30), 0.22)),
              at=(0, 2.3, -16.9))
    scene.add("ShaftPedestal", (pedestal, stone), at=(0.35, 0, -6.4))
    scene.add("GlassOrb",
              (shapes.icosphere(0.36, 5), glass("OrbGlass", tint=(0.85, 0.95, 0.92), tint_distance=0.5)),
              at=(0.35, 1.3605, -6.4))


def _lamps(scene):
    """Oil lamps: standing bowls between the columns, hanging ones above the nave, candles on the steps."""
    bronze = metal("Bronze", (0.55, 0.38, 0.20), 0.35)
    stand = shapes.lathe(
        furniture.rounded_outline([(0, 0), (0.16, 0), (0.15, 0.04), (0.03, 0.10), (0.022, 0.6), (0.04, 0.65),
                                   (0.022, 0.7), (0.02, 1.15), (0.13, 1.25), (0.15, 1.29), (0.13, 1.27),
                                   (0, 1.20)], 2), 32)
    bowl = shapes.lathe(
        furniture.rounded_outline([(0, -0.06), (0.07, -0.05), (0.11, 0.01), (0.10, 0.01), (0, -0.04)], 2), 32)
    chain = shapes.tube([(0, 0.10, 0), (0, 2.6, 0)], 0.006, 8)
    hoop = shapes.join(
        *(shapes.tube([(0.105 * math.cos(a), 0.005, 0.105 * math.sin(a)), (0, 0.62, 0)], 0.003, 6)
          for a in (0, 2.094, 4.189)))
    candle = shapes.cylinder(0.022, 0.16, 16, 0.003)
    wax = lambert("Wax", (0.75, 0.66, 0.48))
    flame = shapes.icosphere(1.0, 1).scaled(0.028, 0.055, 0.028)
    warm = [
        emitter(f"Flame{k}",
                np.array((1.0, 0.62, 0.30)) * power) for k, power in enumerate((260.0, 360.0, 480.0))
    ]
    lit = 0
    for k in range(6):
        z = -1.7 - COLUMN_STEP * k
        for x in (-COLUMN_X, COLUMN_X, -3.8, 3.8):
            scene.add("LampStand", (stand, bronze), at=(x, 0, z))
            scene.add("Flame", (flame, warm[lit % 3]), at=(x, 1.325, z))
            lit += 1
        for x in (-1.2, 0.0, 1.2):
            if x == 0.0 and k in (2, 3):
                continue
            y = 3.1 + 0.35 * math.cos(2.1 * k + 1.7 * x)
            scene.add("HangingLamp", (bowl, bronze), (hoop, bronze), (chain.moved(0, 0.5, 0), bronze),
                      at=(x, y, z))
            scene.add("Flame", (flame, warm[lit % 3]), at=(x, y + 0.035, z))
            lit += 1
    for step in range(5):
        for k in range(10):
            x = -2.05 + 0.4 * k + 0.12 * math.sin(5 * k + step)
            if abs(x) < 0.75:
                continue
            at = np.array((x, 0.16 * (step + 1), -14.4 - 0.34 * step - 0.17))
            scene.add("Candle", (candle, wax), at=at)
            scene.add("CandleFlame", (flame, warm[(step + k) % 3]), at=at + (0, 0.185, 0), scale=0.45)


def temple():
    """Temple of seventy small lamps and a sun shaft: many lights of very different reach."""
    scene = SceneFile("temple", 3, environment=3.0 * textures.sky(68.0, 350.0))
    _hall(scene)
    _columns(scene)
    _sanctuary(scene)
    _lamps(scene)
    scene.add_camera((-0.9, 1.7, 2.3), (0.25, 1.9, -8.0), 50.0)
    return scene


FAMILY = (temple,)
