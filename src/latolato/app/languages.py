"""The languages of the pages: each that has a file."""

from __future__ import annotations

import json
from functools import lru_cache
from typing import Any

from latolato.app import STATIC
from latolato.core.errors import InputError
from latolato.core.language import Language

_FOLDER = STATIC / "languages"


def languages() -> dict[str, Any]:
    """Return what each language calls itself and whether it is unfinished, by its code."""
    found = {path.stem: json.loads(text_of(path.stem)) for path in sorted(_FOLDER.glob("*.json"))}
    return {
        code: {"name": table["name"], "beta": table.get("beta", False)}
        for code, table in found.items()
    }


def text_of(code: str) -> str:
    """Return the file of a language.

    Raises
    ------
    InputError
        If there is none of this code.
    """
    known = sorted(path.stem for path in _FOLDER.glob("*.json"))
    if code not in known:
        raise InputError(f"must be one of {', '.join(known)}", parameter="language", value=code)
    return (_FOLDER / f"{code}.json").read_text(encoding="utf-8")


@lru_cache(maxsize=4)
def language_of(code: str) -> Language:
    """Return the language in which results are presented on a page that speaks it."""
    table = json.loads(text_of(code))
    return Language(table["texts"], table.get("decimal", "."))
