"""What people see of analyses: a module each, with the picture ``draw`` and words, ``QUESTION``."""

from __future__ import annotations

import importlib
from typing import Any

from latolato.core.errors import InputError


def module_of(name: str) -> Any:
    """Return the module of the picture of an analysis.

    Raises
    ------
    InputError
        If it has none.
    """
    home = f"{__name__}.{name}"
    try:
        return importlib.import_module(home)
    except ModuleNotFoundError as error:
        if error.name != home:
            raise
        raise InputError(f"analysis '{name}' has no picture; its numbers can be stored") from None
