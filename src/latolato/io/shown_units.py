"""Numbers in the units in which people read them, as decimal texts that keep every bit."""

from __future__ import annotations

from collections.abc import Iterable
from decimal import Context, Decimal

# More digits than a float and its unit need together.
_DECIMALS = Context(prec=60)
_DEGREE = Decimal("0.0174532925199432957692369076848861271344287188854172545609719")  # pi/180
# Longer numbers are written with a power of ten.
_LONGEST = 26
# SI units in one of these; others are read as they are stored.
SIZES = {
    "deg": _DEGREE, "mm": Decimal("0.001"), "cm": Decimal("0.01"), "g": Decimal("0.001")
}  # fmt: skip


def shown_texts(values: Iterable[float], unit: str) -> list[str]:
    """Return numbers in SI units as texts in another unit, from which `read_texts` makes the same.

    Examples
    --------
    >>> shown_texts([0.02, 1e-05], "mm"), shown_texts([0.3490658503988659], "deg")
    (['20', '0.01'], ['20'])
    """
    return [_shown(value, SIZES[unit]) for value in values]


def _shown(value: float, size: Decimal) -> str:
    """Return a number in a unit with as many digits as keep it, 15 to 17."""
    if value != value or value in (float("inf"), float("-inf")):
        return str(value)
    # Of powers of ten the shortest text only moves its point.
    exact = Decimal(value) if size == _DEGREE else Decimal(repr(value))
    for digits in (15, 16):
        text = _rounded(_DECIMALS.divide(exact, size), digits)
        if float(_DECIMALS.multiply(Decimal(text), size)) == value:
            return text
    return _rounded(_DECIMALS.divide(exact, size), 17)


def _rounded(number: Decimal, digits: int) -> str:
    """Return a number with so many digits, without trailing zeros."""
    short = f"{number:.{digits}g}"
    text = f"{Decimal(short):f}"
    if len(text.lstrip("-")) > _LONGEST:
        return short
    return text.rstrip("0").rstrip(".") if "." in text else text


def name_and_unit(heading: str) -> tuple[str, str]:
    """Return the name in the heading of a column and the unit in brackets, "" for none and 1.

    Examples
    --------
    >>> name_and_unit("angle [deg]"), name_and_unit("class")
    (('angle', 'deg'), ('class', ''))
    """
    name, _, unit = heading.strip().removesuffix("]").partition(" [")
    return name, "" if unit == "1" else unit


def read_texts(texts: Iterable[str], unit: str) -> list[float]:
    """Return texts in a unit as numbers in SI units, rounded once."""
    size = SIZES[unit]
    return [float(_DECIMALS.multiply(Decimal(text.strip()), size)) for text in texts]
