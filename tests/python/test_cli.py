"""The command line program: what it prints, what it refuses, what it writes."""

import hashlib
import os
import pty
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import renderer_scenes

ROOT = Path(__file__).parents[2]
BUILD = Path(os.environ.get("RESTIRPG_BUILD", ROOT / "build"))
PROGRAM = BUILD / "bin" / "restirpg"
GRAPH = ROOT / "graphs" / "path_tracer.py"


def restirpg(*arguments, folder=ROOT):
    """Run the program. Returns (exit code, standard output, standard error)."""
    done = subprocess.run(
        [PROGRAM, *map(str, arguments)], cwd=folder, text=True, capture_output=True, timeout=600, check=False
    )
    return done.returncode, done.stdout, done.stderr


def refusal(*arguments, folder=ROOT):
    """The one line on standard error of a run that must be refused without a word on standard output."""
    code, output, errors = restirpg(*arguments, folder=folder)
    assert (code, output) == (2, ""), errors
    assert errors.count("\n") == 1
    return errors.rstrip("\n")


@pytest.fixture(scope="session")
def scene(tmp_path_factory):
    """A Cornell box."""
    folder = tmp_path_factory.mktemp("scenes")
    subprocess.run([sys.executable, ROOT / "scripts" / "make_scenes.py", "cornell_box", "--out", folder], check=True)
    return folder / "cornell_box.glb"


def render_command(scene, frames=2):
    """A quick rendering of the scene to a.exr of the working directory."""
    return ["render", GRAPH, "--scene", scene, "--size", "24x16", "--frames", str(frames), "-o", "a.exr"]


def test_rendering_writes_what_it_says(scene, tmp_path):
    code, output, errors = restirpg(*render_command(scene), "--png", "a.png", folder=tmp_path)
    assert (code, errors) == (0, "")
    assert re.match(r".+, .+, (software|rayquery) back end\n2 frames in ", output)
    for line in ("gbuffer", "paths", "accumulate", "all", "wrote a.exr", "wrote a.png"):
        assert line in output
    assert sorted(os.listdir(tmp_path)) == ["a.exr", "a.png"]


@pytest.fixture(scope="module")
def one_kernel(tmp_path_factory):
    """A graph of a single cheap kernel."""
    file = tmp_path_factory.mktemp("graphs") / "one_kernel.py"
    file.write_text(
        'from restirpg import Graph\ngraph = Graph("one")\ngraph.output("image", graph.add("a", "GBuffer").albedo)\n'
    )
    return file


@pytest.mark.parametrize("trouble", ["a file in its place", "no HOME"])
def test_rendering_goes_on_without_a_cache(scene, one_kernel, tmp_path, trouble):
    variables = {**os.environ, "RESTIRPG_CACHE_DIR": "/dev/full/cache", "HOME": str(tmp_path)}
    if trouble == "no HOME":
        for name in ("HOME", "XDG_CACHE_HOME", "RESTIRPG_CACHE_DIR"):
            variables.pop(name, None)
    command = [PROGRAM, "render", one_kernel, "--scene", scene, "--size", "8x8", "--frames", "1", "-o", "a.exr"]
    done = subprocess.run(
        list(map(str, command)), cwd=tmp_path, env=variables, text=True, capture_output=True, timeout=600, check=False
    )
    assert done.returncode == 0 and (tmp_path / "a.exr").exists(), done.stderr
    warnings = done.stderr.splitlines()
    assert len(warnings) == 1 and warnings[0].startswith("warning: ") and "RESTIRPG_CACHE_DIR" in warnings[0]


def test_same_seed_same_bytes(scene, tmp_path):
    def digest(seed):
        assert restirpg(*render_command(scene), "--seed", seed, folder=tmp_path)[0] == 0
        return hashlib.sha256((tmp_path / "a.exr").read_bytes()).hexdigest()

    first = digest(7)
    assert digest(7) == first
    assert digest(8) != first


