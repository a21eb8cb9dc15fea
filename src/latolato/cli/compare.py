"""`latolato compare`: measurement against computation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli.law_options import laws_of
from latolato.cli.options import (
    EndOption,
    JsonOption,
    OutputOption,
    PlotOption,
    StartOption,
    named_values,
    with_law_options,
)
from latolato.cli.output import Targets, print_summary
from latolato.core.errors import InputError
from latolato.core.registry import suggest
from latolato.scenario.options import law_options

if TYPE_CHECKING:
    import xarray as xr

# What a computed response curve takes of a run.
_START = ("initial_angle", "initial_offset", "duration")
_UNFIT = {
    option.name
    for option in law_options().values()
    if option.owner == "noise" or (option.owner == "run" and option.name not in _START)
}


@with_law_options(without=_UNFIT)
def compare(
    table: Annotated[
        Path | None, typer.Argument(help="Track table, or a trial table, as with --trials.")
    ] = None,
    scenario: Annotated[str | None, typer.Argument(help="Scenario that names the system.")] = None,
    trials: Annotated[Path | None, typer.Option(help="Trial table: .csv or .nc.")] = None,
    map_: Annotated[
        Path | None, typer.Option("--map", help="Sweep to compare trials with: .nc or .zarr.")
    ] = None,
    fit: Annotated[Path | None, typer.Option(help="Result of a model or decay fit: .nc.")] = None,
    sigma: Annotated[
        list[str] | None,
        typer.Option(
            help='Standard deviation of a parameter: "length = 0.5 mm". May be given several times.'
        ),
    ] = None,
    draws: Annotated[
        int | None, typer.Option(help="Number of computations with varied parameters.")
    ] = None,
    match: Annotated[
        str | None,
        typer.Option(
            help="Time over which the computed motion is fitted to the measured one, in s; 4 "
            "natural periods by default."
        ),
    ] = None,
    transient: Annotated[
        str | None, typer.Option(help="Transient of computed response curves, in s.")
    ] = None,
    ball: Annotated[int | None, typer.Option(help="Ball of the table.")] = None,
    start: StartOption = None,
    end: EndOption = None,
    output: OutputOption = None,
    plot: PlotOption = None,
    as_json: JsonOption = False,
    **values: Any,
) -> None:
    """Compare measurement with computation: a motion, trials on a map, or response curves.

    A track table with a system, a scenario or a fit gives residuals and phase of the motion on the
    measured drive. Trials with --map give the agreement of their classes; with a system, a
    scenario or a fit the response curves and their peaks.
    """
    from latolato.experiment.compare import compare as find
    from latolato.experiment.importing import read_measured
    from latolato.experiment.trial_table import read_trials

    targets = Targets(output, plot)
    targets.check("the result of a comparison")
    table, trials, scenario = _measured(table, trials, scenario)
    computed, drive, options = _computed(scenario, map_, fit, values, of_trials=trials is not None)
    if draws is not None:
        options["draws"] = draws
    if sigma:
        options["sigmas"] = sigmas_of(sigma)
    of_motion = {"match": match, "ball": ball, "start": start, "end": end}
    of_trials = {"transient": transient}
    own: Mapping[str, Any] = of_motion if trials is None else of_trials
    unfit: Mapping[str, Any] = of_trials if trials is None else of_motion
    if any(value is not None for value in unfit.values()):
        names = ", ".join(f"--{name}" for name, value in unfit.items() if value is not None)
        raise InputError(f"{names} does not belong to this comparison")
    options |= {name: _si(name, value) for name, value in own.items() if value is not None}
    measured = read_measured(table) if table is not None else read_trials(Path(str(trials)))
    dataset = find(measured, computed, drive, **options)
    files = [str(path) for path in targets.write(dataset)]
    print_summary(summarise(dataset) | {"files": files}, lines_of(dataset), as_json=as_json)


def _measured(
    table: Path | None, trials: Path | None, scenario: str | None
) -> tuple[Path | None, Path | None, str | None]:
    """Return the track table or the trial table, and the scenario, that words and options name."""
    from latolato.experiment.trial_table import is_trial_table

    if table is not None and not table.exists() and trials is not None and scenario is None:
        table, scenario = None, str(table)  # the only word is the scenario's
    if table is not None and trials is not None:
        raise InputError("give a track table or --trials, not both")
    if table is not None and table.is_file() and is_trial_table(table):
        table, trials = None, table
    if table is None and trials is None:
        raise InputError("name a track table, or trials with --trials")
    return table, trials, scenario


def _computed(
    scenario: str | None,
    grid: Path | None,
    fit: Path | None,
    values: Mapping[str, Any],
    *,
    of_trials: bool,
) -> tuple[Any, Any, dict[str, Any]]:
    """Return the system that is computed, its drive (None: as measured), and its start."""
    has_system = scenario is not None or values.get("system") is not None
    if grid is not None:
        from latolato.io.files import load

        if not of_trials:
            raise InputError("--map needs trials", way_out="give --trials trials.csv")
        if fit is not None or has_system:
            raise InputError(
                "--map says what is computed", way_out="leave out system, scenario and --fit"
            )
        return load(grid), None, {}
    if fit is not None:
        from latolato.experiment.fits.result import load_fit

        if has_system:
            raise InputError("give a fit, or a system or scenario, not both")
        return load_fit(fit), None, {}
    missing = "name what is computed: --system, a scenario, --fit FILE or --map FILE"
    system, drive, run = laws_of(values, scenario, missing=missing)
    if not of_trials:
        return system, drive, {}
    return system, None, {k: _si(k, run[k]) for k in _START if run.get(k) is not None}


def sigmas_of(texts: Sequence[str]) -> dict[str, float]:
    """Return the standard deviations that options give, in SI units."""
    from latolato.core.quantities import QUANTITIES
    from latolato.scenario.units import to_si

    sigmas = {}
    for name, value in named_values("--sigma", texts, "NAME=VALUE, as in 'length = 1 mm'").items():
        if name not in QUANTITIES:
            raise InputError(f"--sigma does not know '{name}': {suggest(name, list(QUANTITIES))}")
        sigmas[name] = float(to_si(name, value, QUANTITIES[name].unit))
    return sigmas


def summarise(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the verdict and all single numbers of a comparison as JSON knows them."""
    from latolato.simulation.summary import plain

    names = [str(name) for name in dataset.data_vars if not dataset[name].dims]
    return {
        "comparison": dataset.attrs["comparison"],
        "verdict": dataset.attrs["verdict"],
        "values": {
            name: {
                "value": plain(dataset[name].item()),
                "unit": dataset[name].attrs["units"],
                "meaning": dataset[name].attrs["long_name"],
            }
            for name in names
        },
    }


def lines_of(dataset: xr.Dataset) -> dict[str, str]:
    """Return a comparison as names and texts for reading."""
    summary = summarise(dataset)
    lines = {"comparison": f"{summary['comparison']}: {summary['verdict']}"}
    for name, number in summary["values"].items():
        unit = "" if number["unit"] == "1" else f" {number['unit']}"
        value = "unknown" if number["value"] is None else f"{number['value']:.5g}{unit}"
        lines[name] = f"{value} ({number['meaning']})"
    return lines


def _si(name: str, value: Any) -> Any:
    """Return the value of an option in SI units; numbers of a ball have none."""
    from latolato.core.quantities import QUANTITIES
    from latolato.scenario.units import to_si

    if name == "ball":
        return value
    return to_si(name, value, QUANTITIES[name].unit if name in QUANTITIES else "s")
