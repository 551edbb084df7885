"""A world of two dimensions for figure 2: one bounce off a floor, light on the other walls, a screen between.

The floor is y = 0, x in [0, 1]; a pixel is a point on it. Light comes from points of the other three walls,
addressed by their arc length s in [0, 3): up the right wall, along the ceiling to the left, down the left
wall. A pixel sees radiance(s) times cosine over two, through the angle; in the measure of s the density is

    target(x, s) = radiance(s) * visible(x, s) * cos_x * cos_s / (2 r)

so that a path moved to another pixel keeps its s and needs no Jacobian. Candidates are drawn by the cosine.
"""

from dataclasses import dataclass

import numpy as np

SCREEN = np.array([[0.3, 0.45], [0.72, 0.6]])  # end points of an opaque, black screen
#: Light: (place s, width, radiance) of Gaussian patches on a faintly lit wall.
PATCHES = ((1.25, 0.035, 12.0), (2.35, 0.05, 5.0), (0.3, 0.025, 6.0))
FAINT = 0.05


def point_at(s):
    """Points (..., 2) and inward normals of the walls at arc length s."""
    s = np.asarray(s, float)[..., None]
    place = np.where(
        s < 1, np.concatenate([np.ones_like(s), s], -1),
        np.where(s < 2, np.concatenate([2 - s, np.ones_like(s)], -1), np.concatenate([0 * s, 3 - s], -1)),
    )  # fmt: skip
    normal = np.where(s < 1, [-1.0, 0.0], np.where(s < 2, [0.0, -1.0], [1.0, 0.0]))
    return place, normal


def radiance(s):
    """What the wall at s sends to the floor."""
    s = np.asarray(s, float)
    return FAINT + sum(power * np.exp(-0.5 * ((s - place) / width) ** 2) for place, width, power in PATCHES)


def visible(x, s):
    """Whether nothing stands between floor x and wall s."""
    a, b = SCREEN
    start = np.stack([x, np.zeros_like(x)], -1)
    ray = point_at(s)[0] - start

    def side(u, v):
        return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]

    across = side(ray, a - start) * side(ray, b - start) < 0
    return ~(across & (side(b - a, start - a) * side(b - a, start + ray - a) < 0))


def density(x, s):
    """Of candidates, over s: by the cosine at the floor, whatever is in the way."""
    place, normal = point_at(s)
    ray = place - np.stack([x, np.zeros_like(x)], -1)
    r = np.maximum(np.linalg.norm(ray, axis=-1), 1e-9)
    return ray[..., 1] / r * np.maximum(-(ray * normal).sum(-1) / r, 0) / (2 * r)


def target(x, s):
    """The integrand of a pixel's radiance over s."""
    return radiance(s) * visible(x, s) * density(x, s)


def direction(x, s):
    """Angle from the floor's right, in (0, pi)."""
    ray = point_at(s)[0] - np.stack([x, np.zeros_like(x)], -1)
    return np.arctan2(ray[..., 1], ray[..., 0])


def truth(x, steps=6000):
    """Radiance of each pixel by the midpoint rule."""
    s = (np.arange(steps) + 0.5) * 3 / steps
    return np.array([target(np.full(steps, one), s).sum() * 3 / steps for one in np.atleast_1d(x)])


@dataclass(frozen=True)
class Reservoirs:
    """A path per pixel: its place on the walls, and its unbiased contribution weight."""

    s: np.ndarray
    ucw: np.ndarray


def candidates(x, random):
    """One path-traced sample per pixel."""
    cosine = 2 * random.random(len(x)) - 1  # of a direction by the cosine about the normal
    sine = np.sqrt(1 - cosine**2)
    with np.errstate(divide="ignore"):
        to_right = np.where(cosine > 0, (1 - x) / cosine, np.inf)
        to_left = np.where(cosine < 0, -x / cosine, np.inf)
        up = 1 / sine
    t = np.minimum(np.minimum(to_right, to_left), up)
    s = np.where(t == to_right, t * sine, np.where(t == up, 2 - (x + t * cosine), 3 - t * sine))
    s = np.clip(s, 0, np.nextafter(3, 0))
    p = density(x, s)
    return Reservoirs(s, np.where(p > 0, 1 / np.maximum(p, 1e-300), 0))


