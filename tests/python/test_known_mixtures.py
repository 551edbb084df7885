"""GuidingSplat and GuidingFit on samples of a known distribution (tests/guide/KnownSamples): what they
find, and how cells behave that are starved, crowded, or hold samples that are all alike.

Statistical: recovery alone, from 16,384 samples per frame. Its bounds are four standard errors or more: a lobe
of n samples has kappa to 1 / sqrt(n) (2.5% for the least of them), to which Banerjee's formula adds up to 5%,
weights to 0.4%, directions to 0.4 degrees.
"""

import guiding_fit_oracle as fit_oracle
import guiding_oracle as oracle
import numpy as np
import pytest
from renderer_scenes import ROOT, check_samples, make_renderer, restirpg

#: As in KnownSamples.comp.
MU = np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0.6, 0.8], [0, 0.28, -0.96]])
KAPPA = np.array([6.0, 20, 80, 300])
WEIGHT = np.array([0.4, 0.3, 0.2, 0.1])

pytestmark = pytest.mark.usefixtures("own_plugins")


class Learner:
    """Known samples, splat and fit, frame by frame. Each place lies in a cell of its own."""

    def __init__(self, scene, size=64, cells=4096, **known):
        g = restirpg.Graph("Known samples")
        known = g.add("known", "KnownSamples", **known)
        statistics = g.add(
            "splat",
            "GuidingSplat",
            samples=known.samples,
            guide=restirpg.prev("fit.guide"),
            cells=cells,
            cell_size=0.003,
        )
        guide = g.add(
            "fit",
            "GuidingFit",
            statistics=statistics.statistics,
            history=restirpg.prev("fit.guide"),
            cells=cells,
        )
        g.output("guide", guide.guide)
        self.renderer = make_renderer(scene, g, size=(size, size), seed=3)

    def render(self, frames=1, **fit):
        """Set knobs of GuidingFit, render, and return (header, cells) of the guide."""
        for name, value in fit.items():
            self.renderer.set(f"fit.{name}", value)
        self.renderer.render(frames)
        knobs = self.renderer.knobs()["fit"]
        memory = [oracle.MEMORY] if knobs["keep_samples"] or knobs["decay"] > 0 else []
        header, table, keys = oracle.read_table(self.renderer.read_port("fit.guide"), oracle.CELL, *memory)
        assert oracle.slots_are_reachable(keys)
        return header, [records[0] for records in table.values()]

    @property
    def statistics(self):
        return oracle.read_table(self.renderer.read_port("splat.statistics"), oracle.SUMS)


def test_a_known_mixture_is_recovered(scene):
    header, (cell,) = Learner(scene, size=128).render(32, concentration_prior=0.01)
    m = oracle.mixture_of(cell)
    assert header["samples"] == 128 * 128 and header["fitted"] == 1
    order = (MU @ m.mu.T).argmax(-1)
    assert sorted(order) == [0, 1, 2, 3]
    print(np.degrees(np.arccos((MU * m.mu[order]).sum(-1))), m.kappa[order] / KAPPA, m.weight[order])
    assert ((MU * m.mu[order]).sum(-1) > np.cos(np.radians(1.5))).all()
    assert np.allclose(m.kappa[order], KAPPA, rtol=0.12)
    assert np.allclose(m.weight[order], WEIGHT, atol=0.02)


def test_the_oracle_itself_climbs(scene):
    """EM never makes a batch less likely, but for the priors and Banerjee's kappa: each step may lose 10^-3 a
    sample at most."""
    random = np.random.default_rng(1)
    lobe = random.choice(4, 4000, p=WEIGHT)
    w = MU[lobe] + random.normal(size=(4000, 3)) / np.sqrt(KAPPA[lobe])[:, None]
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    m, scores = oracle.new_mixture(np.array([0.0, 1, 0])), []
    for _ in range(30):
        scores.append(m.log_density(w).mean())
        m = fit_oracle.m_step(
            m.shares(w).T @ np.c_[w, np.ones(len(w))],
            len(w),
            m,
            {"lobes": 4, "weight_prior": 0.1, "concentration_prior": 1.0, "largest_kappa": 32000.0},
        )
    assert min(np.diff(scores)) > -1e-3 and scores[-1] > scores[0] + 0.5


