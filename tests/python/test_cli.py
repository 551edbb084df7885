"""The command line programs apart from `restirpg render`: what they print and what they refuse."""

import json
import os
import re
import subprocess

import pytest
from program import BUILD, GRAPH, PROGRAM, ROOT, refusal, restirpg


@pytest.mark.parametrize("command", (["graph", GRAPH, "--dot"], ["describe"], ["--help"]))
def test_a_full_standard_output_is_one_line(command):
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run([PROGRAM, *command], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert re.fullmatch(r".*cannot write.*No space left on device.*\n", done.stderr)


def test_a_full_standard_error_changes_no_exit_code():
    with open("/dev/full", "w", encoding="utf-8") as full:
        assert subprocess.run([PROGRAM, "describe", "Nothing"], stderr=full, check=False).returncode == 2


def test_a_name_steers_no_terminal(tmp_path):
    said = refusal("render", "g\x1b[2J\n.py", "--scene", "s", "-o", "a.exr", folder=tmp_path)
    assert said.startswith("g\\x1b[2J\\n.py: cannot read the graph file")
    assert refusal("rend\x1b[2J").startswith("restirpg: there is no subcommand 'rend\\x1b[2J'")
    assert "\x1b" not in refusal("render", "--\x1b[2J")


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


def test_modules_of_the_current_folder_are_not_imported(tmp_path):
    """It may be anybody's."""
    for name in ("json", "asyncio", "restirpg"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('a module of the current folder was run')\n")
    assert restirpg("graph", GRAPH, folder=tmp_path)[0] == 0
    code, output, errors = restirpg("view", "--help", folder=tmp_path)
    assert code == 0 and output.startswith("usage: restirpg view"), errors


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


def test_a_graph_is_printed_whatever_its_file_is_called(tmp_path):
    folder = tmp_path / os.fsdecode(b"\xe9\x1b[2J")
    folder.mkdir()
    (folder / "g.py").write_text((ROOT / "graphs/path_tracer.py").read_text())
    (folder / "pipeline.py").write_text((ROOT / "graphs/pipeline.py").read_text())
    code, output, errors = restirpg("graph", folder / "g.py", folder=tmp_path)
    assert (code, errors) == (0, "")
    assert "\\xe9\\x1b[2J/" in output and "\x1b" not in output


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


def test_the_benchmarks_refuse_in_one_line_and_show_their_options(scene_file, tmp_path):
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
    assert said("--scenes", scene_file, "--backends", "magic").startswith("restirpg_bench: no back end 'magic'")
    assert (
        said("--scenes", scene_file, "--benchmark_filter=none")
        == "Failed to match any benchmarks against regex: none\n"
    )
    assert said("--seed", "x") == "restirpg_bench: Could not convert: --seed = x; --help lists the options\n"
    assert said("--nonsense") == "restirpg_bench: '--nonsense' is no option; --help lists them\n"
    assert "formats are console, json and csv" in said("--benchmark_format=yaml")
    absent = tmp_path / "absent/x.json"
    assert (
        said("--scenes", scene_file, f"--benchmark_out={absent}")
        == f"restirpg_bench: --benchmark_out: {absent}: cannot be written: No such file or directory; name another file\n"
    )
    for same in (["--scenes", scene_file, scene_file], ["--scenes", scene_file, "--sizes", "16x9", "16x9"]):
        assert "restirpg_bench: two cases would be called graph/path_tracer/" in said(*same)
    options = subprocess.run([program, "--help"], text=True, capture_output=True, check=True).stdout
    assert all(f"--{name} " in options for name in ("graphs", "scenes", "sizes", "backends", "device", "seed"))
    assert "--benchmark_filter" in options


def test_two_graphs_of_one_name_are_measured_apart(scene_file, tmp_path):
    files = [tmp_path / folder / "mine.py" for folder in ("a", "b")]
    for file, name in zip(files, ("path_tracer", "restir_pt")):
        file.parent.mkdir()
        file.write_text((ROOT / f"graphs/{name}.py").read_text())
    (tmp_path / "b/pipeline.py").write_text((ROOT / "graphs/pipeline.py").read_text())
    command = [BUILD / "bin/restirpg_bench", "--graphs", *files, "--scenes", scene_file, "--sizes", "16x9"]
    command += ["--backends", "software", "--benchmark_filter=^graph", "--benchmark_min_time=0.001"]
    done = subprocess.run([*command, "--benchmark_format=json"], text=True, capture_output=True, check=True)
    found = {case["name"]: case for case in json.loads(done.stdout)["benchmarks"]}
    assert len(found) == 2
    for file, reuses in zip(files, (False, True)):
        [case] = [case for name, case in found.items() if str(file) in name]
        assert ("ms:reuse" in case) == reuses


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
