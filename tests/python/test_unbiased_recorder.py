"""benchmarks/unbiased/record.py and the test it makes (restirpg.harness.unbiased): what it must find, and what it must
not.

Rendered cases: 64 runs of the Cornell box at 16 x 16; the seeds are fixed, so that a case that passes keeps passing. Of
the mutants of ReSTIRReuse only "confidence" shows here: a still camera makes every temporal Jacobian 1, and in a
diffuse box the spatial ones are near it. Made-up runs: TRIALS comparisons of lognormal pixels, skewed as a frame's are.
"""

import json
import resource
import subprocess
import sys

import numpy as np
import pytest
import runs
from mutants import mutant
from renderer_scenes import ROOT
from samples import Samples

from restirpg.harness import UserError
from restirpg.harness.jobs import parse_method
from restirpg.harness.statistics import LEVEL
from restirpg.harness.unbiased import Reference, compare

RECORD = ROOT / "benchmarks" / "unbiased" / "record.py"
TRIALS, RUNS = 300, 64


def record(out, scene_file, method, *options):
    """Run the recorder. Returns its exit code and the numbers that it wrote."""
    numbers = out / "numbers.json"
    done = subprocess.run(
        [
            sys.executable,
            RECORD,
            method,
            "--scene",
            scene_file,
            "--size",
            "16x16",
            "--bounces",
            "2",
            "--out",
            out,
            "--reference-batches",
            "16",
            "--batch-frames",
            "128",
            "--json",
            numbers,
            *options,
        ],
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    assert done.returncode in (0, 1), done.stderr
    print(done.stdout)
    return done.returncode, json.loads(numbers.read_text())


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """One folder for all, so that the reference is rendered once."""
    return tmp_path_factory.mktemp("recorded")


@pytest.mark.parametrize("method", ["graphs/path_tracer.py@gbuffer.jitter=false", "graphs/restir_pt.py"])
def test_a_method_without_bias_passes(out, scene_file, method):
    code, found = record(out, scene_file, method, "--frames", "1,4", "--runs", "64")
    assert code == 0 and found["invalid"] == 0
    assert not any(row["biased"] for row in found["frames"].values())


#: Cells so large that they hold samples enough to guide at 16 x 16.
CELLS = "splat.cell_size=0.15"


@pytest.mark.parametrize("method", ["restir_pg", "restir_pg_plus", "raw_pt_ruppert2020"])
def test_a_guided_method_passes(out, scene_file, method):
    code, found = record(out, scene_file, f"graphs/{method}.py@{CELLS}", "--frames", "8", "--runs", "64")
    assert code == 0 and found["invalid"] == 0 and not found["biased"]


def test_a_mistake_of_reuse_is_found(out, scene_file):
    with mutant("reuse_confidence"):
        code, found = record(out, scene_file, "graphs/restir_pt.py", "--frames", "4", "--runs", "64")
    assert code == 1 and found["biased"]


def test_what_was_rendered_before_an_interruption_stays(out, scene_file, tmp_path):
    options = ("graphs/restir_pt.py", "--frames", "1,2", "--runs", "6", "--reference-batches", "2")
    _, whole = record(tmp_path / "whole", scene_file, *options)
    _, first = record(tmp_path / "parts", scene_file, *options, "--seconds", "0")
    assert first["runs"] == 2
    for file in (tmp_path / "parts").glob("*/samples.f32"):
        with open(file, "ab") as samples:
            samples.write(b"half a run")
    _, both = record(tmp_path / "parts", scene_file, *options)
    assert both["frames"] == whole["frames"] and both["runs"] == 6
    assert [session["first_run"] for session in both["sessions"]] == [0, 2]


@pytest.mark.parametrize("name", ["name", "driver", "backend"])
def test_samples_of_another_device_are_not_gone_on_with(scene_file, tmp_path, monkeypatch, name):
    case = runs.Case(parse_method(f"{ROOT}/graphs/restir_pt.py"), scene_file, (16, 16), 2, (1,))

    def folders():
        sources = runs.MethodRuns(case, tmp_path), runs.ReferenceBatches(case, 2, 1, 2, tmp_path)
        return [source.samples.folder for source in sources]

    known = runs.device_of(runs.MethodRuns(case, tmp_path / "other").renderer)
    first = folders()
    assert folders() == first
    monkeypatch.setattr(runs, "device_of", lambda _: {**known, name: "another"})
    assert not set(folders()) & set(first)


def test_a_cap_of_no_bounces_is_not_the_scenes_own(scene_file, tmp_path):
    _, found = record(
        tmp_path,
        scene_file,
        "graphs/restir_pt.py",
        "--frames",
        "1",
        "--runs",
        "2",
        "--reference-batches",
        "2",
        "--bounces",
        "0",
    )
    assert found["bounces"] == 0


#: Of a record that is soon done.
FEW = "graphs/restir_pt.py --scene cornell_box --frames 1 --runs 2 --reference-batches 2 --batch-frames 2".split()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["graphs/none.py", "--scene", "cornell_box"], "no such graph"),
        (["graphs/restir_pt.py", "--scene", "no_scene"], "neither a file nor an embedded scene"),
        (["graphs/restir_pt.py", "--scene", "cornell_box", "--size", "10x16"], "multiples of 4"),
        ([*FEW, "--size", "48x52", "--block", "8"], "no whole blocks"),
        (["graphs/restir_pt.py", "--scene", "cornell_box", "--frames", "8,1"], "ascending"),
        (["graphs/restir_pt.py@reuse.capp=3", "--scene", "cornell_box"], "capp"),
    ],
)
def test_a_mistake_in_what_is_asked_is_one_line(tmp_path, arguments, words):
    done = subprocess.run(
        [sys.executable, RECORD, *arguments, "--out", tmp_path], capture_output=True, text=True, cwd=ROOT
    )
    assert done.returncode == 2 and words in done.stderr.splitlines()[-1] and "Traceback" not in done.stderr


