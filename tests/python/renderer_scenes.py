"""Scenes and graphs of the renderer's tests."""

import base64
import json
import struct
from pathlib import Path

import pytest

import restirpg

ROOT = Path(__file__).parents[2]
SIZE = (32, 32)
GRAPH = ROOT / "graphs" / "path_tracer.py"


def make_renderer(scene, graph=None, seed=0, size=SIZE, **options):
    """A renderer under the validation layer, any message of which is an error."""
    return restirpg.Renderer(
        scene, graph or restirpg.load_graph(GRAPH), size=size, seed=seed, validation=True, **options
    )


def check_samples(renderer, invalid="invalid"):
    """Fail where Accumulate has left out a sample since the last cut: its mean is one of finite numbers whatever the
    frames were. The graph must have Accumulate's count as an output."""
    dropped = renderer.output(invalid)
    assert dropped.max() == 0, f"{dropped.sum():.0f} samples were NaN, infinite or too large"


def image_after(renderer, frames, output="image"):
    """The output after so many more frames."""
    renderer.render(frames)
    return renderer.output(output)


def refusal(action, *arguments, **keywords):
    """The text of the restirpg.Error that the call must raise."""
    with pytest.raises(restirpg.Error) as caught:
        action(*arguments, **keywords)
    return str(caught.value)


def one_line_refusal(action, *arguments, **keywords):
    """That text, which must be one line."""
    text = refusal(action, *arguments, **keywords)
    assert "\n" not in text
    return text


def frame_graph(**accumulate):
    """The path tracer with each frame's own radiance and emission as outputs, besides their mean and variance."""
    graph = restirpg.Graph("Frames")
    gbuffer = graph.add("gbuffer", "GBuffer", jitter=True)
    paths = graph.add("paths", "PathTracerGuided", surface=gbuffer.surface, direct=True, bounces=2)
    image = graph.add(
        "accumulate",
        "Accumulate",
        indirect=paths.radiance,
        emission=gbuffer.emission,
        history=restirpg.prev("accumulate.sums"),
        **accumulate,
    )
    graph.output("mean", image.mean)
    graph.output("variance", image.variance)
    graph.output("radiance", paths.radiance)
    graph.output("emission", gbuffer.emission)
    return graph


def write_flying_panel(file, times=(0, 1), interpolation="LINEAR", strength=1):
    """A glTF whose one panel, of emission `strength`, fills the view until the first of `times`, s, and is 100 m aside
    from the last on. Its key times have no "min" and "max"."""
    positions, count = [-9, -9, 0, 9, -9, 0, 9, 9, 0, -9, 9, 0], len(times)
    data = struct.pack("<12f6H", *positions, 0, 1, 2, 0, 2, 3)
    data += struct.pack(f"<{4 * count}f", *times, *[0] * 3 * (count - 1), 100, 0, 0)
    ranges = [
        (0, 48),
        (48, 12),
        (60, 4 * count),
        (60 + 4 * count, 12 * count),
    ]  # positions, indices, times, translations
    views = [{"buffer": 0, "byteOffset": offset, "byteLength": length} for offset, length in ranges]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-9, -9, 0], "max": [9, 9, 0]},
        {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        {"bufferView": 2, "componentType": 5126, "count": count, "type": "SCALAR"},
        {"bufferView": 3, "componentType": 5126, "count": count, "type": "VEC3"},
    ]
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    file.write_text(
        json.dumps(
            {
                "asset": {"version": "2.0"},
                "scene": 0,
                "scenes": [{"nodes": [0, 1]}],
                "nodes": [{"name": "Panel", "mesh": 0}, {"name": "Camera", "camera": 0, "translation": [0, 0, 5]}],
                "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
                "materials": [
                    {
                        "emissiveFactor": [1, 1, 1],
                        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength}},
                    }
                ],
                "extensionsUsed": ["KHR_materials_emissive_strength"],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
                "animations": [
                    {
                        "samplers": [{"input": 2, "output": 3, "interpolation": interpolation}],
                        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                    }
                ],
                "buffers": [{"uri": uri, "byteLength": len(data)}],
                "bufferViews": views,
                "accessors": accessors,
            }
        )
    )
    return file


def write_outside(inside):
    """A copy of a glTF with one embedded buffer, in a folder below it: its buffer is a file beside `inside`."""
    document = json.loads(inside.read_text())
    buffer = document["buffers"][0]
    inside.with_suffix(".bin").write_bytes(base64.b64decode(buffer["uri"].partition(",")[2]))
    buffer["uri"] = f"%2e%2e/{inside.stem}.bin"
    outside = inside.parent / "below" / inside.name
    outside.parent.mkdir()
    outside.write_text(json.dumps(document))
    return outside


def write_far(near, far, place):
    """A copy of a .glb of one scene under a parent that stands at `place`, m."""
    data = near.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])
    document["nodes"].append({"children": document["scenes"][0]["nodes"], "translation": list(place)})
    document["scenes"][0]["nodes"] = [len(document["nodes"]) - 1]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    far.write_bytes(struct.pack("<4s4I", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest)
    return far
