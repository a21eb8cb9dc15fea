"""What the form of an analysis is made from: its docstring, its options, texts to begin with."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from latolato.app.answers import message_of
from latolato.app.forms import described, pretty, shown_option
from latolato.app.run_request import RunRequest, options_of
from latolato.core.errors import InputError
from latolato.scenario.analysis_call import moving

if TYPE_CHECKING:
    from latolato.core.parameters import Parameter
    from latolato.scenario.scenario import Scenario

# Shares of the length between which amplitudes are scanned.
_AMPLITUDES = (0.02, 0.4)
# A parameter is scanned between these shares of its value; a frequency where resonances are.
_AROUND = (0.5, 1.5)
_RATIOS = (1.5, 3.0)
# Of two lists: a little beyond.
_WIDER = (1.4, 3.2)
# Entries of a scenario's run that an analysis is asked with here: runs to look at are too short.
OWN_RUN = ("duration",)
# Units in a text: pages show numbers in others, which stand beside them.
_UNITS = re.compile(r" \((?:m|s|1/s|rad|rad/s|rad/s or rad)\)")
# SI units in a text: an interval, which fields keep by themselves, or what a number is in.
_SI = re.compile(r", in (?:[([][^])]*[])]|the parameter's SI unit)")


@lru_cache(maxsize=1)
def forms() -> dict[str, Any]:
    """Title, texts and options of each analysis's form, by name."""
    from latolato.analysis import analyses
    from latolato.figures.plot import module_of
    from latolato.scenario.analysis_options import plain_text, summary_of
    from latolato.simulation.summary import plain

    results = {}
    for name in sorted(analyses):
        function, picture = analyses[name], module_of("analysis", name)
        notes = (inspect.getdoc(function) or "").split("\n\n")[1:2]
        own, run = own_options(function)
        results[name] = {
            "title": label_of(name),
            "summary": pretty(_UNITS.sub("", summary_of(function))),
            "notes": pretty(_UNITS.sub("", " ".join(map(plain_text, notes)))),
            "reading": getattr(picture, "READING", ""),
            "first": list(first_of(name)),
            "options": {o.name: _option(o) for o in own.values()},
            "run": list(run),
        }
    result: dict[str, Any] = plain(results)
    return result


def first_of(name: str) -> dict[str, str]:
    """Return the options that the form of an analysis shows at once, with their first texts.

    These are those named in the module of its picture, or else all that have no default.
    """
    from latolato.analysis import analyses
    from latolato.figures.plot import module_of

    own, _ = own_options(analyses[name])
    first: dict[str, str] = getattr(module_of("analysis", name), "FIRST", {})
    return first | {n: "" for n, option in own.items() if option.is_required and n not in first}


def own_options(
    function: Callable[..., Any],
) -> tuple[dict[str, Parameter], dict[str, Parameter]]:
    """Return the options that the form of an analysis asks for, and those that are of the run."""
    from latolato.scenario.analysis_options import options_of

    both = options_of(function)
    own = {n: o for n, o in both.items() if o.owner != "run" or n in OWN_RUN}
    return own, {n: o for n, o in both.items() if n not in own}


def _option(option: Parameter) -> dict[str, Any]:
    """Return how an option of an analysis is shown, and what it may be."""
    from latolato.scenario.options import law_options

    law = law_options().get(option.name)
    is_of_law = law is not None and law.owner in ("system", "drive") and not option.several
    is_from_scenario = option.is_required or is_of_law
    default = "" if is_from_scenario or option.default is None else option.default
    # A page shows one of them: an empty one where the analysis chooses.
    choices = option.choices
    if choices and option.default is None and not option.is_required:
        choices = ("", *choices)
    default = default or next(iter(choices), "")
    if isinstance(default, (tuple, list)):
        default = ", ".join(v if isinstance(v, str) else f"{v:g}" for v in default)
    description = _UNITS.sub("", _SI.sub("", option.description))
    shown = {
        "label": label_of(option.name, option.unit),
        "symbol": "",
        "description": described(description),
        "choices": list(choices),
        "labels": {each: label_of(each) for each in option.choices},
        "is_from_scenario": is_from_scenario,
        "default": f"{default:g}" if isinstance(default, float) else str(default),
        "suggested": None,
        "is_in_unit_of_parameter": bool(option.unit_of) and not option.several,
    }
    return shown_option(option) | shown


