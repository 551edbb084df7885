"""What a pixel's reservoirs hold, in words, and the vertices of the path that it has selected: the records of
framework/shaders/restir/path_reservoir_types.h, light_reservoir_types.h and path_vertex_types.h."""

import numpy as np

from restirpg.harness import guiding
from restirpg.records import constant, fields_of, record

from . import camera

PATH = record("PathReservoir")
LIGHT = record("LightReservoir", point=fields_of(record("LightPoint")))
_NONE, _LIGHT_SAMPLED = 0xFFFFFFFF, constant("PATH_LIGHT_SAMPLED")
_LABELS = ("smooth", "sharp reflection", "sharp transmission")
_ARROW = 0.25  # of a vertex's distance from the camera: length of the last edge, whose end is not stored


def _numbers(values):
    return " ".join(f"{float(value):.4g}" for value in np.atleast_1d(values))


def _light_point(instance, index):
    return (
        f"light {index} of the table" if instance == _NONE else f"triangle {index} of instance {instance}, which emits"
    )


def _weights(record):
    yield f"confidence M = {_numbers(record['confidence'])}", "how many pixels' candidates stand behind it"
    yield (
        f"contribution weight W = {_numbers(record['ucw'])}",
        "about 1 / density" if record["ucw"] > 0 else "it carries no light",
    )


def describe_light(record):
    """[(what, meaning)] of a LightReservoir."""
    if record["confidence"] == 0:
        return [("empty", "no light was found here")]
    if record["instance"] == record["index"] == _NONE:
        return [("empty", "no light was found here"), *_weights(record)]
    lines = [("a point of " + _light_point(record["instance"], record["index"]), f"at {_numbers(record['place'])}")]
    return [
        *lines,
        *_weights(record),
        (f"target {_numbers(record['target'])}", "luminance that it sends to the camera, if it is seen"),
    ]


def describe_path(record):
    """[(what, meaning)] of a PathReservoir."""
    shape = int(record["shape"])
    edges, reconnects = shape & (_LIGHT_SAMPLED - 1), shape >> 8 & 255
    if edges == 0:
        return [("empty", "no path was found here"), *(_weights(record) if record["confidence"] > 0 else ())]
    lines = [
        (f"a path of {edges} edges", "camera, " + ", ".join(f"x{u}" for u in range(1, edges)) + f", light x{edges}"),
        ("its light was sampled" if shape & _LIGHT_SAMPLED else "its light was met by scattering", "how it ends"),
    ]
    bounces = []
    for u in range(1, edges):
        delta = " (delta)" if shape >> (15 + u) & 1 else ""
        bounces.append(f"x{u} {_LABELS[min(record['labels'] >> (2 * u - 2) & 3, 2)]}{delta}")
    lines.append((", ".join(bounces), "how it leaves each vertex"))
    if reconnects == 0:
        lines.append(("it reconnects nowhere", "a shift replays all of its bounces"))
    elif reconnects == edges:
        lines.append((f"it reconnects at its light, x{edges}", _light_point(*record["anchor"])))
    else:
        lines.append(
            (f"it reconnects at x{reconnects}", f"triangle {record['anchor'][1]} of instance {record['anchor'][0]}")
        )
    radiance = record["f"].astype(float) * float(record["ucw"])
    return [*lines, *_weights(record), (f"f W = {_numbers(radiance)}", "radiance by this path alone, RGB")]


_RESERVOIRS = {"ReSTIRReuse": (PATH, describe_path), "ReSTIRDI": (LIGHT, describe_light)}


def at_pixel(pane, x, y):
    """{"pass.reservoirs": [(what, meaning)]} of a graph in view."""
    told, readable = {}, pane.renderer.memory()
    for entry in pane.description["passes"]:
        port = f"{entry['name']}.reservoirs"
        if entry["type"] in _RESERVOIRS and port in readable:
            dtype, describe = _RESERVOIRS[entry["type"]]
            told[port] = describe(pane.renderer.read_port(port).view(dtype)[y * pane.renderer.size[0] + x])
    return told


def path_at_pixel(pane, x, y, pose):
    """The smooth vertices of the pixel's path that the guide learns from, as places in the picture: {points: [[u, v] or
    null], fractions of the picture; bounces: [u], their numbers; light: [u, v] or null, towards the light beyond the last}.
    None where no guide learns from paths, or the pixel has none."""
    if pane.learnt_vertices is None:
        return None
    width, height = pane.renderer.size
    vertices = pane.renderer.read_port(pane.learnt_vertices).view(guiding.VERTEX)
    vertices = vertices.reshape(width * height, -1)[y * width + x]
    bounces = np.flatnonzero(guiding.is_valid(vertices))
    if bounces.size == 0:
        return None
    vertices = vertices[bounces]
    (splat,) = guiding.passes_of(pane.description, "GuidingSplat")
    grid = guiding.grid_of_splat(pane.renderer, splat)
    # Seen from the camera, since kernels' places are the world's only where the scene is not far off.
    points = grid.positions(vertices["position"]) - grid.camera + pane.renderer.camera["position"]
    last, leaves = points[-1], guiding.unpack_direction(vertices["direction"][-1:])[0]
    light = None
    if vertices["surface"][-1] & guiding.FINAL:
        length = _ARROW * np.linalg.norm(last - pose["position"])
        (light,) = camera.project(pose, width / height, [last + length * leaves])
    return {
        "points": camera.project(pose, width / height, points),
        "bounces": [int(u) + 1 for u in bounces],
        "light": light,
    }