def test_errors_against_the_picture_itself_are_zero(scene, tmp_path):
    command = render_command(scene)
    assert restirpg(*command, folder=tmp_path)[0] == 0
    assert refusal(*command, "--reference", "a.exr", folder=tmp_path).startswith(
        "a.exr: cannot write: it is the file a.exr, which was read"
    )
    command[-1] = "b.exr"
    code, output, _ = restirpg(*command, "--reference", "a.exr", folder=tmp_path)
    assert code == 0
    assert "against a.exr: MAPE 0%, relMSE 0, RMSE 0, bias +0%, invalid pixels 0\n" in output
    _, output, _ = restirpg(*command, "--reference", "a.exr", "--bounces", 0, folder=tmp_path)
    assert re.search(r"MAPE [\d.]+%, .* bias -", output)


def test_a_full_disk_is_one_line_and_keeps_the_old_picture(scene, tmp_path):
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=4k", "tmpfs", tmp_path], check=False).returncode:
        pytest.skip("a full disk needs a small tmpfs, which only root can mount: none is written to")
    try:
        (tmp_path / "a.png").write_text("old")
        command = [*render_command(scene)[:-2], "--png", "a.png"]
        code, output, errors = restirpg(*command, folder=tmp_path)
        assert (code, errors) == (
            2,
            "a.png: cannot write: No space left on device; free some space or choose another folder\n",
        )
        assert "wrote" not in output
        assert os.listdir(tmp_path) == ["a.png"]
        assert (tmp_path / "a.png").read_text() == "old"
    finally:
        subprocess.run(["umount", tmp_path], check=True)


