"""Things that stand in rooms. Each function returns one Mesh, or a dict of meshes: one a material.

Everything stands on y = 0 about the y axis unless its docstring says otherwise; metres.
"""

import functools
import math

import numpy as np

from .implicit import capsule_chain, mesh_isosurface, revolved, smooth_union
from .shapes import (
    Mesh,
    bezier,
    copies,
    cylinder,
    icosphere,
    join,
    lathe,
    quad,
    rounded_box,
    surface,
    tube,
    unit,
)


def rounded_outline(points, passes=2):
    """Chaikin's corner cutting of an open outline (K, 2); its ends stay."""
    points = np.asarray(points, float)
    for _ in range(passes):
        cut = np.stack([0.75 * points[:-1] + 0.25 * points[1:], 0.25 * points[:-1] + 0.75 * points[1:]], 1)
        points = np.concatenate([points[:1], cut.reshape(-1, 2)[1:-1], points[-1:]])
    return points


@functools.cache
def teapot(cell=0.0044):
    """A solid teapot, one closed surface 0.38 m from spout (+x) to handle (-x). `cell`: resolution, m."""
    body = rounded_outline([(0, 0.002), (0.060, 0.002), (0.072, 0.004), (0.100, 0.042), (0.116, 0.085),
                            (0.100, 0.126), (0.066, 0.146), (0.056, 0.150), (0.058, 0.157), (0.040, 0.172),
                            (0.014, 0.178), (0.008, 0.186), (0.020, 0.196), (0.017, 0.210), (0, 0.213)])
    spout = bezier([(0.075, 0.055, 0), (0.165, 0.050, 0), (0.130, 0.140, 0), (0.195, 0.158, 0)], 14)
    spout_radii = np.linspace(0.030, 0.0115, 14)
    handle = bezier([(-0.075, 0.130, 0), (-0.225, 0.175, 0), (-0.205, 0.020, 0), (-0.085, 0.042, 0)], 18)

    def distance(p):
        d = smooth_union(revolved(p, body), capsule_chain(p, spout, spout_radii), 0.016)
        return smooth_union(d, capsule_chain(p, handle, np.full(18, 0.0095)), 0.010)

    return mesh_isosurface(distance, (-0.205, -0.006, -0.125), (0.215, 0.222, 0.125), cell)


def egg(height=0.12, segments=64):
    """A closed egg standing on its blunt end."""
    t = np.linspace(0, math.pi, 49)
    radius = 0.36 * height * np.sin(t) * (1 + 0.16 * np.cos(t))
    radius[[0, -1]] = 0.0
    return lathe(np.stack([radius, height / 2 * (1 - np.cos(t))], -1), segments, crease=180)


def vase(height=0.32, segments=64):
    """A turned vase with a narrow neck (thick-walled and closed)."""
    outside = rounded_outline(
        np.array([(0.0, 0), (0.16, 0), (0.18, 0.03), (0.34, 0.32), (0.30, 0.55), (0.11, 0.78), (0.10, 0.88),
                  (0.17, 1.0)]) * height)
    inside = rounded_outline(np.array([(0.155, 1.0), (0.085, 0.88), (0.095, 0.78), (0.27, 0.55), (0.30, 0.32),
                                       (0.0, 0.05)]) * height)
    return lathe(np.concatenate([outside, inside]), segments, crease=50)


def bowl(radius=0.15, segments=64):
    """A shallow bowl (closed)."""
    t = np.linspace(0.25, 1, 12)
    outside = np.stack([radius * t, radius * 0.45 * t ** 2.2], -1)
    inside = np.stack([radius * t * 0.96, radius * 0.45 * t ** 2.2 + 0.006], -1)[::-1]
    return lathe(np.concatenate([[(0, outside[0, 1])], outside, inside, [(0, inside[-1, 1])]]), segments)


def candlestick(height=0.16, candle=0.10):
    """Parts "metal" and "wax"."""
    stick = rounded_outline(
        np.array([(0, 0), (0.28, 0), (0.30, 0.05), (0.10, 0.10), (0.05, 0.25), (0.09, 0.40), (0.05, 0.55),
                  (0.07, 0.80), (0.16, 0.92), (0.16, 1.0), (0, 1.0)]) * height)
    wax = lathe([(0, 0), (0.011, 0), (0.0105, candle), (0.007, candle + 0.003), (0.0015, candle),
                 (0.001, candle + 0.012), (0, candle + 0.012)], 32)
    return {"metal": lathe(stick, 48), "wax": wax.moved(0, height, 0)}


