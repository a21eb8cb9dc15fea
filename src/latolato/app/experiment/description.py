"""The description of a video or a table on a page: places and quantities with units, checked."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from latolato.app.forms import shown_option
from latolato.core.errors import InputError
from latolato.core.parameters import Parameter
from latolato.core.quantities import ANY, NON_NEGATIVE, POSITIVE, Quantity, Range
from latolato.core.registry import checked_choice, checked_count, suggest
from latolato.core.rules import broken_rule
from latolato.experiment.parameters import CAMERA, VIDEO_PARAMETERS
from latolato.experiment.sidecar import (
    OUTSIDE,
    Correction,
    Pivot,
    Place,
    checked_correction,
    checked_place,
    checked_region,
    checked_stick,
)
from latolato.scenario.options import law_options
from latolato.scenario.units import to_si

if TYPE_CHECKING:
    import xarray as xr

    from latolato.experiment.fits.registry import Apparatus

# Names that the fields share with the options of a run.
SHARED = ("length", "radius", "mass", "damping", "restitution", "gravity")
# Sizes that a page asks for beside these.
SIZES = ("stick_length", "patch")
# Nothing that hangs is longer [m].
LONGEST = 1000.0
# What only pages ask for.
LENGTH_SIGMA = Parameter(
    name="length_sigma",
    kind=float,
    description="standard deviation of the length; by default 1 mm, a mark of a ruler, or that of "
    "the scale where the length follows from it",
    quantity=Quantity("m", "", "uncertainty of the length", usual=0.001, first_unit="mm"),
    allowed=POSITIVE,
)
# What fits use of a table; of a video only frames of that part are tracked.
PART = ("start", "end")
# What only tables need: their time may be given by frames, and their pivot by two numbers.
TABLE_PARAMETERS = {
    name: Parameter(
        name=name, kind=float, description=description, quantity=Quantity(unit, "", label),
        allowed=allowed,
    )
    for name, unit, label, description, allowed in (
        ("frame_rate", "1", "frames per second", "frames of the camera per second", POSITIVE),
        ("pivot_x", "1", "x of the pivot", "in the coordinates and the unit of the file", ANY),
        ("pivot_y", "1", "y of the pivot", "in the coordinates and the unit of the file", ANY),
        ("start", "s", "fit from", "first instant of the table that fits use", ANY),
        ("end", "s", "fit up to", "last instant of the table that fits use", ANY),
    )
}  # fmt: skip
# Files that are made on request.
EXPORTS = ("track.nc", "overlay.mp4", "report.html")
EXAMPLES = ("decay", "driven", "toy")
# How names of tables end, and of files from which another program exports one: the reader of tables
# says how.
TABLE_ENDINGS = (
    ".csv", ".txt", ".tsv", ".dat", ".asc", ".gz", ".zip", ".xlsx", ".xls", ".ods", ".json", ".trk",
    ".nc", ".parquet", ".pdf",
)  # fmt: skip
_ROW_UNITS = [{"name": "us", "size": 1e-6}, {"name": "ms", "size": 1e-3}, {"name": "s", "size": 1}]


def _pivot(value: Any) -> Pivot:
    """Return a pivot's place [pixels], or that it is outside of the picture."""
    return OUTSIDE if value == OUTSIDE else checked_place("pivot", value)


def _balls(value: Any) -> tuple[Place, ...]:
    """Return the places of one ball or two [pixels]."""
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) > 2:
        raise InputError("must be one place or two", parameter="balls")
    return tuple(checked_place("balls", ball) for ball in value)


def _corrections(value: Any) -> tuple[Correction, ...]:
    """Return places that are set by hand."""
    if not isinstance(value, Sequence) or isinstance(value, str):
        raise InputError("must be a list", parameter="corrections")
    return tuple(checked_correction(one) for one in value)


def _text(value: Any) -> str:
    """Return a text."""
    if not isinstance(value, str):
        raise InputError("must be a text", parameter="section", value=value)
    return value


def _columns(value: Any) -> dict[str, str]:
    """Return the columns of a file by the names of those of the track table."""
    if not isinstance(value, Mapping) or not all(isinstance(each, str) for each in value.values()):
        raise InputError("must be an object of texts", parameter="columns")
    return dict(value)


