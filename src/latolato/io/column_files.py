"""Columns with units in CSV and Parquet files, below the attributes of what they belong to."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from latolato.core.errors import InputError, import_extra, reading
from latolato.core.quantities import QUANTITIES, in_brackets
from latolato.core.rules import broken_rule
from latolato.io.tables.rules import broken, said

# Values and attributes of variables along one dimension.
Columns = dict[str, tuple[Any, dict[str, Any]]]
# An attribute of a text file, and its unit if it has one.
_ATTRIBUTE = re.compile(r"(?P<key>[^:\[]*?)(?: \[[^\]]*\])?:(?P<value>.*)")
# One column of a text file as its header describes it.
_COLUMN = re.compile(r"column (?P<name>\S+) \[(?P<units>[^\]]*)\]: (?P<long_name>.*)")

# So many rows are written together; as Python's own numbers they take four times the memory.
_ROWS = 20_000


def write_columns(columns: Columns, attributes: Mapping[str, Any], path: Path, suffix: str) -> None:
    """Write columns of equal length and attributes as the suffix says, ``.csv`` or ``.parquet``.

    A CSV begins with ``# key [unit]: value`` lines of the attributes and one
    ``# column name [unit]`` line for each column; a name may end in a unit of its own.
    """
    if suffix == ".csv":
        _write_csv(columns, attributes, path)
    else:
        _write_parquet(columns, attributes, path)


def read_columns(path: Path, suffix: str) -> tuple[Columns, dict[str, Any]]:
    """Return the columns and the attributes in a file that `write_columns` wrote.

    The values of a CSV are texts.

    Raises
    ------
    InputError
        For files of another kind, and for rows of unequal length.
        For Parquet, if the extra `parquet` is missing.
    """
    if suffix == ".parquet":
        return _read_parquet(path)
    with reading(path):
        try:
            return parse_columns(path.read_text(encoding="utf-8-sig"))
        except UnicodeDecodeError:
            raise broken("is_no_text", {"subject": said("this_file")}) from None


def parse_columns(text: str) -> tuple[Columns, dict[str, Any]]:
    """Return the columns, whose values are texts, and the attributes that a CSV holds.

    Lines that begin with ``#`` may stand anywhere, empty lines too.
    """
    attributes: dict[str, Any] = {}
    about: dict[str, dict[str, Any]] = {}
    body = []
    for line in text.splitlines():
        if not line.startswith("#"):
            body.append(line)
            continue
        column = _COLUMN.fullmatch(line[1:].strip())
        if column:
            about[column["name"]] = {"units": column["units"], "long_name": column["long_name"]}
        else:
            key, value = attribute_of(line[1:])
            attributes[key] = value
    rows = [row for row in csv.reader(body) if row]
    if not rows:
        raise broken_rule("columns")
    names = [name.strip() for name in rows[0]]
    for number, row in enumerate(rows[1:], start=1):
        if len(row) != len(names):
            sizes = {"row": number, "cells": len(row), "names": len(names)}
            raise broken_rule("cells_of_row", sizes)
    cells = zip(*rows[1:], strict=True) if rows[1:] else [()] * len(names)
    columns = {
        name: (list(values), about.get(name, {})) for name, values in zip(names, cells, strict=True)
    }
    return columns, attributes


def attribute_of(comment: str) -> tuple[str, Any]:
    """Return name and value of an attribute from a comment in a CSV's header.

    Examples
    --------
    >>> attribute_of(" gravity [m/s^2]: 9.81")
    ('gravity', 9.81)
    """
    match = _ATTRIBUTE.fullmatch(comment.strip())
    key, value = match.groups() if match else (comment, "")
    return key.strip(), _value(value.strip())


def import_pyarrow() -> Any:
    """Return pyarrow with its Parquet."""
    options = {"purpose": "a Parquet file", "way_out": "use .nc or .csv"}
    import_extra("pyarrow.parquet", "parquet", **options)
    return import_extra("pyarrow", "parquet", **options)


def _write_csv(columns: Columns, attributes: Mapping[str, Any], path: Path) -> None:
    """Write the columns below a header of ``# key [unit]: value`` lines."""
    with path.open("w", encoding="utf-8", newline="") as file:
        for key, value in attributes.items():
            file.write(f"# {_with_unit(key)}: {_text(value)}\n")
        for name, (_, about) in columns.items():
            head = name if name.endswith("]") else f"{name} [{about.get('units', '1')}]"
            file.write(f"# column {head}: {about.get('long_name', name)}\n")
        table = csv.writer(file, lineterminator="\n")
        table.writerow(columns)
        count = max((len(values) for values, _ in columns.values()), default=0)
        for first in range(0, count, _ROWS):
            part = [_plain(values[first : first + _ROWS]) for values, _ in columns.values()]
            table.writerows(zip(*part, strict=True))


def _with_unit(key: str) -> str:
    """Return the name of an attribute with the unit of its value, if it has one."""
    quantity = QUANTITIES.get(re.sub("^(right|left)_", "", key))
    return key if quantity is None else key + in_brackets(quantity.unit)


def _write_parquet(columns: Columns, attributes: Mapping[str, Any], path: Path) -> None:
    """Write the columns, their units with each field."""
    pyarrow = import_pyarrow()
    arrays = [pyarrow.array(values) for values, _ in columns.values()]
    schema = pyarrow.schema(
        [
            pyarrow.field(
                name,
                array.type,
                metadata={k: v for k, v in about.items() if isinstance(v, str)},
            )
            for (name, (_, about)), array in zip(columns.items(), arrays, strict=True)
        ],
        metadata={key: json.dumps(_plain(value)) for key, value in attributes.items()},
    )
    pyarrow.parquet.write_table(pyarrow.table(arrays, schema=schema), path)


def _read_parquet(path: Path) -> tuple[Columns, dict[str, Any]]:
    """Return the columns and the attributes of a Parquet file."""
    pyarrow = import_pyarrow()
    try:
        table = pyarrow.parquet.read_table(path)
    except pyarrow.ArrowInvalid as error:
        raise InputError(f"'{path}' is not a Parquet file: {error}") from None
    attributes = {
        key.decode(): _value(value.decode())
        for key, value in (table.schema.metadata or {}).items()
        if not key.startswith((b"ARROW:", b"pandas"))
    }
    columns: Columns = {}
    for name in table.column_names:
        metadata = table.schema.field(name).metadata or {}
        about = {key.decode(): value.decode() for key, value in metadata.items()}
        columns[name] = (table[name].to_numpy(), about)
    return columns, attributes


def _plain(value: Any) -> Any:
    """Return a value as JSON knows it."""
    return value.tolist() if hasattr(value, "tolist") else value


def _text(value: Any) -> str:
    """Return an attribute as a header line holds it; texts that look like others are quoted."""
    if not isinstance(value, str):
        return json.dumps(_plain(value))
    is_plain = value == value.strip() and value.isprintable() and _value(value) is value
    return value if is_plain else json.dumps(value)


def _value(text: str) -> Any:
    """Return an attribute from what `_text` wrote; a description in JSON stays the text it is."""
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return text
    return text if isinstance(value, dict) else value
