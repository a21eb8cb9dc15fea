"""Programs and sensors whose exports are recognised, and what their units are known to be."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from latolato.core.errors import Sentence, Word
from latolato.io.tables.rules import said

# Names of columns with their unit and where it is known from.
Units = Mapping[str, tuple[str, Sentence]]


@dataclass(frozen=True)
class Kind:
    """An export that is recognised.

    Attributes
    ----------
    name : str
        What it is called in the output of the importer.
    fits : callable
        Whether lines of the header, and the names of the columns, are those of this export.
    units : dict of str to str
        Units that the program always uses and does not write.
    """

    name: str
    fits: Callable[[str, set[str]], bool]
    units: dict[str, str] = field(default_factory=dict)


def _tracker(text: str, names: set[str]) -> bool:
    """Tracker: the first column is t, the others belong to point masses."""
    quantities = {"x", "y", "r", "vx", "vy", "v", "θ", "θr", "ω", "ax", "ay", "a", "theta"}
    # Above the names stand objects; an index of rows has no name in the line of the names.
    above = "\n".join(text.split("\n")[:-1])
    has_objects = re.search(r"^#multi|^[\t;,] *\S|^ \t\S|^\w+[ _][A-Z]\d*$", above, re.MULTILINE)
    return bool(has_objects) and "t" in names and bool(quantities & names)


KINDS = (
    Kind("Kinovea export", lambda text, names: "kinovea" in text.lower()),
    Kind("LabChart export", lambda text, names: "ChannelTitle=" in text),
    Kind("TrackMate export", lambda text, names: {"POSITION_X", "FRAME"} <= names),
    Kind("Vernier text", lambda text, names: text.lstrip().startswith("Vernier Format")),
    Kind(
        "Vernier table",
        lambda text, names: bool(re.search(r'(?:^|,|")(?:Latest|Data Set \d+): ?\w', text)),
    ),
    Kind("Capstone export", lambda text, names: bool(re.search(r"Run #\d", text))),
    Kind(
        "Sensor Logger recording",
        lambda text, names: {"time", "seconds_elapsed"} <= names,
        {"time": "ns", "seconds_elapsed": "s"},
    ),
    Kind(
        "phyphox export",
        lambda text, names: (
            "Time" in names
            and bool(re.search(r"(?:Gyroscope|Rotation|cceleration|Magnetic field) \w", text))
        ),
    ),
    Kind("AndroSensor recording", lambda text, names: "TIME SINCE START" in text.upper()),
    Kind("Tracker export", _tracker, {"t": "s", "x": "m", "y": "m"}),
)


def kind_of_file(header: Sequence[str], names: Sequence[str]) -> tuple[str, Units]:
    """The program that exported a file, "table" if it is not known, and the units that follow."""
    text = "\n".join(header)
    for kind in KINDS:
        if kind.fits(text, set(names)):
            source = said("unit_of_kind", kind=Word(kind.name))
            return kind.name, {name: (unit, source) for name, unit in kind.units.items()}
    return "table", {}
