"""The command line: reads options, hands them on, and turns errors into one line."""

from __future__ import annotations

import gc
import inspect
import json
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from latolato.options import changes, law_options
from latolato.physics.pendulum import systems
from latolato.scenario import (
    Scenario,
    find,
    load_scenario,
    overridden,
    read_tables,
    scenarios,
)

if TYPE_CHECKING:
    import xarray as xr

PICTURES = (".png", ".svg", ".pdf")
# A bar appears once work has taken this long [s].
_PATIENCE = 0.7
# What typer raises for wrong options; its name has moved between versions.
_UsageError: Any = typer.BadParameter.__mro__[1]

app = typer.Typer(
    name="latolato",
    help="Driven and colliding pendula: simulate, draw, reproduce the paper.",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
scenarios_app = typer.Typer(help="List the scenarios that come with latolato, or show one.")
app.add_typer(scenarios_app, name="scenarios")


class _EachOptionOnce(TyperCommand):
    """A command that refuses an option given twice, where typer would take the last."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Return the arguments that are left when the options are read."""
        *_, given = self.make_parser(ctx).parse_args(list(args))
        for parameter in given:
            count = given.count(parameter)
            if count > 1 and not getattr(parameter, "multiple", False):
                flag = max(parameter.opts, key=len)
                raise _UsageError(f"option {flag} must be given once, got it {count} times")
        return super().parse_args(ctx, args)


def _with_law_options(
    command: Callable[..., None], without: Sequence[str] = ()
) -> Callable[..., None]:
    """Return a command whose keyword arguments are spelled out as options."""
    panels = {"system": "System", "drive": "Drive", "run": "Run", "noise": "Noise"}
    signature = inspect.signature(command, eval_str=True)
    parameters = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
    for option in law_options().values():
        if option.name in without:
            continue
        flag = "--" + option.name.replace("_", "-")
        unit = f", in {option.unit}" if option.unit not in ("", "1") else ""
        about = typer.Option(
            flag,
            help=f"{option.description}{unit}",
            rich_help_panel=panels[option.path[0]],
            show_default=False,
            metavar=None if option.kind is bool else "VALUES" if option.several else "VALUE",
        )
        parameters.append(
            inspect.Parameter(
                option.name,
                inspect.Parameter.KEYWORD_ONLY,
                default=None,
                annotation=Annotated[option.kind | None, about],
            )
        )
    command.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return command


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


@app.command(cls=_EachOptionOnce)
@_with_law_options
def simulate(
    scenario: Annotated[
        str | None,
        typer.Argument(help="A scenario's name or TOML file.", show_default=False),
    ] = None,
    rerun: Annotated[
        Path | None,
        typer.Option("--from", help="Run a result file again, at the same instants."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(help="Result file: .nc, .csv or .parquet.", rich_help_panel="Output"),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option(help="Picture: .png, .svg or .pdf.", rich_help_panel="Output"),
    ] = None,
    animate: Annotated[
        Path | None,
        typer.Option(help="Animation: .mp4 or .gif.", rich_help_panel="Output"),
    ] = None,
    speed: Annotated[
        float, typer.Option(help="How much faster it plays.", rich_help_panel="Output")
    ] = 1.0,
    fps: Annotated[float, typer.Option(help="Frames a second.", rich_help_panel="Output")] = 30.0,
    as_json: Annotated[
        bool,
        typer.Option("--json", help="Print the summary as JSON.", rich_help_panel="Output"),
    ] = False,
    **given: Any,
) -> None:
    """Run one scenario, or a system given by options, and write what is asked for.

    Options replace what the scenario says. Quantities may carry a unit: "24.5 cm", "20 deg",
    "1.6 Hz"; without one they are in SI units. Existing files are replaced.
    """
    begun = time.perf_counter()
    with _uncollected():
        ready = _scenario(scenario, rerun, given)
        _check_targets(output, plot, animate, speed, fps)
        with _progress("simulating") as progress:
            run = ready.simulate(progress=progress)
        files = _write(run, output, None, None, speed, fps)
    files += _write(run, None, plot, animate, speed, fps)
    from latolato.summary import summarise

    found = summarise(run) | {
        "wall_time": round(time.perf_counter() - begun, 3),
        "files": [str(path) for path in files],
    }
    print(json.dumps(found) if as_json else _as_text(found))


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


def _sweep(
    scenario: Annotated[
        str | None,
        typer.Argument(help="A scenario's name or TOML file.", show_default=False),
    ] = None,
    rerun: Annotated[
        Path | None,
        typer.Option("--from", help="Run the sweep of a store or of a .nc file again."),
    ] = None,
    status: Annotated[
        Path | None, typer.Option(help="Say how far the sweep in this store is, and nothing else.")
    ] = None,
    axis: Annotated[
        list[str] | None,
        typer.Option(
            help='What varies: "drive_amplitude = 0 : 0.5 : 400 m", "frequency_ratio = 1.9, 2", '
            '"radius = 1 mm : 1 cm : 20 log", or several together: "case: length = 0.2 m, 0.3 m; '
            'radius = 2 cm, 3 cm". May be given several times.',
            show_default=False,
            rich_help_panel="Sweep",
        ),
    ] = None,
    observable: Annotated[
        list[str] | None,
        typer.Option(
            help='What is gathered: "mean_energy", "crossings(crossing_angle = 90 deg)". May be '
            "given several times.",
            show_default=False,
            rich_help_panel="Sweep",
        ),
    ] = None,
    transient: Annotated[
        str | None,
        typer.Option(
            help="time after which observables begin, in s",
            metavar="VALUE",
            rich_help_panel="Sweep",
        ),
    ] = None,
    transient_periods: Annotated[
        float | None,
        typer.Option(help="the same in drive periods; both add up", rich_help_panel="Sweep"),
    ] = None,
    continuation: Annotated[
        str | None,
        typer.Option(
            help="axis along which each point starts where its neighbour ended",
            rich_help_panel="Sweep",
        ),
    ] = None,
    direction: Annotated[
        str | None,
        typer.Option(help="way along it: up, down or both", rich_help_panel="Sweep"),
    ] = None,
    chunk_size: Annotated[
        int | None,
        typer.Option(help="points computed and stored at once", rich_help_panel="Sweep"),
    ] = None,
    executor: Annotated[
        str,
        typer.Option(help="threads, dask, cuda or reference", rich_help_panel="Where it runs"),
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
    plot: Annotated[
        Path | None,
        typer.Option(help="Picture: .png, .svg or .pdf.", rich_help_panel="Output"),
    ] = None,
    variable: Annotated[
        str | None,
        typer.Option(
            help="What the picture shows; by default the first observable.",
            rich_help_panel="Output",
        ),
    ] = None,
    as_json: Annotated[
        bool,
        typer.Option("--json", help="Print the summary as JSON.", rich_help_panel="Output"),
    ] = False,
    **given: Any,
) -> None:
    """Run a map of many trajectories over any parameters, and write what is asked for.

    Options replace what the scenario says: an axis one that varies the same thing, a value one
    that it fixes. A store is resumed; other existing files are replaced. Ctrl-C stops.
    """
    from latolato import sweep_command

    if status is not None:
        asked = {"a scenario": scenario, "--from": rerun, "--axis": axis, "--output": output}
        others = [name for name, value in asked.items() if value]
        if others:
            raise ValueError(f"--status says how far a store is: leave out {', '.join(others)}")
        sweep_command.print_status(status, as_json)
        return
    if scenario is not None and rerun is not None:
        raise ValueError("give either a scenario or --from, not both")
    table = {
        "transient": transient,
        "transient_periods": transient_periods,
        "continuation": continuation,
        "direction": direction,
        "chunk_size": chunk_size,
    }
    plan = sweep_command.plan_of(
        _tables,
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
        sweep_command.Targets(output, store, plot, variable),
        as_json=as_json,
    )


app.command("sweep", cls=_EachOptionOnce)(
    _with_law_options(_sweep, without=("times", "samples", "frame"))
)


@app.command(cls=_EachOptionOnce)
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
            help='Value of a further dimension: "restitution=0.9".',
            show_default=False,
            rich_help_panel="Maps",
        ),
    ] = None,
    overlay: Annotated[
        list[str] | None,
        typer.Option(help="tongue or lift_off.", show_default=False, rich_help_panel="Maps"),
    ] = None,
    points: Annotated[
        Path | None,
        typer.Option(
            help="CSV of trials: drive_amplitude, drive_frequency or frequency_ratio, class.",
            rich_help_panel="Maps",
        ),
    ] = None,
) -> None:
    """Draw a run or a map; animate a run if asked to."""
    from latolato.files import load

    dataset = load(file)
    picture = output or file.with_suffix(".png")
    _check_targets(None, picture, animate, speed, fps)
    from latolato.figures import run as pictures

    of_map: dict[str, Any] = {
        "variable": variable,
        "log": log,
        "curves": curves,
        "select": _selection(select or [], dataset),
        "overlays": overlay or [],
        "points": points,
    }
    if pictures.is_map(dataset):
        if animate is not None:
            raise ValueError(f"'{file}' holds a map: only a run can be animated")
        from latolato.figures.style import save_figure

        print(save_figure(pictures.plot(dataset, **of_map), picture))
        return
    unfit = [f"--{name.removesuffix('s')}" for name, value in of_map.items() if value]
    if unfit:
        raise ValueError(f"'{file}' holds a run: {', '.join(unfit)} only fits a map")
    for path in _write(dataset, None, picture, animate, speed, fps):
        print(path)


