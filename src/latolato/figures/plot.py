"""The picture of what was computed: a run or an analysis whole, or one variable of a sweep."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.core.errors import InputError
from latolato.figures.pictures import module_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


# Where the pictures of each kind of result are, one module each.


def plot(
    run: xr.Dataset,
    variable: str | None = None,
    *,
    log: bool = False,
    curves: bool = False,
    select: Mapping[str, Any] | None = None,
    overlays: Sequence[str] = (),
    points: str | Path | None = None,
) -> Figure:
    """Return a figure of a run, of an analysis, or of one variable of a sweep over parameters.

    A run shows its angles, its energies, where these came from and went, and the pivot; an analysis
    what it found. The further arguments belong to sweeps over one or two parameters.

    Parameters
    ----------
    run : xarray.Dataset
        What `latolato.simulate`, `latolato.sweep`, `latolato.load` or a function of
        `latolato.analysis` returned.
    variable : str, optional
        What to draw; by default the first.
    log : bool
        A logarithmic scale of the values. Zeros get a colour of their own.
    curves : bool
        Draw a curve for each value of the shorter of two dimensions, at most 12, not a map.
    select : mapping, optional
        Values of further dimensions, such as ``{"restitution": 0.9}``; the nearest one is
        taken and named in the title. A dimension without numbers takes its text or its index.
    overlays : sequence of {"tongue", "lift_off"}
        Curves over a map of amplitude and frequency: the edges of the primary tongue of eq14 with
        the sweep's linear damping, and where the pivot's acceleration reaches gravity.
    points : str or Path, optional
        A CSV of trials with the columns `drive_amplitude`, `drive_frequency` or
        `frequency_ratio`, and `class` (none, weak or strong).

    Raises
    ------
    InputError
        If `run` holds no run, sweep or analysis that can be drawn; for unknown names, too
        many dimensions left and overlays that the axes cannot carry.

    Notes
    -----
    A cell of a map reaches halfway to its neighbours. Points without an answer are grey and
    counted in the legend, by status; they never look like a value.

    Examples
    --------
    >>> import latolato as ll
    >>> figure = ll.plot(ll.load_scenario("zeno").simulate())
    >>> len(figure.axes)
    4
    """
    import xarray as xr

    if not isinstance(run, xr.Dataset):
        raise InputError(
            f"plot needs a run: a dataset with angle over time, got {type(run).__name__}"
        )
    is_plain = not (variable or log or curves or select or overlays or points)
    if is_fit(run):
        if not is_plain:
            raise InputError("a fit is drawn whole: variable, log and the like belong to sweeps")
        from latolato.figures.fits import draw_fit

        return draw_fit(run)
    if is_comparison(run):
        if not is_plain:
            raise InputError("a comparison is drawn whole: variable, log and the like fit a sweep")
        from latolato.figures.comparisons import draw_comparison

        return draw_comparison(run)
    if is_analysis(run):
        if not is_plain:
            raise InputError("an analysis is drawn whole: variable, log and the like fit a sweep")
        return picture_of("analysis", str(run.attrs["analysis"]))(run)
    if is_map(run):
        from latolato.figures.map import Drawing

        drawing = Drawing(run, variable, log=log, select=select or {})
        if len(drawing.sides) == 2 and not curves:
            return drawing.map(overlays, points)
        if overlays or points:
            raise InputError("overlays and points belong to a map of amplitude and frequency")
        return drawing.curves()
    if "angle" not in run or "time" not in run.dims:
        raise InputError("plot needs a run: a dataset with angle over time, a sweep or an analysis")
    if not is_plain:
        raise InputError("a run is drawn whole: variable, log and the like belong to sweeps")
    from latolato.figures.run import draw_run

    return draw_run(run)


def is_map(dataset: xr.Dataset) -> bool:
    """Return whether a dataset is that of a sweep."""
    return "plan" in dataset.attrs and "time" not in dataset.dims and not is_comparison(dataset)


def is_analysis(dataset: xr.Dataset) -> bool:
    """Return whether a dataset is what an analysis found."""
    return "analysis" in dataset.attrs


def is_fit(dataset: xr.Dataset) -> bool:
    """Return whether a dataset is that of a fit of measurements."""
    return "fit" in dataset.attrs


def is_comparison(dataset: xr.Dataset) -> bool:
    """Return whether a dataset compares measurement and computation."""
    return "comparison" in dataset.attrs


def picture_of(kind: str, name: str) -> Callable[[xr.Dataset], Figure]:
    """Return what draws an analysis or a fit: ``draw`` of the module of its name.

    Raises
    ------
    InputError
        If it has no picture.
    """
    draw: Callable[[xr.Dataset], Figure] = module_of(kind, name).draw
    return draw