def table(width, depth, height=0.72, top=0.035, leg=0.035):
    """Parts "top" and "legs": a slab with an apron on four turned legs."""
    x, z = width / 2, depth / 2
    slab = rounded_box((-x, height - top, -z), (x, height, z), 0.006, 2)
    inset, apron = 0.06, height - top - 0.09
    rails = [
        rounded_box((-x + inset, apron, s * (z - inset) - 0.01),
                    (x - inset, height - top, s * (z - inset) + 0.01)) for s in (-1, 1)
    ]
    rails += [
        rounded_box((s * (x - inset) - 0.01, apron, -z + inset),
                    (s * (x - inset) + 0.01, height - top, z - inset)) for s in (-1, 1)
    ]
    turned = rounded_outline(
        np.array([(0, 0), (0.5, 0), (0.7, 0.03), (0.5, 0.10), (0.75, 0.55), (0.95, 0.70), (0.6, 0.76),
                  (1.0, 0.82), (1.0, 1.0), (0, 1.0)]) * (leg, height - top - 0.001))
    places = [(sx * (x - inset), 0, sz * (z - inset)) for sx in (-1, 1) for sz in (-1, 1)]
    return {"top": slab, "legs": join(*rails, copies(lathe(turned, 32), places))}


def chair(seat=0.45):
    """A wooden chair facing +z: parts "wood" and "cushion"."""
    half = seat / 2
    wood = [rounded_box((-half, 0.42, -half), (half, 0.45, half), 0.008, 2)]
    wood += [
        tube([(s * 0.19, 0, z * 1.12), (s * 0.18, 0.43, z)], [0.013, 0.018]) for s in (-1, 1)
        for z in (-0.18, 0.18)
    ]
    wood += [
        tube(bezier([(s * 0.19, 0.43, -0.19), (s * 0.19, 0.7, -0.20), (s * 0.18, 0.93, -0.27)], 10), 0.014)
        for s in (-1, 1)
    ]
    for y, bow in ((0.86, 0.03), (0.72, 0.025), (0.58, 0.02)):
        z = -0.19 - 0.08 * max(0.0, (y - 0.55) / 0.38) ** 1.4
        wood.append(tube(bezier([(-0.185, y, z), (0, y, z - 2 * bow), (0.185, y, z)], 12), 0.013))
    return {"wood": join(*wood), "cushion": cushion(seat * 0.92, seat * 0.92, 0.05).moved(0, 0.449, 0)}


def cushion(width, depth, height):
    """A stuffed pillow lying on y = 0: a superellipsoid, closed."""
    def point(u, v):
        a, b = 2 * math.pi * u, math.pi * (v - 0.5)
        c = np.sign(np.cos(b)) * np.abs(np.cos(b)) ** 0.5
        x = np.sign(np.cos(a)) * np.abs(np.cos(a)) ** 0.35
        z = np.sign(np.sin(a)) * np.abs(np.sin(a)) ** 0.35
        return np.stack([width / 2 * c * x, height / 2 * (1 + np.sin(b)), -depth / 2 * c * z], -1)

    sheet = surface(lambda u, v: point(u, 0.02 + 0.96 * v), 64, 20, wrap_u=True)
    rims = [sheet.positions[:65], sheet.positions[-65:]]
    caps = [
        Mesh(np.concatenate([[rim.mean(axis=0)], rim]), np.tile((0.0, sign, 0.0), (66, 1)), np.zeros((66, 2)),
             np.array([(0, k, k + 1)[::sign] for k in range(1, 65)])) for rim, sign in zip(rims, (-1, 1))
    ]
    return join(sheet, *caps)


def door_leaf(width=0.9, height=2.05, thickness=0.042):
    """A panelled door in the plane z = 0, hinged at x = 0: "wood" and "metal" (levers, roses, hinges)."""
    z, stile, lock = thickness / 2, 0.11, 0.95
    rails = [(0.0, 0.2), (lock - 0.09, lock + 0.09), (height - 0.12, height)]
    wood = [rounded_box((x, 0, -z), (x + stile, height, z)) for x in (0, width - stile)]
    wood += [rounded_box((stile, low, -z), (width - stile, high, z)) for low, high in rails]
    middle = (width / 2 - 0.05, width / 2 + 0.05)
    wood += [
        rounded_box((middle[0], low[1], -z), (middle[1], high[0], z))
        for low, high in zip(rails[:-1], rails[1:])
    ]
    for low, high in zip(rails[:-1], rails[1:]):
        for left, right in ((stile, middle[0]), (middle[1], width - stile)):
            wood.append(rounded_box((left, low[1], -0.3 * z), (right, high[0], 0.3 * z), 0.001))
            wood.append(rounded_box((left + 0.035, low[1] + 0.035, -0.75 * z),
                                    (right - 0.035, high[0] - 0.035, 0.75 * z), 0.008))
    lever_x = width - 0.06
    metal = []
    for side in (-1, 1):
        rose = cylinder(0.026, 0.009, 32, 0.002).turned("x", 90 * side).moved(lever_x, lock, side * z)
        lever = tube(
            bezier([(lever_x, lock, side * z), (lever_x, lock, side * (z + 0.07)),
                    (lever_x - 0.02, lock, side * (z + 0.06)), (lever_x - 0.13, lock, side * (z + 0.055))],
                   16), 0.0095, 20)
        metal += [rose, lever]
    metal += [cylinder(0.008, 0.09, 16, 0.002).moved(-0.004, y, 0.0) for y in (0.22, 1.0, 1.78)]
    return {"wood": join(*wood), "metal": join(*metal)}


