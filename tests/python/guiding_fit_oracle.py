"""GuidingFit in NumPy and double precision: the M-step, what cells remember, which live on. Written from
[shaders/README: The MAP fit].

A cell that has fewer samples than the knob `minimum` keeps its lobes and, with `keep_samples`, its samples; one that
has enough is fitted, and its sums weigh `decay` in the next frame. Cells without samples live on for `oldest`
frames.
"""

from dataclasses import dataclass

import numpy as np
from guiding_oracle import (
    LOBES,
    NEW_ALPHA,
    ONE,
    Mixture,
    alpha_of,
    face_normals,
    face_of,
    mixture_of,
    new_mixture,
    previous_key,
    unpack_direction,
)

BSDF, COUNT = 16, 17  # places in a memory, after the sums


def m_step(sums, count, before, knobs):
    """The MAP mixture of sums (4, 4) over `count` samples, of the first `lobes` lobes; what the others
    explained counts for those.  [shaders/README: The MAP fit] Without samples the mixture stays."""
    if count <= 0:
        return before
    lobes = knobs["lobes"]
    sums = np.array([sums[k::lobes].sum(0) if k < lobes else np.zeros(4) for k in range(LOBES)])
    share = sums[:, 3]
    weight = (knobs["weight_prior"] + share) / (lobes * knobs["weight_prior"] + count)
    weight[lobes:] = 0
    length = np.linalg.norm(sums[:, :3], axis=-1)
    mine = weight * count
    cosine = length / np.maximum(share, 1e-20) * mine / (knobs["concentration_prior"] + mine)
    cosine = np.minimum(cosine, 1 - 1 / 32000)
    kappa = np.minimum((3 * cosine - cosine**3) / (1 - cosine**2), knobs["largest_kappa"])
    mu = np.where(length[:, None] > 0, sums[:, :3] / np.maximum(length, 1e-300)[:, None], before.mu)
    return Mixture(mu, np.where(kappa < 1e-3, 0, kappa), weight)


def reseed(m, strangest, lobes):
    """Move the lightest of the first `lobes` lobes that is below 2% or another's twin (cosine above 0.999,
    kappas within 1.5 times) to the direction `strangest`.  [shaders/README: The MAP fit] Returns the mixture, the lobe
    that was moved, the one nearest to where it was and by how little that is the nearest, or None, and by how little a
    threshold was passed or missed."""
    mu, kappa, weight = m.mu[:lobes], m.kappa[:lobes], m.weight[:lobes]
    cosines = mu @ mu.T
    ratio = np.maximum.outer(kappa, kappa) / np.maximum(np.minimum.outer(kappa, kappa), 1e-20)
    lighter = (weight[:, None] <= weight) & ~np.eye(lobes, dtype=bool)
    twins = (cosines > 0.999) & (ratio < 1.5) & lighter
    margins = [
        np.abs(weight - 0.02).min(),
        np.abs(cosines - 0.999)[lighter].min(initial=1.0),
        np.abs(ratio[lighter] / 1.5 - 1).min(initial=1.0),
    ]
    idle, moved = np.flatnonzero((weight < 0.02) | twins.any(1)), None
    if len(idle):
        order = np.sort(weight[idle])
        margins.append(np.ptp(order[:2]) if len(order) > 1 else 1.0)
        k = idle[np.argmin(m.weight[idle])]
        near = np.where(np.arange(lobes) == k, -2, cosines[k])
        moved = k, int(np.argmax(near)), np.ptp(np.sort(near)[-2:])
        m.mu[k], m.kappa[k], m.weight[k] = strangest, 10.0, 0.1
        m.weight = m.weight / m.weight.sum()
    return m, moved, min(margins)


@dataclass
class FittedCell:
    """What a cell of the guide should be. `memory` (22,): sums, bsdf, count, inverse distances, or None; `doubtful`:
    rounding decides; `handed_over`: a lobe was moved, and what it remembered is another's."""

    mixture: Mixture
    alpha: float
    age: int
    samples: float
    memory: np.ndarray | None
    doubtful: bool = False
    handed_over: bool = False


