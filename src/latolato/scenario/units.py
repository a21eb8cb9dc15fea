"""Quantities as people write them, such as "24.5 cm", "20 deg" or "1.6 Hz", become SI numbers.

Used at the edges only: scenario files, the command line and forms. Here the angle is a dimension
of its own and a hertz is one turn per second, so "1.6 Hz" is 10.053 rad/s for an angular
frequency and "1.6 /s" is refused instead of being guessed.
"""

from __future__ import annotations

import re
import tokenize
from collections.abc import Sequence
from decimal import Decimal
from functools import lru_cache
from pathlib import Path
from typing import Any

from latolato.core.errors import InputError
from latolato.core.registry import no_quantity, suggest
from latolato.core.rules import broken_rule, sentence
from latolato.io.shown_units import name_and_unit

_PI = "3.1415926535897932384626433833"

# What the toy is measured in; pint reads these 50 times faster than its own list of 900 units.
_DEFINITIONS = (
    "nano- = 1e-9 = n-",
    "micro- = 1e-6 = µ- = μ- = u-",
    "milli- = 1e-3 = m-",
    "centi- = 1e-2 = c-",
    "deci- = 1e-1 = d-",
    "kilo- = 1e3 = k-",
    "mega- = 1e6 = M-",
    "meter = [length] = m = metre",
    "second = [time] = s = sec",
    "gram = [mass] = g",
    "radian = [angle] = rad",
    "inch = 0.0254 * meter = in",
    "foot = 0.3048 * meter = ft",
    "pound = 453.59237 * gram = lb",
    "ounce = 28.349523125 * gram = oz",
    "minute = 60 * second = min",
    "hour = 3600 * second = h",
    f"degree = {_PI} / 180 * radian = deg = °",
    f"turn = 2 * {_PI} * radian = rev = revolution = cycle",
    "hertz = turn / second = Hz",
    "rpm = turn / minute",
    "newton = kilogram * meter / second ** 2 = N",
    "joule = newton * meter = J",
    "watt = joule / second = W",
    "standard_gravity = 9.80665 * meter / second ** 2 = g_0 = gn",
    "percent = 0.01 = %",
    "pixel = [pixel]",
)

# The commonest conversions, as pint does them: importing it takes longer than a run.
_TURN = 2 * Decimal(_PI)
_COMMON = {
    ("mm", "m"): Decimal("1e-3"),
    ("cm", "m"): Decimal("1e-2"),
    ("g", "kg"): Decimal("1e-3"),
    ("ms", "s"): Decimal("1e-3"),
    ("min", "s"): Decimal(60),
    ("deg", "rad"): _TURN / 360,
    ("°", "rad"): _TURN / 360,
    ("deg/s", "rad/s"): _TURN / 360,
    ("Hz", "rad/s"): _TURN,
}

_TEXT = re.compile(
    r"\s*(?P<number>[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|nan|inf(?:inity)?))"
    r"\s*(?P<unit>(?:1/)?[a-zA-Zµμ°%/(][\w µμ°%/*^().+\-²³ᐟ·]*)?\s*",
    re.IGNORECASE,
)


# Powers and products as pages and pictures write them.
_SHOWN = {"³ᐟ²": "^(3/2)", "²": "^2", "³": "^3", "·": "*"}


@lru_cache(maxsize=1)
def _registry() -> Any:
    """Return the unit registry; decimal numbers keep 24.5 cm equal to 0.245 m to the last bit."""
    import pint

    registry: Any = pint.UnitRegistry(None, non_int_type=Decimal)
    registry.load_definitions(_DEFINITIONS)
    return registry


