"""What the forms of analyses are made from: options, their words, and sizes to begin with."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from latolato.app.analyse.words import OPTION_WORDS
from latolato.app.forms import units_of
from latolato.app.run_request import RunRequest, options_of
from latolato.core.errors import InputError
from latolato.figures.analyses.question import Cost, all_questions

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
# Motion has settled after so many decay times.
_SETTLED = 8.0
# Along a branch each motion begins near where it ends.
_NEAR = 1.5
# The longest run that is proposed [s].
_LONGEST_RUN = 3000
# Entries of a scenario's run that an analysis is asked with here: runs to look at are too short.
OWN_RUN = ("duration",)
# Names of parameters in a text.
_NAMES = re.compile(r"\b[a-z]+(?:_[a-z]+)+\b")
# An interval of SI units in a text; fields keep it by themselves.
_INTERVAL = re.compile(r", in [([][^])]*[])]")
_LETTERS = {"w/w0": "ω/ω₀", "w0": "ω₀", "A0": "A₀", "-pi to pi": "-180° to 180°"}


@lru_cache(maxsize=1)
def forms() -> dict[str, Any]:
    """Title, texts and options of each analysis's form, by name, group after group."""
    from latolato.analysis import analyses
    from latolato.scenario.analysis_options import plain_text, summary_of
    from latolato.simulation.summary import plain

    results = {}
    for name, question in all_questions().items():
        function = analyses[name]
        notes = (inspect.getdoc(function) or "").split("\n\n")[1:2]
        own, run = own_options(function)
        results[name] = {
            "title": question.title,
            "group": question.group,
            "term": question.term,
            "reading": question.reading,
            "first": question.first,
            "summary": pretty(summary_of(function)),
            "notes": pretty(" ".join(map(plain_text, notes))),
            "options": {o.name: _option(o) for o in own.values()},
            "run": list(run),
        }
    result: dict[str, Any] = plain(results)
    return result


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
    default = "" if option.is_required or option.default is None else option.default
    if isinstance(default, (tuple, list)):
        default = ", ".join(f"{value:g}" for value in default)
    description = _INTERVAL.sub("", option.description)
    return {
        "label": label_of(option.name),
        "description": pretty(_NAMES.sub(lambda n: label_of(n[0]).lower(), description)),
        "unit": option.unit,
        "units": None if option.unit_of else units_of(option.quantity),
        "limits": [asdict(limit) for limit in option.limits],
        "whole": option.kind is int,
        "kind": option.kind.__name__,
        "several": option.several,
        "required": option.is_required,
        "default": f"{default:g}" if isinstance(default, float) else str(default),
        "choices": {each: label_of(each) for each in option.choices},
    }


@lru_cache(maxsize=1)
def option_words() -> dict[str, str]:
    """Return the labels of options that are no quantities."""
    own = [question.labels for question in all_questions().values()]
    return OPTION_WORDS | {name: text for labels in own for name, text in labels.items()}


def label_of(name: str) -> str:
    """The name of an option, a choice or a variable on a page.

    Examples
    --------
    >>> label_of("transient_periods"), label_of("damping"), label_of("inverted")
    ('Shakes to leave out at the beginning', 'Linear damping coefficient', 'Inverted')
    """
    from latolato.core.quantities import QUANTITIES

    known = QUANTITIES.get(name)
    text: str = option_words().get(name) or (known.long_name if known else name.replace("_", " "))
    return f"{text[:1].upper()}{text[1:]}"


def pretty(text: str) -> str:
    """Return a text of a docstring with frequencies, amplitudes and angles as a page writes them.

    Examples
    --------
    >>> pretty("w/w0 of A0, by default 3 w0")
    'ω/ω₀ of A₀, by default 3 ω₀'
    """
    for plain, pretty in _LETTERS.items():
        text = re.sub(rf"(?<![\w/]){plain}(?!\w)", pretty, text)
    return text


