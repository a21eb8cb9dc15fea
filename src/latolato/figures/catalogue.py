"""Finds the figures and the further evidence: adding one is adding one file and its claims.

A module ``figNN`` offers ``TITLE``, ``CAPTION``, ``data(quick=False)``, ``numbers(dataset)`` and
``draw(dataset)``. A module ``text_*`` offers the same without ``CAPTION`` and ``draw``: it judges
what the paper says without a picture. Figures that are made through a video are the rows of
`latolato.figures.chain_table`. The claims of all of them stand in ``claims.toml``.
"""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from latolato.core.registry import suggest
from latolato.figures.claim import FILE, Claim, Numbers, Statement, read_statements

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_MODULE = re.compile(r"fig\d\d\w*|text_\w+")


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """A figure, or a set of runs without one, and the claims that it decides.

    Attributes
    ----------
    title : str
        What it is about.
    data : callable
        ``data(quick=False)`` computes everything that is drawn and judged. With `needs_video` it
        also takes ``full``, to film all that it can.
    numbers : callable
        Returns the numbers that the statements name, in SI units, from the dataset.
    statements : tuple of Statement
        The claims that the numbers decide.
    caption : str
        Of the figure; empty without one.
    draw : callable, optional
        Returns the figure drawn from the dataset.
    needs_video : bool
        It goes through a video, which needs the extra `video`.
    """

    title: str
    data: Callable[..., xr.Dataset]
    numbers: Callable[[xr.Dataset], Numbers]
    statements: tuple[Statement, ...] = ()
    caption: str = ""
    draw: Callable[[xr.Dataset], Figure] | None = None
    needs_video: bool = False

    def judge(self, dataset: xr.Dataset) -> list[Claim]:
        """Return the claims that a dataset decides."""
        numbers = self.numbers(dataset)
        return [statement.judge(numbers) for statement in self.statements]


def evidence() -> dict[str, Evidence]:
    """Return the figures in the paper's order and then what judges the text, by name.

    Raises
    ------
    ValueError
        If ``claims.toml`` holds claims of something that does not exist.
    """
    import latolato.figures
    from latolato.figures import chain_table

    modules = [module.name for module in pkgutil.iter_modules(latolato.figures.__path__)]
    names = sorted([*filter(_MODULE.fullmatch, modules), *chain_table.FIGURES])
    statements = read_statements(FILE)
    for name in statements:
        if name not in names:
            raise ValueError(f"{FILE.name}: there is no figure '{name}', {suggest(name, names)}")
    return {name: _evidence(name, statements.get(name, ())) for name in names}


def figures() -> dict[str, Evidence]:
    """Return all that has a figure, by name, in the paper's order."""
    return {name: each for name, each in evidence().items() if each.draw}


def title_of(name: str) -> str:
    """Return what a figure is called in the report.

    Examples
    --------
    >>> title_of("fig08"), title_of("fig08_chain")
    ('Figure 8', 'Figure 8 through the chain')
    """
    number, _, way = name.removeprefix("fig").lstrip("0").partition("_")
    return f"Figure {number}" + (" through the chain" if way == "chain" else "")


def _evidence(name: str, statements: tuple[Statement, ...]) -> Evidence:
    """Return the evidence of a row of the table, or else of a module of this package."""
    from latolato.figures import chain_table

    if name in chain_table.FIGURES:
        row = chain_table.FIGURES[name]
        return Evidence(
            title=row.title,
            caption=row.caption,
            statements=statements,
            data=row.data,
            numbers=row.numbers,
            draw=row.draw,
            needs_video=True,
        )
    module = importlib.import_module(f"latolato.figures.{name}")
    return Evidence(
        title=module.TITLE,
        caption=getattr(module, "CAPTION", ""),
        statements=statements,
        data=module.data,
        numbers=module.numbers,
        draw=getattr(module, "draw", None),
    )
