"""One run: a system, a drive and a start become a labelled dataset with a closed energy ledger."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from inspect import signature
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.registry import check_increasing, checked_array, in_unit
from latolato.numerics import records
from latolato.numerics.engine.samples import MOST_HALVINGS, MOST_STEPS_TO_REPEAT, allowed_error
from latolato.numerics.integrate import (
    Floats,
    Trajectory,
    choose_step,
    integrate,
    laws_key,
    moves_in_plane,
    observe,
)
from latolato.numerics.derived import ACROSS_ROWS, BALL_ROWS, PIVOT_ROWS, Observation, ball_records
from latolato.numerics.prepare import MOST_STEPS, choose_stepper
from latolato.physics.contacts import ContactLaw
from latolato.physics.drives import Drive
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import System
from latolato.simulation.parameters import MOST_SAMPLES, RUN_PARAMETERS
from latolato.simulation.record import Record, attributes_of, record_of
from latolato.simulation.start import (
    DEFAULT_REST_SPEED,
    checked_contact,
    checked_drive,
    checked_start,
    checked_system,
    kicks_of,
    walls_of,
    warn_of_degrees,
)

if TYPE_CHECKING:
    import xarray as xr

SAMPLES_PER_PERIOD = 100


def simulate(
    system: System,
    drive: Drive | None = None,
    *,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    initial_distance: float | Sequence[float] | None = None,
    duration: float | None = None,
    times: Sequence[float] | Floats | None = None,
    tolerance: float = 1e-10,
    contact: str | ContactLaw | None = "exact",
    rest_speed: float = DEFAULT_REST_SPEED,
    frame: str = "pivot",
    noise: VelocityKicks | None = None,
    contact_limit: int = 1_000_000,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Return the motion of a system as a dataset over time, with contacts and energies.

    Paper eq10 (eq14 for `Mathieu`) with impacts by eq11, resting contact and lift-off.

    Parameters
    ----------
    system : Pendulum, Mathieu, LatoLato or BallPair
        What moves.
    drive : Drive, optional
        How the pivot moves; None is a pivot at rest.
    initial_angle : float or pair of float
        Angle at time zero [rad]; for a `BallPair` (right, left).
    initial_angular_velocity : float or pair of float
        Angular velocity at time zero [rad/s].
    initial_offset : float, optional
        Instead of `initial_angle`: the angle above the low contact angle of a `LatoLato` [rad].
    initial_distance : float or pair of float, optional
        Distance of a ball from the pivot at time zero [m], on a string only: below the length the
        string is slack, and the ball moves around the pivot at `initial_angular_velocity`, not
        outwards. By default all strings are taut.
    duration : float
        End of the run [s]; by default the last of `times`.
    times : array_like of float, shape (time,), optional
        Strictly increasing instants in [0, duration] [s] at which the state is wanted; by default
        at least 100 in the shorter of the natural and the driving period.
    tolerance : float
        Aimed-at error of the angle over a few hundred periods of regular motion [rad], in
        [1e-14, 1e-2]; see Notes.
    contact : {"exact", "clamp", None} or a contact law
        `ExactContact` is impact with restitution, rest and lift-off; `ClampContact` the labelled
        fixed-step artefact; None lets the balls pass through each other.
    rest_speed : float
        Impacts up to this speed [rad/s] begin rest when the restitution is below 1.
    frame : {"pivot", "both"}
        ``"both"`` adds `lab_energy` and `rod_power` of the laboratory frame.
    noise : VelocityKicks, optional
        Random velocity kicks.
    contact_limit : int
        Contacts after which the run stops with a status and a warning.
    progress : callable, optional
        Called with the fraction done, now and then.

    Returns
    -------
    xarray.Dataset
        Variables on ``time`` (angles, angular velocities and energies also on ``ball`` for a
        `BallPair`, right then left) and on ``contact``. Energies are per ball; the ledger
        (`drive_work`, `damping_loss`, `impact_loss`, `capture_loss` and, on strings,
        `retension_loss`) is per ball for one angle and the sum of both balls for a `BallPair`. On
        strings there are also `distance`, `radial_velocity` and `slack` on ``time``, and contacts
        of kinds ``slack`` and ``taut``.

    Raises
    ------
    InputError
        For bad input, naming value, rule and way out.

    Notes
    -----
    Fixed steps of a symmetric sixth-order splitting, ``5 tolerance^(1/6)`` over the fastest rate
    of the system. The ledger ``E(t) - E(0) - works + losses`` is computed from separate
    quadratures at the end of every step; when it closes worse than 5 tolerances of the largest
    energy, the run is repeated with half the step, three times at most, and a warning follows
    if that was not enough. The motion does not depend on `times`; the attribute `energy_residual`
    is the largest error of the ledger at all steps and samples [J].
    Chaotic motion amplifies every error: only its statistics can be trusted at late times.
    A contact is missed if the ball dips into a wall and returns within a quarter of a step while
    its acceleration keeps its sign at the ends; the depth of such a dip is below the step's error.

    Examples
    --------
    >>> import latolato as ll
    >>> toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
    >>> run = ll.simulate(toy, initial_angle=0.6, duration=2.0)
    >>> [str(kind) for kind in run.contact_kind.values]
    ['bottom', 'bottom']
    """
    return _recorded(**locals()).to_dataset()