def reuse(x, before, random, neighbours=5, radius=40, weights="balance"):
    """One round of spatial resampling; weights "equal" is a mistake for tests: what no neighbour could have
    found then counts too little."""
    count = len(x)
    others = np.arange(count)[:, None] + random.integers(-radius, radius + 1, (count, neighbours))
    others = np.c_[np.arange(count), np.clip(others, 0, count - 1)]  # pixel, participants; itself first
    s = before.s[others]
    by_each = target(x[others][:, None, :], s[:, :, None] * np.ones(others.shape[1]))  # of path j by participant k
    own = np.take_along_axis(by_each, np.arange(others.shape[1])[None, :, None], 2)[..., 0]
    total = by_each.sum(-1)
    share = own / np.maximum(total, 1e-300) if weights == "balance" else np.full_like(own, 1 / others.shape[1])
    here = by_each[:, :, 0]
    w = np.where(total > 0, share * here * before.ucw[others], 0)
    chosen = (random.random((count, 1)) * w.sum(1, keepdims=True) > np.cumsum(w, 1)).sum(1)
    chosen = np.minimum(chosen, others.shape[1] - 1)
    rows = np.arange(count)
    f = here[rows, chosen]
    return Reservoirs(s[rows, chosen], np.where(f > 0, w.sum(1) / np.maximum(f, 1e-300), 0))


def estimate(x, reservoirs):
    """Each pixel's radiance by its one path."""
    return target(x, reservoirs.s) * reservoirs.ucw


def true_distribution(x, bins):
    """Share of the light that comes from each of `bins` angles in (0, pi), mean over the pixels x."""
    s = (np.arange(6000) + 0.5) * 3 / 6000
    histogram = np.zeros(bins)
    for one in x:
        here = np.full(len(s), one)
        histogram += np.histogram(direction(here, s), bins, (0, np.pi), weights=target(here, s))[0]
    return histogram / histogram.sum()


@dataclass(frozen=True)
class Lobes:
    """A mixture of von Mises lobes on the circle."""

    mean: np.ndarray  # angles
    kappa: np.ndarray
    weight: np.ndarray

    def densities(self, angle):
        """Weighted density of each lobe, (n, lobes)."""
        from scipy.special import i0e

        distance = np.cos(np.asarray(angle)[:, None] - self.mean) - 1
        return self.weight * np.exp(self.kappa * distance) / (2 * np.pi * i0e(self.kappa))

    def distribution(self, bins):
        """Share of each of `bins` angles in (0, pi), of what lies above the floor."""
        fine = (np.arange(16 * bins) + 0.5) * np.pi / (16 * bins)
        share = self.densities(fine).sum(1).reshape(bins, 16).sum(1)
        return share / share.sum()


def fit(angle, weight, lobes=4, steps=20, prior=0.2):
    """Lobes by EM with the priors of GuidingFit, from evenly spread ones; None without samples."""
    if not weight.sum() > 0:
        return None
    weight = weight * len(weight) / weight.sum()
    model = Lobes((np.arange(lobes) + 0.5) * np.pi / lobes, np.full(lobes, 3.0), np.full(lobes, 1 / lobes))
    vectors = np.c_[np.cos(angle), np.sin(angle)]
    for _ in range(steps):
        share = model.densities(angle)
        share = weight[:, None] * share / np.maximum(share.sum(1, keepdims=True), 1e-300)
        n = share.sum(0)
        r = share.T @ vectors
        length = np.linalg.norm(r, axis=1)
        mean = np.where(length > 0, np.arctan2(r[:, 1], r[:, 0]), model.mean)
        cosine = np.minimum(length / (n + prior), 1 - 1e-4)
        kappa = cosine * (2 - cosine**2) / (1 - cosine**2)  # [Banerjee et al. 2005], in two dimensions
        model = Lobes(mean, kappa, (n + 0.1) / (n.sum() + 0.1 * lobes))
    return model