@pytest.mark.parametrize("command", (["graph", GRAPH, "--dot"], ["describe"], ["--help"]))
def test_a_full_standard_output_is_one_line(command):
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run([PROGRAM, *command], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert re.fullmatch(r".*cannot write.*No space left on device.*\n", done.stderr)


def test_the_progress_bar_is_drawn_on_terminals_only(scene, tmp_path):
    command = render_command(scene, frames=3)
    master, slave = pty.openpty()
    subprocess.run([PROGRAM, *map(str, command)], cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=slave, check=True)
    os.close(slave)
    drawn = os.read(master, 65536).decode()
    os.close(master)
    assert "compiling kernels [" in drawn
    assert "rendering [" in drawn and "0/3" in drawn
    assert drawn.endswith("\r\x1b[K"), "the line is cleared at the end"
    assert restirpg(*command, folder=tmp_path)[2] == ""


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["--size", "24"], "--size 24: write WIDTHxHEIGHT in pixels, as in 640x360"),
        (["--size", "24x16x"], "--size 24x16x: write WIDTHxHEIGHT in pixels, as in 640x360"),
        (["--size", "-1x16"], "--size -1x16: write WIDTHxHEIGHT in pixels, as in 640x360"),
        (["--size", "0x16"], "an image of 0x16 pixels cannot be rendered; each side is 1 to 16384"),
        (["--window", "1,2,3"], "restirpg: --window: At least 4 required but received 3; see restirpg --help"),
        (["--window", "20,0,8,8"], "a window of 8x8 pixels at 20,0 does not lie in the picture of 24x16"),
        (["--frames", "0"], "restirpg: --frames: Value 0 not in range 1 to 100000000; see restirpg --help"),
        (
            ["--frames", "many"],
            "restirpg: --frames: Value many not in range 1 to 100000000; see restirpg --help",
        ),
        (["--fps", "-1"], "-1 frames a second: must be 0, where the scene stands still, or finite and at least 1e-06"),
        (["--time", "nan"], "a time of nan s: must be finite and at least 0"),
        (["--time", "-1"], "a time of -1 s: must be finite and at least 0"),
        (["--exposure", "nan"], "--exposure nan: must be a number of stops from -100 to 100"),
        (["--seed", "-1"], None),
        (["--bounces", "nan"], None),
        (["--keep-every", "-1"], None),
        (
            ["-o", "/proc/a.exr"],
            "/proc/a.exr: cannot write: No such file or directory; choose another folder",
        ),
        (
            ["--output", "invalid", "--reference", "none.exr"],
            "output 'invalid' has 1 channels, a --reference is compared with 3; choose another with --output",
        ),
        (
            ["--nonsense"],
            "restirpg: The following argument was not expected: --nonsense; see restirpg --help",
        ),
        (["--camera", "5"], "SCENE: there is no camera 5; the scene has 1, counted from 0"),
        (["--set", "paths.bounces"], "--set paths.bounces: write PASS.KNOB=VALUE, as in paths.bounces=4"),
        (
            ["--set", "path.bounces=1"],
            "graph 'Path tracer' has no pass 'path'; passes: gbuffer, paths, accumulate; did you mean 'paths'?",
        ),
        (
            ["--set", "paths.bounces=x"],
            "pass 'paths' (PathTracerGuided): knob 'bounces' must be a whole number from 0 to 64, not \"x\"",
        ),
        (
            ["--output", "picture"],
            "graph 'Path tracer' has no output 'picture'; it has: image, variance, invalid; and, of its passes: "
            "gbuffer.emission, gbuffer.normal, gbuffer.geometric_normal, gbuffer.albedo, gbuffer.depth, gbuffer.motion, "
            "gbuffer.material, paths.radiance, accumulate.mean, accumulate.variance, accumulate.invalid",
        ),
        (["-o", "a.jpg"], "a.jpg: the name must end in .exr"),
        (["--png", "a.exr"], "a.exr: the name must end in .png"),
        (["-o", "none/a.exr"], "none/a.exr: cannot write: the folder none does not exist; create it first"),
        (
            ["--reference", "none.exr"],
            "none.exr: cannot read: No such file or directory; name an existing EXR file",
        ),
        (["--scene", "none.glb"], None),
        (["--device", "Voodoo"], None),
        (["--backend", "magic"], None),
        (["--environment", "none.exr"], None),
        (["--ocio", "none.ocio", "--png", "a.png"], None),
    ],
)
def test_bad_arguments_are_one_line(scene, tmp_path, arguments, message):
    command = render_command(scene, frames=1)
    for option, value in zip(arguments[::2], arguments[1::2]):
        if option in command:
            command[command.index(option) + 1] = value
        else:
            command += [option, value]
    if len(arguments) == 1:
        command += arguments
    said = refusal(*command, folder=tmp_path)
    if message:
        assert said == message.replace("SCENE", str(scene))
    else:
        assert arguments[1] in said
    assert os.listdir(tmp_path) == []


def header_of(file):
    """The text attributes of an EXR file's header."""
    return renderer_scenes.restirpg.read_exr_attributes(file)


def test_a_file_that_was_read_is_not_written(scene, tmp_path):
    own = tmp_path / "own.glb"
    shutil.copy(scene, own)
    (tmp_path / "link.exr").symlink_to("own.glb")
    os.link(own, tmp_path / "hard.png")
    sky = tmp_path / "sky.exr"
    renderer_scenes.restirpg.write_exr(sky, {"": np.ones((2, 4, 3))})
    before = own.read_bytes(), sky.read_bytes()
    for output, read in (["-o", "link.exr"], own), (["--png", "hard.png"], own), (["-o", "sky.exr"], sky):
        said = refusal(
            "render", GRAPH, "--scene", own, "--environment", sky, "--size", "16x16", *output, folder=tmp_path
        )
        assert said == f"{output[1]}: cannot write: it is the file {read}, which was read; choose another name"
    assert (own.read_bytes(), sky.read_bytes()) == before


