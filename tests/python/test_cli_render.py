"""`restirpg render`: what it prints, what it refuses, what it writes."""

import fcntl
import hashlib
import os
import pty
import re
import shutil
import signal
import subprocess
import termios
import time

import numpy as np
import pytest
import renderer_scenes
from program import GRAPH, PROGRAM, ROOT, refusal, restirpg


@pytest.fixture(scope="session")
def scene(scene_file):
    """The file of the Cornell box."""
    return scene_file


def render_command(scene, frames=2):
    """A quick rendering of the scene to a.exr of the working directory."""
    return ["render", GRAPH, "--scene", scene, "--size", "24x16", "--frames", str(frames), "-o", "a.exr"]


@pytest.fixture(scope="module")
def one_kernel(tmp_path_factory):
    """A graph of a single cheap kernel."""
    file = tmp_path_factory.mktemp("graphs") / "one_kernel.py"
    file.write_text(
        'from restirpg import Graph\ngraph = Graph("one")\ngraph.output("image", graph.add("a", "GBuffer").albedo)\n'
    )
    return file


def test_rendering_writes_what_it_says(scene, tmp_path):
    code, output, errors = restirpg(*render_command(scene), "--png", "a.png", folder=tmp_path)
    assert (code, errors) == (0, "")
    assert re.match(r".+, .+, (software|rayquery) back end\n2 frames in ", output)
    for line in ("gbuffer", "paths", "accumulate", "all", "wrote a.exr", "wrote a.png"):
        assert line in output
    assert sorted(os.listdir(tmp_path)) == ["a.exr", "a.png"]


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


def test_a_reference_of_another_scene_is_refused(scene, tmp_path):
    """And one whose header says nothing is not."""
    for name, attributes in (("other", {"restirpg.sceneHash": "0" * 16, "restirpg.scene": "hall.glb"}), ("silent", {})):
        renderer_scenes.restirpg.write_exr(
            tmp_path / f"{name}.exr", {"": np.ones((16, 24, 3), np.float32)}, attributes=attributes
        )
    command = render_command(scene)
    line = refusal(*command, "--reference", "other.exr", folder=tmp_path)
    assert line.startswith(
        "other.exr: this reference is of another scene, or of another version of it (hall.glb, hash 0"
    )
    assert restirpg(*command, "--reference", "silent.exr", folder=tmp_path)[0] == 0
    with pytest.raises(renderer_scenes.restirpg.Error, match=r"other\.exr: this reference is of another scene"):
        renderer_scenes.restirpg.view(ROOT / "graphs/path_tracer.py", scene, (24, 16), reference=tmp_path / "other.exr")


def test_a_reference_of_other_pixels_is_refused(scene, one_kernel, tmp_path):
    command = ["render", one_kernel, "--scene", scene, "--frames", 1]
    window = ["--size", "64x48", "--window", "8,8,16,16"]
    assert restirpg(*command, *window, "-o", "window.exr", folder=tmp_path)[0] == 0
    assert restirpg(*command, *window, "--reference", "window.exr", folder=tmp_path)[0] == 0
    said = "window.exr: this reference is of other pixels (8,8,16,16 of a picture of 64x48; here it is "
    for other, words in (
        (["--size", "16x16"], "0,0,16,16 of 16x16"),
        (["--size", "64x48", "--window", "0,8,16,16"], "0,8,16,16 of 64x48"),
    ):
        assert refusal(*command, *other, "--reference", "window.exr", folder=tmp_path).startswith(said + words)
    with pytest.raises(renderer_scenes.restirpg.Error, match=r"window\.exr: this reference is of other pixels"):
        renderer_scenes.restirpg.view(
            ROOT / "graphs/path_tracer.py", scene, (16, 16), reference=tmp_path / "window.exr"
        )


def test_a_reference_of_another_environment_is_told(scene, one_kernel, tmp_path, capsys):
    def write_sky(radiance):
        renderer_scenes.restirpg.write_exr(tmp_path / "sky.exr", {"": np.full((4, 8, 3), radiance, np.float32)})

    def warned(*options):
        code, _, errors = restirpg(*command, "--reference", "sky_1.exr", *options, folder=tmp_path)
        assert code == 0
        return errors

    command = ["render", one_kernel, "--scene", scene, "--size", "16x16", "--frames", 1]
    write_sky(1)
    assert restirpg(*command, "--environment", "sky.exr", "-o", "sky_1.exr", folder=tmp_path)[0] == 0
    shutil.copy(tmp_path / "sky.exr", tmp_path / "renamed.exr")
    assert warned("--environment", "sky.exr") == warned("--environment", "renamed.exr") == ""
    write_sky(2)
    told = "warning: sky_1.exr: its environment is sky.exr (hash "
    assert warned("--environment", "sky.exr").startswith(told)
    assert warned("--environment", "1,1,1").startswith(told) and "here it is 1,1,1: the diff" in warned(
        "--environment", "1,1,1"
    )
    assert "here it is that of the scene: the difference counts as error" in warned()
    with renderer_scenes.restirpg.view(
        ROOT / "graphs/path_tracer.py", scene, (16, 16), reference=tmp_path / "sky_1.exr", captures=tmp_path
    ):
        assert "sky_1.exr: its environment is sky.exr (hash " in capsys.readouterr().err


