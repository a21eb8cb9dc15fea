"""The reproduction report: every claim with its verdict, every figure with its data, one page."""

from __future__ import annotations

import os
import secrets
import shutil
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import latolato.paper
from latolato import InputError
from latolato.paper.claim import Claim, Evidence, Verdict
from latolato.paper.powers import rewritten_powers

if TYPE_CHECKING:
    from rich.table import Table

    from latolato.paper.finding import Finding

# Shapes beside the words, so that no verdict depends on colour alone.
SHAPES = {
    Verdict.REPRODUCED: "●",
    Verdict.ASSUMED: "△",
    Verdict.NOT_AS_PRINTED: "✕",
    Verdict.METHOD_CHECK: "◇",
}
_COLOURS = {
    Verdict.REPRODUCED: "green",
    Verdict.ASSUMED: "yellow",
    Verdict.NOT_AS_PRINTED: "red",
    Verdict.METHOD_CHECK: "cyan",
}
INDEX = "index.html"
DPI, QUICK_DPI = 200, 150
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# Shares of the work, for the progress: computing, drawing.
_COMPUTED = 0.8


@dataclass(frozen=True)
class Result:
    """What `reproduce` wrote; may be used where a path of the report is wanted.

    Attributes
    ----------
    index : Path
        The report, ``index.html``.
    claims : tuple of Claim
        All judged claims, in the order of the report.
    left_out : tuple of str
        What could not be made, and why.
    """

    index: Path
    claims: tuple[Claim, ...]
    left_out: tuple[str, ...] = ()

    def __fspath__(self) -> str:
        return os.fspath(self.index)


def reproduce(
    folder: str | Path,
    *,
    quick: bool = False,
    full: bool = False,
    progress: Callable[[float], None] | None = None,
    paper: ModuleType = latolato.paper,
) -> Result:
    """Write figures, their data and a report on a paper's claims into a folder.

    Parameters
    ----------
    folder : str or Path
        Made if it does not exist. Files of an earlier report are replaced when everything is
        ready; other files are left alone.
    quick : bool
        Compute scans with fewer points, draw at a lower resolution, and film the decays of Figs. 7
        and 10 only.
    full : bool
        Send every trial of Figs. 9 and 11 through a synthetic video, not only ten of them.
    progress : callable, optional
        Called with the fraction done, from 0 to 1.
    paper : module
        The package of the paper; see `latolato.paper.about`.

    Returns
    -------
    Result
        The path of ``index.html`` and the claims.

    Raises
    ------
    InputError
        For both `quick` and `full`, and for `full` without the extra `video`.
    NotADirectoryError
        If `folder` is a file.
    OSError
        If the folder cannot be written.

    Notes
    -----
    Written are ``index.html`` (self-contained: it shows without a network and without the other
    files), for each figure ``figNN.png``, ``figNN.svg`` and ``figNN.nc``, the same for each result
    beyond the paper (``strings_*``, ``curves_*``), and a ``text_*.nc`` for each set of runs behind
    claims without a figure. An interrupted call leaves an earlier report
    as it was. Figures that go through a synthetic video are left out without the extra `video`,
    which the page and the result say.
    """
    from latolato.paper import chain

    if quick and full:
        raise InputError("a report is quick or full, not both")
    if full and chain.is_missing():
        raise InputError(f"a full report films every trial: {chain.MISSING}")
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"'{folder}' is a file; name a folder for the report")
    tell = progress or (lambda fraction: None)
    tell(0.0)
    folder.parent.mkdir(parents=True, exist_ok=True)
    # Inside a folder that exists: its neighbours may be on another disk, or nobody's to write.
    beside = folder if folder.exists() else folder.parent
    unfinished = beside / f".latolato.{os.getpid()}.{secrets.token_hex(3)}"
    try:
        unfinished.mkdir()
        claims, left_out = _write(paper, unfinished, quick, full, tell)
        if not folder.exists():
            os.replace(unfinished, folder)
        else:
            # The page last: until then it describes the files that it was made with.
            names = sorted(os.listdir(unfinished), key=lambda name: (name == INDEX, name))
            for name in names:
                os.replace(unfinished / name, folder / name)
    except OSError as error:
        if error.errno is None or not str(error.filename).startswith(str(unfinished)):
            raise
        # The temporary name would say nothing to anyone.
        raise OSError(error.errno, error.strerror, str(folder)) from None
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)
    tell(1.0)
    return Result(folder / INDEX, claims, left_out)


