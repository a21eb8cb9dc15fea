"""The command line: reads options, hands them on, and turns errors into one line."""

from __future__ import annotations

import _thread
import signal
import sys
import threading
import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from inspect import getdoc
from typing import Annotated, Any

import typer

from latolato.cli.analyse import AnalysisGroup
from latolato.cli.fit import FitGroup
from latolato.cli.options import UsageError, command_from
from latolato.cli.registered import RegistryGroup
from latolato.core.faults import refusal_of, report_of
from latolato.scenario.scenario import find, load_scenario, scenarios

# Exit code of a fault of the program, EX_SOFTWARE of sysexits.h.
_FAULT = 70

# Panels of the help, in the order in which they are read.
_PLAY, _SIMULATE, _MEASURE, _PAPER = "Play and show", "Simulate", "Measure", "The paper"
# Panel of the commands, none for another spelling, module and function.
_COMMANDS = {
    "app": (_PLAY, "app", "app"),
    "site": (_PLAY, "site", "site"),
    "simulate": (_SIMULATE, "simulate", "simulate"),
    "sweep": (_SIMULATE, "sweep", "sweep"),
    "plot": (_SIMULATE, "plot", "plot"),
    "track": (_MEASURE, "track", "track"),
    "import": (_MEASURE, "importing", "import_"),
    "trials": (_MEASURE, "trials", "trials"),
    "compare": (_MEASURE, "compare", "compare"),
    "synthesise": (_MEASURE, "synthesise", "synthesise"),
    "synthesize": (None, "synthesise", "synthesise"),
    "reproduce": (_PAPER, "reproduce", "reproduce"),
}


class Commands(RegistryGroup):
    """The commands, each imported when it is asked for: its options come from what it calls."""

    kind = "command"

    def entries(self) -> Mapping[str, Any]:
        """Panel, module and function of each command."""
        return _COMMANDS

    def make_command(self, name: str) -> Any:
        """Return a command."""
        panel, module, function = _COMMANDS[name]
        run = getattr(import_module(f"latolato.cli.{module}"), function)
        return command_from(run, name, getdoc(run) or "", panel=panel, hidden=panel is None)


app = typer.Typer(
    cls=Commands,
    name="latolato",
    help="Driven and colliding pendula: play, simulate, measure, reproduce the paper.",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
scenarios_app = typer.Typer(help="List the scenarios that come with latolato, or show one.")
app.add_typer(scenarios_app, name="scenarios", rich_help_panel=_SIMULATE)
analyse_app = typer.Typer(
    cls=AnalysisGroup,
    help="Analyse a system and its drive: periods, stability, thresholds, basins.",
)
app.add_typer(analyse_app, name="analyse", rich_help_panel=_SIMULATE)
app.add_typer(analyse_app, name="analyze", hidden=True)
fit_app = typer.Typer(cls=FitGroup, help="Fit physics to a track table.")
app.add_typer(fit_app, name="fit", rich_help_panel=_MEASURE)


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and the processor.")
    ] = False,
) -> None:
    if version:
        from latolato import __version__
        from latolato.numerics.shipped import this_processor, tuned_for_lanes

        processor = this_processor()
        lanes = tuned_for_lanes(processor)
        print(f"latolato {__version__}")
        print(f"compiles for {processor.name}, lanes as for {lanes.name}")
    elif context.invoked_subcommand is None:
        print(context.get_help())


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


@app.command(rich_help_panel=_PAPER)
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
            # Ctrl-C in one of Zarr's calls can leave a coroutine that nothing has begun.
            warnings.filterwarnings("ignore", "coroutine .* was never awaited", RuntimeWarning)
            return _exit_code(arguments)
    finally:
        signal.signal(signal.SIGTERM, before)
        sys.unraisablehook = hook


def _exit_code(arguments: Sequence[str] | None) -> int:
    """Run the command line, print an error as one line and return the exit code."""
    try:
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
