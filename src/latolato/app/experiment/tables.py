"""Tables that pages upload: what was recognised in them, and what they become."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.app.experiment.description import Description
from latolato.core.errors import InputError, reading
from latolato.core.registry import suggest
from latolato.experiment.importing import (
    import_table,
    is_track_file,
    parts_of,
    proposed_columns,
    unit_questions,
    units_of,
    usual_columns,
)
from latolato.experiment.track_table import balls_of, read_table
from latolato.io.tables.rules import broken as broken_table
from latolato.io.tables.source import Section, SourceColumn, read_source
from latolato.scenario.units import to_si

if TYPE_CHECKING:
    import xarray as xr

# What a column may be, as a page offers it: a column of the track table, or the numbers of frames.
FRAMES = "frame"
ROLES = (
    "time", FRAMES, "angle_1", "angle_2", "ball_1_x", "ball_1_y", "ball_2_x", "ball_2_y",
    "pivot_x", "pivot_y", "angular_velocity_1",
)  # fmt: skip
# Rows of a preview.
_ROWS = 5
# What importing takes beside the columns, as it is given.
_GIVEN = ("section", "decimal", "frame_rate", "length", "radius", "angle_from", "y_axis")


def roles() -> dict[str, list[str]]:
    """The roles of columns, each with the units that it may have in a file."""
    return {role: [] if role == FRAMES else units_of(role) for role in ROLES}


def look_at_table(job: Mapping[str, Any]) -> dict[str, Any]:
    """The sections and columns recognised in a table, ready for JSON.

    Returns
    -------
    dict
        As `SourceTable.to_dict`, with one section for each table that can be imported. Each has
        ``roles``, the positions of columns whose role follows from their names, and ``question``,
        what they leave open, or None. ``is_own`` says whether it is a track table of this package.

    Raises
    ------
    InputError
        If the file holds no table.
    """
    source = read_source(job["path"], decimal=job.get("decimal"))
    parts = parts_of(source)
    sections = tuple(replace(section, name=name) for name, section in parts.items())
    preview = replace(source, sections=sections).to_dict(_ROWS) | {"about": source.about}
    for shown, section in zip(preview["sections"], sections, strict=True):
        shown["roles"], shown["question"] = _proposal(section)
    return {"table": preview | {"is_own": is_track_file(Path(job["path"]))}}


def _proposal(section: Section) -> tuple[dict[str, int], str | None]:
    """Return the roles that follow from the names of columns, and the question that remains."""
    columns = proposed_columns(section)
    if "time" not in columns:
        frames = proposed_columns(section, has_rate=True)
        columns |= {FRAMES: frames["time"]} if "time" in frames else {}
    question = None
    try:
        usual_columns(section)
    except InputError as error:
        question = error.rule
    return {role: int(position) for role, position in columns.items()}, question


@dataclass(frozen=True, kw_only=True)
class Import:
    """What `import_table` gets for the choices of a page.

    Attributes
    ----------
    columns : dict of str to str
        By the names of the file where these are clear, with a unit where the file has none.
    arguments : dict
        What else it gets.
    is_in_pixels : bool
        Whether the pivot is in pixels.
    """

    columns: dict[str, str]
    arguments: dict[str, Any]
    is_in_pixels: bool


def import_of(path: Path, description: Description) -> Import:
    """The columns and arguments of `import_table` for a file and the choices of a page.

    Raises
    ------
    InputError
        For sections and columns that the file does not have.
    """
    with reading(path):
        parts = parts_of(read_source(path, decimal=description.get("decimal")))
        name = description.get("section") or next(iter(parts))
        if name not in parts:
            raise broken_table("no_section", {"name": name}, way_out=suggest(name, list(parts)))
        section = parts[name]
        chosen = description.get("columns", {})
        found = {target: section.column(text) for target, text in chosen.items()}
    arguments = {name: description[name] for name in _GIVEN if name in description}
    place = (description.get("pivot_x"), description.get("pivot_y"))
    unit = next((found[each][1] for each in ("ball_1_x", "ball_2_x") if each in found), "")
    if None not in place and unit == "px":
        arguments["pivot"] = list(place)
    elif None not in place and unit:
        arguments["pivot"] = [to_si("pivot", f"{number} {unit}", "m") for number in place]
    return Import(
        columns={target: _named(section, *each) for target, each in found.items()},
        arguments=arguments,
        is_in_pixels=unit == "px",
    )


def _named(section: Section, column: SourceColumn, unit: str) -> str:
    """Return how a column is named for `import_table`: by position if its name is not its own."""
    try:
        is_clear = section.column(column.path)[0] is column
    except InputError:
        is_clear = False
    name = column.path if is_clear else str(column.position)
    return f"{name} [{unit}]" if unit and unit != column.unit else name


def track_table_of(
    job: Mapping[str, Any], choices: Import | None
) -> tuple[xr.Dataset, list[str], list[str]]:
    """Return the track table that a page makes of an upload, what was assumed, and what is open.

    Without choices the upload is a track table itself.

    Raises
    ------
    InputError
        As `import_table` and `read_table`.
    """
    path = Path(job["path"])
    if choices is None:
        # Uploads have no suffix, by which formats are known.
        table = read_table(shutil.copyfile(path, path.with_name("own.csv")))
        names = [f"angle_{ball}" for ball in range(1, balls_of(table) + 1)]
        return table, [], unit_questions({name: table[name].values for name in names})
    notes: list[str] = []
    questions: list[str] = []
    table = import_table(
        path, choices.columns, notes=notes, questions=questions, **choices.arguments
    )
    table.attrs["source"] = job["name"]
    return table, notes, questions
