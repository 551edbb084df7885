"""Procedural images: sRGB (H, W, 3) that repeat seamlessly unless they say otherwise. Seeded, own design."""

import functools

import numpy as np

from restirpg.colour import srgb

from .gltf import Texture


def to_srgb(linear):
    """sRGB bytes of linear colours in [0, 1]."""
    return (srgb(np.clip(linear, 0.0, 1.0)) * 255 + 0.5).astype(np.uint8)


def noise(size, octaves, seed, start=4):
    """Periodic fractal value noise in [0, 1], (size, size): octaves of smoothly interpolated lattices."""
    random = np.random.default_rng(seed)
    total, weight = np.zeros((size, size)), 0.0
    for octave in range(octaves):
        cells = start << octave
        lattice = random.random((cells, cells))
        x = np.arange(size) * cells / size
        i = x.astype(int)
        f = x - i
        f = f * f * (3 - 2 * f)
        j = (i + 1) % cells
        rows = lattice[i] * (1 - f)[:, None] + lattice[j] * f[:, None]
        total += (rows[:, i] * (1 - f) + rows[:, j] * f) * 0.5 ** octave
        weight += 0.5 ** octave
    return total / weight


def mix(a, b, t):
    """Linear blend of colours a and b (3,) by t (H, W)."""
    return np.asarray(a) * (1 - t[..., None]) + np.asarray(b) * t[..., None]


def pixel_grid(width, height):
    """(u, v) of the texel centres, each (height, width)."""
    return np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)


@functools.cache
def checker(dark, light, seed=1, size=512, marbling=0.25):
    """Two by two polished stone tiles with thin joints."""
    u, v = pixel_grid(size, size)
    parity = ((u < 0.5) ^ (v < 0.5)).astype(float)
    veins = 1 - np.abs(2 * noise(size, 5, seed) - 1)
    colors = mix(dark, light, parity) * (1 - marbling * veins[..., None] ** 6)
    joint = np.minimum(np.abs((2 * u + 0.5) % 1 - 0.5), np.abs((2 * v + 0.5) % 1 - 0.5)) < 0.006
    return Texture(to_srgb(np.where(joint[..., None], 0.6 * np.asarray(dark) + 0.02, colors)))


