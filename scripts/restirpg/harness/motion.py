"""What moves from frame to frame of a run, and where things stand at one of its frames."""

from dataclasses import dataclass

import numpy as np

TURN = 6  # frames of one turn of a camera that goes in a circle


@dataclass(frozen=True)
class Motion:
    """What moves from frame to frame.

    circle: radius, m, of the circle that the camera goes round in its own plane without turning, one step a
    frame, as long as the radius, TURN steps per turn: frames 2, 8, 14, 20, 26, 32 all stand where the scene's
    camera does. fps: frames per second of the scene's animation; 0: it stands.
    """

    circle: float = 0.0
    fps: float = 0.0

    def pose(self, frame):
        """What tells one frame's (counted from 1) view from another's: steps round the circle, time in s."""
        return (frame - 2) % TURN if self.circle else 0, (frame - 1) / self.fps if self.fps else 0.0

    def apply(self, renderer, home, frame):
        """Move camera and time to where they are at that frame; `home`: the scene's own camera."""
        step, seconds = self.pose(frame)
        if self.fps:
            renderer.set_time(seconds)
        if self.circle:
            forward = np.subtract(home["target"], home["position"])
            right = np.cross(forward, home["up"])
            up = np.cross(right, forward)
            angle = 2 * np.pi * step / TURN
            offset = self.circle * (
                np.sin(angle) * right / np.linalg.norm(right) + (1 - np.cos(angle)) * up / np.linalg.norm(up)
            )
            renderer.move_camera(position=home["position"] + offset, target=home["target"] + offset)