def memory_of(record):
    return np.r_[record["sums"], record["bsdf"], record["count"], record["inverseDistances"]].astype(float)


def hand_over(memory, lobe, heir, lobes):
    """The memory (22,) in which what a lobe of the first `lobes` remembers is another's."""
    by_lobe = np.c_[memory[:BSDF].reshape(LOBES, 4), memory[COUNT + 1 :]]
    given = by_lobe[lobe::lobes].sum(0)
    by_lobe[lobe::lobes] = 0
    by_lobe[heir] += given
    return np.r_[by_lobe[:, :4].ravel(), memory[BSDF : COUNT + 1], by_lobe[:, 4]]


def batch_of(sums, distances):
    """A frame's sums as a memory (22,), scaled so that the shares add up to the count of the samples.
    [shaders/README: The E-step]"""
    batch = np.r_[
        sums["lanes"] / ONE,
        sums["bsdf"] / ONE,
        sums["count"],
        distances["lanes"] / ONE if distances is not None else np.zeros(LOBES),
    ]
    total = batch[3:16:4].sum() + batch[BSDF]
    scale = batch[COUNT] / total if total > 0 else 0.0
    return batch * np.r_[np.full(17, scale), 1.0 if total > 0 else 0.0, np.full(LOBES, scale)]


def fit_cell(key, statistics, learns_alpha, grid, before, cells, knobs):
    """The FittedCell of a key that has samples. `statistics`: its records, with the BSDF as a component if
    `learns_alpha`; `before`, `cells`: the guide a frame ago; `knobs`: GuidingFit's."""
    sums = statistics[0]
    memory = batch_of(sums, statistics[1] if len(statistics) > 1 else None)
    remembers = knobs["keep_samples"] or knobs["decay"] > 0 or knobs["parallax"]
    found, doubtful = previous_key(key, grid, before, cells)
    mixture, age, samples = new_mixture(face_normals(np.array([face_of(key)]))[0]), 0, 0.0
    alpha = NEW_ALPHA
    if found:
        cell = cells[found][0]
        mixture, age, samples = mixture_of(cell), int(cell["age"]) + 1, float(cell["samples"])
        alpha = alpha_of(cell)
        if remembers:
            memory = memory + memory_of(cells[found][1])
    kept = 1.0 if knobs["keep_samples"] else knobs["decay"]
    count, lasting, moved = memory[COUNT], memory, None
    if count >= knobs["minimum"]:
        mixture = m_step(memory[:BSDF].reshape(LOBES, 4), count - memory[BSDF], mixture, knobs)
        if learns_alpha:
            prior = knobs["alpha_prior"]
            alpha = np.clip((prior + memory[BSDF]) / (2 * prior + count), 0.1, 0.9)
        if knobs["reseed"]:
            mixture, moved, margin = reseed(
                mixture,
                unpack_direction(np.uint32(sums["strangest"] & np.uint64(0xFFFFFFFF))),
                knobs["lobes"],
            )
            doubtful = doubtful or margin < 1e-4
            if moved and knobs["decay"] > 0:
                lobe, heir, margin = moved
                lasting = hand_over(memory, lobe, heir, knobs["lobes"])
                doubtful = doubtful or margin < 1e-4
        age, samples, kept = 0, count, knobs["decay"]
    elif age > knobs["oldest"]:
        samples = 0.0
    return FittedCell(
        mixture, alpha, age, samples, kept * lasting if remembers else None, doubtful, lasting is not memory
    )


def fit_guide(statistics, learns_alpha, grid, before, cells, knobs):
    """{key: FittedCell} of the whole guide."""
    guide = {
        key: fit_cell(key, records, learns_alpha, grid, before, cells, knobs) for key, records in statistics.items()
    }
    carried = cells if before and before.same_places(grid) else {}
    for key, records in carried.items():
        age = int(records[0]["age"]) + 1
        if key not in guide and age <= knobs["oldest"]:
            memory = memory_of(records[1]) if len(records) > 1 else None
            guide[key] = FittedCell(
                mixture_of(records[0]), alpha_of(records[0]), age, float(records[0]["samples"]), memory
            )
    return guide
