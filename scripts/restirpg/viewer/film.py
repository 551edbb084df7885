"""A film: pictures of the next frames of every graph in view, numbered, in a folder of its own below the capture
folder."""

import time
from pathlib import Path

from restirpg.harness import UserError, files

from . import capture

KINDS = ("png", "exr")
MOST_FRAMES = 100_000


class Film:
    """captures: the folder that the viewer was given. count: frames. kind: "png", as shown, or "exr", see capture.save."""

    def __init__(self, captures, session, count, kind):
        if captures is None:
            raise UserError("there is no folder for films; name one with --captures")
        if kind not in KINDS:
            raise UserError(f"a film is of {' or '.join(KINDS)} files, not of {kind!r}")
        if not (isinstance(count, int) and not isinstance(count, bool) and 1 <= count <= MOST_FRAMES):
            raise UserError(f"{count!r} is no number of frames from 1 to {MOST_FRAMES}")
        self.count, self.done, self._kind, self._session = count, 0, kind, session
        stamp = time.strftime("film_%Y%m%d_%H%M%S")
        self.folder = next(
            folder for i in range(1000) if not (folder := Path(captures) / (stamp + (f"_{i}" if i else ""))).exists()
        )

    def add(self):
        """Write the frame that every graph has just rendered. Raises UserError where that cannot be."""
        self.done += 1
        for number, pane in enumerate(self._session.panes):
            file = self.folder / f"{number + 1}_{capture.stem_of(pane)}" / f"{self.done:05}.{self._kind}"
            try:
                file.parent.mkdir(parents=True, exist_ok=True)
                if self._kind == "png":
                    files.write(file, capture.png(self._session, pane))
                else:
                    capture.save(self._session, pane, file)
            except OSError as error:
                raise UserError(f"{file}: cannot write: {error.strerror}") from None

    @property
    def ended(self):
        """Whether all frames are written."""
        return self.done >= self.count

    def told(self):
        """What the page shows of it."""
        return {"done": self.done, "count": self.count}
