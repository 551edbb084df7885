"""Statistics of the harness against closed forms, SciPy, and their own null distributions."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from restirpg.harness import analysis, tables
from restirpg.harness import statistics as st
from restirpg.harness.jobs import Job
from restirpg.harness.measure import TemporalSums


def test_paired_and_welch_agree_with_scipy():
    random = np.random.default_rng(1)
    a, b = random.normal(1, 2, 9), random.normal(1.5, 3, 9)
    assert st.paired(a, b).p == pytest.approx(stats.ttest_rel(a, b).pvalue)
    assert st.welch(a, b[:5]).p == pytest.approx(stats.ttest_ind(a, b[:5], equal_var=False).pvalue)
    assert st.welch(a, 1.2).p == pytest.approx(stats.ttest_1samp(a, 1.2).pvalue)


def test_a_ratio_of_means_and_its_error_hold_where_a_mean_of_ratios_does_not():
    rng = np.random.default_rng(3)
    baseline, values = rng.gamma(4, 1 / 4, (2, 4000, 64))  # a relative standard deviation of a half
    found = np.array([st.ratio(*pair) for pair in zip(0.9 * values, baseline)])
    assert found[:, 0].mean() == pytest.approx(0.9, rel=0.01)
    assert found[:, 1].mean() == pytest.approx(found[:, 0].std(), rel=0.05)
    assert (0.9 * values / baseline).mean() > 1.1


def test_holm_gives_the_textbook_values_and_skips_what_was_not_tested():
    np.testing.assert_allclose(st.holm([0.01, np.nan, 0.04, 0.03]), [0.03, np.nan, 0.06, 0.06])
    assert st.holm([]).size == 0


def test_holm_keeps_the_family_wise_error_at_its_level():
    # 4,000 families of 20 true null hypotheses. At level 5% the count of families with an alarm is binomial
    # with p <= 0.05: more than 4 standard deviations above has probability < 1e-4. Without correction it
    # would be 64%.
    p = np.random.default_rng(2).random((4000, 20))
    alarms = sum((st.holm(family) < 0.05).any() for family in p)
    assert alarms < 4000 * 0.05 + 4 * np.sqrt(4000 * 0.05 * 0.95)
    assert (p < 0.05).any(axis=1).sum() > 2000


def test_the_smallest_detectable_difference_is_found_with_the_promised_power():
    # 4,000 samples of 10 whose mean differs from 0 by exactly that: found in 80%. The t approximation and the
    # binomial error (0.6%) together stay within 4%.
    random = np.random.default_rng(3)
    se = 1 / np.sqrt(10)
    difference = st.Test(0, se, 9, 1).smallest_detectable()
    samples = random.normal(difference, 1, (4000, 10))
    found = np.mean(stats.ttest_1samp(samples, 0, axis=1).pvalue < st.LEVEL)
    assert st.POWER - 0.04 < found < st.POWER + 0.04


def test_a_biased_block_is_found_among_unbiased_ones():
    # 16 runs of 12 x 20 blocks with 5% noise: block (3, 4) is 25% too bright, 20 standard errors.
    random = np.random.default_rng(7)
    runs, batches = random.normal(1, 0.05, (16, 12, 20)), random.normal(1, 0.02, (16, 12, 20))
    runs[:, 3, 4] += 0.25
    p = st.block_bias_p_values(runs, batches)
    assert [tuple(index) for index in np.argwhere(p * p.size < st.LEVEL)] == [(3, 4)]


def test_biased_blocks_are_counted_after_the_correction_that_their_p_has():
    """Of 100 blocks and six tests in all; with more bias elsewhere fewer tests are left to correct for."""

    def counted(blocks, *others):
        methods = [
            SimpleNamespace(bias=SimpleNamespace(p=0.5), block_p=np.array(p), adjusted={}, biased_blocks=0)
            for p in (blocks, *others)
        ]
        assert analysis._correct_bias(methods) == 2 * len(methods)
        return tables.block_cell(methods[0])

    blocks, clean = [0.0, 1e-5, 1.9e-5, 9e-5, *96 * [0.5]], 100 * [0.5]
    assert counted(blocks, clean, clean) == "2 of 100 biased (p = 1e-99)"
    assert counted(blocks) == "3 of 100 biased (p = 1e-99)"
    assert counted(blocks[1:], [1e-9, *clean], [1e-9, *clean]) == "2 of 99 biased (p = 0.004)"
    assert counted(clean, blocks) == "none of 100 (p = 1)"


def test_blocks_that_rare_samples_have_missed_are_not_called_biased():
    # A sample is 50 with a probability of 2%, else 0: most of 220 blocks see none in 4 runs. In 200 trials at
    # the 1% level more than 8 alarms have a probability of 1e-4; a t-test without the guard alarms always.
    random, alarms, unguarded = np.random.default_rng(8), 0, 0
    for _ in range(200):
        runs = 50 * (random.random((4, 220)) < 0.02) + random.normal(0, 1e-3, (4, 220))
        alarms += np.min(st.block_bias_p_values(runs, np.ones((1, 220)))) * 220 < st.LEVEL
        unguarded += np.min(stats.ttest_1samp(runs, 1).pvalue) * 220 < st.LEVEL
    assert alarms <= 8 and unguarded > 100


def test_one_run_is_not_tested_and_equal_runs_do_not_differ():
    assert np.isnan(st.paired([1.0], [2.0]).p)
    assert np.isnan(st.welch([1.0], [1.0, 2.0, 3.0]).p)
    assert st.paired([1, 2, 3], [1, 2, 3]).p == 1
    assert st.paired([1, 1, 1], [2, 2, 2]).p == 0


@pytest.mark.parametrize("block, expected", [(1, 1), (2, 4), (8, 64)])
def test_block_correlation_is_the_number_of_pixels_that_move_together(block, expected):
    # Relative standard deviation of the ratio, 12 runs of 64 blocks: sqrt(2 / (11 * 64)) = 5.3%; 5 of them.
    noise = np.random.default_rng(4).normal(size=(12, 64 // block, 64 // block))
    ratio, se = st.block_correlation(noise.repeat(block, axis=1).repeat(block, axis=2))
    assert abs(ratio / expected - 1) < 5 * np.sqrt(2 / (11 * 64))
    assert 0 < se < 0.3 * expected


@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_temporal_correlation_finds_the_coefficient_of_an_autoregressive_pixel(memory):
    # 64 x 64 pixels, 20 frames: standard error of the coefficient about 1/sqrt(64 * 64 * 19) = 0.0036; 5 of
    # them.
    random = np.random.default_rng(5)
    truth = random.random((64, 64, 3)).astype(np.float32)
    sums, state = TemporalSums(), random.normal(size=(64, 64, 1))
    for _ in range(20):
        sums.add((truth + state).astype(np.float32), truth, consecutive=True)
        state = memory * state + np.sqrt(1 - memory**2) * random.normal(size=(64, 64, 1))
    assert abs(st.temporal_correlation(sums.sums, 0) - memory) < 5 * 0.0036


def test_a_gap_between_frames_is_no_pair():
    truth = np.zeros((2, 2, 3), np.float32)
    sums = TemporalSums()
    for consecutive in (True, True, False, True):
        sums.add(truth + 1, truth, consecutive)
    assert sums.sums[1] == 2 * 4 and sums.sums[3] == 4 * 4


def test_at_time_is_exact_on_power_laws_and_unknown_outside_the_curve():
    times = np.array([1.0, 2.0, 8.0, 16.0])
    assert st.at_time(times, 3 / np.sqrt(times), 5) == pytest.approx(3 / np.sqrt(5))
    assert st.at_time(times, [1, -1, 1, 1], 1.5) == pytest.approx(0)
    assert np.isnan(st.at_time(times, times, 0.5)) and np.isnan(st.at_time(times, times, 17))


def test_block_means_leave_out_the_rest():
    image = np.arange(10 * 9).reshape(10, 9)
    np.testing.assert_array_equal(st.block_means(image, 8), [[image[:8, :8].mean()]])
    np.testing.assert_array_equal(st.block_means(image[:4, :4], 8), [[image[:4, :4].mean()]])


def test_a_long_run_is_measured_at_spread_frames_and_at_its_last_ones():
    job = Job(
        scene="", scene_hash="", graph="", description="{}", size=(1, 1), frames=1000, seed=0, code="", reference="r"
    )
    frames = job.frames_measured()
    assert frames[0] == 1 and set(range(969, 1001)) <= set(frames) and frames == sorted(set(frames))
    assert 64 < len(frames) < 96
