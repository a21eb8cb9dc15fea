"""The command line: reads options, hands them on, and turns errors into one line."""

from __future__ import annotations

import _thread
import gc
import signal
import sys
import threading
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from latolato.cli import app as app_command
from latolato.cli import compare as compare_command
from latolato.cli import importing as import_command
from latolato.cli import reproduce as reproduce_command
from latolato.cli import simulate as run_command
from latolato.cli import site as site_command
from latolato.cli import trials as trials_command
from latolato.cli import videos as video_commands
from latolato.cli.analyse import AnalysisGroup
from latolato.cli.fit import FitGroup
from latolato.cli.options import (
    EachOptionOnce,
    JsonOption,
    PlotOption,
    ScenarioArgument,
    UsageError,
    with_law_options,
    with_options,
)
from latolato.cli.output import Targets, elapsed_since, print_summary
from latolato.core.errors import InputError, refusal_of, report_of
from latolato.experiment.parameters import VIDEO_PARAMETERS
from latolato.io.progress import bar
from latolato.scenario.options import changes
from latolato.scenario.scenario import find, load_scenario, scenarios
from latolato.simulation.parameters import SWEEP_PARAMETERS

# Exit code of a fault of the program, EX_SOFTWARE of sysexits.h.
_FAULT = 70

app = typer.Typer(
    name="latolato",
    help="Driven and colliding pendula: simulate, draw, reproduce the paper.",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
scenarios_app = typer.Typer(help="List the scenarios that come with latolato, or show one.")
app.add_typer(scenarios_app, name="scenarios")
analyse_app = typer.Typer(
    cls=AnalysisGroup,
    help="Ask a system and its drive a question: periods, stability, thresholds, basins.",
)
app.add_typer(analyse_app, name="analyse")
app.add_typer(analyse_app, name="analyze", hidden=True)
fit_app = typer.Typer(cls=FitGroup, help="Fit physics to a track table.")
app.add_typer(fit_app, name="fit")
app.command("import", cls=EachOptionOnce)(import_command.import_)
app.command("trials", cls=EachOptionOnce)(trials_command.trials)
app.command("compare", cls=EachOptionOnce)(compare_command.command())
for _spelling in ("synthesise", "synthesize"):
    app.command(_spelling, cls=EachOptionOnce, hidden=_spelling == "synthesize")(
        with_law_options(video_commands.synthesise, without=("times", "samples", "frame"))
    )
app.command("track", cls=EachOptionOnce)(
    with_options(video_commands.track, VIDEO_PARAMETERS.values())
)
app.command("reproduce", cls=EachOptionOnce)(reproduce_command.reproduce)
app.command("app", cls=EachOptionOnce)(app_command.app)
app.command("site", cls=EachOptionOnce)(site_command.site)


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if version:
        from latolato import __version__

        print(f"latolato {__version__}")
    elif context.invoked_subcommand is None:
        print(context.get_help())


@app.command(cls=EachOptionOnce)
@with_law_options
def simulate(
    scenario: ScenarioArgument = None,
    rerun: Annotated[
        Path | None, typer.Option("--from", help="Run a result file again, at the same instants.")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(help="Result file: .nc, .csv or .parquet.", rich_help_panel="Output"),
    ] = None,
    plot: PlotOption = None,
    animate: Annotated[
        Path | None, typer.Option(help="Animation: .mp4 or .gif.", rich_help_panel="Output")
    ] = None,
    speed: Annotated[
        float, typer.Option(help="How much faster it plays.", rich_help_panel="Output")
    ] = 1.0,
    fps: Annotated[float, typer.Option(help="Frames a second.", rich_help_panel="Output")] = 30.0,
    as_json: JsonOption = False,
    **given: Any,
) -> None:
    """Run one scenario, or a system given by options, and write what is asked for.

    Options replace what the scenario says. Quantities may carry a unit: "24.5 cm", "20 deg",
    "1.6 Hz"; without one they are in SI units. Existing files are replaced.
    """
    begun = time.perf_counter()
    targets = Targets(output, plot)
    animation = run_command.Animation(animate, speed, fps)
    with _uncollected():
        ready = run_command.scenario_of(scenario, rerun, given)
        targets.check("the name of a result file", (".nc", ".csv", ".parquet"))
        animation.check()
        with bar("simulating") as progress:
            run = ready.record(progress=progress)
        files = targets.save(run)
    if plot is not None or animate is not None:
        dataset = run.to_dataset()
        files += targets.draw(dataset) + animation.write(dataset)
    from latolato.simulation.summary import summarise

    summary = summarise(run) | {
        "wall_time": elapsed_since(begun),
        "files": [str(path) for path in files],
    }
    print_summary(summary, run_command.lines_of(summary), as_json=as_json)


@scenarios_app.callback(invoke_without_command=True)
def _list_scenarios(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        for name, scenario in scenarios().items():
            figure = f"Fig. {scenario.figure}" if scenario.figure else ""
            kind = "sweep" if scenario.varied else "run"
            print(f"{name:20} {kind:6} {figure:12} {scenario.title}")


@scenarios_app.command()
def show(name: Annotated[str, typer.Argument(help="The scenario's name.")]) -> None:
    """Print a scenario's TOML file, to copy and change."""
    load_scenario(name)
    print(find(name).read_text(encoding="utf-8"), end="")


@analyse_app.callback(invoke_without_command=True)
@fit_app.callback(invoke_without_command=True)
def _list_commands(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        print(context.get_help())


def _sweep(
    scenario: ScenarioArgument = None,
    rerun: Annotated[
        Path | None, typer.Option("--from", help="Run the sweep of a store or of a .nc file again.")
    ] = None,
    status: Annotated[
        Path | None, typer.Option(help="Say how far the sweep in this store is, and nothing else.")
    ] = None,
    verify: Annotated[
        Path | None,
        typer.Option(
            metavar="STORE",
            help="Read everything in a store and say what is damaged; exit code 1 if anything is.",
        ),
    ] = None,
    axis: Annotated[
        list[str] | None,
        typer.Option(
            help='What varies: "drive_amplitude = 0 : 0.5 : 400 m", "frequency_ratio = 1.9, 2", '
            '"radius = 1 mm : 1 cm : 20 log", or several together: "case: length = 0.2 m, 0.3 m; '
            'radius = 2 cm, 3 cm". May be given several times.',
            rich_help_panel="Sweep",
        ),
    ] = None,
    observable: Annotated[
        list[str] | None,
        typer.Option(
            help='What is gathered: "mean_energy", "crossings(crossing_angle = 90 deg)". May be '
            "given several times.",
            rich_help_panel="Sweep",
        ),
    ] = None,
    executor: Annotated[
        str, typer.Option(help="threads, dask, cuda or reference", rich_help_panel="Where it runs")
    ] = "threads",
    workers: Annotated[
        int | None,
        typer.Option(
            help="threads, or processes of a local Dask cluster", rich_help_panel="Where it runs"
        ),
    ] = None,
    address: Annotated[
        str | None,
        typer.Option(
            help="scheduler of a Dask cluster, tcp://HOST:8786", rich_help_panel="Where it runs"
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(help="Result: map.nc, or map.zarr, a store.", rich_help_panel="Output"),
    ] = None,
    store: Annotated[
        Path | None,
        typer.Option(
            help="Zarr store, written as points are done and resumed if it exists.",
            rich_help_panel="Output",
        ),
    ] = None,
    plot: PlotOption = None,
    variable: Annotated[
        str | None,
        typer.Option(
            help="What the picture shows; by default the first observable.",
            rich_help_panel="Output",
        ),
    ] = None,
    as_json: JsonOption = False,
    **given: Any,
) -> None:
    """Run a map of many trajectories over any parameters, and write what is asked for.

    Options replace what the scenario says: an axis one that varies the same thing, a value one
    that it fixes. A store is resumed; other existing files are replaced. Ctrl-C stops.
    """
    from latolato.cli import sweep as sweep_command

    look = {"--status": status, "--verify": verify}
    looks = [name for name, store_path in look.items() if store_path is not None]
    if looks:
        run_options = {"a scenario": scenario, "--from": rerun, "--axis": axis, "--output": output}
        others = looks[1:] + [name for name, value in run_options.items() if value]
        if others:
            raise InputError(
                f"{looks[0]} only looks at a store", way_out=f"leave out {', '.join(others)}"
            )
    if status is not None:
        sweep_command.print_status(status, as_json)
        return
    if verify is not None:
        if sweep_command.print_verification(verify, as_json):
            raise typer.Exit(1)
        return
    if scenario is not None and rerun is not None:
        raise InputError("give either a scenario or --from, not both")
    table = {name: given.pop(name) for name in SWEEP_PARAMETERS}
    plan = sweep_command.plan_of(
        scenario,
        rerun,
        changes(given),
        {name: value for name, value in table.items() if value is not None},
        axis or [],
        observable or [],
    )
    options = {"workers": workers, "client": address}
    sweep_command.run(
        plan,
        executor,
        {name: value for name, value in options.items() if value is not None},
        sweep_command.SweepTargets(output, store, plot, variable),
        as_json=as_json,
    )


app.command("sweep", cls=EachOptionOnce)(
    with_law_options(
        _sweep, without=("times", "samples", "frame"), further=SWEEP_PARAMETERS.values()
    )
)


@app.command(cls=EachOptionOnce)
def plot(
    file: Annotated[Path, typer.Argument(help="A result file or a sweep's store.")],
    output: Annotated[
        Path | None, typer.Option(help="Picture; by default beside the file, as PNG.")
    ] = None,
    animate: Annotated[Path | None, typer.Option(help="Animation of a run: .mp4 or .gif.")] = None,
    speed: Annotated[float, typer.Option(help="How much faster it plays.")] = 1.0,
    fps: Annotated[float, typer.Option(help="Frames a second.")] = 30.0,
    variable: Annotated[
        str | None, typer.Option(help="What to draw of a map.", rich_help_panel="Maps")
    ] = None,
    log: Annotated[
        bool, typer.Option("--log", help="Logarithmic scale.", rich_help_panel="Maps")
    ] = False,
    curves: Annotated[
        bool,
        typer.Option(
            "--curves", help="Curves, one for each of few values.", rich_help_panel="Maps"
        ),
    ] = False,
    select: Annotated[
        list[str] | None,
        typer.Option(
            help='Value of a further dimension: "restitution=0.9".', rich_help_panel="Maps"
        ),
    ] = None,
    overlay: Annotated[
        list[str] | None, typer.Option(help="tongue or lift_off.", rich_help_panel="Maps")
    ] = None,
    points: Annotated[
        Path | None,
        typer.Option(
            help="CSV of trials: drive_amplitude, drive_frequency or frequency_ratio, class.",
            rich_help_panel="Maps",
        ),
    ] = None,
) -> None:
    """Draw a run, a map or an analysis; animate a run if asked to."""
    from latolato.io.files import load

    dataset = load(file)
    picture = output or file.with_suffix(".png")
    targets = Targets(plot=picture)
    targets.check("the name of a picture")
    animation = run_command.Animation(animate, speed, fps)
    animation.check()
    from latolato.figures import plot as pictures

    of_map: dict[str, Any] = {
        "variable": variable,
        "log": log,
        "curves": curves,
        "select": run_command.selection_of(select or [], dataset),
        "overlays": overlay or [],
        "points": points,
    }
    kind = pictures.kind_of(dataset)
    if kind != "run":
        if animate is not None:
            article = "an" if kind == "analysis" else "a"
            raise InputError(f"'{file}' holds {article} {kind}: only a run can be animated")
        from latolato.figures.style import save_figure

        print(save_figure(pictures.plot(dataset, **of_map), picture))
        return
    unfit = [f"--{name.removesuffix('s')}" for name, value in of_map.items() if value]
    if unfit:
        raise InputError(f"'{file}' holds a run: {', '.join(unfit)} only fits a map")
    for path in targets.draw(dataset) + animation.write(dataset):
        print(path)


@app.command()
def cite() -> None:
    """Print how to cite latolato and the paper it builds on."""
    from latolato.core.citation import cite as citation

    print(citation())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    0 when the work is done, 2 for refused input, 70 for a fault of the program and 130 for Ctrl-C.
    """
    before = signal.signal(signal.SIGTERM, _terminate)
    hook = sys.unraisablehook
    sys.unraisablehook = _show_failed_cleanup
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _show_warning
            warnings.simplefilter("always", RuntimeWarning)
            code = app(args=arguments, prog_name="latolato", standalone_mode=False)
            return code if isinstance(code, int) else 0
    except (KeyboardInterrupt, typer.Abort):
        return 130
    except UsageError as error:
        return _refuse(error.format_message())
    except Exception as error:
        ending = _ending(error)
        if ending is not None:
            return ending
        message = refusal_of(error)
        return _refuse(message) if message is not None else _refuse(report_of(error), _FAULT)
    finally:
        signal.signal(signal.SIGTERM, before)
        sys.unraisablehook = hook


def _ending(error: BaseException) -> int | None:
    """Return the exit code of a signal that an error stands for, None if there was none.

    A signal may come where Python itself turns any exception into another, as while a class is
    made.
    """
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, KeyboardInterrupt):
            return 130
        if isinstance(cause, SystemExit) and isinstance(cause.code, int):
            return cause.code
        cause = cause.__cause__ or cause.__context__
    return None


def _terminate(number: int, _frame: Any) -> None:
    """Leave by an exception, so that unfinished files are removed."""
    sys.exit(128 + number)


def _refuse(message: str, code: int = 2) -> int:
    """Print an error as one line and return its exit code, by default that of refused input."""
    print(f"latolato: {' '.join(message.split())}", file=sys.stderr)
    return code


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """Print a warning as one line."""
    print(f"latolato: warning: {' '.join(str(message).split())}", file=sys.stderr)


def _show_failed_cleanup(failure: Any) -> None:
    """Print as one line that something could not be closed, such as a damaged file.

    Where Ctrl-C came during a cleanup, Python has dropped it: it is sent once more, from a thread,
    since whatever is raised here is dropped too.
    """
    if isinstance(failure.exc_value, KeyboardInterrupt):
        threading.Timer(0.01, _thread.interrupt_main).start()
        return
    _show_warning(f"{failure.exc_value} (after the work was done)")


@contextmanager
def _uncollected() -> Iterator[None]:
    """Look for no garbage: while modules load, that costs a sixth of a short command's time."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
