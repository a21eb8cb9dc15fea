"""The shortest detour over a faster drive that reaches the large swing, against a hand push."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.checks import check_rods, check_vertical, checked_nonlinear, increasing
from latolato.analysis.protocol import Protocol
from latolato.analysis.registry import analyses, labelled, warn
from latolato.analysis.rules import broken_analysis
from latolato.analysis.starts import start_columns, start_options
from latolato.core.quantities import NON_NEGATIVE, POSITIVE, Quantity, Range
from latolato.core.registry import checked_number
from latolato.physics.drives import Chirp, Drive, Harmonic, Segment, drives
from latolato.physics.drives.segment import COSINE
from latolato.physics.pendulum import System
from latolato.simulation.run import simulate
from latolato.simulation.start import DEFAULT_REST_SPEED, checked_drive, checked_numbers
from latolato.sweeps import sweep

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

FOUND, BY_ITSELF = "found", "reached from rest"
NO_BRANCH, NOT_REACHED = "no upper branch", "not reached"
# The upper branch lies at least so far above the lower one [rad].
_LEAST_GAP = 0.1
# The last share of the time after the protocol in which the settled angle is read.
_READ = 0.25
# More candidates than this are not run in full when chaos makes the search's answers differ.
_MOST_CHECKS = 10
# Default first stages, over the target's frequency, and dwells [s].
_DEFAULT_FIRST = (1.05, 1.6, 12)
_DEFAULT_DWELLS = (0.25, 4.0, 16)
# Default largest push [natural frequencies], and how many.
_DEFAULT_PUSHES = (1.0, 21)
_LASTING = "largest_angle_after_transient"

_QUANTITIES = {
    "first_frequency_ratio": Quantity("1", r"\omega_1/\omega_0", "first-stage frequency ratio"),
    "push": Quantity("rad/s", r"\dot\theta_p", "angular velocity that a push gives each ball"),
    "success_share": Quantity("1", "p", "share of drive phases that reach the upper branch"),
    "push_share": Quantity("1", "p_p", "share of drive phases at which a push reaches it"),
    "best_first_ratio": Quantity("1", r"\omega_1^*/\omega_0", "first stage of the shortest"),
    "best_dwell_time": Quantity("s", "t_d^*", "dwell of the shortest protocol"),
    "lead_time": Quantity("s", "t_l", "time until the target frequency is reached"),
    "checked_share": Quantity("1", "p^*", "its share of success in complete runs"),
    "smallest_push": Quantity("rad/s", r"\dot\theta_p^*", "smallest push that reaches it"),
    "smallest_push_energy": Quantity("J", "E_p", "kinetic energy of that push, all balls"),
    "angle_after_push": Quantity(
        "rad", r"\theta_p", "settled angle after a push, median over drive phases"
    ),
    "angle_from_rest": Quantity("rad", r"\theta_-", "settled angle from rest at the target"),
    "upper_angle": Quantity("rad", r"\theta_+", "settled angle on the upper branch"),
}


class _Search(NamedTuple):
    """What stays the same in a search."""

    system: System
    amplitude: float
    target: float  # rad/s
    ramp: float
    phases: Floats
    settling: float
    start: dict[str, Any]
    options: dict[str, Any]


def last_stage(drive: Drive | None) -> Any:
    """Return the last segment of a drive's motion, a cosine."""
    last = last_cosine(checked_drive(drive))
    if last is None:
        name = "no" if drive is None else f"a {drives.name_of(drive)}"
        raise broken_analysis("drive_of_stages", {"law": name})
    return last


