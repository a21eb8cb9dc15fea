"""Questions about the ball that hangs still or stands upright."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from latolato.app.questions.asked import REST, asked, can_hang, can_stand, is_even, is_shaken
from latolato.app.questions.words import millimetres, number

if TYPE_CHECKING:
    import xarray as xr

_WORDS = {"hanging": "hanging still", "inverted": "standing upright"}


@asked(
    "tongue_edges",
    group=REST,
    title="At which speeds does hanging still become impossible?",
    term="parametric resonance, Mathieu-Hill tongue",
    reading="Inside the coloured tongues the smallest swing grows by itself, as on a garden swing. "
    "The dashed line is the amplitude asked for; the dots are the edges on it.",
    first=("drive_amplitude", "order", "position"),
    conditions=(can_hang, is_shaken),
)
def tongue_edges(found: xr.Dataset) -> str:
    """Tell both edges."""
    low, high = float(found["low"]), float(found["high"])
    where = _WORDS[found.attrs["position"]]
    with_amplitude = f"With an amplitude of {millimetres(found.attrs['drive_amplitude'])}"
    if not math.isfinite(low):
        return f"{with_amplitude} tongue {found.attrs['order']} is closed: drag is too strong."
    if not math.isfinite(high):
        return f"{with_amplitude} {where} is unstable at all speeds above ω/ω₀ = {number(low, 5)}."
    return (
        f"{with_amplitude} {where} is unstable from ω/ω₀ = {number(low, 5)} to {number(high, 5)}."
    )


@asked(
    "threshold_amplitude",
    group=REST,
    title="How strongly must it be shaken to swing up by itself?",
    term="threshold of parametric resonance",
    reading="Inside the coloured tongues hanging still is impossible. The dot is where this speed "
    "first meets a tongue; below it a small swing dies away.",
    first=("frequency_ratio", "order"),
    conditions=(can_hang, is_even),
)
def threshold_amplitude(found: xr.Dataset) -> str:
    """Tell the amplitude."""
    at = f"At ω/ω₀ = {number(found.attrs['frequency_ratio'], 4)}"
    amplitude = float(found["drive_amplitude"])
    if not math.isfinite(amplitude):
        return f"{at} no amplitude up to the limit of the search makes hanging unstable."
    return f"{at} a small swing grows once the amplitude exceeds {millimetres(amplitude)}."


@asked(
    "growth_rate",
    group=REST,
    title="Does a small swing grow or die away?",
    term="growth rate, Floquet exponent",
    reading="To the right the speed of the drive, upwards how fast a small swing grows. Above zero "
    "it grows, below it dies away. The dot is the speed of now.",
    first=("position",),
    conditions=(can_hang, is_even),
)
def growth_rate(found: xr.Dataset) -> str:
    """Tell the rate as the time in which a swing doubles or halves."""
    rate, where = float(found["growth_rate"]), _WORDS[found.attrs["position"]]
    if abs(rate) < 1e-9:
        return f"About {where} a small swing neither grows nor dies away."
    verb = "doubles" if rate > 0.0 else "halves"
    time = math.log(2.0) / abs(rate)
    return f"About {where} a small swing {verb} every {number(time)} s."


@asked(
    "inverted_limits",
    group=REST,
    title="Can it stand on its head?",
    term="Kapitza's pendulum, dynamic stabilisation",
    reading="Inside the coloured part fast shaking holds the ball upright. To the right the speed "
    "of the drive, upwards its amplitude over the length; dashed is Kapitza's formula.",
    first=("frequency_ratio",),
    conditions=(can_stand,),
)
def inverted_limits(found: xr.Dataset) -> str:
    """Tell between which amplitudes."""
    at = f"At ω/ω₀ = {number(found.attrs['frequency_ratio'], 4)}"
    low, high = float(found["low"]), float(found["high"])
    if not math.isfinite(low):
        return f"{at} no amplitude holds it upright."
    if not math.isfinite(high):
        return f"{at} every amplitude above {millimetres(low)} that was tried holds it upright."
    return f"{at} it stands upright with an amplitude of {millimetres(low)} to {millimetres(high)}."
