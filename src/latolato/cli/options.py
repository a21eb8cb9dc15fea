"""Options as commands take them: each once, some shared, one for each parameter of a law."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand
from typer.models import ArgumentInfo

from latolato.core.errors import InputError, python_name
from latolato.core.parameters import Parameter, flag_of
from latolato.core.registry import suggest
from latolato.scenario.options import law_options

if TYPE_CHECKING:
    from latolato.experiment.sidecar import Pivot, Place

# What typer raises for wrong options; its name has moved between versions.
UsageError: Any = typer.BadParameter.__mro__[1]

ScenarioArgument = Annotated[str | None, typer.Argument(help="A scenario's name or TOML file.")]
OutputOption = Annotated[
    Path | None, typer.Option(help="Result file: .nc.", rich_help_panel="Output")
]
# An analysis also fits tables, which other programs and the Map page read.
TablesOption = Annotated[
    Path | None, typer.Option(help="Result file: .nc or .csv.", rich_help_panel="Output")
]
PlotOption = Annotated[
    Path | None, typer.Option(help="Picture: .png, .svg or .pdf.", rich_help_panel="Output")
]
ColumnOption = Annotated[
    list[str] | None,
    typer.Option(
        # Round brackets: square ones are taken for markup.
        help='Column of another program\'s table: time="t (s)", angle_1="theta (deg)". '
        "May be given several times.",
        rich_help_panel="Table",
    ),
]
JsonOption = Annotated[
    bool, typer.Option("--json", help="Print the summary as JSON.", rich_help_panel="Output")
]
BallsOption = Annotated[int | None, typer.Option(help="How many balls swing: 1 or 2.")]
BallOption = Annotated[
    list[str] | None,
    typer.Option(
        metavar="U,V",
        help="Column and row of a ball's centre in the frame of --pivot; give it twice for two "
        "balls. Without it, the video is searched for balls.",
    ),
]
Command = Callable[..., Any]
# What the help calls values with commas between them.
SEVERAL = "VALUES"
# Options that choose the samples of a single run.
SAMPLE_OPTIONS = ("times", "samples", "frame")


class StrictCommand(TyperCommand):
    """A command that refuses what typer would misread, and calls parameters by its options.

    Typer takes the last of an option that is given twice, and of values with spaces between them
    only the first.
    """

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Return the arguments that are left when the options are read."""
        lists = {flag for p in self.params if p.metavar == SEVERAL for flag in p.opts}
        for flag, *values in zip(args, args[1:], args[2:], strict=False):
            if flag in lists and all(map(_begins_with_number, values)):
                raise UsageError(
                    f"values of {flag} need commas between them: write {flag} {','.join(values)}"
                )
        *_, parameters = self.make_parser(ctx).parse_args(list(args))
        for parameter in parameters:
            count = parameters.count(parameter)
            if count > 1 and not getattr(parameter, "multiple", False):
                flag = max(parameter.opts, key=len)
                raise UsageError(f"option {flag} must be given once, it was given {count} times")
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Return what the command returns; what it refuses is said with its options.

        What was typed is called by its option; what a file gives is called as there.
        """
        try:
            return super().invoke(ctx)
        except InputError as error:
            if not error.is_of_file:
                error.name_of = self.name_of
                name, *rest = re.split(r"\b(?=\W)", error.parameter or "", maxsplit=1)
                if ctx.params.get(name) is not None:
                    error.parameter = self.name_of(name) + "".join(rest)
            raise

    def name_of(self, parameter: str, value: str = "") -> str:
        """Return the option of a parameter, or its name where the command has none.

        An option that is given once for each of several values is called by one of them.
        """
        flags = [flag for each in self.params for flag in each.opts]
        for name in (parameter, parameter.removesuffix("s")):
            if flag_of(name) in flags:
                return flag_of(name, value)
        return python_name(parameter, value)


def _begins_with_number(text: str) -> bool:
    return re.match(r"[-+]?\.?\d", text) is not None


def command_from(
    run: Command, name: str, text: str, *, panel: str | None = None, hidden: bool = False
) -> Any:
    """Return the command that runs a function; `text` is its help."""
    app = typer.Typer(add_completion=False)
    # Typer keeps the ends of a docstring's lines; the terminal's width shall decide.
    text = "\n\n".join(" ".join(part.split()) for part in text.split("\n\n"))
    app.command(name, cls=StrictCommand, help=text, rich_help_panel=panel, hidden=hidden)(run)
    return typer.main.get_command(app)


def named_values(flag: str, texts: Sequence[str] | None, example: str) -> dict[str, str]:
    """Return the names and values of an option that is given as NAME=VALUE, several times.

    Raises
    ------
    InputError
        For a text without ``=`` or value, and a name that is given twice.
    """
    values: dict[str, str] = {}
    for text in texts or ():
        name, equals, value = (part.strip() for part in text.partition("="))
        name = name.replace("-", "_")
        if not equals or not value:
            raise InputError(f"must be {example}", parameter=flag, value=text)
        if name in values:
            raise InputError(f"{flag} {name} is given twice")
        values[name] = value
    return values


def columns_of(texts: Sequence[str] | None) -> dict[str, str] | None:
    """Return the columns of another program's table that options name, None without any."""
    return named_values("--column", texts, "NAME=COLUMN, as in time='t [s]'") or None


def place_of(flag: str, text: str) -> tuple[float, float]:
    """Return a column and a row.

    Examples
    --------
    >>> place_of("--pivot", "640.5, 194")
    (640.5, 194.0)
    """
    u, v = pixels_of(flag, text, "a column and a row in pixels such as 640,200")
    return u, v


