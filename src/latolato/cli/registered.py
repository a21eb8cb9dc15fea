"""Commands made from the functions in a registry, each when it is asked for."""

from __future__ import annotations

import inspect
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import typer
from typer.core import TyperGroup

from latolato.cli.options import EachOptionOnce, with_law_options
from latolato.core.errors import InputError
from latolato.core.registry import suggest

if TYPE_CHECKING:
    from latolato.scenario.analysis_options import AnalysisOption


class RegistryGroup(TyperGroup):
    """The commands of the entries of a registry; nothing is imported before one is asked for."""

    # What an entry is called.
    kind: ClassVar[str]

    @abstractmethod
    def entries(self) -> Mapping[str, Any]:
        """Return the registry."""

    @abstractmethod
    def make_command(self, name: str) -> Any:
        """Return the command of an entry."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all entries."""
        return sorted(name.replace("_", "-") for name in self.entries())

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command of an entry, None for an unknown one."""
        name = cmd_name.replace("-", "_")
        if name not in self.entries():
            return None
        if name not in self.commands:
            self.commands[name] = self.make_command(name)
        return self.commands[name]

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return what is to be run, or raise InputError with the closest known name."""
        known = self.list_commands(ctx)
        if args[0].replace("_", "-") not in known:
            raise InputError(f"unknown {self.kind} '{args[0]}': {suggest(args[0], known)}")
        return super().resolve_command(ctx, args)


def parameter_of(option: AnalysisOption, panel: str | None) -> inspect.Parameter:
    """Return the parameter of a command from which typer makes an option."""
    typed: Any = str
    if option.is_sequence and option.kind is str:
        typed = list[str]  # given several times
    elif option.kind in (bool, int) and not option.is_sequence:
        typed = option.kind
    metavar = "VALUES" if option.is_sequence else "VALUE"
    about = typer.Option(
        f"{option.flag}/--no-{option.flag[2:]}" if typed is bool else option.flag,
        help=option.help(),
        rich_help_panel="Start and run" if option.is_of_run else panel,
        show_default=False,
        metavar=None if typed is bool else metavar,
    )
    return inspect.Parameter(
        option.name,
        inspect.Parameter.KEYWORD_ONLY,
        default=None,
        annotation=Annotated[typed | None, about],
    )


def command_of(
    name: str,
    function: Callable[..., Any],
    run: Callable[..., None],
    own: Mapping[str, AnalysisOption],
    *,
    panel: str | None = None,
    without: Sequence[str],
) -> Any:
    """Return the command that runs a function, with an option for each of its parameters.

    Parameters
    ----------
    name : str
        What the command is called.
    function : callable
        Its docstring becomes the help.
    run : callable
        Does the work: takes an argument, options of its own, and all others as keywords.
    own : mapping of str to AnalysisOption
        The options of the function.
    panel : str, optional
        The heading of these in the help.
    without : sequence of str
        The options of laws and runs that the command does not take.
    """
    from latolato.scenario.analysis_options import plain_text, summary_of

    signature = inspect.signature(run, eval_str=True)
    first, *others, rest = signature.parameters.values()
    options = sorted(own.values(), key=lambda option: option.is_of_run)

    def command(**given: Any) -> None:
        several = {name: given[name] for name in own if isinstance(given[name], list)}
        run(**given | {name: ",".join(texts) for name, texts in several.items()})

    command.__signature__ = signature.replace(  # type: ignore[attr-defined]
        parameters=[
            first.replace(kind=first.KEYWORD_ONLY),
            *(parameter_of(option, panel) for option in options),
            *(each.replace(kind=each.KEYWORD_ONLY) for each in others),
            rest,
        ]
    )
    source = (inspect.getdoc(function) or "").partition("\nParameters\n---")[0].split("\n\n")[1:2]
    app = typer.Typer(add_completion=False)
    app.command(
        name.replace("_", "-"),
        cls=EachOptionOnce,
        help="\n\n".join([summary_of(function), *map(plain_text, source)]),
    )(with_law_options(command, without=without))
    return typer.main.get_command(app)
