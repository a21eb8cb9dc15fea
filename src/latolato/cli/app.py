"""`latolato app`: the application in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from latolato.cli.reproduce import REPORT
from latolato.core.errors import import_extra


def app(
    port: Annotated[
        int | None,
        typer.Option(
            help="Port; 0 for any free one. Default: 8765, if it is free.", min=0, max=65535
        ),
    ] = None,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser.")] = True,
    report: Annotated[
        Path | None,
        typer.Option(help="Folder of `latolato reproduce`. Default: latolato-report, if present."),
    ] = None,
    opened: Annotated[
        list[Path] | None,
        typer.Option(
            "--open",
            metavar="MAP",
            help="Store, .nc or .csv file of a sweep for the Map view; may be given several times.",
        ),
    ] = None,
) -> None:
    """Open the application in the browser: the toy, maps, measurements, analyses, the report."""
    if report is None and (REPORT / "index.html").is_file():
        report = REPORT
    import_extra("latolato.app.serve", "app", "the application").serve(
        port, browser=browser, report=report, stored=opened or ()
    )