def pixels_of(flag: str, text: str, example: str) -> list[float]:
    """Return numbers with commas between them, as many as the last word of an example has.

    Examples
    --------
    >>> pixels_of("--region", "0, 20, 500.5, 300", "four edges such as 0,0,640,480")
    [0.0, 20.0, 500.5, 300.0]
    """
    parts = text.split(",")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = []
    if len(numbers) != 1 + example.split()[-1].count(","):
        raise InputError(f"must be {example}", parameter=flag, value=text)
    return numbers


def balls_of(count: int | None, texts: Sequence[str] | None) -> tuple[Place, ...] | int | None:
    """Return the places of the balls that `--ball` points at, or how many `--balls` says there are.

    Raises
    ------
    InputError
        For more than two, or another number of places than of balls.
    """
    places = tuple(place_of("--ball", text) for text in texts or ())
    if count is not None and count not in (1, 2):
        raise InputError("must be 1 or 2", parameter="--balls", value=count)
    if count is not None and places and len(places) != count:
        raise InputError(f"--balls {count} needs --ball {count} times", value=len(places))
    if len(places) > 2:
        raise InputError("may be given twice at most", parameter="--ball", value=len(places))
    return places or count


def pivots_of(texts: Sequence[str] | None) -> Pivot | tuple[Pivot, ...] | None:
    """Return the pivot that `--pivot` points at, or both; a place or ``"outside"`` each.

    Raises
    ------
    InputError
        For more than two.
    """
    from latolato.experiment.sidecar import OUTSIDE

    if not texts:
        return None
    if len(texts) > 2:
        raise InputError("may be given twice at most", parameter="--pivot", value=len(texts))
    pivots: tuple[Pivot, ...] = tuple(
        OUTSIDE if text == OUTSIDE else place_of("--pivot", text) for text in texts
    )
    return pivots[0] if len(pivots) == 1 else pivots


def values_of(
    flag: str, texts: Sequence[str] | None, known: Mapping[str, Parameter]
) -> dict[str, Any]:
    """Return the values of known parameters that an option gives as NAME=VALUE, in SI units.

    Raises
    ------
    InputError
        As `named_values`, for an unknown name and a value of another kind.
    """
    from latolato.scenario.analysis_options import read_value

    values = {}
    for name, text in named_values(flag, texts, "NAME=VALUE").items():
        if name not in known:
            raise InputError(f"{flag} has no '{name}': {suggest(name, list(known))}")
        values[name] = read_value(known[name], text)
    return values


def note_of(option: Parameter) -> str:
    """Return the description of an option's default."""
    if option.is_required:
        has_law = option.name in law_options() and not option.several
        return "; by default the scenario's" if has_law else "; needed"
    if option.default is None or option.kind is bool:
        return ""
    several = isinstance(option.default, (list, tuple))
    values = option.default if several else [option.default]
    text = ", ".join(f"{v:.6g}" if isinstance(v, float) else str(v) for v in values)
    of_run = "the scenario's, else " if option.owner == "run" else ""
    return f"; by default {of_run}{text}"


def option_of(parameter: Parameter, panel: str | None = None, note: str = "") -> inspect.Parameter:
    """Return the argument from which typer makes an option; quantities come as texts."""
    typed: Any = str
    if parameter.several and parameter.kind is str:
        typed = list[str]  # given several times
    elif parameter.kind in (bool, int) and not parameter.several:
        typed = parameter.kind
    flag, unit = parameter.flag, parameter.unit
    about = typer.Option(
        f"{flag}/--no-{flag[2:]}" if typed is bool else flag,
        help=parameter.help + (f", in {unit}" if unit not in ("", "1") else "") + note,
        rich_help_panel=parameter.owner.title() or panel,
        metavar=None if typed is bool else SEVERAL if parameter.several else "VALUE",
    )
    return inspect.Parameter(
        parameter.name,
        inspect.Parameter.KEYWORD_ONLY,
        default=None,
        annotation=Annotated[typed | None, about],
    )


def with_options(
    options: Iterable[Parameter], panel: str | None = None
) -> Callable[[Command], Command]:
    """Return the decorator that gives a command the options of a function, before its own ones.

    `panel` is the heading in the help of those that no law or run owns.
    """
    ordered = sorted(options, key=lambda option: option.owner == "run")
    return _adding([option_of(each, panel, note_of(each)) for each in ordered], first=True)


def with_law_options(
    without: Container[str] = (), further: Iterable[Parameter] = ()
) -> Callable[[Command], Command]:
    """Return the decorator that gives a command an option for each parameter of a law or a run."""
    own = (option for option in law_options().values() if option.name not in without)
    return _adding([option_of(each) for each in (*further, *own)])


def _adding(options: list[inspect.Parameter], *, first: bool = False) -> Callable[..., Command]:
    """Return the decorator that spells out the keyword arguments of a command as options."""

    def spell_out(command: Command) -> Command:
        signature = inspect.signature(command, eval_str=True)
        declared = [
            parameter.replace(kind=parameter.KEYWORD_ONLY)
            for parameter in signature.parameters.values()
            if parameter.kind is not parameter.VAR_KEYWORD
        ]
        # The context of a command has no mark of typer.
        marks = [getattr(p.annotation, "__metadata__", (None,))[0] for p in declared]
        words = sum(isinstance(mark, ArgumentInfo) for mark in marks)
        place = words if first else len(declared)
        parameters = [*declared[:place], *options, *declared[place:]]
        command.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
        return command

    return spell_out
