"""What `latolato analyse` does: one command for each analysis, made when it is asked for."""

from __future__ import annotations

import inspect
import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from latolato.cli.options import (
    EachOptionOnce,
    JsonOption,
    PlotOption,
    ScenarioArgument,
    with_law_options,
)
from latolato.core.errors import InputError
from latolato.io.progress import working
from latolato.scenario.analysis_call import AnalysisCall, axes_of, unfit_options

if TYPE_CHECKING:
    import xarray as xr

    from latolato.scenario.analysis_options import AnalysisOption


OutputOption = Annotated[
    Path | None,
    typer.Option(help="Result file: .nc.", rich_help_panel="Output"),
]


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


def parameter_of(option: AnalysisOption) -> inspect.Parameter:
    """Return the parameter of a command from which typer makes an option."""
    typed: Any = option.kind if option.kind in (bool, int) and not option.is_sequence else str
    metavar = "VALUES" if option.is_sequence else "VALUE"
    about = typer.Option(
        f"{option.flag}/--no-{option.flag[2:]}" if typed is bool else option.flag,
        help=option.help(),
        rich_help_panel="Start and run" if option.is_of_run else "Analysis",
        show_default=False,
        metavar=None if typed is bool else metavar,
    )
    return inspect.Parameter(
        option.name,
        inspect.Parameter.KEYWORD_ONLY,
        default=None,
        annotation=Annotated[typed | None, about],
    )


def make_command(name: str, function: Callable[..., Any]) -> Any:
    """Return the command of one analysis."""
    from latolato.scenario.analysis_options import options_of, plain_text, summary_of

    own = options_of(function)

    def command(
        scenario: ScenarioArgument = None,
        output: OutputOption = None,
        plot: PlotOption = None,
        as_json: JsonOption = False,
        **given: Any,
    ) -> None:
        run(
            AnalysisCall(name, function, own),
            scenario,
            given,
            Targets(output, plot),
            as_json=as_json,
        )

    signature = inspect.signature(command, eval_str=True)
    first, *output, rest = signature.parameters.values()
    of_analysis = sorted(own.values(), key=lambda option: option.is_of_run)
    command.__signature__ = signature.replace(  # type: ignore[attr-defined]
        parameters=[
            first.replace(kind=first.KEYWORD_ONLY),
            *map(parameter_of, of_analysis),
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


@dataclass(frozen=True)
class Targets:
    """What is to be written: a result file and a picture."""

    output: Path | None
    plot: Path | None

    def check(self, name: str) -> None:
        """Raise before any work if one of them cannot be written."""
        from latolato.cli.simulate import check_targets
        from latolato.io.files import check_suffix, check_target

        if self.output is not None:
            check_suffix(self.output, (".nc",), "the result of an analysis")
            check_target(self.output)
        check_targets(None, self.plot, None, 1.0, 30.0)
        if self.plot is not None:
            from latolato.figures.plot import picture_of

            picture_of("analysis", name)

    def write(self, found: xr.Dataset) -> list[Path]:
        """Write what is asked for and return the names."""
        written = []
        if self.output is not None:
            from latolato.io.files import save

            written.append(save(found, self.output))
        if self.plot is not None:
            from latolato.figures.plot import plot
            from latolato.figures.style import save_figure

            written.append(save_figure(plot(found), self.plot))
        return written


def run(
    call: AnalysisCall,
    source: str | None,
    given: Mapping[str, Any],
    targets: Targets,
    *,
    as_json: bool,
) -> None:
    """Run an analysis, write what is asked for and print what it found."""
    from latolato.analysis.summary import as_lines, summarise

    begun = time.perf_counter()
    targets.check(call.name)
    try:
        arguments = call.arguments(source, given)
        with working(call.name.replace("_", " ")):
            found = call.function(**arguments)
    except InputError as error:
        varied = ", ".join(n for n in axes_of(source) if given.get(n) is None)
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
