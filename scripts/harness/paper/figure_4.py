"""Figure 4: directions splatted into a point's cell beside the true product rho L_i cos, and their
divergence.

`directions` and `products` run in workers.
"""

import json

import numpy as np

from harness import statistics as st
from harness.jobs import seed_of
from harness.paper.page import Estimate, Picture, Section, Table
from harness.paper.paper import OURS, name_of

#: Places in the picture, as shares of width and height: walls, floor and tables of the embedded
#: door_ajar_diffuse.
PLACES = ((0.128, 0.339), (0.378, 0.283), (0.253, 0.672), (0.69, 0.228), (0.909, 0.617))
KINDS = {"selected by ReSTIR": False, "raw path trees": True}  # title -> raw


def directions(scene, description, size, bounces, pixels, frames, seed, raw):
    """Of each pixel's cell, over 1, 2, 4 ... frames (NaN where there was no sample): `frames` (k,),
    `histograms` (pixels, k, rows, columns), `counts`, `effective` (pixels, k); and `lobes` (pixels, rows,
    columns)."""
    import restirpg

    from harness import guide_maps

    points, samples, mixtures = guide_maps.learn(
        restirpg.load_scene(scene),
        json.loads(description),
        pixels,
        size,
        frames,
        seed,
        bounces,
        raw=raw,
        strict=False,
    )
    doublings = [2**k for k in range(frames.bit_length())]
    shape = (len(points), len(doublings))
    result = {
        "frames": np.array(doublings),
        "histograms": np.full((*shape, guide_maps.ROWS, guide_maps.COLUMNS), np.nan),
        "counts": np.zeros(shape),
        "effective": np.full(shape, np.nan),
        "lobes": np.full((len(points), guide_maps.ROWS, guide_maps.COLUMNS), np.nan),
        "meta": {},
    }
    for at, (point, mine, mixture) in enumerate(zip(points, samples, mixtures)):
        for done, count, effective, histogram in guide_maps.histograms(mine, point):
            k = done.bit_length() - 1
            result["histograms"][at, k] = histogram
            result["counts"][at, k], result["effective"][at, k] = count, effective
        if mixture:
            result["lobes"][at] = guide_maps.lobes_in(mixture, point)
    return result


def products(scene, description, size, bounces, pixels):
    """`products` (pixels, rows, columns)."""
    import restirpg

    from harness import guide_maps

    loaded = restirpg.load_scene(scene)
    points = guide_maps.learn(loaded, json.loads(description), pixels, size, 1, strict=False)[0]
    found = [guide_maps.product_at(point, loaded, bounces or 8) for point in points]
    return {"products": np.array(found), "meta": {}}


def calls(paper, scene):
    """(call of the products, {kind: calls of the directions, one a seed})."""
    width, height = paper.size.size
    pixels = [[int(x * width), int(y * height)] for x, y in PLACES[: paper.size.points]]
    learned = {
        kind: [
            paper.call(
                directions, scene, OURS.graph, pixels=pixels, frames=paper.size.frames,
                seed=seed_of("directions", number), raw=raw,
            )
            for number in range(paper.size.seeds)
        ]
        for kind, raw in KINDS.items()
    }  # fmt: skip
    return paper.call(products, scene, OURS.graph, pixels=pixels), learned


def rows_of(scene, truth, answers):
    """Rows of the table: {kind: results by seed}; powers of four of the frames, and the last."""
    from harness import guide_maps

    rows, random = [], np.random.default_rng(1)
    frames = answers[next(iter(answers))][0]["frames"]
    shown = [k for k, count in enumerate(frames) if k % 2 == 0 or k == len(frames) - 1]
    for at, product in enumerate(truth):
        for k in shown:
            row = [scene, f"{at + 1}", f"{frames[k]}"]
            for results in answers.values():
                lit = [result for result in results if np.isfinite(result["effective"][at, k])]
                scores = [
                    guide_maps.score(result["histograms"][at, k], result["effective"][at, k], product, random)
                    for result in lit
                ]
                row.append(Estimate(*map(float, st.mean_se([result["counts"][at, k] for result in results]))))
                if not scores:
                    row += ["no sample", ""]
                    continue
                scores = np.array(scores)
                row += [Estimate(*map(float, st.mean_se(scores[:, n]))) for n in (0, 1)]
            rows.append(row)
    return rows


def run(paper):
    """Maps of the first seed, and divergences over seeds."""
    from harness import guide_maps

    rows, maps = [], []
    for scene in paper.scenes("door_ajar_diffuse"):
        truth_call, learned = calls(paper, scene)
        (truth,) = paper.answers([truth_call])
        answers = {kind: [a for a in paper.answers(many) if a] for kind, many in learned.items()}
        if truth is None or not all(answers.values()):
            continue
        rows += rows_of(name_of(scene), truth["products"], answers)
        selected, raw = (results[0] for results in answers.values())
        for at, product in enumerate(truth["products"]):
            pictures = (
                product,
                selected["histograms"][at, -1],
                raw["histograms"][at, -1],
                selected["lobes"][at],
            )
            maps.append(
                (f"{name_of(scene)} {at + 1}", [p if np.isfinite(p).all() else None for p in pictures])
            )
    header = ["scene", "point", "frames"]
    for kind in KINDS:
        header += [f"samples, {kind}", f"KL, {kind}", f"KL by chance, {kind}"]
    text = (
        "Directions that fell into the cell of a point over the frames of a run, in bins of the hemisphere "
        "of equal solid angle (azimuth across, cosine from 1 down to 0), beside L_i cos of a render from "
        "the point, and the lobes fitted at the end. KL: Kullback-Leibler divergence of the directions from "
        "the product, in nats; by chance: that of as many independent draws from the product. Raw path "
        "trees are unguided, weighted by light, BSDF and cosine over density."
    )
    titles = ("L_i cos", *KINDS, "fitted lobes")
    table = Table("figure_4", "Figure 4: divergence from the product", tuple(header), rows)
    title = "Figure 4: what the guide learns from"
    if not maps:
        return Section(title, "Nothing was finished: see what failed.")
    caption = "Figure 4: what is splatted, and the product."
    return Section(title, text, [Picture("figure_4", caption, guide_maps.draw(maps, titles))], [table])
