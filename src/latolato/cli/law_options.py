"""The system and the drive that the options of a command name."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.core.errors import InputError

if TYPE_CHECKING:
    from latolato.physics.drives import Drive
    from latolato.physics.pendulum import System


def laws_of(
    values: Mapping[str, Any], scenario: str | None = None, *, missing: str
) -> tuple[System, Drive | str | None, Mapping[str, Any]]:
    """Return system, drive (None or "measured": as measured) and start that options name.

    Raises
    ------
    InputError
        With the text `missing` if neither options nor a scenario name a system.
    """
    from latolato.physics.pendulum import systems
    from latolato.scenario.options import changes
    from latolato.scenario.scenario import changed_tables, find
    from latolato.scenario.tables import drive_from, law_from

    is_measured = values.get("drive") == "measured"
    changed = changes({k: v for k, v in values.items() if not (k == "drive" and is_measured)})
    has_drive = "drive" in changed
    path = find(scenario) if scenario is not None else None
    if path is None and "kind" not in changed.get("system", {}):
        raise InputError(missing)
    tables = changed_tables(path, changed)
    system: System = law_from(tables["system"], systems, "system", Path())
    drive: Drive | str | None = "measured" if is_measured else None
    if has_drive:
        drive = drive_from(tables["drive"], system, Path())
    return system, drive, tables.get("run", {})
