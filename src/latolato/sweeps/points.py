"""Turns points of a plan into the arrays that kernels read.

Parameters become columns, columns the fields of cases, and `latolato.numerics.prepare` does the
rest, as for a single run. Objects are made for drives of several segments and for noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError
from latolato.core.registry import number_fields
from latolato.numerics import records
from latolato.numerics.batch import Points
from latolato.numerics.integrate import motion_laws, moves_in_plane, prepare_cases
from latolato.numerics.prepare import Cases, cases_of, has_nonsmooth_drag
from latolato.numerics.records import BALL, BODY, PROBLEM, SETTINGS
from latolato.numerics.run_record import STATE
from latolato.numerics.steppers import BLANES_MOAN_GENERAL, BLANES_MOAN_RKN, Stepper
from latolato.physics.noise import KEY, VelocityKicks
from latolato.physics.pendulum import System
from latolato.physics.problems import FINE, OUT_OF_RANGE, TRANSIENT, refusal
from latolato.simulation.start import kicks_of
from latolato.simulation.vary import DERIVED, parameters_of, replaced
from latolato.sweeps.plan import Plan

Floats = NDArray[np.float64]
Columns = dict[str, Floats]

# A last drive period counts as complete if it ends this little after the run (relative).
LAST_PERIOD = 1e-14


@dataclass(frozen=True)
class Batch:
    """Points ready to run.

    Attributes
    ----------
    columns : dict of ndarray, shape (point,)
        Every parameter by name.
    states : ndarray, shape (point,)
        Records of the motion at time zero.
    valid : ndarray of bool, shape (point,)
        False where the parameters contradict each other; such points do not run.
    reason : str
        What is wrong with the first invalid point.
    """

    columns: Columns
    points: Points
    states: NDArray[Any]
    valid: NDArray[np.bool_]
    reason: str


@dataclass(frozen=True)
class Previous:
    """Where the points before these on a continuation ended; arrays of shape (angle, point)."""

    angles: Floats
    velocities: Floats
    phase: Floats | None


def is_smooth(plan: Plan) -> bool:
    """Return whether no point of the plan has drag that is not smooth at rest."""
    names = {"quadratic_damping", "coulomb_damping"}
    varied = {p.removeprefix("right_").removeprefix("left_") for p in plan.varied}
    return not (names & varied or has_nonsmooth_drag(plan.system.balls, plan.system.angles))


def is_planar(plan: Plan) -> bool:
    """Return whether any point of the plan needs the engine for motions in the plane."""
    sideways = plan.drive.across_parameter in plan.varied
    return sideways or moves_in_plane(plan.system, plan.drive)


def laws_of_points(plan: Plan) -> tuple[Any, ...]:
    """Return the laws of `trajectory.make_trajectory` that serve all points of a plan."""
    return motion_laws(plan.system, plan.drive, in_plane=is_planar(plan))


def stepper_of(plan: Plan) -> Stepper:
    """Return the one stepper that all points of a plan use."""
    return BLANES_MOAN_RKN if is_smooth(plan) else BLANES_MOAN_GENERAL


def columns_of(plan: Plan, index: NDArray[np.int64]) -> Columns:
    """Return every parameter of the points with these numbers, arrays of shape (point,)."""
    known = parameters_of(plan.system, plan.drive, plan.noise)
    owners = {"system": plan.system, "drive": plan.drive}
    columns: Columns = {}
    for name, parameter in known.items():
        if parameter.owner not in owners or name in DERIVED:
            continue
        value: Any = owners[parameter.owner]
        for part in parameter.path:
            value = getattr(value, part)
        columns[name] = np.full(len(index), value)
    columns |= {name: np.full(len(index), value) for name, value in plan.start}
    if plan.own_streams:
        assert plan.noise is not None
        columns["noise_stream"] = (plan.noise.noise_stream + index).astype(np.float64)
    place = dict(zip(plan.dims, np.unravel_index(index, plan.shape), strict=True))
    for axis in plan.axes:
        for name, values in zip(axis.parameters, axis.values, strict=True):
            columns[name] = np.array(values)[place[axis.name]]
    _resolve(columns)
    return columns


def _resolve(columns: Columns) -> None:
    """Replace parameters that stand for others; frequencies come before accelerations."""
    length = columns["length"] if "length" in columns else columns["right_length"]
    gravity = columns["gravity"]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        if "frequency_ratio" in columns:
            ratio = columns.pop("frequency_ratio")
            columns["drive_frequency"] = ratio * np.sqrt(gravity / length)
        if "amplitude_ratio" in columns:
            columns["drive_amplitude"] = columns.pop("amplitude_ratio") * length
        if "drive_acceleration_ratio" in columns:
            lift = columns.pop("drive_acceleration_ratio") * gravity
            columns["drive_amplitude"] = lift / columns["drive_frequency"] ** 2


def make_batch(plan: Plan, index: NDArray[np.int64], previous: Previous | None = None) -> Batch:
    """Return the points with these numbers, of which some may continue earlier ones."""
    columns = columns_of(plan, index)
    if previous is not None and previous.phase is not None:
        columns["drive_phase"] = previous.phase
    count = len(index)
    valid = _are_in_range(plan, columns)
    stops, problems = _stops(plan, columns)
    cases = _cases(plan, columns, previous)
    segments, firsts = _stretches(plan, columns, cases, valid)
    settings = np.zeros(count, dtype=SETTINGS)
    bodies = np.zeros((count, 1 if plan.system.angles == 1 else 4), dtype=BODY)
    states = np.zeros(count, dtype=STATE)
    problems["number"][~valid] = OUT_OF_RANGE
    # Drives with numbers of their own have given their bounds.
    has_forms = segments.dtype == records.segment_dtype()
    prepare_cases(Cases(
        cases, segments if has_forms else np.zeros(0, dtype=records.segment_dtype()),
        firsts, settings, bodies, states, problems,
    ))  # fmt: skip
    valid = problems["number"] == FINE
    kick_times, kick_sizes, kick_firsts = _kicks(plan, columns, valid)
    points = Points(
        settings, bodies, segments, firsts, kick_times, kick_sizes, kick_firsts,
        stops, plan.contact_limit,
    )  # fmt: skip
    reason = ""
    if not valid.all():
        first = int(np.argmin(valid))
        reason = _reason(plan, columns, first, problems[first])
    return Batch(columns, points, states, valid, reason)


def _are_in_range(plan: Plan, columns: Columns) -> NDArray[np.bool_]:
    """Return the mask of points whose parameters all lie in their ranges."""
    known = parameters_of(plan.system, plan.drive, plan.noise)
    valid = np.ones(len(columns["gravity"]), dtype=bool)
    for name in columns.keys() & known.keys():
        for limit in known[name].limits:
            valid &= limit.holds(columns[name])
    return valid


def _cases(plan: Plan, columns: Columns, previous: Previous | None) -> NDArray[Any]:
    """Return the points' cases, without the bounds of their drives."""
    cases = cases_of(
        plan.system, plan.contact, count=len(columns["gravity"]), duration=plan.duration,
        tolerance=plan.tolerance, rest_speed=plan.rest_speed, is_nonsmooth=not is_smooth(plan),
        follows_tension=_follows_tension(plan), mirrored=any(o.mirrored for o in plan.observables),
    )  # fmt: skip
    for name in ("gravity", "restitution", "initial_offset", "string_restitution"):
        if name in columns:
            cases[name] = columns[name]
    one = plan.system.angles == 1
    for i, side in enumerate(("",) if one else ("right", "left")):
        for name in BALL.names or ():
            column = columns.get(name if one else f"{side}_{name}")
            if column is not None:
                cases["balls"][name][:, i] = column
        for name in ("initial_angle", "initial_angular_velocity", "initial_distance"):
            column = columns.get(name if one else f"{name}_{side}")
            if column is not None:
                cases[name][:, i] = column
    if previous is not None:
        cases["initial_offset"], cases["clamps_start"] = math.nan, 1
        for i in range(plan.system.angles):
            cases["initial_angle"][:, i] = previous.angles[i]
            cases["initial_angular_velocity"][:, i] = previous.velocities[i]
    return cases


