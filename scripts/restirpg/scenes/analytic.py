"""Scenes with a known answer or an exact counterpart in other renderers: Cornell boxes and furnaces."""

from . import shapes
from .gltf import SceneFile, emitter, glass, lambert, metal


def _empty_box(name, bounces):
    """A two-metre box open towards +z, with one square light; every surface exactly Lambert."""
    scene = SceneFile(name, bounces)
    white = lambert("White", (0.74, 0.73, 0.70))
    scene.add("Floor", (shapes.quad((-1, 0, 1), (2, 0, 0), (0, 0, -2)), white))
    scene.add("Ceiling", (shapes.quad((-1, 2, -1), (2, 0, 0), (0, 0, 2)), white))
    scene.add("BackWall", (shapes.quad((-1, 0, -1), (2, 0, 0), (0, 2, 0)), white))
    scene.add("LeftWall", (shapes.quad((-1, 0, 1), (0, 0, -2),
                                       (0, 2, 0)), lambert("Rust", (0.62, 0.13, 0.05))))
    scene.add("RightWall", (shapes.quad((1, 0, -1), (0, 0, 2),
                                        (0, 2, 0)), lambert("Teal", (0.04, 0.30, 0.33))))
    scene.add("Light", (shapes.quad((-0.3, 1.995, -0.3), (0.6, 0, 0),
                                    (0, 0, 0.6)), emitter("Light", (17.0, 13.5, 9.5))))
    scene.add_camera((0, 1, 4.35), (0, 1, 0), 34.0)
    return scene


def cornell_box():
    """Cornell box: Lambert only, one square light; equal to any other renderer's."""
    scene = _empty_box("cornell_box", 8)
    white = lambert("White", (0.74, 0.73, 0.70))
    scene.add("Tower", (shapes.box((-0.28, 0, -0.28),
                                   (0.28, 1.25, 0.28)).turned("y", 21).moved(-0.38, 0, -0.38), white))
    prism = shapes.lathe([(0, 0), (0.36, 0), (0.36, 0.55), (0, 0.55)], segments=6).faceted()
    scene.add("Prism", (prism.turned("y", -12).moved(0.42, 0, 0.32), lambert("Straw", (0.66, 0.55, 0.24))))
    return scene


def cornell_glass():
    """Cornell box with a smooth glass sphere and a perfect mirror: exact delta lobes and a caustic."""
    scene = _empty_box("cornell_glass", 12)
    scene.add("GlassSphere", (shapes.icosphere(0.36, 5).moved(0.42, 0.361, 0.35), glass("Glass")))
    block = shapes.box((-0.28, 0, -0.28), (0.28, 1.25, 0.28)).turned("y", 26).moved(-0.38, 0, -0.35)
    scene.add("MirrorBlock", (block, metal("Mirror", (1.0, 1.0, 1.0), 0.0)))
    return scene


def furnace_environment():
    """Environment furnace: a convex white Lambert body under constant radiance; every pixel is exactly 1."""
    scene = SceneFile("furnace_environment", 4, environment=(1.0, 1.0, 1.0))
    scene.add("Body", (shapes.icosphere(1.0, 3).faceted(), lambert("White")))
    scene.add_camera((0, 0.4, 3.6), (0, 0, 0), 40.0)
    return scene


def furnace_closed():
    """Closed furnace: emission 1, albedo 1/2 all around; a bounce cap n gives the radiance 2 - 2^-(n + 1)."""
    scene = SceneFile("furnace_closed", 8)
    scene.add("Walls", (shapes.box((-1, -1, -1),
                                   (1, 1, 1)).inverted(), lambert("Glow", (0.5,) * 3, emission=(1.0,) * 3)))
    scene.add_camera((0.5, 0.35, 0.8), (-0.4, -0.2, -0.6), 55.0)
    return scene


FAMILY = (cornell_box, cornell_glass, furnace_environment, furnace_closed)