@analyses.register("shortest_protocol", checked_nonlinear, check_rods, check_vertical, last_stage)
def shortest_protocol(
    system: System,
    drive: Drive | None = None,
    *,
    frequency_ratio: Annotated[float | None, POSITIVE] = None,
    first_frequency_ratio: Annotated[Sequence[float] | None, POSITIVE] = None,
    dwell_time: Annotated[Sequence[float] | None, POSITIVE] = None,
    push: Annotated[Sequence[float] | None, "rad/s", POSITIVE] = None,
    ramp: Annotated[float, NON_NEGATIVE] = 0.0,
    phases: int = 8,
    required_share: Annotated[float, Range(0.0, 1.0, open_low=True)] = 0.5,
    settling: Annotated[float, "s", POSITIVE] = 40.0,
    threshold_angle: Annotated[float | None, POSITIVE] = None,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    tolerance: float = 1e-8,
    contact: str | None = "exact",
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return the shortest two-stage drive that reaches the upper branch [s], and the least push.

    Paper Fig. 12 steps the frequency ratio from 3.136 to 2.389; here the first stage is searched.

    Parameters
    ----------
    system : System
        What moves; of two balls, the right one is analysed.
    drive : Harmonic, FrequencySchedule or another that ends as a cosine
        Its last amplitude is used, and its last frequency is the target where none is given.
    frequency_ratio : float, optional
        Target driving over natural frequency [1].
    first_frequency_ratio : sequence of float, optional
        First stages that are tried [1]; by default 12 from 1.05 to 1.6 times the target.
    dwell_time : sequence of float, optional
        How long the first stage is held [s], increasing; by default 16 from 0.25 to 4 s.
    push : sequence of float, optional
        Angular velocities that a hand gives each ball outwards, at the target frequency [rad/s],
        increasing; by default 21 up to one natural frequency.
    ramp : float
        Time in which the frequency moves between the stages [s].
    phases : int
        Drive phases at the start, evenly spread: nobody starts a motor by its phase.
    required_share : float
        Share of these phases that must succeed [1].
    settling : float
        Time after the protocol [s]; the settled angle is the largest one in its last quarter.
    threshold_angle : float, optional
        Settled angle that counts as the upper branch [rad]; by default halfway between the angle
        from rest and the median of those that lie above it.
    initial_angle, initial_angular_velocity, initial_offset, tolerance, contact, rest_speed
        As for `latolato.simulate`; by default the system hangs at rest.

    Returns
    -------
    xarray.Dataset
        ``best_first_ratio``, ``best_dwell_time``, ``lead_time`` and ``checked_share`` of the
        shortest protocol, ``smallest_push`` and ``smallest_push_energy``, ``angle_from_rest``,
        ``upper_angle`` and ``threshold_angle``; ``success_share`` over
        ``first_frequency_ratio`` and ``dwell_time``, ``push_share`` and ``angle_after_push`` over
        ``push``. The status is "found", "reached from rest" (no protocol is needed: a lead time of
        0), "no upper branch" (no push leads to a larger motion, and nothing was searched) or "not
        reached"; what does not exist is NaN.

    Raises
    ------
    InputError
        For a parameter outside its range, a linear system, or a drive without frequencies.

    Notes
    -----
    All dwells of a first stage begin as one run, whose states go on with the target frequency.
    Candidates are taken by lead time, then by share, and run in full as a `Protocol`, ten at most;
    the first that keeps the required share there is the answer. The first hops after lift-off are
    chaotic, so success is a striped set in frequency, dwell and phase, and so are the pushes that
    succeed: a finer grid can find shorter ones, and a longer dwell or a harder push may fail.
    ``settling`` must outlast transients. A push acts on balls at rest at time zero. The upper
    branch is the median of what pushes lead to; a branch that no push of the list reaches is not
    seen.

    Examples
    --------
    >>> import latolato as ll, numpy as np
    >>> toy = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.0196, restitution=0.9)
    >>> drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.389 * toy.natural_frequency)
    >>> result = shortest_protocol(
    ...     toy, drive, first_frequency_ratio=[3.6], dwell_time=[1.0, 2.0, 4.0], phases=4
    ... )
    >>> result.status.item(), f"{np.rad2deg(result.upper_angle.item()):.0f} degrees"
    ('found', '42 degrees')
    """
    w0 = system.natural_frequency
    amplitude, target = _drive_of(system, drive, frequency_ratio)
    low, high, count = _DEFAULT_FIRST
    usual = np.linspace(low * target / w0, high * target / w0, count)
    first = increasing("first_frequency_ratio", first_frequency_ratio, usual)
    dwells = increasing("dwell_time", dwell_time, np.linspace(*_DEFAULT_DWELLS))
    largest, count = _DEFAULT_PUSHES
    pushes = increasing("push", push, np.linspace(0.0, largest * w0, count)[1:])
    search = _Search(
        system,
        amplitude,
        target,
        ramp,
        np.linspace(0.0, math.tau, phases, endpoint=False),
        settling,
        start_options(system, initial_angle, initial_angular_velocity, initial_offset),
        {"tolerance": tolerance, "contact": contact, "rest_speed": rest_speed},
    )
    pushed = _pushed(search, [0.0, *pushes])
    rest = float(np.median(pushed[0]))
    above = pushed[pushed > rest + _LEAST_GAP]
    upper = float(np.median(above)) if above.size else math.nan
    threshold = 0.5 * (rest + upper) if threshold_angle is None else threshold_angle
    shares = np.mean(pushed > threshold, axis=1)
    if math.isnan(threshold):
        shares = np.full(len(pushed), math.nan)
    success = np.full((len(first), len(dwells)), math.nan)
    result: dict[str, Any] = dict.fromkeys(
        ("best_first_ratio", "best_dwell_time", "lead_time", "checked_share"), math.nan
    )
    if shares[0] >= required_share:
        result |= {"status": BY_ITSELF, "lead_time": 0.0, "checked_share": float(shares[0])}
    elif not math.isfinite(threshold):
        result["status"] = NO_BRANCH
    else:
        success = np.array([_stepped(search, ratio, dwells, threshold) for ratio in first])
        result |= _shortest(search, first, dwells, success, threshold, required_share)
    if result["status"] == NO_BRANCH:
        warn("no_push_helps", push=float(pushes[-1]))
    elif result["status"] == NOT_REACHED:
        warn("no_protocol", percent=100.0 * required_share)
    enough = [
        speed for speed, share in zip(pushes, shares[1:], strict=True) if share >= required_share
    ]
    smallest = enough[0] if enough else math.nan
    inertia = sum(ball.mass * ball.length**2 for ball in system.balls)
    if system.angles == 1 and system.has_contacts:
        inertia *= 2.0  # the mirror image is pushed too
    return labelled(
        {
            **result,
            "success_share": (("first_frequency_ratio", "dwell_time"), success),
            "push_share": ("push", shares),
            "angle_after_push": ("push", np.median(pushed, axis=1)),
            "smallest_push": smallest,
            "smallest_push_energy": 0.5 * inertia * smallest**2,
            "angle_from_rest": rest,
            "upper_angle": upper,
            "threshold_angle": threshold,
        },
        system=system,
        drive=drive,
        coordinates={
            "first_frequency_ratio": first,
            "dwell_time": dwells,
            "push": [0.0, *pushes],
        },
        quantities=_QUANTITIES,
        settings={**search.start, "frequency_ratio": target / system.natural_frequency},
    )


def last_cosine(drive: Drive) -> Segment | None:
    """Return the last segment of a drive's motion if that is a cosine."""
    last = drive.segments(math.inf)[-1]
    return last if getattr(last, "form", None) == COSINE else None


