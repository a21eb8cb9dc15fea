"""The result of an analysis: computed and written in a process of its own, with its picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.app.analyse.request import AnalysisRequest
from latolato.app.blocks import content_of
from latolato.app.worker import Result
from latolato.core.errors import InputError
from latolato.core.language import spoken
from latolato.io.analysis_tables import to_csv

if TYPE_CHECKING:
    import xarray as xr

_PICTURE_DPI = 200


def compute(request: Mapping[str, Any], folder: Path, progress: Callable[[float], None]) -> Result:
    """Run an analysis and write its result, with the lines of Python and shell that do the same.

    How much of it is done is not known before its end, so `progress` is never called.
    """
    import warnings

    from latolato.analysis.registry import noting
    from latolato.figures.plot import plot
    from latolato.figures.style import save_figure
    from latolato.io.files import save

    asked = AnalysisRequest.from_json(request)
    arguments = asked.arguments()
    with noting() as notes:
        result = asked.function(**arguments)
    save(result, folder / "result.nc")
    (folder / "result.csv").write_text(to_csv(result), encoding="utf-8")
    if "message" in result.attrs:
        message = notes[notes.index(result.attrs["message"])]
        warnings.warn(message, RuntimeWarning, stacklevel=1)
    try:
        figure = plot(result)
    except InputError as error:  # without a picture
        warnings.warn(str(error), RuntimeWarning, stacklevel=1)
    else:
        save_figure(figure, folder / "result.png", dpi=_PICTURE_DPI)
        save_figure(figure, folder / "result.svg")
    about = {
        "analysis": asked.name, "lines": numbers_of(result),
        "python": asked.python(arguments), "command": asked.command(),
        "points": result.sizes.get("point"),
    }  # fmt: skip
    return about, {path.suffix[1:]: content_of(path) for path in folder.glob("result.*")}


def numbers_of(dataset: xr.Dataset) -> list[tuple[str, str]]:
    """The results of an analysis as rows of a table: a label, and the value with its unit."""
    from latolato.analysis.summary import as_lines

    rows = []
    for name, text in as_lines(_in_shown_units(dataset.squeeze())).items():
        variable = dataset.variables.get(name)
        # What was found of nothing, as along a curve without a point, needs no row.
        if variable is None or variable.size == 0 or not text.strip(", "):
            continue
        label = spoken(str(variable.attrs.get("long_name") or name))
        rows.append((label[:1].upper() + label[1:], text.replace(" °", "°")))
    return rows


def _in_shown_units(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset with its angles and amplitudes in the units in which pages show them."""
    import numpy as np

    # The lengths that analyses find are amplitudes.
    units = {"rad": ("°", np.degrees(1.0)), "m": ("mm", 1e3)}
    shown = dataset.copy()
    for name, variable in dataset.variables.items():
        if variable.attrs.get("units") in units:
            unit, factor = units[variable.attrs["units"]]
            attrs = {**variable.attrs, "units": unit}
            shown[name] = (variable.dims, variable.values * factor, attrs)
    return shown
