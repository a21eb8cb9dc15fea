"""`latolato reproduce`: the report on the paper."""

from __future__ import annotations

from dataclasses import asdict
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli.options import JsonOption
from latolato.cli.output import print_summary
from latolato.core.errors import InputError
from latolato.io.progress import bar

if TYPE_CHECKING:
    from latolato.paper.report import Result

# Where the report is written, and where `latolato app` looks for it.
REPORT = Path("latolato-report")


def reproduce(
    quick: Annotated[bool, typer.Option(help="Coarser report in about two minutes.")] = False,
    full: Annotated[
        bool, typer.Option("--full", help="Film every trial of Figs. 9 and 11: about an hour.")
    ] = False,
    output: Annotated[Path, typer.Option(help="Folder of the report.")] = REPORT,
    paper: Annotated[str, typer.Option(help="Package of the paper.")] = "latolato.paper",
    as_json: JsonOption = False,
) -> None:
    """Reproduce the paper's figures and judge its claims in a report."""
    from latolato.paper import report

    if find_spec(paper.partition(".")[0]) is None or find_spec(f"{paper}.about") is None:
        raise InputError(
            "must be the name of a package",
            parameter="paper",
            value=paper,
            way_out="CONTRIBUTING.md says how to add a paper",
        )
    package = import_module(paper)
    with bar("reproducing") as progress:
        result = report.reproduce(output, quick=quick, full=full, progress=progress, paper=package)
    print_result(result, as_json=as_json)


def print_result(result: Result, *, as_json: bool) -> None:
    """Print the claims, what could not be made, and the path of the report."""
    if not as_json:
        from rich.console import Console

        from latolato.paper.report import claims_table

        Console().print(claims_table(result.claims))
    left_out = {"left out": "; ".join(result.left_out)} if result.left_out else {}
    print_summary(summarise(result), left_out, as_json=as_json)


def summarise(result: Result) -> dict[str, Any]:
    """Return the judged claims, what could not be made and the report as JSON knows them."""
    from latolato.simulation.summary import plain

    claims = [asdict(claim) | {"verdict": claim.verdict.value} for claim in result.claims]
    return {
        "claims": plain(claims),
        "left_out": list(result.left_out),
        "files": [str(result.index)],
    }
