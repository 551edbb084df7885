"""What guides the paths at some points: fitted lobes, the directions they were fitted to, and the true
product rho L_i cos, in bins of the hemisphere about the surface's normal: azimuth to the right, cosine
downwards from 1 to 0, so that equal areas are equal solid angles. [Zeng et al. 2025, figure 4]

The product is a render of what the point sees (five faces of a cube, path traced with one bounce less,
without what is emitted towards the point itself: direct light is not ReSTIR PT's); it stands for the product
on diffuse surfaces alone.
"""

import numpy as np

import restirpg
from restirpg.colour import luminance
from restirpg.harness import UserError, plots  # noqa: F401  (chooses matplotlib's backend and style)
from restirpg.harness.guiding import (
    LEARNT,
    SAMPLE,
    GuidedGraph,
    added_rows,
    is_valid,
    mixture_of,
    read_guide,
    splatted_paths,
    unpack_direction,
    vertex_face,
    vertex_scatter,
    with_learnt_paths,
)

from matplotlib.figure import Figure  # isort: skip

ROWS, COLUMNS = 8, 32  # bins of a hemisphere
FACE = 48  # pixels of a cube's face
FACE_FRAMES = 64


class Point:
    """A surface point: `position` (3,) in the world, `place` (3,) as kernels have it, from the scene's origin on,
    `frame` (3, 3) whose last row is the normal, `key` of its cell, `radius` of the scene."""

    def __init__(self, position, place, normal, key, radius):
        self.position, self.place, self.key, self.radius = position, place, key, radius
        tangent = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
        tangent /= np.linalg.norm(tangent)
        self.frame = np.stack([tangent, np.cross(normal, tangent), normal])

    def histogram(self, directions, weights):
        """Share of the weights in each bin of the hemisphere, (ROWS, COLUMNS); what lies below the horizon is
        left out."""
        x, y, z = self.frame @ np.asarray(directions).T
        above = z > 0
        sums = np.histogram2d(
            1 - z[above],
            np.arctan2(y, x)[above],
            (ROWS, COLUMNS),
            ((0, 1), (-np.pi, np.pi)),
            weights=np.asarray(weights)[above],
        )[0]
        return sums / max(sums.sum(), 1e-30)


class Learner:
    """Runs of a graph, by its description, that show what the guide learns from at the points of some pixels.

    raw: instead of the vertices of the paths that were selected, those of raw unguided path trees, weighted
    by light, BSDF and cosine. strict: see find_points.
    """

    def __init__(self, scene, description, pixels, size, bounces=None, cell_size=None, raw=False, strict=True):
        self._pixels, self._size, self._raw, self._strict = pixels, size, raw, strict
        self._names = names = GuidedGraph(description)
        self._port = (names.paths, "samples") if raw else (LEARNT, "vertices")
        shown = [
            {"name": "training", "pass": self._port[0], "output": self._port[1]},
            {"name": "normal", "pass": names.gbuffer, "output": "geometric_normal"},
            {"name": "depth", "pass": names.gbuffer, "output": "depth"},
            {"name": "material", "pass": names.gbuffer, "output": "material"},
        ]
        made = description if raw else with_learnt_paths(description)
        if made is None:
            name = description.get("name")
            raise UserError(
                f"graph '{name}': its guide learns from raw samples; --raw shows those of unguided path trees"
            )
        graph = {**made, "outputs": description["outputs"] + shown}
        self._renderer = restirpg.Renderer(scene, graph, size=tuple(size), bounces=bounces)
        if cell_size:
            self._renderer.set(f"{names.splat}.cell_size", cell_size)
        if raw:
            self._renderer.set(f"{names.paths}.alpha", 1.0)

    @property
    def bounces(self):
        """The bounce cap of its paths: what was asked for, the scene's or the graph's own."""
        return self._renderer.get(f"{self._names.paths}.bounces")

    def run(self, frames, seed=1):
        """The points, and for each a list of (directions (n, 3), weights (n,)) a frame and its last fitted
        mixture, or None."""
        renderer, points, collected = self._renderer, [], []
        renderer.seed = seed
        renderer.cut()
        for _ in range(frames):
            renderer.render(1)
            grid = self._names.grid(renderer)
            points = points or find_points(renderer, grid, self._pixels, self._size, self._strict)
            learns_from = (None, ".".join(self._port)) if self._raw else (self._names.splat,)
            directions, weights, keys = learnt(renderer, grid, *learns_from)
            mine = [(keys == np.uint64(point.key)) & (weights > 0) for point in points]
            collected.append([(unpack_direction(directions[m]), weights[m]) for m in mine])
        guide = read_guide(renderer.read_port(f"{self._names.fit}.guide"))[1]
        mixtures = [mixture_of(guide[point.key]) if point.key in guide else None for point in points]
        return points, [list(samples) for samples in zip(*collected)], mixtures


