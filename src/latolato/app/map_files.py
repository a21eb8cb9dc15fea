"""Files of the map on show: its numbers as tables and stores, its picture."""

from __future__ import annotations

import io
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from starlette.responses import Response

from latolato.app.downloads import PICTURE_DPI, TYPES, drawing_lock
from latolato.app.given import TooLargeError
from latolato.app.map_contours import contours
from latolato.app.map_shown import Shown
from latolato.core.errors import InputError
from latolato.core.quantities import ANY
from latolato.core.registry import checked_number, suggest

if TYPE_CHECKING:
    from collections.abc import Callable

    from latolato.figures.map import Look

KINDS = {"csv": "text/csv", **TYPES, "zarr": "application/zip"}
SCALES = ("viridis", "cividis", "magma")
# Of a stored sweep with more axes than two.
MOST_BYTES = 200_000_000
MOST_TRIALS = 1_000_000  # characters


def file_response(kind: str, given: Any, shown_of: Callable[[Any], Shown]) -> Response:
    """Return a file of the map that a page shows, to be stored by the browser.

    Its name, and the header ``X-Points-Missing``, tell where it is not finished.

    Raises
    ------
    InputError
        For bad input, an unknown kind, and an unfinished map as a store.
    TooLargeError
        For a stored sweep that is too large.
    """
    if kind not in KINDS:
        raise InputError(f"a map is stored as {', '.join(KINDS)}, not as {kind!r}")
    shown = shown_of(given)
    if shown.grid.nbytes > MOST_BYTES:
        raise TooLargeError(
            f"this sweep has {shown.grid.nbytes / 1e6:.0f} MB, the limit of a download is "
            f"{MOST_BYTES / 1e6:.0f} MB: copy its file instead"
        )
    with tempfile.TemporaryDirectory(prefix="latolato-") as folder:
        if kind in ("png", "svg"):
            content = _picture(kind, shown, given, shown_of, Path(folder))
        elif kind == "zarr":
            content = _zipped(shown, Path(folder))
        else:
            from latolato.io.files import save

            path = Path(folder) / f"map.{kind}"
            save(_told(shown), path)
            content = path.read_bytes()
    name = shown.name + ("_unfinished" if shown.missing else "")
    ending = "zarr.zip" if kind == "zarr" else kind
    headers = {
        "Content-Disposition": f'attachment; filename="{name}.{ending}"',
        "X-Points-Missing": str(shown.missing),
    }
    return Response(content, media_type=KINDS[kind], headers=headers)


def _told(shown: Shown) -> Any:
    """Return the dataset; one that is not finished says so."""
    if not shown.missing:
        return shown.grid
    total = shown.grid["status"].size
    text = f"{shown.missing} of {total} points are not computed: status is -1 there"
    return shown.grid.assign_attrs(unfinished=text)


def _zipped(shown: Shown, folder: Path) -> bytes:
    """Return a store of the sweep as a zip file."""
    from latolato.io.plans import plan_from_store
    from latolato.sweeps.plan import Plan
    from latolato.sweeps.store import Store

    if shown.path is not None and shown.path.is_dir():
        return _zip(shown.path, shown.path.name)
    if shown.missing:
        raise InputError(
            f"{shown.missing} points are not computed yet: a store holds whole maps; let it "
            "finish, or take NetCDF"
        )
    if shown.path is not None:
        plan = plan_from_store(shown.path)
    else:
        import json

        plan = Plan.from_description(json.loads(shown.grid.attrs["plan"]))
    if "rounding" not in shown.grid.attrs:
        raise InputError(
            "this map was computed by an earlier latolato, which did not record how it rounds",
            way_out="compute it again, or take NetCDF",
        )
    path = folder / f"{shown.name}.zarr"
    reason = str(shown.grid.attrs.get("first_invalid", ""))
    arrays = {str(name): array.values for name, array in shown.grid.data_vars.items()}
    with Store(plan, path, shown.grid.attrs["rounding"]) as store:
        for number in store.missing:
            block = plan.block(number)
            store.write(number, {name: a[block] for name, a in arrays.items()}, reason)
    return _zip(path, path.name)


def _zip(path: Path, name: str) -> bytes:
    """Return the files of a folder below a name; locks and unfinished files are left out."""
    result = io.BytesIO()
    with zipfile.ZipFile(result, "w", zipfile.ZIP_STORED) as archive:
        for each in sorted(path.rglob("*")):
            if each.is_file() and each.name != "lock":
                archive.write(each, f"{name}/{each.relative_to(path).as_posix()}")
    return result.getvalue()


def _picture(
    kind: str,
    shown: Shown,
    given: Mapping[str, Any],
    shown_of: Callable[[Any], Shown],
    folder: Path,
) -> bytes:
    """Return the picture of a map as the page shows it."""
    from latolato.figures.style import save_figure

    overlays = given.get("overlays") or []
    if not isinstance(overlays, list) or not all(isinstance(name, str) for name in overlays):
        raise InputError(f"overlays must be a list of names, got {overlays!r}")
    trials, points = given.get("trials"), None
    if trials is not None:
        if not isinstance(trials, str) or len(trials) > MOST_TRIALS:
            raise InputError("trials must be the text of a trial table")
        points = folder / "trials.csv"
        points.write_text(trials, encoding="utf-8")
    look = _look(shown, given, shown_of)
    drawing = shown.drawing
    drawing.log = bool(given.get("log")) and not drawing.classes
    path = folder / f"map.{kind}"
    with drawing_lock:
        save_figure(drawing.map(overlays, points, look), path, dpi=PICTURE_DPI)
    return path.read_bytes()


def _look(shown: Shown, given: Mapping[str, Any], shown_of: Callable[[Any], Shown]) -> Look:
    """Return the colours, their ends and the contour lines that a page shows."""
    from latolato.figures.map import Look

    scale, ends = given.get("scale") or SCALES[0], given.get("limits")
    if scale not in SCALES:
        raise InputError(f"unknown scale {scale!r}: {suggest(str(scale), list(SCALES))}")
    limits = None
    if ends is not None:
        if not isinstance(ends, list) or len(ends) != 2:
            raise InputError(f"limits must be two numbers, got {ends!r}")
        low, high = (checked_number("limits", value, ANY, "SI") for value in ends)
        # Values as pages have them, in single precision, may lie beside those of the map.
        own = [float(np.float32(value)) for value in shown.drawing.limits]
        limits = None if [low, high] == own else (low, high)
    request = given.get("contours")
    if request is None:
        return Look(colours=scale, limits=limits)
    over = shown_of(request)
    _, lines, _ = contours(over, request)
    label = str(over.drawing.data.attrs.get("long_name", over.drawing.name))
    return Look(colours=scale, limits=limits, lines=lines, unit=over.unit, label=label)
