"""What names a kept result: its job, the code's hash, the settings of a method."""

from dataclasses import replace

from harness_runs import write_graph

from restirpg.harness import jobs, render
from restirpg.harness.jobs import Call, Job, parse_method


def job_of(**options):
    """A job; options override."""
    own = {"scene": "a.glb", "scene_hash": "1", "graph": "g.py", "description": "{}", "code": "c"}
    return Job(**{**own, "size": (8, 8), "frames": 2, "seed": 3, **options})


def test_a_job_is_named_by_its_content_alone():
    job = job_of()
    assert job.key == job_of(scene="b.glb", graph="h.py", label="x").key
    others = [
        job_of(**{name: value})
        for name, value in [
            ("scene_hash", "2"),
            ("description", "[]"),
            ("size", (8, 9)),
            ("frames", 3),
            ("seed", 4),
            ("code", "d"),
            ("knobs", (("a", 1),)),
            ("bounces", 2),
            ("environment", "1,1,1"),
            ("reference", "r"),
            ("backend", "rayquery"),
            ("energy_compensation", True),
        ]
    ]
    assert len({job.key, *(other.key for other in others)}) == 1 + len(others)


def test_a_measurement_is_named_by_its_camera_and_its_environment_too():
    """The hash of a scene tells files of environments apart, but no radiances."""
    call = Call(job_of, "a.glb", "1", (), "c")
    others = [replace(call, **own) for own in ({"environment": "1,1,1"}, {"environment": "2,2,2"}, {"camera": 1})]
    assert len({call.key, *(other.key for other in others)}) == 1 + len(others)


def test_a_run_that_measures_other_frames_is_another_job(monkeypatch):
    job = job_of(frames=400, reference="r")
    before = job.key
    monkeypatch.setattr(jobs, "LAST_FRAMES", 40)
    assert job.key != before


def test_settings_of_a_method_keep_their_types(tmp_path):
    graph = tmp_path / write_graph(tmp_path)
    method = parse_method(f"{graph}@paths.nee=false,bounces=3,alpha=0.5,fit=em,backend=rayquery,label=A B")
    assert method.knobs == (("paths.nee", False), ("bounces", 3), ("alpha", 0.5), ("fit", "em"))
    assert (method.label, method.backend) == ("A B", "rayquery")


def test_the_code_s_hash_is_that_of_its_files_wherever_they_lie(tmp_path, monkeypatch):
    """A clone and its copy are alike; a shader that changes, or changes its name, is other code."""

    def version(clone):
        folder = tmp_path / clone
        monkeypatch.setattr(render, "native_file", lambda: folder / "restirpg/b.so")
        monkeypatch.setattr(render.restirpg, "code_paths", lambda: [folder / "shaders"], raising=False)
        return render.code_version()

    for clone in ("1", "2"):
        for name in ("restirpg/b.so", "shaders/a.glsl"):
            (tmp_path / clone / name).parent.mkdir(parents=True)
            (tmp_path / clone / name).write_text(name)
    first = version("1")
    assert version("2") == first
    (tmp_path / "2/shaders/a.glsl").rename(tmp_path / "2/shaders/b.glsl")
    assert version("2") != first
    (tmp_path / "1/shaders/a.glsl").write_text("another")
    assert version("1") != first
    monkeypatch.setenv("RESTIRPG_VALIDATION", "1")
    assert version("2") not in (first, version("1"))


def test_the_code_s_hash_is_of_what_the_driver_was_told_too(monkeypatch):
    """The renderer itself asks for vectors of 128 bits where nobody else does."""
    monkeypatch.setattr(render, "_code_files", list)
    for name in render.OF_TIMES:
        monkeypatch.delenv(name, raising=False)
    usual, found = render.code_version(), []
    for name, value in (("LP_NATIVE_VECTOR_WIDTH", "256"), ("LP_NUM_THREADS", "1"), ("GALLIVM_PERF", "nopt")):
        with monkeypatch.context() as patch:
            patch.setenv(name, value)
            found.append(render.code_version())
    assert len({usual, *found}) == 4
    monkeypatch.setenv("LP_NATIVE_VECTOR_WIDTH", "128")
    assert render.code_version() == usual