def door_frame(width, height, depth, casing=0.08):
    """Lining and architraves of a doorway of x in [0, width], centred on z = 0 in a wall `depth` thick."""
    z = depth / 2
    parts = []
    for side in (-1, 1):
        low, high = sorted((side * z, side * (z + 0.018)))
        parts += [
            rounded_box((-casing, 0, low), (0.002, height - 0.002, high), 0.005, 2),
            rounded_box((width - 0.002, 0, low), (width + casing, height - 0.002, high), 0.005, 2),
            rounded_box((-casing, height - 0.002, low), (width + casing, height + casing, high), 0.005, 2)
        ]
    parts += [rounded_box((-0.01, 0, -z), (0.012, height, z), 0.002),
              rounded_box((width - 0.012, 0, -z), (width + 0.01, height, z), 0.002),
              rounded_box((-0.01, height - 0.012, -z), (width + 0.01, height + 0.01, z), 0.002)]
    return join(*parts)


def picture(width, height, border=0.06, depth=0.03):
    """A framed picture facing +z about the origin: parts "canvas" (UVs 0..1) and "frame"."""
    x, y = width / 2, height / 2
    canvas = quad((-x, -y, 0.4 * depth), (width, 0, 0), (0, height, 0))
    parts = []
    for inset, front, girth in ((0.0, 1.0, 0.62), (0.58, 0.7, 0.42)):
        inner, outer = border * (1 - inset - girth), border * (1 - inset)
        for s in (-1, 1):
            low, high = sorted((s * (x + inner), s * (x + outer)))
            parts.append(rounded_box((low, -y - outer, 0), (high, y + outer, depth * front), 0.008, 2))
            low, high = sorted((s * (y + inner), s * (y + outer)))
            flush = depth * front * 0.999  # a hair behind the uprights, so that no faces coincide
            parts.append(rounded_box((-x - inner, low, 0), (x + inner, high, flush), 0.008, 2))
    return {"canvas": canvas, "frame": join(*parts)}


def books(width, seed, depth=0.16):
    """Upright books on y = 0 from x = 0 to `width`, spines towards +z: a list of meshes to colour in turn."""
    random = np.random.default_rng(seed)
    x, out = 0.0, []
    while True:
        thickness, height, book_depth = random.uniform((0.018, 0.19, depth * 0.8), (0.045, 0.27, depth))
        if x + thickness > width:
            return out
        out.append(
            rounded_box((x, 0, -depth / 2), (x + thickness - 0.001, height, -depth / 2 + book_depth), 0.004))
        x += thickness


def floor_lamp(height=1.55):
    """A standing lamp: parts "metal" (foot, pole) and "shade" (a thin closed cone)."""
    foot = lathe(
        rounded_outline([(0, 0), (0.14, 0), (0.145, 0.015), (0.03, 0.03), (0.012, 0.06),
                         (0.011, height - 0.08), (0, height - 0.08)], 1), 48)
    return {"metal": foot, "shade": lampshade(0.2, 0.13, 0.26).moved(0, height - 0.22, 0)}


def lampshade(lower_radius, upper_radius, height, wall=0.002):
    """An open truncated cone with a thin wall (a closed surface)."""
    outer = [(lower_radius, 0), (upper_radius, height)]
    profile = [*outer, (upper_radius - wall, height), (lower_radius - wall, 0), (lower_radius, 0)]
    return lathe(profile, 64)


def bulb(radius=0.03):
    """A round bulb about the origin."""
    return icosphere(radius, 3)


def plant(seed, leaves=60, spread=0.28, height=0.55):
    """Parts "stems" and "leaves" (quads for an alpha-masked leaf, UVs 0..1) growing from the origin."""
    random = np.random.default_rng(seed)
    stems, blades = [], []
    for _ in range(leaves):
        angle, reach = random.random() * 2 * math.pi, spread * (0.25 + 0.75 * random.random())
        top = height * (0.35 + 0.65 * random.random())
        out = np.array((math.cos(angle), 0, math.sin(angle)))
        tip = out * reach + (0, top, 0)
        stems.append(tube(bezier([(0, 0, 0), 0.2 * out * reach + (0, 0.8 * top, 0), tip], 8), 0.003, 6))
        length, width = 0.09 + 0.06 * random.random(), 0.045 + 0.02 * random.random()
        along = out * length * 0.8 + (0, -length * (0.6 * random.random() - 0.2), 0)
        across = np.array((-out[2], 0.3 * (random.random() - 0.5), out[0])) * width
        blades.append(quad(tip - across / 2 + along, across, -along))
    return {"stems": join(*stems), "leaves": join(*blades)}


