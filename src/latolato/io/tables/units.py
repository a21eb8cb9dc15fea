"""Units as people and programs write them."""

from __future__ import annotations

import re

# Spellings in small letters of each unit, by what it measures.
_SPELLINGS: dict[str, dict[str, str]] = {
    "time": {
        "s": "s sec secs second seconds sek sekunde sekunden seconde secondes segundos detik",
        "ms": "ms msec msecs millisecond milliseconds millisekunden millisecondes milidetik",
        "us": "us µs μs usec microsecond microseconds",
        "ns": "ns nsec nanosecond nanoseconds",
        "min": "min mins minute minutes",
        "h": "h hr hour hours",
    },
    "length": {
        "m": "m meter meters metre metres",
        "cm": "cm centimeter centimeters centimetre centimetres",
        "mm": "mm millimeter millimeters millimetre millimetres",
        "um": "um µm μm micron microns micrometer micrometre",
        "in": "in inch inches",
        "ft": "ft foot feet",
        "km": "km",
    },
    "angle": {
        "rad": "rad rads radian radians",
        "mrad": "mrad",
        "deg": "deg degs degree degrees ° º degré degrés derajat grados gradi",
        "arcmin": "arcmin arcminute arcminutes",
        "gon": "gon gradian gradians",
        "rev": "rev turn turns revolution revolutions",
    },
    "angular velocity": {
        "rad/s": "rad/s rad/sec rads/s radian/s radians/s rad*s^-1 rad.s-1 rad·s⁻¹",
        "deg/s": "deg/s deg/sec °/s º/s °/sec dps degree/s degrees/s",
        "Hz": "hz hertz",
        "rpm": "rpm",
    },
    "picture": {"px": "px pixel pixels pix"},
    "number": {"1": "1 frame frames"},
}
# Others that mark a cell of a header as a unit; nothing is converted from them.
_OTHERS = (
    "v", "mv", "n", "g", "kg", "j", "w", "m/s", "m/s^2", "m/s²", "m/s2", "cm/s", "cm/s^2", "mm/s",
    "mm/s^2", "n·m", "rad/s^2", "rad/s²", "deg/s^2", "°/s²", "quality", "%", "µt", "ut", "lux",
    "hpa", "kpa", "pa", "°c", "k",
)  # fmt: skip
# Units whose conversion the list of units does not know, in one that it knows.
IN_OTHERS = {"gon": "0.9 deg", "arcmin": f"{1 / 60!r} deg"}
_KNOWN = {
    spelling: unit
    for units in _SPELLINGS.values()
    for unit, spellings in units.items()
    for spelling in spellings.split()
}
_OF = {unit: kind for kind, units in _SPELLINGS.items() for unit in units}
# Units that programs append to a name: t_s, theta_deg.
APPENDED = ("s", "ms", "us", "ns", "m", "cm", "mm", "px", "rad", "deg")


def canonical(text: str) -> str | None:
    """Return a unit in the spelling that this package reads, None for an unknown one.

    Examples
    --------
    >>> canonical("Deg"), canonical("S"), canonical("º"), canonical("x axis")
    ('deg', 's', 'deg', None)
    """
    text = text.strip()
    if text in _OF:
        return text
    if re.fullmatch("M(s|m|rad)", text):  # mega or, written by mistake, milli
        return None
    return _KNOWN.get(re.sub(r"\s+", "", text).lower())


def is_unit(text: str) -> bool:
    """Return whether a cell of a header holds a unit, perhaps in brackets."""
    match = re.fullmatch(r"\s*[(\[](.*)[)\]]\s*", text)
    if match:
        return True
    return canonical(text) is not None or text.strip().lower() in _OTHERS


def is_known(text: str) -> bool:
    """Return whether a text in brackets is a unit and not a remark."""
    text = text.strip()
    if canonical(text) is not None or text.lower() in _OTHERS:
        return True
    return bool(text) and len(text) <= 12 and not re.search(r"\s|^[xyz]$|^#?\d+$", text.lower())


def units_like(unit: str) -> list[str]:
    """Return the units that measure the same as one of them."""
    kind = _OF.get(unit)
    return list(_SPELLINGS[kind]) if kind else []