def record(*args: Any, **options: Any) -> Record:
    """Return the result of `simulate` for the same arguments, as plain arrays.

    Examples
    --------
    >>> import latolato as ll
    >>> float(record(ll.Pendulum(length=1.0, mass=1), initial_angle=0.1, duration=2.0)["time"][-1])
    2.0
    """
    bound = signature(simulate).bind(*args, **options)
    bound.apply_defaults()
    return _recorded(**bound.arguments)


def _recorded(
    *,
    system: System,
    drive: Drive | None,
    initial_angle: float | Sequence[float] | None,
    initial_angular_velocity: float | Sequence[float],
    initial_offset: float | None,
    initial_distance: float | Sequence[float] | None,
    duration: float | None,
    times: Sequence[float] | Floats | None,
    tolerance: float,
    contact: str | ContactLaw | None,
    rest_speed: float,
    frame: str,
    noise: VelocityKicks | None,
    contact_limit: int,
    progress: Callable[[float], None] | None,
) -> Record:
    """Return the record of a run; arguments as of `simulate`."""
    drive = checked_drive(drive, checked_system(system))
    law = checked_contact(contact, system)
    tolerance = RUN_PARAMETERS["tolerance"].checked(tolerance)
    rest_speed = RUN_PARAMETERS["rest_speed"].checked(rest_speed)
    contact_limit = RUN_PARAMETERS["contact_limit"].checked(contact_limit)
    if progress is not None and not callable(progress):
        raise InputError("must be a function", parameter="progress", value=progress)
    frame = RUN_PARAMETERS["frame"].checked(frame)
    instants, end = _checked_times(system, drive, times, duration)
    walls = walls_of(system, law)
    start = checked_start(
        system, walls, initial_angle, initial_angular_velocity, initial_offset, initial_distance
    )
    warn_of_degrees("initial_angle", start.angles, stacklevel=3)
    kick_times, kick_sizes = kicks_of(noise, system, end)

    if law.fixed_step is not None and law.fixed_step > end:
        raise InputError(
            f"must not exceed the duration {end:g} s",
            parameter="clamp_step",
            value=law.fixed_step,
            way_out="a thousandth of a second is usual",
        )
    step = choose_step(system, drive, start, tolerance, law)
    if end / step > MOST_STEPS:
        raise InputError(
            f"the run would take {end / step:.3g} steps of {step:.3g} s, the limit is "
            f"{MOST_STEPS:.0e}: shorten the duration, loosen the tolerance or slow the motion"
        )
    begun = partial(
        integrate,
        system,
        drive,
        start,
        instants,
        end,
        rest_speed=rest_speed,
        contact_limit=contact_limit,
        kick_times=kick_times,
        kick_sizes=kick_sizes,
        law=law,
        progress=progress,
    )
    clamped = law.fixed_step is not None
    trajectory, halvings = (begun(step=step), 0) if clamped else _closed(begun, step, tolerance)
    residual = float(trajectory.state.ledger_error)
    if trajectory.status != "complete":
        if not trajectory.contact_times.size and not np.isfinite(trajectory.samples[0]).any():
            raise InputError(
                f"the run {trajectory.status}; no sample and no contact is known",
                way_out="ask for earlier times",
            )
        warnings.warn(
            f"the run {trajectory.status}; later samples are NaN", RuntimeWarning, stacklevel=3
        )
    quantities = _observe(system, drive, trajectory, instants, end, frame == "both")
    is_string = system.suspension == "string"
    run = {
        "tolerance": tolerance,
        "rest_speed": rest_speed,
        "frame": frame,
        "contact_limit": contact_limit,
    }
    attrs = attributes_of(system, drive, law, noise, start, end, run)
    attrs.update(
        energy_residual=residual,
        status=trajectory.status,
        step=trajectory.step,
        stepper="classical Runge-Kutta" if clamped else choose_stepper(system).name,
        step_halvings=halvings,
        grazing_contacts=int(trajectory.state.grazes),
        contacts=len(trajectory.contact_times),
    )
    if not law.stores_energy:
        attrs["energy_residual"] = max(residual, _sampled_residual(trajectory, quantities))
    result = record_of(system, trajectory, quantities, instants, frame, attrs)
    if is_string:
        attrs.update(_slackness(system, trajectory))
    elif "tension" in result:
        attrs.update(_compression(system, trajectory))
    return result


