"""The Python package: where a clone finds its binding module, its commands without it, names, help, stubs, kinds of
errors."""

import ast
import inspect
import os
import pydoc
import subprocess
import sys

import pytest
from renderer_scenes import ROOT, make_renderer, restirpg

from restirpg.harness.render import native_file

WHERE = "import restirpg; restirpg.Renderer; print(restirpg._native.__file__)"


def python(*arguments, **variables):
    """Run Python with no variable of the package's but these; a CompletedProcess with text output."""
    own = {name: value for name, value in os.environ.items() if not name.startswith(("RESTIRPG_", "PYTHON"))}
    return subprocess.run(
        [sys.executable, *map(str, arguments)], env={**own, **variables}, capture_output=True, text=True
    )


@pytest.mark.parametrize(
    "variables",
    [
        {"PYTHONPATH": "{scripts}", "RESTIRPG_BUILD": "{build}"},
        {"PYTHONPATH": "{build}/python"},
        {"PYTHONPATH": "{scripts}:{build}/python", "RESTIRPG_BUILD": "/nowhere"},
    ],
)
def test_the_binding_module_is_found(variables):
    places = {"scripts": str(ROOT / "scripts"), "build": str(native_file().parents[2])}
    done = python("-c", WHERE, **{name: text.format(**places) for name, text in variables.items()})
    assert done.stdout.strip() == str(native_file()), done.stderr


@pytest.mark.parametrize(
    "program, arguments",
    [("compare", ["a.py"]), ("reproduce", ["--list"]), ("see_guide", ["--scene", "a", "--pixel", "0", "0"])],
)
def test_a_program_without_the_binding_module_says_how_to_get_it(program, arguments, tmp_path):
    done = python(ROOT / "scripts" / f"{program}.py", *arguments, RESTIRPG_BUILD=str(tmp_path))
    assert done.returncode == 2 and done.stdout == ""
    assert (
        done.stderr.count("\n") == 1
        and done.stderr.startswith(f"{program}.py: ")
        and "build it with scripts/run" in done.stderr
    )


def test_a_program_without_a_module_says_which():
    done = python("-S", ROOT / "scripts" / "make_scenes.py", "--list")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("make_scenes.py: ") and "lacks the module 'numpy'" in done.stderr


def test_an_interpreter_that_does_not_know_its_name_reads_graph_files():
    code = f"import sys; sys.executable = ''; import restirpg; restirpg.load_graph('{ROOT}/graphs/path_tracer.py')"
    done = python("-c", code, PYTHONPATH=str(native_file().parents[1]))
    assert done.returncode == 0, done.stderr


def public(names):
    """Those without an underscore in front."""
    return {name for name in names if not name.startswith("_")}


def test_every_name_of_the_binding_module_is_the_packages():
    native = public(dir(sys.modules["restirpg._native"]))
    assert native < set(restirpg.__all__) == set(dir(restirpg))
    assert all(getattr(restirpg, name) is not None for name in restirpg.__all__)


def test_help_shows_what_the_binding_module_has():
    text = pydoc.plain(pydoc.render_doc(restirpg))
    for shown in ("class Renderer(", "class Scene(", "load_scene(", "class WrongValueError(", "move_camera("):
        assert shown in text


def members(namespace):
    """{class or function: the names in it} of the binding module."""
    return {
        name: public(vars(member)) if inspect.isclass(member) and not issubclass(member, Exception) else set()
        for name, member in vars(namespace).items()
        if not name.startswith("_")
    }


def test_the_stub_names_what_the_binding_module_has():
    tree = ast.parse((ROOT / "scripts/restirpg/_native.pyi").read_text())

    def names(body):
        """{what the statements define: its statements}"""
        found = {node.name: node.body for node in body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
        return found | {node.target.id: [] for node in body if isinstance(node, ast.AnnAssign)}

    stub = {name: public(names(inner)) for name, inner in names(tree.body).items() if not name.startswith("_")}
    assert stub == members(sys.modules["restirpg._native"])


def test_the_version_is_that_of_the_project(scene):
    assert f"VERSION {restirpg.__version__} " in (ROOT / "CMakeLists.txt").read_text()
    told = subprocess.run(
        [native_file().parents[2] / "bin/restirpg", "--version"], capture_output=True, text=True
    ).stdout
    assert told == f"restirpg {restirpg.__version__}, commit {restirpg.COMMIT}, plugin ABI {restirpg.PLUGIN_ABI}\n"


@pytest.mark.parametrize("read", [restirpg.load_scene, restirpg.load_graph, restirpg.read_exr])
@pytest.mark.parametrize("name", ["none.gltf", "none.py", "none.exr"])
def test_a_file_that_is_not_there_is_pythons_own_error_too(read, name, tmp_path):
    with pytest.raises(FileNotFoundError, match="none") as caught:
        read(tmp_path / name)
    assert isinstance(caught.value, restirpg.Error) and "\n" not in str(caught.value)


def test_a_wrong_value_is_pythons_own_error_too_and_a_closed_renderer_says_so(scene):
    with make_renderer(scene, size=(16, 16)) as renderer:
        assert renderer._repr_png_() is None
        renderer.render(1)
        assert renderer._repr_png_().startswith(b"\x89PNG")
        for wrong in (
            lambda: renderer.set("paths.bounces", "many"),
            lambda: renderer.set("paths.none", 1),
            lambda: renderer.set_everywhere("bounces", -1),
            lambda: renderer.set_time(-1),
            lambda: renderer.output("none"),
            lambda: renderer.move_node(10**6, [[1] * 4] * 4),
            lambda: renderer.move_camera(yfov=9),
            lambda: renderer.save("a.png"),
            lambda: make_renderer(scene, size=(0, 0)),
            lambda: make_renderer(scene, outputs=["none"]),
            lambda: make_renderer(scene, device="none"),
            lambda: make_renderer(scene, backend="none"),
            lambda: restirpg.describe_pass("None"),
            lambda: restirpg.load_scene(scene.file, camera=99),
            lambda: restirpg.Renderer(scene, 7, size=(16, 16)),
            lambda: restirpg.measure_errors([[1.0]], [[1.0]]),
        ):
            with pytest.raises(ValueError) as caught:
                wrong()
            assert isinstance(caught.value, restirpg.Error), wrong
    with pytest.raises(restirpg.Error, match="closed"):
        renderer.render(1)
