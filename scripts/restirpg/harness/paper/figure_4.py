"""Figure 4: directions splatted into a point's cell beside the true product rho L_i cos, and their
divergence.

`directions` and `products` run in workers.
"""

import json

import numpy as np

from restirpg.harness.jobs import seed_of
from restirpg.harness.paper.page import Picture, Section, Table, estimate
from restirpg.harness.paper.paper import OURS, name_of

#: Places in the picture, as shares of width and height: walls, floor and tables of the embedded
#: door_ajar_diffuse.
PLACES = ((0.128, 0.339), (0.378, 0.283), (0.253, 0.672), (0.69, 0.228), (0.909, 0.617))
KINDS = {"selected by ReSTIR": False, "raw path trees": True}  # title -> raw


def directions(scene, description, size, bounces, pixels, frames, seeds, raw):
    """Of each seed and pixel's cell, over 1, 2, 4 ... frames (NaN where there was no sample): `frames` (k,),
    `histograms` (seeds, pixels, k, rows, columns), `counts`, `effective` (seeds, pixels, k); and `lobes`
    (seeds, pixels, rows, columns)."""
    from restirpg.harness import guide_maps

    learner = guide_maps.Learner(scene, json.loads(description), pixels, size, bounces, raw=raw, strict=False)
    doublings = [2**k for k in range(frames.bit_length())]
    shape, bins = (len(seeds), len(pixels), len(doublings)), (guide_maps.ROWS, guide_maps.COLUMNS)
    result = {
        "frames": np.array(doublings),
        "histograms": np.full((*shape, *bins), np.nan),
        "counts": np.zeros(shape),
        "effective": np.full(shape, np.nan),
        "lobes": np.full((*shape[:2], *bins), np.nan),
        "meta": {},
    }
    for run, seed in enumerate(seeds):
        for at, (point, mine, mixture) in enumerate(zip(*learner.run(frames, seed))):
            for done, count, effective, histogram in guide_maps.histograms(mine, point):
                k = run, at, done.bit_length() - 1
                result["histograms"][k], result["counts"][k] = histogram, count
                result["effective"][k] = effective
            if mixture:
                result["lobes"][run, at] = guide_maps.lobes_in(mixture, point)
    return result


def products(scene, description, size, bounces, pixels):
    """`products` (pixels, rows, columns)."""
    from restirpg.harness import guide_maps

    learner = guide_maps.Learner(scene, json.loads(description), pixels, size, bounces, strict=False)
    points = learner.run(1)[0]
    return {"products": np.array(guide_maps.products_at(points, scene, learner.bounces)), "meta": {}}


def calls(paper, scene):
    """[call of the products, calls of the directions of each of KINDS]."""
    width, height = paper.size.size
    pixels = [[int(x * width), int(y * height)] for x, y in PLACES[: paper.size.points]]
    seeds = [seed_of("directions", number) for number in range(paper.size.seeds)]
    learn = {"pixels": pixels, "frames": paper.size.frames, "seeds": seeds}
    return [paper.call(products, scene, OURS.graph, pixels=pixels)] + [
        paper.call(directions, scene, OURS.graph, raw=raw, **learn) for raw in KINDS.values()
    ]


def rows_of(scene, truth, answers):
    """Rows of the table, a point and count of frames each: powers of four, and the last.

    truth: products (pixels, rows, columns); answers: what `directions` gave, in the order of KINDS.
    """
    from restirpg.harness import guide_maps

    rows, random = [], np.random.default_rng(1)
    frames = answers[0]["frames"]
    for at, product in enumerate(truth):
        for k in [k for k in range(len(frames)) if k % 2 == 0 or k == len(frames) - 1]:
            row = [scene, f"{at + 1}", f"{frames[k]}"]
            for answer in answers:
                row.append(estimate(answer["counts"][:, at, k]))
                scores = np.array(
                    [
                        guide_maps.score(histogram, effective, product, random)
                        for histogram, effective in zip(answer["histograms"][:, at, k], answer["effective"][:, at, k])
                        if np.isfinite(effective)
                    ]
                )
                if not len(scores):
                    row += ["no sample", ""]
                    continue
                row += [estimate(scores[:, n]) for n in (0, 1)]
            rows.append(row)
    return rows


def run(paper):
    """Maps of the first seed, and divergences over seeds."""
    from restirpg.harness import guide_maps

    rows, maps = [], []
    for scene in paper.scenes("door_ajar_diffuse"):
        truth, *answers = paper.answers(calls(paper, scene))
        if truth is None or None in answers:
            continue
        rows += rows_of(name_of(scene), truth["products"], answers)
        selected, raw = answers
        for at, product in enumerate(truth["products"]):
            learned = (
                selected["histograms"][0, at, -1],
                raw["histograms"][0, at, -1],
                selected["lobes"][0, at],
            )
            pictures = [picture if np.isfinite(picture).all() else None for picture in (product, *learned)]
            maps.append((f"{name_of(scene)} {at + 1}", pictures))
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
