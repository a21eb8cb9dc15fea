"""One run: a system, a drive and a start become a labelled dataset with a closed energy ledger."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.rules import broken_rule, sentence
from latolato.numerics import records
from latolato.numerics.derived import ACROSS_ROWS, BALL_ROWS, PIVOT_ROWS, Observation, ball_records
from latolato.numerics.engine.samples import MOST_HALVINGS, MOST_STEPS_TO_REPEAT, allowed_error
from latolato.numerics.integrate import (
    Directions,
    Floats,
    Trajectory,
    integrate,
    laws_key,
    moves_in_plane,
    observe,
)
from latolato.numerics.prepare import choose_stepper
from latolato.physics.contacts import ContactLaw
from latolato.physics.drives import Drive
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import System
from latolato.simulation.plan import RunPlan, make_run_plan
from latolato.simulation.record import Record, add_sensitivities, attributes_of, record_of
from latolato.simulation.sensitivity import batches_of, directions_of
from latolato.simulation.start import (
    DEFAULT_REST_SPEED,
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
    sensitivity_to: str | Sequence[str] = (),
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
    sensitivity_to : str or sequence of str
        Parameters with respect to which the motion is differentiated, by the names that axes of
        sweeps have: ``"restitution"``, ``"right_mass"``, ``"drive_phase"``, ``"frequency_ratio"``,
        ``"initial_angle_left"``. All others keep their values. A ratio among them, such as
        ``"frequency_ratio"``, keeps its value too, so that the drive moves with the length or the
        gravity as it does in a sweep with these axes; see Notes.
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
        of kinds ``slack`` and ``taut``. With `sensitivity_to` there are `angle_sensitivity` and
        `angular_velocity_sensitivity` on ``parameter`` and ``time``, the derivatives at a fixed
        time, and `contact_time_sensitivity` on ``parameter`` and ``contact``; the units are those
        of the variable per SI unit of the parameter.

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

    Derivatives with respect to parameters are exact through impacts, rest, lift-off and slack: they
    follow the variational equation of the very steps, and jump at events. Walls move with radius
    and length, and a start at an `initial_offset` moves with its wall. The derivative by the length
    is that at a fixed `drive_frequency` [rad/s] and `drive_amplitude` [m], unless `sensitivity_to`
    names a ratio that sets one of them: it is then that at this fixed ratio. Derivatives are NaN,
    and the attribute `sensitivity_status` says since when and why, once they do not exist or cannot
    be trusted: after a graze, two events at one instant, or a capture of two balls. Of the start of
    rest by capture `contact_time_sensitivity` alone is NaN.
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
    plan = make_run_plan(
        system,
        drive,
        initial_angle=initial_angle,
        initial_angular_velocity=initial_angular_velocity,
        initial_offset=initial_offset,
        initial_distance=initial_distance,
        duration=duration,
        times=times,
        tolerance=tolerance,
        contact=contact,
        rest_speed=rest_speed,
        frame=frame,
        noise=noise,
        contact_limit=contact_limit,
        sensitivity_to=sensitivity_to,
    )
    return run_plan(plan, progress).to_dataset()


def record(*args: Any, progress: Callable[[float], None] | None = None, **options: Any) -> Record:
    """Return the result of `simulate` for the same arguments, as plain arrays.

    Examples
    --------
    >>> import latolato as ll
    >>> float(record(ll.Pendulum(length=1.0, mass=1), initial_angle=0.1, duration=2.0)["time"][-1])
    2.0
    """
    return run_plan(make_run_plan(*args, **options), progress)


def run_plan(plan: RunPlan, progress: Callable[[float], None] | None = None) -> Record:
    """Return the record of a planned run."""
    if progress is not None and not callable(progress):
        raise InputError("must be a function", parameter="progress", value=progress)
    clamped = plan.law.fixed_step is not None
    # One run carries a few parameters; with more of them it is made again for the others.
    batches: list[Directions | None] = [
        directions_of(plan, parameters) for parameters in batches_of(plan.sensitivity_to)
    ]
    first, *others = batches or [None]
    trajectory, halvings = _integrated(plan, plan.step, first, progress), 0
    if not clamped:
        trajectory, halvings = _closed(plan, trajectory, first, progress)
    residual = float(trajectory.state.ledger_error)
    if trajectory.status != "complete":
        if not trajectory.contact_times.size and not np.isfinite(trajectory.samples[0]).any():
            raise broken_rule("no_sample", {"status": trajectory.status})
        early = sentence("ended_early", status=trajectory.status)
        warnings.warn(early, RuntimeWarning, stacklevel=3)
    quantities = _observe(plan, trajectory)
    attrs = attributes_of(plan)
    attrs.update(
        energy_residual=residual,
        status=trajectory.status,
        step=trajectory.step,
        stepper="classical Runge-Kutta" if clamped else choose_stepper(plan.system).name,
        step_halvings=halvings,
        grazing_contacts=int(trajectory.state.grazes),
        contacts=len(trajectory.contact_times),
    )
    if not plan.law.stores_energy:
        attrs["energy_residual"] = max(residual, _sampled_residual(trajectory, quantities))
    result = record_of(plan.system, trajectory, quantities, plan.instants, plan.frame, attrs)
    if plan.sensitivity_to:
        step = trajectory.step
        again = [_integrated(plan, step, directions, None) for directions in others]
        add_sensitivities(result, plan, [trajectory, *again])
    if plan.system.suspension == "string":
        attrs.update(_slackness(plan.system, trajectory))
    elif "tension" in result:
        attrs.update(_compression(plan.system, trajectory))
    return result


def _integrated(
    plan: RunPlan,
    step: float,
    directions: Directions | None,
    progress: Callable[[float], None] | None,
) -> Trajectory:
    """Return the trajectory of a plan with steps of this length [s], differentiated if asked."""
    return integrate(
        plan.system,
        plan.drive,
        plan.start,
        plan.instants,
        plan.end,
        rest_speed=plan.rest_speed,
        contact_limit=plan.contact_limit,
        kick_times=plan.kick_times,
        kick_sizes=plan.kick_sizes,
        law=plan.law,
        step=step,
        directions=directions,
        progress=progress,
    )


def _closed(
    plan: RunPlan,
    trajectory: Trajectory,
    directions: Directions | None,
    progress: Callable[[float], None] | None,
) -> tuple[Trajectory, int]:
    """Return the run with the largest step that closes the energy ledger, and its halvings.

    If none does, it is the last one, with a warning.
    """
    halvings = 0
    while True:
        state = trajectory.state
        residual, allowed = float(state.ledger_error), float(allowed_error(state, plan.tolerance))
        if residual <= allowed or trajectory.status != "complete":
            return trajectory, halvings
        if halvings == MOST_HALVINGS or int(state.total_steps) > MOST_STEPS_TO_REPEAT:
            text = sentence(
                "open_ledger",
                residual=residual,
                share=residual / max(float(state.largest_energy), np.finfo(float).tiny),
                tolerance=plan.tolerance,
                step=trajectory.step,
            )
            warnings.warn(text, RuntimeWarning, stacklevel=4)
            return trajectory, halvings
        halvings += 1
        trajectory = _integrated(plan, plan.step * 0.5**halvings, directions, progress)


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
    first: Any = known * state.slack_start
    share: Any = _share_of(state.slack_time, trajectory)
    if system.angles == 1:
        first, share = float(first[0]), float(share[0])
    impulse = known * float(state.string_impulse)
    return {"first_slack": first, "slack_fraction": share, "largest_string_impulse": impulse}


def _compression(system: System, trajectory: Trajectory) -> dict[str, Any]:
    """Return when a rod is first pushed [s], and in which share of the time [1], of each ball."""
    # What a failed run adds up last is no compression.
    known = math.nan if trajectory.failed else 1.0
    first: Any = known * trajectory.state.compression_start
    share: Any = _share_of(trajectory.state.compression_time, trajectory)
    if system.angles == 1:
        first, share = float(first[0]), float(share[0])
    return {"compression_time": first, "compression_fraction": share}


def _observe(plan: RunPlan, trajectory: Trajectory) -> dict[str, Floats]:
    """Return the pivot's motion, shape (time,), and per-ball quantities, shape (ball, time)."""
    system, drive, times = plan.system, plan.drive, plan.instants
    segments = records.segment_records(drive, plan.end)
    balls, in_plane = ball_records(system.balls), moves_in_plane(system, drive)
    names = (*PIVOT_ROWS, *ACROSS_ROWS) if in_plane else PIVOT_ROWS
    pivot = np.empty((len(names), len(times)))
    out = np.empty((len(balls), len(BALL_ROWS), len(times)))
    samples = trajectory.samples
    observation = Observation(
        times, samples[records.S_MODE], samples, segments, balls, float(system.gravity),
        int(system.is_linear), int(system.drag_frame == "lab"), int(plan.frame == "both"), pivot,
        out,
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
