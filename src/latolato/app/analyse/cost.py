"""How many steps of motion a question takes, and how long."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from typing import Any

from latolato.app.run_request import TooLargeError
from latolato.figures.analyses.question import question_of

# Most steps of all motions together: minutes of work on two cores.
MOST_STEPS = 1e10
_STEPS_PER_PERIOD = 40.0
# Periods that are looked at after the transient, where no option says how many.
_WATCHED = 48.0
# How much longer a second run at a tenth of the tolerance makes the work.
_TWICE = 2.3
# Seconds that every answer takes, with its picture.
_LEAST_SECONDS = 1.0


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
    """Return roughly how many steps of motion an analysis takes, 0 if it does not say."""
    from latolato.scenario.analysis_options import options_of

    own, cost = options_of(function), question_of(function.__name__).cost
    known = {n: p.default for n, p in inspect.signature(function).parameters.items()}
    known |= arguments
    drive, system = known.get("drive"), known["system"]
    natural = float(system.natural_frequency)
    fastest = max(natural, float(drive.fastest_frequency) if drive is not None else 0.0)
    period = 2.0 * math.pi / float(getattr(drive, "drive_frequency", natural) or natural)

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
        return 0.0
    many = math.prod(max(number(name, 1.0), 1.0) for name in cost.counts)
    if "check_tolerance" in known:
        many *= _TWICE
    for name, option in own.items():
        value = known.get(name)
        if option.several and option.owner != "run" and isinstance(value, (list, tuple)):
            many *= max(len(value), 1)
        elif value is None:
            many *= cost.lengths.get(name, 1)
    return many * span * fastest / (2.0 * math.pi) * _STEPS_PER_PERIOD


def seconds_of(function: Callable[..., Any], arguments: Mapping[str, Any]) -> float:
    """Return roughly how long an answer takes [s], once its kernels are compiled."""
    rate = question_of(function.__name__).cost.steps_per_second
    return _LEAST_SECONDS + steps_of(function, arguments) / rate