def test_a_scenes_own_bounce_cap_is_replaced(tmp_path):
    file = renderer_scenes.write_flying_panel(tmp_path / "panel.gltf")
    file.write_text(
        file.read_text().replace('"version": "2.0"', '"version": "2.0", "extras": {"restirpg": {"bounces": 20}}')
    )
    command = ["render", GRAPH.with_name("restir_pg.py"), "--scene", file, *render_command(file, frames=1)[4:]]
    said = refusal(*command, folder=tmp_path)
    assert said.startswith(f"{file}: asset.extras.restirpg.bounces is 20: ") and "--bounces N" in said
    for option in (["--bounces", "3"], ["--set", "paths.bounces=3"]):
        assert restirpg(*command, *option, "--time", "0.5", "--fps", "8", folder=tmp_path)[0] == 0
        header = header_of(tmp_path / "a.exr")
        assert '"bounces":3' in header["restirpg.knobs"] and "restirpg.camera" not in header
        assert (header["restirpg.time"], header["restirpg.fps"]) == ("0.5", "8")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_rendering_keeps_what_there_is(scene, tmp_path, number):
    command = [PROGRAM, *map(str, render_command(scene, frames=1000000))]
    with subprocess.Popen(command, cwd=tmp_path, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as program:
        try:
            assert "back end" in program.stdout.readline()
            program.send_signal(number)
            output, errors = program.communicate(timeout=60)
        finally:
            program.kill()
    assert program.returncode == -number
    kept = int(re.search(r"interrupted after (\d+) of 1000000 frames, which are kept\n", errors)[1])
    assert output.endswith("wrote a.exr\n") and kept > 0
    assert header_of(tmp_path / "a.exr")["restirpg.frames"] == str(kept)


def test_every_so_many_frames_are_kept(scene, tmp_path):
    command = [PROGRAM, *map(str, render_command(scene, frames=1000000)), "--keep-every", "3"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL) as program:
        while not (tmp_path / "a.exr").exists() and program.poll() is None:
            time.sleep(0.01)
        program.kill()
    assert int(header_of(tmp_path / "a.exr")["restirpg.frames"]) % 3 == 0


def test_a_name_steers_no_terminal(tmp_path):
    said = refusal("render", "g\x1b[2J\n.py", "--scene", "s", "-o", "a.exr", folder=tmp_path)
    assert said.startswith("g\\x1b[2J\\n.py: cannot read the graph file")
    assert refusal("rend\x1b[2J").startswith("restirpg: there is no subcommand 'rend\\x1b[2J'")
    assert "\x1b" not in refusal("render", "--\x1b[2J")


@pytest.mark.parametrize(
    "kilobytes", [300000, 600000, 1000000]
)  # where drivers crash when they start, and when they compile
@pytest.mark.parametrize("validation", ["0", "1"])
def test_no_memory_is_one_line(scene, tmp_path, kilobytes, validation):
    limited = ["bash", "-c", f'ulimit -v {kilobytes}; exec "$@"', "bash", str(PROGRAM)]
    done = subprocess.run(
        [*limited, *map(str, render_command(scene))],
        cwd=tmp_path,
        text=True,
        capture_output=True,
        check=False,
        env={**os.environ, "RESTIRPG_VALIDATION": validation},
    )
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "raise that limit" in done.stderr, done.stderr
    assert os.listdir(tmp_path) == []


def test_a_picture_must_go_somewhere(scene):
    assert refusal("render", GRAPH, "--scene", scene).startswith("nothing to do with the picture; name a file with -o")


def test_subcommands_are_asked_for():
    assert refusal() == "restirpg: A subcommand is required; see restirpg --help"
    assert refusal("rendre") == (
        "restirpg: there is no subcommand 'rendre'; subcommands: render, describe, graph, devices, view; "
        "did you mean 'render'?"
    )
    assert refusal("render") == "restirpg: GRAPH is required; see restirpg --help"


def test_the_viewer_is_the_package_s_program():
    code, output, errors = restirpg("view", "--help")
    assert code == 0 and output.startswith("usage: restirpg view"), errors
    assert refusal("view", GRAPH, "--scene", "nowhere.glb").startswith("restirpg view: nowhere.glb: ")


def test_graph_mistakes_are_collected_and_located(tmp_path):
    (tmp_path / "g.py").write_text(
        "from restirpg import Graph, prev\n"
        "graph = Graph('G')\n"
        "gbuffer = graph.add('gbuffer', 'GBuffer', jiter=True)\n"
        "paths = graph.add('paths', 'PathTracerGuided', surface=gbuffer.surfaces)\n"
        "graph.output('image', paths.radiance)\n"
    )
    code, output, errors = restirpg("graph", "g.py", folder=tmp_path)
    assert (code, output) == (2, "")
    assert errors.splitlines()[:2] == [
        "g.py:3: pass 'gbuffer' (GBuffer) has no knob 'jiter'",
        "    knobs: jitter        did you mean 'jitter'?",
    ]
    assert errors.splitlines()[2] == (
        "g.py:4: input 'surface' of pass 'paths' (PathTracerGuided) reads gbuffer.surfaces, "
        "but pass 'gbuffer' (GBuffer) has no output 'surfaces'"
    )


def test_a_graph_is_printed_in_order_and_for_graphviz():
    code, output, errors = restirpg("graph", "graphs/path_tracer.py")
    assert (code, errors) == (0, "")
    assert re.search(r"0 +gbuffer +GBuffer +graphs/path_tracer.py:\d+\n +1 +paths .*\n +2 +accumulate ", output)
    assert re.search(r"accumulate.sums +accumulate.history +AccumulatorState +one frame later\n", output)
    assert restirpg("graph", "graphs/path_tracer.py", "--dot")[1].startswith('digraph "Path tracer" {\n')


@pytest.mark.parametrize(("width", "bits"), [(None, "128 bits"), ("256", "256 bits")])
def test_lavapipe_has_narrow_vectors_unless_the_user_says_otherwise(width, bits):
    environment = {name: value for name, value in os.environ.items() if name != "LP_NATIVE_VECTOR_WIDTH"}
    environment |= {"LP_NATIVE_VECTOR_WIDTH": width} if width else {}
    done = subprocess.run([PROGRAM, "devices"], env=environment, text=True, capture_output=True)
    lavapipe = [line for line in done.stdout.splitlines() if "llvmpipe" in line]
    if not lavapipe:
        pytest.skip("no lavapipe among the devices")
    assert bits in lavapipe[0]


def test_pictures_are_the_same_with_validation_and_without(scene, tmp_path):
    """With it kernels are pipelines, which the other tests render with; without it they are shader objects on
    lavapipe, from SPIR-V in the first process and from their kept binaries in the second."""
    pictures = []
    for validation in ("1", "0", "0"):
        environment = {**os.environ, "RESTIRPG_VALIDATION": validation, "RESTIRPG_CACHE_DIR": str(tmp_path / "cache")}
        command = ["render", "graphs/restir_pg.py", "--scene", scene, "--size", "24x16", "--frames", "3"]
        command = [PROGRAM, *map(str, command), "-o", tmp_path / "a.exr"]
        subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, timeout=600, check=True)
        pictures.append((tmp_path / "a.exr").read_bytes())
    assert pictures[1] == pictures[0]
    assert pictures[2] == pictures[0]
    if "llvmpipe" in restirpg("devices")[1].splitlines()[1]:
        assert len(list((tmp_path / "cache" / "binary").iterdir())) == 14  # one per kernel of restir_pg