def _stretches(
    plan: Plan, columns: Columns, cases: NDArray[Any], valid: NDArray[np.bool_]
) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Return the segments of all points' drives, and where those of each begin.

    A drive's bounds go into its case, and points whose drive is impossible become invalid; whole
    columns turn into segments where each point has one cosine.
    """
    count = len(cases)
    if plan.drive.rotation is not None and plan.drive.write is not None:
        segments = np.zeros(count, dtype=records.segment_dtype())
        plan.drive.write([segments.view(np.recarray)], SimpleNamespace(**columns))
        return segments, np.arange(count + 1)
    result: list[NDArray[Any]] = []
    firsts, known = np.zeros(count + 1, dtype=np.int64), None
    for k in range(count):
        firsts[k + 1] = firsts[k]
        if not valid[k]:
            continue
        try:
            drive = _law_at(plan, columns, k, "drive")
        except (InputError, ArithmeticError):
            valid[k] = False
            continue
        if known is None or known[0] is not drive:
            own = records.segment_records(drive, plan.duration)
            known = drive, own, drive.largest_acceleration, drive.fastest_frequency
        result.append(known[1])
        firsts[k + 1] += len(known[1])
        cases["pivot_bound"][k], cases["drive_rate"][k] = known[2:]
    whole = np.concatenate(result) if result else np.zeros(0, dtype=records.segment_dtype())
    return whole, firsts


def _kicks(
    plan: Plan, columns: Columns, valid: NDArray[np.bool_]
) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Return instants and sizes of all points' kicks, and where those of each begin."""
    firsts = np.zeros(len(valid) + 1, dtype=np.int64)
    if plan.noise is None:
        return np.zeros(0), np.zeros((plan.system.angles, 0)), firsts
    times, sizes = [np.zeros(0)], [np.zeros((plan.system.angles, 0))]
    for k in range(len(valid)):
        firsts[k + 1] = firsts[k]
        if valid[k]:
            system = _law_at(plan, columns, k, "system")
            instants, each = kicks_of(_noise(plan, columns, k), system, plan.duration)
            assert instants is not None
            assert each is not None
            times.append(instants)
            sizes.append(each)
            firsts[k + 1] += len(instants)
    return np.concatenate(times), np.concatenate(sizes, axis=1), firsts


