"""What `latolato compare` does once its options are read."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli.options import JsonOption, PlotOption, named_values, with_law_options
from latolato.core.errors import InputError
from latolato.core.registry import suggest

if TYPE_CHECKING:
    import xarray as xr

_START = ("initial_angle", "initial_offset")


def compare(
    table: Annotated[
        Path | None,
        typer.Argument(help="Track table, or trial table as --trials.", show_default=False),
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Argument(help="Scenario that names the system.", show_default=False),
    ] = None,
    trials: Annotated[
        Path | None, typer.Option(help="Trial table: .csv or .nc.", show_default=False)
    ] = None,
    map_: Annotated[
        Path | None,
        typer.Option(
            "--map", help="Sweep that trials are laid over: .nc or .zarr.", show_default=False
        ),
    ] = None,
    fit: Annotated[
        Path | None,
        typer.Option(help="Fit of a model or a decay: .nc.", show_default=False),
    ] = None,
    sigma: Annotated[
        list[str] | None,
        typer.Option(
            help='Standard deviation of a parameter: "length = 0.5 mm". May be given several '
            "times.",
            show_default=False,
        ),
    ] = None,
    draws: Annotated[
        int | None,
        typer.Option(help="Computations with other parameters.", show_default=False),
    ] = None,
    match: Annotated[
        str | None,
        typer.Option(
            help="Time in which the computed motion is fitted to the measured one, in s; 4 "
            "natural periods by default.",
            show_default=False,
        ),
    ] = None,
    transient: Annotated[
        str | None,
        typer.Option(help="Transient of computed response curves, in s.", show_default=False),
    ] = None,
    ball: Annotated[int | None, typer.Option(help="Ball of the table.", show_default=False)] = None,
    start: Annotated[
        str | None, typer.Option(help="First instant used, in s.", show_default=False)
    ] = None,
    end: Annotated[
        str | None, typer.Option(help="Last instant used, in s.", show_default=False)
    ] = None,
    output: Annotated[
        Path | None, typer.Option(help="Result file: .nc.", rich_help_panel="Output")
    ] = None,
    plot: PlotOption = None,
    as_json: JsonOption = False,
    **given: Any,
) -> None:
    """Lay measurement beside computation: a motion, trials over a map, or response curves.

    A track table with a system, a scenario or a fit gives residuals and phase of the motion on the
    measured drive. Trials with --map give the agreement of their classes; with a system, a
    scenario or a fit the response curves and their peaks.
    """
    from latolato.cli.simulate import check_targets
    from latolato.experiment.compare import compare as find
    from latolato.experiment.fits.result import load_fit
    from latolato.experiment.table import read_table
    from latolato.experiment.trial_table import is_trial_table, read_trials
    from latolato.io.files import check_suffix, check_target, save
    from latolato.scenario.units import to_si

    if output is not None:
        check_suffix(output, (".nc",), "the result of a comparison")
        check_target(output)
    check_targets(None, plot, None, 1.0, 30.0)
    if table is not None and not table.exists() and trials is not None and scenario is None:
        table, scenario = None, str(table)  # the only word is the scenario's
    if table is not None and trials is not None:
        raise InputError("give a track table or --trials, not both")
    if table is not None and table.is_file() and is_trial_table(table):
        table, trials = None, table
    if table is None and trials is None:
        raise InputError("name a track table, or trials with --trials")
    options: dict[str, Any] = {} if draws is None else {"draws": draws}
    computed: Any
    drive = None
    if map_ is not None:
        if trials is None:
            raise InputError("--map needs trials: --trials trials.csv")
        if fit is not None or scenario is not None or _named(given):
            raise InputError("--map says what is computed: leave out system, scenario and --fit")
        computed = _map(map_)
        system = None
    elif fit is not None:
        if scenario is not None or _named(given):
            raise InputError("give a fit, or a system or scenario, not both")
        computed = system = load_fit(fit)
    else:
        system, drive, run = _system(scenario, given)
        computed = system
        if trials is not None:
            drive = None
            options |= {k: run[k] for k in (*_START, "duration") if run.get(k) is not None}
    if sigma:
        options["sigmas"] = sigmas_of(sigma)
    if trials is not None:
        if transient is not None:
            options["transient"] = to_si("transient", transient, "s")
        unfit = {"--match": match, "--ball": ball, "--start": start, "--end": end}
    else:
        texts = {"match": match, "start": start, "end": end}
        options |= {k: to_si(k, v, "s") for k, v in texts.items() if v is not None}
        options |= {} if ball is None else {"ball": ball}
        unfit = {"--transient": transient}
    if any(value is not None for value in unfit.values()):
        names = ", ".join(name for name, value in unfit.items() if value is not None)
        raise InputError(f"{names} does not belong to this comparison")
    measured = read_table(table) if table is not None else read_trials(Path(str(trials)))
    found = find(measured, computed, drive, **options)
    written = [save(found, output)] if output is not None else []
    if plot is not None:
        from latolato.figures.comparisons import draw_comparison
        from latolato.figures.style import save_figure

        written.append(save_figure(draw_comparison(found), plot))
    values = summary(found) | {"files": [str(path) for path in written]}
    print(json.dumps(values) if as_json else as_text(values))


def command() -> Callable[..., None]:
    """Return the command with an option for each parameter of systems, drives and starts."""
    from latolato.scenario.options import law_options

    kept = (*_START, "duration")
    left = [
        o.name
        for o in law_options().values()
        if o.owner == "noise" or (o.owner == "run" and o.name not in kept)
    ]
    return with_law_options(compare, without=left)


def sigmas_of(texts: Sequence[str]) -> dict[str, float]:
    """Return the standard deviations that options give, in SI units."""
    from latolato.core.quantities import QUANTITIES
    from latolato.scenario.units import to_si

    found = {}
    for name, value in named_values("--sigma", texts, "NAME=VALUE, as in 'length = 1 mm'").items():
        if name not in QUANTITIES:
            raise InputError(f"--sigma knows no '{name}': {suggest(name, list(QUANTITIES))}")
        found[name] = float(to_si(name, value, QUANTITIES[name].unit))
    return found


def summary(found: xr.Dataset) -> dict[str, Any]:
    """Return what the summary says: the verdict and all single numbers."""
    names = [str(name) for name in found.data_vars if not found[name].dims]
    return {
        "comparison": found.attrs["comparison"],
        "verdict": found.attrs["verdict"],
        "values": {
            name: {
                "value": _number(found[name].item()),
                "unit": found[name].attrs["units"],
                "meaning": found[name].attrs["long_name"],
            }
            for name in names
        },
    }


def as_text(found: Mapping[str, Any]) -> str:
    """Return the summary as lines for reading."""
    lines = {"comparison": f"{found['comparison']}: {found['verdict']}"}
    for name, each in found["values"].items():
        unit = "" if each["unit"] == "1" else f" {each['unit']}"
        shown = "unknown" if each["value"] is None else f"{each['value']:.5g}{unit}"
        lines[name] = f"{shown} ({each['meaning']})"
    lines["written"] = ", ".join(found["files"]) or "nothing; name a file with --output or --plot"
    width = max(map(len, lines))
    return "\n".join(f"{name:{width}} {text}" for name, text in lines.items())


def _number(value: float) -> float | None:
    """Return a number as JSON knows it."""
    return float(value) if value == value else None


def _named(given: Mapping[str, Any]) -> bool:
    """Return whether options name a system."""
    return given.get("system") is not None


def _map(path: Path) -> xr.Dataset:
    """Return the dataset of a sweep."""
    from latolato.io.files import load

    return load(path)


def _system(scenario: str | None, given: Mapping[str, Any]) -> tuple[Any, Any, dict[str, Any]]:
    """Return system, drive (None: as measured) and start that scenario and options name."""
    from latolato.scenario.options import changes
    from latolato.scenario.scenario import changed_tables, find
    from latolato.scenario.tables import law_from, without_ratios

    plain = {k: v for k, v in given.items() if not (k == "drive" and v == "measured")}
    changed = changes(plain)
    has_drive = "drive" in changed
    path = find(scenario) if scenario is not None else None
    if path is None and "kind" not in changed.get("system", {}):
        raise InputError("name what is computed: --system, a scenario, --fit FILE or --map FILE")
    tables, _ = changed_tables(path, changed)
    from latolato.physics.drives import drives
    from latolato.physics.pendulum import systems

    system = law_from(tables["system"], systems, "system", Path())
    drive: Any = None
    if has_drive:
        drive = law_from(without_ratios(tables["drive"], system), drives, "drive", Path())
    elif given.get("drive") == "measured":
        drive = "measured"
    from latolato.scenario.units import to_si

    run = tables.get("run", {})
    units = {"initial_angle": "rad", "initial_offset": "rad", "duration": "s"}
    return system, drive, {
        k: to_si(k, run[k], unit) for k, unit in units.items() if run.get(k) is not None
    }  # fmt: skip
