"""Compare measurement and computation: motion, trials on a map, and response curves."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

from latolato.core.errors import InputError
from latolato.physics.pendulum import System

if TYPE_CHECKING:
    import xarray as xr

    from latolato.experiment.fits.result import Fit


def compare(measured: xr.Dataset, computed: Any, drive: Any = None, **options: Any) -> xr.Dataset:
    """Return a comparison of measurement and computation.

    Parameters
    ----------
    measured : xarray.Dataset
        A track table or a trial table.
    computed : System, Fit or xarray.Dataset
        For a track table: a system or a fit of one (`latolato.fit_model`, `latolato.fit_decay`)
        whose motion is computed on the measured drive. For trials: a sweep's dataset, whose
        classes are compared with theirs, or a system or fit, whose response curves are.
    drive : Drive or "measured", optional
        How the pivot of a track table moves, by default as it was measured.
    **options
        Options of `compare_motion`, `compare_map` or `compare_response` in
        `latolato.experiment.comparison`: ``sigmas`` and ``draws`` for the uncertainty (by default
        that of the fit), ``match``, ``initial_offset``, ``duration`` and so on.

    Returns
    -------
    xarray.Dataset
        With the attributes ``comparison`` (motion, map or response) and ``verdict``, a sentence.
        `latolato.plot` draws it.

    Raises
    ------
    InputError
        For bad input.

    Examples
    --------
    >>> import latolato as ll
    >>> from latolato.experiment.track_table import track_table
    >>> ball = ll.Pendulum(length=0.363, mass=0.108, damping=0.00274)
    >>> swing = ll.simulate(ball, initial_angle=0.5, duration=12.0)
    >>> table = track_table({"time": swing.time, "pivot_y": 0.0 * swing.time,
    ...                      "angle_1": swing.angle})
    >>> ll.compare(table, ball).attrs["comparison"]
    'motion'
    """
    import xarray as xr

    from latolato.experiment.fits.result import Fit

    if not isinstance(measured, xr.Dataset):
        raise InputError("compare needs a track table or trials", value=type(measured).__name__)
    kind = measured.attrs.get("table")
    if kind not in ("track", "trials"):
        raise InputError("compare needs a track table or a trial table")
    if isinstance(computed, Fit):
        system, sigmas = system_of(computed)
        options = {"sigmas": sigmas, **options}
        if kind == "track" and drive is None:
            # None for the measured one.
            is_given = computed.dataset.attrs.get("pivot") == "the given drive"
            drive = computed.drive if is_given else None
        computed = system
    if kind == "track":
        if not isinstance(computed, System):
            raise InputError("a track table is compared with a system or a fit", value=computed)
        from latolato.experiment.comparison.motion import compare_motion

        return compare_motion(measured, computed, drive, **options)
    if drive is not None:
        raise InputError("trials contain their own drive: omit drive")
    if isinstance(computed, System):
        from latolato.experiment.comparison.response import compare_response

        return compare_response(measured, computed, **options)
    from latolato.experiment.comparison.places import compare_map

    return compare_map(measured, computed, **options)


def system_of(fit: Fit) -> tuple[System, dict[str, float]]:
    """Return the system of a fit and the standard deviations of its numbers.

    Raises
    ------
    InputError
        If the fit does not describe its record, or does not define a complete system.
    """
    if not fit.describes:
        raise InputError(fit.doubt, way_out="compare with a fit that describes its record")
    system = fit.system
    if system is None:
        raise InputError(
            f"a fit of {fit.kind} does not define a complete system: use a fit of a model, "
            "or of a decay with its mass"
        )
    return system, {f.name: fit[f.name].sigma for f in fields(system) if f.name in fit}