def unit_table() -> dict[str, Any]:
    """Return all units and prefixes as plain values, for pages that read quantities themselves.

    A unit has its size in SI units and the powers of these, such as
    ``"N": [1.0, {"kg": 1, "m": 1, "s": -2}]``.
    """
    registry = _registry()
    bases = {"meter": "m", "second": "s", "gram": "kg", "radian": "rad", "pixel": "pixel"}
    units: dict[str, Any] = {}
    for name in registry._units:
        quantity = registry.Quantity(Decimal(1), registry.parse_units(name)).to_base_units()
        powers = {bases[base]: int(power) for base, power in quantity._units.items()}
        size = quantity.magnitude * Decimal("1e-3") ** powers.get("kg", 0)
        units[name] = [float(size), powers]
    prefixes = {name: float(each.value) for name, each in registry._prefixes.items() if name}
    return {"units": units, "prefixes": prefixes}


def to_si(name: str, value: Any, unit: str) -> Any:
    """Return a quantity as a number in its SI unit; what is not text is returned as it is.

    Parameters
    ----------
    name : str
        What the quantity is called in messages.
    value : str or number
        A number with or without a unit; without one it is in SI units.
    unit : str
        The SI unit as in `latolato.core.quantities`, e.g. ``"kg*m/s"``.

    Raises
    ------
    InputError
        If the text is no quantity, or its unit does not convert to `unit`.

    Examples
    --------
    >>> to_si("length", "24.5 cm", "m")
    0.245
    >>> round(to_si("drive_frequency", "1.6 Hz", "rad/s"), 3)
    10.053
    """
    if not isinstance(value, str):
        return value
    # A byte order mark within a text is a space that nobody sees.
    text = value.replace("\N{MINUS SIGN}", "-").replace("\ufeff", " ")
    match = _TEXT.fullmatch(text)
    if match is None:
        raise _refusal(name, value, "", unit)
    number, written = float(match["number"]), (match["unit"] or "").strip()
    plain = _plain_unit(written)
    if plain.replace(" ", "*") in ("", unit):
        return number
    if (written, unit) in _COMMON:
        return float(Decimal(match["number"]) * _COMMON[written, unit])
    import pint

    registry = _registry()
    try:
        source = registry.parse_units(plain)
        target = registry.parse_units("" if unit == "1" else unit)
        return float(registry.Quantity(Decimal(match["number"]), source).to(target).magnitude)
    except (
        pint.PintError,
        ArithmeticError,
        AssertionError,
        AttributeError,
        TypeError,
        ValueError,
        tokenize.TokenError,  # of Python 3.12 and later, for brackets that do not match
    ):
        raise _refusal(name, value, written, unit) from None


def _plain_unit(written: str) -> str:
    """Return a unit in the letters of SI units such as "m/s^2".

    Examples
    --------
    >>> _plain_unit("kg·m/s²")
    'kg*m/s^2'
    """
    for shown, plain in _SHOWN.items():
        written = written.replace(shown, plain)
    return written


def _refusal(name: str, value: str, written: str, unit: str) -> InputError:
    """Return the error for a text that is no such quantity, with another unit that is meant."""
    meant = _in_other_letters(written, unit) if written and unit != "1" else None
    way_out = None if meant is None else sentence("meant", name=meant)
    return no_quantity(name, value, unit, way_out)


def _in_other_letters(written: str, unit: str) -> str | None:
    """Return the unit that differs in capitals only and converts to `unit`, None if there is none.

    Examples
    --------
    >>> _in_other_letters("hz", "rad/s")
    'Hz'
    """
    registry = _registry()
    target = registry.parse_units(unit)
    for name in registry._units:
        for prefix in ("", *filter(None, registry._prefixes)):
            meant = f"{prefix}{name}"
            if meant.lower() == written.lower() and registry.parse_units(meant).is_compatible_with(
                target
            ):
                return meant
    return None


