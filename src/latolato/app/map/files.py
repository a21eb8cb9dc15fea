"""Files of the map on show: its numbers as tables and stores, its picture for print.

A map of the page is computed once more, by `latolato.sweep`.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app.blocks import pack_files
from latolato.app.downloads import PICTURE_DPI, TYPES
from latolato.app.forms import units_of
from latolato.app.jobs import Job
from latolato.app.map.stored import (
    MOST_CELLS,
    check_observable,
    drawing_of,
    opened,
    path_of,
    with_spacing,
)
from latolato.app.run_request import RunRequest, TooLargeError
from latolato.core.errors import InputError
from latolato.core.quantities import ANY, quantity_of
from latolato.core.registry import checked_number
from latolato.io.analysis_tables import read_curves
from latolato.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr

    from latolato.figures.map import Drawing, Look

    Progress = Callable[[float], None]

KINDS = {"csv": "text/csv", **TYPES, "zarr": "application/zip"}
SCALES = ("viridis", "cividis", "magma", "viridis_r")
# Of a stored sweep with more axes than two.
MOST_BYTES = 200_000_000
MOST_TRIALS = 1_000_000  # characters
MOST_LEVELS = 20
_BALLS = ("right", "left")


def prepare(known: Mapping[str, Path], body: Any) -> Job:
    """Return the job that makes a file of the current map.

    A page sends its `kind`; `stored`, the name of a stored map, or the `options` and the `sweep`
    of its own; `observable` with `ball` and `select`; and how the map looks: `scale`, `log`,
    `limits`, `xlog`, `ylog`, `contours` (an observable with its `levels`), `overlays`, `trials`,
    and `curves`, texts of bifurcation curves.

    Raises
    ------
    InputError
        For bad input.
    """
    if not isinstance(body, Mapping):
        raise InputError("a request must be an object", value=body)
    kind = body.get("kind")
    if kind not in KINDS:
        raise InputError(f"must be one of {', '.join(KINDS)}", parameter="kind", value=kind)
    if not isinstance(body.get("observable"), str):
        raise InputError("must be a text", parameter="observable", value=body.get("observable"))
    _check_look(body)
    request = dict(body)
    if body.get("stored") is not None:
        request["path"] = str(path_of(known, body["stored"]))
    else:
        scenario_of(body).plan()

    def finish(about: dict[str, Any], folder: Path) -> bytes:
        return pack_files({**about, "type": KINDS[kind]}, {"file": folder / about["file"]})

    return Job("map_file", request, finish)


def scenario_of(body: Mapping[str, Any]) -> Scenario:
    """Return the sweep of a map that a page computed; no file is read for it.

    Raises
    ------
    InputError
        For bad input.
    """
    sweep = body.get("sweep")
    if not isinstance(sweep, Mapping):
        raise InputError("must be an object", parameter="sweep", value=sweep)
    axes, watched = sweep.get("axes"), sweep.get("observables")
    if not isinstance(axes, Mapping) or len(axes) != 2 or not all(map(_are_numbers, axes.values())):
        raise InputError("must be two lists of numbers", parameter="axes")
    count = int(np.prod([len(values) for values in axes.values()]))
    if count > MOST_CELLS:
        raise TooLargeError(f"width x height must not exceed {MOST_CELLS} cells", value=count)
    if not isinstance(watched, list) or not all(map(_is_observable, watched)):
        raise InputError("must be objects with a kind and numbers", parameter="observables")
    base = RunRequest.from_json({"options": body.get("options")}).to_scenario()
    return Scenario.from_dict({**base.to_dict(), "sweep": dict(sweep)})


def _are_numbers(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(each, (int, float)) for each in value)


def _is_observable(value: Any) -> bool:
    """Return whether a value names an observable and gives it nothing but numbers."""
    if not isinstance(value, Mapping) or not isinstance(value.get("kind"), str):
        return False
    return all(isinstance(each, (int, float)) for name, each in value.items() if name != "kind")


@dataclass(frozen=True)
class PageMap:
    """A map on show: all its numbers, how a page shows it, and the file that it comes from."""

    grid: xr.Dataset
    request: Mapping[str, Any]
    path: Path | None = None

    @property
    def missing(self) -> int:
        """Points that are not computed."""
        from latolato.sweeps.statuses import MISSING

        return int(np.sum(self.grid["status"].values == MISSING)) if "status" in self.grid else 0

    def drawing(self, variable: str, ball: Any) -> Drawing:
        """Return a variable as the library draws it, of a ball if each has its own."""
        from latolato.figures.map import Drawing

        if self.path is not None:
            return drawing_of(self.grid, variable, self.request)
        check_observable(self.grid, variable)
        inner = {"ball": ball or _BALLS[0], "sample": "0", "exponent": "0"}
        select = {d: value for d, value in inner.items() if d in self.grid[variable].dims}
        _, right = self.request["sweep"]["axes"]
        drawing = Drawing(self.grid, variable, log=False, select=select, right=right)
        return with_spacing(drawing, self.request)


def compute(request: Mapping[str, Any], folder: Path, progress: Progress) -> dict[str, Any]:
    """Make a file of a map: what the job `map_file` does in its process."""
    kind, path = request["kind"], request.get("path")
    store = folder / "map.zarr" if kind == "zarr" and path is None else None
    if path is not None:
        page_map = PageMap(opened(Path(path)), request, Path(path))
    else:
        grid = scenario_of(request).sweep(
            store=store, progress=lambda done, total: progress(done / total)
        )
        page_map = PageMap(grid, request)
    if page_map.grid.nbytes > MOST_BYTES:
        raise TooLargeError(
            f"a download must not exceed {MOST_BYTES / 1e6:.0f} MB",
            value=page_map.grid.nbytes / 1e6,
            way_out="copy the file of this sweep instead",
        )
    target = folder / f"map.{'zip' if kind == 'zarr' else kind}"
    if kind in ("png", "svg"):
        _write_picture(page_map, target, folder)
    elif kind == "zarr":
        _zip(store or _store_of(page_map, folder), target)
    else:
        from latolato.io.files import save

        save(_with_note(page_map), target)
    return {"file": target.name, "missing": page_map.missing}


def _with_note(page_map: PageMap) -> xr.Dataset:
    """Return the dataset; one that is not finished has a note of that."""
    if not page_map.missing:
        return page_map.grid
    total = page_map.grid["status"].size
    text = f"{page_map.missing} of {total} points are not computed: status is 'missing' there"
    return page_map.grid.assign_attrs(unfinished=text)


def _store_of(page_map: PageMap, folder: Path) -> Path:
    """Return the store of a stored map, its own or one that is written from its file."""
    from latolato.sweeps.plan import Plan
    from latolato.sweeps.statuses import codes_of
    from latolato.sweeps.store import Store

    assert page_map.path is not None
    if page_map.path.is_dir():
        return page_map.path
    if page_map.missing:
        raise InputError(
            f"a store holds whole maps; {page_map.missing} points are not computed yet",
            way_out="let the sweep finish, or take NetCDF",
        )
    if "rounding" not in page_map.grid.attrs:
        raise InputError(
            "this map was computed by an earlier latolato, which did not record how it rounds",
            way_out="compute it again, or take NetCDF",
        )
    plan = Plan.from_description(json.loads(page_map.grid.attrs["plan"]))
    path = folder / f"{page_map.path.stem}.zarr"
    reason = str(page_map.grid.attrs.get("first_invalid", ""))
    arrays = {str(name): array.values for name, array in page_map.grid.data_vars.items()}
    arrays["status"] = codes_of(arrays["status"])
    with Store(plan, path, page_map.grid.attrs["rounding"]) as store:
        for number in store.missing:
            block = plan.block(number)
            store.write(number, {name: a[block] for name, a in arrays.items()}, reason)
    return path


def _zip(path: Path, target: Path) -> None:
    """Write the files of a store into an archive; locks and unfinished files are left out."""
    with zipfile.ZipFile(target, "w", zipfile.ZIP_STORED) as archive:
        for each in sorted(path.rglob("*")):
            if each.is_file() and each.name != "lock":
                archive.write(each, f"{path.name}/{each.relative_to(path).as_posix()}")


def _check_look(body: Mapping[str, Any]) -> None:
    """Raise InputError unless a picture can look as a page asks."""
    overlays, trials = body.get("overlays") or [], body.get("trials")
    if not isinstance(overlays, list) or not all(isinstance(name, str) for name in overlays):
        raise InputError("must be a list of names", parameter="overlays", value=overlays)
    curves = body.get("curves") or []
    if not isinstance(curves, list) or not all(map(_is_short, curves)):
        raise InputError("must be a list of texts of bifurcation curves", parameter="curves")
    for text in curves:
        read_curves(text)
    if trials is not None and (not isinstance(trials, str) or len(trials) > MOST_TRIALS):
        raise InputError("must be the text of a trial table", parameter="trials")
    scale = body.get("scale") or SCALES[0]
    if scale not in SCALES:
        raise InputError(f"must be one of {', '.join(SCALES)}", parameter="scale", value=scale)
    limits, ball = body.get("limits"), body.get("ball")
    if limits is not None and (not isinstance(limits, list) or len(limits) != 2):
        raise InputError("must be two numbers", parameter="limits", value=limits)
    for value in limits or ():
        checked_number("limits", value, ANY, "SI")
    if ball is not None and ball not in _BALLS:
        raise InputError("must be right or left", parameter="ball", value=ball)
    contours = body.get("contours")
    if contours is None:
        return
    if not isinstance(contours, Mapping) or not isinstance(contours.get("observable"), str):
        raise InputError(
            "must be an object with an observable", parameter="contours", value=contours
        )
    levels = contours.get("levels")
    if not isinstance(levels, list) or not levels:
        raise InputError("must be a list of numbers", parameter="levels", value=levels)
    if len(levels) > MOST_LEVELS:
        raise TooLargeError(f"there may be at most {MOST_LEVELS} levels", value=len(levels))
    for value in levels:
        checked_number("a level", value, ANY, "SI")


def _is_short(text: Any) -> bool:
    return isinstance(text, str) and len(text) <= MOST_TRIALS


def _write_picture(page_map: PageMap, target: Path, folder: Path) -> None:
    """Write the picture of a map as the page shows it."""
    from latolato.figures.style import save_figure

    request, points = page_map.request, None
    if request.get("trials") is not None:
        points = folder / "trials.csv"
        points.write_text(request["trials"], encoding="utf-8")
    drawing = page_map.drawing(request["observable"], request.get("ball"))
    drawing.log = bool(request.get("log")) and not drawing.classes
    curves = [curve for text in request.get("curves") or [] for curve in read_curves(text)]
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
        "colours": request.get("scale") or SCALES[0],
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
