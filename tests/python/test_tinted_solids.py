"""Absorption in tinted solids as the camera meets it: from within, and not on the backs of opaque surfaces.

The pictures are known in closed form. What noise they have is that of light between the faces of glass: less than 0.5%
of the image mean, of which 2% may be off.
"""

import pytest
from renderer_scenes import ROOT, check_samples, make_renderer, restirpg

from restirpg.scenes import shapes
from restirpg.scenes.gltf import Material, SceneFile, emitter, glass

SIZE = (16, 16)
TINT = 0.5  # of the light that a metre lets through
DISTANCE = 1.9  # from the camera to the face it looks at, m
GRAPHS = ("path_tracer", "restir_di", "restir_pt")


def make(file, graph, **options):
    return make_renderer(
        restirpg.load_scene(file), restirpg.load_graph(ROOT / "graphs" / f"{graph}.py"), size=SIZE, **options
    )


def mean(file, graph, frames, **options):
    renderer = make(file, graph, **options)
    renderer.render(frames)
    check_samples(renderer)
    return renderer.output("image").mean(dtype=float)


def inside_a_solid(folder, ior, roughness=0.0, tint=TINT):
    """The camera in a box of this glass, and a wall of radiance 1 before it."""
    scene = SceneFile(f"inside_{ior}_{roughness}_{tint}".replace(".", "_"), 8)
    tinted = glass("Tinted", ior=ior, roughness=roughness, tint=(tint,) * 3, tint_distance=1.0)
    scene.add("Box", (shapes.box((-1, -1, -1), (1, 1, 1)), tinted))
    scene.add("Wall", (shapes.quad((-40, -40, -3), (80, 0, 0), (0, 80, 0)), emitter("Wall", (1.0, 1.0, 1.0))))
    scene.add_camera((0, 0, DISTANCE - 1), (0, 0, -3), 2.0)
    return scene.write(folder)


@pytest.mark.parametrize("graph", GRAPHS)
def test_what_a_camera_in_a_solid_sees_is_absorbed(tmp_path, graph):
    through = TINT**DISTANCE
    assert abs(mean(inside_a_solid(tmp_path, 1.0), graph, 2) / through - 1) < 0.001
    # The light that goes to and fro between front and back, and what an interface does to radiance.
    ior, reflected = 1.5, 0.04
    expected = ior**2 * (1 - reflected) * through / (1 - reflected**2 * TINT**4)
    measured = mean(inside_a_solid(tmp_path, ior), graph, 64)
    print(f"{graph}: {measured:.4f} of {expected:.4f}")
    assert abs(measured / expected - 1) < 0.02


@pytest.mark.parametrize("graph", GRAPHS)
def test_it_is_absorbed_through_rough_faces_too(tmp_path, graph):
    """With the same random numbers, so that only absorption tells the pictures apart."""
    clear, tinted = (mean(inside_a_solid(tmp_path, 1.5, 0.4, tint), graph, 16, bounces=0) for tint in (1.0, TINT))
    assert clear > 0.1 and abs(tinted / clear / TINT**DISTANCE - 1) < 0.02


@pytest.mark.parametrize("graph", GRAPHS)
def test_a_shell_that_glows_is_seen_through_what_it_holds(tmp_path, graph):
    scene = SceneFile("glowing_shell", 0)
    tinted = {"transmission": 1.0, "thickness": 1.0, "attenuation_color": (TINT,) * 3, "attenuation_distance": 1.0}
    # Of ior 1: another would reflect its light totally beyond the critical angle.
    shell = emitter("Shell", (1.0,) * 3, double_sided=True, ior=1.0, **tinted)
    scene.add("Shell", (shapes.box((-1, -1, -1), (1, 1, 1)), shell))
    scene.add_camera((0, 0, DISTANCE - 1), (0, 0, -3), 2.0)
    assert abs(mean(scene.write(tmp_path), graph, 1) / TINT**DISTANCE - 1) < 0.001


def opaque_room(folder, **volume):
    """A closed room of an opaque material, whose walls show their backs."""
    scene = SceneFile("room_" + "_".join(volume), 2)
    wall = Material("Wall", (0.7, 0.7, 0.7), roughness=1.0, specular=0.0, **volume)
    scene.add("Room", (shapes.box((-1, -1, -1), (1, 1, 1)), wall))
    lamp = emitter("Lamp", (10.0, 10.0, 10.0))
    scene.add("Lamp", (shapes.quad((-0.2, 0.9, -0.2), (0.4, 0, 0), (0, 0, 0.4)), lamp))
    scene.add_camera((0, 0, 0.9), (0, 0, -1), 60.0)
    return scene.write(folder)


VOLUME = {"thickness": 1.0, "attenuation_color": (0.2, 0.2, 0.2), "attenuation_distance": 1.0}


def test_a_volume_means_nothing_where_nothing_is_transmitted(tmp_path):
    pictures = []
    for volume in ({}, VOLUME):
        renderer = make(opaque_room(tmp_path, **volume), "path_tracer")
        renderer.render(2)
        pictures.append(renderer.output("image").tobytes())
    assert pictures[0] == pictures[1]


def test_an_edit_of_the_transmission_makes_and_unmakes_the_volume(tmp_path):
    opaque, clear = opaque_room(tmp_path, **VOLUME), opaque_room(tmp_path, transmission=0.5, **VOLUME)
    renderer = make(opaque, "path_tracer")
    for transmission, file in ((0.5, clear), (0.0, opaque)):
        renderer.edit({"materials.Wall.transmission": transmission})
        same = make(file, "path_tracer")
        for one in (renderer, same):
            one.render(2)
        assert renderer.output("image").tobytes() == same.output("image").tobytes()
