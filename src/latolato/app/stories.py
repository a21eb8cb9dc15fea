"""Guided stories and challenges: their files.

A file is TOML in ``static/stories``; `docs/how-to/stories.md` describes it. `latolato site` checks
it by ``schema.json`` beside it. Pages get all files as JSON and compute the numbers and scores
(``js/story``).
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from latolato.app import STATIC
from latolato.app.forms import registry
from latolato.app.run_request import RunRequest
from latolato.core.errors import InputError
from latolato.core.registry import suggest
from latolato.scenario.units import to_si

FOLDER = STATIC / "stories"
# What files may hold. An entry is a type, the name of a table, or such in a list with the least and
# the most of them; one whose name ends in "?" may be left out.
SCHEMA: dict[str, Any] = json.loads((FOLDER / "schema.json").read_text(encoding="utf-8"))


def contents(folder: Path = FOLDER) -> dict[str, dict[str, Any]]:
    """Return the tables of all files in a folder by their names, in the order of the list."""
    tables = {path.stem: read(path) for path in sorted(folder.glob("*.toml"))}
    return dict(sorted(tables.items(), key=lambda item: item[1].get("order", math.inf)))


def checked_contents(folder: Path) -> dict[str, dict[str, Any]]:
    """Return the same for files that anybody may have written.

    Raises
    ------
    InputError
        With the first fault of a file and its place.
    """
    result = contents(folder)
    for name, tables in result.items():
        with _inside(f"{name}.toml"):
            check(tables)
    return result


def read(path: Path) -> dict[str, Any]:
    """Return the tables of a file as JSON knows them.

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


def check(tables: Mapping[str, Any]) -> None:
    """Raise an InputError with one sentence if something is wrong with the tables of a file."""
    number, newest = tables.get("format", 1), SCHEMA["format"]
    if type(number) is not int or not 1 <= number <= newest:
        raise InputError(f"it has format {number}, and this version reads {newest} at most")
    kind = tables.get("kind", "story")
    _check_value(kind, "kind", "kind")
    _check_table(tables, kind)


@contextmanager
def _inside(place: str) -> Iterator[None]:
    """Name a place of the file in errors that are raised meanwhile."""
    try:
        yield
    except InputError as error:
        error.where = ", ".join(filter(None, (place, error.where)))
        raise


def _check_table(table: Mapping[str, Any], kind: str) -> None:
    fields = {entry.rstrip("?"): value for entry, value in SCHEMA["tables"][kind].items()}
    for name in table:
        if name not in fields:
            raise InputError(f"there is no entry '{name}': {suggest(name, list(fields))}")
    for name, entry in fields.items():
        if name in table:
            _check_value(table[name], entry, name)
        elif name in SCHEMA["tables"][kind]:
            raise InputError(f"{name} is missing")
    if kind in _RULES:
        _RULES[kind](table)


def _check_value(value: Any, entry: Any, name: str) -> None:
    if isinstance(entry, list):
        part, least, most = entry
        if not isinstance(value, list):
            raise InputError(f"{name} must be a list")
        if not least <= len(value) <= most:
            raise InputError(f"{name} must be {least} to {most}, got {len(value)}")
        for number, each in enumerate(value, start=1):
            _check_value(each, part, f"{part} {number}")
    elif entry in SCHEMA["tables"]:
        if not isinstance(value, dict):
            raise InputError(f"{name} must be a table")
        with _inside(name):
            _check_table(value, entry)
    else:
        # All other types are written as texts.
        words, is_one = _TYPES.get(entry, _TYPES["text"])
        if not is_one(value):
            raise InputError(f"{name} must be {words}")
        known = _known().get(entry, [value])
        if value not in known:
            raise InputError(f"there is no {entry} '{value}': {suggest(value, list(known))}")
        if entry == "angle":
            to_si(name, value, "rad")


def _is_number(value: Any) -> bool:
    return type(value) in (int, float)


_TYPES: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "text": ("a text", lambda value: isinstance(value, str) and value.strip() != ""),
    "number": ("a number above zero", lambda value: _is_number(value) and value > 0),
    "whole": ("a whole number", lambda value: type(value) is int),
    "switch": ("true or false", lambda value: isinstance(value, bool)),
    "options": (
        "a table of options",
        lambda value: (
            isinstance(value, dict)
            and all(_is_number(part) or isinstance(part, (str, list)) for part in value.values())
        ),
    ),
    "extra": (
        'a table of texts with names such as "map.x"',
        lambda value: (
            isinstance(value, dict)
            and all("." in name and isinstance(part, str) for name, part in value.items())
        ),
    ),
}


def _known() -> dict[str, Any]:
    """Return the names that there are of each type."""
    shown = registry()
    return {
        "kind": SCHEMA["kinds"],
        "view": SCHEMA["views"],
        "preset": shown["scenarios"],
        "parameter": shown["options"],
        "quantity": SCHEMA["quantities"],
        "rule": SCHEMA["rules"],
    }


def _check_look(look: Mapping[str, Any]) -> None:
    RunRequest(look["preset"], look.get("options")).to_scenario()


def _check_predict(predict: Mapping[str, Any]) -> None:
    right = sum(choice.get("right", False) for choice in predict["choices"])
    if right != 1:
        raise InputError(f"one choice must be right, got {right}")


def _check_condition(condition: Mapping[str, Any]) -> None:
    subjects = [name for name in ("parameter", "quantity", "address") if name in condition]
    if len(subjects) != 1:
        raise InputError("name one of parameter, quantity, address")
    units = {
        "quantity": SCHEMA["quantities"],
        "parameter": {name: option["unit"] for name, option in registry()["options"].items()},
    }.get(subjects[0], {})
    for end in ("at_least", "at_most"):
        if end in condition and units:
            to_si(end, condition[end], units[condition[subjects[0]]])
    _check_angle(condition)


def _check_angle(table: Mapping[str, Any]) -> None:
    name = table.get("quantity", table.get("rule"))
    if name in SCHEMA["need_angle"] and "angle" not in table:
        raise InputError(f"angle is missing: {name} needs one")


def _check_task(task: Mapping[str, Any]) -> None:
    _check_angle(task)
    if task["rule"] == "guess_tongue" and "ratios" not in task:
        raise InputError("ratios is missing: guess_tongue needs them")
    to_si("par", task["par"], SCHEMA["rules"][task["rule"]])


_RULES: dict[str, Callable[[Mapping[str, Any]], None]] = {
    "look": _check_look,
    "predict": _check_predict,
    "condition": _check_condition,
    "number_shown": _check_angle,
    "task": _check_task,
}