def test_a_reference_of_another_view_is_told(scene, one_kernel, tmp_path):
    command = ["render", one_kernel, "--scene", scene, "--size", "16x16", "--frames", 1]
    pose = ["--pose", "0,1,3,0,1,0,0,1,0,0.8"]
    view = [*pose, "--time", "0.5", "--energy-compensation"]
    assert restirpg(*command, *view, "-o", "view.exr", folder=tmp_path)[0] == 0
    assert restirpg(*command, *view, "--reference", "view.exr", folder=tmp_path)[2] == ""
    told = restirpg(*command, "--reference", "view.exr", folder=tmp_path)[2].splitlines()
    assert told == [
        f"warning: view.exr: its {what}: the difference counts as error"
        for what in (
            "pose is 0,1,3,0,1,0,0,1,0,0.8, here it is that of the camera",
            "time is 0.5, here it is 0",
            "energyCompensation is true, here it is false",
        )
    ]


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
        (
            ["--fps", "-1"],
            "-1 frames per second: must be 0, where the scene stands still, or finite and at least 1e-06",
        ),
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
            "gbuffer.material, paths.radiance, accumulate.frame, accumulate.mean, accumulate.variance, accumulate.invalid",
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
    code, _, said = restirpg(*command, folder=tmp_path)
    assert code == 2 and said.endswith(
        "\n    bounce cap 20 is the scene's; --bounces replaces it (bounces= in Python)\n"
    )
    other = tmp_path / "other.gltf"
    other.write_text(file.read_text().replace('{"bounces": 20}', '{"bounces": 8}'))
    said = refusal(*command[:3], other, *command[4:], "--set", "paths.bounces=20", folder=tmp_path)
    assert "'bounces' is at most 15, not 20" in said and "the scene's" not in said
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


def own_terminal():
    """Make standard input the terminal of this new session, whose end is told by SIGHUP; nohup has that ignored."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


@pytest.mark.parametrize("printed", ["to the terminal", "elsewhere"])
def test_a_terminal_that_is_closed_keeps_what_there_is(scene, tmp_path, printed):
    master, slave = pty.openpty()
    with subprocess.Popen(
        [PROGRAM, *map(str, render_command(scene, frames=1000000))],
        cwd=tmp_path,
        stdin=slave,
        stdout=slave if printed == "to the terminal" else subprocess.DEVNULL,
        stderr=slave,
        start_new_session=True,
        preexec_fn=own_terminal,
    ) as program:
        os.close(slave)
        drawn = b""
        while b"3/1000000" not in drawn:
            drawn += os.read(master, 65536)
        os.close(master)
        try:
            code = program.wait(timeout=60)
        finally:
            program.kill()
    assert code == -signal.SIGHUP
    assert 3 <= int(header_of(tmp_path / "a.exr")["restirpg.frames"]) < 1000000


def test_every_so_many_frames_are_kept(scene, tmp_path):
    command = [PROGRAM, *map(str, render_command(scene, frames=1000000)), "--keep-every", "3"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL) as program:
        while not (tmp_path / "a.exr").exists() and program.poll() is None:
            time.sleep(0.01)
        program.kill()
    assert int(header_of(tmp_path / "a.exr")["restirpg.frames"]) % 3 == 0


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
        assert len(list((tmp_path / "cache" / "binary").iterdir())) == 13  # one per kernel of restir_pg


def test_ports_of_passes_are_written_by_name(scene, tmp_path):
    command = [*render_command(scene), "--output", "image", "--output", "depth", "--output", "gbuffer.albedo"]
    assert restirpg(*command, folder=tmp_path)[0] == 0
    data = (tmp_path / "a.exr").read_bytes()
    assert b"depth.Y" in data and b"albedo.R" in data and b"variance" not in data.split(b"restirpg.graph")[0]