def _closed(
    begun: Callable[..., Trajectory], step: float, tolerance: float
) -> tuple[Trajectory, int]:
    """Return the run with the largest step that closes the energy ledger, and its halvings.

    If none does, it is the last one, with a warning.
    """
    halvings = 0
    while True:
        trajectory = begun(step=step * 0.5**halvings)
        state = trajectory.state
        residual, allowed = float(state.ledger_error), float(allowed_error(state, tolerance))
        if residual <= allowed or trajectory.status != "complete":
            return trajectory, halvings
        if halvings == MOST_HALVINGS or int(state.total_steps) > MOST_STEPS_TO_REPEAT:
            share = residual / max(float(state.largest_energy), np.finfo(float).tiny)
            warnings.warn(
                f"the energy ledger closes only to {residual:.3g} J, {share:.2g} of "
                f"the largest energy: tolerance {tolerance:g} was not reached with step "
                f"{trajectory.step:.3g} s",
                RuntimeWarning,
                stacklevel=4,
            )
            return trajectory, halvings
        halvings += 1


def _share_of(time: Any, trajectory: Trajectory) -> Any:
    """Return a share of the time [1]; a run that failed, or stopped where it began, has none."""
    known = not trajectory.failed and trajectory.reached > 0.0
    return time / trajectory.reached if known else np.full_like(time, math.nan)


def _slackness(system: System, trajectory: Trajectory) -> dict[str, Any]:
    """Return when each ball's string first goes slack [s], in which share of the time [1] it is.

    The largest impulse that any string had to bear comes with them [N s].
    """
    state = trajectory.state
    known = math.nan if trajectory.failed else 1.0
    first, share = known * state.slack_start, _share_of(state.slack_time, trajectory)
    if system.angles == 1:
        first, share = float(first[0]), float(share[0])
    impulse = known * float(state.string_impulse)
    return {"first_slack": first, "slack_fraction": share, "largest_string_impulse": impulse}


def _compression(system: System, trajectory: Trajectory) -> dict[str, Any]:
    """Return when a rod is first pushed [s], and in which share of the time [1], of each ball."""
    # What a failed run adds up last is no compression.
    known = math.nan if trajectory.failed else 1.0
    first = known * trajectory.state.compression_start
    share = _share_of(trajectory.state.compression_time, trajectory)
    if system.angles == 1:
        first, share = float(first[0]), float(share[0])
    return {"compression_time": first, "compression_fraction": share}


