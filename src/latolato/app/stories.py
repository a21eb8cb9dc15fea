"""Guided stories and challenges: their files.

A file is TOML in ``static/stories``; `docs/how-to/stories.md` describes it. Pages get all files as
JSON, check them by ``schema.json`` beside them, and compute the numbers and scores (``js/story``).
"""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

from latolato.app import STATIC
from latolato.core.errors import InputError

FOLDER = STATIC / "stories"


def read(path: Path) -> dict[str, Any]:
    """Return the tables of a file as JSON knows them: pages say what is wrong with one.

    Raises
    ------
    InputError
        If the file is not TOML, or holds what JSON lacks, such as a date.
    """
    try:
        tables: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
        json.dumps(tables, allow_nan=False)
    except (ValueError, TypeError) as error:
        raise InputError(f"'{path}' is not a story in TOML: {error}") from None
    return tables


def contents(folder: Path = FOLDER) -> dict[str, dict[str, Any]]:
    """Return the tables of all files in a folder by their names."""
    return {path.stem: read(path) for path in sorted(folder.glob("*.toml"))}
