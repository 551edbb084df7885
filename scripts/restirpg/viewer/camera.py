"""Moves of a camera: pure functions from pose to pose.

A pose is the dictionary that Renderer.camera gives: position and target (m), up, and yfov (radians).
"""

import json
import math

import numpy as np

_POLE = 0.01  # radians that an orbit keeps from the poles, where `up` spans no view
_SHORTEST = 1e-3  # m from the position to the target
_FOV = (math.radians(2), math.radians(150))


def _vectors(pose):
    return tuple(np.array(pose[name], float) for name in ("position", "target", "up"))


def of_scene(entry):
    """The pose of an entry of Renderer.scene_cameras()."""
    return {name: entry[name] for name in ("position", "target", "up", "yfov")}


def axes(pose):
    """Unit vectors (right, up, forward) of the view."""
    position, target, up = _vectors(pose)
    forward = target - position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return right, np.cross(right, forward), forward


def _with(pose, **changes):
    return {**pose, **{name: [float(x) for x in value] for name, value in changes.items()}}


def distance(pose):
    """From the position to the target, m."""
    return float(np.linalg.norm(np.subtract(pose["target"], pose["position"])))


def _turned(direction, up, azimuth, elevation):
    """`direction` turned about `up`, then towards it, staying off the poles."""
    up = up / np.linalg.norm(up)
    length = np.linalg.norm(direction)
    height = direction @ up / length
    across = direction - (direction @ up) * up
    across /= np.linalg.norm(across)
    across = math.cos(azimuth) * across + math.sin(azimuth) * np.cross(up, across)
    limit = math.pi / 2 - _POLE
    angle = min(limit, max(-limit, math.asin(min(1.0, max(-1.0, height))) + elevation))
    return length * (math.cos(angle) * across + math.sin(angle) * up)


def orbit(pose, azimuth, elevation):
    """Turn about the target: `azimuth` radians about the up direction, `elevation` towards it."""
    position, target, up = _vectors(pose)
    return _with(pose, position=target + _turned(position - target, up, azimuth, elevation))


def look(pose, azimuth, elevation):
    """Turn the head: the position stays."""
    position, target, up = _vectors(pose)
    return _with(pose, target=position + _turned(target - position, up, azimuth, elevation))


def pan(pose, right, up):
    """Shift the view by fractions of its height at the target's distance."""
    across, above, _ = axes(pose)
    height = 2 * distance(pose) * math.tan(pose["yfov"] / 2)
    shift = height * (right * across + up * above)
    position, target, _ = _vectors(pose)
    return _with(pose, position=position + shift, target=target + shift)


def dolly(pose, amount):
    """Go towards the target: its distance shrinks by the factor exp(amount)."""
    position, target, _ = _vectors(pose)
    length = max(_SHORTEST, distance(pose) * math.exp(-amount))
    return _with(pose, position=target - length * axes(pose)[2])


def fly(pose, right, up, forward):
    """Move by metres along the view's axes."""
    shift = np.array([right, up, forward], float) @ np.stack(axes(pose))
    position, target, _ = _vectors(pose)
    return _with(pose, position=position + shift, target=target + shift)


def zoom(pose, factor):
    """Another field of view: the picture's extent times `factor`."""
    return with_fov(pose, 2 * math.atan(math.tan(pose["yfov"] / 2) * factor))


def with_fov(pose, yfov):
    """The same view with a vertical field of view of `yfov` radians, or the nearest that is useful."""
    return {**pose, "yfov": min(_FOV[1], max(_FOV[0], yfov))}


def focus(pose, depth):
    """The same view with its target at `depth` m along the axis, so that it orbits about what it sees."""
    position, _, _ = _vectors(pose)
    return _with(pose, target=position + max(_SHORTEST, depth) * axes(pose)[2])


def same(one, other):
    """Whether two poses show the same picture: positions by 0.01 mm, wherever they are, and directions by 1e-5."""

    def numbers(pose):
        return np.concatenate([pose["position"], *axes(pose), [pose["yfov"]]])

    return bool(np.allclose(numbers(one), numbers(other), rtol=0, atol=1e-5))


def project(pose, aspect, points):
    """Where world points (n, 3) are in the picture: [[u, v]], fractions from its top left, None behind the camera.
    aspect: of the picture, width / height."""
    right, up, forward = axes(pose)
    x, y, depth = np.stack([right, up, forward]) @ (np.asarray(points, float) - pose["position"]).T
    extent = math.tan(pose["yfov"] / 2)
    return [
        [float(0.5 + a / (2 * d * extent * aspect)), float(0.5 - b / (2 * d * extent))] if d > 1e-6 else None
        for a, b, d in zip(x, y, depth)
    ]


def as_python(pose):
    """The call that puts a Renderer's camera there."""
    return f"renderer.move_camera({', '.join(f'{name}={value}' for name, value in pose.items())})"


def as_json(pose):
    """What Renderer.camera gives."""
    return json.dumps(pose)


def as_option(pose):
    """The option of `restirpg render` and `restirpg view`."""
    numbers = [*pose["position"], *pose["target"], *pose["up"], pose["yfov"]]
    return "--pose=" + ",".join(repr(float(x)) for x in numbers)


def from_option(text):
    """The pose of as_option's text; raises ValueError."""
    numbers = [float(part) for part in text.split(",")]
    if len(numbers) != 10 or not np.isfinite(numbers).all():
        raise ValueError(text)
    return {"position": numbers[:3], "target": numbers[3:6], "up": numbers[6:9], "yfov": numbers[9]}
