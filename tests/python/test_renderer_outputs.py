"""What a renderer gives: outputs, ports, saved pictures and their headers, times, memory, errors."""

import json
import os

import numpy as np
import pytest
from renderer_scenes import GRAPH, SIZE, frame_graph, image_after, make_renderer, refusal, restirpg, write_flying_panel


def test_times_and_memory_are_reported_for_every_pass(renderer):
    renderer.render(1)
    first = renderer.gpu_times()
    renderer.render(1)
    assert set(first) == {"gbuffer", "paths", "accumulate"} and min(first.values()) > 0
    for name, total in renderer.total_gpu_times().items():
        assert total == pytest.approx(first[name] + renderer.gpu_times()[name])
    memory = renderer.memory()
    assert memory["scene"] > 0
    assert memory["accumulate.mean"] == SIZE[0] * SIZE[1] * 12
    assert set(renderer.device_info) == {"name", "driver", "type", "backend"}
    assert renderer.size == SIZE


def test_what_a_pass_keeps_within_a_frame_is_in_its_memory(scene):
    """A path per pixel between two stages of reuse, and with pairs 40 B per pixel and partner, of which there are 6."""
    for name, bytes_per_pixel in (("restir_pg", 88), ("restir_pg_plus", 88 + 6 * 40)):
        renderer = make_renderer(scene, restirpg.load_graph(GRAPH.with_name(f"{name}.py")))
        assert "reuse.scratch" not in renderer.memory()
        renderer.render(2)
        assert renderer.memory()["reuse.scratch"] == SIZE[0] * SIZE[1] * bytes_per_pixel


def test_the_memory_of_a_scene_is_what_it_takes_now(renderer):
    renderer.render(1)
    before = renderer.memory()["scene"]
    aside = np.eye(4)
    aside[0, 3] = 0.1
    renderer.move_node("Tower", aside)  # which gets a hierarchy of its own
    renderer.render(1)
    assert renderer.memory()["scene"] > before


def test_a_saved_exr_holds_every_output_and_where_it_came_from(renderer, tmp_path):
    image = image_after(renderer, 2)
    renderer.save(tmp_path / "a.exr")
    assert restirpg.read_exr(tmp_path / "a.exr").tobytes() == image.tobytes()
    variance = restirpg.read_exr(tmp_path / "a.exr", layer="variance")
    assert variance.tobytes() == renderer.output("variance").tobytes()
    header = restirpg.read_exr_attributes(tmp_path / "a.exr")
    assert header["restirpg.seed"] == "0" and header["restirpg.frames"] == "2"
    assert header["restirpg.energyCompensation"] == "false"
    assert header["restirpg.sceneHash"] and '"bounces"' in header["restirpg.knobs"]
    renderer.save(tmp_path / "v.exr", half=True, output="variance")
    np.testing.assert_allclose(restirpg.read_exr(tmp_path / "v.exr"), variance, rtol=1e-3, atol=1e-6)
    assert "create it first" in refusal(renderer.save, tmp_path / "none" / "a.exr")
    assert sorted(os.listdir(tmp_path)) == ["a.exr", "v.exr"]


