"""Scenes and graphs for measuring shifts of paths: every way a path can bounce, under every kind of light."""

import numpy as np
from direct_light import LitScene
from renderer_scenes import restirpg

from restirpg.scenes import shapes
from restirpg.scenes.gltf import Material, SceneFile, emitter, glass, lambert, metal

COSINE, SINE = np.cos(np.radians(35)), np.sin(np.radians(35))
OUTPUTS = ("stay", "neighbour", "previous", "neighbour_jacobian", "previous_jacobian", "spatial_sums", "temporal_sums")


def write_every_bounce(folder, camera_in_a_solid=False):
    """Smooth, sharp and delta lobes that reflect and transmit, under every kind of light. The camera may stand in a
    block of tinted frosted glass."""
    sky = np.full((8, 16, 3), 0.3, np.float32)
    sky[1:3, 3:6] = (4.0, 3.0, 1.0)
    scene = LitScene("every_bounce", 4, environment=sky)
    gloss = Material("Gloss", (0.6, 0.5, 0.4), roughness=0.4)
    scene.add("Floor", (shapes.quad((-2, 0, 2), (4, 0, 0), (0, 0, -4)), gloss))
    scene.add("Wall", (shapes.quad((-2, 0, -1.2), (4, 0, 0), (0, 2.2, 0)), lambert("White", (0.8, 0.8, 0.8))))
    # A mirror and brushed steel in one plane: one label, a delta beside a rough lobe.
    panel = shapes.quad((0, 0, 0), (0.5, 0, 0), (0, 1.4, 0)).turned("y", 35)
    silver, steel = metal("Silver", (0.9, 0.9, 0.9), 0.0), metal("Steel", (0.8, 0.8, 0.9), 0.12)
    scene.add("Mirror", (panel.moved(-1.7, 0.05, -0.2), silver))
    scene.add("Brushed", (panel.moved(-1.7 + 0.5 * COSINE, 0.05, -0.2 - 0.5 * SINE), steel))
    ball = shapes.icosphere(0.3, 2).moved(0.0, 0.3, -0.6)
    scene.add("Ball", (ball, Material("Clay", (0.7, 0.4, 0.3), roughness=0.5)))
    block = shapes.box((-0.2, 0, -0.1), (0.2, 0.6, 0.1))
    for name, x, roughness in (("Clear", -0.75, 0.0), ("Etched", -0.3, 0.12), ("Frosted", 0.35, 0.4)):
        material = glass(name, roughness=roughness, tint=(0.8, 0.9, 0.7), tint_distance=0.3)
        scene.add(name, (block.moved(x, 0.01, 0.5), material))
    sheet = Material("Sheet", (0.9, 0.9, 0.9), roughness=0.12, transmission=0.9)
    scene.add("Sheet", (shapes.quad((-0.25, 0, 0), (0.5, 0, 0), (0, 0.7, 0)).moved(0.95, 0.01, 0.5), sheet))
    lamp = shapes.quad((-0.8, 2.0, -0.6), (1.6, 0, 0), (0, 0, 1.2))
    scene.add("Lamp", (lamp, emitter("Lamp", (3.0, 2.6, 2.3))))
    shade = shapes.quad((0.9, 0.9, -1.1), (0.6, 0, 0), (0, 0.5, 0))
    scene.add("Panel", (shade, emitter("Panel", (3.0, 4.0, 5.0))))
    scene.add_spot("Spot", (1.0, 2.0, 1.0), (0.0, 0.2, 0.0), (3.0, 3.0, 2.5), outer=40.0)
    scene.add_punctual("point", (-0.6, 1.4, 0.6), (0, 0, 0), (0.7, 0.6, 0.5))
    scene.add_punctual("directional", (2.0, 3.0, 2.0), (0, 0, 0), (0.3, 0.3, 0.5))
    if camera_in_a_solid:
        frosted = glass("Around", roughness=0.4, tint=(0.5, 0.7, 0.3), tint_distance=0.3)
        scene.add("Around", (shapes.box((-0.5, 0.6, 2.8), (0.7, 1.4, 3.7)), frosted))
    scene.add_camera((0.1, 1.0, 3.3), (0.0, 0.5, 0), 38.0)
    return scene.write(folder)


def write_panes(folder, panes, roughness):
    """Panes of rough glass one behind the other that fill the view, before a sky of radiance 1."""
    scene = SceneFile("panes", 2 * panes, environment=(1.0, 1.0, 1.0))
    pane = shapes.box((-4, -4, -0.05), (4, 4, 0.05))
    for i in range(panes):
        scene.add(f"Pane{i}", (pane.moved(0, 0, -0.3 * i), glass(f"Glass{i}", roughness=roughness)))
    scene.add_camera((0, 0, 3.0), (0, 0, 0), 30.0)
    return scene.write(folder)


def add_reuse(graph, gbuffer, paths, **knobs):
    """The pass `reuse`: ReSTIR PT over these candidates, with its history."""
    return graph.add(
        "reuse",
        "ReSTIRReuse",
        surface=gbuffer.surface,
        candidates=paths.candidates,
        motion=gbuffer.motion,
        previous_surface=restirpg.prev("gbuffer.surface"),
        history=restirpg.prev("reuse.reservoirs"),
        **knobs,
    )


def probe_graph(outputs=OUTPUTS):
    """ReSTIR PT under the tests' ShiftProbe, which compiles what these outputs need."""
    graph = restirpg.Graph("Shifts measured")
    gbuffer = graph.add("gbuffer", "GBuffer")
    paths = graph.add("paths", "PathTracerGuided", surface=gbuffer.surface, bounces=4)
    reuse = add_reuse(graph, gbuffer, paths)
    probe = graph.add(
        "probe",
        "ShiftProbe",
        surface=gbuffer.surface,
        reservoirs=reuse.reservoirs,
        previous_surface=restirpg.prev("gbuffer.surface"),
        history=restirpg.prev("reuse.reservoirs"),
    )
    for name in outputs:
        graph.output(name, getattr(probe, name))
    return graph
