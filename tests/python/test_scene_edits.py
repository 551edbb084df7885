"""Values of the scene that Python reads and changes, against scene files that were written with them; and
Renderer.reload."""

import json
import shutil
import struct

import numpy as np
import pytest
from renderer_scenes import GRAPH, restirpg

from restirpg.scenes import shapes
from restirpg.scenes.gltf import SceneFile, Texture, emitter, lambert

SIZE = (16, 16)
FRAMES = 2
LAMP = np.array([[1, 0, 0, 0], [0, 1, 0, 1.5], [0, 0, 1, 0.5], [0, 0, 0, 1]], float)
TURNED = np.array([[0.5, 0, 0.75, 0.25], [0, 1, 0, 0.25], [-0.75, 0, 0.5, 0], [0, 0, 0, 1]])
VALUES = {"materials.White.base_color": [0.25, 0.5, 0.75], "materials.White.metallic": 0.25, "materials.White.roughness": 0.5,
          "materials.Rust.emission": [0.5, 0.25, 0.125], "materials.Teal.transmission": 0.5, "lights.Lamp.intensity": [8, 8, 8],
          "environment.radiance": [0.5, 0.5, 0.5], "nodes.Tower.matrix": TURNED.tolist()}  # fmt: skip


def add_lights(document):
    """A lamp at a node, and a constant environment."""
    document["extensionsUsed"].append("KHR_lights_punctual")
    document["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 1.0}]}}
    document["nodes"].append(
        {"name": "Lamp", "matrix": LAMP.T.flatten().tolist(), "extensions": {"KHR_lights_punctual": {"light": 0}}}
    )
    document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)
    document["asset"]["extras"]["restirpg"]["environment"] = [0.125, 0.125, 0.125]


