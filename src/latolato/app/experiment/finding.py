"""What a tracked video shows, in one sentence, and what to do where something was not found."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.experiment.quality import flag_shares
from latolato.experiment.track_table import balls_of
from latolato.experiment.tracking.wander import period_of
from latolato.figures.analyses.sentences import degrees, percent, plus_minus

if TYPE_CHECKING:
    import xarray as xr

# Where fewer samples were seen, the numbers are doubtful.
_SEEN = 0.5
_PLAIN = ("ok", "collision", "occluded")


def finding_of(
    table: xr.Dataset, cards: Mapping[str, Mapping[str, Any]], trial: Mapping[str, Any] | None
) -> str:
    """Return what a video shows; the first sentence is the answer.

    Parameters
    ----------
    table : xarray.Dataset
        A track table.
    cards : mapping
        The fits of `fits_of`, each with its numbers or an error.
    trial : mapping, optional
        The row of the trial table, if the pivot is driven.
    """
    drive, decay, restitution = (
        cards.get(name, {}).get("values") for name in ("drive", "decay", "restitution")
    )
    if drive:
        sentences = [_driven(table, drive, trial)]
    elif decay:
        sentences = [_free(decay), "The pivot rests. Larger swings are a little slower."]
    else:
        sentences = [_plain(table)]
    if balls_of(table) == 2:
        sentences.append(_collisions(table, restitution))
    seen = sum(flag_shares(table).get(flag, 0.0) for flag in _PLAIN)
    if seen < _SEEN:
        sentences.append(
            f"Only {percent(seen)} of the samples were seen: do not trust the numbers, and correct "
            "the set-up."
        )
    return " ".join(filter(None, sentences))


def _driven(table: xr.Dataset, drive: Mapping[str, Any], trial: Mapping[str, Any] | None) -> str:
    """Return how the pivot moves, and how far the balls swing."""
    text = f"Shaken with an amplitude of {_text(drive['drive_amplitude'], 1e3)} mm, "
    text += f"{_text(drive['drive_frequency'], 1.0 / math.tau)} times a second"
    if "drive_frequency_final" in drive:
        text += f" and later {_text(drive['drive_frequency_final'], 1.0 / math.tau)} times"
    text += ", the balls swing" if balls_of(table) == 2 else ", the ball swings"
    if trial is None:
        return f"{text} out to about {degrees(float(np.nanmax(np.abs(table['angle_1']))))}."
    size, sigma = (math.degrees(trial[n]) for n in ("largest_angle", "largest_angle_sigma"))
    text += f" out to {plus_minus(size, sigma)}°."
    if "not settled" in trial["note"]:
        return f"{text} The motion has not settled in this video."
    words = {
        "none": "The swing ends below 45°",
        "weak": "The swing lasts, beyond 45°",
        "strong": "That is beyond 90°: strong motion",
    }
    return f"{text} {words[trial['class']]}{', but only just' if trial['borderline'] else ''}."


def _free(decay: Mapping[str, Any]) -> str:
    """Return how often a free pendulum swings, and how fast its swing fades."""
    text = f"It swings {_text(decay['natural_frequency'], 1.0 / math.tau)} times a second"
    rate = decay.get("decay_rate") or decay.get("decay_rate_envelope")
    if rate is None or not rate["value"] > 0.0:
        return f"{text}; that its swing fades was not found: film it for longer."
    half = math.log(2.0) / rate["value"]
    sigma = half * (rate["sigma"] or 0.0) / rate["value"]
    return f"{text} and loses half of its swing every {plus_minus(half, sigma)} s."


def _plain(table: xr.Dataset) -> str:
    """Return what tracking alone gives: the period of the swing, if there is one."""
    if "angle_1" in table.variables and np.isfinite(table["angle_1"].values).any():
        angle = table["angle_1"].values
        period, sigma = period_of(table["time"].values, np.column_stack([angle, 0.0 * angle]))
    else:
        period, sigma = (float(table.attrs.get(n) or math.nan) for n in ("period", "period_sigma"))
    if not math.isfinite(period):
        return (
            "No swing was found. At least three swings must be seen: film for longer, or correct "
            "the set-up."
        )
    return f"It swings once in {plus_minus(period, sigma)} s."


def _collisions(table: xr.Dataset, restitution: Mapping[str, Any] | None) -> str:
    """Return what collisions do to the balls."""
    touching = table["flag_1"].values == "collision"
    if not restitution and not touching.any():
        return "The balls were not seen to touch."
    angles = np.abs(table["angle_1"].values[touching]) if "angle_1" in table else np.empty(0)
    quarter = 0.5 * math.pi
    sides = {"below": (angles < quarter).any(), "above": (angles >= quarter).any()}
    where = " and".join(f" {side}" for side, is_there in sides.items() if is_there)
    if not restitution:
        return f"The balls touch{where}. What a collision does is not seen: film it faster."
    kept = _text(restitution["restitution"])
    return f"The balls clack{where}: a collision keeps {kept} of their speed."


def _text(value: Mapping[str, Any], factor: float = 1.0) -> str:
    """Return a number of a fit and its standard deviation, times a factor."""
    return plus_minus(value["value"] * factor, (value["sigma"] or 0.0) * factor)
