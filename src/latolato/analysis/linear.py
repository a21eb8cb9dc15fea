"""The pendulum linearised about hanging or standing, under any periodic drive: what is analysed.

Over the drive's phase p = w t it is ``x'' + c x' + s (r^-2 + y''/l) x = 0`` with the frequency
ratio r = w/w0, ``c = 2 zeta/r``, y'' the pivot's acceleration at w = 1, and s = 1 (hanging) or -1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.checks import check_drag, checked_vertical
from latolato.analysis.roots import find_peak, find_root, first_rise
from latolato.analysis.rules import broken_analysis
from latolato.analysis.waveform import (
    Complexes,
    band_edges,
    enough_harmonics,
    fourier_coefficients,
    hill_value,
    undamped_growth,
)
from latolato.core.quantities import Range
from latolato.core.registry import describe
from latolato.core.rules import broken_rule
from latolato.physics.drives import Drive, Harmonic, PeriodicDrive, drives
from latolato.physics.pendulum import BallPair, LatoLato, System
from latolato.simulation.start import checked_system

# What an analysis varies of a drive.
_SOUGHT = ("drive_amplitude", "drive_frequency")
# A slower drive would need too many harmonics.
SLOWEST = 0.01
RATIOS = Range(low=SLOWEST)
# A crank closer to its connecting rod than this has too many overtones.
LARGEST_CRANK = 0.95
# Phases at which an acceleration is sampled before its peak is followed.
_PHASES = 360
# A stiffness this close to a tongue's tip lies on it.
_ON_TIP = 1e-14


@dataclass(frozen=True)
class Linear:
    """A linearised pendulum and the waveform of its drive."""

    length: float
    mass: float
    gravity: float
    damping: float
    side: float
    template: PeriodicDrive
    is_string: bool

    @property
    def natural_frequency(self) -> float:
        """w0 [rad/s]."""
        return math.sqrt(self.gravity / self.length)

    @property
    def damping_ratio(self) -> float:
        """C/(2 m l w0) [1]."""
        return self.damping / (2.0 * self.mass * self.length * self.natural_frequency)

    @property
    def largest_amplitude(self) -> float:
        """The largest drive amplitude [m] that the drive and this analysis allow."""
        return LARGEST_CRANK * self.template.largest_amplitude

    def slackens(self, drive_frequency: float, amplitude: float) -> bool:
        """Return whether the string of a ball that hangs still goes slack: where ``g + y'' < 0``.

        A string that does not is a rod.
        """
        if not (self.is_string and math.isfinite(drive_frequency)):
            return False
        return drive_frequency**2 * peak(self.template, amplitude) > self.gravity

    def waveform(self, amplitude: float) -> Callable[[float], float]:
        """Return ``s y''/l`` at w = 1 as a function of the phase."""
        acceleration = acceleration_at(self.template, amplitude)
        factor = self.side / self.length
        return lambda phase: factor * acceleration(phase)

    @lru_cache(maxsize=256)  # noqa: B019 - problems are small, and this bounds their number
    def coefficients(self, amplitude: float) -> Complexes:
        """Return the Fourier coefficients of `waveform`."""
        if self.template.is_cosine:  # they are proportional to the amplitude
            return np.asarray(amplitude / self.length * self._cosine)
        return fourier_coefficients(self.waveform(amplitude))

    @cached_property
    def _cosine(self) -> Complexes:
        """Fourier coefficients of a cosine as large as the length."""
        return fourier_coefficients(self.waveform(self.length))

    @lru_cache(maxsize=256)  # noqa: B019
    def harmonics(self, amplitude: float, is_odd: bool, count: int) -> int:
        """Return how many harmonics give the lowest `count` edges of bands."""
        return enough_harmonics(self.coefficients(amplitude), is_odd, count)

    def bands(self, amplitude: float, is_odd: bool, count: int) -> NDArray[np.float64]:
        """Return the lowest edges of bands of the equation without drag, shape (count,)."""
        harmonics = self.harmonics(amplitude, is_odd, count)
        return band_edges(self.coefficients(amplitude), is_odd, harmonics, count)

    def excess(self, slowness: float, amplitude: float, is_odd: bool, harmonics: int) -> float:
        """Return minus Hill's determinant at 1/r: positive where the motion grows."""
        a, c = self.side * slowness**2, 2.0 * self.damping_ratio * slowness
        return -hill_value(a, c, self.coefficients(amplitude), is_odd, harmonics)

    def monodromy(self, slowness: float, amplitude: float) -> NDArray[np.float64]:
        """Return the map of (x, dx/dp) over one drive period at 1/r, by quadrature.

        An eighth-order Runge-Kutta method (SciPy's DOP853) with a relative error of 1e-13 a step.
        """
        from scipy.integrate import solve_ivp

        force = self.waveform(amplitude)
        a, c = self.side * slowness**2, 2.0 * self.damping_ratio * slowness

        def motion(phase: float, y: Any) -> tuple[float, float, float, float]:
            weight = a + force(phase)
            return y[1], -weight * y[0] - c * y[1], y[3], -weight * y[2] - c * y[3]

        options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15}
        run = solve_ivp(motion, (0.0, math.tau), (1.0, 0.0, 0.0, 1.0), **options)
        return np.asarray(run.y[:, -1].reshape(2, 2).T)

    def monodromy_excess(self, slowness: float, amplitude: float, is_odd: bool) -> float:
        """Return ``s trace - 1 - det`` of the monodromy: positive where the motion grows."""
        trace = float(np.trace(self.monodromy(slowness, amplitude)))
        loss = math.exp(-2.0 * math.tau * self.damping_ratio * slowness)
        return (-trace if is_odd else trace) - 1.0 - loss

    def growth(self, drive_frequency: float, amplitude: float, method: str) -> float:
        """Return the largest real part of the Floquet exponents [1/s]."""
        w, w0, zeta = drive_frequency, self.natural_frequency, self.damping_ratio
        slowness = w0 / w
        if method == "monodromy":
            trace = float(np.trace(self.monodromy(slowness, amplitude)))
            half = 0.5 * abs(trace) * math.exp(math.tau * zeta * slowness)
            rate = math.acosh(max(half, 1.0)) / math.tau
        else:
            a = (self.side - zeta**2) * slowness**2
            count = 2 + math.ceil(2.0 * math.sqrt(abs(a)))
            rate = max(
                undamped_growth(
                    a,
                    self.coefficients(amplitude),
                    is_odd,
                    self.harmonics(amplitude, is_odd, count),
                )
                for is_odd in (False, True)
            )
        return w * rate - zeta * w0