@functools.cache
def wood(dark, light, seed=2, size=512):
    """Boards along u, four across v, each with its own grain."""
    random = np.random.default_rng(seed)
    grain = noise(size, 6, seed, start=2)
    _, v = pixel_grid(size, size)
    board = (v * 4).astype(int)
    shift = random.integers(0, size, 4)
    rows = np.arange(size)
    stretched = np.empty((size, size))
    for k in range(4):  # the noise runs 8 times slower along the board, from an own start
        columns = (np.arange(size) // 8 + shift[k]) % size
        block = slice(k * size // 4, (k + 1) * size // 4)
        stretched[block] = grain[rows[block]][:, columns] + 0.15 * np.sin(
            40 * v[block] + 12 * grain[rows[block]][:, columns])
    tone = np.clip(stretched + (random.random(4) * 0.3 - 0.15)[board], 0, 1)
    joint = (v * 4) % 1 < 0.012
    return Texture(to_srgb(mix(dark, light, tone) * np.where(joint, 0.35, 1.0)[..., None]))


@functools.cache
def planks(dark, light, seed=3, size=1024):
    """Parquet: boards along u, eight across v, with staggered ends."""
    random = np.random.default_rng(seed)
    u, v = pixel_grid(size, size)
    row = (v * 8).astype(int)
    along = (u * 2 + random.random(8)[row]) % 2
    board = row * 2 + along.astype(int)
    fine = noise(size, 7, seed, start=2)
    columns = (np.arange(size) // 10 + 97 * board) % size
    grain = fine[np.arange(size)[:, None], columns]
    tone = np.clip(0.7 * grain + 0.5 * random.random(16)[board] - 0.1, 0, 1)
    joint = ((v * 8) % 1 < 0.02) | (along % 1 < 0.004)
    return Texture(to_srgb(mix(dark, light, tone) * np.where(joint, 0.3, 1.0)[..., None]))


@functools.cache
def tiles(color, joint_color, count=4, seed=4, size=512, variation=0.2):
    """Square tiles of slightly different tones with joints."""
    random = np.random.default_rng(seed)
    u, v = pixel_grid(size, size)
    tone = 1 + variation * (random.random((count, count)) - 0.5)[(v * count).astype(int),
                                                                 (u * count).astype(int)]
    colors = np.asarray(color) * (tone * (0.85 + 0.3 * noise(size, 6, seed)))[..., None]
    edge = np.minimum(np.abs((u * count + 0.5) % 1 - 0.5), np.abs((v * count + 0.5) % 1 - 0.5))
    return Texture(to_srgb(np.where((edge < 0.02)[..., None], joint_color, colors)))


@functools.cache
def bricks(color, joint_color, seed=5, size=512):
    """Running bond: 8 courses of 4 bricks."""
    random = np.random.default_rng(seed)
    u, v = pixel_grid(size, size)
    course = (v * 8).astype(int)
    along = (u * 4 + 0.5 * (course % 2)) % 4
    tone = 0.7 + 0.6 * random.random((8, 4))[course, along.astype(int)]
    colors = np.asarray(color) * (tone * (0.75 + 0.5 * noise(size, 6, seed)))[..., None]
    joint = ((v * 8) % 1 < 0.07) | (along % 1 < 0.035)
    return Texture(to_srgb(np.where(joint[..., None], joint_color, colors)))


@functools.cache
def plaster(color, seed=6, size=512, contrast=0.12):
    """A wall colour with faint blotches."""
    return Texture(to_srgb(np.asarray(color) * (1 + contrast * (noise(size, 6, seed) - 0.5))[..., None]))


@functools.cache
def marble(dark, light, seed, size=512):
    """Polished stone: bands of colour bent by turbulence, with pale veins."""
    u, v = pixel_grid(size, size)
    warp = noise(size, 6, seed, start=2)
    bands = 0.5 + 0.5 * np.sin(2 * np.pi * (2 * u + v) + 9 * warp)
    veins = sum(np.clip(1 - 40 * np.abs(noise(size, 6, seed + k, start=k) - 0.5), 0, 1)
                for k in (2, 3, 5)) / 2
    colors = mix(dark, light, bands * (0.4 + 0.6 * noise(size, 6, seed + 2)))
    return Texture(to_srgb(colors + 0.25 * veins[..., None]))


@functools.cache
def curtained_window(seed, size=128):
    """The glow of a room behind half-drawn curtains (does not repeat)."""
    random = np.random.default_rng(seed)
    u, v = pixel_grid(size, size)
    opening = 0.20 + 0.25 * random.random()
    folds = 0.45 + 0.15 * np.sin(2 * np.pi * (9 * u + 0.4 * np.sin(5 * v + 6 * random.random())))
    drawn = np.abs(u - 0.5) > opening + 0.05 * np.sin(3 * v)
    ceiling = 0.55 + 0.45 * np.exp(-((u - random.random()) ** 2 + (v - 0.15) ** 2) / 0.08)
    furniture = (v > 0.72) & (np.abs(u - random.random()) < 0.22)
    glow = np.where(drawn, 0.6 * folds, ceiling * np.where(furniture, 0.25, 1.0))
    return Texture(to_srgb(glow[..., None] * np.where(drawn[..., None], (1.0, 0.7, 0.5), 1.0)))


@functools.cache
def woven(color, seed=7, size=256):
    """A coarse fabric: alternating warp and weft."""
    u, v = pixel_grid(size, size)
    weave = 0.75 + 0.25 * np.sin(64 * np.pi * u) * np.sin(64 * np.pi * v)
    return Texture(to_srgb(np.asarray(color) * (weave * (0.85 + 0.3 * noise(size, 4, seed)))[..., None]))


@functools.cache
def rug(ground, figure, border, width=512, height=768):
    """A carpet of nested lozenges within two borders (does not repeat)."""
    u, v = pixel_grid(width, height)
    lozenge = (np.abs(u * 4 % 1 - 0.5) + np.abs(v * 6 % 1 - 0.5)) * 6 % 1 < 0.45
    colors = mix(ground, figure, lozenge.astype(float))
    edge = np.minimum(np.minimum(u, 1 - u) * width, np.minimum(v, 1 - v) * height) / width
    colors = np.where((edge < 0.12)[..., None], border, colors)
    stripe = ((edge > 0.05) & (edge < 0.065)) | ((edge > 0.105) & (edge < 0.12))
    colors = np.where(stripe[..., None], figure, colors)
    threads = 0.85 + 0.15 * np.sin(np.pi * v * height / 2)
    return Texture(to_srgb(colors * threads[..., None]))


@functools.cache
def painting(seed=8, width=640, height=480):
    """A landscape at dusk: banded sky, a low sun, ranges of hills in mist, reflections in a lake."""
    random = np.random.default_rng(seed)
    u, v = pixel_grid(width, height)
    horizon = 0.62
    above = np.where(v > horizon, 2 * horizon - v, v)  # the lake shows the sky and hills upside down
    brush = noise(1024, 6, seed)[:height, :width] - 0.5
    above = above + 0.02 * brush
    t = np.clip(above / horizon, 0, 1)
    colors = mix((0.16, 0.30, 0.62), (1.0, 0.62, 0.26), t ** 1.3)
    colors += np.exp(-((u - 0.67) ** 2 + (above - 0.47) ** 2) / 0.01)[..., None] * (0.9, 0.6, 0.25)
    colors = np.where((((u - 0.67) ** 2 + (0.75 * (above - 0.47)) ** 2) < 0.0016)[..., None],
                      (1.0, 0.9, 0.65), colors)
    for layer in range(4):
        phase = random.random(3) * 6.28
        ridge = 0.40 + 0.055 * layer + 0.05 * np.sin(5 * u + phase[0]) + 0.025 * np.sin(13 * u + phase[1])
        ridge = ridge + 0.008 * np.sin(41 * u + phase[2])
        depth = (layer + 1) / 4
        hill = mix(np.array((0.62, 0.45, 0.52)) * (1 - depth) + np.array((0.06, 0.16, 0.08)) * depth,
                   (0.8, 0.5, 0.3), np.clip((above - ridge) * 3, 0, 0.35))
        colors = np.where((above > ridge)[..., None], hill, colors)
    ripple = 0.75 + 0.15 * np.sin(v * 420 + 25 * brush)
    colors *= np.where(v > horizon, ripple, 1.0)[..., None] * (1 + 0.5 * brush[..., None])
    return Texture(to_srgb(colors))


@functools.cache
def abstract_painting(seed=9, width=480, height=640):
    """Overlapping translucent discs and bars on a pale ground."""
    random = np.random.default_rng(seed)
    u, v = pixel_grid(width, height)
    v = v * height / width
    colors = mix((0.86, 0.80, 0.68), (0.74, 0.68, 0.55), noise(1024, 5, seed)[:height, :width])
    palette = np.array([(0.65, 0.08, 0.05), (0.04, 0.16, 0.36), (0.85, 0.50, 0.06), (0.05, 0.25, 0.18),
                        (0.02,) * 3])
    for k in range(12):
        x, y, r = random.random() * 0.9, random.random() * 1.25, 0.05 + 0.2 * random.random()
        disc = (u - x) ** 2 + (v - y) ** 2 < r * r
        bar = (np.abs(u - x) < r * 1.5) & (np.abs(v - y) < r * 0.12)
        shape = disc if k % 3 else bar
        colors = np.where(shape[..., None], 0.25 * colors + 0.75 * palette[k % 5], colors)
    return Texture(to_srgb(colors))


@functools.cache
def stained_glass(seed=10, size=256, cells=26):
    """Coloured Voronoi panes in black leading, for an emitter (does not repeat)."""
    random = np.random.default_rng(seed)
    u, v = pixel_grid(size, size)
    seeds = random.random((cells, 2))
    distance = np.hypot(u[..., None] - seeds[:, 0], v[..., None] - seeds[:, 1])
    order = np.sort(distance, axis=-1)
    pane = distance.argmin(axis=-1)
    hues = np.array([(1.0, 0.25, 0.08), (0.1, 0.35, 1.0), (1.0, 0.75, 0.15), (0.1, 0.8, 0.3),
                     (0.7, 0.12, 0.6)])
    colors = hues[pane % 5] * (0.5 + 0.5 * random.random(cells))[pane][..., None]
    return Texture(to_srgb(np.where((order[..., 1] - order[..., 0] < 0.02)[..., None], 0.0, colors)))


@functools.cache
def brushed(seed=11, size=256, low=0.15, high=0.45):
    """Roughness (g) and metallic (b) of brushed metal: streaks along u."""
    streaks = np.repeat(noise(size, 7, seed)[:, ::16], 16, axis=1)
    pixels = np.zeros((size, size, 3), np.uint8)
    pixels[..., 1] = ((low + (high - low) * streaks) * 255).astype(np.uint8)
    pixels[..., 2] = 255
    return Texture(pixels)


def normals_of(height, strength):
    """Tangent-space normal map of a periodic height field (H, W), v down; `strength`: texels a unit."""
    slope_u = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / 2 * strength
    slope_v = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) / 2 * strength
    normal = np.stack([-slope_u, slope_v, np.ones_like(height)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return Texture(((normal * 0.5 + 0.5) * 255 + 0.5).astype(np.uint8))


@functools.cache
def leaf(size=64):
    """A pointed leaf on a transparent ground, for alpha masking (RGBA; does not repeat)."""
    u, v = pixel_grid(size, size)
    inside = np.abs(u - 0.5) < 0.42 * np.sin(np.pi * v) ** 0.8
    vein = np.abs(u - 0.5) < 0.02
    pixels = np.zeros((size, size, 4), np.uint8)
    pixels[..., :3] = to_srgb(
        np.where(vein[..., None], (0.18, 0.3, 0.06), (0.05, 0.16, 0.03)) * np.ones((size, size, 1)))
    pixels[..., 3] = inside * 255
    return Texture(pixels)


def sky(sun_elevation, sun_azimuth, width=1024, sun_radiance=9000.0, haze=(1.0, 0.82, 0.6)):
    """Equirectangular radiance (W/2, W, 3) of a clear sky with a sun and thin clouds; angles in degrees.

    Azimuth 0 is -z, 90 is +x: u = 0.5 + azimuth / 360, as the renderer maps the environment. The sun's disc
    has a radius of 1.2 degrees (the real one, 0.27, is below a texel), and so a twentieth of its radiance.
    """
    height = width // 2
    u, v = pixel_grid(width, height)
    azimuth, polar = (u - 0.5) * 2 * np.pi, v * np.pi
    direction = np.stack([np.sin(polar) * np.sin(azimuth),
                          np.cos(polar), -np.sin(polar) * np.cos(azimuth)], -1)
    elevation, bearing = np.radians(sun_elevation), np.radians(sun_azimuth)
    to_sun = np.array(
        (np.cos(elevation) * np.sin(bearing), np.sin(elevation), -np.cos(elevation) * np.cos(bearing)))
    cosine = direction @ to_sun
    up = np.clip(direction[..., 1], 0, 1)
    radiance = mix((0.62, 0.72, 0.85), (0.10, 0.24, 0.62), up ** 0.5)
    glow = 0.6 * np.clip(cosine, 0, 1) ** 12 + 2.0 * np.clip(cosine, 0, 1) ** 200
    radiance += np.asarray(haze) * glow[..., None]
    clouds = np.clip(noise(width, 6, 12, start=2)[:height] * 2.6 - 1.25, 0, 1) * np.clip(up * 4, 0, 1)
    radiance = radiance * (1 - 0.6 * clouds[..., None]) + 0.75 * clouds[..., None]
    radiance = np.where((direction[..., 1] < 0)[..., None], (0.16, 0.14, 0.12), radiance)
    disc = cosine > np.cos(np.radians(1.2))
    return np.where(disc[..., None], np.asarray(haze) * sun_radiance, radiance)


def tile_relief(size=512, count=4, seed=13):
    """Height field of rounded tiles with joints and gentle waves, for `normals_of`."""
    u, v = pixel_grid(size, size)
    edge = np.minimum(np.abs((u * count + 0.5) % 1 - 0.5), np.abs((v * count + 0.5) % 1 - 0.5))
    return np.clip(edge / 0.03, 0, 1) + 0.6 * noise(size, 3, seed)