@app.command(cls=_EachOptionOnce)
def reproduce(
    quick: Annotated[bool, typer.Option(help="Coarser, in about two minutes.")] = False,
    output: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("latolato-report"),
) -> None:
    """Reproduce the paper's figures and judge its claims in a report."""
    from latolato import report

    with _progress("reproducing") as progress:
        result = report.reproduce(output, quick=quick, progress=progress)
    report.print_claims(result)


@app.command()
def cite() -> None:
    """Print how to cite latolato and the paper it builds on."""
    from latolato.citation import cite as citation

    print(citation())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code: 0, 2 for refused input, 130 for Ctrl-C."""
    before = signal.signal(signal.SIGTERM, _terminate)
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _show_warning
            warnings.simplefilter("always", RuntimeWarning)
            code = app(args=arguments, prog_name="latolato", standalone_mode=False)
            return code if isinstance(code, int) else 0
    except (KeyboardInterrupt, typer.Abort):
        return 130
    except _UsageError as error:
        return _refuse(error.format_message())
    except OSError as error:
        has_cause = error.strerror and error.filename
        return _refuse(f"{error.strerror}: {error.filename}" if has_cause else str(error))
    except MemoryError as error:
        return _refuse(f"not enough memory: {error}; ask for fewer samples or a shorter duration")
    except (ValueError, TypeError, RuntimeError, ImportError) as error:
        return _refuse(str(error))
    finally:
        signal.signal(signal.SIGTERM, before)


def _terminate(number: int, _frame: Any) -> None:
    """Leave by an exception, so that unfinished files are removed."""
    sys.exit(128 + number)


def _refuse(message: str) -> int:
    """Print an error as one line and return the exit code of refused input."""
    print(f"latolato: {' '.join(message.split())}", file=sys.stderr)
    return 2


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """Print a warning as one line."""
    print(f"latolato: warning: {' '.join(str(message).split())}", file=sys.stderr)


def _scenario(source: str | None, rerun: Path | None, given: Mapping[str, Any]) -> Scenario:
    """Return the scenario named by the command line with the options put in."""
    if source is not None and rerun is not None:
        raise ValueError("give either a scenario or --from, not both")
    changed = changes(given)
    path = rerun or (find(source) if source is not None else None)
    tables, folder = _tables(path, changed)
    return Scenario.from_dict(tables, folder=folder)


def _tables(
    path: Path | None, changed: dict[str, dict[str, Any]], tables: Mapping[str, Any] | None = None
) -> tuple[dict[str, Any], Path | None]:
    """Return the tables of a scenario with the options put in, and where its files begin."""
    if path is None and tables is None and "kind" not in changed.get("system", {}):
        raise ValueError(
            "name what to run: a scenario (`latolato scenarios` lists them), a TOML file, "
            f"--from FILE or --system with one of {', '.join(systems)}"
        )
    if tables is None:
        tables = read_tables(path) if path else {}
    if "drive" in changed and tables.get("drive", {}).get("kind", "static") == "static":
        changed["drive"].setdefault("kind", "harmonic")
    return overridden(dict(tables), changed), path.parent if path else None


def _selection(texts: Sequence[str], dataset: xr.Dataset) -> dict[str, Any]:
    """Return the values of dimensions that options name, in SI units."""
    from latolato.units import to_si

    found: dict[str, Any] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        name = name.replace("-", "_")
        if not equals or not value:
            raise ValueError(f"--select must be NAME=VALUE, such as restitution=0.9, got {text!r}")
        is_text = name not in dataset.coords or dataset[name].dtype.kind not in "iuf"
        unit = "1" if is_text else str(dataset[name].attrs.get("units", "1"))
        found[name] = value if is_text and not value.isdigit() else to_si(name, value, unit)
    return found


def _check_targets(
    output: Path | None, plot: Path | None, animate: Path | None, speed: float, fps: float
) -> None:
    """Raise before any work if a file that is asked for cannot be written."""
    from latolato import files

    for path in (output, plot, animate):
        if path is not None:
            files.check_folder(path)
    if output is not None:
        files.check_target(output)
    if plot is not None:
        files.check_suffix(plot, PICTURES, "the name of a picture")
    if animate is not None:
        from latolato.figures.animate import check_target

        check_target(animate, speed, fps)


def _write(
    run: xr.Dataset,
    output: Path | None,
    plot: Path | None,
    animate: Path | None,
    speed: float,
    fps: float,
) -> list[Path]:
    """Write the files that are asked for and return their names."""
    written = []
    if output is not None:
        from latolato.files import save

        written.append(save(run, output))
    if plot is not None:
        from latolato.figures import run as picture
        from latolato.figures.style import save_figure

        written.append(save_figure(picture.plot(run), plot))
    if animate is not None:
        from latolato.figures import animate as movie

        with _progress("animating") as progress:
            written.append(movie.animate(run, animate, speed=speed, fps=fps, progress=progress))
    return written


@contextmanager
def _uncollected() -> Iterator[None]:
    """Look for no garbage: while modules load, that costs a sixth of a short command's time."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