def _drive_of(
    system: System, drive: Drive | None, frequency_ratio: float | None
) -> tuple[float, float]:
    """Return amplitude [m] and target frequency [rad/s]."""
    last = last_stage(drive)
    amplitude, target = last.c0, last.frequency
    if frequency_ratio is not None:
        target = frequency_ratio * system.natural_frequency
    return amplitude, checked_number("drive_frequency", target, POSITIVE, "rad/s")


def _settle(search: _Search, drive: Drive, cases: dict[str, Floats], **start: Any) -> Floats:
    """Return the settled angle of each case, NaN where there is no answer."""
    names = list(cases)
    # Balls that still rest are in equal states: each is run once.
    table, back = np.unique(np.column_stack(list(cases.values())), axis=0, return_inverse=True)
    wait = search.settling + drive.segments(math.inf)[-1].start
    grid = sweep(
        search.system,
        drive,
        axes={"case": {name: table[:, i] for i, name in enumerate(names)}},
        duration=wait,
        transient=wait - _READ * search.settling,
        observables=[_LASTING],
        **search.options,
        **start,
    )
    angles = grid[_LASTING]
    if "ball" in angles.dims:
        angles = angles.isel(ball=0)
    return np.asarray(angles.values[back.ravel()], dtype=np.float64)


