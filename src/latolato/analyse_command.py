"""What `latolato analyse` does: one command for each analysis, made when it is asked for."""

from __future__ import annotations

import inspect
import json
import math
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from latolato.command_options import (
    EachOptionOnce,
    JsonOption,
    PlotOption,
    ScenarioArgument,
    with_law_options,
)
from latolato.errors import InputError
from latolato.progress import working

if TYPE_CHECKING:
    import xarray as xr

    from latolato.analyse_options import AnalysisOption
    from latolato.scenario import Scenario

# Arrays up to these sizes are shown whole, as text and as JSON.
_FEW, _MANY = 8, 1000
# Entries of ``[sweep]`` that an analysis may take as well.
_OF_SWEEP = ("transient", "transient_periods")
OutputOption = Annotated[
    Path | None,
    typer.Option(help="Result file: .nc.", rich_help_panel="Output"),
]
Tables = dict[str, Any]


class AnalysisGroup(TyperGroup):
    """The commands of the registered analyses; nothing is imported before one is asked for."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all analyses."""
        from latolato.analysis import analyses

        return sorted(analyses)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command of an analysis, None for an unknown one."""
        from latolato.analysis import analyses

        name = cmd_name.replace("-", "_")
        if name not in analyses:
            return None
        if name not in self.commands:
            self.commands[name] = make_command(name, analyses[name])
        return self.commands[name]

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return what is to be run, or raise InputError with the closest known name."""
        from latolato.analysis import analyses

        analyses[args[0].replace("-", "_")]
        return super().resolve_command(ctx, args)


def make_command(name: str, function: Callable[..., Any]) -> Any:
    """Return the command of one analysis."""
    from latolato.analyse_options import options_of, plain_text, summary_of

    own = options_of(function)

    def command(
        scenario: ScenarioArgument = None,
        output: OutputOption = None,
        plot: PlotOption = None,
        as_json: JsonOption = False,
        **given: Any,
    ) -> None:
        run(Question(name, function, own), scenario, given, Targets(output, plot), as_json=as_json)

    signature = inspect.signature(command, eval_str=True)
    first, *output, rest = signature.parameters.values()
    of_analysis = sorted(own.values(), key=lambda option: option.is_of_run)
    command.__signature__ = signature.replace(  # type: ignore[attr-defined]
        parameters=[
            first.replace(kind=first.KEYWORD_ONLY),
            *(option.parameter for option in of_analysis),
            *(each.replace(kind=each.KEYWORD_ONLY) for each in output),
            rest,
        ]
    )
    source = (inspect.getdoc(function) or "").split("\n\n")[1:2]
    app = typer.Typer(add_completion=False)
    app.command(
        name,
        cls=EachOptionOnce,
        help="\n\n".join([summary_of(function), *map(plain_text, source)]),
    )(with_law_options(command, without=unfit_options(function, own)))
    return typer.main.get_command(app)


def unfit_options(function: Callable[..., Any], own: Mapping[str, Any]) -> list[str]:
    """Return the options of laws and runs that the command of an analysis does not take."""
    from latolato.options import law_options

    has_drive = "drive" in inspect.signature(function).parameters
    return [
        option.name
        for option in law_options().values()
        if option.name in own
        or option.path[0] in ("run", "noise")
        or (option.path[0] == "drive" and not has_drive)
    ]


@dataclass(frozen=True)
class Targets:
    """What is to be written: a result file and a picture."""

    output: Path | None
    plot: Path | None

    def check(self, name: str) -> None:
        """Raise before any work if one of them cannot be written."""
        from latolato.files import check_suffix, check_target
        from latolato.run_command import check_targets

        if self.output is not None:
            check_suffix(self.output, (".nc",), "the result of an analysis")
            check_target(self.output)
        check_targets(None, self.plot, None, 1.0, 30.0)
        if self.plot is not None:
            from latolato.figures.plot import picture_of

            picture_of(name)

    def write(self, found: xr.Dataset) -> list[Path]:
        """Write what is asked for and return the names."""
        written = []
        if self.output is not None:
            from latolato.files import save

            written.append(save(found, self.output))
        if self.plot is not None:
            from latolato.figures.plot import plot
            from latolato.figures.style import save_figure

            written.append(save_figure(plot(found), self.plot))
        return written