def test_starved_cells_keep_their_samples_until_there_are_enough(scene):
    """512 places, 8 samples each a frame; 16 are needed."""
    learner = Learner(scene, places=512)
    header, cells = learner.render(1)
    start = oracle.new_mixture(np.array([0.0, 1, 0]))
    assert (header["cells"], header["fitted"], header["guiding"]) == (512, 0, 0)
    assert all(np.allclose(oracle.mixture_of(cell).mu, start.mu, atol=1e-4) for cell in cells)
    header, cells = learner.render(1)
    assert (header["fitted"], header["guiding"]) == (512, 512)
    assert {(int(cell["age"]), float(cell["samples"])) for cell in cells} == {(0, 16.0)}
    header, cells = learner.render(1)
    assert (header["fitted"], header["guiding"]) == (0, 512) and {int(cell["age"]) for cell in cells} == {1}


def test_starved_cells_that_drop_their_samples_never_guide(scene):
    header, cells = Learner(scene, places=512).render(5, keep_samples=False)
    assert (header["cells"], header["fitted"], header["guiding"]) == (512, 0, 0)
    assert {int(cell["age"]) for cell in cells} == {4}


def test_cells_stop_guiding_when_they_have_grown_too_old(scene):
    """Fitted once, then kept from it by a larger `minimum`."""
    learner = Learner(scene, places=64)
    assert learner.render(1, keep_samples=False, oldest=2)[0]["guiding"] == 64
    assert [int(learner.render(1, minimum=1000)[0]["guiding"]) for _ in range(4)] == [64, 64, 0, 0]


def test_cells_without_samples_are_carried_on_for_a_while(scene):
    learner = Learner(scene, places=64)
    learner.render(2, oldest=2)
    learner.renderer.set("known.places", 1)
    counts = [int(learner.render(1)[0]["cells"]) for _ in range(3)]
    assert counts == [64, 64, 1]


def test_a_cell_of_one_sample_has_a_legal_mixture(scene):
    """4096 places, one sample each, all fitted: the priors bound what one sample can say."""
    header, cells = Learner(scene, places=4096, cells=16384).render(1, minimum=1)
    assert header["fitted"] == header["cells"] == 4096
    mixtures = [oracle.mixture_of(cell) for cell in cells]
    assert all(np.isfinite(m.kappa).all() and np.isclose(m.weight.sum(), 1, atol=1e-5) for m in mixtures)
    assert max(m.kappa.max() for m in mixtures) <= 10.01  # a re-seeded lobe's; a fitted one's mean cosine is below 1/2


def test_identical_samples_meet_the_largest_kappa(scene):
    """Without a prior the mean cosine is 1 up to rounding: clamped, not infinite."""
    learner = Learner(scene, identical=True)
    cell = learner.render(4, concentration_prior=0.0, weight_prior=0.0, reseed=False)[1][0]
    m = oracle.mixture_of(cell)
    best = m.weight.argmax()
    assert np.isfinite(m.kappa).all() and np.isclose(m.weight.sum(), 1, atol=1e-5)
    assert 0.98 < m.kappa[best] / 32000 < 1.02 and m.mu[best] @ MU[0] > 1 - 1e-7
    cell = learner.render(4, concentration_prior=1.0)[1][0]
    assert oracle.mixture_of(cell).kappa.max() < 1.1 * 2 * 4096  # kappa <= 2 n / prior [shaders/README: The MAP fit]


def test_keys_that_collide_keep_cells_of_their_own(scene):
    """Half of 1024 slots taken, by cells in a lattice: no sample is lost or lands in another's cell, and a
    probe meets about as many slots of others as with random hashing (half a slot on the way to a key, by
    Knuth's formula for linear probing)."""
    learner = Learner(scene, places=512, cells=1024)
    header, cells = learner.render(1)
    counts = [int(records[0]["count"]) for records in learner.statistics[1].values()]
    assert header["failed"] == 0 and counts == [8] * 512
    assert 0.25 < header["collisions"] / 4096 < 1


def test_samples_that_find_a_full_table_are_counted(scene):
    learner = Learner(scene, places=4096, cells=1024)
    for _ in range(3):
        header, cells = learner.render(1, minimum=1)
        statistics = learner.statistics[0]
        assert statistics["failed"] + header["samples"] == 4096 and statistics["cells"] <= 1024
        assert statistics["failed"] >= 3072 and header["failed"] >= statistics["failed"]
        assert len(cells) == header["cells"] <= 1024


def test_rendering_goes_on_with_a_full_table(scene):
    renderer = make_renderer(scene, restirpg.load_graph(ROOT / "graphs" / "restir_pg.py"), seed=1)
    renderer.set("splat.cells", 1024)
    renderer.set("fit.cells", 1024)
    renderer.set("splat.cell_size", 0.01)  # more cells than slots
    renderer.render(3)
    header = oracle.read_table(renderer.read_port("fit.guide"), oracle.CELL, oracle.MEMORY)[0]
    assert header["failed"] > 0
    check_samples(renderer)
