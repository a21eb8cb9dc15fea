"""Finds the figures and the further evidence: adding one is adding one file and its claims.

A module ``figNN`` offers ``TITLE``, ``CAPTION``, ``data(quick=False)``, ``numbers(dataset)`` and
``draw(dataset)``. A module ``text_*`` offers the same without ``CAPTION`` and ``draw``: it judges
what the paper says without a picture. Figures that are made through a video are the rows of
`latolato.paper.chain_table`. The claims of all of them stand in ``claims.toml``.
"""

from __future__ import annotations

import importlib
import pkgutil
import re
from dataclasses import replace

import latolato.paper
from latolato.core.registry import suggest
from latolato.paper import chain_table
from latolato.paper.claim import FILE, Evidence, Statement, read_statements
from latolato.paper.finding import Finding

_MODULE = re.compile(r"fig\d\d\w*|text_\w+")
_RESULT = re.compile(r"strings_\w+")


def evidence() -> dict[str, Evidence]:
    """Return the figures in the paper's order and then what judges the text, by name.

    Raises
    ------
    ValueError
        If ``claims.toml`` holds claims of something that does not exist.
    """
    names = sorted([*_modules(_MODULE), *chain_table.FIGURES])
    statements = read_statements(FILE)
    for name in statements:
        if name not in names:
            raise ValueError(f"{FILE.name}: there is no figure '{name}', {suggest(name, names)}")
    return {name: _evidence(name, statements.get(name, ())) for name in names}


def figures() -> dict[str, Evidence]:
    """Return all that has a figure, by name, in the paper's order."""
    return {name: each for name, each in evidence().items() if each.draw}


def results() -> dict[str, Finding]:
    """Return the results beyond the paper, by name."""
    return {name: _result(name) for name in _modules(_RESULT)}


def title_of(name: str) -> str:
    """Return the title of a figure in the report.

    Examples
    --------
    >>> title_of("fig08"), title_of("fig08_chain")
    ('Figure 8', 'Figure 8 from a synthetic experiment')
    """
    number, _, way = name.removeprefix("fig").lstrip("0").partition("_")
    return f"Figure {number}" + (" from a synthetic experiment" if way == "chain" else "")


def _modules(pattern: re.Pattern[str]) -> list[str]:
    """Return the modules of this package whose whole name matches, sorted."""
    modules = (module.name for module in pkgutil.iter_modules(latolato.paper.__path__))
    return sorted(filter(pattern.fullmatch, modules))


def _result(name: str) -> Finding:
    """Return the result of a module of this package."""
    module = importlib.import_module(f"latolato.paper.{name}")
    return Finding(
        title=module.TITLE,
        caption=module.CAPTION,
        finding=module.FINDING,
        check=module.CHECK,
        data=module.data,
        numbers=module.numbers,
        draw=module.draw,
    )


def _evidence(name: str, statements: tuple[Statement, ...]) -> Evidence:
    """Return the evidence of a row of the table, or else of a module of this package."""
    if name in chain_table.FIGURES:
        return replace(chain_table.FIGURES[name], statements=statements)
    module = importlib.import_module(f"latolato.paper.{name}")
    return Evidence(
        title=module.TITLE,
        caption=getattr(module, "CAPTION", ""),
        statements=statements,
        data=module.data,
        numbers=module.numbers,
        draw=getattr(module, "draw", None),
    )
