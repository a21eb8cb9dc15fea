"""The request for a run: flat options with units, and the scenario that they stand for.

A page, its URL, the command line and the Python lines on show all use the names and the texts of
`latolato.scenario.options`: ``{"length": "24.5 cm", "drive_frequency": "2.4 Hz"}``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from latolato.core.errors import InputError
from latolato.core.parameters import Parameter
from latolato.core.registry import suggest
from latolato.core.rules import broken_rule
from latolato.numerics.integrate import choose_step
from latolato.scenario.options import changes, flat_options, law_options
from latolato.scenario.scenario import Scenario, changed_scenario, changed_tables, shipped
from latolato.simulation.start import checked_contact, checked_start

# Steps of one run; a second or two of work.
MOST_STEPS = 5_000_000
MOST_SECONDS = 1e5
MOST_SAMPLES = 200_000
_SWITCH = {"true": True, "false": False}
_WHOLE = re.compile(r"\s*[-+]?\d{1,18}\s*")


class TooLargeError(InputError):
    """A request that would keep the machine busy for too long, or need too much memory."""


@dataclass(frozen=True)
class RunRequest:
    """A scenario to begin with, if any, and the options that replace what it says."""

    scenario: str | None = None
    options: Mapping[str, Any] | None = None

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> RunRequest:
        """Return the request of a page: ``{"scenario": name, "options": {name: value}}``."""
        return cls(value.get("scenario") or None, value.get("options") or {})

    def to_scenario(self) -> Scenario:
        """Return the scenario; no file but those that are shipped is read.

        Raises
        ------
        InputError
            For unknown names, wrong types, units and values.
        """
        known = law_options()
        given: dict[str, Any] = {}
        for name, value in (self.options or {}).items():
            if name not in known:
                hint = suggest(name, list(known))
                raise broken_rule("unknown", {"kind": "option", "name": name, "hint": hint})
            given[name] = option_value(known[name], value)
        path = None
        if self.scenario is not None:
            if self.scenario not in shipped():
                hint = suggest(self.scenario, list(shipped()))
                raise broken_rule("unknown_scenario", {"name": self.scenario, "hint": hint})
            path = shipped()[self.scenario]
        return changed_scenario(path, changed_tables(path, changes(given)))


def option_value(option: Parameter, value: Any) -> Any:
    """Return the value of an option; a list stays one, so that a text never names a file."""
    name = option.name
    if isinstance(value, str) and option.kind is bool:
        return _SWITCH.get(value.strip().lower(), value)
    if isinstance(value, str) and option.kind is int and _WHOLE.fullmatch(value):
        return int(value)
    if option.several and isinstance(value, str):
        value = [part.strip() for part in value.split(",") if part.strip()]
    if isinstance(value, Sequence) and not isinstance(value, str):
        if not all(isinstance(part, (str, int, float)) for part in value):
            raise broken_rule("quantities", parameter=name)
        return list(value)
    if value is not None and not isinstance(value, (str, int, float, bool)):
        raise broken_rule("text_or_number", parameter=name, value=value)
    return value


def options_of(scenario: Scenario) -> dict[str, Any]:
    """Return every option that a scenario sets, in SI units."""
    return flat_options(scenario.to_dict())


def check_size(scenario: Scenario) -> None:
    """Refuse, before any work, a run that would take more than seconds.

    Raises
    ------
    TooLargeError
        With the number of steps and the limit.
    """
    run = scenario.run
    times = run.get("times")
    if times and len(times) > MOST_SAMPLES:
        raise TooLargeError(f"a run here has at most {MOST_SAMPLES} samples", value=len(times))
    end = float(run.get("duration") or (times[-1] if times else 0.0))
    if end > MOST_SECONDS:
        raise TooLargeError(
            f"must not exceed {MOST_SECONDS:g} s here", parameter="duration", value=end
        )
    system, drive = scenario.system, scenario.drive
    start = checked_start(
        system,
        checked_contact(run.get("contact", "exact"), system),
        run.get("initial_angle"),
        run.get("initial_angular_velocity", 0.0),
        run.get("initial_offset"),
        run.get("initial_distance"),
    )
    tolerance = float(run.get("tolerance", 1e-10))
    step = choose_step(system, drive, start, tolerance)
    steps = end / step
    if not math.isfinite(steps) or steps > MOST_STEPS:
        raise TooLargeError(
            f"a run here may take at most {MOST_STEPS:g} steps",
            value=float(f"{steps:.2g}"),
            way_out="shorten the duration, loosen the tolerance or slow the drive",
        )
