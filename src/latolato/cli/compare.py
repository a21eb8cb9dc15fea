"""`latolato compare`: measurement against computation."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli.law_options import laws_of
from latolato.cli.options import (
    JsonOption,
    OutputOption,
    PlotOption,
    values_of,
    with_law_options,
    with_options,
)
from latolato.cli.output import Targets, print_summary
from latolato.core.errors import InputError
from latolato.experiment.compare import compare as compare_with
from latolato.experiment.comparison.motion import compare_motion
from latolato.experiment.comparison.places import compare_map
from latolato.experiment.comparison.response import compare_response
from latolato.scenario.analysis_options import LAWS, arguments_of, options_of
from latolato.scenario.options import law_options

if TYPE_CHECKING:
    import xarray as xr

OF_MOTION = options_of(compare_motion, without=(*LAWS, "draws", "seed"))
OF_RESPONSE = {"transient": options_of(compare_response, without=("trials", "system"))["transient"]}
# What a computed response curve takes of a run.
_START = ("initial_angle", "initial_offset", "duration")
_UNFIT = {
    option.name
    for option in law_options().values()
    if option.owner == "noise" or (option.owner == "run" and option.name not in _START)
}


def _usual_draws(function: Callable[..., xr.Dataset]) -> int:
    """Return how many draws a comparison makes by default."""
    return int(inspect.signature(function).parameters["draws"].default)


@with_law_options(without=_UNFIT)
@with_options((*OF_MOTION.values(), *OF_RESPONSE.values()))
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
        int | None,
        typer.Option(
            help="Number of computations with varied parameters; by default "
            f"{_usual_draws(compare_motion)} for a motion, {_usual_draws(compare_map)} on a map, "
            f"{_usual_draws(compare_response)} for response curves."
        ),
    ] = None,
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
    from latolato.experiment.importing import read_measured
    from latolato.experiment.trial_table import read_trials

    targets = Targets(output, plot)
    targets.check("the result of a comparison")
    table, trials, scenario = _measured(table, trials, scenario)
    computed, drive, options = _computed(scenario, map_, fit, values, of_trials=trials is not None)
    if draws is not None:
        options["draws"] = draws
    if sigma:
        numbers = {name: option for name, option in law_options().items() if option.is_number}
        options["sigmas"] = values_of("--sigma", sigma, numbers)
    own, unfit = (OF_MOTION, OF_RESPONSE) if trials is None else (OF_RESPONSE, OF_MOTION)
    names = ", ".join(one.flag for name, one in unfit.items() if values[name] is not None)
    if names:
        raise InputError(f"{names} does not belong to this comparison")
    options |= arguments_of(own, values)
    measured = read_measured(table) if table is not None else read_trials(Path(str(trials)))
    dataset = compare_with(measured, computed, drive, **options)
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
    return system, None, arguments_of({name: law_options()[name] for name in _START}, run)


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
