"""Commands made from the functions in a registry, each when it is asked for."""

from __future__ import annotations

import inspect
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import typer
from typer.core import TyperGroup

from latolato.cli.options import EachOptionOnce, option_of, with_law_options
from latolato.core.errors import InputError
from latolato.core.parameters import Parameter
from latolato.core.registry import suggest
from latolato.scenario.options import law_options


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
        """Return the function to run, or raise InputError with the closest known name."""
        known = self.list_commands(ctx)
        if args[0].replace("_", "-") not in known:
            raise InputError(f"unknown {self.kind} '{args[0]}': {suggest(args[0], known)}")
        return super().resolve_command(ctx, args)


def _note(option: Parameter) -> str:
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


def command_of(
    name: str,
    function: Callable[..., Any],
    run: Callable[..., None],
    own: Mapping[str, Parameter],
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
    own : mapping of str to Parameter
        The options of the function.
    panel : str, optional
        The heading of these in the help.
    without : sequence of str
        The options of laws and runs that the command does not take.
    """
    from latolato.scenario.analysis_options import plain_text, summary_of

    signature = inspect.signature(run, eval_str=True)
    first, *others, rest = signature.parameters.values()
    options = [
        option_of(option, "Start and run" if option.owner == "run" else panel, _note(option))
        for option in sorted(own.values(), key=lambda option: option.owner)
    ]

    def command(**values: Any) -> None:
        several = {name: values[name] for name in own if isinstance(values[name], list)}
        run(**values | {name: ",".join(texts) for name, texts in several.items()})

    command.__signature__ = signature.replace(  # type: ignore[attr-defined]
        parameters=[
            first.replace(kind=first.KEYWORD_ONLY),
            *options,
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
    )(with_law_options(without)(command))
    return typer.main.get_command(app)
