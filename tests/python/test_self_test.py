"""scripts/compare.py --self-test: the harness's test of its own statistics."""

import subprocess

import numpy as np
import pytest
from harness_runs import ENVIRONMENT, changed, compare, write_graph

from restirpg.harness import selftest, statistics


def self_test(folder, *options):
    """The harness's test of itself in `folder`, run to its end."""
    write_graph(folder)
    (folder / "scene.gltf").touch()
    command = [*changed(), "--self-test", *options]
    return subprocess.run(command, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True)


def test_the_harness_passes_its_self_test(tmp_path):
    # Null hypothesis: no more than 5% of trials between equal methods claim a difference. The rate aimed at
    # is 2%: of 60 trials more than 3 alarm with a probability of 3%; base seed and outcome are fixed.
    # The scene reads outside of its folder: the self-test, too, does so only where that is allowed.
    (tmp_path / "outside.gltf").touch()
    run = self_test(tmp_path, "plain.json", "--scenes", "outside.gltf", "--allow-outside", "--trials", "60")
    assert run.returncode == 0, run.stdout + run.stderr
    assert "found in 5 of 5 trials" in run.stdout and "smallest detectable bias is" in run.stdout


@pytest.mark.parametrize(
    "options, words",
    [
        (["--size", "64x36", "--seeds", "3"], "--self-test chooses its own --seeds, --size; leave out"),
        (["--frames", "4"], "its own --frames;"),
        (["--energy-compensation"], "its own --energy-compensation;"),
        (["plain.json"], "--self-test reads one of the methods, not 2"),
        (["--scenes", "a.glb", "b.glb"], "--self-test reads one of the scenes, not 2"),
        (["--reference-graph", "other.json"], "--self-test reads --reference-graph where no method is given"),
    ],
)
def test_the_self_test_refuses_what_it_would_ignore(tmp_path, options, words):
    run = self_test(tmp_path, "plain.json", *options)
    assert (run.returncode, run.stdout) == (2, "") and words in run.stderr and run.stderr.count("\n") == 1


def test_trials_are_those_of_the_self_test(tmp_path):
    run = compare(tmp_path, "plain.json", trials=3)
    assert run.returncode == 2 and "--trials are those of --self-test" in run.stderr


def test_the_self_test_fails_when_equal_methods_differ(tmp_path, monkeypatch):
    # The injected error: a test that takes the standard error for a third of what it is.
    random = np.random.default_rng(6)
    truth = {
        "mean": np.ones((32, 32, 3), np.float32),
        "variance": np.zeros((32, 32, 3)),
        "luminance_variance": np.array(0.0),
        "batch_means": np.array([1.0]),
        "batch_blocks": np.ones((1, 4, 4)),
        "meta": {},
    }

    def result():
        image = random.normal(1, 0.1, (32, 32, 3)).astype(np.float32)
        curve = np.full(2, np.abs(image - 1).mean())
        return {
            "image": image,
            "frame": image,
            "frames": np.array([1, 2]),
            "mape": curve,
            "frame_mape": curve,
            "relmse": curve**2,
            "bias": curve,
            "gpu_ms": np.array([1.0, 2.0]),
            "wall_ms": np.array([1.0, 2.0]),
            "temporal": np.zeros(4),
            "meta": {"passes": {}, "memory": {}},
        }

    results = [result() for _ in range(2 * selftest.SEEDS * 40)]
    assert len(selftest._false_alarms(truth, results, 40)[0]) <= 2
    honest = statistics._t_test
    monkeypatch.setattr(statistics, "_t_test", lambda difference, se, dof: honest(difference, se / 3, dof))
    assert len(selftest._false_alarms(truth, results, 40)[0]) > 5