def about_request(request: RunRequest) -> dict[str, Any]:
    """Return the options of what a page asks for, and what can be asked of it."""
    from latolato.simulation.summary import plain

    scenario = request.to_scenario()
    of = (scenario.system, scenario.drive)
    unfit = {name: why for name, each in all_questions().items() if (why := each.unfit(*of))}
    result: dict[str, Any] = plain(
        {
            "options": options_of(scenario),
            "title": scenario.title,
            "quick": quick_of(scenario),
            "parameters": parameters_of(scenario),
            "unfit": unfit,
            "first": _first(scenario, unfit),
        }
    )
    return result


def _first(scenario: Scenario, unfit: Mapping[str, str]) -> str:
    """Return the question that says most about a system and a drive and is answered quickly."""
    standing = ("inverted_limits",) if _stands(scenario) and "inverted_limits" not in unfit else ()
    order = (*standing, "bifurcation_diagram", "lyapunov_spectrum")
    result: str = next(name for name in order if name not in unfit)
    return result


def _stands(scenario: Scenario) -> bool:
    """Return whether one ball starts in the upper half, where it could stand upright."""
    start = scenario.run.get("initial_angle")
    if not isinstance(start, (int, float)) or scenario.system.has_contacts:
        return False
    return abs(start) > 0.5 * math.pi


def quick_of(scenario: Scenario) -> dict[str, dict[str, str]]:
    """First values of each analysis's options, as texts, with which it takes seconds."""
    from latolato.analysis import analyses

    ranges = {
        name: f"{low:.3g} : {high:.3g}"
        for name, (low, high) in (
            ("ratios", _ratios_of(scenario, _WIDER)),
            ("amplitudes", _amplitudes_of(scenario)),
        )
    }
    known = parameters_of(scenario)
    result = {}
    for name, question in all_questions().items():
        own, _ = own_options(analyses[name])
        texts = {option: text.format(**ranges) for option, text in question.quick.items()}
        limits = known.get(texts.get("parameter", ""))
        if limits:
            texts |= {end: limits[end] for end in ("low", "high") if end in own}
        texts |= _settled(question.cost, scenario, own, texts)
        result[name] = {option: text for option, text in texts.items() if option in own}
    if _stands(scenario):
        result["growth_rate"]["position"] = "inverted"
    return result


def _settled(
    cost: Cost, scenario: Scenario, own: Mapping[str, Parameter], texts: Mapping[str, str]
) -> dict[str, str]:
    """Return times in which motion settles, for analyses whose usual ones are too short for it."""
    ball = scenario.system.balls[0]
    rate = float(getattr(ball, "damping", 0.0)) / (2.0 * ball.mass * ball.length)
    if rate <= 0.0:
        return {}
    result = {}
    frequency = float(getattr(scenario.drive, "drive_frequency", 0.0) or 0.0)
    if cost.most_shakes and frequency > 0.0:
        times = _NEAR if "parameter" in own else _SETTLED
        shakes = times / rate * frequency / math.tau
        default = float(own["transient_periods"].default or 0.0)
        if shakes > default:
            result["transient_periods"] = f"{min(math.ceil(shakes / 100) * 100, cost.most_shakes)}"
    if cost.decay_times and "duration" in texts:
        least = cost.decay_times / rate
        if least > float(texts["duration"]):
            result["duration"] = f"{min(math.ceil(least / 10) * 10, _LONGEST_RUN)}"
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
    """Return the numbers that a diagram can vary: what they are, their units, usual limits [SI]."""
    from latolato.analysis.flow import value_of
    from latolato.sweeps import axes

    if not scenario.drive.moves:
        return {}
    result = {}
    for name, parameter in axes.parameters_of(scenario.system, scenario.drive).items():
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
        result[name] = {
            "label": label_of(name),
            "units": units_of(parameter.quantity),
            "low": "0" if value == 0.0 else low,
            "high": "0.1" if value == 0.0 else high,
        }
    return result
