"""What the figures share: sizes, scenes, methods, and runs and calls that are kept in one cache."""

import json
import os
from dataclasses import dataclass, replace
from pathlib import Path

import restirpg
from restirpg.harness import UserError, analysis, csv_files, files, render, report, scenes
from restirpg.harness.comparison import PATH_TRACER, Comparison, Settings
from restirpg.harness.jobs import Call, Method, made_from, without_places

GRAPHS = os.path.relpath(restirpg.GRAPHS)  # from any folder


def method(graph, label, **knobs):
    """A graph of graphs/; a knob "splat__cell_size" is the pass's `splat.cell_size`."""
    settings = tuple((name.replace("__", "."), value) for name, value in knobs.items())
    return Method(label, f"{GRAPHS}/{graph}.py", settings)


UNGUIDED = method("restir_pt", "without guiding")
OURS = method("restir_pg", "ReSTIR PG")
PLUS = method("restir_pg_plus", "ReSTIR PG+")
RUPPERT = method("raw_pt_ruppert2020", "Ruppert 2020")
DEREVYANNYKH = method("raw_pt_derevyannykh2022", "Derevyannykh 2022")
METHODS = (UNGUIDED, DEREVYANNYKH, RUPPERT, OURS)  # the first is what the others are tested against
SHOWN = (DEREVYANNYKH, RUPPERT, UNGUIDED, OURS)  # from left to right, as in the paper


@dataclass(frozen=True)
class Size:
    """How large an evaluation is."""

    name: str
    size: tuple  # width, height
    seeds: int
    frames: int
    reference_frames: int  # over all batches
    scenes: tuple
    ablation_scenes: int  # the first of the scenes
    points: int = 5  # of figure 4
    scales: tuple = (0.5, 1, 2)  # of the resolution study's pictures
    reference_batches: int = 16
    reference_graph: str = PATH_TRACER
    bounces: int | None = None  # in place of the scenes' own caps

    @property
    def motion_reference_frames(self):
        """Of the reference's graph, for each frame of a sequence that is compared."""
        return max(self.reference_frames // 4, self.reference_batches)


SCENES = ("door_ajar", "bidirectional_room", "living_room", "temple", "glass_pavilion")
QUICK = Size("quick", (96, 54), 4, 32, 2048, SCENES[:3], 1, points=3)
DEFAULT = Size("default", (160, 90), 8, 32, 4096, SCENES, 2)
FULL = Size("full", (480, 270), 4, 64, 4096, SCENES, 1, scales=(1 / 6, 1 / 3, 2 / 3, 4 / 3))


@dataclass(frozen=True)
class Study:
    """A comparison: methods on scenes, all with the same seeds."""

    methods: tuple
    scenes: tuple  # names or files
    changes: tuple = ()  # ((field of Settings, value), ...): what differs from the evaluation's settings
    views: int = 1  # references per scene: measured frames that show different things


@dataclass(frozen=True)
class Results:
    """A finished study. `runs`: a SceneRuns each scene; `findings`: a SceneFindings each, in the same
    order."""

    runs: list
    findings: list


class Paper:
    """One evaluation: its size and folder, and what has been measured for it so far."""

    def __init__(self, size, out, cache, pool, display, chosen=None, allow_outside=False):
        self.size, self.out, self.cache, self.pool, self.display = size, Path(out), cache, pool, display
        self.chosen = tuple(chosen or ())  # scenes that the user named, in place of those of the figures
        self.allow_outside = allow_outside  # scenes may read files that lie outside of their own folder
        self.failures, self.devices, self.code = [], {}, render.code_version()
        self._results, self._files = {}, {}

    def scenes(self, *own):
        """Names or files: the user's, or `own`, or the evaluation's."""
        return self.chosen or own or self.size.scenes

    def file(self, scene):
        """The file of a scene by name or path; an embedded one is written into the folder `scenes`."""
        if scene not in self._files:
            own = self.out / "scenes" / f"{scene}.glb"
            if not Path(scene).is_file() and any(own.resolve() == Path(name).resolve() for name in self.chosen):
                raise UserError(f"{own}: the embedded '{scene}' would be written over it; name one of the two")
            self._files[scene] = scenes.file_of(scene, self.out / "scenes")
        return self._files[scene]

    def settings(self, study):
        """The study as the harness's Settings."""
        settings = made_from(
            Settings,
            self.size,
            methods=study.methods,
            scenes=tuple(self.file(scene) for scene in study.scenes),
            allow_outside=self.allow_outside,
        )
        return replace(settings, **dict(study.changes))

    def compare(self, study, folder=None):
        """Run what is missing of a study; its CSV and EXR files go to `folder`, if one is named."""
        if study not in self._results:
            comparison = Comparison(self.settings(study), self.cache, self.pool, self.display)
            comparison.prepare()
            self.devices.update(comparison.device)
            runs = [scene for scene in comparison.run() if scene.runs]
            self.failures += [line for line in comparison.failures if line not in self.failures]
            self._results[study] = Results(runs, analysis.analyse(runs))
        results = self._results[study]
        if folder:
            files.make_folder(self.out / folder, "--out")
            tables = csv_files.write_csv(results.findings, self.out / folder)
            files.remove_earlier(
                self.out / folder, [*tables, *report.write_pictures(results.findings, self.out / folder)]
            )
        return results

    def call(self, function, scene, graph, **settings):
        """A Call of `function` on a scene, to be given to `answers`.

        Besides `settings` the function is given the graph's `description`, the picture's `size` and the
        evaluation's or the scene's cap of `bounces`, unless they are among the settings.
        """
        file = self.file(scene)
        facts = scenes.facts(self.pool, file, allow_outside=self.allow_outside)
        settings = {
            "description": without_places(json.dumps(render.describe_graph(graph))),
            "size": self.size.size,
            "bounces": facts.bounces(self.size.bounces),
        } | settings
        label = f"{Path(file).stem}, {function.__module__.rpartition('.')[2]}"
        return Call(function, file, facts.hash, tuple(sorted(settings.items())), self.code, self.allow_outside, label)

    def answers(self, calls):
        """The calls' results in order, None for one that failed; what is not in the cache is measured."""
        keys = [call.key for call in calls]
        calls = dict(zip(keys, calls))
        missing = [call for call in calls.values() if self.cache.load(call.key) is None]
        for number, (call, failure, _) in enumerate(self.pool.run(missing, kind="call"), 1):
            if failure:
                self.failures.append(f"{call.label}: {failure}")
                self.display.message(f"failed: {self.failures[-1]}")
            else:
                self.display.message(f"{call.label}: {number} of {len(missing)}")
        return [self.cache.load(key) for key in keys]


def name_of(scene):
    """What a scene is called in tables, figures and file names."""
    return Path(scene).stem