@dataclass(frozen=True)
class Question:
    """An analysis and its options."""

    name: str
    function: Callable[..., Any]
    own: Mapping[str, AnalysisOption]

    def arguments(
        self, source: str | None, given: Mapping[str, Any], tables: Tables | None = None
    ) -> dict[str, Any]:
        """Return the arguments that a scenario, by its name or its tables, and options give."""
        from latolato.registry import describe

        scenario, sweep = self._scenario(source, given, tables)
        drive = _moving(scenario)
        found: dict[str, Any] = {"system": scenario.system}
        if "drive" in inspect.signature(self.function).parameters:
            found["drive"] = drive
        run = dict(scenario.run)
        noise = run.get("noise")
        kicks = {f"noise_{k}": v for k, v in describe(noise).items()} if noise is not None else {}
        if "times" in run:
            run.setdefault("duration", run["times"][-1])
        for name, option in self.own.items():
            if option.is_of_run:
                if name in run:
                    found[name] = run[name]
            elif given.get(name) is not None:
                found[name] = option.value(given[name], self._unit(option, given, scenario))
            elif name in kicks:
                found[name] = kicks[name]
            elif name in sweep:
                found[name] = option.value(sweep[name], option.unit or "1")
            elif option.is_required:
                found[name] = self._needed(option, scenario)
        self._tell_left_out(scenario)
        return found

    def _scenario(
        self, source: str | None, given: Mapping[str, Any], tables: Tables | None
    ) -> tuple[Scenario, Mapping[str, Any]]:
        """Return the scenario with the options put in, and what ``[sweep]`` says of its run."""
        from latolato.options import changes
        from latolato.physics.pendulum import systems
        from latolato.run_command import changed_tables
        from latolato.scenario import Scenario, find

        kept = {k: v for k, v in given.items() if k not in self.own or self.own[k].is_of_run}
        changed = changes(kept)
        path = find(source) if source is not None else None
        if path is None and tables is None and "kind" not in changed.get("system", {}):
            raise InputError(
                "name what to analyse: a scenario (`latolato scenarios` lists them), a TOML file, "
                f"the file of a run, or --system with one of {', '.join(systems)}"
            )
        tables, folder = changed_tables(path, changed, tables)
        sweep = dict(tables.pop("sweep", {}))
        run = {k: v for k, v in tables.get("run", {}).items() if k not in ("samples", "frame")}
        tables["run"] = {k: sweep[k] for k in ("duration", "tolerance") if k in sweep} | run
        for name, option in self.own.items():
            if given.get(name) is not None and not option.is_of_run:
                _set_law(tables, option, given[name])
        scenario = Scenario.from_dict(tables, folder=folder)
        return scenario, {k: v for k, v in sweep.items() if k in _OF_SWEEP}

    def _needed(self, option: AnalysisOption, scenario: Scenario) -> Any:
        """Return a needed value from the laws of a scenario."""
        from latolato.analysis.flow import value_of

        drive = _moving(scenario)
        if drive is not None and not option.is_sequence:
            try:
                return value_of(scenario.system, drive, option.name)
            except InputError:
                pass
        unit = f" [{option.unit}]" if option.unit not in (None, "1") else ""
        example = ' "0 : 1 : 11"' if option.is_sequence else ""
        raise InputError(f"{self.name} needs {option.name}{unit}: give {option.flag}{example}")

    def _unit(self, option: AnalysisOption, given: Mapping[str, Any], scenario: Scenario) -> str:
        """Return the unit of an option; that of the quantity that another one names, if need be."""
        if option.unit is not None:
            return option.unit
        from latolato.physics.drives import Harmonic
        from latolato.quantities import QUANTITIES
        from latolato.sweep.axes import parameters_of

        drive = _moving(scenario) or Harmonic(drive_amplitude=0.0, drive_frequency=1.0)
        known = {n: p.quantity for n, p in parameters_of(scenario.system, drive).items()}
        known = QUANTITIES | known
        for name, other in self.own.items():
            named = given.get(name) if given.get(name) is not None else other.default
            if other.kind is str and named in known:
                return known[named].unit
        return "1"

    def _tell_left_out(self, scenario: Scenario) -> None:
        """Warn of laws of a scenario that the analysis does not know."""
        from latolato.physics.contacts import Clamp

        if isinstance(scenario.run.get("contact"), Clamp) and "contact" not in self.own:
            warnings.warn(
                f"contact 'clamp' of the scenario is left out: {self.name} is of exact contact",
                RuntimeWarning,
                stacklevel=2,
            )
        if scenario.run.get("noise") is not None and "noise_strength" not in self.own:
            warnings.warn(
                f"the noise of the scenario is left out: {self.name} is of the motion without",
                RuntimeWarning,
                stacklevel=2,
            )


