"""Glossy metal and glass of several roughnesses under area lights, a textured emitter and a spot light."""

import numpy as np

from . import furniture, shapes, textures
from .architecture import skirting, wall
from .gltf import Material, SceneFile, emitter, glass, lambert, metal, rotation

PLINTH = 0.62  # height of the slab that the objects stand on, m


def _room(scene):
    """A dark panelled room 5 m wide, its floor of wet-looking relief tiles."""
    relief = textures.normals_of(textures.tile_relief(), 6.0)
    floor = Material("WetTiles", (1.0,) * 3, roughness=0.22, normal_texture=relief,
                     texture=textures.tiles((0.20, 0.22, 0.24), (0.05,) * 3))
    scene.add("Floor", (shapes.room_quad((-2.5, 0, 2.6), (5, 0, 0), (0, 0, -4.6)), floor))
    paint = lambert("DarkPaint", (0.20, 0.21, 0.24))
    scene.add("Walls", (shapes.join(
        wall((-2.5, 0, -2.0), (5, 0, 0), 3.0), wall((-2.5, 0, 2.6), (0, 0, -4.6), 3.0),
        wall((2.5, 0, -2.0), (0, 0, 4.6), 3.0), wall((2.5, 0, 2.6), (-5, 0, 0), 3.0)), paint))
    scene.add("Ceiling", (shapes.quad((-2.5, 3.0, -2.0), (5, 0, 0),
                                      (0, 0, 4.6)), lambert("Ceiling", (0.55,) * 3)))
    slats = Material("Slats", (1.0,) * 3,
                     roughness=0.4,
                     texture=textures.wood((0.10, 0.05, 0.025), (0.34, 0.19, 0.09), 31))
    slat = shapes.rounded_box((0, 0.12, 0), (0.055, 2.6, 0.05), 0.006)
    scene.add("SlatWall", (shapes.copies(slat, [(x, 0, -2.0) for x in np.arange(-2.46, 2.4, 0.092)]), slats))
    scene.add("Skirting", (skirting((-2.5, -1.995), (2.5, -1.995), 0.12, 0.055), slats))


def _lights(scene):
    """A warm strip above, a cool panel on the right, a stained-glass window, and a spot on the glass egg."""
    strip = shapes.quad((-1.1, 2.85, -0.35), (2.2, 0, 0), (0, 0, 0.16))
    scene.add("Strip", (strip, emitter("Warm", (64.0, 52.0, 36.0))))
    panel = shapes.quad((2.45, 1.1, 0.4), (0, 0, 1.2), (0, 1.2, 0))
    scene.add("Panel", (panel, emitter("Cool", (3.0, 4.0, 5.6))))
    window = emitter("StainedGlass", (6.0, 6.0, 6.0), emission_texture=textures.stained_glass())
    scene.add("Window", (shapes.quad((-2.44, 0.7, -0.15), (0, 0, -1.4), (0, 1.7, 0)), window))
    bars = Material("Lead", (0.05,) * 3, roughness=0.5, metallic=1.0)
    frame = [shapes.rounded_box((-2.5, 0.62, z), (-2.40, 2.48, z + 0.08)) for z in (-1.63, -0.15)]
    frame += [shapes.rounded_box((-2.5, y, -1.63), (-2.40, y + 0.08, -0.07)) for y in (0.62, 2.40)]
    scene.add("WindowFrame", (shapes.join(*frame), bars))
    scene.add_spot("Spot", (0.75, 2.7, 0.75), (0.42, PLINTH, 0.30), (90.0, 85.0, 75.0), 7.0, 10.0)


def _exhibits(scene):
    """Two rows on a stone slab: spheres by roughness in front, larger things behind."""
    stone = Material("Stone", (1.0,) * 3,
                     roughness=0.25,
                     texture=textures.plaster((0.34, 0.33, 0.32), 33, contrast=0.5))
    slab = shapes.join(
        shapes.rounded_box((-1.45, PLINTH - 0.07, -0.62), (1.45, PLINTH, 0.58), 0.008, 2),
        *(shapes.rounded_box((x, 0, -0.45), (x + 0.12, PLINTH - 0.07, 0.40), 0.006) for x in (-1.1, 0.98)))
    scene.add("Slab", (slab, stone))
    ball = shapes.sphere(0.105, 32, 64)
    gold, copper, steel = (1.0, 0.71, 0.29), (0.95, 0.64, 0.54), (0.56, 0.57, 0.58)
    row = [("Mirror", metal("Mirror", (0.95,) * 3, 0.0)), ("Gold10", metal("Gold10", gold, 0.10)),
           ("Copper25", metal("Copper25", copper, 0.25)), ("Steel40", metal("Steel40", steel, 0.40)),
           ("Gold60", metal("Gold60", gold, 0.60))]
    for k, (name, material) in enumerate(row):
        scene.add(name, (ball, material), at=(-1.15 + 0.28 * k, PLINTH + 0.1055, 0.36 - 0.02 * k))
    scene.add("GlassBall", (ball, glass("ClearGlass")), at=(0.72, PLINTH + 0.1055, 0.36))
    scene.add("FrostedBall", (ball, glass("FrostedGlass", roughness=0.3)), at=(1.02, PLINTH + 0.1055, 0.32))
    scene.add("GlassEgg",
              (furniture.egg(0.24), glass("EggGlass", tint=(0.95, 0.75, 0.45), tint_distance=0.2)),
              at=(0.42, PLINTH + 0.0005, 0.30))
    scene.add("CopperTeapot", (furniture.teapot(), metal("PolishedCopper", copper, 0.12)),
              at=(-0.72, PLINTH + 0.0005, -0.15),
              turn=rotation((0, 1, 0), 200),
              scale=1.5)
    scene.add("GlassVase",
              (furniture.vase(0.55), glass("BlueGlass", tint=(0.35, 0.65, 0.92), tint_distance=0.05)),
              at=(0.0, PLINTH + 0.0005, -0.22))
    scene.add("Knot", (furniture.trefoil_knot(), metal("BrushedSteel", steel, 0.2)),
              at=(0.86, PLINTH + 0.245, -0.22))
    brushed = Material("Brushed", gold, roughness=1.0, metallic=1.0, roughness_texture=textures.brushed())
    scene.add("BrushedBox", (shapes.rounded_box((-0.11, 0, -0.11),
                                                (0.11, 0.22, 0.11), 0.012, 3).with_uvs(3.0), brushed),
              at=(-1.22, PLINTH + 0.0005, -0.2),
              turn=rotation((0, 1, 0), 30))


def glossy_glass():
    """Metal and glass of several roughnesses, area lights, a textured one, a spot: glossy paths, caustics."""
    scene = SceneFile("glossy_glass", 10)
    _room(scene)
    _lights(scene)
    _exhibits(scene)
    scene.add_camera((0.45, 1.32, 2.35), (-0.12, 0.76, -0.1), 40.0)
    return scene


FAMILY = (glossy_glass,)
