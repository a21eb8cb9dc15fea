"""`latolato fit`: one command for each fit."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli.law_options import laws_of
from latolato.cli.options import (
    ColumnOption,
    JsonOption,
    OutputOption,
    PlotOption,
    columns_of,
    values_of,
)
from latolato.cli.output import Targets, print_summary
from latolato.cli.registered import RegistryGroup, command_of
from latolato.core.errors import as_read

if TYPE_CHECKING:
    from latolato.core.parameters import Parameter
    from latolato.experiment.fits.registry import FitKind
    from latolato.experiment.fits.result import Fit

TableArgument = Annotated[Path, typer.Argument(help="Track table, or another program's.")]


class FitGroup(RegistryGroup):
    """The commands of the registered fits."""

    kind = "fit"

    def entries(self) -> Mapping[str, FitKind]:
        """Return the fits."""
        from latolato.experiment.fits import fits

        return dict(sorted(fits.items()))

    def make_command(self, name: str) -> Any:
        """Return the command of a fit."""
        from latolato.scenario.analysis_options import options_of
        from latolato.scenario.options import law_options

        kind = self.entries()[name]
        own = options_of(kind.function)
        if "prior" in kind.parameters:
            own["prior"] = prior_option()

        def fit(
            table: TableArgument,
            column: ColumnOption = None,
            output: OutputOption = None,
            plot: PlotOption = None,
            as_json: JsonOption = False,
            **values: Any,
        ) -> None:
            from latolato.experiment.importing import read_measured

            targets = Targets(output, plot)
            targets.check("the result of a fit")
            measured = read_measured(table, columns_of(column))
            if measured.attrs.get("assumed"):
                print(f"latolato: {measured.attrs['assumed']}", file=sys.stderr)
            result = kind.function(measured, **arguments_of(kind, own, values))
            files = [str(path) for path in targets.write(result.dataset)]
            print_summary(result.to_dict() | {"files": files}, lines_of(result), as_json=as_json)

        has_laws = "system" in kind.parameters
        unfit = [
            option.name
            for option in law_options().values()
            if option.owner in ("run", "noise") or option.name in own or not has_laws
        ]
        return command_of(name, kind.function, fit, own, without=unfit)


def prior_option() -> Parameter:
    """Return the option of what is known beforehand, which names and values are written for."""
    from latolato.core.parameters import Parameter
    from latolato.core.quantities import ANY, Quantity

    return Parameter(
        name="prior",
        kind=str,
        description='standard deviation of an unknown parameter about its value: "length = 2 mm"',
        quantity=Quantity("", "", "prior"),
        allowed=ANY,
        several=True,
    )


def arguments_of(
    kind: FitKind, own: Mapping[str, Parameter], values: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the arguments of a fit that options give."""
    from latolato.scenario import analysis_options

    arguments = analysis_options.arguments_of(own, values)
    for name, option in own.items():
        if option.several and option.kind is str and name in arguments:
            # Names of parameters, which options spell with dashes.
            arguments[name] = [text.replace("-", "_") for text in arguments[name]]
    if values.get("prior"):
        from latolato.scenario.options import law_options

        numbers = {name: option for name, option in law_options().items() if option.is_number}
        arguments["prior"] = values_of("--prior", values["prior"], numbers)
    if "system" in kind.parameters:
        from latolato.physics.pendulum import systems

        missing = f"name the system: --system with one of {', '.join(systems)}"
        arguments["system"], arguments["drive"], _ = laws_of(values, missing=missing)
    return arguments


def lines_of(fit: Fit) -> dict[str, str]:
    """Return a fit as names and texts for reading."""
    lines = {"fit": f"{fit.kind}: {fit.verdict}"}
    for name, estimate in fit.estimates.items():
        low, high = (as_read(f"{end:.6g}") for end in (estimate.low, estimate.high))
        text = f"{estimate} (95 %: {low} to {high})"
        lines[name] = text if fit.describes else f"not a result: {text}"
    return lines