@contextmanager
def _progress(text: str) -> Iterator[Callable[[float], None] | None]:
    """Give a function that shows a bar on standard error, on a screen and for long work only."""
    if not sys.stderr.isatty():
        yield None
        return
    bar: Any = None
    begun = time.perf_counter()

    def show(fraction: float) -> None:
        nonlocal bar
        if bar is None and time.perf_counter() - begun > _PATIENCE:
            from rich.console import Console
            from rich.progress import Progress

            bar = Progress(console=Console(stderr=True), transient=True)
            bar.add_task(text, total=1.0)
            bar.start()
        if bar is not None:
            bar.update(bar.task_ids[0], completed=fraction)

    try:
        yield show
    finally:
        if bar is not None:
            bar.stop()


def _as_text(found: Mapping[str, Any]) -> str:
    """Return a summary as lines for reading."""
    contacts = ", ".join(f"{count} {kind}" for kind, count in found["contacts"].items())
    energy = found["largest_energy"]  # None beyond all floats
    largest = f"{energy:.3g} J" if energy is not None else "more than floats hold"
    lines = {
        "run": f"{found['system']}, drive {found['drive']}, {found['duration']:g} s",
        "status": found["status"],
        "largest angle": f"{found['largest_angle']:.6g} rad",
        "contacts": contacts or "none",
        "energy residual": f"{found['energy_residual']:.2g} J of {largest}",
        "wall time": f"{found['wall_time']:.2f} s",
        "written": ", ".join(found["files"]) or "nothing; name a file with --output",
    }
    return "\n".join(f"{name:16} {text}" for name, text in lines.items())
