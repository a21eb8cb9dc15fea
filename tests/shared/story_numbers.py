"""Numbers of stories and scores of challenges in Python: what pages compute, once more."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.linear import linearised, threshold
from latolato.app.run_request import RunRequest, options_of
from latolato.app.runs import USUAL_SAMPLES, arrays_of, sampled, scenario_of
from latolato.app.stories import SCHEMA
from latolato.physics.drives import PeriodicDrive
from latolato.physics.pendulum import Pendulum
from latolato.scenario.scenario import ALTERNATIVES, Scenario
from latolato.scenario.units import to_si

Tables = Mapping[str, Any]

# Samples from here on show how a motion has settled.
_LATE = 0.75
# Up to this angle a swing grows as the small-angle equation does [rad].
_SMALL = math.radians(20.0)


class Run(NamedTuple):
    """What numbers are made of.

    Attributes
    ----------
    time : array (time,)
        Instants [s].
    angle : array (ball, time)
        Angles [rad].
    contact_time, contact_kind : array (contact,)
        Instants [s] and names of contacts.
    strobe : array (period,)
        Instants at which the drive begins a period [s].
    has_moving_pivot : bool
        Whether the drive moves the pivot at all.
    options : mapping
        All options [SI].
    scenario : Scenario
        What was run.
    """

    time: NDArray[np.float64]
    angle: NDArray[np.float64]
    contact_time: NDArray[np.float64]
    contact_kind: list[str]
    strobe: NDArray[np.float64]
    has_moving_pivot: bool
    options: Mapping[str, Any]
    scenario: Scenario


def run_of(preset: str, options: Mapping[str, Any]) -> Run:
    """Return the run that a page shows for a preset and options."""
    scenario: Scenario = scenario_of(RunRequest(preset, options))
    record = scenario.record(**sampled(scenario, USUAL_SAMPLES))
    arrays = arrays_of(scenario, record, ["angle", "pivot_height", "pivot_across"])
    pivot = [arrays[name] for name in ("pivot_height", "pivot_across") if name in arrays]
    return Run(
        time=arrays["time"],
        angle=arrays["angle"],
        contact_time=arrays["contact_time"],
        contact_kind=[str(kind) for kind in np.asarray(record["contact_kind"])],
        strobe=arrays["strobe"],
        has_moving_pivot=any(np.ptp(each) > 0.0 for each in pivot),
        options=options_of(scenario),
        scenario=scenario,
    )


def quantity(name: str, run: Run, angle: float = math.nan) -> float:
    """Return a quantity of a run [SI]: nan where the run has none, as for what never happens.

    Parameters
    ----------
    name : str
        One of the quantities in ``schema.json``.
    run : Run
        What moves.
    angle : float
        For `time_to_angle`, which angle [rad].
    """
    return float(_QUANTITIES[name](run, angle))


def _largest_angle(run: Run, _: float) -> Any:
    return np.abs(run.angle).max()


def _late_angle(run: Run, _: float) -> Any:
    return np.abs(run.angle[:, run.time >= _LATE * run.time[-1]]).max()


def _time_to_angle(run: Run, angle: float) -> Any:
    """Return when the first ball first reaches an angle, linear between samples [s]."""
    size = np.abs(run.angle[0])
    after = int(np.argmax(size >= angle))
    if size[after] < angle or after == 0:
        return 0.0 if size[after] >= angle else math.nan
    share = (angle - size[after - 1]) / (size[after] - size[after - 1])
    return run.time[after - 1] + share * (run.time[after] - run.time[after - 1])


def _top_time(run: Run, _: float) -> Any:
    tops = (
        time for time, kind in zip(run.contact_time, run.contact_kind, strict=True) if kind == "top"
    )
    return next(tops, math.nan)


def _contacts(run: Run, _: float) -> Any:
    return sum(kind in ("bottom", "top") for kind in run.contact_kind)


def _swing_period(run: Run, _: float) -> Any:
    """Return the mean time between passages upwards through zero, in the second half [s]."""
    late = run.time >= 0.5 * run.time[-1]
    time, angle = run.time[late], run.angle[0, late]
    before = np.flatnonzero((angle[:-1] < 0.0) & (angle[1:] >= 0.0))
    if len(before) < 2:
        return math.nan
    i = before[[0, -1]]
    first, last = time[i] - angle[i] * (time[i + 1] - time[i]) / (angle[i + 1] - angle[i])
    return (last - first) / (len(before) - 1)


def _response_period(run: Run, _: float) -> Any:
    """Return the value of an observable at one point of a map, for two balls the right one's."""
    system, drive = run.scenario.system, run.scenario.drive
    if not isinstance(drive, PeriodicDrive):
        return math.nan
    point = {"axes": {"gravity": [system.gravity]}, "observables": ["response_period"]}
    return replace(run.scenario, varied=point).sweep()["response_period"].values.flat[0]


