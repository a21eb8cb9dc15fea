"""Questions about motion that lasts."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.app.questions.asked import (
    LONG_RUN,
    asked,
    has_contacts,
    is_even,
    is_shaken,
    settles,
)
from latolato.app.questions.words import UPRIGHT, degrees, listed, number, percent, shakes, times

if TYPE_CHECKING:
    import xarray as xr


@asked(
    "bifurcation_diagram",
    group=LONG_RUN,
    title="What happens when I turn one knob?",
    term="bifurcation diagram",
    reading="Above each setting of the knob stand the angles seen once per shake: one dot, it "
    "repeats every shake; two dots, every second; a smear, never. Red is the way up, blue the way "
    "back down: where they differ, the past decides.",
    first=("parameter", "low", "high", "points"),
    quick={"points": "41", "parameter": "frequency_ratio"},
    conditions=(settles, is_shaken),
)
def bifurcation_diagram(found: xr.Dataset) -> str:
    """Tell how many settings move, which periods occur, and where both ways differ."""
    status = found["status"].values.astype(str)
    moving = np.isin(status, ("periodic", "grazing", "aperiodic"))
    if not moving.any():
        rest = percent((status == "rest").mean())
        if (status == "rest").all():
            return "It ends at rest at every setting tried."
        return f"It ends at rest at {rest} of the settings; at the others it has not settled yet."
    periods = found["response_period"].values[np.isin(status, ("periodic", "grazing"))]
    known = [shakes(p) for p in np.unique(periods[np.isfinite(periods)])]
    parts = [f"repeats {listed(known[:4], 'or')}"] if known else []
    if (status == "aperiodic").any():
        parts.append("never repeats")
    text = f"It keeps moving at {percent(moving.mean())} of the settings; there it "
    text += ", or ".join(parts)
    if "is_hysteretic" in found:
        both = np.flatnonzero(found["is_hysteretic"].values == 1)
        if both.size:
            values = found[found.attrs["parameter"]]
            unit = str(values.attrs.get("units", "1")).replace("^2", "²")
            unit = "" if unit == "1" else f" {unit}"
            ends = sorted({number(float(values[both[0]])), number(float(values[both[-1]]))})
            text += (
                f". Between {' and '.join(ends)}{unit}"
                if len(ends) == 2
                else (f". At {ends[0]}{unit}")
            )
            text += " there are settings with two answers: the way there decides"
    return text + "."


@asked(
    "response_period",
    group=LONG_RUN,
    title="After how many shakes does it repeat?",
    term="response period and rotation number",
    reading="The angle is noted once per shake, as if by a flash. Dots that jump between p heights "
    "mean that the motion repeats after p shakes; dots without order never repeat.",
    first=("longest", "transient_periods"),
    conditions=(settles, is_shaken),
)
def response_period(found: xr.Dataset) -> str:
    """Tell the period and what happens in it."""
    status = str(found["status"].item())
    if status == "rest" and found["largest_angle_watched"].item() > UPRIGHT:
        return "It comes to rest upright: it stands on its head."
    if status == "rest":
        return "It comes to rest: nothing moves against the pivot any more."
    if status == "not settled":
        return (
            f"After {found.attrs['transient_periods']:g} shakes it still changes: leave out more "
            "shakes at the beginning."
        )
    if status == "aperiodic":
        return (
            f"It does not repeat within {found.attrs['longest']} shakes: look whether it is chaos."
        )
    if status not in ("periodic", "grazing"):
        return f"There is no answer: {status}."
    text = f"The motion repeats {shakes(found['response_period'].item())}"
    if found["impacts_per_period"].item():
        text += f", with {times(found['impacts_per_period'].item(), 'impact')} per shake"
    text += f", and goes out to {degrees(found['largest_angle_watched'].item())}"
    tail = " It touches almost without speed, so a small change may change the rhythm."
    return f"{text}.{tail if status == 'grazing' else ''}"


@asked(
    "poincare_section",
    group=LONG_RUN,
    title="What pattern does it draw, seen once per shake?",
    term="Poincaré (stroboscopic) section",
    reading="Every dot is one flash per shake: to the right the angle, upwards the speed. A few "
    "dots mean a rhythm, a closed curve two rhythms that do not fit, a cloud with layers chaos.",
    first=("periods", "section_phase"),
    conditions=(settles, is_shaken),
)
def poincare_section(found: xr.Dataset) -> str:
    """Tell how many different points there are."""
    angle, speed = (
        found[name].values.reshape(-1, found.sizes["time"]).T
        for name in ("angle", "angular_velocity")
    )
    keep = np.isfinite(angle).all(axis=1) & np.isfinite(speed).all(axis=1)
    if not keep.any():
        return f"There is no answer: {found['status'].item()}."
    scale = float(found.attrs["drive_frequency"])
    # Angles as points of a circle, which has no ends.
    points = np.concatenate([np.cos(angle[keep]), np.sin(angle[keep]), speed[keep] / scale], axis=1)
    count = len(np.unique(np.round(points, 3), axis=0))
    # Neighbours on both sides of an edge of rounding are one.
    near = np.abs(points[1:] - points[0]).max(axis=1) < 5e-3
    if near.all():
        return f"All {len(points)} flashes show the same: it repeats every shake, or rests."
    period = int(np.argmax(near)) + 1 if near.any() else 0
    if period and near[period - 1 :: period].all() and period <= 64:
        return f"It visits {period} places in turn: it repeats {shakes(period)}."
    return f"The {len(points)} flashes fall on some {count} places: no short repetition is seen."


@asked(
    "response_period_map",
    group=LONG_RUN,
    title="Where does it repeat, rest or run wild?",
    term="map of response periods",
    reading="Each cell is one toy: to the right the speed of the drive, upwards its amplitude. The "
    "colour says after how many shakes its motion repeats; pale cells rest, red ones never repeat.",
    first=("drive_amplitude", "frequency_ratio"),
    quick={"drive_amplitude": "{amplitudes} : 16", "frequency_ratio": "{ratios} : 16"},
    conditions=(settles, is_even),
)
def response_period_map(found: xr.Dataset) -> str:
    """Tell the shares of rest, of the most frequent period and of motion without one."""
    if not found["cells"].values.any():
        return "No cell has an answer."
    share = dict(zip(found["motion"].values.astype(str), found["share"].values, strict=True))
    rest = share.pop("rest", 0.0)
    parts = [f"{percent(rest)} rest"] if rest else []
    wild = share.pop("aperiodic", 0.0)
    moving = {name: s for name, s in share.items() if name.startswith("period ") and s > 0.0}
    if moving:
        name = max(moving, key=lambda each: moving[each])
        parts.append(f"{percent(moving[name])} repeat {shakes(int(name.split()[1]))}")
    if wild:
        parts.append(f"{percent(wild)} never repeat")
    return f"Of the cells {listed(parts)}." if parts else "No cell has settled."


@asked(
    "impact_map",
    group=LONG_RUN,
    title="In what rhythm do the balls clack?",
    term="impact map",
    reading="Every dot is a clack: to the right when in the shake it comes, upwards how fast the "
    "balls part. Few dots mean a steady rhythm. On the right each clack against the one before.",
    first=("periods", "transient_periods"),
    conditions=(has_contacts, is_shaken),
)
def impact_map(found: xr.Dataset) -> str:
    """Tell the rate of impacts and their sides."""
    count = found.sizes.get("impact", 0)
    if not count:
        return "The balls do not clack: they rest on each other, or swing without touching."
    side = found["impact_side"].values.astype(str)
    where = [name for name in ("bottom", "top") if (side == name).any()]
    rate = float(found["impacts_per_period"])
    phases = found["impact_phase"].values
    # On the circle, a little coarser than the drive's phase is told.
    places = np.unique(np.round(np.exp(1j * phases), 2)).size
    steady = places <= 12
    text = f"The balls clack {times(rate, 'time')} per shake, at the {listed(where)}"
    rests = int(found["rests"])
    if rests:
        text += f", and come to rest {times(rests, 'time')} meanwhile"
    return f"{text}; {'the rhythm is steady' if steady else 'the rhythm keeps changing'}."


@asked(
    "time_crystal",
    group=LONG_RUN,
    title="Does it keep its half-speed beat?",
    term="subharmonic line, “time crystal” order",
    reading="Does it swing once in two shakes, and does random jiggling make it lose the beat? "
    "The left curve is its memory of the beat: flat near 1 it is kept, falling to 0 it is lost.",
    first=("noise_strength", "trajectories", "periods"),
    quick={"noise_strength": "0", "trajectories": "1"},
    conditions=(is_shaken,),
)
def time_crystal(found: xr.Dataset) -> str:
    """Tell whether there is a line at half the frequency, and how long it keeps its phase."""
    heights = found["peak_amplitude"].fillna(-1.0)
    best = np.unravel_index(int(np.argmax(heights.values)), heights.shape)
    point = found.isel(dict(zip(map(str, heights.dims), best, strict=True)))
    status, peak = str(point["status"].item()), float(point["peak_frequency"])
    angle = degrees(float(point["peak_amplitude"]))
    life, least = float(point["lifetime"]), float(point["lifetime_low"])
    if status in ("no motion", "no subharmonic", "no answer") or not math.isfinite(peak):
        words = {"no motion": "it rests", "no subharmonic": "it follows every shake alike"}
        return f"There is no beat of two shakes: {words.get(status, 'the run has no answer')}."
    text = {
        "locked": "It swings exactly once in two shakes",
        "drifting": f"Its beat is near half the drive's speed but not at it ({number(peak, 4)})",
        "broad": "There is no clear beat of two shakes, but a broad mixture about it",
    }[status]
    text += f", {angle} to each side"
    if math.isfinite(life):
        return f"{text}; it slips out of step about every {number(life)} s."
    if math.isfinite(least):
        return f"{text}; it never slipped, so it does so less than once in {number(least)} s."
    return f"{text}."
