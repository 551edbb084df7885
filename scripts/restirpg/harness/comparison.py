"""Plans the jobs of a comparison, runs those that are not in the cache, and collects the results."""

import json
import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import restirpg
from restirpg.harness import (
    UserError,
    denoised,
    equal_cost,
    equal_time,
    measure,
    plans,
    reference,
    render,
    scenes,
    tiles,
)
from restirpg.harness.collected import SceneRuns, warnings_of, with_knobs
from restirpg.harness.jobs import Job, Method, digest, file_name, made_from, seed_of, without_places
from restirpg.harness.motion import Motion

PATH_TRACER = os.path.relpath(f"{restirpg.GRAPHS}/path_tracer.py")  # from any folder


@dataclass(frozen=True)
class Settings:
    """What the command line asks for."""

    methods: tuple
    scenes: tuple
    size: tuple = (160, 90)
    frames: int = 32
    seeds: int = 8
    base_seed: int = 0
    bounces: int | None = None
    environment: str | None = None
    allow_outside: bool = False  # scenes may read files that lie outside of their own folder
    camera: int = 0
    energy_compensation: bool = False
    reference: str | None = None  # an EXR in place of the path tracer
    reference_graph: str = PATH_TRACER
    reference_frames: int = 1024  # over all batches together
    reference_batches: int = 16
    motion: Motion | None = None
    at: tuple = ()  # ascending frames whose own pictures are measured, each against a reference of its own;
    # (): measured is the mean of all frames, after each of them
    denoise: bool = False  # measure what a denoiser leaves, too
    tiles: int = 0  # that errors are measured in, see tiles.py; 0: the whole picture
    tile_size: int = 24  # their side, pixels
    equal_frame_time: str | None = None  # the knob, see equal_time.py