def test_a_header_has_what_it_takes_to_make_the_picture_again(tmp_path):
    file = write_flying_panel(tmp_path / "panel.gltf")
    description = json.loads(file.read_text())
    description["cameras"].append({"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}})
    description["nodes"].append({"name": "Flying camera", "camera": 1})
    description["scenes"][0]["nodes"].append(2)
    description["animations"][0]["channels"][0]["target"]["node"] = 2
    file.write_text(json.dumps(description))
    sky = tmp_path / "sky.exr"
    restirpg.write_exr(sky, {"": np.random.default_rng(1).uniform(0, 1, (4, 8, 3))})
    scene = restirpg.load_scene(file, camera=1, environment=str(sky))
    renderer = make_renderer(scene, seed=3, time=0.1, fps=7)
    moved = np.eye(4)
    moved[:3, 3] = (46, 2, -9)  # to where the camera flies by
    renderer.render(3)
    renderer.move_node("Panel", moved)
    renderer.cut()
    renderer.render(2)
    renderer.save(tmp_path / "a.exr")
    header = restirpg.read_exr_attributes(tmp_path / "a.exr")
    told = {name.removeprefix("restirpg."): value for name, value in header.items()}
    assert float(told["time"]) == pytest.approx(0.1 + 3 / 7) and (told["fps"], told["camera"]) == ("7", "1")
    assert told["environment"] == "sky.exr" and len(told["environmentHash"]) == 16
    assert json.loads(told["movedNodes"]) == {"nodes.Panel.matrix": moved.flatten().tolist()}

    again = make_renderer(
        restirpg.load_scene(file, camera=int(told["camera"]), environment=str(tmp_path / told["environment"])),
        json.loads(told["graph"]),
        seed=int(told["seed"]),
        size=tuple(map(int, told["size"].split("x"))),
        time=float(told["time"]),
        fps=float(told["fps"]),
    )
    again.edit(json.loads(told["movedNodes"]))
    image = renderer.output("image")
    assert image_after(again, int(told["frames"])).tobytes() == image.tobytes()
    assert image.max() > 1 and np.unique(image).size > 100  # the panel before a sky of less than 1

    restirpg.write_exr(sky, {"": np.ones((4, 8, 3))})
    for environment, named in ((str(sky), "sky.exr"), ("0.5,1,2", "0.5,1,2"), (None, None)):
        plain = make_renderer(restirpg.load_scene(file, environment=environment))
        plain.render(1)
        plain.save(tmp_path / "b.exr")
        other = restirpg.read_exr_attributes(tmp_path / "b.exr")
        assert other.get("restirpg.environment") == named
        assert (other.get("restirpg.environmentHash") is None) == (named != "sky.exr")
        assert other.get("restirpg.environmentHash") != told["environmentHash"]
        assert not {f"restirpg.{name}" for name in ("time", "fps", "camera", "movedNodes", "pose")} & other.keys()


def test_any_port_of_a_pass_is_an_output_where_it_is_asked_for_and_costs_nothing_where_not(scene, tmp_path):
    plain, asked = make_renderer(scene), make_renderer(scene, outputs=["albedo", "gbuffer.depth"])
    assert image_after(plain, 2).tobytes() == image_after(asked, 2).tobytes()
    assert asked.output_names[-2:] == ["albedo", "gbuffer.depth"] and asked.output_names[:-2] == plain.output_names
    assert asked.output("albedo").shape == (SIZE[1], SIZE[0], 3) and asked.output("albedo").max() > 0.1
    assert asked.output("gbuffer.depth").shape[:2] == (SIZE[1], SIZE[0]) and asked.output("gbuffer.depth").max() > 1
    assert set(asked.memory()) - set(plain.memory()) == {"gbuffer.albedo", "gbuffer.depth"}
    assert 'outputs=["albedo"]' in refusal(plain.output, "albedo")
    asked.save(tmp_path / "a.exr", output=["image", "albedo", "gbuffer.depth"])
    for name in ("albedo", "gbuffer.depth"):
        picture = asked.output(name)
        assert np.array_equal(restirpg.read_exr(tmp_path / "a.exr", name)[..., : picture.shape[2]], picture)
    again = make_renderer(scene, json.loads(restirpg.read_exr_attributes(tmp_path / "a.exr")["restirpg.graph"]))
    assert again.output_names == asked.output_names


def test_a_port_that_several_passes_have_is_asked_for_by_its_pass(scene):
    graph = restirpg.load_graph(GRAPH.with_name("restir_di.py"))
    both = make_renderer(scene, graph, outputs=["direct.radiance", "paths.radiance", "frame"])
    both.render(3)
    parts = [both.output(name).astype(float) for name in ("direct.radiance", "paths.radiance")]
    emission = both.read_port("gbuffer.emission").view(np.float32).reshape(parts[0].shape)
    np.testing.assert_allclose(both.output("frame"), sum(parts) + emission, rtol=1e-5, atol=1e-6)
    said = refusal(make_renderer, scene, graph, outputs=["radiance"])
    assert said == "graph 'ReSTIR DI' has several ports 'radiance'; name one of: direct.radiance, paths.radiance"
    assert "no output 'nonsense'" in refusal(make_renderer, scene, graph, outputs=["nonsense"])


def test_errors_measured_on_the_device_are_those_measured_on_the_host(scene, tmp_path):
    reference = image_after(make_renderer(scene, seed=1), 8)
    restirpg.write_exr(tmp_path / "reference.exr", {"": reference})
    graph = frame_graph()
    errors = graph.add(
        "errors", "ErrorMeasure", image=graph["accumulate"].mean, reference=str(tmp_path / "reference.exr")
    )
    graph.output("errors", errors.errors)
    graph.output("map", errors.map)
    renderer = make_renderer(scene, graph)
    host = restirpg.measure_errors(image_after(renderer, 2, "mean"), reference)
    raw = renderer.read_port("errors.errors")
    measured = [*raw[:16].view(np.float32), raw[16:].view(np.uint32)[0]]
    np.testing.assert_allclose(measured, list(host.values()), rtol=1e-5)
    assert renderer.output("map").shape == (SIZE[1], SIZE[0], 1)
    assert renderer.output("map").mean() == pytest.approx(host["mape"], rel=1e-5)
    assert "no image" in refusal(renderer.output, "errors")


def test_an_error_of_a_pass_arrives_as_restirpg_error(scene):
    graph = frame_graph()
    errors = graph.add("errors", "ErrorMeasure", image=graph["accumulate"].mean)
    graph.output("errors", errors.errors)
    assert "set its knob 'reference'" in refusal(make_renderer, scene, graph)


def test_reading_before_the_first_frame_is_refused(renderer):
    assert "render at least one frame" in refusal(renderer.output, "image")
    assert "it has: image" in refusal(renderer.output, "picture")
    assert renderer.output_names[0] == "image"
