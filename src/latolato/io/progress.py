"""How far work is: a bar on a screen, of a sweep with its pace, and some lines in a log."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from types import TracebackType
from typing import Any

from latolato.numerics.compiler import with_compiler

# A bar appears once work has taken this long [s].
_PATIENCE = 0.7
# Time between two lines where standard error is no screen [s].
_PAUSE = 60.0


@contextmanager
def bar(text: str) -> Iterator[Callable[[float], None] | None]:
    """Give a function that shows a bar on standard error, on a screen and for long work only."""
    if not sys.stderr.isatty():
        yield None
        return
    display: Any = None
    begun = time.perf_counter()

    def show(fraction: float) -> None:
        nonlocal display
        if display is None and time.perf_counter() - begun > _PATIENCE:
            from rich.console import Console
            from rich.progress import Progress

            display = Progress(console=Console(stderr=True), transient=True)
            display.add_task(text, total=1.0)
            display.start()
        if display is not None:
            display.update(display.task_ids[0], completed=fraction)

    try:
        yield show
    finally:
        if display is not None:
            display.stop()


@contextmanager
def working(text: str) -> Iterator[None]:
    """Show on a screen how long work has taken, and tell on standard error when it compiles.

    For work whose end nobody knows. Kernels compile on their first use, for seconds in which
    nothing else is heard of them.
    """
    display: Any = None
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        display = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            TimeElapsedColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        display.add_task(text, total=None)
    is_announced = False

    def tell() -> None:
        nonlocal is_announced
        if display is not None:
            display.update(display.task_ids[0], description=f"{text}, compiling")
        elif not is_announced:
            print(
                "latolato: compiling, once for each kind of motion and question (some 10 s)",
                file=sys.stderr, flush=True,
            )  # fmt: skip
        is_announced = True

    def done() -> None:
        if display is not None:
            display.update(display.task_ids[0], description=text)

    timer = threading.Timer(_PATIENCE, display.start) if display is not None else None
    if timer is not None:
        timer.start()
    try:
        with compiling(tell, done):
            yield
    finally:
        if timer is not None:
            timer.cancel()
            timer.join()
            display.stop()


@contextmanager
def compiling(begins: Callable[[], None], ends: Callable[[], None]) -> Iterator[None]:
    """Call one function when numba begins to compile a kernel, and one when it is compiled.

    Kernels that lie ready on disk count for nothing. The compiler is not imported for this.
    """
    depth = 0

    def listen() -> None:
        from numba.core import event

        class Watch(event.Listener):
            """Counts kernels within kernels: the outermost begins and ends."""

            def on_start(self, event: Any) -> None:
                """Report the outermost only."""
                nonlocal depth
                depth += 1
                if depth == 1:
                    begins()

            def on_end(self, event: Any) -> None:
                """Report the outermost only."""
                nonlocal depth
                depth -= 1
                if depth == 0:
                    ends()

        watch = Watch()
        event.register("numba:compile", watch)  # type: ignore[no-untyped-call]
        last.callback(event.unregister, "numba:compile", watch)

    with ExitStack() as last, with_compiler(listen):
        yield


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
        self._last_line = time.monotonic()
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
        elif now - self._last_line > _PAUSE and done < total:
            self._last_line = now
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