def made_up(random, scale=1.0, sigma=1.0):
    """The verdict on lognormal pixels of mean 1, times `scale`, and an exact reference. Skewness 6 for sigma 1, 33 for
    1.5."""
    samples = scale * random.lognormal(-(sigma**2) / 2, sigma, (RUNS, 16, 16))
    return compare(samples, Reference(np.ones((16, 16)), np.full((16, 16), 1e-12)))


@pytest.mark.parametrize("sigma", [1.0, 1.5])
def test_equal_means_are_seldom_called_different(sigma):
    """A false alarm of 1% each: more than 3% of TRIALS have a probability of 10^-3. Unguarded, 9% for sigma = 1.5."""
    random = np.random.default_rng(1)
    verdicts = [made_up(random, sigma=sigma) for _ in range(TRIALS)]
    print("unguarded:", sum(np.abs(verdict.plain_z).max() > verdict.limit for verdict in verdicts))
    assert sum(verdict.worst > 1 for verdict in verdicts) <= 0.03 * TRIALS
    assert sum(verdict.image.p < LEVEL for verdict in verdicts) <= 0.03 * TRIALS


@pytest.mark.parametrize(
    ("errors", "least", "most"),
    [(3.0, 0.5, 0.8), (None, 0.7, 0.95), (5.0, 0.95, 1.0)],
    ids=["three standard errors", "the smallest detectable", "five standard errors"],
)
def test_a_bias_is_found_as_often_as_its_size_says(errors, least, most):
    """A t-test at 1% finds a shift of three standard errors in 64% of the cases, of 3.5 in 80%."""
    random = np.random.default_rng(2)
    typical = [made_up(random) for _ in range(20)]
    bias = np.mean([errors * verdict.image.se if errors else verdict.detectable for verdict in typical])
    found = sum(made_up(random, 1 + bias).image.p < LEVEL for _ in range(TRIALS))
    assert least * TRIALS <= found <= most * TRIALS


def exact(image):
    """A Reference without error."""
    return Reference(image, np.zeros_like(image))


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("where", ["samples", "reference", "variance"])
def test_a_value_that_is_no_number_is_refused(where, value):
    """It would be within every limit: no comparison with NaN holds."""
    random = np.random.default_rng(3)
    arrays = {"samples": random.random((4, 8, 8)), "reference": np.full((8, 8), 0.5), "variance": np.zeros((8, 8))}
    arrays[where][..., 2, 5] = value
    with pytest.raises(UserError, match="NaN or infinite"):
        compare(arrays["samples"], Reference(arrays["reference"], arrays["variance"]))


def test_a_black_reference_is_refused():
    with pytest.raises(UserError, match="the reference is black"):
        compare(np.ones((4, 8, 8)), exact(np.zeros((8, 8))))


@pytest.mark.parametrize("ratio, biased", [(1.0, False), (1.0001, True), (0.0, True)])
def test_runs_without_spread_have_the_mean_or_have_not(ratio, biased):
    image = np.full((8, 8), 0.5)
    verdict = compare(np.array([ratio * image] * 4), exact(image))
    assert verdict.biased == biased and (verdict.image.p < 1e-4) == biased, str(verdict)


def test_what_cannot_be_noted_leaves_what_was(tmp_path):
    samples = Samples(tmp_path, {"method": "own"}, (2,))
    samples.note_session()
    before, (soft, hard) = samples.sessions(), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, hard))  # no byte can be written
    try:
        with pytest.raises(UserError, match=r"sessions\.json: cannot be written"):
            samples.note_session()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert len(before) == 1 and samples.sessions() == before
