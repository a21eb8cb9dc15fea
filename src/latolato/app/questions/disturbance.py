"""Questions about neighbours of a motion."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.app.questions.asked import DISTURBANCE, asked, is_shaken, is_toy
from latolato.app.questions.words import listed, number, shakes

if TYPE_CHECKING:
    import xarray as xr


@asked(
    "lyapunov_spectrum",
    group=DISTURBANCE,
    title="Is it chaotic?",
    term="Lyapunov exponents",
    reading="Two starts that almost agree: do they drift apart? A red bar above zero means yes, "
    "ever faster, and nobody can foretell the motion for long; blue bars mean they meet again.",
    first=("duration", "transient"),
    quick={"duration": "300"},
)
def lyapunov_spectrum(found: xr.Dataset) -> str:
    """Tell whether neighbours part and how fast."""
    status, largest = str(found["status"].item()), float(found["lyapunov_exponents"].max())
    if status == "rest":
        return "No: the balls come to rest on each other, and the past is forgotten."
    if status == "chaotic":
        return (
            f"Yes: neighbouring starts drift apart e-fold every {number(1.0 / largest)} s: chaos."
        )
    if status == "regular":
        return f"No: neighbouring starts come together e-fold every {number(-1.0 / largest)} s."
    if status == "marginal":
        return "It cannot be told in this time: neighbours hardly drift. Follow it longer."
    return f"There is no answer: {status}."


@asked(
    "floquet",
    group=DISTURBANCE,
    title="Is there a steady rhythm nearby, and is it stable?",
    term="Floquet multipliers of a periodic orbit",
    reading="A motion that repeats is found exactly, from a start near it. If all dots lie inside "
    "the circle, small disturbances die out; a red one outside makes them grow.",
    first=("period",),
    conditions=(is_shaken,),
)
def floquet(found: xr.Dataset) -> str:
    """Tell whether the orbit is stable."""
    status, rate = str(found["status"].item()), float(found["growth_rate"])
    if status == "not found":
        return "No repeating motion was found from this start: change the start or the repetition."
    text = f"There is a motion that repeats {shakes(float(found['response_period']))}"
    if status == "unstable":
        return f"{text}; it is unstable: disturbances grow e-fold every {number(1.0 / rate)} s."
    if status == "stable":
        fade = "die out" if math.isinf(rate) else f"fade e-fold every {number(-1.0 / rate)} s"
        return f"{text}; it is stable: disturbances {fade}."
    words = {
        "neutral": "disturbances neither grow nor fade",
        "rest": "the balls rest on each other, and disturbances vanish",
        "grazing": "it touches without speed, so nothing can be said of disturbances",
        "contradicted": "a check of the result failed: do not trust it",
    }
    return f"{text}; {words.get(status, status)}."


@asked(
    "continue_orbit",
    group=DISTURBANCE,
    title="How does a rhythm change, and where does it end?",
    term="continuation of a periodic orbit",
    reading="One repeating motion is followed while a knob is turned: solid where it is stable, "
    "dashed where it is not. Marks show where it turns round, splits or begins to touch.",
    first=("parameter", "low", "high", "period", "direction"),
    quick={"points": "100", "parameter": "frequency_ratio"},
    conditions=(is_shaken,),
)
def continue_orbit(found: xr.Dataset) -> str:
    """Tell the range, the share that is stable, and special points."""
    if not found.sizes["point"] or str(found["status"].item()) == "not found":
        return "No repeating motion was found from this start: change the start or the repetition."
    values = found[found.attrs["parameter"]].values
    low, high = number(float(values.min()), 4), number(float(values.max()), 4)
    stable = found["is_stable"].values == 1
    kind = "stable" if stable.all() else "unstable" if not stable.any() else "partly stable"
    text = f"The rhythm goes on from {low} to {high} and is {kind} there"
    names, counts = np.unique(found["special_kind"].values.astype(str), return_counts=True)
    if names.size:
        marks = [f"{n.replace('_', ' ')} ({c})" for n, c in zip(names, counts, strict=True)]
        text += f"; on the way: {listed(marks)}"
    ends = {"lost": "; then it ends", "points": "; there is more of it", "closed": "; it is a loop"}
    return f"{text}{ends.get(str(found['status'].item()), '')}."


@asked(
    "pair_symmetry",
    group=DISTURBANCE,
    title="Do both balls stay mirror images?",
    term="transverse stability of the symmetric motion",
    reading="Both balls start almost as mirror images. Below zero the difference dies out, and one "
    "ball tells all; above zero it grows, and each ball goes its own way.",
    first=("duration", "transient"),
    quick={"duration": "300"},
    conditions=(is_toy,),
)
def pair_symmetry(found: xr.Dataset) -> str:
    """Tell whether departures grow, of one toy or of how many."""
    status = found["status"].values.astype(str)
    rate = found["transverse_exponent"].values.ravel()
    if status.size > 1:
        share = 100.0 * float((status == "valid").mean())
        return f"They do in {share:.0f} % of the {status.size} cases."
    told, value = str(status.ravel()[0]), float(rate[0])
    if math.isnan(value):
        return f"There is no answer: {told}."
    if told == "valid" and math.isinf(value):
        return "Yes: they rest on each other, and every difference vanishes."
    shown = number(value)
    if told == "valid":
        return f"Yes: differences between them die out, at a rate of {shown} 1/s."
    if told == "broken":
        return f"No: a small difference between them grows, at a rate of {shown} 1/s."
    return f"It cannot be told in this time: the rate is {shown} 1/s."
