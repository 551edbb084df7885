"""What is to be rendered of a scene, and what is to be said of it before it is."""

from dataclasses import dataclass, field, replace

from restirpg.harness import UserError, equal_cost, given_reference
from restirpg.harness.jobs import seed_of
from restirpg.harness.mean_knobs import differences, mean_of


@dataclass(frozen=True)
class ScenePlan:
    """The jobs of a scene."""

    scene: str  # file
    methods: list  # a Job each, of any seed; the first is the baseline
    views: dict  # see views_of()
    knobs: dict  # method label -> Renderer.knobs()
    origin: dict  # given_reference.origin()
    batches: dict = field(default_factory=dict)  # view -> independent jobs of its reference; {}: that is a file
    warnings: list = field(default_factory=list)

    def jobs(self, seeds):
        """The methods with each of the seeds."""
        return [replace(job, seed=seed) for seed in seeds for job in self.methods]


def make(settings, facts, jobs, probes):
    """The ScenePlan for scenes.Facts; raises UserError. jobs: of the methods, and last of the reference unless it is a file.
    probes: job's label -> what is known before its first frame."""
    methods = [job for job in jobs if job.label != "reference"]
    knobs = {job.label: probes[job.label]["knobs"] for job in methods}
    views = views_of(settings, facts)
    means = {label: mean_of(own) for label, own in knobs.items()}
    _check_equal_frame_time(settings, knobs)
    if settings.reference:
        batches, warnings = {}, _warnings_of_given(settings, facts, views, means)
    else:
        batches, warnings = _rendered(settings, jobs[-1], probes["reference"]["knobs"], views, means)
    if settings.motion and settings.motion.fps and not facts.animation:
        warnings.append("the scene has no animation that --fps could play")
    origin = given_reference.origin(jobs[0].scene, facts, settings)
    return ScenePlan(jobs[0].scene, methods, views, knobs, origin, batches, warnings)


def _check_equal_frame_time(settings, knobs):
    raised = settings.equal_frame_time
    if raised and all(equal_cost.start_of(own, raised) is None for own in knobs.values()):
        raise UserError(
            f"no method has a whole number '{raised}' that --equal-frame-time could raise; write it PASS.KNOB"
        )


def views_of(settings, facts):
    """{measured frame: the first one that shows the same, whose reference it has}; {0: 0} of the mean."""
    at, motion = settings.at, settings.motion
    if not motion:
        return dict.fromkeys(at or (0,), 0)
    poses, first = {}, {}
    for frame in range(1, at[-1] + 1):
        step, seconds = motion.pose(frame)
        poses[frame] = step, facts.held_since(seconds) if motion.fps else 0.0
        first.setdefault(poses[frame], frame)
    return {frame: first[poses[frame]] for frame in at}


def _warnings_of_given(settings, facts, views, means):
    """What is to be said of a picture that is the reference."""
    if len(set(views.values())) > 1:
        raise UserError(
            f"{settings.reference}: the frames measured show different things; one picture cannot be the reference of all"
        )
    header = given_reference.check(settings.reference, facts.scene_hash, settings.size)
    return given_reference.warnings_of(settings.reference, header, settings, facts.environment_hash, means)


def _rendered(settings, job, knobs, views, means):
    """({view: jobs of its reference}, warnings). job, knobs: the reference's, as its graph has them."""
    own, wanted = mean_of(knobs), reference_mean(means.values(), job.bounces)
    jitter = (("jitter", wanted["jitter"]),) if "jitter" in differences(own, wanted, "") else ()
    if "bounces" not in own:
        wanted.pop("bounces", None)
    frames = max(1, settings.reference_frames // settings.reference_batches)
    windows = bool(job.tiles)
    still = replace(job, bounces=wanted.get("bounces"), knobs=jitter, frames=frames, at=(), windows=windows)
    batches = {view: _batches(settings, still, view) for view in dict.fromkeys(views.values())}
    return batches, [line for label, mean in means.items() for line in _differences(label, mean, wanted)]


def reference_mean(means, cap):
    """The mean_of() of a reference for methods of those: the bounce cap `cap`, or else the largest, and the pixel filter of
    the first that has one."""
    caps = [own["bounces"] for own in means if "bounces" in own] if cap is None else [cap]
    filters = [own["jitter"] for own in means if "jitter" in own]
    return {**({"bounces": max(caps)} if caps else {}), **({"jitter": filters[0]} if filters else {})}


def _differences(label, mean, wanted):
    """Lines about a method whose mean is not the reference's."""
    for knob, words in differences(mean, wanted, "the reference").items():
        advice = "; @gbuffer.jitter=false gives all the same" if knob == "jitter" else ""
        yield f"{label}: {words}: the difference counts as error{advice}"


def _batches(settings, job, view):
    """The jobs of a view's reference, independent of each other."""
    return [
        replace(
            job,
            still=view,
            label=f"reference {number + 1}" + (f" of frame {view}" if view else ""),
            seed=seed_of(settings.base_seed, "reference", number),
        )
        for number in range(settings.reference_batches)
    ]