def label_of(name: str, unit: str = "") -> str:
    """The name of an option, a choice or a variable on a page; a quantity's if the units agree.

    Examples
    --------
    >>> label_of("transient_periods"), label_of("damping", "kg*m/s"), label_of("period", "1")
    ('Transient periods', 'Linear damping coefficient', 'Period')
    """
    from latolato.core.quantities import QUANTITIES

    known = QUANTITIES.get(name)
    text: str = known.long_name if known and known.unit == unit else name.replace("_", " ")
    return pretty(f"{text[:1].upper()}{text[1:]}")


def about_request(request: RunRequest) -> dict[str, Any]:
    """Return the options of what a page asks for, and with which texts the forms begin."""
    from latolato.analysis import analyses
    from latolato.simulation.summary import plain

    scenario = request.to_scenario()
    result: dict[str, Any] = plain(
        {
            "options": options_of(scenario),
            "title": scenario.title,
            "titles": {name: label_of(name) for name in analyses},
            "refused": refusals(scenario),
            "first": first_texts(scenario),
            "parameters": parameters_of(scenario),
        }
    )
    return result


def refusals(scenario: Scenario) -> dict[str, dict[str, Any]]:
    """Return why analyses cannot treat the system and the drive of a scenario, by their names."""
    from latolato.analysis import analyses

    laws = {"system": scenario.system, "drive": moving(scenario)}
    result = {}
    for name in analyses:
        try:
            analyses.check(name, laws)
        except InputError as error:
            result[name] = message_of(error)
    return result


def first_texts(scenario: Scenario) -> dict[str, dict[str, str]]:
    """Return the texts with which the form of each analysis begins, by option."""
    from latolato.analysis import analyses

    ratios, amplitudes = _ratios_of(scenario, _WIDER), _amplitudes_of(scenario)
    ranges = {
        "ratios": "{:.3g} : {:.3g}".format(*ratios),
        "amplitudes": "{:.3g} : {:.3g}".format(*amplitudes),
        "corner_low": f"0, {ratios[0]:.3g}",
        "corner_high": f"{amplitudes[1]:.3g}, {ratios[1]:.3g}",
    }
    known = parameters_of(scenario)
    result = {}
    for name in analyses:
        own, _ = own_options(analyses[name])
        texts = {option: text.format(**ranges) for option, text in first_of(name).items() if text}
        limits = known.get(texts.get("parameter", ""))
        if limits:
            texts |= {end: limits[end] for end in ("low", "high") if end in own}
        result[name] = texts
    return result


def _ratios_of(scenario: Scenario, usual: tuple[float, float]) -> tuple[float, float]:
    """Return the usual range of driving over natural frequency, or one about the scenario's."""
    drive = scenario.drive
    frequency = float(getattr(drive, "drive_frequency", 0.0) or 0.0)
    ratio = frequency / float(scenario.system.natural_frequency)
    if ratio == 0.0 or usual[0] <= ratio <= usual[1]:
        return usual
    return _AROUND[0] * ratio, _AROUND[1] * ratio


def _amplitudes_of(scenario: Scenario) -> tuple[float, float]:
    """Return the amplitudes [m] of a map, with that of the drive."""
    l = scenario.system.balls[0].length
    amplitude = float(getattr(scenario.drive, "drive_amplitude", 0.0) or 0.0)
    return _AMPLITUDES[0] * l, max(_AMPLITUDES[1] * l, _AROUND[1] * amplitude)


def parameters_of(scenario: Scenario) -> dict[str, dict[str, Any]]:
    """Return the numbers that a diagram can vary: what they may be, and usual limits [SI]."""
    from latolato.analysis.flow import value_of
    from latolato.simulation import vary

    if not scenario.drive.moves:
        return {}
    result = {}
    for name, parameter in vary.parameters_of(scenario.system, scenario.drive).items():
        if parameter.owner not in ("system", "drive"):
            continue
        try:
            value = float(value_of(scenario.system, scenario.drive, name))
        except InputError:
            continue
        allowed = parameter.allowed
        ends = (min(max(share * value, allowed.low), allowed.high) for share in _AROUND)
        low, high = (f"{end:.4g}" for end in ends)
        if name == "frequency_ratio":
            low, high = (f"{end:.4g}" for end in _ratios_of(scenario, _RATIOS))
        shown = shown_option(parameter)
        result[name] = {
            "label": label_of(name, parameter.unit),
            "shown": {each: shown[each] for each in ("unit", "units", "limits")},
            "low": "0" if value == 0.0 else low,
            "high": "0.1" if value == 0.0 else high,
        }
    return result
