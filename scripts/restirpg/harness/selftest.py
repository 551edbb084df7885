"""The harness measured by itself: how often it sees a difference where there is none, and whether it sees one
of 1%.

Null hypothesis of every trial: two runs of one graph, with independent seeds, have the same errors and no
bias. At LEVEL for each of the two families of a report, at most 2% of trials may claim otherwise; 5% is what
the self-test allows.
"""

import json
from dataclasses import replace

import numpy as np

from restirpg.harness import UserError, analysis, render, scenes
from restirpg.harness import reference as references
from restirpg.harness import statistics as st
from restirpg.harness.collected import SceneRuns
from restirpg.harness.comparison import Comparison, cost
from restirpg.harness.jobs import Job, Method, parse_method, seed_of

SIZE = (32, 32)
FRAMES = 16
SEEDS = 6  # of each side of a trial
REFERENCE_FRAMES, BATCHES = 256, 16  # frames of a batch
GAIN = 1.01
GAIN_TRIALS = 5
GAIN_SEEDS = 16  # of each
ALLOWED = 0.05  # of trials between equal methods
MOST_FRAMES = 1024  # of a run of a gain trial


class _Everything:
    """Settings of a Comparison that only renders."""

    methods = ()
    motion = None


def run(options, cache, pool, display):
    """Print the findings. Returns the exit code: 0 when both properties hold, 1 when not."""
    base = _base_job(options, pool)
    comparison = Comparison(_Everything, cache, pool, display)
    batches = [
        replace(
            base,
            frames=REFERENCE_FRAMES,
            label="reference",
            seed=seed_of(options.base_seed, "self-test truth", n),
        )
        for n in range(BATCHES)
    ]
    pairs = [
        [[_run(base, options, "pair", trial, side, n) for n in range(SEEDS)] for side in "AB"]
        for trial in range(options.trials)
    ]
    every = [job for pair in pairs for side in pair for job in side]
    display.start(sum(map(cost, batches + every)))
    _render(comparison, batches)
    truth = references.combine(cache, batches)
    key = references.key_of_batches(batches)
    results = _render(comparison, [replace(job, reference=key) for job in every])
    display.stop()
    false, biases = _false_alarms(truth, results, options.trials)
    spread = np.std([result["image"].mean() for result in results], ddof=1)
    frames = _frames_needed(spread, truth)
    found, detectable = _gain_trials(comparison, replace(base, frames=frames), options, truth, key)
    _print(options, truth, false, biases, found, frames, detectable)
    return 0 if len(false) <= ALLOWED * options.trials and found == GAIN_TRIALS else 1


def _base_job(options, pool):
    method = parse_method(options.methods[0]) if options.methods else Method("", options.reference_graph)
    scene = options.scenes[0]
    read = {name: getattr(options, name) for name in ("camera", "environment", "allow_outside")}
    facts = scenes.facts(pool, scene, **read)
    return Job(
        scene=scene,
        scene_hash=facts.hash,
        graph=method.graph,
        description=json.dumps(render.describe_graph(method.graph), sort_keys=True),
        knobs=method.knobs,
        size=SIZE,
        frames=FRAMES,
        seed=0,
        code=render.code_version(),
        output=method.output,
        device=method.device,
        backend=method.backend,
        bounces=facts.bounces(options.bounces),
        **read,
    )


def _run(base, options, *parts):
    """A run whose random numbers belong to it alone."""
    return replace(base, seed=seed_of(options.base_seed, "self-test", *parts), label=" ".join(map(str, parts[:2])))


def _render(comparison, jobs):
    if comparison.render(jobs):
        raise UserError(f"the self-test needs every run: {comparison.failures[0]}")
    return [comparison.cache.need(job.key) for job in jobs]


def _false_alarms(truth, results, trials):
    """Descriptions of the trials that claim a difference or a bias, and how many of them claim a bias."""
    alarms = []
    for trial in range(trials):
        own = results[2 * SEEDS * trial : 2 * SEEDS * (trial + 1)]
        runs = SceneRuns("self-test", truth, {"A": own[:SEEDS], "B": own[SEEDS:]}, {})
        claims = [
            str(kind)
            for method in analysis.analyse([runs])[0].methods
            for kind, p in method.adjusted.items()
            if p < st.LEVEL
        ]
        if claims:
            alarms.append(f"trial {trial}: {', '.join(claims)}")
    return alarms, sum("bias" in alarm or "blocks" in alarm for alarm in alarms)


def _frames_needed(spread, truth):
    """Frames of a run that make the smallest detectable bias well smaller than GAIN - 1.

    spread: standard deviation of a picture's mean over runs of FRAMES.
    """
    batches = truth["batch_means"]
    frames = FRAMES
    while frames < MOST_FRAMES:
        se = np.hypot(spread * np.sqrt(FRAMES / frames / GAIN_SEEDS), batches.std(ddof=1) / np.sqrt(len(batches)))
        if st.Test(0, se / batches.mean(), GAIN_SEEDS - 1, 1).smallest_detectable() < 0.6 * (GAIN - 1):
            break
        frames *= 2
    return frames


def _gain_trials(comparison, base, options, truth, key):
    """How many trials with too much energy are found biased, and the median smallest detectable bias."""
    jobs = [
        replace(_run(base, options, "gain", trial, n), gain=GAIN, reference=key)
        for trial in range(GAIN_TRIALS)
        for n in range(GAIN_SEEDS)
    ]
    comparison.display.start(sum(map(cost, jobs)))
    results = _render(comparison, jobs)
    comparison.display.stop()
    scale = truth["batch_means"].mean()
    tests = [
        st.welch(
            [
                result["image"].mean(dtype=float) / scale
                for result in results[GAIN_SEEDS * trial : GAIN_SEEDS * (trial + 1)]
            ],
            truth["batch_means"] / scale,
        )
        for trial in range(GAIN_TRIALS)
    ]
    return sum(test.p < st.LEVEL for test in tests), float(np.median([test.smallest_detectable() for test in tests]))


def _print(options, truth, alarms, biases, found, frames, detectable):
    share = 100 * (1 - len(alarms) / options.trials)
    print(
        f"equal graphs: {share:.1f}% of {options.trials} trials find no difference and no bias; at least "
        f"{100 * (1 - ALLOWED):.0f}% is asked for ({SEEDS} seeds a side, {FRAMES} frames of "
        f"{SIZE[0]}x{SIZE[1]}; {biases} of the {len(alarms)} false alarms are of bias)"
    )
    for alarm in alarms:
        print(f"    {alarm}")
    print(
        f"1% too much energy: found in {found} of {GAIN_TRIALS} trials ({GAIN_SEEDS} seeds of {frames} "
        f"frames); the smallest detectable bias is {100 * detectable:.2g}% "
        f"({100 * st.POWER:.0f}% power at the "
        f"{100 * st.LEVEL:.0f}% level); the reference's own standard error is "
        f"{100 * references.noise(truth)['relative_se']:.2g}%"
    )
