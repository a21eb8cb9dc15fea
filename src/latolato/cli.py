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
            if count > 1:
                flag = max(parameter.opts, key=len)
                raise _UsageError(f"option {flag} must be given once, got it {count} times")
        return super().parse_args(ctx, args)


def _with_law_options(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command whose keyword arguments are spelled out as options."""
    panels = {"system": "System", "drive": "Drive", "run": "Run", "noise": "Noise"}
    signature = inspect.signature(command, eval_str=True)
    parameters = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
    for option in law_options().values():
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
            print(f"{name:20} {figure:12} {scenario.title}")


@scenarios_app.command()
def show(name: Annotated[str, typer.Argument(help="The scenario's name.")]) -> None:
    """Print a scenario's TOML file, to copy and change."""
    load_scenario(name)
    print(find(name).read_text(encoding="utf-8"), end="")


@app.command(cls=_EachOptionOnce)
def plot(
    file: Annotated[Path, typer.Argument(help="A result file.")],
    output: Annotated[
        Path | None, typer.Option(help="Picture; by default beside the file, as PNG.")
    ] = None,
    animate: Annotated[Path | None, typer.Option(help="Animation: .mp4 or .gif.")] = None,
    speed: Annotated[float, typer.Option(help="How much faster it plays.")] = 1.0,
    fps: Annotated[float, typer.Option(help="Frames a second.")] = 30.0,
) -> None:
    """Draw a result file, and animate it if asked to."""
    from latolato.files import load

    run = load(file)
    picture = output or file.with_suffix(".png")
    _check_targets(None, picture, animate, speed, fps)
    for path in _write(run, None, picture, animate, speed, fps):
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
    except (ValueError, TypeError, RuntimeError, ModuleNotFoundError) as error:
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
    if path is None and "kind" not in changed.get("system", {}):
        raise ValueError(
            "name what to run: a scenario (`latolato scenarios` lists them), a TOML file, "
            f"--from FILE or --system with one of {', '.join(systems)}"
        )
    tables = read_tables(path) if path else {}
    if "drive" in changed and tables.get("drive", {}).get("kind", "static") == "static":
        changed["drive"].setdefault("kind", "harmonic")
    folder = path.parent if path else None
    return Scenario.from_dict(overridden(tables, changed), folder=folder)


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