def _moving(scenario: Scenario) -> Any:
    """Return the drive of a scenario, None for a pivot at rest."""
    from latolato.physics.drives import Static

    return None if isinstance(scenario.drive, Static) else scenario.drive


def _set_law(tables: Tables, option: AnalysisOption, given: Any) -> None:
    """Put the value of an option into the law of that name too, if the scenario has it.

    Of several values the first one stands there where the law has none: the analysis varies it.
    """
    from latolato.options import law_options
    from latolato.physics.drives import drives
    from latolato.physics.pendulum import systems
    from latolato.scenario import overridden
    from latolato.tables import RATIOS

    law = law_options().get(option.name)
    if law is None or len(law.path) != 2 or law.path[0] not in ("system", "drive"):
        return
    part = law.path[0]
    kind = tables.get(part, {}).get("kind")
    registry: Any = systems if part == "system" else drives
    target = RATIOS.get(option.name, option.name)
    if kind not in registry or target not in {f.name for f in fields(registry[kind])}:
        return
    if not option.is_sequence:
        tables |= overridden(tables, {part: {option.name: given}})
        return
    names = {target, *(ratio for ratio, plain in RATIOS.items() if plain == target)}
    if not names & tables[part].keys():
        tables[part] = {**tables[part], option.name: option.value(given, option.unit or "1")[0]}


def _axes_of(source: str | None) -> list[str]:
    """Return what a scenario varies, nothing if it cannot be read."""
    from latolato.scenario import find, read_tables

    try:
        tables = read_tables(find(source)) if source is not None else {}
    except (OSError, InputError):
        return []
    sweep = tables.get("sweep", {})
    return list(sweep.get("axes", {})) if isinstance(sweep, Mapping) else []


def run(
    question: Question,
    source: str | None,
    given: Mapping[str, Any],
    targets: Targets,
    *,
    as_json: bool,
) -> None:
    """Run an analysis, write what is asked for and print what it found."""
    begun = time.perf_counter()
    targets.check(question.name)
    try:
        arguments = question.arguments(source, given)
        with working(question.name.replace("_", " ")):
            found = question.function(**arguments)
    except InputError as error:
        varied = ", ".join(n for n in _axes_of(source) if given.get(n) is None)
        if not varied:
            raise
        raise InputError(f"{error} ('{source}' varies {varied}: give values)") from None
    files = targets.write(found)
    elapsed = round(time.perf_counter() - begun, 3)
    if as_json:
        told = summarise(found)
        print(json.dumps(told | {"wall_time": elapsed, "files": [str(path) for path in files]}))
        return
    lines = as_lines(found) | {
        "wall time": f"{elapsed:.2f} s",
        "written": ", ".join(map(str, files)) or "nothing; name a file with --output",
    }
    width = max(16, *map(len, lines))
    print("\n".join(f"{name:{width}} {text}" for name, text in lines.items()))


