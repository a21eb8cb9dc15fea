"""The bifurcation curves that are shipped with scenarios."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from latolato.app import CURVES
from latolato.io.analysis_tables import to_csv
from latolato.paper import curves_fig05, curves_fig09, curves_fig11

if TYPE_CHECKING:
    import xarray as xr

# Amplitudes of the map of Fig. 11 reach so far [m].
_FIG11 = 0.04
# By the names of scenarios; each makes the curves over its map.
SHIPPED: dict[str, Callable[[], Sequence[xr.Dataset]]] = {
    "fig05": curves_fig05.curves,
    "fig09": curves_fig09.curves,
    "fig11": lambda: curves_fig11.curves(_FIG11),
}


def write_shipped(names: Iterable[str] = SHIPPED, folder: Path = CURVES) -> list[Path]:
    """Compute the curves that are shipped with scenarios, a file for each; return the files."""
    folder.mkdir(exist_ok=True)
    paths = []
    for name in names:
        paths.append(folder / f"{name}.csv")
        text = "\n".join(to_csv(_shortened(curve)) for curve in SHIPPED[name]())
        paths[-1].write_text(text, encoding="utf-8")
    return paths


def _shortened(curve: xr.Dataset) -> xr.Dataset:
    """Round a curve's numbers to twelve digits and 1e-15, below which a state is zero.

    With ten digits motions at folds are not found again.
    """
    shortened = curve.copy()
    for name, variable in curve.data_vars.items():
        if variable.dtype.kind == "f":
            digits = np.array(
                [float(f"{round(value, 15):.12g}") for value in variable.values.ravel()]
            )
            shortened[name] = variable.copy(data=digits.reshape(variable.shape))
    return shortened


if __name__ == "__main__":
    write_shipped()
