"""What a video or a table shows: numbers, sentences, and what to do where something is missing."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import Sentence, as_read
from latolato.core.rules import Rule, sentence
from latolato.experiment.fits.result import USUAL_SIZES, size_questions
from latolato.experiment.period import period_of_ball
from latolato.experiment.quality import flag_shares
from latolato.experiment.track_table import MEASURED, balls_of
from latolato.physics.pendulum import GRAVITY, equivalent_pendulum

if TYPE_CHECKING:
    import xarray as xr

    from latolato.experiment.fits.registry import Apparatus

# The sentences; pages translate them by their names, as those of rules.
FINDINGS = {
    "swing_fades": Rule(
        "It swings {rate} times a second and loses half of its swing every {half} s."
    ),
    "swing_grows": Rule("It swings {rate} times a second, and its swing grows by {growth} 1/s."),
    "swing_lasts": Rule(
        "It swings {rate} times a second; no decay of its swing was found: a longer record may "
        "show one."
    ),
    "pivot_at_rest": Rule("The pivot is at rest. Larger swings are a little slower."),
    "one_swing": Rule("One swing takes {period} s."),
    "no_swing": Rule(
        "No swing was found. A record needs at least three swings: make it longer, or correct the "
        "set-up."
    ),
    "ball_is_shaken": Rule(
        "Shaken with an amplitude of {amplitude} mm, {rates}, the ball swings out to {angle}."
    ),
    "balls_are_shaken": Rule(
        "Shaken with an amplitude of {amplitude} mm, {rates}, the balls swing out to {angle}."
    ),
    "one_rate": Rule("{rate} times a second"),
    "two_rates": Rule("{rate} times a second and later {later} times"),
    "vertical_axis": Rule(
        "The axis of the drive is taken as vertical: the clip shows too little of the swing to "
        "tell."
    ),
    "not_settled": Rule("The motion has not settled in this record."),
    "motion_none": Rule("The swing ends below 45°."),
    "motion_weak": Rule("The swing lasts and goes beyond 45°."),
    "motion_strong": Rule("That is beyond 90°: strong motion."),
    "borderline": Rule("The uncertainty of the angle reaches across that limit."),
    "no_touch": Rule("The balls were not seen to touch."),
    "touch": Rule(
        "The balls touch, but the effect of a collision could not be measured: it takes more "
        "frames or samples per second."
    ),
    "clack": Rule("The balls clack: a collision keeps {kept} of their speed."),
    "met_below": Rule("They meet below."),
    "met_above": Rule("They meet above."),
    "met_twice": Rule("They meet below and above."),
    "hardly_seen": Rule(
        "The angle was measured in only {share} of the samples: do not trust the numbers, and "
        "correct the set-up."
    ),
}
# Where fewer samples were seen, the numbers are doubtful.
_SEEN = 0.5
# Standard deviations from which a decay or a growth is seen.
_SURE = 3.0
# Standard uncertainty of a length that somebody measured: one mark of a ruler [m].
_RULER = 1e-3


def finding_of(
    table: xr.Dataset,
    cards: Mapping[str, Mapping[str, Any]],
    trial: Mapping[str, Any] | None,
    questions: Sequence[str] = (),
) -> list[str]:
    """The finding of a video or a table in sentences; the first is the answer or a doubt.

    Parameters
    ----------
    table : xarray.Dataset
        A track table.
    cards : mapping
        The fits of `fits_of`, each with its numbers or an error.
    trial : mapping, optional
        The row of the trial table, if the pivot is driven.
    questions : sequence of str
        What must be asked before any number is said, as of `questions_of`.
    """
    drive, decay, restitution = (
        cards.get(name, {}).get("values") for name in ("drive", "decay", "restitution")
    )
    doubt = _doubt(table, cards)
    sentences: list[str]
    if drive:
        sentences = _driven(table, drive, trial)
        if table.attrs.get("gravity_source") == "vertical drive":
            sentences.append(_sentence("vertical_axis"))
    elif doubt:
        sentences = [doubt, _plain(table)]
    elif decay:
        sentences = [_free(decay), _sentence("pivot_at_rest")]
    else:
        sentences = [_plain(table)]
    if balls_of(table) == 2:
        sentences += _collisions(table, restitution)
    seen = sum(flag_shares(table).get(flag, 0.0) for flag in MEASURED)
    if seen < _SEEN:
        sentences.append(_sentence("hardly_seen", share=f"{100.0 * seen:.0f} %"))
    return [*questions, *sentences]


def questions_of(table: xr.Dataset, cards: Mapping[str, Mapping[str, Any]]) -> list[Sentence]:
    """Return questions about numbers that no pendulum on a table or a tower has.

    Without a fit the length is that of a pendulum with the period of the swing.
    """
    values = {n: v for card in cards.values() for n, v in (card.get("values") or {}).items()}
    sizes = {name: values[name]["value"] for name in USUAL_SIZES if name in values}
    if not sizes:
        period, _ = _period(table)
        sizes = {"length": GRAVITY * (period / math.tau) ** 2} if math.isfinite(period) else {}
    return size_questions(sizes)


def _sentence(name: str, /, **values: Any) -> Sentence:
    """Return one of `FINDINGS`."""
    return sentence(name, FINDINGS, **values)


def _doubt(table: xr.Dataset, cards: Mapping[str, Mapping[str, Any]]) -> str:
    """Return why the motion is not what fits take it for, "" if it is.

    That of the decay counts for one ball only: two that collide do not swing freely.
    """
    names = ("drive", "decay") if balls_of(table) == 1 else ("drive",)
    return next((cards[n]["doubt"] for n in names if cards.get(n, {}).get("doubt")), "")


def answer_of(
    table: xr.Dataset,
    cards: Mapping[str, Mapping[str, Any]],
    trial: Mapping[str, Any] | None,
    apparatus: Apparatus,
    questions: Sequence[str] = (),
) -> list[dict[str, Any]]:
    """Return the few numbers that a video was filmed for, in reading order.

    There are none while a question is open, or where a fit does not describe the record.

    Parameters
    ----------
    table : xarray.Dataset
        A track table.
    cards : mapping
        The fits of `fits_of`, each with its numbers or an error.
    trial : mapping, optional
        The row of the trial table, if the pivot is driven.
    apparatus : Apparatus
        What was measured besides the video. With the length, gravity is a result; without it, the
        length is one, with the gravity of `fit_decay`, which is taken as exact.
    questions : sequence of str
        As in `finding_of`.

    Returns
    -------
    list of dict
        Each with `name`, `value`, `sigma` (one standard deviation) and `units`. Gravity and length
        have `given`, the numbers from which they follow by ``T = 2 pi sqrt(l/g)``, as a page shows
        them: `length` and `sigma`, its uncertainty, or `gravity`; and with a radius, that of the
        ball, and by how much the equivalent length `l` exceeds the distance to the centre.

    Notes
    -----
    A length whose uncertainty nobody gave is taken to be uncertain by 1 mm, one mark of a ruler,
    and a radius to be exact: of the equivalent length ``l + 2/5 r^2/l`` it changes the small second
    part only.
    """
    drive, decay, restitution = (
        cards.get(name, {}).get("values") for name in ("drive", "decay", "restitution")
    )
    if questions or _doubt(table, cards):
        return []
    if drive:
        numbers = _of_drive(drive, trial)
    elif decay:
        numbers = _of_decay(decay, apparatus)
    else:
        numbers = _of_period("", *_period(table))
    if restitution:
        numbers.append(_number("restitution", *_value(restitution["restitution"]), ""))
    return numbers


def _number(name: str, value: float, sigma: float, units: str, **more: Any) -> dict[str, Any]:
    return {"name": name, "value": value, "sigma": sigma, "units": units, **more}


def _of_period(which: str, period: float, sigma: float) -> list[dict[str, Any]]:
    """Return a period and its frequency, nothing if it is unknown."""
    if not math.isfinite(period):
        return []
    return [
        _number(f"{which}period", period, sigma, "s"),
        _number(f"{which}frequency", 1.0 / period, sigma / period**2, "Hz"),
    ]


def _of_drive(drive: Mapping[str, Any], trial: Mapping[str, Any] | None) -> list[dict[str, Any]]:
    """Return how the pivot moves, and how far the balls swing."""
    numbers = [
        _number("drive_amplitude", *_value(drive["drive_amplitude"], 1e3), "mm"),
        _number("drive_frequency", *_value(drive["drive_frequency"], 1.0 / math.tau), "Hz"),
    ]
    if trial is not None:
        size, sigma = (math.degrees(trial[n]) for n in ("largest_angle", "largest_angle_sigma"))
        numbers.append(_number("largest_angle", size, sigma, "°"))
    return numbers


def _of_decay(decay: Mapping[str, Any], apparatus: Apparatus) -> list[dict[str, Any]]:
    """Return period and frequency of small swings, how they fade, and gravity or the length."""
    rate, error = _value(decay["natural_frequency"])
    numbers = _of_period("small_", math.tau / rate, math.tau * error / rate**2)
    half = _half_life(decay)
    if half is not None:
        numbers.append(_number("half_life", *half, "s"))
    given: dict[str, float] = {}
    if apparatus.length is None:
        length, sigma = _value(decay.get("centre_length") or decay["length"])
        if "centre_length" in decay:
            given = _of_ball(length, decay["length"]["value"], apparatus)
        given |= {"gravity": apparatus.gravity}
        return [*numbers, _number("length", 1e2 * length, 1e2 * sigma, "cm", given=given)]
    point, _ = equivalent_pendulum(apparatus.length, 1.0, radius=apparatus.radius or 0.0)
    if apparatus.radius:
        given = _of_ball(apparatus.length, point, apparatus)
    ruler = apparatus.length_sigma or _RULER
    given |= {"length": 1e2 * apparatus.length, "sigma": 1e3 * ruler}
    gravity = point * rate**2
    sigma = gravity * math.hypot(2.0 * error / rate, ruler / apparatus.length)
    return [*numbers, _number("gravity", gravity, sigma, "m/s²", given=given)]


def _of_ball(centre: float, equivalent: float, apparatus: Apparatus) -> dict[str, float]:
    """Return by how much a solid ball makes its pendulum longer [mm], and the sum [cm]."""
    return {
        "radius": 1e3 * (apparatus.radius or 0.0),
        "more": 1e3 * (equivalent - centre),
        "equivalent": 1e2 * equivalent,
    }


def _half_life(decay: Mapping[str, Any]) -> tuple[float, float] | None:
    """Return the time in which half of a swing is lost [s], None if it was not seen to fade."""
    rate = decay.get("decay_rate") or decay.get("decay_rate_envelope")
    if rate is None or not rate["value"] > _SURE * (rate["sigma"] or 0.0):
        return None
    half = math.log(2.0) / rate["value"]
    return half, half * (rate["sigma"] or 0.0) / rate["value"]


def _driven(
    table: xr.Dataset, drive: Mapping[str, Any], trial: Mapping[str, Any] | None
) -> list[str]:
    """Return how the pivot moves, and how far the balls swing."""
    rate = _text(drive["drive_frequency"], 1.0 / math.tau)
    rates = _sentence("one_rate", rate=rate)
    if "drive_frequency_final" in drive:
        later = _text(drive["drive_frequency_final"], 1.0 / math.tau)
        rates = _sentence("two_rates", rate=rate, later=later)
    if trial is None:
        largest = math.degrees(np.nanmax(np.abs(table["angle_1"])))
        angle = f"≈ {largest:.0f}°"
    else:
        size, sigma = (math.degrees(trial[n]) for n in ("largest_angle", "largest_angle_sigma"))
        angle = f"{plus_minus(size, sigma)}°"
    shaken = _sentence(
        "balls_are_shaken" if balls_of(table) == 2 else "ball_is_shaken",
        amplitude=_text(drive["drive_amplitude"], 1e3), rates=rates, angle=angle,
    )  # fmt: skip
    if trial is None:
        return [shaken]
    if "not settled" in trial["note"]:
        return [shaken, _sentence("not_settled")]
    close = [_sentence("borderline")] if trial["borderline"] else []
    return [shaken, _sentence(f"motion_{trial['class']}"), *close]


def _free(decay: Mapping[str, Any]) -> Sentence:
    """Return how often a free pendulum swings, and how fast its swing fades."""
    swings = _text(decay["natural_frequency"], 1.0 / math.tau)
    half = _half_life(decay)
    rate, sigma = _value(decay.get("decay_rate") or decay["decay_rate_envelope"])
    if rate < -_SURE * sigma:
        return _sentence("swing_grows", rate=swings, growth=plus_minus(-rate, sigma))
    if half is None:
        return _sentence("swing_lasts", rate=swings)
    return _sentence("swing_fades", rate=swings, half=plus_minus(*half))


def _period(table: xr.Dataset) -> tuple[float, float]:
    """Return the period of the swing and its standard deviation [s], NaN if none is seen."""
    return period_of_ball(table, 1)


def _plain(table: xr.Dataset) -> Sentence:
    """A sentence with the period of the swing [s], or with advice if no swing was found."""
    period, sigma = _period(table)
    if not math.isfinite(period):
        return _sentence("no_swing")
    return _sentence("one_swing", period=plus_minus(period, sigma))


def _collisions(table: xr.Dataset, restitution: Mapping[str, Any] | None) -> list[str]:
    """Sentences about how much speed the balls keep when they collide, and where that is."""
    touching = table["flag_1"].values == "collision"
    if not restitution and not touching.any():
        return [_sentence("no_touch")]
    kept = _text(restitution["restitution"]) if restitution else ""
    effect = _sentence("clack", kept=kept) if restitution else _sentence("touch")
    angles = np.abs(table["angle_1"].values[touching]) if "angle_1" in table else np.empty(0)
    if not angles.size:
        return [effect]
    is_above = angles >= 0.5 * math.pi
    place = "met_above" if is_above.all() else "met_twice" if is_above.any() else "met_below"
    return [effect, _sentence(place)]


def _value(value: Mapping[str, Any], factor: float = 1.0) -> tuple[float, float]:
    """Return a number of a fit and its standard deviation, times a factor."""
    return value["value"] * factor, (value["sigma"] or 0.0) * factor


def _text(value: Mapping[str, Any], factor: float = 1.0) -> str:
    """Return a number of a fit and its standard deviation as a text, times a factor."""
    return plus_minus(*_value(value, factor))


def plus_minus(value: float, error: float) -> str:
    """Return a number and its uncertainty in one digit, or two from 10 to 19.

    Examples
    --------
    >>> plus_minus(0.38381, 0.0383), plus_minus(1.5, 0.0)
    ('0.38 ± 0.04', '1.5')
    """
    if not (error > 0.0 and math.isfinite(error)):
        return as_read(f"{value:.3g}")
    places = max(-math.floor(math.log10(error)) + (1 if f"{error:.0e}"[0] == "1" else 0), 0)
    return f"{as_read(f'{value:.{places}f}')} ± {error:.{places}f}"
