"""What was measured on a scene, and what has to be said about it."""

from dataclasses import dataclass, field

from restirpg.harness.equal_cost import EqualCost


@dataclass
class SceneRuns:
    """Everything measured on one scene."""

    scene: str
    reference: dict  # of the last measured frame
    runs: dict  # method label -> results by seed, only of seeds that all methods finished
    descriptions: dict  # method label -> graph description with the knobs as they were
    warnings: list = field(default_factory=list)
    at: tuple = ()  # as in Settings
    noise: tuple = ()  # reference.noise() of each frame of `at`
    denoised: dict = field(default_factory=dict)  # method label -> denoised.of_runs(); empty: not asked for
    without: dict = field(default_factory=dict)  # of tiles: tiles.reference_errors()
    equal_cost: EqualCost | None = None  # at equal frame time; None: not asked for
    origin: dict = field(default_factory=dict)  # given_reference.origin()
    raised: dict = field(default_factory=dict)  # (method label, value of the knob) -> results by seed, as `runs`


def warnings_of(runs, references):
    """Lines about runs (method label -> results by seed) and about their references, of which `meta` is given."""
    warnings = []
    everything = [result["meta"] for by_seed in runs.values() for result in by_seed]
    devices = {", ".join(meta["device"].values()) for meta in everything}
    if len(devices) > 1:
        warnings.append(f"times are those of several devices: {'; '.join(sorted(devices))}")
    machines = {meta["machine"] for meta in everything if "machine" in meta}
    if len(machines) > 1:
        warnings.append(f"times are those of several machines: {', '.join(sorted(machines))}")
    if any(meta.get("at_a_time", 1) > 1 for meta in everything):
        warnings.append(
            "some runs were not alone (--jobs), or shared a machine with other Dask workers: they took longer than they would have"
        )
    for label, by_seed in runs.items():
        if invalid := int(sum(result["invalid"].sum() for result in by_seed)):
            warnings.append(
                f"{label}: NaN or infinite pixels, {invalid} in all measured pictures: left out of its "
                "errors, black in its pictures"
            )
        if dropped := sum(result["meta"]["dropped"] for result in by_seed):
            warnings.append(
                f"{label}: {dropped} samples were NaN, infinite or beyond 1e30 and left out of its pictures: "
                "its mean is wrong where they were"
            )
    if invalid := sum(meta.get("invalid", 0) for meta in references):
        warnings.append(f"reference: {invalid} NaN or infinite pixels of its batches count as black")
    if dropped := sum(meta.get("dropped", 0) for meta in references):
        warnings.append(
            f"reference: {dropped} samples were NaN, infinite or beyond 1e30 and left out: it is wrong where they were"
        )
    return warnings


def with_knobs(description, knobs):
    """The description with every knob's actual value, defaults too."""
    passes = [{**entry, "knobs": knobs.get(entry["name"], entry.get("knobs", {}))} for entry in description["passes"]]
    return {**description, "passes": passes}