def test_devices_are_listed():
    code, output, errors = restirpg("devices")
    assert (code, errors) == (0, "")
    assert re.match(r"# +name +driver +type +back ends +usable\n0 ", output)


def test_an_unknown_pass_type_is_one_line():
    said = refusal("describe", "GBufer")
    assert said.startswith("there is no pass type 'GBufer'; pass types: Accumulate, ")
    assert said.endswith("; did you mean 'GBuffer'?")


def test_descriptions_fit_a_terminal_of_100_columns():
    code, output, errors = restirpg("describe")
    assert (code, errors) == (0, "")
    assert not [line for line in output.splitlines() if len(line) > 100]
    assert "one of cell, level, samples," in " ".join(output.split())  # choices of a knob, wrapped


def test_ports_of_passes_are_written_by_name(scene, tmp_path):
    command = [*render_command(scene), "--output", "image", "--output", "depth", "--output", "gbuffer.albedo"]
    assert restirpg(*command, folder=tmp_path)[0] == 0
    data = (tmp_path / "a.exr").read_bytes()
    assert b"depth.Y" in data and b"albedo.R" in data and b"variance" not in data.split(b"restirpg.graph")[0]


def test_bash_completes_pass_types_and_options():
    def completed(*words):
        script = (
            f"source {ROOT}/scripts/completion.bash; COMP_WORDS=({' '.join(words)}); "
            "COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _restirpg; printf '%s\\n' \"${COMPREPLY[@]}\""
        )
        return subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True).stdout.split()

    assert completed(str(PROGRAM), "des") == ["describe"]
    assert completed(str(PROGRAM), "describe", "GuidingS") == ["GuidingScreen", "GuidingSplat"]
    assert completed(str(PROGRAM), "render", "--exp") == ["--exposure"]
    assert completed(str(PROGRAM), "render", f"{ROOT}/graphs/restir_pg.") == [f"{ROOT}/graphs/restir_pg.py"]


