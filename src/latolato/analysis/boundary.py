"""The boundary between stable and unstable motion in a map, and how sharp its two sides are."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError
from latolato.core.quantities import ANY
from latolato.core.registry import checked_number, suggest

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

# Dimensions along which there are a left and a right edge.
FREQUENCIES = ("frequency_ratio", "drive_frequency")
# Shares of the plateau between which an edge's width is measured.
FOOT, SHOULDER = 0.1, 0.9
# The plateau beside an edge: this share of the main region's points, and this many at least.
NEAR, FEWEST = 0.1, 5


def map_boundary(grid: xr.Dataset, observable: str, level: float) -> xr.Dataset:
    """Return the lines at which an observable of a 2-D map passes a level, and their widths.

    Answers the paper's "the left boundary is more distinct than the right boundary" (Fig. 3cd).

    Parameters
    ----------
    grid : xarray.Dataset
        A sweep over two parameters; of one over more, take a part with ``grid.sel`` first.
    observable : str
        The variable that is large for unstable and small for stable motion.
    level : float
        The value on the boundary, in the unit of the observable.

    Returns
    -------
    xarray.Dataset
        ``boundary_x`` and ``boundary_y`` over ``vertex``, in the units of the two axes, with
        ``part``, the number of the polyline that a vertex belongs to. Over the other axis
        (mostly the amplitude): ``left_edge``, ``right_edge``, ``left_width``, ``right_width`` in
        the unit of the frequency axis, and ``left_plateau``, ``right_plateau`` in that of the
        observable.

    Raises
    ------
    InputError
        For an unknown observable, a map that is not 2-D or smaller than 2 x 2, a level that is not
        finite.

    Notes
    -----
    x is the frequency axis (`frequency_ratio` or `drive_frequency`), or else the last one. The
    polylines are the contour of the bilinear surface through the points (contourpy).

    In each row, the *main region* is that run of neighbouring points at or above the level over
    which the observable's integral is largest. The *plateau* P beside an edge is the median of the
    observable over a tenth of the region's points, at least 5, next to the edge; it is taken once
    more from the first point on that reaches 0.9 P, to leave the flank out. Both sides have their
    own, as the energy of unstable motion rises with the frequency. ``left_edge`` and ``right_edge``
    are where the straight line between the region's last point and its neighbour outside passes
    the level. A width goes from where the observable last stays at or above 0.9 P, on the way out
    from the region's first point that reaches it, to where it first is at or below 0.1 P beyond;
    both are found on straight lines between points.

    What it can miss: an edge sharper than the grid shows 0.8 spacings of width, so compare with
    the attribute ``spacing``. A ragged region (chaotic motion, collisions) is cut at its first gap,
    so islands beyond count neither for edges nor for widths. A flank longer than about a fifth of
    the region is measured against a lower plateau, so a soft edge shows less width than it has.
    An edge or a width is NaN where it is unknown: the map ends, a point has no answer, or the
    observable stays above 0.1 P. Contours end at points without an answer.

    Examples
    --------
    >>> import numpy as np, xarray as xr
    >>> x, y = np.linspace(1.0, 3.0, 201), np.array([0.1, 0.2])
    >>> hump = np.clip((x - 1.9) / 0.02, 0, 1) * np.clip((2.5 - x) / 0.2, 0, 1)
    >>> axes = {"drive_amplitude": y, "frequency_ratio": x}
    >>> grid = xr.Dataset({"mean_energy": (tuple(axes), np.array([hump, hump]))}, axes)
    >>> edges = map_boundary(grid, "mean_energy", 0.5)
    >>> edges.left_width.values.round(3), edges.right_width.values.round(3)
    (array([0.016, 0.016]), array([0.112, 0.112]))
    """
    import xarray as xr

    values = _checked(grid, observable)
    level = checked_number("level", level, ANY, values.attrs.get("units", "1"))
    x_name, y_name = str(values.dims[1]), str(values.dims[0])
    x, y, z = values[x_name].values, values[y_name].values, values.values.astype(np.float64)
    result = np.array([_edges(x, row, level) for row in z])
    lines = contour_lines(x, y, z, level)
    part = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    vertices = np.concatenate([*lines, np.empty((0, 2))])
    about_x, about_y, about_z = (
        dict(each.attrs) for each in (values[x_name], values[y_name], values)
    )
    unit_x, unit_z = about_x.get("units", "1"), about_z.get("units", "1")
    names = {
        "left_edge": "left edge of the main region",
        "right_edge": "right edge of the main region",
        "left_width": "width of the left edge (10 to 90 %)",
        "right_width": "width of the right edge (10 to 90 %)",
    }
    variables = {
        name: (y_name, result[:, i], {"units": unit_x, "long_name": text, "symbol": ""})
        for i, (name, text) in enumerate(names.items())
    }
    for i, side in enumerate(("left", "right"), start=4):
        text = f"{observable} beside the {side} edge"
        about = {"units": unit_z, "long_name": text, "symbol": ""}
        variables[f"{side}_plateau"] = (y_name, result[:, i], about)
    return xr.Dataset(
        {
            "boundary_x": ("vertex", vertices[:, 0], about_x),
            "boundary_y": ("vertex", vertices[:, 1], about_y),
            "part": ("vertex", part, {"units": "1", "long_name": "number of the polyline"}),
            **variables,
        },
        coords={y_name: (y_name, y, about_y)},
        attrs={
            "title": f"boundary of {observable}",
            "observable": observable,
            "level": level,
            "x": x_name,
            "y": y_name,
            "spacing": float(np.max(np.diff(x))),
            **{k: grid.attrs[k] for k in ("plan_hash", "latolato_version") if k in grid.attrs},
        },
    )


def _checked(grid: xr.Dataset, observable: str) -> xr.DataArray:
    """Return the observable over (y, x), both increasing."""
    import xarray as xr

    if not isinstance(grid, xr.Dataset):
        raise InputError(
            "must be the dataset of a sweep", parameter="grid", value=type(grid).__name__
        )
    known = [str(name) for name in grid.data_vars if name != "status"]
    if observable not in known:
        raise InputError(f"unknown observable '{observable}': {suggest(str(observable), known)}")
    values = grid[observable]
    dims = [str(dim) for dim in values.dims]
    if len(dims) != 2 or min(values.shape) < 2:
        text = ", ".join(f"{d} ({n})" for d, n in values.sizes.items()) or "nothing"
        raise InputError(
            f"boundary needs a map over two parameters of at least 2 values each, but "
            f"{observable} is over {text}; take a part with grid.sel or grid.isel"
        )
    for dim in dims:
        if dim not in grid.coords or grid[dim].dtype.kind not in "iuf":
            raise InputError(
                f"boundary needs numbers along {dim}: set one of its parameters as its index with "
                "grid.swap_dims"
            )
    y, x = sorted(dims, key=lambda dim: dim in FREQUENCIES)
    return values.transpose(y, x).sortby([y, x])


def contour_lines(x: Floats, y: Floats, z: Floats, level: float) -> list[Floats]:
    """Return the polylines of a level, each of shape (vertex, 2): contours between points."""
    from contourpy import contour_generator

    generator = contour_generator(x, y, np.ma.masked_invalid(z))
    return [np.asarray(line, dtype=np.float64) for line in generator.lines(level)]


def _edges(x: Floats, row: Floats, level: float) -> tuple[float, ...]:
    """Return left and right edge, left and right width, left and right plateau of one row."""
    region = _main_region(x, row, level)
    if region is None:
        return (math.nan,) * 6
    first, last = region
    inside = row[first : last + 1]
    left, right = _plateau(inside), _plateau(inside[::-1])
    return (
        _crossing(x, row, first, -1, level),
        _crossing(x, row, last, 1, level),
        _width(x, row, range(first, last + 1), -1, left),
        _width(x, row, range(last, first - 1, -1), 1, right),
        left,
        right,
    )


def _plateau(inwards: Floats) -> float:
    """Return the typical value beside an edge, from the region's values inwards."""
    count = max(FEWEST, round(NEAR * len(inwards)))
    rough = float(np.median(inwards[:count]))
    shoulder = int(np.argmax(inwards >= SHOULDER * rough))
    return float(np.median(inwards[shoulder : shoulder + count]))