def acceleration_at(template: PeriodicDrive, amplitude: float) -> Callable[[float], float]:
    """Return y'' [m] of a drive with this amplitude and w = 1, as a function of the phase [rad].

    The phase at time zero is left out: nothing here depends on it.
    """
    drive = replace(template, drive_amplitude=amplitude, drive_frequency=1.0, drive_phase=0.0)
    (segment,) = drive.segments(math.tau)
    formula = type(drive).acceleration
    return lambda phase: formula(phase, segment)


def peak(template: PeriodicDrive, amplitude: float) -> float:
    """Return the largest -y'' [m] at w = 1."""
    if amplitude == 0.0:
        return 0.0
    acceleration = acceleration_at(template, amplitude)
    return -acceleration(phase_of_peak(template, amplitude))


def phase_of_peak(template: PeriodicDrive, amplitude: float) -> float:
    """Return the phase [rad] of the largest -y''."""
    acceleration = acceleration_at(template, amplitude)
    phases = [math.tau * i / _PHASES for i in range(_PHASES)]
    best = min(phases, key=acceleration)
    step = math.tau / _PHASES
    near = find_peak(lambda phase: -acceleration(phase), best - step, best + step)
    return min((best, near), key=acceleration)


def waveform_of(template: PeriodicDrive) -> dict[str, Any]:
    """Return the attributes of a drive without its amplitude and frequency."""
    about = {k: v for k, v in describe(template).items() if k not in _SOUGHT}
    return {"drive": drives.name_of(template), **about}


