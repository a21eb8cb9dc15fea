"""Runs of one figure, brought together in one self-describing dataset."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.quantities import QUANTITIES

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

SAMPLES_PER_PERIOD = 50
# Meanings of what is kept for each case, beside the quantities that latolato names anyway.
_PER_CASE = {
    "bottom_contacts": ("1", "contacts at the bottom"),
    "top_contacts": ("1", "contacts at the top"),
    "largest_energy": ("J", "largest total energy of the run"),
    "step": ("s", "time step of the integration"),
}


def instants(duration: float, frequency: float, *, per_period: int = SAMPLES_PER_PERIOD) -> Floats:
    """Return multiples of a fixed part of the period of `frequency`, from 0 to `duration` [s].

    Every `per_period`-th instant has the same phase of the drive.
    """
    spacing = 2.0 * math.pi / (frequency * per_period)
    count = math.floor(duration / spacing) + 1
    return np.arange(count, dtype=np.float64) * spacing


def variable(
    dims: str | Sequence[str], values: Any, *, units: str, long_name: str, symbol: str = ""
) -> tuple[Any, Any, dict[str, str]]:
    """Return an xarray variable with its metadata."""
    return dims, values, {"units": units, "long_name": long_name, "symbol": symbol}


def quantity(
    name: str, dims: str | Sequence[str], values: Any, *, long_name: str | None = None
) -> tuple[Any, Any, dict[str, str]]:
    """Return an xarray variable with the unit, name and symbol of a quantity of latolato."""
    about = QUANTITIES[name]
    return variable(
        dims,
        values,
        units=about.unit,
        long_name=about.long_name if long_name is None else long_name,
        symbol=about.symbol,
    )


class Residuals:
    """Counts runs of a scan, of which only a number is kept, and their worst energy residual."""

    def __init__(self) -> None:
        self.count = 0
        self.worst = 0.0

    def of(self, run: xr.Dataset) -> xr.Dataset:
        """Take note of a run and return it."""
        self.count += 1
        largest = max(float(run.total_energy.max()), np.finfo(float).tiny)
        self.worst = max(self.worst, run.attrs["energy_residual"] / largest)
        return run

    def variables(self) -> dict[str, Any]:
        """Return the variables that a figure's dataset keeps."""
        return {
            "scan_runs": variable(
                (), self.count, units="1", long_name="runs of which a number is kept"
            ),
            "scan_residual": variable(
                (),
                self.worst,
                units="1",
                long_name="worst residual of their energy ledgers, relative",
            ),
        }


def stack(
    runs: Mapping[str, xr.Dataset], *, title: str, keep: Sequence[str] = ("angle",)
) -> xr.Dataset:
    """Return runs over the same instants as one dataset with the dimension ``case``.

    Parameters
    ----------
    runs : mapping of str to xarray.Dataset
        Results of `latolato.simulate`, by a label for people.
    title : str
        Title of the dataset.
    keep : sequence of str
        Variables over time that are kept.

    Returns
    -------
    xarray.Dataset
        With, for each case, its scenario (JSON, enough to run it again), the number of contacts,
        the step, and the residual of the energy ledger beside the largest energy.
    """
    import xarray as xr

    labels, results = list(runs), list(runs.values())
    first = results[0]
    for label, run in runs.items():
        if not np.array_equal(run.time.values, first.time.values):
            raise ValueError(f"case '{label}' has other instants than '{labels[0]}'")
    variables: dict[str, Any] = {}
    for name in keep:
        together = np.stack([run[name].values for run in results])
        variables[name] = (("case", "time"), together, dict(first[name].attrs))
    per_case: dict[str, list[Any]] = {
        "largest_energy": [float(run.total_energy.max()) for run in results],
        "step": [run.attrs["step"] for run in results],
    }
    for kind in ("bottom", "top"):
        per_case[f"{kind}_contacts"] = [int((run.contact_kind == kind).sum()) for run in results]
    for name, values in per_case.items():
        unit, meaning = _PER_CASE[name]
        variables[name] = variable("case", values, units=unit, long_name=meaning)
    residuals = [run.attrs["energy_residual"] for run in results]
    variables["energy_residual"] = quantity("energy_residual", "case", residuals)
    variables["scenario"] = variable(
        "case",
        [run.attrs["scenario"] for run in results],
        units="1",
        long_name="system, drive and run as JSON",
    )
    coordinates = {
        "time": quantity("time", "time", first.time.values),
        "case": variable("case", labels, units="1", long_name="case"),
    }
    versions = ("latolato_version", "numpy_version", "numba_version")
    about = {name: first.attrs[name] for name in versions}
    return xr.Dataset(variables, coordinates, attrs={"title": title, **about})