def put(document, values):
    """Write values into a glTF's JSON, each where the file has it."""

    def named(kind, name):
        return next(entry for entry in document[kind] if entry.get("name") == name)

    for path, value in values.items():
        kind, _, rest = path.partition(".")
        name, _, what = rest.rpartition(".")
        if kind == "materials":
            material = named(kind, name)
            core = material["pbrMetallicRoughness"]
            if what == "base_color":
                core["baseColorFactor"] = [*value, 1]
            elif what == "emission":
                material["emissiveFactor"] = value
            elif what == "transmission":
                material["extensions"]["KHR_materials_transmission"] = {"transmissionFactor": value}
                document["extensionsUsed"].append("KHR_materials_transmission")
            else:
                core[f"{what}Factor"] = value
        elif kind == "lights":
            document["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = value[0]
        elif kind == "environment":
            document["asset"]["extras"]["restirpg"]["environment"] = value
        else:
            node = named("nodes", name)
            node["matrix"] = np.transpose(value).flatten().tolist()
            for replaced in ("translation", "rotation", "scale"):
                node.pop(replaced, None)


@pytest.fixture(scope="module")
def write(scene_file, tmp_path_factory):
    """A function that writes the Cornell box with two lights more and these values, and loads it."""
    data = scene_file.read_bytes()
    (length,) = struct.unpack("<I", data[12:16])
    folder = tmp_path_factory.mktemp("edits")

    def with_values(values):
        document = json.loads(data[20 : 20 + length])
        add_lights(document)
        put(document, values)
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        rest = data[20 + length :]
        file = folder / f"{len(list(folder.iterdir()))}.glb"
        file.write_bytes(
            struct.pack("<4s4I", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest
        )
        return restirpg.load_scene(file)

    return with_values


def make(scene):
    return restirpg.Renderer(scene, restirpg.load_graph(GRAPH), size=SIZE, validation=True)


def picture(renderer):
    """After FRAMES frames from the first on."""
    renderer.cut()
    renderer.render(FRAMES)
    return renderer.output("image").tobytes()


@pytest.fixture(scope="module")
def edited(write):
    """A renderer that the tests edit, one after the other."""
    return make(write({}))


def test_every_value_gives_the_picture_of_a_file_that_has_it(edited, write):
    """One after the other, and so back to what the scene was."""
    shown = {picture(edited)}
    original = edited.parameters()
    for path, value in VALUES.items():
        edited.edit({path: value})
        assert np.allclose(edited.parameters()[path], value) and edited.frame == 0
        shown.add(picture(edited))
    assert len(shown) == 1 + len(VALUES)  # each is seen
    assert picture(edited) == picture(make(write(VALUES)))
    edited.edit({path: original[path] for path in VALUES})
    assert picture(edited) == picture(make(write({})))


def test_a_lights_intensity_moves_the_probabilities_of_selection(edited, write):
    """With the old table the mean would be right, but not the bytes."""
    values = {"lights.Lamp.intensity": [64, 64, 64]}
    edited.edit({"lights.Lamp.intensity": 64})  # one number stands for three
    assert picture(edited) == picture(make(write(values)))
    edited.edit({"lights.Lamp.intensity": 0})
    assert picture(edited) == picture(make(write({"lights.Lamp.intensity": [0, 0, 0]})))
    edited.edit({"lights.Lamp.intensity": 1})


def test_a_dark_emitter_that_an_edit_lights_has_its_texture(tmp_path):
    texels = np.zeros((2, 2, 3), np.uint8)
    texels[0, 0], texels[1, 1] = 255, 128
    panel = emitter("Panel", (1.0, 1.0, 1.0), emission_texture=Texture(texels, nearest=True))

    def panel_scene(name, factor):
        scene = SceneFile(name, 0, environment=(0, 0, 0))
        scene.add("Panel", (shapes.quad((-1, -1, 0), (2, 0, 0), (0, 2, 0)), panel))
        scene.add_camera((0, 0, 2.5), (0, 0, 0), 40.0)
        scene._json["materials"][0]["emissiveFactor"] = [factor] * 3
        return restirpg.load_scene(scene.write(tmp_path))

    lit, dark = make(panel_scene("lit", 1)), make(panel_scene("dark", 0))
    assert picture(dark) != picture(lit)
    dark.edit({"materials.Panel.emission": 1})
    assert picture(dark) == picture(lit)
    dark.edit({"materials.Panel.emission": 0})
    assert picture(dark) == picture(make(panel_scene("dark_again", 0)))


STRETCHED = np.diag([3.0, 1, 1, 1])
FAR = np.array([[1, 0, 0, 5000], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], float)
CAMERA = np.array([[1, 0, 0, 5000.3], [0, 1, 0, 0.4], [0, 0, 1, 2], [0, 0, 0, 1]])


@pytest.mark.parametrize(
    "values",
    [
        {"nodes.Triangle.matrix": STRETCHED},  # its longest edge is another one
        {"nodes.Triangle.matrix": FAR, "nodes.Camera.matrix": CAMERA},  # far from the origin for its size
    ],
    ids=["stretched", "far"],
)
def test_what_follows_from_matrices_is_that_of_a_file(tmp_path, values):
    """The corner at which a triangle starts and the origin of coordinates show in the hits, to the byte."""

    def renderer_of(name, values):
        scene = SceneFile(name, 0, environment=(1, 1, 1))
        corners = np.array([(0, 0, 0), (1, 0, 0), (0.4, 0.9, 0)], np.float32)
        mesh = shapes.Mesh(
            corners, np.tile(np.float32([0, 0, 1]), (3, 1)), np.zeros((3, 2), np.float32), np.array([[0, 1, 2]])
        )
        scene.add("Triangle", (mesh, lambert("White")))
        scene.add_camera((0.4, 0.4, 2), (0.4, 0.4, 0), 40.0)
        put(scene._json, values)
        return make(restirpg.load_scene(scene.write(tmp_path)))

    def hits(renderer):
        return picture(renderer), bytes(renderer.read_port("gbuffer.surface"))

    one = renderer_of("plain", {})
    plain = hits(one)
    original = {path: one.parameters()[path] for path in values}
    one.edit(values)
    assert hits(one) == hits(renderer_of("with_values", values)) != plain
    one.edit(original)
    assert hits(one) == hits(renderer_of("with_matrices", original))


def test_an_edit_that_makes_the_scene_too_large_is_refused(edited):
    before = edited.parameters(), picture(edited)
    with pytest.raises(restirpg.Error, match="the scene reaches beyond 3000000000 m; check the scale") as caught:
        edited.edit({"nodes.Tower.matrix": np.diag([1e10, 1, 1, 1])})
    assert isinstance(caught.value, ValueError) and (edited.parameters(), picture(edited)) == before


def test_an_edit_is_this_renderers_alone_and_files_tell_of_it(write, tmp_path):
    scene = write({})
    one, other = make(scene), make(scene)
    before = picture(other)
    one.edit({"materials.White.base_color": [0.25, 0.25, 0.25]})
    assert picture(one) != before == picture(other)
    one.save(tmp_path / "edited.exr")
    other.save(tmp_path / "plain.exr")
    assert json.loads(restirpg.read_exr_attributes(tmp_path / "edited.exr")["restirpg.sceneEdits"]) == {
        "materials.White.base_color": [0.25] * 3
    }
    assert "restirpg.sceneEdits" not in restirpg.read_exr_attributes(tmp_path / "plain.exr")


def test_a_node_that_was_moved_is_told_where_it_is(edited):
    edited.move_node("Tower", TURNED)
    assert np.allclose(edited.parameters()["nodes.Tower.matrix"], TURNED)
    edited.edit({"nodes.Tower.matrix": np.eye(4)})
    assert np.allclose(edited.parameters()["nodes.Tower.matrix"], np.eye(4))


@pytest.mark.parametrize(
    "values, kind, words",
    [
        (
            {"materials.Whit.roughness": 0.5},
            ValueError,
            "no parameter 'materials.Whit.roughness'; did you mean 'materials.White.roughness'",
        ),
        (
            {"materials.White.roughness": 1.5},
            ValueError,
            "'materials.White.roughness' cannot be 1.5: must lie between 0 and 1",
        ),
        ({"materials.White.base_color": [1, 1]}, ValueError, "takes 3 numbers, not 2"),
        ({"materials.White.roughness": "rough"}, ValueError, "takes numbers"),
        ({"materials.99.roughness": 0.5}, IndexError, "the scene has 6 materials, counted from 0"),
        ({"materials.0.roughness": 0.5}, ValueError, "called 'White'"),
        ({"lights.7.intensity": 1}, IndexError, "has 1 lights"),
        ({"lights.Lamp.intensity": [1, -1, 1]}, ValueError, "at least 0"),
        ({"nodes.Tower.matrix": np.full((4, 4), np.nan)}, ValueError, "must be finite"),
        ({5: 1}, ValueError, "5 is no path"),
        ({"materials.White.roughness": 0.25, "materials.White.colour": 1}, ValueError, "White.colour"),
    ],
)
def test_what_cannot_be_is_refused_by_name_and_changes_nothing(edited, values, kind, words):
    before = edited.parameters()
    with pytest.raises(restirpg.Error, match=words) as caught:
        edited.edit(values)
    assert isinstance(caught.value, kind) and edited.parameters() == before


def test_the_scenes_cameras_are_told(edited):
    (camera,) = edited.scene_cameras()
    assert camera.pop("name") == "Camera" and camera == edited.camera


def test_reload_takes_an_edited_graph_and_an_edited_shader(write, tmp_path, monkeypatch):
    shaders, file = tmp_path / "shaders", tmp_path / "own.py"
    shutil.copytree(GRAPH.parents[1] / "framework" / "shaders", shaders)
    monkeypatch.setenv("RESTIRPG_SHADERS", str(shaders))
    file.write_text(GRAPH.read_text())
    renderer = restirpg.Renderer(write({}), restirpg.load_graph(file), size=SIZE, validation=True, outputs=["depth"])
    first = picture(renderer)
    renderer.set("paths.bounces", 1)
    single = picture(renderer)

    file.write_text(GRAPH.read_text() + "graph.name = 'Edited'\n")
    renderer.reload()
    assert renderer.frame == 0 and renderer.get("paths.bounces") == 1 and "depth" in renderer.output_names
    assert picture(renderer) == single != first
    file.write_text("from restirpg import Graph\ngraph = Graph('broken')\ngraph.add('x', 'NoSuchPass')\n")
    with pytest.raises(restirpg.Error, match=r"own.py:3: .*NoSuchPass"):
        renderer.reload()

    random, source = shaders / "math/random.glsl", (shaders / "math/random.glsl").read_text()
    random.write_text(source + "\nthis is no GLSL\n")
    with pytest.raises(restirpg.Error, match=rf"random.glsl:{source.count(chr(10)) + 2}"):
        renderer.reload(restirpg.load_graph(GRAPH))
    assert picture(renderer) == single  # what was refused has changed nothing
    random.write_text(source)
    renderer.set("paths.bounces", 0)
    renderer.reload(restirpg.load_graph(GRAPH))
    assert renderer.get("paths.bounces") == 0 and picture(renderer) not in (first, single)