def curtain(width, height, folds, depth=0.05, seed=1):
    """A hanging cloth in the plane z = 0 facing +z, from y = 0 up, x from 0 to `width`."""
    phase = np.random.default_rng(seed).random(3) * 2 * math.pi

    def point(u, v):
        wave = np.sin(2 * math.pi * folds * u + phase[0] + 0.5 * np.sin(3 * v + phase[1]))
        z = depth * (0.6 + 0.4 * (1 - v)) * (wave + 0.25 * np.sin(2 * math.pi * 2.3 * folds * u + phase[2]))
        return np.stack([width * u, height * v, z], -1)

    return surface(point, 24 * folds, 12)


def sofa(width=2.0, depth=0.9):
    """A sofa facing +z: parts "frame", "seat" (cushions) and "feet"."""
    half, arm = width / 2, 0.18
    frame = [rounded_box((-half, 0.10, -depth / 2), (half, 0.30, depth / 2), 0.03, 3),
             rounded_box((-half + arm, 0.28, -depth / 2), (half - arm, 0.82, -depth / 2 + 0.2), 0.06, 4)]
    frame += [
        rounded_box((x, 0.10, -depth / 2), (x + arm, 0.58, depth / 2), 0.06, 4) for x in (-half, half - arm)
    ]
    each = (width - 2 * arm) / 2
    seats = [cushion(each * 0.99, depth - 0.2, 0.2).moved(s * each / 2, 0.27, 0.1) for s in (-1, 1)]
    backs = [
        cushion(each * 0.96, 0.5, 0.2).turned("x", 74).moved(s * each / 2, 0.63, -depth / 2 + 0.20)
        for s in (-1, 1)
    ]
    feet = copies(cylinder(0.025, 0.1),
                  [(sx * (half - 0.1), 0, sz * (depth / 2 - 0.1)) for sx in (-1, 1) for sz in (-1, 1)])
    return {"frame": join(*frame), "seat": join(*seats, *backs), "feet": feet}


def shelf(width, height, boards, depth=0.28):
    """A bookcase with its back at z = 0 and its front at +z, and the heights of its boards' upper faces."""
    half, thick = width / 2, 0.025
    tops = [0.08 + (height - 0.08 - thick) * k / (boards - 1) + thick for k in range(boards)]
    parts = [rounded_box((x, 0, 0), (x + thick, height, depth)) for x in (-half, half - thick)]
    parts += [
        rounded_box((-half + thick, y - thick, 0.005), (half - thick, y, depth - 0.004), 0.002) for y in tops
    ]
    parts.append(rounded_box((-half + thick, 0.08, 0.0), (half - thick, height, 0.01), 0.001))
    return join(*parts), tops


def cup_lamp(radius, height, wall=0.004, segments=48):
    """A deep cup, open at the top, with a floor inside at 4 cm: the tube of an uplighter (closed surface)."""
    return lathe([(0, 0), (radius, 0), (radius, height), (radius - wall, height), (radius - wall, 0.04),
                  (0, 0.04)], segments)


def disc(radius, segments=32):
    """A flat disc facing +y."""
    angles = 2 * math.pi * np.arange(segments) / segments
    rim = np.stack([radius * np.cos(angles), np.zeros(segments), -radius * np.sin(angles)], -1)
    k = np.arange(segments)
    return Mesh(np.concatenate([[(0, 0, 0)], rim]), np.tile((0.0, 1.0, 0.0), (segments + 1, 1)),
                np.zeros((segments + 1, 2)),
                np.stack([np.zeros(segments, int), 1 + k, 1 + (k + 1) % segments], -1))


def trefoil_knot(size=0.075, radius=0.032):
    """A trefoil knot as one closed tube about the origin."""
    def center(u):
        a = 2 * math.pi * u
        x, y = np.sin(a) + 2 * np.sin(2 * a), np.cos(a) - 2 * np.cos(2 * a)
        return size * np.stack([x, y, -np.sin(3 * a)], -1)

    def point(u, v):
        tangent = unit(center(u + 1e-3) - center(u - 1e-3))
        x = unit(np.cross(tangent, (0.0, 0.0, 1.0)))
        y = np.cross(x, tangent)
        b = 2 * math.pi * v
        return center(u) + radius * (x * np.cos(b)[..., None] + y * np.sin(b)[..., None])

    return surface(point, 220, 24, wrap_u=True, wrap_v=True)
