"""The smallest drive that starts two balls from rest against each other."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from latolato.analysis.checks import check_drag, hits_pull
from latolato.analysis.linear import RATIOS, checked_template, peak, phase_of_peak, waveform_of
from latolato.analysis.registry import analyses, labelled, warn
from latolato.analysis.roots import find_root
from latolato.analysis.rules import broken_analysis
from latolato.analysis.starts import hanging_angles
from latolato.core.errors import Word
from latolato.core.quantities import Quantity
from latolato.physics.drives import Drive, PeriodicDrive
from latolato.physics.pendulum import System
from latolato.simulation.run import simulate
from latolato.simulation.start import checked_system

if TYPE_CHECKING:
    import xarray as xr

# A crank closer to its connecting rod than this is taken for one that jams.
LARGEST_CRANK = 0.999
# Bisection ends when this share of the amplitude is left.
_BISECTION = 1e-11
# The simulated threshold is searched for within this factor of the computed one.
_SPREAD = 1.2
# Contacts after which a run is known to have left rest, or not.
_CONTACTS = 100


def resting_angles(system: System) -> tuple[float, ...]:
    """Return the angles of the balls at rest against each other [rad].

    Raises
    ------
    InputError
        For balls that cannot touch or that nothing lifts, drag in the room, and strings of which
        one would have to push.
    """
    check_drag(checked_system(system))
    angles = hanging_angles(system)
    if not system.has_contacts:
        raise broken_analysis("wall_to_start", {"law": Word(type(system).__name__)})
    if angles[0] == 0.0:
        raise broken_analysis("lifting_radius")
    if system.suspension == "string" and not hits_pull(system):
        raise broken_analysis("alike_lengths", parameter="suspension", value=system.suspension)
    return angles


@analyses.register("self_start", resting_angles, checked_template)
def self_start(
    system: System,
    frequency_ratio: Annotated[float, RATIOS],
    drive: Drive | None = None,
    *,
    check: bool = False,
) -> xr.Dataset:
    """Return the smallest drive amplitude A0 [m] that lifts balls at rest on each other.

    From the contact force of paper eq10 on the wall: it would have to pull.

    Parameters
    ----------
    system : LatoLato or BallPair
        At rest in bottom contact; a `BallPair` where the two balls balance.
    frequency_ratio : float
        Driving over natural frequency, w/w0 [1], at least 0.01; of the right ball for a `BallPair`.
    drive : PeriodicDrive, optional
        Supplies the waveform; by default a cosine. Its amplitude and frequency are not used.
    check : bool
        Also bisect with simulated runs of one drive period.

    Returns
    -------
    xarray.Dataset
        ``drive_amplitude`` [m], ``drive_acceleration_ratio`` A0 w^2/g [1] there, and ``status``:
        "found" or "out of reach" (NaN: the crank would jam first). With `check` also
        ``simulated_amplitude`` [m], the smallest at which a run leaves rest.

    Raises
    ------
    InputError
        For a system without walls, for balls without a radius, which rest where nothing can lift
        them, and for drag relative to the room.

    Notes
    -----
    The free torque ``-m l (g + y'') sin(angle)`` must turn and beat the Coulomb friction C0 l:
    ``max(-y'') = g + C0/(m sin(angle))``, that is ``A0 w^2 = g`` for a cosine without friction and
    ``A0 w^2 (1 + A0/L) = g`` for a crank with its guide above. With its guide below, the largest
    ``-y''`` is ``A0 w^2 (1 - A0/L)`` up to about ``A0 = L/4`` and lies to either side of the
    turning point beyond; it is followed to the last digits.

    Of a `BallPair` the contact force is proportional to ``I1 tau2 - I2 tau1`` (tau: free torques).
    At the joint equilibrium ``m1 l1 sin(angle_1) = -m2 l2 sin(angle_2)`` it is proportional to
    g + y'', so the condition is the same for unequal balls; with friction the ball of the smaller
    C0 l leaves first; while friction holds both, runs follow a dip of the hold within a step only
    roughly, so that `check` finds up to 1e-5 more there. Two balls that swing together part earlier
    or later.

    On strings tension and contact force vanish together, so the condition is the same, without
    friction, which does not hold a ball on a slack string. The motion after it is not: the balls
    fly up side by side, and the strings throw them together.

    This is where rest ends; a large motion need not follow. For one the paper's toy needs 4 %
    (e = 1) to 90 % (e = 0.5) more.

    Examples
    --------
    >>> import latolato as ll
    >>> toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
    >>> print(f"{ll.analysis.self_start(toy, 2.0).drive_amplitude:.6f}")
    0.250000
    >>> crank = ll.CrankSlider(drive_amplitude=0.1, drive_frequency=1, connecting_rod_length=1.0)
    >>> print(f"{ll.analysis.self_start(toy, 3.0, crank).drive_amplitude:.6f}")
    0.127322
    """
    angles = resting_angles(system)
    template = checked_template(drive)
    w = frequency_ratio * system.natural_frequency
    needed = (system.gravity + holding_friction(system, angles)) / w**2
    amplitude = _amplitude(template, needed)
    status = "found"
    if math.isnan(amplitude):
        status = "out of reach"
        warn("never_lifted", share=LARGEST_CRANK, ratio=frequency_ratio)
    variables: dict[str, Any] = {
        "drive_amplitude": amplitude,
        "drive_acceleration_ratio": amplitude * w**2 / system.gravity,
        "status": status,
    }
    if check:
        variables["simulated_amplitude"] = _simulated(system, template, w, angles, amplitude)
    return labelled(
        variables,
        system=system,
        quantities={
            "simulated_amplitude": Quantity("m", "A_0", "driving amplitude that lifts in a run"),
        },
        settings=waveform_of(template),
    )


def holding_friction(system: System, angles: tuple[float, ...]) -> float:
    """Return the upward acceleration that the Coulomb friction adds to gravity [m/s^2].

    A string goes slack first, and friction at the hinge does not hold a ball on a slack string.
    """
    if system.suspension == "string":
        return 0.0
    ball = system.balls[0]
    moment = ball.mass * ball.length * math.sin(angles[0])  # the left one's is the same
    return min(each.coulomb_damping * each.length for each in system.balls) / moment


def _amplitude(template: PeriodicDrive, needed: float) -> float:
    """Return the smallest amplitude [m] whose largest -y''/w^2 is `needed` [m]; NaN if none."""
    if template.is_cosine:
        return needed
    # No waveform of this amplitude can be much weaker than the cosine.
    left, last = 0.0, min(LARGEST_CRANK * template.largest_amplitude, 10.0 * needed)
    for right in np.linspace(0.0, last, 50)[1:]:
        if peak(template, float(right)) >= needed:
            return find_root(lambda a: peak(template, a) - needed, left, float(right))
        left = float(right)
    return math.nan


def _simulated(
    system: System, template: PeriodicDrive, w: float, angles: tuple[float, ...], computed: float
) -> float:
    """Return the smallest amplitude [m] at which a run of one period leaves rest; NaN if none."""
    if math.isnan(computed):
        return math.nan

    def lifts(amplitude: float) -> bool:
        drive = replace(
            template,
            drive_amplitude=amplitude,
            drive_frequency=w,
            # begins half a period before the turn, where the pivot presses the balls together
            drive_phase=phase_of_peak(template, amplitude) + math.pi,
        )
        start = angles if len(angles) > 1 else angles[0]
        with warnings.catch_warnings():  # that it stops: tiny elastic hops may go on without end
            warnings.simplefilter("ignore", RuntimeWarning)
            run = simulate(
                system, drive, initial_angle=start, duration=math.tau / w, times=[0.0],
                contact_limit=_CONTACTS,
            )  # fmt: skip
        # A hop too small for the angle's digits is counted as grazing.
        leaves = bool(run.contact_kind.isin(["release", "slack"]).any())
        return leaves or run.attrs["grazing_contacts"] > 0

    limit = 0.5 * (computed + template.largest_amplitude)
    low, high = computed / _SPREAD, min(computed * _SPREAD, limit)
    if lifts(low) or not lifts(high):
        return math.nan
    while high - low > _BISECTION * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if lifts(middle) else (middle, high)
    return 0.5 * (low + high)