def _main_region(x: Floats, row: Floats, level: float) -> tuple[int, int] | None:
    """Return the first and last index of the run at or above the level with the most integral."""
    inside = np.concatenate([[False], row >= level, [False]])
    starts = np.flatnonzero(inside[1:] & ~inside[:-1])
    ends = np.flatnonzero(~inside[1:] & inside[:-1]) - 1
    if not starts.size:
        return None
    cells = np.gradient(x)
    totals = [np.sum(row[a : b + 1] * cells[a : b + 1]) for a, b in zip(starts, ends, strict=True)]
    best = int(np.argmax(totals))
    return int(starts[best]), int(ends[best])


def _crossing(x: Floats, row: Floats, inner: int, way: int, level: float) -> float:
    """Return the crossing of a level between a point and its neighbour that way; NaN if none."""
    outer = inner + way
    if not 0 <= outer < len(row) or not math.isfinite(row[outer]):
        return math.nan
    share = (row[inner] - level) / (row[inner] - row[outer])
    return float(x[inner] + share * (x[outer] - x[inner]))


def _width(x: Floats, row: Floats, inwards: range, way: int, plateau: float) -> float:
    """Return the distance over which a row falls from 0.9 to 0.1 of its plateau; NaN if it ends.

    `inwards` are the indices of the region from this edge on, `way` points out of it.
    """
    place = next((i for i in inwards if row[i] >= SHOULDER * plateau > 0.0), -1)
    if place < 0:
        return math.nan
    result = []
    for share in (SHOULDER, FOOT):
        while 0 <= place + way < len(row) and row[place + way] > share * plateau:
            place += way
        result.append(_crossing(x, row, place, way, share * plateau))
    return abs(result[1] - result[0])
