"""The picture of what was computed: a run or an analysis whole, or one variable of a sweep."""

from __future__ import annotations

import importlib
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.core.errors import InputError
from latolato.core.registry import suggest
from latolato.figures import style
from latolato.simulation.record import ON_STRINGS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_FOLDERS = {"analysis": "analyses", "fit": "fits"}
# Letters in a line of a verdict on a page's width.
_LINE = 122


def plot(
    run: xr.Dataset,
    variable: str | None = None,
    *,
    log: bool = False,
    curves: bool = False,
    select: Mapping[str, Any] | None = None,
    overlays: Sequence[str | xr.Dataset] = (),
    points: str | Path | None = None,
) -> Figure:
    """Return a figure of a run, of an analysis, or of one variable of a sweep over parameters.

    A run shows its angles, its energies, where these came from and went, and the pivot, and where
    strings go slack the distances of the balls; an analysis shows its result. The arguments after
    `variable` belong to sweeps and to variables of analyses, over one or two dimensions.

    Parameters
    ----------
    run : xarray.Dataset
        What `latolato.simulate`, `latolato.sweep`, `latolato.load` or a function of
        `latolato.analysis` returned.
    variable : str, optional
        What to draw of a sweep, by default the first; of an analysis a variable in place of its
        picture; of a run the only thing to draw, over time, such as ``"tension"`` or
        ``"angle_sensitivity"``.
    log : bool
        A logarithmic scale of the values. Zeros get a colour of their own.
    curves : bool
        Draw a curve for each value of the shorter of two dimensions, or for each word of one of
        text such as `direction`, at most 12, not a map.
    select : mapping, optional
        Values of further dimensions, such as ``{"restitution": 0.9}``; the nearest one is
        taken and named in the title. A dimension without numbers takes its text or its index.
        A third dimension of one value needs no selection.
    overlays : sequence of {"tongue", "lift_off"} or xarray.Dataset
        Curves over a map: results of `bifurcation_curve` of the same system; of amplitude and
        frequency the edges of the primary tongue of eq14 with the sweep's linear damping, and where
        the pivot's acceleration reaches gravity.
    points : str or Path, optional
        A CSV of trials with the columns `drive_amplitude`, `drive_frequency` or
        `frequency_ratio`, and `class` (none, weak or strong).

    Raises
    ------
    InputError
        If `run` holds no run, sweep or analysis that can be drawn; for unknown names, too
        many dimensions left, overlays that the axes cannot carry, and what only strings have where
        balls hang on rods.

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
        raise InputError("plot needs a run: a dataset with angle over time", value=run)
    kind = kind_of(run)
    if isinstance(overlays, (str, xr.Dataset)):
        overlays = [overlays]
    asked = bool(variable or log or curves or select or overlays or points)
    if kind == "map" or (kind == "analysis" and asked):
        from latolato.figures.map import Drawing

        drawing = Drawing(run, variable, log=log, select=select or {})
        if len(drawing.sides) == 2 and not curves:
            return drawing.map(overlays, points)
        if overlays or points:
            raise InputError("overlays and points belong to a map of amplitude and frequency")
        return drawing.curves()
    if kind == "run" and ("angle" not in run or "time" not in run.dims):
        raise InputError("plot needs a run: a dataset with angle over time, a sweep or an analysis")
    if kind == "run" and variable and not (log or curves or select or overlays or points):
        from latolato.figures.run import draw_variable

        _check_over_time(run, variable)
        return draw_variable(run[[variable]])
    if asked:
        raise InputError(
            f"a {kind} is drawn whole: variable, log and the like belong to sweeps"
            if kind != "run"
            else "of a run one variable can be drawn: log and the like belong to sweeps"
        )
    if kind == "run":
        from latolato.figures.run import draw_run

        return draw_run(run)
    if kind == "analysis":
        from latolato.figures.analyses import drawings

        module = module_of("analysis", run.attrs["analysis"])
        figure: Figure = getattr(module, "draw", drawings.draw)(run)
        return figure
    return _draw_with_verdict(run)


def _check_over_time(run: xr.Dataset, name: str) -> None:
    """Raise InputError unless a run has such a variable over time."""
    if name in run and "time" in run[name].dims and name != "time":
        return
    if name in (*ON_STRINGS, "retension_loss"):
        raise InputError(
            "must be one of a run on rods, which never go slack: where its tension is negative, a "
            "rod is pushed",
            parameter="variable",
            value=name,
            way_out="simulate with suspension='string', or draw 'tension'",
        )
    known = [str(each) for each in run.data_vars if "time" in run[each].dims]
    raise InputError(f"unknown variable '{name}' of a run: {suggest(name, known)}")


@style.styled
def _draw_with_verdict(dataset: xr.Dataset) -> Figure:
    """Return the picture of a fit or a comparison under its verdict."""
    from latolato.figures import comparisons

    is_fit = kind_of(dataset) == "fit"
    module = module_of("fit", dataset.attrs["fit"]) if is_fit else comparisons
    figure: Figure = module.draw(dataset)
    letters = int(_LINE * figure.get_figwidth() / style.PAGE)
    style.head(figure, textwrap.fill(str(dataset.attrs["verdict"]), letters))
    return figure


def kind_of(dataset: xr.Dataset) -> str:
    """Return the kind of a dataset: a fit, comparison or analysis, a map, or else a run."""
    for kind in ("fit", "comparison", "analysis"):
        if kind in dataset.attrs:
            return kind
    is_map = dataset.attrs.keys() & {"plan", "prediction"} and "time" not in dataset.dims
    return "map" if is_map else "run"


def module_of(kind: str, name: str) -> Any:
    """Return the module with the picture of an analysis or a fit: the one of its name.

    Raises
    ------
    InputError
        If it has none.
    """
    home = f"latolato.figures.{_FOLDERS[kind]}.{name}"
    try:
        return importlib.import_module(home)
    except ModuleNotFoundError as error:
        if error.name != home:
            raise
        raise InputError(f"{kind} '{name}' has no picture; its numbers can be stored") from None