def _growth_rate(run: Run, _: float) -> Any:
    """Return the slope of the logarithm of the peaks up to the first that is not small [1/s].

    Of these peaks the later half counts: what dies away has gone by then.
    """
    size = np.abs(run.angle[0])
    peaks = 1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:]))
    large = np.flatnonzero(size[peaks] > _SMALL)
    peaks = peaks[: large[0]] if len(large) else peaks
    peaks = peaks[len(peaks) // 2 :]
    if len(peaks) < 2:
        return math.nan
    return np.polyfit(run.time[peaks], np.log(size[peaks]), 1)[0]


def _fastest_drive(run: Run) -> float:
    """Return the largest angular frequency of the drive [rad/s]."""
    options = run.options
    return float(np.max(options.get("drive_frequencies", options.get("drive_frequency", math.nan))))


def _shakes_per_swing(run: Run, _: float) -> Any:
    if not run.has_moving_pivot:
        return math.nan
    return _swing_period(run, _) * _fastest_drive(run) / math.tau


def _drive_speed(run: Run, _: float) -> Any:
    return run.options.get("drive_amplitude", math.nan) * _fastest_drive(run)


def _drive_acceleration_ratio(run: Run, _: float) -> Any:
    return _drive_speed(run, _) * _fastest_drive(run) / run.options["gravity"]


_QUANTITIES: dict[str, Callable[[Run, float], Any]] = {
    "largest_angle": _largest_angle,
    "late_angle": _late_angle,
    "final_angle": lambda run, _: run.angle[0, -1],
    "farthest_from_top": lambda run, _: np.abs(math.pi - np.abs(run.angle)).max(),
    "time_to_angle": _time_to_angle,
    "top_time": _top_time,
    "contacts": _contacts,
    "top_contacts": lambda run, _: run.contact_kind.count("top"),
    "swing_period": _swing_period,
    "shakes_per_swing": _shakes_per_swing,
    "response_period": _response_period,
    "growth_rate": _growth_rate,
    "drive_speed": _drive_speed,
    "drive_acceleration_ratio": _drive_acceleration_ratio,
}


class Score(NamedTuple):
    """What somebody reached in a challenge; less is better.

    Attributes
    ----------
    value : float
        The score [SI], nan if the goal was not reached.
    unit : str
        Its unit.
    beats_par : bool
        Whether it is at least as good as the challenge asks for.
    """

    value: float
    unit: str
    beats_par: bool


def score(challenge: Tables, options: Mapping[str, Any]) -> Score:
    """Return the score of a challenge.

    Parameters
    ----------
    challenge : mapping
        The tables of its file.
    options : mapping
        The options that the player chose, as texts; what the challenge does not leave free counts
        not. For ``guess_tongue`` the entry ``guess`` holds one amplitude for each ratio, such as
        ``"30 mm, 12 mm"``.
    """
    task, look = challenge["task"], challenge["look"]
    free = {name: options[name] for name in task["free"] if name in options}
    given = {**_without(look.get("options", {}), free), **free}
    rule, unit = task["rule"], SCHEMA["rules"][task["rule"]]
    if rule == "guess_tongue":
        value = _distance_from_tongue(options["guess"], task["ratios"], look["preset"], given)
    elif rule == "least_amplitude":
        value = _least_amplitude(run_of(look["preset"], given))
    else:
        angle = to_si("angle", task["angle"], "rad")
        value = quantity("time_to_angle", run_of(look["preset"], given), angle)
    return Score(value, unit, value <= to_si("par", task["par"], unit))


def _without(options: Tables, replaced: Tables) -> dict[str, Any]:
    """Return the options that are not said in another way by those that replace them."""
    gone = {name for group in ALTERNATIVES for name in group if group & replaced.keys()}
    return {name: value for name, value in options.items() if name not in gone}


def _least_amplitude(run: Run) -> float:
    """Return the amplitude of a run that reaches the top [m]."""
    reached = "top" in run.contact_kind
    return float(run.options["drive_amplitude"]) if reached else math.nan


def _distance_from_tongue(guess: str, ratios: list[float], preset: str, options: Tables) -> float:
    """Return how far guesses are on average from where parametric resonance begins [m]."""
    guesses = [to_si("guess", part.strip(), "m") for part in guess.split(",")]
    system = RunRequest(preset, options).to_scenario().system
    [ball] = system.balls
    pendulum = Pendulum(
        length=ball.length, mass=ball.mass, damping=ball.damping, gravity=system.gravity
    )
    problem = linearised(pendulum, None)
    edges = [threshold(problem, ratio, ball.length, None) for ratio in ratios]
    return float(np.mean(np.abs(np.subtract(guesses, edges))))
