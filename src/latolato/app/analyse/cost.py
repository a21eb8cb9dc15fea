"""How much work a question is, and how long it takes here, from answers that were timed."""

from __future__ import annotations

import hashlib
import inspect
import math
import statistics
from collections.abc import Callable, Mapping
from typing import Any

from latolato.app.analyse.timings import Timing, timings_of
from latolato.app.run_request import TooLargeError
from latolato.figures.analyses.question import question_of

# Most steps of all motions together: minutes of work on two cores.
MOST_STEPS = 1e10
_STEPS_PER_PERIOD = 40.0
# Periods that are looked at after the transient, where no option says how many.
_WATCHED = 48.0
# With a second run at a tenth of the tolerance all motion is computed once more.
_TWICE = 2.0
# Times are predicted for answers up to so many times larger than those that were timed.
_REACH = 10.0


def check_work(function: Callable[..., Any], arguments: Mapping[str, Any]) -> None:
    """Refuse, before any work, a question that would take very long.

    Raises
    ------
    TooLargeError
        With the number of steps and the limit.
    """
    steps = steps_of(function, arguments)
    if steps > MOST_STEPS:
        raise TooLargeError(
            f"a question may take about {MOST_STEPS:.0e} steps at most",
            value=float(f"{steps:.1g}"),
            way_out="ask for fewer points, values or periods",
        )


def steps_of(function: Callable[..., Any], arguments: Mapping[str, Any]) -> float:
    """Return roughly how many steps of motion an analysis takes."""
    return motion_of(function, arguments) * _fastest(arguments) / math.tau * _STEPS_PER_PERIOD


def motion_of(function: Callable[..., Any], arguments: Mapping[str, Any]) -> float:
    """Return roughly how much motion an analysis computes, all runs together [s].

    Where no option says how long a run is, each counts as one natural period.
    """
    from latolato.scenario.analysis_options import options_of

    own, cost = options_of(function), question_of(function.__name__).cost
    known = {n: p.default for n, p in inspect.signature(function).parameters.items()}
    known |= arguments
    drive, natural = known.get("drive"), float(known["system"].natural_frequency)
    period = math.tau / float(getattr(drive, "drive_frequency", natural) or natural)

    def number(name: str, otherwise: float) -> float:
        value = known.get(name)
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        return abs(float(value)) if is_number else otherwise  # type: ignore[arg-type]

    if "transient_periods" in known:
        watched = number("periods", 3.0 * number("longest", _WATCHED / 3.0))
        span = (number("transient_periods", 0.0) + watched) * period
    elif "duration" in known:
        span = number("duration", 0.0)
    elif "settling" in known:
        span = number("settling", 0.0)
    else:
        span = math.tau / natural
    many = math.prod(max(number(name, 1.0), 1.0) for name in cost.counts)
    if "check_tolerance" in known:
        many *= _TWICE
    for name, option in own.items():
        value = known.get(name)
        if option.several and option.owner != "run" and isinstance(value, (list, tuple)):
            many *= max(len(value), 1)
        elif value is None:
            many *= cost.lengths.get(name, 1)
    return many * span


def _fastest(arguments: Mapping[str, Any]) -> float:
    """Return the fastest frequency of a motion [rad/s]."""
    drive, natural = arguments.get("drive"), float(arguments["system"].natural_frequency)
    return max(natural, float(drive.fastest_frequency) if drive is not None else 0.0)


def seconds_of(function: Callable[..., Any], arguments: Mapping[str, Any]) -> float | None:
    """Return how long an answer takes here [s], None if none of its kind and size was timed yet."""
    timed = timings_of(key_of(function, arguments))
    steps, most = steps_of(function, arguments), max((each.steps for each in timed), default=0.0)
    if steps > _REACH * most:
        return None
    # Small ones spend their time on other things than steps, and a first one on loading code.
    large = [each for each in timed if each.steps >= 0.5 * most]
    rate = statistics.median_low(each.seconds / each.steps for each in large)
    return statistics.median_low(each.rest for each in timed) + rate * steps


def timing(
    function: Callable[..., Any], arguments: Mapping[str, Any], seconds: float, rest: float
) -> tuple[str, Timing]:
    """The key of analyses like a finished one, and the timing that predicts theirs."""
    timed = Timing(steps=steps_of(function, arguments), seconds=seconds, rest=rest)
    return key_of(function, arguments), timed


def key_of(function: Callable[..., Any], arguments: Mapping[str, Any]) -> str:
    """Return under which name the times of a question are kept: the analysis, system and drive.

    Where balls chatter, a step may take ten times as long as elsewhere.
    """
    laws = repr((arguments["system"], arguments.get("drive")))
    return f"{function.__name__} {hashlib.sha256(laws.encode()).hexdigest()[:12]}"
