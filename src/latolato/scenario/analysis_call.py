"""What a scenario and options make of the arguments of an analysis."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

from latolato.core.errors import InputError
from latolato.core.quantities import in_brackets
from latolato.core.rules import sentence
from latolato.scenario.analysis_options import read_value
from latolato.scenario.units import to_si

if TYPE_CHECKING:
    from latolato.core.parameters import Parameter
    from latolato.scenario.scenario import Scenario

# Entries of ``[sweep]`` that an analysis may take as well.
_OF_SWEEP = ("transient", "transient_periods")
Tables = dict[str, Any]


def unfit_options(function: Callable[..., Any], own: Mapping[str, Any]) -> list[str]:
    """Return the options of laws and runs that the command of an analysis does not take."""
    from latolato.scenario.options import law_options

    has_drive = "drive" in inspect.signature(function).parameters
    return [
        option.name
        for option in law_options().values()
        if option.name in own
        or option.owner in ("run", "noise")
        or (option.owner == "drive" and not has_drive)
    ]


@dataclass(frozen=True)
class AnalysisCall:
    """An analysis with its options, and the arguments that it is called with."""

    name: str
    function: Callable[..., Any]
    own: Mapping[str, Parameter]

    def arguments(
        self, source: str | None, values: Mapping[str, Any], tables: Tables | None = None
    ) -> dict[str, Any]:
        """Return the arguments that a scenario, by its name or its tables, and options give."""
        from latolato.core.registry import describe

        scenario, sweep = self._scenario(source, values, tables)
        drive = moving(scenario)
        result: dict[str, Any] = {"system": scenario.system}
        if "drive" in inspect.signature(self.function).parameters:
            result["drive"] = drive
        run = dict(scenario.run)
        noise = run.get("noise")
        kicks = describe(noise) if noise is not None else {}
        if "times" in run:
            run.setdefault("duration", run["times"][-1])
        for name, option in self.own.items():
            if option.owner == "run":
                if name in run:
                    result[name] = run[name]
            elif values.get(name) is not None:
                result[name] = self._value(option, values, scenario)
            elif name in kicks:
                result[name] = kicks[name]
            elif name in sweep:
                result[name] = read_value(option, sweep[name])
            elif (given := _of_laws(option, scenario)) is not None:
                result[name] = given
            elif option.is_required:
                raise _missing(option)
        self._tell_left_out(scenario)
        return result

    def _scenario(
        self, source: str | None, values: Mapping[str, Any], tables: Tables | None
    ) -> tuple[Scenario, Mapping[str, Any]]:
        """Return the scenario with the options put in, and what of ``[sweep]`` sets its run."""
        from latolato.physics.pendulum import systems
        from latolato.scenario.options import changes
        from latolato.scenario.scenario import changed_scenario, changed_tables, find

        kept = {k: v for k, v in values.items() if k not in self.own or self.own[k].owner == "run"}
        changed = changes(kept)
        path = find(source) if source is not None else None
        if path is None and tables is None and "kind" not in changed.get("system", {}):
            raise InputError(
                "name what to analyse: a scenario (`latolato scenarios` lists them), a TOML file, "
                f"the file of a run, or --system with one of {', '.join(systems)}"
            )
        tables = changed_tables(path, changed, tables)
        sweep = dict(tables.pop("sweep", {}))
        run = {k: v for k, v in tables.get("run", {}).items() if k not in ("samples", "frame")}
        tables["run"] = {k: sweep[k] for k in ("duration", "tolerance") if k in sweep} | run
        for name, option in self.own.items():
            if values.get(name) is not None and option.owner != "run":
                _set_law(tables, option, values[name])
        scenario = changed_scenario(path, tables)
        return scenario, {k: v for k, v in sweep.items() if k in _OF_SWEEP}

    def _value(self, option: Parameter, values: Mapping[str, Any], scenario: Scenario) -> Any:
        """Return the argument of an option; its unit may be that of what another option names."""
        value = values[option.name]
        if not option.unit_of:
            return read_value(option, value)
        from latolato.analysis.registry import quantity_named

        naming = self.own[option.unit_of]
        given = values.get(naming.name)
        named = naming.default if given is None else read_value(naming, given)

        def unit_of(name: str) -> str:
            return quantity_named(name, scenario.system, moving(scenario)).unit

        if not option.several:
            return read_value(option, value, unit_of(named))
        texts = value if isinstance(value, (list, tuple)) else str(value).split(",")
        if len(texts) != len(named):
            return read_value(option, value)
        return [
            to_si(f"{option.name} ({name})", text, unit_of(name))
            for name, text in zip(named, texts, strict=True)
        ]

    def _tell_left_out(self, scenario: Scenario) -> None:
        """Warn of laws of a scenario that the analysis does not know."""
        from latolato.physics.contacts import ContactLaw, contact_laws

        law = scenario.run.get("contact")
        if isinstance(law, ContactLaw) and "contact" not in self.own:
            kind = contact_laws.name_of(law)
            warnings.warn(
                f"the scenario's contact '{kind}' is left out: {self.name} uses exact contact",
                RuntimeWarning,
                stacklevel=2,
            )
        if scenario.run.get("noise") is not None and "noise_strength" not in self.own:
            warnings.warn(
                f"the scenario's noise is left out: {self.name} analyses the motion without it",
                RuntimeWarning,
                stacklevel=2,
            )


def moving(scenario: Scenario) -> Any:
    """Return the drive of a scenario, None for a pivot at rest."""
    return scenario.drive if scenario.drive.moves else None


def _set_law(tables: Tables, option: Parameter, value: Any) -> None:
    """Put the value of an option into the law of that name too, if the scenario has it.

    Of several values the first one stands there where the law has none: the analysis varies it.
    """
    from latolato.physics.drives import drives
    from latolato.physics.pendulum import systems
    from latolato.scenario.options import law_options
    from latolato.scenario.scenario import overridden
    from latolato.scenario.tables import RATIOS

    law = law_options().get(option.name)
    if law is None or len(law.path) != 1 or law.owner not in ("system", "drive"):
        return
    part = law.owner
    kind = tables.get(part, {}).get("kind")
    registry: Any = systems if part == "system" else drives
    target = RATIOS.get(option.name, option.name)
    if kind not in registry or target not in {f.name for f in fields(registry[kind])}:
        return
    if not option.several:
        tables |= overridden(tables, {part: {option.name: value}})
        return
    names = {target, *(ratio for ratio, plain in RATIOS.items() if plain == target)}
    if not names & tables[part].keys():
        tables[part] = {**tables[part], option.name: read_value(option, value)[0]}


def axes_of(source: str | None) -> list[str]:
    """Return the names that a scenario varies, none if it cannot be read."""
    from latolato.scenario.scenario import find, read_tables

    try:
        tables = read_tables(find(source)) if source is not None else {}
    except (OSError, InputError):
        return []
    sweep = tables.get("sweep", {})
    return list(sweep.get("axes", {})) if isinstance(sweep, Mapping) else []


def _of_laws(option: Parameter, scenario: Scenario) -> float | None:
    """Return the value that the laws of a scenario give an option of one number, if they do.

    An answer at one frequency, say, is for that of the drive.
    """
    from latolato.analysis.flow import value_of

    drive = moving(scenario)
    if drive is None or option.several:
        return None
    try:
        return value_of(scenario.system, drive, option.name)
    except InputError:
        return None


def _missing(option: Parameter) -> InputError:
    """Return the error of an option without which an analysis has no answer."""
    from latolato.analysis.rules import RULES, broken_analysis

    unit = "" if option.unit_of else in_brackets(option.unit)
    values = sentence("value_of_each" if option.unit_of else "such_values", RULES)
    return broken_analysis(
        "needed_by_analysis",
        {"unit": unit},
        parameter=option.name,
        way_out=values if option.several else None,
    )