def checked_template(drive: Drive | None) -> PeriodicDrive:
    """Return the drive whose waveform is meant; a `Harmonic` one for None.

    Raises
    ------
    InputError
        Unless it is a periodic drive.
    """
    if drive is None:
        return Harmonic(drive_amplitude=0.0, drive_frequency=1.0)
    return checked_vertical(drive)


def check_linear(system: System, position: str = "hanging") -> None:
    """Raise InputError where a system has no linear stability.

    That is a wall or friction at the position, a string that would have to push, or drag relative
    to the room.
    """
    checked_system(system)
    check_drag(system)
    if position == "inverted" and system.suspension == "string":
        raise broken_analysis("upright_rod", parameter="suspension", value=system.suspension)
    if position == "inverted" and system.is_linear:
        raise broken_analysis("inverted_mathieu")
    for ball in system.balls:
        if ball.coulomb_damping > 0.0:
            raise broken_analysis(
                "linear_friction", parameter="coulomb_damping", value=ball.coulomb_damping
            )
    if isinstance(system, (LatoLato, BallPair)):
        _check_no_wall(system, position)


def linearised(system: System, drive: Drive | None, position: str = "hanging") -> Linear:
    """Return the linearised system, one that `check_linear` allows."""
    ball = system.balls[0]
    return Linear(
        length=ball.length,
        mass=ball.mass,
        gravity=system.gravity,
        damping=ball.damping,
        side=1.0 if position == "hanging" else -1.0,
        template=checked_template(drive),
        is_string=system.suspension == "string",
    )


def _check_no_wall(system: LatoLato | BallPair, position: str) -> None:
    """Refuse balls that are kept from the position, or lose energy at every passage of it."""
    if any(each.radius > 0.0 for each in system.balls):
        rule = "hanging_points" if position == "hanging" else "upright_points"
        radius = max(each.radius for each in system.balls)
        raise broken_analysis(rule, parameter="radius", value=radius)
    if system.restitution < 1.0:
        raise broken_analysis("lossless_balls", parameter="restitution", value=system.restitution)
    if len({each.damping / each.mass for each in system.balls}) > 1:
        raise broken_analysis("one_drag_rate")


def check_oscillates(problem: Linear) -> None:
    """Refuse a pendulum that is damped so strongly that it does not oscillate."""
    if problem.damping_ratio >= 1.0:
        values = {"damping": problem.damping, "ratio": problem.damping_ratio}
        raise broken_rule("tongue", values, parameter="damping")


def tongue(problem: Linear, amplitude: float, order: int, method: str) -> tuple[float, float]:
    """Return the frequency ratios between which tongue `order` is unstable; NaN where closed.

    Drag is first removed by ``x = exp(-c p/2) z``; within the undamped tongue of z the growth has
    one hump, and the edges are where it equals the drag.
    """
    is_odd, zeta = order % 2 == 1, problem.damping_ratio
    bands = problem.bands(amplitude, is_odd, order + 1)
    harmonics = problem.harmonics(amplitude, is_odd, order + 1)
    below = float(bands[order - 1]) if order else -math.inf
    above = float(bands[order])
    # z has a = stiffness/r^2
    stiffness = problem.side - zeta**2
    ends = sorted((below / stiffness, above / stiffness))
    if ends[1] <= 0.0:
        return math.nan, math.nan
    low, high = math.sqrt(max(ends[0], 0.0)), math.sqrt(ends[1])
    has_high = ends[0] > 0.0

    def excess(slowness: float) -> float:
        if method == "monodromy":
            return problem.monodromy_excess(slowness, amplitude, is_odd)
        return problem.excess(slowness, amplitude, is_odd, harmonics)

    def ratio(slowness: float) -> float:
        return 1.0 / slowness if slowness > 0.0 else math.inf

    if order == 0:  # falls over for every slower drive
        return 0.0, ratio(_edge_above(excess, low)) if zeta or method == "monodromy" else ratio(low)
    if zeta == 0.0 and method == "determinant":
        return ratio(high), ratio(low)
    peak = find_peak(excess, low, high)
    if excess(peak) <= 0.0:
        return math.nan, math.nan
    # Rounding may put an undamped edge on either side of its band's end.
    low_end, high_end = (_outside(excess, end, peak) for end in (low, high))
    fast = ratio(find_root(excess, low_end, peak)) if has_high else math.inf
    return ratio(find_root(excess, peak, high_end)), fast