def learnt(renderer, grid, splat, samples=None):
    """Packed directions, weights and keys of what a guide has learnt from in the last frame: the raw samples at the port
    `samples`, or (None) paths; only those that the GuidingSplat of the name `splat` (None: there is none) has added."""
    if samples is None:
        data, weights = splatted_paths(renderer, splat)
    else:
        data = renderer.read_port(samples).view(SAMPLE)
        data = added_rows(renderer, splat, data).ravel() if splat else data
        data = data[is_valid(data)]
        weights = data["weight"] * vertex_scatter(data)
    positions = grid.positions(data["position"])
    keys = grid.keys(positions, vertex_face(data), data["surface"] & 0xFFFF)[0]
    return data["direction"], weights, keys


def find_points(renderer, grid, pixels, size, strict=True):
    """The points that the pixels see. grid: of the frame that the renderer made last.

    Where a pixel shows no surface UserError is raised, or, unless `strict`, the next one towards the
    picture's middle that does is taken.
    """
    width, height = size
    camera = {name: np.array(value) for name, value in renderer.camera.items()}
    forward = camera["target"] - camera["position"]
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, camera["up"])
    right /= np.linalg.norm(right)
    extent = np.tan(camera["yfov"] / 2)
    images = {name: renderer.output(name) for name in ("normal", "depth", "material")}
    points = []
    for x, y in pixels:
        if not strict:
            x, y = _next_surface(images["depth"][..., 0], x, y)
        if not (0 <= x < width and 0 <= y < height and images["depth"][y, x, 0] > 0):
            raise UserError(f"pixel {x} {y} shows no surface; give one of the {width}x{height} that does")
        across, down = (2 * (x + 0.5) / width - 1) * width / height, 1 - 2 * (y + 0.5) / height
        ray = forward + extent * (across * right + down * np.cross(right, forward))
        away = images["depth"][y, x, 0] * ray
        position, place = camera["position"] + away, grid.camera + away
        normal = images["normal"][y, x].astype(float)
        axis = np.abs(normal).argmax()
        face, material = np.array([2 * axis + (normal[axis] < 0)]), images["material"][y, x].astype(int)
        points.append(Point(position, place, normal, int(grid.keys(place[None], face, material)[0][0]), grid.radius))
    return points


