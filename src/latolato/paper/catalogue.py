"""Finds the figures and the further evidence: adding one is adding one file and its claims.

A module ``figNN`` offers ``TITLE``, ``CAPTION``, ``data(quick=False)``, ``numbers(dataset)`` and
``draw(dataset)``. A module ``text_*`` offers the same without ``CAPTION`` and ``draw``: it judges
what the paper says without a picture. Figures that are made through a video are those in
``FILMED`` of the module ``about``. The claims of all of them stand in ``claims.toml``. The
functions take the package of the paper, by default that of the toy.
"""

from __future__ import annotations

import pkgutil
import re
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import ModuleType

import latolato.paper
from latolato.core.registry import suggest
from latolato.paper.claim import Evidence, read_statements
from latolato.paper.finding import Finding

_MODULE = re.compile(r"fig\d\d\w*|text_\w+")
_RESULT = re.compile(r"(strings|curves)_\w+")


def evidence(paper: ModuleType = latolato.paper) -> dict[str, Evidence]:
    """Return the figures in the paper's order and then what judges the text, by name.

    Raises
    ------
    ValueError
        If ``claims.toml`` holds claims of something that does not exist.
    """
    filmed = getattr(import_module(f"{paper.__name__}.about"), "FILMED", {})
    names = sorted([*_modules(paper, _MODULE), *filmed])
    path = claims_of(paper)
    statements = read_statements(path)
    for name in statements:
        if name not in names:
            raise ValueError(f"{path.name}: there is no figure '{name}', {suggest(name, names)}")
    found = {name: _evidence(paper, name) for name in names if name not in filmed} | filmed
    return {name: replace(found[name], statements=statements.get(name, ())) for name in names}


def claims_of(paper: ModuleType) -> Path:
    """Return the file with the claims of a paper."""
    return Path(str(paper.__file__)).with_name("claims.toml")


def figures(paper: ModuleType = latolato.paper) -> dict[str, Evidence]:
    """Return all that has a figure, by name, in the paper's order."""
    return {name: each for name, each in evidence(paper).items() if each.draw}


def results(paper: ModuleType = latolato.paper) -> dict[str, Finding]:
    """Return the results beyond the paper, by name."""
    return {name: _result(paper, name) for name in _modules(paper, _RESULT)}


def title_of(name: str) -> str:
    """Return the title of a figure in the report.

    Examples
    --------
    >>> title_of("fig08"), title_of("fig08_chain")
    ('Figure 8', 'Figure 8 from a synthetic experiment')
    """
    number, _, way = name.removeprefix("fig").lstrip("0").partition("_")
    return f"Figure {number}" + (" from a synthetic experiment" if way == "chain" else "")


def _modules(paper: ModuleType, pattern: re.Pattern[str]) -> list[str]:
    """Return the modules of a paper whose whole name matches, sorted."""
    modules = (module.name for module in pkgutil.iter_modules(paper.__path__))
    return sorted(filter(pattern.fullmatch, modules))


def _result(paper: ModuleType, name: str) -> Finding:
    """Return the result of a module of a paper."""
    module = import_module(f"{paper.__name__}.{name}")
    return Finding(
        title=module.TITLE,
        caption=module.CAPTION,
        finding=module.FINDING,
        check=module.CHECK,
        data=module.data,
        numbers=module.numbers,
        draw=module.draw,
    )


def _evidence(paper: ModuleType, name: str) -> Evidence:
    """Return the evidence of a module of a paper, without its claims."""
    module = import_module(f"{paper.__name__}.{name}")
    return Evidence(
        title=module.TITLE,
        caption=getattr(module, "CAPTION", ""),
        statements=(),
        data=module.data,
        numbers=module.numbers,
        draw=getattr(module, "draw", None),
    )
