"""Sweeps: maps of many trajectories over any parameters, gathered on threads, GPUs or a cluster."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.core.errors import InputError
from latolato.physics.contacts import ContactLaw
from latolato.physics.drives import Drive
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import System
from latolato.simulation.start import DEFAULT_REST_SPEED
from latolato.sweeps.executors import ROUNDING, executor_named
from latolato.sweeps.plan import DEFAULT_OBSERVABLES, Plan, make_plan

if TYPE_CHECKING:
    import xarray as xr

    from latolato.observables import Observable


def sweep(
    system: System,
    drive: Drive | None = None,
    *,
    axes: Mapping[str, Any],
    duration: float,
    observables: Sequence[str | Observable] = DEFAULT_OBSERVABLES,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    initial_distance: float | Sequence[float] | None = None,
    transient: float = 0.0,
    transient_periods: float = 0.0,
    tolerance: float = 1e-6,
    contact: str | ContactLaw | None = "exact",
    rest_speed: float = DEFAULT_REST_SPEED,
    contact_limit: int = 1_000_000,
    noise: VelocityKicks | None = None,
    continuation: str | None = None,
    direction: str = "up",
    executor: str = "threads",
    workers: int | None = None,
    client: Any = None,
    store: str | Path | None = None,
    chunk_size: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    sensitivity_to: str | Sequence[str] | None = None,
) -> xr.Dataset:
    """Return observables of many trajectories as a dataset over the varied parameters.

    Parameters
    ----------
    system, drive
        The laws, with the values of the parameters that do not vary. Without a drive, axes that
        name an amplitude and a frequency vary a `Harmonic` one.
    axes : mapping
        ``{"drive_amplitude": values, "frequency_ratio": values}`` is a grid over both. A mapping
        as value varies several parameters together: ``{"case": {"length": ..., "radius": ...}}``.
        Any number of the system or the drive, `initial_angle`, `initial_angular_velocity`,
        `initial_offset`, `initial_distance` (of a `BallPair` with ``_right`` or ``_left`` behind),
        and `frequency_ratio`, `amplitude_ratio`, `drive_acceleration_ratio` may vary.
    duration : float
        End of every run [s].
    observables : sequence
        Names or instances of `latolato.observables`; a variable's name stands for its observable.
    initial_angle, initial_angular_velocity, initial_offset, initial_distance
        As for `latolato.simulate`.
    transient, transient_periods : float
        Time [s], or number of drive periods (natural ones without a drive), after which
        observables begin; they add up.
    tolerance, contact, rest_speed, contact_limit, noise
        As for `latolato.simulate`. Point k (in C order over the axes) sees the stream
        ``noise.noise_stream + k``: a run with ``VelocityKicks(..., noise_stream=...)`` of that
        number sees the same kicks. Each field of the noise may be an axis; where
        ``noise_seed`` or ``noise_stream`` is one, points that differ in other parameters see
        equal kicks.
    continuation : str, optional
        Name of an axis along which every point starts where its neighbour ended, with the phase
        of the drive going on: hysteresis.
    direction : {"up", "down", "both"}
        Way along the axis of a continuation, up towards larger values; ``"both"`` adds a dimension
        `direction`.
    executor : {"threads", "reference", "dask", "cuda"}
        Where the points run. ``"reference"`` is plain Python.
    workers : int, optional
        Threads, or processes of a local cluster for ``"dask"``.
    client : distributed.Client or str, optional
        The cluster or its address, for ``"dask"``.
    store : str or Path, optional
        Folder of a Zarr store that is written chunk by chunk and resumed if it exists.
    chunk_size : int, optional
        Points that a worker takes, and that the store writes, at once.
    progress : callable, optional
        Called with the points done and their total number.
    sensitivity_to
        Refused: derivatives with respect to parameters are those of the samples of a single run.

    Returns
    -------
    xarray.Dataset
        The observables' variables over the axes (also on ``ball`` for a `BallPair`, on ``sample``
        where an observable gives several numbers), and `status`, a word: ``converged``,
        ``grazing`` or ``rest``; where it is ``event_limit``, ``failed``, ``invalid`` or
        ``outside_model`` everything else is NaN. Elsewhere NaN stands for what does not exist, such
        as a mean impact speed without impacts.

    Raises
    ------
    InputError
        For bad input, naming value, rule and way out.

    Notes
    -----
    Results do not depend on chunks, on the number of workers or on what ran before: they are
    identical bit by bit on one machine, on threads and Dask. ``"reference"`` and ``"cuda"`` round
    differently and cut some steps beside a wall elsewhere; at regular points they agree within the
    tolerance, `mean_energy` within the fourth power of the step.

    A new combination of laws and observables is compiled for some ten seconds, once.

    Examples
    --------
    >>> import latolato as ll
    >>> pendulum = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    >>> grid = ll.sweep(
    ...     pendulum, axes={"drive_amplitude": [0.02, 0.1], "frequency_ratio": [1.5, 2.0, 2.5]},
    ...     initial_angle=0.01, duration=60.0, observables=["largest_angle"],
    ... )
    >>> grid.largest_angle.dims
    ('drive_amplitude', 'frequency_ratio')
    """
    if sensitivity_to is not None:
        raise InputError(
            "is for single runs: the observables of a sweep have no derivatives",
            parameter="sensitivity_to",
            way_out="call simulate for each point of interest",
        )
    plan = make_plan(
        system,
        drive,
        axes=axes,
        duration=duration,
        observables=observables,
        initial_angle=initial_angle,
        initial_angular_velocity=initial_angular_velocity,
        initial_offset=initial_offset,
        initial_distance=initial_distance,
        transient=transient,
        transient_periods=transient_periods,
        tolerance=tolerance,
        contact=contact,
        rest_speed=rest_speed,
        contact_limit=contact_limit,
        noise=noise,
        continuation=continuation,
        direction=direction,
        chunk_size=chunk_size,
    )
    options = {"workers": workers, "client": client}
    options = {name: value for name, value in options.items() if value is not None}
    return run_plan(plan, executor=executor, store=store, progress=progress, **options)


def run_plan(
    plan: Plan,
    *,
    executor: str = "threads",
    store: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    **options: Any,
) -> xr.Dataset:
    """Return the dataset of a plan; `options` go to the executor. See `sweep`."""
    from latolato.sweeps.chunk import STATUS
    from latolato.sweeps.labels import Memory

    execute = executor_named(executor)
    known = [p.name for p in signature(execute).parameters.values() if p.kind is p.KEYWORD_ONLY]
    for option in options:
        if option not in known:
            takes = f"only {' and '.join(known)}" if known else "no options"
            raise InputError(
                f"executor '{executor}' does not know {option}, it takes {takes}: leave {option} "
                "out or name another executor"
            )
    results: Any

    def missing() -> Iterator[int]:
        yield from results.missing

    # An executor raises for what it lacks when it is called: before a store begins.
    chunks = execute(plan, missing(), **options)
    if store is not None:
        from latolato.sweeps.store import Store

        results = Store(plan, store, ROUNDING[executor])
    else:
        results = Memory(plan, ROUNDING[executor])
    with results:
        done = results.points_done
        if progress is not None:
            progress(done, plan.size)
        for number, (values, reason) in chunks:
            results.write(number, values, reason)
            done += values[STATUS].size
            if progress is not None:
                progress(done, plan.size)
        dataset: xr.Dataset = results.dataset()
    counts = results.status_counts()
    lost = {name: counts[name] for name in ("event_limit", "failed", "invalid") if name in counts}
    if lost:
        text = ", ".join(f"{n} {name}" for name, n in lost.items())
        why = dataset.attrs.get("first_invalid", "")
        warnings.warn(
            f"{sum(lost.values())} of {plan.size} points have no answer: {text}"
            + (f" ({why})" if why else ""),
            RuntimeWarning,
            stacklevel=3,
        )
    return dataset
