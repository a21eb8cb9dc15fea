"""Finds the module that draws an analysis or a fit: the one of its name."""

from __future__ import annotations

import importlib
from typing import Any

from latolato.core.errors import InputError

_FOLDERS = {"analysis": "analyses", "fit": "fits"}


def module_of(kind: str, name: str) -> Any:
    """Return the module of the picture of an analysis or a fit.

    Raises
    ------
    InputError
        If it has none.
    """
    home = f"latolato.figures.{_FOLDERS[kind]}.{name}"
    try:
        return importlib.import_module(home)
    except ModuleNotFoundError as error:
        if error.name != home:
            raise
        raise InputError(f"{kind} '{name}' has no picture; its numbers can be stored") from None