def _outside(excess: Callable[[float], float], end: float, peak: float) -> float:
    """Return a point at or a little beyond an end at which there is no growth."""
    step = 1e-3 * (end - peak)
    place = end
    while excess(place) > 0.0 and place > 0.0:
        place = max(place + step, 0.0)
        step *= 2.0
    return place


def _edge_above(excess: Callable[[float], float], guess: float) -> float:
    """Return the zero near a guess of a function that is negative below and positive above it."""
    low = high = guess
    while excess(low) >= 0.0:
        low *= 0.99
    while excess(high) <= 0.0:
        high *= 1.01
    return find_root(excess, low, high)


def threshold(problem: Linear, ratio: float, largest: float, order: int | None) -> float:
    """Return the smallest amplitude [m] at which tongue `order` (None: any) grows; NaN if none.

    Tongues without drag are followed by their edges on a grid of 0.01 l, then searched for growth
    that beats the drag.
    """
    slowness, zeta = 1.0 / ratio, problem.damping_ratio
    a = (problem.side - zeta**2) * slowness**2
    orders = [order] if order else list(range(1, 4 + math.ceil(2.0 * math.sqrt(max(a, 0.0)))))

    def gaps(amplitude: float) -> dict[int, float]:
        """Return how far a lies outside of each tongue; negative inside."""
        result: dict[int, float] = {}
        for is_odd in {n % 2 == 1 for n in orders}:
            own = [n for n in orders if (n % 2 == 1) == is_odd]
            bands = problem.bands(amplitude, is_odd, max(own) + 1)
            result |= {n: float(max(bands[n - 1] - a, a - bands[n])) for n in own}
        return result

    grid = np.linspace(0.0, largest, 1 + math.ceil(100.0 * largest / problem.length))
    now = gaps(0.0)
    tips = [n for n, gap in now.items() if abs(gap) < _ON_TIP * max(1.0, a)]
    for left, right in pairwise([0.0, 0.1 * float(grid[1]), *map(float, grid[1:])]):
        before, now = now, gaps(right)
        if left == 0.0:  # on a tip only rounding is left: does its tongue open there?
            before |= {n: 0.0 if now[n] < 0.0 else 1.0 for n in tips}
        candidates = []
        for n in orders:
            if before[n] > 0.0 and now[n] > 0.0:
                continue

            def gap(amplitude: float, n: int = n) -> float:
                return gaps(amplitude)[n]

            def excess(
                amplitude: float, is_odd: bool = n % 2 == 1, count: int = n + 1, most: float = right
            ) -> float:
                harmonics = problem.harmonics(most, is_odd, count)
                return problem.excess(slowness, amplitude, is_odd, harmonics)

            low = left if before[n] <= 0.0 else find_root(gap, left, right)
            high = right if now[n] <= 0.0 else find_root(gap, left, right)
            candidates.append(low if zeta == 0.0 else first_rise(excess, low, high))
        result = [value for value in candidates if not math.isnan(value)]
        if result:
            return min(result)
    return math.nan
