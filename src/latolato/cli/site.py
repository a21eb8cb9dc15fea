"""`latolato site`: a static site for any web space."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from latolato.cli.options import JsonOption
from latolato.cli.output import print_summary
from latolato.core.errors import import_extra
from latolato.io.progress import bar


def site(
    folder: Annotated[Path, typer.Argument(help="Folder of the site.", metavar="FOLDER")],
    report: Annotated[
        Path | None,
        typer.Option(help="Folder of `latolato reproduce`. Default: make a quick report."),
    ] = None,
    docs: Annotated[Path | None, typer.Option(help="Folder of the built documentation.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Write Toy, Map, the report and the documentation as a site for any web space."""
    module = import_extra("latolato.app.site", "app", "the site")
    module.check_site(folder, report=report, docs=docs)
    if report is None:
        from latolato.paper.report import reproduce

        with bar("making the report") as progress:
            report = reproduce(folder / "report", quick=True, progress=progress).index.parent
    files = module.write_site(folder, report=report, docs=docs)
    size = sum(path.stat().st_size for path in files)
    address = f"http://127.0.0.1:8000, after python -m http.server --bind 127.0.0.1 -d {folder}"
    left_out = {} if docs else {"left out": "the documentation; give its folder with --docs"}
    print_summary(
        {"files": [str(folder / "index.html")], "count": len(files), "bytes": size},
        {"files": f"{len(files)}, {size / 1e6:.1f} MB", "look at it": address, **left_out},
        as_json=as_json,
    )