def _pushed(search: _Search, pushes: Sequence[float]) -> Floats:
    """Return settled angles at the target frequency after pushes, of shape (push, phase)."""
    push, phase = (each.ravel() for each in np.meshgrid(pushes, search.phases, indexing="ij"))
    start = dict(search.start)
    name = "initial_angular_velocity"
    velocities = checked_numbers(name, start.pop(name), search.system.angles)
    sides = ("",) if search.system.angles == 1 else ("_right", "_left")
    columns = {
        f"{name}{side}": velocity + way * push
        for side, velocity, way in zip(sides, velocities, (1.0, -1.0), strict=False)
    }
    drive = Harmonic(drive_amplitude=search.amplitude, drive_frequency=search.target)
    settled = _settle(search, drive, {**columns, "drive_phase": phase}, **start)
    return settled.reshape(len(pushes), len(search.phases))


def _stepped(search: _Search, ratio: float, dwells: Floats, threshold: float) -> Floats:
    """Return the share of phases at which a first stage succeeds, for each dwell."""
    frequency = ratio * search.system.natural_frequency
    angles, velocities = [], []
    for phase in search.phases:
        drive = Harmonic(
            drive_amplitude=search.amplitude, drive_frequency=frequency, drive_phase=float(phase)
        )
        run = simulate(search.system, drive, times=dwells, **search.options, **search.start)
        angles.append(np.atleast_2d(run.angle.values))
        velocities.append(np.atleast_2d(run.angular_velocity.values))
    columns = start_columns(
        search.system, np.concatenate(angles, axis=1), np.concatenate(velocities, axis=1)
    )
    turned = search.phases[:, None] + frequency * dwells
    columns["drive_phase"] = turned.ravel()
    second: Drive = Harmonic(drive_amplitude=search.amplitude, drive_frequency=search.target)
    if search.ramp > 0.0:
        second = Chirp(
            drive_amplitude=search.amplitude,
            drive_frequency=frequency,
            drive_frequency_final=search.target,
            sweep_time=search.ramp,
        )
    lasting = _settle(search, second, columns).reshape(len(search.phases), len(dwells))
    return np.asarray(np.mean(lasting > threshold, axis=0), dtype=np.float64)


def _shortest(
    search: _Search,
    first: Floats,
    dwells: Floats,
    success: Floats,
    threshold: float,
    required: float,
) -> dict[str, Any]:
    """Return the shortest protocol that keeps its share in complete runs."""
    candidates = [
        (dwells[j], -success[i, j], first[i])
        for i, j in zip(*np.nonzero(success >= required), strict=True)
    ]
    for dwell, _, ratio in sorted(candidates)[:_MOST_CHECKS]:
        steps = Protocol(
            drive_frequencies=[ratio * search.system.natural_frequency, search.target],
            dwells=[dwell],
            ramp=search.ramp,
        )
        share = _share(search, steps, threshold)
        if share >= required:
            return {
                "status": FOUND,
                "best_first_ratio": ratio,
                "best_dwell_time": dwell,
                "lead_time": steps.lead_time,
                "checked_share": share,
            }
    return {"status": NOT_REACHED}


def _share(search: _Search, steps: Protocol, threshold: float) -> float:
    """Return the share of drive phases at which a protocol succeeds in complete runs."""
    end = steps.lead_time + search.settling
    reaches = []
    for phase in search.phases:
        grid = sweep(
            search.system,
            steps.drive(search.amplitude, float(phase)),
            axes={"drive_amplitude": [search.amplitude]},
            duration=end,
            transient=end - _READ * search.settling,
            observables=[_LASTING],
            **search.options,
            **search.start,
        )
        reaches.append(float(grid[_LASTING].values.ravel()[0]) > threshold)
    return float(np.mean(reaches))
