"""Progress on standard error: a bar with the time left on a terminal, now and then a line elsewhere."""

import sys
import time

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

SECONDS_BETWEEN_LINES = 20


class Display:
    """Counts work in pixels times frames; work found in the cache does not count for the speed."""

    def __init__(self, stream=sys.stderr):
        self._console = Console(file=stream, markup=False, emoji=False, highlight=False)
        self._bar = None
        self._total = self._done = 0.0
        self._started = self._printed = time.monotonic()

    def start(self, total, done="rendered"):
        """Begin a stretch of `total` work; `done`: what work that is behind us is."""
        self._word = done
        self._total, self._done, self._rendered = total, 0.0, 0.0
        self._started = self._printed = time.monotonic()
        if self._console.is_terminal:
            self._bar = Progress(
                TextColumn("{task.description}", markup=False),
                BarColumn(),
                TaskProgressColumn(),
                TimeElapsedColumn(),
                TextColumn("left"),
                TimeRemainingColumn(),
                console=self._console,
                transient=True,
                speed_estimate_period=120,
            )
            self._task = self._bar.add_task("", total=total)
            self._bar.start()

    def skip(self, work):
        """Some of the work need not be done."""
        self.extend(-work)

    def extend(self, work):
        """There is more work than start() was told."""
        self._total += work
        if self._bar:
            self._bar.update(self._task, total=max(self._total, 1e-9))

    def advance(self, work, description):
        """Some work was done, or (0) another step of it begins."""
        self._done += work
        if self._bar:
            self._bar.update(self._task, advance=work, description=description[-60:])
        elif time.monotonic() - self._printed > SECONDS_BETWEEN_LINES:
            self._printed = time.monotonic()
            left = ""
            total = max(self._total, self._done, 1e-9)
            if self._done > 0:
                seconds = (self._printed - self._started) * (total - self._done) / self._done
                left = f", {seconds / 60:.1f} min left"
            self.message(f"{100 * self._done / total:.0f}% {self._word}{left} ({description})")

    def message(self, text):
        """Print a line that stays."""
        self._console.print(text, soft_wrap=True)

    def stop(self):
        """End the stretch; the bar goes away."""
        if self._bar:
            self._bar.stop()
            self._bar = None
