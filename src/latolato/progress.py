"""How far a sweep is: a bar with rate and remaining time on a screen, some lines in a log."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any

# Time between two lines where standard error is no screen [s].
_PAUSE = 60.0


class SweepProgress:
    """Shows a sweep's progress on standard error inside a ``with`` block; call it to update.

    Attributes
    ----------
    done, total : int
        Points.
    """

    def __init__(self) -> None:
        self.done = self.total = 0
        self._bar: Any = None
        self._told = time.monotonic()
        # Points and time that the rate counts from: compiling is over with the first chunk.
        self._from: tuple[int, float] | None = None
        self._updates = 0

    def __enter__(self) -> SweepProgress:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, done: int, total: int) -> None:
        """Show that `done` of `total` points are there."""
        now = time.monotonic()
        self.done, self.total = done, total
        if self._updates < 2:
            self._from = (done, now)
        self._updates += 1
        if sys.stderr.isatty():
            self._show(done, total)
        elif now - self._told > _PAUSE and done < total:
            self._told = now
            print(f"latolato: {done} of {total} points, {self.pace()}", file=sys.stderr, flush=True)

    def pace(self) -> str:
        """Return rate and remaining time in words."""
        done, begun = self._from or (0, 0.0)
        elapsed = time.monotonic() - begun
        if self.done <= done or elapsed <= 0.0:
            return "compiling" if self._updates < 2 else "no rate yet"
        rate = (self.done - done) / elapsed
        return f"{rate:.4g} points/s, {_span((self.total - self.done) / rate)} left"

    def _show(self, done: int, total: int) -> None:
        """Draw the bar."""
        if self._bar is None:
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

            self._bar = Progress(
                TextColumn("sweeping"),
                BarColumn(),
                MofNCompleteColumn(),
                TextColumn("{task.description}"),
                console=Console(stderr=True),
                transient=True,
            )
            self._bar.add_task("", total=total)
            self._bar.start()
        self._bar.update(self._bar.task_ids[0], completed=done, description=self.pace())


def _span(seconds: float) -> str:
    """Return a time in the largest fitting units, e.g. ``2 h 5 min``."""
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"
