"""What the forms of analyses are made from: options, their words, and sizes to begin with."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from latolato.app.given import Asked, options_of

if TYPE_CHECKING:
    from latolato.analyse_options import AnalysisOption
    from latolato.scenario import Scenario

# What a list of analyses begins with; the others follow by name.
FIRST = (
    "response_period",
    "lyapunov_spectrum",
    "poincare_section",
    "bifurcation_diagram",
    "basins",
    "first_push",
)
# What forms begin with: sizes that take seconds, where defaults are for a machine left alone.
QUICK = {
    "points": "41",
    "angle_points": "40",
    "velocity_points": "40",
    "trajectories": "100",
    "scan_points": "30",
    "noise_strength": "0.5 rad/s^(3/2)",
    "drive_amplitude": "{low:.3g} : {high:.3g} : 16 m",
    "frequency_ratio": "1.4 : 3.2 : 16",
    "parameter": "frequency_ratio",
}
# Shares of the length between which amplitudes are scanned.
_AMPLITUDES = (0.02, 0.4)
# A parameter is scanned between these shares of its value; a frequency where resonances are.
_AROUND = (0.5, 1.5)
_RATIOS = ("1.5", "3")
_CHOICES = re.compile(r"^(?P<names>[a-z_, ]+) : \{(?P<choices>[^}]*)\}", re.M)
_LETTERS = {"w/w0": "ω/ω₀", "w0": "ω₀", "A0": "A₀"}


@lru_cache(maxsize=1)
def forms() -> dict[str, Any]:
    """Return what the form of each analysis is made from, by name."""
    from latolato.analyse_options import options_of, plain_text, summary_of
    from latolato.analysis import analyses
    from latolato.summary import plain

    rest = sorted(name for name in analyses if name not in FIRST)
    found = {}
    for name in [*FIRST, *rest]:
        function = analyses[name]
        choices = choices_of(function)
        notes = (inspect.getdoc(function) or "").split("\n\n")[1:2]
        found[name] = {
            "title": name.replace("_", " ").capitalize(),
            "summary": shown(summary_of(function)),
            "notes": shown(" ".join(map(plain_text, notes))),
            "options": {
                option.name: _option(option, choices.get(option.name, ()))
                for option in options_of(function).values()
                if not option.is_of_run
            },
            "run": [o.name for o in options_of(function).values() if o.is_of_run],
        }
    result: dict[str, Any] = plain(found)
    return result


def _option(option: AnalysisOption, choices: Sequence[str]) -> dict[str, Any]:
    """Return how an option of an analysis is shown."""
    from latolato.figures.style import pretty_unit

    default = "" if option.is_required or option.default is None else option.default
    if isinstance(default, (tuple, list)):
        default = ", ".join(f"{value:g}" for value in default)
    return {
        "label": option.name.replace("_", " "),
        "description": shown(option.description),
        "unit": "" if option.unit in ("", "1") else option.unit and pretty_unit(option.unit),
        "kind": option.kind.__name__,
        "several": option.is_sequence,
        "required": option.is_required,
        "default": f"{default:g}" if isinstance(default, float) else str(default),
        "choices": list(choices),
    }


def shown(text: str) -> str:
    """Return a text of a docstring with frequencies and amplitudes as a page writes them.

    Examples
    --------
    >>> shown("w/w0 of A0, by default 3 w0")
    'ω/ω₀ of A₀, by default 3 ω₀'
    """
    for plain, pretty in _LETTERS.items():
        text = re.sub(rf"(?<![\w/]){plain}(?!\w)", pretty, text)
    return text


def choices_of(function: Callable[..., Any]) -> dict[str, list[str]]:
    r"""Return the texts that parameters may be, by the type in their docstring.

    Examples
    --------
    >>> from latolato.analysis import growth_rate
    >>> choices_of(growth_rate)["position"]
    ['hanging', 'inverted']
    """
    found: dict[str, list[str]] = {}
    for match in _CHOICES.finditer(inspect.getdoc(function) or ""):
        choices = [part.strip().strip("\"'") for part in match["choices"].split(",")]
        found |= dict.fromkeys([name.strip() for name in match["names"].split(",")], choices)
    return found


def about_asked(asked: Asked) -> dict[str, Any]:
    """Return the options of what a page asks for, and what analyses may vary of it."""
    from latolato.summary import plain

    scenario = asked.to_scenario()
    l = scenario.system.balls[0].length
    low, high = (share * l for share in _AMPLITUDES)
    quick = {name: text.format(low=low, high=high) for name, text in QUICK.items()}
    found: dict[str, Any] = plain(
        {
            "options": options_of(scenario),
            "title": scenario.title,
            "quick": quick,
            "parameters": parameters_of(scenario),
        }
    )
    return found


def parameters_of(scenario: Scenario) -> dict[str, dict[str, str]]:
    """Return the numbers that a diagram can vary: what they are, their unit, and usual limits."""
    from latolato.analysis.flow import value_of
    from latolato.figures.style import pretty_unit
    from latolato.physics.drives import Static
    from latolato.sweep import axes

    if isinstance(scenario.drive, Static):
        return {}
    found = {}
    for name, parameter in axes.parameters_of(scenario.system, scenario.drive).items():
        if parameter.owner not in ("system", "drive"):
            continue
        try:
            value = float(value_of(scenario.system, scenario.drive, name))
        except (TypeError, ValueError, AttributeError):
            continue
        unit = parameter.quantity.unit
        allowed = parameter.allowed
        ends = (min(max(share * value, allowed.low), allowed.high) for share in _AROUND)
        low, high = (f"{end:.4g}" for end in ends)
        if name == "frequency_ratio":
            low, high = _RATIOS
        tail = "" if unit in ("", "1") else f" {unit}"
        found[name] = {
            "label": parameter.quantity.long_name,
            "unit": "" if unit == "1" else pretty_unit(unit),
            "low": "0" if value == 0.0 else f"{low}{tail}",
            "high": f"0.1{tail}" if value == 0.0 else f"{high}{tail}",
        }
    return found