def _noise(plan: Plan, columns: Columns, k: int) -> VelocityKicks | None:
    """Return the noise of one point."""
    if plan.noise is None:
        return None
    values: dict[str, Any] = {}
    for field in number_fields(plan.noise):
        if field.name in columns:
            value = columns[field.name][k]
            values[field.name] = int(value) if field.name in KEY else float(value)
    return replace(plan.noise, **values)


def transient_of(plan: Plan, columns: Columns) -> Floats:
    """Return how long the transient lasts at each point [s]."""
    period = _drive_period(columns)
    length = columns["length"] if "length" in columns else columns["right_length"]
    with np.errstate(over="ignore"):
        natural = math.tau * np.sqrt(length / columns["gravity"])
        periods: Floats = plan.transient_periods * np.where(np.isfinite(period), period, natural)
    return plan.transient + periods


def _drive_period(columns: Columns) -> Floats:
    """Return the drive's period at each point [s], infinite without a drive."""
    first = next(iter(columns.values()))
    frequency = columns.get("drive_frequency", np.zeros(len(first)))
    with np.errstate(divide="ignore"):
        period: Floats = math.tau / frequency
    return period


def _stops(plan: Plan, columns: Columns) -> tuple[Floats, NDArray[Any]]:
    """Return the instants at which steps end, (point, 2 + mark), and points' problems with them."""
    transient = transient_of(plan, columns)
    marks = max((o.marks for o in plan.observables), default=0)
    stops = np.full((len(transient), 2 + marks), np.nan)
    stops[:, 0], stops[:, -1] = transient, plan.duration
    if marks:
        period = _drive_period(columns)
        with np.errstate(invalid="ignore"):
            last = np.floor(plan.duration / period * (1.0 + LAST_PERIOD))
            numbers = last[:, None] - np.arange(marks - 1, -1, -1)
            instants = np.minimum(numbers * period[:, None], plan.duration)
        inside = np.isfinite(instants) & (numbers >= 0.0) & (instants >= transient[:, None])
        stops[:, 1:-1] = np.where(inside, instants, np.nan)
    problems = np.zeros(len(transient), dtype=PROBLEM)
    problems["number"] = np.where(transient < plan.duration, FINE, TRANSIENT)
    problems["values"][:, 0], problems["values"][:, 1] = transient, plan.duration
    return stops, problems


