"""Numbers as they stand in a sentence."""

from __future__ import annotations

import math

_MINUS = "\N{MINUS SIGN}"
_TIMES = "\N{MULTIPLICATION SIGN}"


def number(value: float, digits: int = 3) -> str:
    """Return a number as it stands in a sentence.

    Examples
    --------
    >>> number(0.25), number(1234.5678), number(2.0e6).split()[0]
    ('0.25', '1230', '2')
    """
    if not math.isfinite(value):
        return f"{_MINUS if value < 0 else ''}∞" if math.isinf(value) else "no value"
    if value != 0.0 and not 1e-4 <= abs(value) < 1e6:
        figures, _, power = f"{value:.{digits - 1}e}".partition("e")
        raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        figures = figures.rstrip("0").rstrip(".") if "." in figures else figures
        return f"{figures} {_TIMES} 10{raised}".replace("-", _MINUS)
    place = digits - 1 - math.floor(math.log10(abs(value))) if value else 0
    text = f"{round(value, place):.{max(place, 0)}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return text.replace("-", _MINUS)


def plus_minus(value: float, error: float) -> str:
    """Return a number and its uncertainty in one digit, or two from 10 to 19.

    Examples
    --------
    >>> plus_minus(0.38381, 0.0383), plus_minus(1.5, 0.0)
    ('0.38 ± 0.04', '1.5')
    """
    if not (error > 0.0 and math.isfinite(error)) or not math.isfinite(value):
        return number(value)
    places = max(-math.floor(math.log10(error)) + (1 if f"{error:.0e}"[0] == "1" else 0), 0)
    return f"{value:.{places}f} ± {error:.{places}f}".replace("-", _MINUS)


def degrees(angle: float) -> str:
    """Return an angle in degrees.

    Examples
    --------
    >>> degrees(0.5), degrees(3e-4)
    ('29°', '0.017°')
    """
    size = math.degrees(angle)
    return f"{number(round(size) if abs(size) >= 10 else size, 3 if abs(size) >= 100 else 2)}°"


def percent(share: float) -> str:
    """Return a share in per cent.

    Examples
    --------
    >>> percent(0.8206), percent(0.004)
    ('82 %', '0.4 %')
    """
    size = 100.0 * share
    return f"{number(round(size) if size >= 10.0 else size, 3 if size >= 99.5 else 2)} %"