class Comparison:
    """One comparison: prepare() checks it cheaply and whole, run() returns a SceneRuns each scene."""

    def __init__(self, settings, cache, pool, display):
        self.settings = settings
        self.cache = cache
        self.failures = []  # one line each
        self.device = {}
        self._pool = pool
        self.display = display
        labels = ["reference", *(method.label for method in settings.methods)]
        names = [file_name(label) for label in labels]
        for label in labels:
            if names.count(file_name(label)) > 1:
                raise UserError(f"two pictures would be called '{label}'; tell them apart with @label=NAME")
        if settings.motion and not settings.at:
            raise UserError("while things move only single frames can be measured: say which, as in --at 8,16")

    def prepare(self):
        """Check scenes, graphs and knobs before anything long starts; raises UserError."""
        settings = self.settings
        self._check_settings()
        self.code = render.code_version()
        seed = seed_of(settings.base_seed, "tiles")
        self.corners = tiles.choose(settings.size, settings.tiles, settings.tile_size, seed) if settings.tiles else ()
        descriptions = {
            method.graph: json.dumps(render.describe_graph(method.graph), sort_keys=True)
            for method in self._all_methods()
        }
        self.plans = []
        self.display.start(len(settings.scenes) * len(self._all_methods()), "checked")
        for scene in settings.scenes:
            facts = scenes.facts(self._pool, scene, settings.camera, settings.environment, settings.allow_outside)
            jobs = self._jobs(scene, facts, descriptions)
            probes = self._probe(jobs)
            plan = plans.make(settings, facts, jobs, probes)
            self.device.update({job.label: probes[job.label]["device"] for job in plan.methods})
            self.plans.append(plan)
        if settings.reference:
            reference.read(settings.reference, settings.size)
        self.display.stop()

    def _check_settings(self):
        """Raise UserError where the settings contradict each other."""
        settings = self.settings
        if settings.denoise:
            render.check_denoiser()
        if settings.tiles and settings.denoise:
            raise UserError("tiles cannot be denoised: leave out --denoise or --tiles")
        if settings.tiles and not settings.at:
            raise UserError("in tiles only single frames can be measured: say which, as in --at 11,12,13")
        if settings.equal_frame_time and len(settings.methods) < 2:
            raise UserError("--equal-frame-time compares methods: name another graph beside the only one")
        names = [Path(scene).stem for scene in settings.scenes]
        for name in names:
            if names.count(name) > 1:
                raise UserError(f"two scenes would be called '{name}'; compare them one after the other")
        if settings.reference and len(names) > 1:
            raise UserError(f"{settings.reference}: one picture cannot be the reference of {len(names)} scenes")

    def _jobs(self, scene, facts, descriptions):
        """A job of each of _all_methods(), of no seed yet. descriptions: by graph file."""
        settings = self.settings
        base = made_from(
            Job,
            settings,
            scene=scene,
            scene_hash=facts.hash,
            graph="",
            description="",
            frames=settings.at[-1] if settings.at else settings.frames,
            seed=0,
            code=self.code,
            bounces=facts.bounces(settings.bounces),
            reference=None,
            tiles=self.corners,
            tile=settings.tile_size if self.corners else 0,
        )
        return [replace(base, description=descriptions[method.graph], **vars(method)) for method in self._all_methods()]

    def _all_methods(self):
        """The methods, and last the reference's graph unless the reference is a file."""
        own = [] if self.settings.reference else [Method("reference", self.settings.reference_graph)]
        return [*self.settings.methods, *own]

    def _probe(self, jobs):
        """The knobs and device of each job, from the cache or a worker."""
        keys = {job.label: digest(f"probe {job.key}".encode()) for job in jobs}
        found = {label: self.cache.load(key) for label, key in keys.items()}
        missing = [job for job in jobs if not found[job.label]]
        self.display.skip(len(jobs) - len(missing))
        for job, failure, answer in self._pool.run(missing, kind="probe"):
            if failure:
                raise UserError(failure)
            self.display.advance(1, f"{job.label} on {job.scene}")
            found[job.label] = {"meta": answer}
            self.cache.store(keys[job.label], found[job.label])
        return {label: result["meta"] for label, result in found.items()}

    def seeds(self):
        """The seeds of the runs: the same for every method, so that tests can be paired."""
        return [seed_of(self.settings.base_seed, "run", number) for number in range(self.settings.seeds)]

    def run(self):
        """Render what is missing. A scene whose reference fails is left out; see `failures`."""
        jobs = [plan.jobs(self.seeds()) for plan in self.plans]
        batches = [job for plan in self.plans for own in plan.batches.values() for job in own]
        self.display.start(total_cost([*batches, *(job for own in jobs for job in own)]))
        found = [self._scene(plan, own) for plan, own in zip(self.plans, jobs)]
        self.display.stop()
        return [each for each in found if each]

    def _scene(self, plan, jobs):
        """The SceneRuns of a plan; None where its reference fails."""
        if self.corners:  # such runs keep their pictures and take longest: they are there before the reference is
            self.render(jobs)
        references = self._references(plan)
        if None in references.values():
            self.failures.append(f"{plan.scene}: left out: its reference failed")
            self.display.skip(0 if self.corners else total_cost(jobs))
            return None
        keys = [references[view] for view in plan.views.values()]
        if not self.corners:
            named = {"references": tuple(keys)} if self.settings.at else {"reference": keys[0]}
            jobs = [replace(job, **named) for job in jobs]
            self.render(jobs)
        equal, added, warnings = self._equal_frame_time(plan, jobs)
        further = [job for raised in added.values() for job in raised]
        self.display.extend(total_cost(further))
        self.render(further)
        collected = self._collect(replace(plan, warnings=[*plan.warnings, *warnings]), keys, jobs, added)
        if equal:  # a bracket of which a setting has no run is none
            brackets = {
                label: bracket
                for label, bracket in equal.brackets.items()
                if all(key in collected.raised for key in bracket.keys(label))
            }
            equal = replace(equal, brackets=brackets)
        return replace(collected, equal_cost=equal)

    def _equal_frame_time(self, plan, jobs):
        """(an EqualCost, {(label, value): the jobs of a cheaper method with the knob raised to one of the neighbouring
        settings}, warnings); (None, {}, []) unless asked for.
        """
        knob, brackets, added, warnings = self.settings.equal_frame_time, {}, {}, []
        runs = {}
        for job in jobs if knob else ():
            if result := self.cache.load(job.key):
                runs.setdefault(job.label, []).append(result)
        if len(runs) < 2:
            return None, {}, []
        other = next(job for job in jobs if job.label == equal_cost.slowest(runs))
        for job in plan.methods:
            if job.label not in runs or job.label == other.label:
                continue
            start = equal_cost.start_of(plan.knobs[job.label], knob)
            if start is None:
                warnings.append(
                    f"{job.label}: it has no {knob} to raise: its frames stay cheaper than those of {other.label}"
                )
                continue
            bracket = self._bracket(equal_time.search_call(job, replace(other, seed=0), knob, start), knob)
            if not bracket:
                continue
            brackets[job.label] = bracket
            own = [each for each in jobs if each.label == job.label]
            for key in bracket.keys(job.label):
                added[key] = [equal_cost.raised(each, knob, start, key[1]) for each in own]
        return equal_cost.EqualCost(other.label, brackets), added, warnings

    def _bracket(self, call, knob):
        """The Bracket that a search_call() finds, or None."""
        for _, failure, _ in self._pool.run([call] if self.cache.load(call.key) is None else [], kind="call"):
            if failure:
                self.failures.append(f"{call.scene}, {call.label}: {failure}")
        answer = self.cache.load(call.key)
        return answer and equal_cost.bracket_of(answer, knob)

    def _references(self, plan):
        """{view: key of its reference, in the cache by then, or None when it failed}."""
        if self.settings.reference:
            key, _ = reference.from_exr(
                self.cache, self.settings.reference, self.settings.size, self.corners, self.settings.tile_size
            )
            return dict.fromkeys(plan.views.values(), key)
        return {view: self._reference(batches) for view, batches in plan.batches.items()}

    def _reference(self, batches):
        key = reference.key_of_batches(batches)
        if self.cache.load(key):
            self.display.skip(total_cost(batches))
            return key
        if self.render(batches):
            return None
        reference.combine(self.cache, batches)
        return key

    def render(self, jobs):
        """Run the jobs that are not in the cache; returns how many failed, each already reported."""
        missing = [job for job in jobs if self.cache.load(job.key) is None]
        self.display.skip(total_cost(jobs) - total_cost(missing))
        failed = 0
        for job, failure, _ in self._pool.run(
            missing,
            on_tick=lambda job, frames: self.display.advance(
                frames * cost(job) / job.frames,
                f"{job.label} on {job.scene}" + ("" if frames else ": compiling kernels"),
            ),
        ):
            if failure:
                failed += 1
                self.failures.append(f"{job.scene}, {job.label}, seed {job.seed}: {failure}")
                self.display.message(f"failed: {self.failures[-1]}")
        return failed

    def _collect(self, plan, keys, jobs, added):
        """The SceneRuns. keys: of the reference of each measured frame. added: as _equal_frame_time() gives it."""
        truth = self.cache.need(keys[-1])
        noise = {key: reference.noise(self.cache.need(key)) for key in set(keys)} if self.settings.at else {}
        by_name = {each.label: [job for job in jobs if job.label == each.label] for each in plan.methods}
        results = {name: self._results(own, keys) for name, own in {**by_name, **added}.items()}
        found, warnings = self._paired(plan, results)
        runs = {name: by_seed for name, by_seed in found.items() if name not in added}
        raised = {name: by_seed for name, by_seed in found.items() if name in added}
        every = {**runs, **{added[name][0].label: by_seed for name, by_seed in raised.items()}}
        references = [self.cache.need(key)["meta"] for key in set(keys)]
        return SceneRuns(
            plan.scene,
            truth,
            runs,
            self._descriptions(plan),
            [*plan.warnings, *warnings, *warnings_of(every, references)],
            self.settings.at,
            tuple(noise[key] for key in keys if noise),
            self._denoised(plan.methods[0], runs, truth) if self.settings.denoise and runs else {},
            self._without(plan, runs),
            raised=raised,
            origin=plan.origin,
        )

    def _results(self, jobs, keys):
        """{seed: result} of the jobs that were finished, of tiles with their errors."""
        truths = [self.cache.need(key)["mean"] for key in keys] if self.corners else []
        found = {job.seed: result for job in jobs if (result := self.cache.load(job.key))}
        for result in found.values() if self.corners else ():
            measure.measure_tiles(result, truths, self.settings.tile_size)
        return found

    def _paired(self, plan, results):
        """({name: results by seed}, warnings), of the seeds that every method with any result finished: tests are
        paired. results: name -> seed -> result."""
        finished = {name: runs for name, runs in results.items() if runs}
        baseline = plan.methods[0].label
        if baseline not in finished:
            self.failures.append(f"{plan.scene}: left out: no run of '{baseline}', the baseline, was finished")
            return {}, []
        seeds = [seed for seed in self.seeds() if all(seed in runs for runs in finished.values())]
        found = {name: [by_seed[seed] for seed in seeds] for name, by_seed in finished.items()} if seeds else {}
        left_out = self.settings.seeds - len(seeds)
        return found, [f"{left_out} of {self.settings.seeds} seeds are left out: a run failed"] if left_out else []

    @staticmethod
    def _descriptions(plan):
        """{method label: its graph with the knobs as they were}."""
        return {
            job.label: with_knobs(json.loads(without_places(job.description)), plan.knobs[job.label])
            for job in plan.methods
        }

    def _denoised(self, job, runs, truth):
        """{method label: denoised.of_runs()}, or {} with a failure where the features could not be rendered."""
        call = denoised.call(job)
        missing = [] if self.cache.load(call.key) else [call]
        for _, failure, _ in self._pool.run(missing, kind="call"):
            if failure:
                self.failures.append(f"{call.label}: {failure}")
                return {}
        found = self.cache.need(call.key)
        at = self.settings.at
        return {label: denoised.of_runs(seeds, found, truth["mean"], at) for label, seeds in runs.items()}

    def _without(self, plan, runs):
        """Of tiles: the methods' errors with one batch of the references left out at a time."""
        if not self.corners or not plan.batches or self.settings.reference_batches < 2:
            return {}
        stacks = {
            view: np.array([reference.finite(self.cache.need(job.key)["image"]) for job in jobs])
            for view, jobs in plan.batches.items()
        }
        views = [stacks[view] for view in plan.views.values()]
        return tiles.reference_errors(runs, views, self.settings.tile_size)


def cost(job):
    """The job's share of the whole work: pixels times frames."""
    pixels = len(job.tiles) * job.tile**2 if job.windows else job.size[0] * job.size[1]
    return pixels * job.frames


def total_cost(jobs):
    """Of all of them."""
    return sum(map(cost, jobs))