def _checked_times(
    system: System, drive: Drive, times: Any, duration: float | None
) -> tuple[Floats, float]:
    """Return the sample instants and the end of the run [s]."""
    if times is None:
        if duration is None:
            raise InputError(
                "is needed: give the end of the run in s, or times", parameter="duration"
            )
        end = RUN_PARAMETERS["duration"].checked(duration)
        fastest = max(system.natural_frequency, drive.fastest_frequency)
        periods = end * fastest / (2.0 * math.pi)
        if periods * SAMPLES_PER_PERIOD > MOST_SAMPLES:
            raise InputError(
                f"{periods * SAMPLES_PER_PERIOD:.3g} default samples exceed the limit of "
                f"{MOST_SAMPLES}; ask for the instants you need with times"
            )
        count = math.ceil(periods * SAMPLES_PER_PERIOD) + 1
        return np.linspace(0.0, end, max(count, 2)), end
    parameter = RUN_PARAMETERS["times"]
    times = in_unit("times", times, parameter.unit)
    is_one = isinstance(times, (int, float)) or getattr(times, "shape", None) == ()
    times = [times] if is_one else times
    numbers = checked_array("times", times, parameter.allowed, unit=parameter.unit)
    instants = np.array(numbers)
    if np.any(np.diff(instants) <= 0.0):
        check_increasing("times", numbers)
    if duration is None and instants[-1] <= 0.0:
        raise InputError(
            f"must reach beyond 0 s, where a run begins, got {instants[-1]:g} as the last",
            parameter="times",
            way_out="add a later instant or give duration",
        )
    end = RUN_PARAMETERS["duration"].checked(instants[-1] if duration is None else duration)
    if instants[0] < 0.0 or instants[-1] > end:
        outside = instants[0] if instants[0] < 0.0 else instants[-1]
        raise InputError(f"must lie in [0, duration = {end:g}] s", parameter="times", value=outside)
    return instants, end


def _observe(
    system: System,
    drive: Drive,
    trajectory: Trajectory,
    times: Floats,
    end: float,
    with_lab: bool,
) -> dict[str, Floats]:
    """Return the pivot's motion, shape (time,), and per-ball quantities, shape (ball, time)."""
    segments = records.segment_records(drive, end)
    balls, in_plane = ball_records(system.balls), moves_in_plane(system, drive)
    names = (*PIVOT_ROWS, *ACROSS_ROWS) if in_plane else PIVOT_ROWS
    pivot = np.empty((len(names), len(times)))
    out = np.empty((len(balls), len(BALL_ROWS), len(times)))
    samples = trajectory.samples
    observation = Observation(
        times, samples[records.S_MODE], samples, segments, balls, float(system.gravity),
        int(system.is_linear), int(system.drag_frame == "lab"), int(with_lab), pivot, out,
    )  # fmt: skip
    laws: tuple[Any, ...] = drive.height, drive.velocity, drive.acceleration
    if in_plane:
        laws += drive.across, drive.across_velocity, drive.across_acceleration
    else:
        laws += laws_key(system)
    observe(observation, *laws)
    result = dict(zip(names, pivot, strict=True))
    result.update({name: out[:, row] for row, name in enumerate(BALL_ROWS)})
    with np.errstate(over="ignore"):  # a linear run may grow beyond all numbers
        result["total_energy"] = result["kinetic_energy"] + result["potential_energy"]
    return result


def _sampled_residual(trajectory: Trajectory, quantities: dict[str, Floats]) -> float:
    """Return the largest error of the closed ledger at the samples [J]."""
    first = trajectory.state.first_energy
    rows = trajectory.samples
    total = quantities["total_energy"].sum(axis=0)
    gained = rows[records.S_WORK] + rows[records.S_NOISE]
    gone = rows[records.S_DAMPED] + rows[records.S_IMPACT] + rows[records.S_CAPTURED]
    if len(rows) == records.PLANE_ROWS:
        gone = gone + rows[records.S_RETENSION]
    with np.errstate(over="ignore", invalid="ignore"):
        error = np.abs(total - first - gained + gone)
    return float(np.nanmax(error[np.isfinite(rows[0] + rows[1])], initial=0.0))
