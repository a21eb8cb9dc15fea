"""What commands do with their results: write files, print a summary."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.io.progress import bar

if TYPE_CHECKING:
    import xarray as xr

    from latolato.simulation.record import Record

PICTURES = (".png", ".svg", ".pdf")


@dataclass(frozen=True)
class Targets:
    """The files that a command writes: its result, and a picture of it."""

    output: Path | None = None
    plot: Path | None = None

    def check(self, what: str, suffixes: tuple[str, ...] = (".nc",)) -> None:
        """Raise before any work if one of them cannot be written; `what` names the result."""
        from latolato.core.atomic import check_folder
        from latolato.io.files import check_suffix, check_target

        for path in (self.output, self.plot):
            if path is not None:
                check_folder(path)
        if self.output is not None:
            check_suffix(self.output, suffixes, what)
            check_target(self.output)
        if self.plot is not None:
            check_suffix(self.plot, PICTURES, "the name of a picture")

    def write(self, dataset: xr.Dataset, variable: str | None = None) -> list[Path]:
        """Write a dataset and its picture where the command names a file; return the names."""
        return self.save(dataset) + self.draw(dataset, variable)

    def save(self, dataset: xr.Dataset | Record) -> list[Path]:
        """Write the result if the command names a file; return the name."""
        if self.output is None:
            return []
        from latolato.io.files import save

        return [save(dataset, self.output)]

    def draw(self, dataset: xr.Dataset, variable: str | None = None) -> list[Path]:
        """Write the picture if the command names a file; return the name.

        Of a sweep it shows a variable, by default the first.
        """
        if self.plot is None:
            return []
        from latolato.figures.plot import plot
        from latolato.figures.style import save_figure

        return [save_figure(plot(dataset, variable), self.plot)]


@dataclass(frozen=True)
class Animation:
    """The animation that a command writes."""

    path: Path | None
    speed: float
    fps: float

    def check(self) -> None:
        """Raise before any work if it cannot be written."""
        if self.path is not None:
            from latolato.core.atomic import check_folder
            from latolato.figures.animate import check_target

            check_folder(self.path)
            check_target(self.path, self.speed, self.fps)

    def write(self, run: xr.Dataset) -> list[Path]:
        """Write it if the command names a file; return the name."""
        if self.path is None:
            return []
        from latolato.figures.animate import animate

        with bar("animating") as progress:
            return [animate(run, self.path, speed=self.speed, fps=self.fps, progress=progress)]


def elapsed_since(begun: float) -> float:
    """Return the wall time since an instant of `time.perf_counter`, in whole milliseconds [s]."""
    return round(time.perf_counter() - begun, 3)


def print_summary(summary: Mapping[str, Any], lines: Mapping[str, str], *, as_json: bool) -> None:
    """Print a summary as JSON, or lines of names and texts and the summary's ``files``."""
    if as_json:
        print(json.dumps(summary))
        return
    files = ", ".join(summary["files"]) or "nothing; name a file with --output"
    print(in_columns({**lines, "written": files}))


def in_columns(lines: Mapping[str, str]) -> str:
    """Return names and texts in two columns."""
    width = max(16, *map(len, lines))
    return "\n".join(f"{name:{width}} {text}" for name, text in lines.items())