def _next_surface(depth, x, y):
    """The first pixel with a surface from x, y to the picture's middle; the last one if there is none."""
    height, width = depth.shape
    for t in np.linspace(0, 1, 2 * max(width, height)):
        at = round(x + t * (width // 2 - x)), round(y + t * (height // 2 - y))
        if depth[at[1], at[0]] > 0:
            break
    return at


def products_at(points, scene, bounces, seconds=0.0, **options):
    """L_i cos of each point in each bin, normalised, (ROWS, COLUMNS). bounces: the cap of the paths from the eye. seconds: of
    the scene's animation. options: further arguments of restirpg.Renderer."""
    if bounces == 0:  # they end at the points
        return [np.zeros((ROWS, COLUMNS)) for _ in points]
    g = restirpg.Graph("What a point sees")
    gbuffer = g.add("gbuffer", "GBuffer", jitter=True)
    paths = g.add("paths", "PathTracerGuided", surface=gbuffer.surface, direct=True)
    image = g.add("accumulate", "Accumulate", indirect=paths.radiance, history=restirpg.prev("accumulate.sums"))
    g.output("image", image.mean)
    renderer = restirpg.Renderer(scene, g, size=(FACE, FACE), seed=2, bounces=bounces - 1, **options)
    if scene.duration > 0:
        renderer.set_time(seconds)
    return [_product(point, renderer) for point in points]


def _product(point, renderer):
    x, y, normal = point.frame
    place = (np.arange(FACE) + 0.5) / FACE * 2 - 1
    right, up = np.meshgrid(place, -place)
    directions, weights = [], []
    for forward, above in ((normal, x), (x, normal), (-x, normal), (y, normal), (-y, normal)):
        renderer.cut()
        eye = point.position + 2e-5 * point.radius * normal
        renderer.move_camera(position=eye, target=eye + forward, up=above, yfov=np.pi / 2)
        renderer.render(FACE_FRAMES)
        d = forward + right[..., None] * np.cross(forward, above) + up[..., None] * above
        length = np.linalg.norm(d, axis=-1)
        directions.append((d / length[..., None]).reshape(-1, 3))
        light = luminance(renderer.output("image")) * length**-3.0  # of a pixel: times its solid angle
        weights.append((light * np.maximum(d @ normal / length, 0)).ravel())
    return point.histogram(np.concatenate(directions), np.concatenate(weights))


def divergence(histogram, product):
    """Kullback and Leibler's, of the histogram from the product, nats. A bin where the product is 0 counts as
    a thousandth of a bin."""
    q = np.maximum(product, 1e-3 / product.size)
    return float((histogram * np.log(np.maximum(histogram, 1e-30) / (q / q.sum()))).sum())


def histograms(samples, point):
    """[(frames, samples, effective samples, histogram)] of the first 1, 2, 4 ... frames; none of no
    samples."""
    rows, frames = [], 1
    while frames <= len(samples):
        directions = np.concatenate([d for d, _ in samples[:frames]])
        weights = np.concatenate([w for _, w in samples[:frames]])
        if len(weights):
            effective = weights.sum() ** 2 / (weights**2).sum()
            rows.append((frames, len(weights), effective, point.histogram(directions, weights)))
        frames *= 2
    return rows


def score(histogram, effective, product, random):
    """(divergence from the product, that of as many independent draws, chi-square over degrees of
    freedom). NaN where the product is 0 everywhere."""
    if product.sum() == 0:
        return np.nan, np.nan, np.nan
    n = max(round(effective), 1)
    draws = random.multinomial(n, product.ravel() / product.sum(), 20) / n
    least = np.mean([divergence(draw.reshape(product.shape), product) for draw in draws])
    wide = product * n >= 5
    chi_square = np.nan
    if wide.sum() > 1:
        chi_square = n * ((histogram - product)[wide] ** 2 / product[wide]).sum() / (wide.sum() - 1)
    return divergence(histogram, product), least, chi_square


def lobes_in(mixture, point):
    """The mixture's mass in each bin, normalised over the hemisphere (0 where all of it is below the horizon)."""
    fine = 8
    z = 1 - (np.arange(ROWS * fine) + 0.5) / (ROWS * fine)
    phi = (np.arange(COLUMNS * fine) + 0.5) / (COLUMNS * fine) * 2 * np.pi - np.pi
    z, phi = np.meshgrid(z, phi, indexing="ij")
    r = np.sqrt(1 - z * z)
    w = np.stack([r * np.cos(phi), r * np.sin(phi), z], -1).reshape(-1, 3) @ point.frame
    density = np.exp(mixture.log_density(w)).reshape(ROWS, fine, COLUMNS, fine).sum((1, 3))
    return density / max(density.sum(), 1e-30)


def top_of(maps):
    """The density that a row of maps shows as white: of the first map that has any, the quantile 0.99 of its bins, or the
    largest where that is 0."""
    first = next((values for values in maps if values is not None and values.any()), np.ones(1))
    return float(np.quantile(first, 0.99)) or float(first.max())


def draw(rows, titles):
    """A figure of maps: rows [(label, [map or None])], densities on one scale per row, see top_of."""
    figure = Figure(figsize=(4 * len(titles), 0.3 + 1.5 * len(rows)))
    axes = figure.subplots(len(rows), len(titles), squeeze=False)
    for row, (label, maps) in zip(axes, rows):
        top = top_of(maps)
        for axis, picture, title in zip(row, maps, titles):
            axis.set_xticks([])
            axis.set_yticks([])
            axis.grid(False)
            if picture is not None:
                axis.imshow(picture, vmin=0, vmax=top, cmap="magma", aspect="auto", extent=(-180, 180, 0, 1))
            axis.set_title(f"{label}: {title}", fontsize=9)
    return figure
