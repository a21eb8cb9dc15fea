"""Numbers, counts and lists as they stand in a sentence."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

# Beyond this angle [rad] one ball at rest stands upright.
UPRIGHT = 0.75 * math.pi
POSITION_WORDS = {"hanging": "hanging still", "inverted": "standing upright"}
# Why a run has no answer, by its status.
_REASONS = {
    "event_limit": "the balls touch more often than can be followed",
    "failed": "the computation failed",
    "invalid": "these values describe no toy",
    "outside_model": "a string hits a ball, which the model does not describe",
}
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


def millimetres(length: float) -> str:
    """Return a length in millimetres.

    Examples
    --------
    >>> millimetres(0.0234567)
    '23.5 mm'
    """
    return f"{number(1e3 * length)} mm"


def percent(share: float) -> str:
    """Return a share in per cent.

    Examples
    --------
    >>> percent(0.8206), percent(0.004)
    ('82 %', '0.4 %')
    """
    size = 100.0 * share
    return f"{number(round(size) if size >= 10.0 else size, 3 if size >= 99.5 else 2)} %"


def shakes(count: float) -> str:
    """Return so many drive periods in words.

    Examples
    --------
    >>> shakes(1), shakes(2), shakes(7)
    ('every shake', 'every second shake', 'every 7 shakes')
    """
    return {1: "every shake", 2: "every second shake"}.get(
        round(count), f"every {count:.0f} shakes"
    )


def times(count: float, what: str) -> str:
    """Return a number of things.

    Examples
    --------
    >>> times(1, "impact"), times(2.5, "impact")
    ('1 impact', '2.5 impacts')
    """
    text = number(count)
    return f"{text} {what}{'' if text == '1' else 's'}"


def listed(parts: list[str], last: str = "and") -> str:
    """Return a list in words.

    Examples
    --------
    >>> listed(["a", "b", "c"])
    'a, b and c'
    """
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} {last} {parts[-1]}"


def within(low: float, high: float) -> str:
    """Return a range of a number, or the number where both ends are the same.

    Examples
    --------
    >>> within(1.5, 3.0), within(2.0, 2.0)
    ('from 1.5 to 3', '2')
    """
    ends = number(low, 4), number(high, 4)
    return ends[0] if ends[0] == ends[1] else f"from {ends[0]} to {ends[1]}"


def range_of(variable: xr.DataArray, low: float, high: float) -> str:
    """Return a range of a quantity with its name and unit.

    Examples
    --------
    >>> import xarray as xr
    >>> range_of(xr.DataArray([1.5], name="frequency_ratio"), 1.5, 3.0)
    'ω/ω₀ from 1.5 to 3'
    >>> about = {"long_name": "driving amplitude", "units": "m"}
    >>> range_of(xr.DataArray([0.01], attrs=about, name="drive_amplitude"), 0.01, 0.01)
    'driving amplitude 0.01 m'
    """
    name = str(variable.attrs.get("long_name", variable.name))
    unit = str(variable.attrs.get("units", "1")).replace("^2", "²").replace("*", " ")
    if variable.name == "frequency_ratio":
        name, unit = "ω/ω₀", "1"
    return f"{name} {within(low, high)}" + ("" if unit == "1" else f" {unit}")


def no_answer(status: str) -> str:
    """Return the sentence that stands for an answer, and why there is none.

    Examples
    --------
    >>> no_answer("event_limit")
    'There is no answer: the balls touch more often than can be followed.'
    """
    return f"There is no answer: {_REASONS.get(status, status)}."


def e_folding(rate: float) -> str:
    """Return how fast something grows or fades, by the time of a factor e.

    Examples
    --------
    >>> e_folding(0.5), e_folding(-2.0)
    ('by a factor of e every 2 s', 'by a factor of e every 0.5 s')
    """
    return f"by a factor of e every {number(1.0 / abs(rate))} s"