def _write(
    paper: ModuleType, folder: Path, quick: bool, full: bool, tell: Callable[[float], None]
) -> tuple[tuple[Claim, ...], tuple[str, ...]]:
    """Compute, draw and write all of it into an empty folder; return claims, what is missing."""
    from latolato import save
    from latolato.core.atomic import atomic_path
    from latolato.figures import style
    from latolato.paper import catalogue, chain
    from latolato.paper.page import Part, render

    entries = catalogue.evidence(paper)
    left_out: tuple[str, ...] = ()
    if chain.is_missing():
        films = [name for name, entry in entries.items() if entry.needs_video]
        left_out = tuple(f"{catalogue.title_of(name)}: {chain.MISSING}" for name in films)
        entries = {name: entry for name, entry in entries.items() if name not in films}
    everything: dict[str, Evidence | Finding] = {**entries, **catalogue.results(paper)}
    parts = []
    for done, (name, entry) in enumerate(everything.items()):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", RuntimeWarning)
            more = {"full": True} if full and getattr(entry, "needs_video", False) else {}
            dataset = entry.data(quick=quick, **more)
        tell((done + _COMPUTED) / len(everything))
        if entry.draw:
            figure = entry.draw(dataset)
            for suffix in (".png", ".svg"):
                path = folder / f"{name}{suffix}"
                style.save_figure(figure, path, dpi=QUICK_DPI if quick else DPI)
                figure.set_layout_engine("none")  # as it was found for the first file
        save(dataset, folder / f"{name}.nc")
        parts.append(
            Part(
                name=name,
                title=entry.title,
                caption=entry.caption if entry.draw else None,
                dataset=dataset,
                claims=tuple(entry.judge(dataset)) if isinstance(entry, Evidence) else (),
                words=None if isinstance(entry, Evidence) else entry.words(dataset),
                warnings=tuple(dict.fromkeys(str(warning.message) for warning in caught)),
            )
        )
        tell((done + 1.0) / len(everything))
    page = render(paper, parts, folder, quick=quick, left_out=left_out)
    with atomic_path(folder / INDEX) as unfinished:  # an error then names the file
        unfinished.write_text(page, encoding="utf-8")
    return tuple(claim for part in parts for claim in part.claims), left_out


def claims_table(claims: Sequence[Claim]) -> Table:
    """Return the claims as a table for the terminal."""
    from rich.box import SIMPLE
    from rich.markup import escape
    from rich.table import Table
    from rich.text import Text

    counts = "; ".join(
        f"{sum(claim.verdict is verdict for claim in claims)} {verdict.value}"
        for verdict in Verdict
    )
    table = Table(title="The paper's claims", caption=counts, box=SIMPLE, expand=True, leading=1)
    table.add_column("verdict", ratio=4)
    table.add_column("what the paper says", ratio=6)
    table.add_column("what an accurate calculation gives", ratio=10)
    for claim in claims:
        verdict = f"{SHAPES[claim.verdict]} {claim.verdict.value}"
        if claim.verdict is Verdict.METHOD_CHECK and not all(held for _, held in claim.criteria):
            verdict += "; the check failed"
        finding = plain(claim.finding)
        if claim.assumption:
            finding += f"\nAssumed: {plain(claim.assumption)}"
        table.add_row(
            Text.assemble(f"{claim.where}\n", (verdict, _COLOURS[claim.verdict])),
            escape(f"“{claim.words}”"),
            escape(finding),
        )
    return table


def plain(text: str) -> str:
    """Return text with powers of ten as people write them: 1e-09 as 10⁻⁹, 0e+00 as 0."""
    return rewritten_powers(text, lambda power: power.translate(_RAISED))