def summarise(found: xr.Dataset) -> dict[str, Any]:
    """Return what an analysis found as JSON knows it.

    Complex variables are parted as in files; NaN is None and infinities are texts. Of more than
    1000 values there are the least and the largest only.
    """
    from latolato.files import without_complex

    plain = without_complex(found)
    variables: dict[str, Any] = {}
    for name, variable in {**plain.coords, **plain.data_vars}.items():
        about: dict[str, Any] = {
            "units": variable.attrs.get("units", "1"),
            "dims": dict(zip(map(str, variable.dims), variable.shape, strict=True)),
        }
        if variable.size <= _MANY:
            about["values"] = _plain(variable.values)
        elif variable.dtype.kind in "iuf":
            about["range"] = _plain(list(_range(variable.values)))
        variables[str(name)] = about
    attributes = {str(key): _plain(value) for key, value in found.attrs.items()}
    return {"analysis": found.attrs["analysis"], "variables": variables, "attributes": attributes}


def as_lines(found: xr.Dataset) -> dict[str, str]:
    """Return what an analysis found as texts by name."""
    drive = f", drive {found.attrs['drive']}" if "drive" in found.attrs else ""
    lines = {"analysis": f"{found.attrs['analysis']} of {found.attrs.get('system', '')}{drive}"}
    if "status" in found:
        lines["status"] = ""
    for name, variable in {**found.coords, **found.data_vars}.items():
        # Numbers of rows and names of balls say nothing by themselves.
        if name not in found.coords or variable.dtype.kind == "f":
            lines[str(name)] = _text_of(variable)
    if "message" in found.attrs:
        lines["message"] = str(found.attrs["message"])
    return lines


def _text_of(variable: xr.DataArray) -> str:
    """Return one variable in a line."""
    import numpy as np

    values, unit = variable.values, str(variable.attrs.get("units", "1"))
    tail = "" if unit == "1" else f" {unit}"
    if values.size == 0:
        return "none"
    if values.dtype.kind in "OUS" and values.size > _FEW:
        names, counts = np.unique(values.astype(str), return_counts=True)
        return ", ".join(f"{n} {name}" for name, n in zip(names, counts, strict=True))
    if values.dtype.kind == "f" and np.isnan(values).all() and values.ndim == 0:
        return "none"
    if values.ndim == 0 or (values.size <= _FEW and values.ndim == 1):
        return ", ".join(_number(value) for value in values.ravel().tolist()) + tail
    shape = " x ".join(f"{name} {n}" for name, n in zip(variable.dims, values.shape, strict=True))
    if values.dtype.kind in "OUS":
        return f"{', '.join(values.ravel().tolist())} (over {shape})"
    what = "moduli " if values.dtype.kind == "c" else ""
    low, high = _range(np.abs(values) if what else values)
    lost = int(np.isnan(values).sum())
    missing = f", {lost} without value" if lost else ""
    if lost == values.size:
        return f"none (over {shape})"
    return f"{what}{_number(low)} to {_number(high)}{tail} (over {shape}{missing})"


def _range(values: Any) -> tuple[float, float]:
    """Return the least and the largest value that is no NaN; NaN if there is none."""
    import numpy as np

    known = values[~np.isnan(values)]
    return (float(known.min()), float(known.max())) if known.size else (math.nan, math.nan)


def _number(value: Any) -> str:
    """Return one value as text."""
    if isinstance(value, complex):
        return f"{value.real:.6g}{value.imag:+.6g}i" if value.imag else f"{value.real:.6g}"
    if isinstance(value, float):
        return "no value" if math.isnan(value) else f"{value:.6g}"
    return str(value)


def _plain(value: Any) -> Any:
    """Return a value as JSON knows it."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else str(value)
    return value
