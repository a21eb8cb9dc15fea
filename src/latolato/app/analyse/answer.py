"""The result of an analysis: computed and written in a process of its own, with its picture."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.app.analyse.forms import label_of
from latolato.app.analyse.request import AnalysisRequest
from latolato.app.blocks import content_of
from latolato.app.worker import Result
from latolato.core.errors import InputError
from latolato.core.quantities import quantity_of
from latolato.io.analysis_tables import to_csv

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_OVER = re.compile(r"\(over (?P<dims>[^,)]*)(?P<rest>[^)]*)\)")
_PICTURE_DPI = 200
_BY = " \N{MULTIPLICATION SIGN} "


def compute(request: Mapping[str, Any], folder: Path, progress: Callable[[float], None]) -> Result:
    """Run an analysis and write its result, with the lines of Python and shell that do the same.

    How much of it is done is not known before its end, so `progress` is never called.
    """
    import warnings

    from latolato.figures.plot import plot
    from latolato.figures.style import save_figure
    from latolato.io.files import save

    asked = AnalysisRequest.from_json(request)
    arguments = asked.arguments()
    result = asked.function(**arguments)
    save(result, folder / "result.nc")
    (folder / "result.csv").write_text(to_csv(result), encoding="utf-8")
    panels: list[dict[str, Any]] = []
    try:
        figure = plot(result)
    except InputError as error:  # without a picture
        warnings.warn(str(error), RuntimeWarning, stacklevel=1)
    else:
        save_figure(figure, folder / "result.png", dpi=_PICTURE_DPI)
        save_figure(figure, folder / "result.svg")
        panels = panels_of(figure, result)
    about = {
        "analysis": asked.name, "lines": numbers_of(result), "panels": panels,
        "python": asked.python(arguments), "command": asked.command(),
    }  # fmt: skip
    return about, {path.suffix[1:]: content_of(path) for path in folder.glob("result.*")}


def numbers_of(dataset: xr.Dataset) -> list[tuple[str, str]]:
    """The results of an analysis as rows of a table: a label, and the value with its unit."""
    from latolato.analysis.summary import as_lines

    rows = []
    for name, text in as_lines(_in_degrees(dataset.squeeze())).items():
        if name == "analysis":
            continue
        variable = dataset.variables.get(name)
        label = str(variable.attrs.get("long_name") or name) if variable is not None else name
        rows.append((label[:1].upper() + label[1:].replace("_", " "), _OVER.sub(_counted, text)))
    return rows


def _in_degrees(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset with its angles in degrees, as pages show them."""
    import numpy as np

    shown = dataset.copy()
    for name, variable in dataset.variables.items():
        if variable.attrs.get("units") == "rad":
            attrs = {**variable.attrs, "units": "°"}
            shown[name] = (variable.dims, np.degrees(variable.values), attrs)
    return shown


def _counted(match: re.Match[str]) -> str:
    """Return how many values a range is of, for a text that names their dimensions."""
    sizes = re.findall(r"(?<=\w )\d+(?= x |$)", match["dims"])
    return f"({_BY.join(sizes)} values{match['rest']})"


def panels_of(figure: Figure, dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Return the panels on which a point stands for parameters or for a start.

    Returns
    -------
    list of dict
        ``box``: left, top, right and bottom as shares of the picture; ``x`` and ``y``: the option,
        its unit and its values at both ends, None where an axis is of something else.
    """
    panels = []
    for axes in figure.axes:
        x = _axis_of(dataset, axes, "x")
        y = _axis_of(dataset, axes, "y")
        if x is None and y is None:
            continue
        place = axes.get_position()
        box = [place.x0, 1.0 - place.y1, place.x1, 1.0 - place.y0]
        panels.append({"box": [float(side) for side in box], "x": x, "y": y})
    return panels


def _axis_of(dataset: xr.Dataset, axes: Any, side: str) -> dict[str, Any] | None:
    """Return the option along a straight axis of a picture, by the label of a coordinate."""
    from latolato.figures.style import label, pretty_unit
    from latolato.scenario.options import law_options

    if getattr(axes, f"get_{side}scale")() != "linear":
        return None
    shared = getattr(axes, f"get_shared_{side}_axes")().get_siblings(axes)
    texts = {getattr(each, f"get_{side}label")() for each in [axes, *shared]} - {""}
    for name, variable in dataset.coords.items():
        if name not in law_options() or (
            str(name).startswith("initial") and "ball" in dataset.dims
        ):
            continue
        about = quantity_of(str(name), str(variable.attrs["units"]))
        units = ("", pretty_unit(about.shown_unit))
        if texts & {label(variable, short=s, unit=u) for s in (False, True) for u in units}:
            low, high = getattr(axes, f"get_{side}lim")()
            unit = str(variable.attrs.get("units", "1"))
            return {
                "name": str(name),
                "unit": "" if unit == "1" else unit,
                "label": label_of(str(name), unit),
                "ends": [float(low), float(high)],
            }
    return None
