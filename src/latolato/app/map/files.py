"""Files of the map on show: its numbers as tables and stores, its picture for print.

A map of the page is computed once more, by `latolato.sweep`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app.answers import Body
from latolato.app.blocks import content_of
from latolato.app.downloads import PICTURE_DPI, TYPES
from latolato.app.forms import units_of
from latolato.app.jobs import Job
from latolato.app.map.stored import check_observable, drawing_of, opened, path_of, with_spacing
from latolato.app.run_request import RunRequest, TooLargeError
from latolato.app.worker import Result
from latolato.core.errors import InputError
from latolato.core.quantities import quantity_of
from latolato.io.analysis_tables import read_curves
from latolato.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr

    from latolato.figures.map import Drawing, Look

    Progress = Callable[[float], None]

# Of a stored sweep with more axes than two.
MOST_BYTES = 200_000_000
_BALLS = ("right", "left")


def prepare(known: Mapping[str, Path], body: Mapping[str, Any]) -> Job:
    """Return the job that makes a file of the current map.

    A page sends its `kind`; `stored`, the name of a stored map, or the `options` and the `sweep`
    of its own; `observable` with `ball` and `select`; and how the map looks: `scale`, `log`,
    `limits`, `xlog`, `ylog`, `contours` (an observable with its `levels`), `overlays`, `trials`,
    and `curves`, texts of bifurcation curves.

    Raises
    ------
    InputError
        If no such map was named.
    """
    stored = body.get("stored")
    return Job(compute, Body(body, path=None if stored is None else path_of(known, stored)))


def scenario_of(body: Mapping[str, Any]) -> Scenario:
    """Return the sweep of a map that a page computed.

    Raises
    ------
    InputError
        For values that its runs cannot have.
    """
    base = RunRequest.from_json({"options": body["options"]}).to_scenario()
    return Scenario.from_dict({**base.to_dict(), "sweep": dict(body["sweep"])})


@dataclass(frozen=True)
class PageMap:
    """A map on show: all its numbers, and how a page shows it."""

    grid: xr.Dataset
    request: Mapping[str, Any]

    @property
    def missing(self) -> int:
        """Points that are not computed."""
        from latolato.sweeps.statuses import MISSING

        return int(np.sum(self.grid["status"].values == MISSING)) if "status" in self.grid else 0

    def drawing(self, variable: str, ball: Any) -> Drawing:
        """Return a variable as the library draws it, of a ball if each has its own."""
        from latolato.figures.map import Drawing

        if self.request["path"] is not None:
            return drawing_of(self.grid, variable, self.request)
        check_observable(self.grid, variable)
        inner = {"ball": ball or _BALLS[0], "sample": "0", "exponent": "0"}
        select = {d: value for d, value in inner.items() if d in self.grid[variable].dims}
        _, right = self.request["sweep"]["axes"]
        drawing = Drawing(self.grid, variable, log=False, select=select, right=right)
        return with_spacing(drawing, self.request)


def compute(request: Mapping[str, Any], folder: Path, progress: Progress) -> Result:
    """Make a file of a map.

    Raises
    ------
    InputError
        If a text holds no curve, or for values that its runs cannot have.
    """
    kind, path = request["kind"], request["path"]
    curves = [curve for text in request.get("curves") or [] for curve in read_curves(text)]
    if path is not None:
        grid = opened(path)
    else:
        grid = scenario_of(request).sweep(progress=lambda done, total: progress(done / total))
    page_map = PageMap(grid, request)
    if page_map.grid.nbytes > MOST_BYTES:
        raise TooLargeError(
            f"a download must not exceed {MOST_BYTES / 1e6:.0f} MB",
            value=page_map.grid.nbytes / 1e6,
            way_out="copy the file of this sweep instead",
        )
    target = folder / f"map.{kind}"
    if kind in ("png", "svg"):
        _write_picture(page_map, curves, target)
    else:
        from latolato.io.files import save

        save(_with_note(page_map), target)
    about = {"file": target.name, "type": TYPES[kind], "missing": page_map.missing}
    return about, {"file": content_of(target)}


def _with_note(page_map: PageMap) -> xr.Dataset:
    """Return the dataset; one that is not finished has a note of that."""
    if not page_map.missing:
        return page_map.grid
    total = page_map.grid["status"].size
    text = f"{page_map.missing} of {total} points are not computed: status is 'missing' there"
    return page_map.grid.assign_attrs(unfinished=text)


def _write_picture(page_map: PageMap, curves: list[xr.Dataset], target: Path) -> None:
    """Write the picture of a map as the page shows it."""
    from latolato.figures.style import save_figure

    request, points = page_map.request, None
    if request.get("trials") is not None:
        points = target.with_name("trials.csv")
        points.write_text(request["trials"], encoding="utf-8")
    drawing = page_map.drawing(request["observable"], request.get("ball"))
    drawing.log = bool(request.get("log")) and not drawing.classes
    over = [*(request.get("overlays") or []), *curves]
    figure = drawing.map(over, points, _look(page_map))
    save_figure(figure, target, dpi=PICTURE_DPI)


def _look(page_map: PageMap) -> Look:
    """Return the colours, their ends and the contour lines that a page shows."""
    from latolato.figures.contours import lines_of
    from latolato.figures.map import Look

    request = page_map.request
    limits = request.get("limits")
    colours: dict[str, Any] = {
        "colours": request.get("scale") or "viridis",
        "limits": None if limits is None else (float(limits[0]), float(limits[1])),
    }
    contours = request.get("contours")
    if contours is None:
        return Look(**colours)
    over = page_map.drawing(contours["observable"], contours.get("ball"))
    if over.classes:
        raise InputError(f"{over.name} has classes, not a scale: it has no contour lines")
    attributes = over.data.attrs
    unit = units_of(quantity_of(over.name, str(attributes.get("units", "1"))))[0]
    levels = sorted(set(map(float, contours["levels"])))
    return Look(
        **colours,
        lines=lines_of(over.values, over.status, sides=over.sides, levels=levels),
        unit=(unit["name"], unit["size"]),
        label=str(attributes.get("long_name", over.name)),
    )