def test_the_benchmarks_refuse_in_one_line_and_show_their_options(scene, tmp_path):
    (tmp_path / "g.py").write_text("from restirpg import Graph\ngraph = Graph('G')\ngraph.add('a', 'Nope')\n")
    program = BUILD / "bin" / "restirpg_bench"

    def said(*arguments):
        done = subprocess.run([program, *arguments], cwd=tmp_path, text=True, capture_output=True, check=False)
        assert (done.returncode, done.stdout) == (2, ""), done.stderr
        return done.stderr

    assert (
        said("--graphs", "none.py")
        == "restirpg_bench: none.py: cannot read the graph file: No such file or directory\n"
    )
    assert said("--graphs", "g.py").startswith("restirpg_bench: g.py:3: there is no pass type 'Nope'")
    assert (
        said("--scenes", tmp_path)
        == f"restirpg_bench: {tmp_path}: no such scene; scripts/make_scenes.py writes the embedded ones\n"
    )
    assert said("--scenes", scene, "--backends", "magic").startswith("restirpg_bench: no back end 'magic'")
    assert said("--scenes", scene, "--benchmark_filter=none") == "Failed to match any benchmarks against regex: none\n"
    assert said("--seed", "x") == "restirpg_bench: Could not convert: --seed = x; --help lists the options\n"
    assert said("--nonsense") == "restirpg_bench: '--nonsense' is no option; --help lists them\n"
    options = subprocess.run([program, "--help"], text=True, capture_output=True, check=True).stdout
    assert all(f"--{name} " in options for name in ("graphs", "scenes", "sizes", "backends", "device", "seed"))
    assert "--benchmark_filter" in options


@pytest.mark.parametrize("readme", sorted((ROOT / "passes").glob("*/README.md")), ids=lambda file: file.parent.name)
def test_the_tables_of_a_readme_are_those_the_pass_declares(readme):
    code, output, errors = restirpg("describe", readme.parent.name, "--markdown")
    assert (code, errors) == (0, "")
    assert output in readme.read_text()


def test_a_python_program_answers_a_shell_that_asks_for_completions():
    pytest.importorskip(
        "argcomplete", reason="argcomplete is not installed: no completion of a Python program is tried"
    )
    line = f"{ROOT}/scripts/compare.py --den"
    environment = {
        **os.environ,
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_IFS": "\n",
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
    }
    run = subprocess.run(
        ["bash", "-c", f"/usr/bin/python3 {ROOT}/scripts/compare.py 8>&1 >/dev/null"],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.stdout.split() == ["--denoise"], run.stderr
