"""Scene files: those of embedded scenes, and what the harness must know of one before it plans runs."""

import functools
from dataclasses import dataclass
from pathlib import Path

from restirpg.harness import UserError
from restirpg.harness.jobs import Job


def file_of(name, folder):
    """The file `name`, or that of the embedded scene so called, written to `folder`; raises UserError."""
    from restirpg.scenes import SCENES

    if Path(name).is_file():
        return str(name)
    if name not in SCENES:
        raise UserError(f"{name}: neither a file nor an embedded scene; scripts/make_scenes.py --list names those")
    Path(folder).mkdir(parents=True, exist_ok=True)
    return str(SCENES[name]().write(Path(folder)))


@dataclass(frozen=True)
class Facts:
    """What a loaded scene says of itself."""

    hash: str  # of the file, of all that it refers to, and of the environment in place of its own
    bounce_cap: int | None  # what the scene's author asks for
    animation: tuple  # restirpg.Scene.animation_keys
    scene_hash: str = ""  # restirpg.Scene.hash, which a picture's header has: an environment in place is no part of it
    environment_hash: str = ""  # restirpg.Scene.environment_hash: of that environment's file

    def bounces(self, wanted=None):
        """`wanted`, or else the author's cap."""
        return self.bounce_cap if wanted is None else wanted

    def held_since(self, seconds):
        """The earliest time, s, from which on the animation stands until `seconds` as it does then.

        Times of one answer need one reference between them. Seen are pauses before and after all keys, and jumps
        between two (interpolation STEP).
        """
        since = 0.0
        for first, last, jump in self.animation:
            if seconds >= last:
                since = max(since, last)
            elif seconds > first and not jump:
                return seconds
        return since


def facts_of(hash, scene):
    """The Facts of a restirpg.Scene."""
    return Facts(hash, scene.bounce_cap, tuple(scene.animation_keys), scene.hash, scene.environment_hash)


@functools.lru_cache(maxsize=64)
def facts(pool, file, camera=0, environment=None, allow_outside=False):
    """The Facts of a scene file, which a worker of the pool loads; raises UserError."""
    if not Path(file).is_file():
        raise UserError(f"{file}: no such scene; scripts/make_scenes.py writes the embedded ones to out/scenes")
    question = Job(
        scene=file, scene_hash="", graph="", description="null", size=(), frames=0, seed=0, code="",
        camera=camera, environment=environment, allow_outside=allow_outside, label="scene",
    )  # fmt: skip
    ((_, failure, answer),) = pool.run([question], kind="scene")
    if failure:
        raise UserError(failure)
    return answer