def _reason(plan: Plan, columns: Columns, k: int, problem: Any) -> str:
    """Return the reason why a point is invalid, with the error of a single run."""
    if problem["number"] == OUT_OF_RANGE:  # a law may have its own words
        try:
            for owner in ("system", "drive"):
                _law_at(plan, columns, k, owner)
        except InputError as error:
            return str(error)
        except ArithmeticError:
            pass
    return str(refusal(problem["number"], problem["values"]))


def _follows_tension(plan: Plan) -> bool:
    """Return whether an observable asks for the time of compression."""
    is_needed = any("compression" in o.needs for o in plan.observables)
    return is_needed and not plan.system.is_linear


def _law_at(plan: Plan, columns: Columns, k: int, owner: str) -> Any:
    """Return the system or the drive of a point.

    Raises
    ------
    InputError
        If its parameters are impossible.
    """
    known = parameters_of(plan.system, plan.drive, plan.noise)
    phase = columns.get("drive_phase")  # a continuation carries it on
    is_turned = phase is not None and phase[k] != plan.drive.drive_phase  # type: ignore[attr-defined]
    names = {DERIVED.get(n, n) for n in plan.varied | ({"drive_phase"} if is_turned else set())}
    changed = {known[n].path: float(columns[n][k]) for n in names if known[n].owner == owner}
    return replaced(getattr(plan, owner), changed)


def _distances(system: System, columns: Columns, k: int) -> Any:
    """Return the distances at which the balls of a point start [m], None for taut strings."""
    sides = ("",) if system.angles == 1 else ("_right", "_left")
    names = [f"initial_distance{side}" for side in sides]
    if not columns.keys() & set(names):
        return None
    distances = tuple(
        float(columns[name][k]) if name in columns else ball.length
        for name, ball in zip(names, system.balls, strict=True)
    )
    return distances if len(distances) > 1 else distances[0]


def arguments_of(plan: Plan, number: int) -> dict[str, Any]:
    """Return the arguments of `latolato.simulate` that run one point of a plan alone.

    Raises
    ------
    InputError
        If the point is invalid, or if it goes on from another point.
    """
    if plan.continuation:
        raise InputError(
            f"a point of this map continues from its neighbour along {plan.continuation}: it "
            "cannot run alone"
        )
    batch = make_batch(plan, np.array([number]))
    if batch.reason:
        raise InputError(batch.reason)
    columns = batch.columns
    system, drive = (_law_at(plan, columns, 0, owner) for owner in ("system", "drive"))
    angles, velocities = (
        tuple(batch.states[name][0, : system.angles].tolist()) for name in ("angle", "velocity")
    )
    one = system.angles == 1
    result = {
        "system": system,
        "drive": drive,
        "initial_angle": angles[0] if one else angles,
        "initial_angular_velocity": velocities[0] if one else velocities,
        "initial_distance": _distances(system, columns, 0),
        "duration": plan.duration,
        "tolerance": plan.tolerance,
        "contact": plan.contact if system.has_contacts else None,
        "rest_speed": plan.rest_speed,
        "contact_limit": plan.contact_limit,
        "noise": _noise(plan, columns, 0),
    }
    return {name: value for name, value in result.items() if value is not None}
