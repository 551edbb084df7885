"""A run on a renderer that a worker has kept is the run of a new one: same bytes, whatever went before."""

import json
import shutil

import numpy as np
import pytest
from renderer_scenes import ROOT, write_flying_panel

from restirpg.harness import Halt, measure, render
from restirpg.harness.cache import Cache
from restirpg.harness.jobs import Job
from restirpg.harness.motion import Motion
from restirpg.harness.workers import Pool

FRAMES = 3


def job_of(graph, scene, seed, **options):
    """A small run of a graph of this repository."""
    file = str(ROOT / "graphs" / graph)
    return Job(
        **{
            "scene": str(scene),
            "scene_hash": "",
            "graph": file,
            "size": (24, 16),
            "frames": FRAMES,
            "seed": seed,
            "description": json.dumps(render.describe_graph(file)),
            "code": render.code_version(),
            "bounces": 2,
            **options,
        }
    )


def pictures(folder, jobs):
    """Outputs of the jobs, done one after the other by one worker."""
    folder.mkdir()
    with Pool(folder, 1) as pool:
        assert [failure for _, failure, _ in pool.run(jobs)] == [None] * len(jobs)
    return [Cache(folder).load(job.key)["image"] for job in jobs]


def test_a_run_on_a_kept_renderer_has_the_bytes_of_one_on_a_new_one(scene_file, tmp_path):
    first, second = (job_of("restir_pg.py", scene_file, seed) for seed in (1, 2))
    kept = pictures(tmp_path / "kept", [first, job_of("path_tracer.py", scene_file, 1), second])[-1]
    (new,) = pictures(tmp_path / "new", [second])
    np.testing.assert_array_equal(kept, new)


class Uncut:
    """A renderer that ignores cuts."""

    def __init__(self, renderer):
        object.__setattr__(self, "renderer", renderer)

    def cut(self):
        """Forget nothing."""

    def __getattr__(self, name):
        return getattr(self.renderer, name)

    def __setattr__(self, name, value):
        setattr(self.renderer, name, value)


def test_a_graph_and_its_neighbours_edited_meanwhile_are_rendered_as_they_were(scene_file, tmp_path):
    """Structural knobs too: rounds make other kernels."""
    shutil.copy(ROOT / "graphs/pipeline.py", tmp_path / "neighbour.py")
    file = tmp_path / "graph.py"
    file.write_text("from neighbour import pipeline\ngraph = pipeline()\n")
    job = job_of(file, scene_file, 1, knobs=(("reuse.rounds", 2),))
    (tmp_path / "neighbour.py").write_text("raise ValueError\n")
    edited = pictures(tmp_path / "edited", [job])
    file.write_text("graph = 1\n")
    shutil.copy(ROOT / "graphs/pipeline.py", tmp_path / "neighbour.py")
    whole = job_of(ROOT / "graphs/restir_pt.py", scene_file, 1, knobs=(("reuse.rounds", 2),))
    np.testing.assert_array_equal(edited, pictures(tmp_path / "whole", [whole]))


def test_a_scene_edited_meanwhile_ends_the_program(scene_file, tmp_path):
    with pytest.raises(Halt, match="the scene has changed since the start"):
        pictures(tmp_path / "kept", [job_of("path_tracer.py", scene_file, 1, scene_hash="of another")])


def test_history_that_is_not_forgotten_shows(scene_file, monkeypatch):
    """The injected error: what the test above must find."""
    job = job_of("restir_pg.py", scene_file, 1)
    make = render.make_renderer
    new = measure.run(job)["image"]
    monkeypatch.setattr(render, "make_renderer", lambda job: Uncut(make(job)))
    assert not np.array_equal(measure.run(job)["image"], new)


def test_a_run_starts_where_the_motion_starts(tmp_path):
    panel = write_flying_panel(tmp_path / "panel.gltf")
    moving = [job_of("path_tracer.py", panel, seed, motion=Motion(0.05, 4.0)) for seed in (1, 2)]
    kept, (new,) = pictures(tmp_path / "kept", moving), pictures(tmp_path / "new", moving[1:])
    np.testing.assert_array_equal(kept[1], new)
    assert 0 < new.mean() < 1  # the panel leaves the view


def test_renderers_that_were_not_used_for_longest_make_room(scene_file):
    jobs = [job_of("path_tracer.py", scene_file, 1, bounces=cap) for cap in (1, 2, 3)]
    size = render.size_of(render.make_renderer(jobs[0]))
    assert size >= render.KERNELS  # what memory() does not know of counts, too
    renderers = render.Renderers(limit=2 * size)
    first, second = (renderers.begin(job)[0] for job in jobs[:2])
    assert renderers.begin(jobs[0])[0] is first
    renderers.begin(jobs[2])
    assert renderers.begin(jobs[0])[0] is first
    assert renderers.begin(jobs[1])[0] is not second


def test_a_frame_alone_is_what_it_is_after_a_sample_was_dropped(tmp_path):
    """The panel fills the view of frame 1, and shines and reflects more than Accumulate takes. From frame 2 on the sky is
    all there is to see, of which the reference is."""
    panel, sky = write_flying_panel(tmp_path / "panel.gltf", strength=1e30), np.float32(9e29)
    options = {"environment": f"{sky},{sky},{sky}", "motion": Motion(0.0, 1.0), "frames": 4}
    truth = {"mean": np.full((16, 24, 3), sky)}
    for measured in ({"reference": "sky"}, {"at": (2, 3, 4), "references": ("sky",) * 3}):
        found = measure.run(job_of("path_tracer.py", panel, 1, **options, **measured), lambda key: truth)
        assert found["meta"]["dropped"] > 16 * 24 / 2
        np.testing.assert_allclose(found["frame_mape"][-3:], 0, atol=1e-6)
        np.testing.assert_allclose(found["frame"], truth["mean"], rtol=1e-6)
