"""Questions about what starts the motion, and about what the start decides."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.app.questions.asked import (
    BEGINNING,
    asked,
    ends_as_cosine,
    has_contacts,
    is_shaken,
    settles,
)
from latolato.app.questions.words import (
    UPRIGHT,
    degrees,
    listed,
    millimetres,
    number,
    percent,
    plus_minus,
    shakes,
    times,
)

if TYPE_CHECKING:
    import xarray as xr


@asked(
    "first_push",
    group=BEGINNING,
    title="How hard must I push to get it going?",
    term="basin boundary on a line of starts",
    reading="To the right the speed of the drive, upwards the smallest push that starts lasting "
    "motion. At zero it starts by itself; where a point is missing no push helps.",
    first=("frequency_ratio", "push", "largest_push"),
    quick={"frequency_ratio": "{ratios} : 16", "scan_points": "30"},
    conditions=(settles, is_shaken),
)
def first_push(found: xr.Dataset) -> str:
    """Tell at how many settings which push is needed."""
    status = found["status"].values.astype(str).ravel()
    push = found["first_push"].values.ravel()
    error = found["push_error"].values.ravel()
    ratio = np.repeat(found["frequency_ratio"].values, found.sizes["drive_phase"])
    unit = str(found["first_push"].attrs["units"])
    alone, none = np.isin(status, ("self-start", "any push")), status == "none"
    parts = []
    if alone.any():
        parts.append(f"at {alone.sum()} it starts by itself")
    pushed = np.flatnonzero(status == "push")
    if pushed.size:
        best = pushed[np.argmin(push[pushed])]
        told = number(float(push[best]))
        parts.append(
            f"at {pushed.size} it needs a push, the least being {told} {unit} "
            f"(known to {number(float(error[best]), 1)}) for ω/ω₀ = {number(float(ratio[best]))}"
        )
    if none.any():
        parts.append(f"at {none.sum()} no push helps")
    text = listed(parts) if parts else "no setting has an answer"
    return f"Of {times(status.size, 'drive speed')}: {text}."


@asked(
    "basins",
    group=BEGINNING,
    title="Does it matter how it starts?",
    term="basins of attraction",
    reading="Each point is a start: to the right its angle, upwards its speed. One colour ends in "
    "one motion; where they mix finely, a tiny change decides. Dots: even rounding does.",
    first=("angle_points", "velocity_points", "transient_periods"),
    quick={"angle_points": "40", "velocity_points": "40"},
    conditions=(settles, is_shaken),
)
def basins(found: xr.Dataset) -> str:
    """Tell how many motions there are and which shares of the starts they have."""
    count, left = found.sizes["attractor"], float(found["unresolved_fraction"])
    if not count:
        return "No motion has settled yet: leave out more shakes at the beginning."
    parts: list[str] = []
    for i in range(min(count, 4)):
        one = found.isel(attractor=i)
        status, period = str(one["status"].item()), float(one["response_period"])
        kind = {"rest": "rest", "aperiodic": "chaos"}.get(status)
        if kind == "rest" and one["largest_angle_watched"].max() > UPRIGHT:
            kind = "rest upright"
        if kind is None:
            size = degrees(float(one["largest_angle_watched"].max()))
            kind = f"one that repeats {shakes(period)} and goes out to {size}"
        of = "" if parts else " of the starts"
        parts.append(f"{kind} ({percent(float(one['basin_fraction']))}{of})")
    rest = f"; {percent(left)} of the starts have not settled" if left else ""
    uncertain = float(found["uncertain_fraction"])
    if uncertain:
        rest += f"; of {percent(uncertain)} of the starts the end depends on the numerical error"
    if count == 1:
        only = "all starts end" if not left else "the starts that settle end"
        return f"It does not matter: {only} in {parts[0]}{rest}."
    more = f" and {times(count - 4, 'more')}".removesuffix("s") if count > 4 else ""
    joined = ", ".join(parts) + more if more else listed(parts)
    return f"It does: there are {count} motions to end in, {joined}{rest}."


@asked(
    "self_start",
    group=BEGINNING,
    title="How far must the hand move for it to start by itself?",
    term="lift-off from resting contact",
    reading="To the right the speed of the drive, upwards its amplitude. Inside the coloured part "
    "the pivot drops faster than the balls fall, and they part without a push.",
    first=("frequency_ratio", "check"),
    conditions=(has_contacts,),
)
def self_start(found: xr.Dataset) -> str:
    """Tell the amplitude."""
    amplitude = float(found["drive_amplitude"])
    if not math.isfinite(amplitude):
        return "It never starts by itself at this speed: the crank would jam first."
    text = f"At ω/ω₀ = {number(found.attrs['frequency_ratio'])} the balls part by themselves from "
    text += f"{millimetres(amplitude)} on"
    return f"{text}, where the pivot reaches {number(float(found['drive_acceleration_ratio']))} g."


@asked(
    "shortest_protocol",
    group=BEGINNING,
    title="Does “first fast, then slow” help?",
    term="two-stage driving protocol",
    reading="On the left each cell is a first stage: to the right how long it is held, upwards how "
    "fast it is; bright ones succeed. On the right the push of a hand that does the same. If "
    "nothing was searched, a curve shows how far each push leads.",
    first=("frequency_ratio", "first_frequency_ratio", "dwell_time"),
    quick={"phases": "4"},
    conditions=(settles, ends_as_cosine),
)
def shortest_protocol(found: xr.Dataset) -> str:
    """Tell the shortest protocol and the least push."""
    status = str(found["status"].item())
    if status == "reached from rest":
        return "It is not needed: the large swing comes from rest by itself."
    push = float(found["smallest_push"])
    hand = f"a push of {number(push)} rad/s does it" if math.isfinite(push) else "no push does it"
    if status == "no upper branch":
        rest, most = degrees(float(found["angle_from_rest"])), number(float(found["push"].max()))
        return f"It cannot help: no push up to {most} rad/s leads beyond the {rest} from rest."
    if status != "found":
        return f"No first stage that was tried reaches the large swing; {hand}."
    ratio, lead = float(found["best_first_ratio"]), float(found["lead_time"])
    angle = float(found["upper_angle"])
    swing = "whole turns" if angle > math.pi else f"the large swing of {degrees(angle)}"
    tail = " as well" if math.isfinite(push) else ""
    return f"Yes: {number(lead)} s at ω/ω₀ = {number(ratio)} lead to {swing}; {hand}{tail}."


@asked(
    "hysteresis",
    group=BEGINNING,
    title="Does it remember where it came from?",
    term="hysteresis, bistability",
    reading="The drive is made slowly faster, then slowly slower; upwards the largest swing. Where "
    "both curves part, the toy does one thing or the other, depending on its past.",
    first=("frequency_ratio", "duration"),
    quick={"frequency_ratio": "{ratios} : 41", "duration": "60"},
    conditions=(settles, is_shaken),
)
def hysteresis(found: xr.Dataset) -> str:
    """Tell the range with two answers and the jumps."""
    row = found.isel(drive_amplitude=0)
    status = str(row["status"].item())
    if status == "no hysteresis":
        return "No: on the way up and on the way down it does the same."
    if status == "not settled":
        return "Both ways differ, but the runs are too short, or too wild, to tell: lengthen them."
    if status != "hysteresis":
        return "It cannot be told: at some of these speeds a run has no answer."
    low, high = (number(float(row[f"bistable_{end}"])) for end in ("low", "high"))
    where = f"at ω/ω₀ = {low}" if low == high else f"from ω/ω₀ = {low} to {high}"
    text = f"Yes: {where} the past decides"
    up = float(row["jump_ratio"].sel(direction="up"))
    down = float(row["jump_ratio"].sel(direction="down"))
    jumps = [
        f"at {number(place)} on the way {way}"
        for place, way in ((up, "up"), (down, "down"))
        if math.isfinite(place)
    ]
    return f"{text}; its largest jumps are {listed(jumps)}." if jumps else f"{text}."


@asked(
    "activation_time",
    group=BEGINNING,
    title="How long until random jiggling sets it off?",
    term="noise activation, first passage",
    reading="Many toys are jiggled at random. The curve is the share that has not yet reached the "
    "angle; a straight line here means that the toy does not age: pure chance.",
    first=("noise_strength", "threshold_angle", "trajectories", "duration"),
    quick={"noise_strength": "0.5", "trajectories": "100", "duration": "300"},
)
def activation_time(found: xr.Dataset) -> str:
    """Tell the mean time with its error, or why there is none."""
    status, share = str(found["status"].item()), float(found["activated_fraction"])
    angle = degrees(found.attrs["threshold_angle"])
    mean = float(found["mean_activation_time"])
    if status == "none activated":
        return (
            f"None reached {angle}: on average it takes more than "
            f"{number(float(found['mean_activation_time_low']))} s."
        )
    text = f"{percent(share)} reached {angle}"
    if status == "all at once":
        return f"{text}, all at the same time: the drive takes them there, not chance."
    if status == "not exponential":
        tail = "but not by pure chance: first the motion must grow"
        return f"{text}, after some {number(mean)} s, {tail}."
    told = plus_minus(mean, float(found["mean_activation_time_error"]))
    return f"{text}, by chance, after {told} s on average."
