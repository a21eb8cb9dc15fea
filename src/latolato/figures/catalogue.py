"""Finds the figures and the further evidence: adding one is adding one file.

A module ``figNN`` offers ``TITLE``, ``CAPTION``, ``data(quick=False)``, ``draw(dataset)``,
``STATEMENTS`` and ``numbers(dataset)``. A module ``text_*`` offers the same without ``CAPTION`` and
``draw``: it judges what the paper says without a picture. A module that makes its figure through a
video says ``NEEDS_VIDEO = True``; its ``data`` also takes ``full``, to film all that it can.
"""

from __future__ import annotations

import importlib
import pkgutil
import re
from typing import TYPE_CHECKING, Protocol, cast

from latolato.figures.claim import Claim, Numbers, Statement

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_FIGURE = re.compile(r"fig\d\d\w*")
_TEXT = re.compile(r"text_\w+")


class Evidence(Protocol):
    """What a module must offer to have its statements judged.

    Attributes
    ----------
    TITLE : str
        What it is about.
    STATEMENTS : tuple of Statement
        The claims that its numbers decide.
    """

    TITLE: str
    STATEMENTS: tuple[Statement, ...]

    def data(self, quick: bool = False, **more: bool) -> xr.Dataset:
        """Compute and return everything that is drawn and judged."""

    def numbers(self, dataset: xr.Dataset) -> Numbers:
        """Return the numbers that the statements name, in SI units."""


class Picture(Evidence, Protocol):
    """What a figure's module offers."""

    CAPTION: str

    def draw(self, dataset: xr.Dataset) -> Figure:
        """Return the figure drawn from `data`'s dataset."""


def figures() -> dict[str, Picture]:
    """Return the modules of all figures by name, in the paper's order."""
    return {name: cast(Picture, _module(name)) for name in _names(_FIGURE)}


def evidence() -> dict[str, Evidence]:
    """Return the figures and then the modules that judge the text, by name."""
    found: dict[str, Evidence] = dict(figures())
    found.update({name: cast(Evidence, _module(name)) for name in _names(_TEXT)})
    return found


def needs_video(module: Evidence) -> bool:
    """Return whether a figure goes through a video, which needs the extra `video`."""
    return bool(getattr(module, "NEEDS_VIDEO", False))


def title_of(name: str) -> str:
    """Return what a figure's module is called in the report.

    Examples
    --------
    >>> title_of("fig08"), title_of("fig08_chain")
    ('Figure 8', 'Figure 8 through the chain')
    """
    number, _, way = name.removeprefix("fig").lstrip("0").partition("_")
    return f"Figure {number}" + (" through the chain" if way == "chain" else "")


def judge(module: Evidence, dataset: xr.Dataset) -> list[Claim]:
    """Return the claims that a module's dataset decides."""
    numbers = module.numbers(dataset)
    return [statement.judge(numbers) for statement in module.STATEMENTS]


def _names(pattern: re.Pattern[str]) -> list[str]:
    """Return the names of this package's modules that match a pattern."""
    import latolato.figures

    found = [found.name for found in pkgutil.iter_modules(latolato.figures.__path__)]
    return sorted(name for name in found if pattern.fullmatch(name))


def _module(name: str) -> object:
    """Return an imported module of this package."""
    return importlib.import_module(f"latolato.figures.{name}")