def _choice(name: str, *choices: str) -> Callable[[Any], str]:
    """Return the check of a word that must be one of some."""
    return lambda value: checked_choice(name, value, choices)


# What a page gives besides quantities, each with its check. Frames count from the first of the
# video.
_CHECKS: dict[str, Callable[[Any], Any]] = {
    "pivot": _pivot,
    "balls": _balls,
    "is_proposed": bool,
    "is_pivot_found": bool,
    "stick": checked_stick,
    "region": checked_region,
    "shape": VIDEO_PARAMETERS["shape"].checked,
    **{
        name: partial(checked_count, name, allowed=NON_NEGATIVE)
        for name in ("click_frame", "first_frame", "last_frame")
    },
    "corrections": _corrections,
    "columns": _columns,
    "section": _text,
    "decimal": _choice("decimal", ".", ","),
    "angle_from": _choice("angle_from", "down", "right"),
    "y_axis": _choice("y_axis", "up", "down"),
}
# The description of a video or a table in SI units and pixels; what is not known is left out. The
# pivot of a table, `pivot_x` and `pivot_y`, is in the unit that the file has for places.
Description = dict[str, Any]


def described(value: Any) -> Description:
    """Return the description that a page sends.

    Raises
    ------
    InputError
        For unknown names, wrong types, units and values.
    """
    if not isinstance(value, Mapping):
        raise InputError("a description must be an object", value=value)
    checks = dict(_CHECKS)
    checks |= {name: partial(_number, one) for name, one in quantities().items()}
    for name in value:
        if name not in checks:
            raise InputError(f"unknown name '{name}': {suggest(str(name), list(checks))}")
    return {name: checks[name](given) for name, given in value.items() if given not in (None, "")}


def apparatus_of(description: Description, table: xr.Dataset) -> Apparatus:
    """The known parameters of the apparatus; a length that is not given is the table's."""
    from latolato.experiment.fits.registry import Apparatus

    own = {n: table.attrs[n] for n in ("length", "length_sigma") if n in table.attrs}
    given = {n: description[n] for n in (*SHARED, "length_sigma") if n in description}
    return Apparatus(**{**own, **given})


def part_of(description: Description) -> dict[str, Any]:
    """Return between which instants of a table fits use it [s], as far as these are given."""
    return {name: description[name] for name in PART if name in description}


def quantities() -> dict[str, Parameter]:
    """The quantities that a page asks for, with what they may be."""
    options = law_options()
    shared = {name: replace(options[name], suggested=None) for name in SHARED}
    camera = {parameter.name: parameter for parameter in CAMERA}
    sizes = {name: VIDEO_PARAMETERS[name] for name in SIZES}
    known = {**shared, **camera, **sizes, **TABLE_PARAMETERS, "length_sigma": LENGTH_SIGMA}
    # Laws know balls without a size, pictures do not.
    lengths = {name: one for name, one in known.items() if one.unit == "m"}
    allowed = Range(0.0, LONGEST, open_low=True)
    return known | {name: replace(one, allowed=allowed) for name, one in lengths.items()}


def _number(parameter: Parameter, value: Any) -> float:
    """Return a quantity in SI units.

    Raises
    ------
    InputError
        If it is no finite number with a unit that fits, or not what the quantity may be.
    """
    name = parameter.name
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise broken_rule("text_or_number", parameter=name, value=value)
    return float(parameter.checked(to_si(name, value, parameter.unit)))


def is_table(name: str) -> bool:
    """Return whether an upload of this name is read as a table and not as a video.

    Examples
    --------
    >>> is_table("swing.CSV"), is_table("swing.mp4")
    (True, False)
    """
    return name.lower().endswith(TABLE_ENDINGS)


def fields() -> dict[str, Any]:
    """Return how each quantity that a page asks for is shown, as in the registry of options."""
    entries = {name: shown_option(parameter) for name, parameter in quantities().items()}
    entries["row_time"]["units"] = _ROW_UNITS
    return entries


def fit_kinds() -> list[dict[str, Any]]:
    """Return the fits that a page offers, with their words."""
    from latolato.experiment.fits import fits

    return [
        {
            "kind": name,
            "title": kind.title,
            "headline": kind.headline,
            "hint": kind.hint,
            "is_slow": kind.is_slow,
            "fewest_balls": kind.fewest_balls,
        }
        for name, kind in fits.items()
        if kind.is_on_page
    ]
