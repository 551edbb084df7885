"""Figure 2: in flatland, path-traced samples against resampled ones, the image they resolve, and what is
fitted."""

import numpy as np

from restirpg.colour import mape_scale
from restirpg.harness import plots
from restirpg.harness import statistics as st
from restirpg.harness.paper import flatland
from restirpg.harness.paper.page import Picture, Section, Table, estimate, percent

from matplotlib.figure import Figure  # isort: skip

PIXELS, CELLS, ROUNDS, SEEDS, BINS = 512, 8, 3, 32, 60
SHOWN_CELLS = (1, 4, 6)
KINDS = ("path traced", "resampled")


def run_of(seed):
    """(pixels, {kind: Reservoirs}) of one frame."""
    random = np.random.default_rng(seed)
    x = (np.arange(PIXELS) + 0.5) / PIXELS
    traced = flatland.candidates(x, random)
    resampled = traced
    for _ in range(ROUNDS):
        resampled = flatland.reuse(x, resampled, random)
    return x, dict(zip(KINDS, (traced, resampled)))


def fitted(x, kind, reservoirs, cell):
    """Lobes of a cell: of path-traced samples weighted by their light, of resampled ones each alike; and how
    many samples carry light."""
    mine = slice(cell * PIXELS // CELLS, (cell + 1) * PIXELS // CELLS)
    light = flatland.estimate(x, reservoirs)[mine]
    angle = flatland.direction(x, reservoirs.s)[mine]
    weight = light if kind == KINDS[0] else (light > 0).astype(float)
    return flatland.fit(angle[light > 0], weight[light > 0]), int((light > 0).sum())


def divergence(model, share):
    """Kullback-Leibler divergence of the true distribution from the fitted one, nats."""
    q = np.maximum(model.distribution(BINS), 1e-6)
    return float((share * np.log(np.maximum(share, 1e-30) / (q / q.sum()))).sum())


def measure():
    """{kind: rows of (MAPE, relative bias, divergence)} over seeds."""
    x = run_of(0)[0]
    right = flatland.truth(x)
    shares = [
        flatland.true_distribution(x[c * PIXELS // CELLS : (c + 1) * PIXELS // CELLS], BINS) for c in range(CELLS)
    ]
    rows = {kind: [] for kind in KINDS}
    for seed in range(SEEDS):
        _, by_kind = run_of(seed)
        for kind, reservoirs in by_kind.items():
            image = flatland.estimate(x, reservoirs)
            error = np.abs(image - right) / mape_scale(right)
            models = [fitted(x, kind, reservoirs, cell)[0] for cell in range(CELLS)]
            apart = [divergence(model, share) for model, share in zip(models, shares) if model]
            rows[kind].append((error.mean(), image.mean() / right.mean() - 1, np.mean(apart)))
    return {kind: np.array(values) for kind, values in rows.items()}


def _room(axis, title):
    axis.plot([0, 0, 1, 1, 0], [0, 1, 1, 0, 0], color="black", linewidth=1)
    axis.plot(*flatland.SCREEN.T, color="black", linewidth=3)
    s = np.linspace(0, 3, 1500)[:-1]
    place = flatland.point_at(s)[0]
    axis.scatter(*place.T, c=np.log(flatland.radiance(s)), cmap="inferno", s=8, zorder=3)
    axis.set(aspect="equal", xticks=[], yticks=[], title=title)
    axis.grid(False)
    axis.spines[:].set_visible(False)


def drawing():
    """Samples of both kinds, the resolved image, and three cells' distributions."""
    figure = Figure(figsize=(15.4, 7.2))
    grid = figure.add_gridspec(2, 6, height_ratios=(1.15, 1))
    x, by_kind = run_of(1)
    for at, (kind, reservoirs) in enumerate(by_kind.items()):
        axis = figure.add_subplot(grid[0, 2 * at : 2 * at + 2])
        light = flatland.estimate(x, reservoirs)
        _room(axis, f"{kind}: {np.mean(light > 0):.0%} of the pixels' samples carry light")
        end = flatland.point_at(reservoirs.s)[0]
        useful = flatland.radiance(reservoirs.s) > 10 * flatland.FAINT
        for i in range(0, PIXELS, 6):
            if light[i] > 0:
                axis.plot(
                    [x[i], end[i, 0]], [0, end[i, 1]], linewidth=0.6,
                    color="#d55e00" if useful[i] else "#999999", alpha=0.7 if useful[i] else 0.35,
                )  # fmt: skip
    axis = figure.add_subplot(grid[0, 4:])
    for kind, colour in zip(KINDS, plots.COLOURS):
        axis.plot(x, flatland.estimate(x, by_kind[kind]), color=colour, linewidth=0.8, label=kind)
    right = flatland.truth(x)
    axis.plot(x, right, color="black", linewidth=1.6, label="truth")
    axis.set(title="resolved image, one frame", xlabel="pixel's place on the floor", ylim=(0, 6 * right.mean()))
    axis.legend()
    for at, cell in enumerate(SHOWN_CELLS):
        axis = figure.add_subplot(grid[1, 2 * at : 2 * at + 2], projection="polar")
        mine = x[cell * PIXELS // CELLS : (cell + 1) * PIXELS // CELLS]
        angles = (np.arange(BINS) + 0.5) * np.pi / BINS
        share = flatland.true_distribution(mine, BINS)
        axis.fill(np.r_[0, angles, np.pi], np.r_[0, np.sqrt(share), 0], color="#bbbbbb", label="truth")
        for kind, colour in zip(KINDS, plots.COLOURS):
            model, count = fitted(x, kind, by_kind[kind], cell)
            if model:
                curve = np.sqrt(model.distribution(BINS))
                axis.plot(angles, curve, color=colour, label=f"{kind}, {count} samples")
        axis.set(thetamin=0, thetamax=180, yticks=[])
        axis.set_title(f"cell {cell + 1} of {CELLS}: share of light by direction (root)", fontsize=9.5)
        axis.legend(loc="upper center", bbox_to_anchor=(0.5, 0.12), fontsize=8, ncol=3)
    return figure


def run(paper):
    """The drawing, and errors over seeds. Needs no renderer."""
    rows = [
        [
            kind,
            *(percent(*st.mean_se(values[:, n])) for n in (0, 1)),
            estimate(values[:, 2]),
        ]
        for kind, values in measure().items()
    ]
    table = Table(
        "figure_2", f"Figure 2: one frame of {PIXELS} pixels, {SEEDS} seeds",
        ("samples", "MAPE", "bias of the image's mean", "KL of the truth from the fitted lobes"), rows,
    )  # fmt: skip
    text = (
        "A world of two dimensions, of our own design: pixels on a floor, bright patches on the other "
        f"walls, an opaque screen. One path per pixel; resampled by {ROUNDS} rounds of spatial reuse with the "
        "balance heuristic. Orange: paths that end on a patch. Per cell four von Mises lobes are fitted by "
        "EM, to path-traced samples weighted by their light, to resampled ones each alike."
    )
    pictures = [Picture("figure_2", "Figure 2: flatland.", drawing())]
    return Section("Figure 2: flatland", text, pictures, [table])