def to_si_list(name: str, value: Any, unit: str, folder: Path | None = None) -> Any:
    """Return several quantities as a list of numbers in their SI unit.

    Parameters
    ----------
    name : str
        What the quantities are called in messages.
    value : str or sequence
        Quantities, a text with commas between them, or the name of a text file that holds numbers
        in SI units: ``"times.txt"``, or ``"pivot.csv:height"`` for one column of a table, which
        may be headed ``height [mm]``.
    unit : str
        The SI unit.
    folder : Path, optional
        Where relative file names begin; by default the working directory.

    Raises
    ------
    InputError
        If a part is no such quantity, if only some parts of a text carry a unit, or if the file
        cannot be read as numbers.

    Examples
    --------
    >>> to_si_list("times", "0 s, 250 ms, 0.5 min", "s")
    [0.0, 0.25, 30.0]
    """
    if not isinstance(value, str):
        if isinstance(value, Sequence):
            return [to_si(f"{name}[{i}]", part, unit) for i, part in enumerate(value)]
        return value
    if "," in value:
        parts = [part.strip() for part in value.strip().rstrip(",").split(",")]
        plain = [_plain_number(part) for part in parts]
        if None in plain and any(plain):  # a 0 needs no unit
            raise broken_rule("units_of_list", parameter=name, value=value)
        return [to_si(name, part, unit) for part in parts]
    path, column = _file_and_column(value, folder or Path())
    if path.is_file():
        return _read_column(name, path, column, unit)
    try:
        return [to_si(name, value, unit)]
    except InputError as error:
        parts = value.split()
        are_numbers = len(parts) > 1 and None not in map(_plain_number, parts)
        error.add_way_out(
            "put commas between the values"
            if are_numbers
            else "there is no file of that name either"
        )
        raise


def _plain_number(text: str) -> float | None:
    """Return a number that is written without a unit, else None."""
    try:
        return float(text)
    except ValueError:
        return None


def _file_and_column(text: str, folder: Path) -> tuple[Path, str]:
    """Return the file and the column that ``"file:column"`` names; the column may be empty."""
    whole = folder / text
    if whole.is_file() or ":" not in text:
        return whole, ""
    file, _, column = text.rpartition(":")
    return folder / file, column


def _read_column(name: str, path: Path, column: str, unit: str) -> list[float]:
    """Return one column of a text table in SI units, read in the unit of its title if it has one.

    ``#`` begins a comment, a header line may come first.
    """
    import numpy as np

    try:
        with path.open(encoding="utf-8-sig") as lines:
            first = next((line for line in lines if line.strip() and line.lstrip()[0] != "#"), "")
    except UnicodeDecodeError:
        raise InputError(
            f"{{parameter}}: '{path}' is not a text file",
            parameter=name,
            way_out="save it as UTF-8 text",
        ) from None
    if not first:
        raise InputError(f"{{parameter}}: '{path}' holds no numbers", parameter=name)
    delimiter = next((d for d in ",;\t" if d in first), None)
    titles = [title.strip() for title in first.split(delimiter)]
    has_header = any(_TEXT.fullmatch(title) is None for title in titles)
    if not column and len(titles) > 1:
        raise InputError(
            f"{{parameter}}: '{path}' has {len(titles)} columns",
            parameter=name,
            way_out=f"name one, as in {path.name}:{titles[0]}",
        )
    plain = [name_and_unit(title)[0] for title in titles]
    known = [*([*titles, *plain] if has_header else []), *(str(i + 1) for i in range(len(titles)))]
    if column and column not in known:
        raise InputError(
            f"{{parameter}}: '{path}' has no column '{column}': "
            f"{suggest(column, [*dict.fromkeys(known)])}",
            parameter=name,
        )
    index = known.index(column) % len(titles) if column else 0
    try:
        with path.open(encoding="utf-8-sig") as lines:
            body = (line for line in lines if not (has_header and line == first))
            numbers = np.loadtxt(body, delimiter=delimiter, usecols=index, ndmin=1)
    except ValueError as error:
        raise InputError(
            f"{{parameter}}: '{path}' cannot be read as numbers: {error}", parameter=name
        ) from None
    written = name_and_unit(titles[index])[1]
    try:
        factor = float(to_si(name, f"1 {written}", unit)) if written else 1.0
    except InputError as error:
        error.where = f"column '{titles[index]}' of '{path}'"
        raise
    result: list[float] = (numbers * factor).tolist()
    return result
