"""Commands made from the functions in a registry, each when it is asked for."""

from __future__ import annotations

import inspect
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

from typer.core import TyperGroup

from latolato.cli.options import command_from, with_law_options, with_options
from latolato.core.errors import InputError
from latolato.core.parameters import Parameter
from latolato.core.registry import suggest


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
        """Return the names of all entries, and of commands that stand beside them."""
        names = [name.replace("_", "-") for name in self.entries()]
        return [*names, *(name for name in self.commands if name not in self.entries())]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command of an entry, None for an unknown one."""
        name = cmd_name.replace("-", "_")
        return self.make_command(name) if name in self.entries() else self.commands.get(cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the function to run, or raise InputError with the closest known name."""
        known = self.list_commands(ctx)
        if args[0].replace("_", "-") not in known:
            raise InputError(f"unknown {self.kind} '{args[0]}': {suggest(args[0], known)}")
        return super().resolve_command(ctx, args)


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
        Does the work: takes arguments, options of its own, and all others as keywords.
    own : mapping of str to Parameter
        The options of the function.
    panel : str, optional
        The heading of these in the help.
    without : sequence of str
        The options of laws and runs that the command does not take.
    """
    from latolato.scenario.analysis_options import plain_text, summary_of

    source = (inspect.getdoc(function) or "").partition("\nParameters\n---")[0].split("\n\n")[1:2]
    text = "\n\n".join([summary_of(function), *map(plain_text, source)])
    run = with_law_options(without)(with_options(own.values(), panel)(run))
    return command_from(run, name.replace("_", "-"), text)
