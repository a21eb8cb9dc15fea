"""Subharmonic response, the part of a discrete time crystal that one toy can show."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.checks import checked_vertical
from latolato.analysis.registry import analyses, labelled
from latolato.analysis.rules import broken_analysis
from latolato.analysis.starts import start_options
from latolato.core.quantities import COUNT, NON_NEGATIVE, POSITIVE, Quantity, Range
from latolato.observables import PoincareSection
from latolato.physics.drives import Drive
from latolato.physics.noise import STREAMS, VelocityKicks
from latolato.physics.pendulum import System
from latolato.simulation.start import DEFAULT_REST_SPEED, checked_system
from latolato.sweeps import sweep
from latolato.sweeps.statuses import has_answer

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

CAUTION = (
    "One toy is not a time crystal: period doubling of a single driven system is an ordinary "
    "subharmonic response. Rigidity (locking to half the drive against changes of every unit, kept "
    "by the coupling of many) and a lifetime that grows with the number of units are properties of "
    "a many-body phase, which no quantity here can show."
)

# Below this the motion or its part at half the frequency is none [rad].
LEAST_AMPLITUDE = 1e-3
# The peak is searched for between these frequencies [drive frequencies].
WINDOW = (0.25, 0.75)
# Share of the oscillating power that a sharp peak holds at least.
SHARP = 0.5
# and how often the width of a steady tone it has at most.
WIDEST = 2.0
# Full width at half maximum of the squared spectrum of a steady tone under a Hann window [bins].
_HANN_WIDTH = 1.44
_PADDING = 8
# Bins of the main lobe of a Hann window, to each side.
_LOBE = 2

NO_MOTION, NO_SUBHARMONIC, NO_ANSWER = "no motion", "no subharmonic", "no answer"
LOCKED, DRIFTING, BROAD = "locked", "drifting", "broad"

_QUANTITIES = {
    "order_parameter": Quantity(
        "rad", "Z", "mean angle once per drive period, with alternating sign"
    ),
    "order_parameter_size": Quantity("rad", "|Z|", "mean of its size over trajectories"),
    "order_parameter_best": Quantity(
        "rad", r"Z_{max}", "order parameter at the best stroboscopic phase"
    ),
    "peak_frequency": Quantity("1", r"\omega_p/\omega", "subharmonic peak over drive frequency"),
    "peak_amplitude": Quantity("rad", "A_p", "amplitude of the subharmonic peak"),
    "peak_width": Quantity("1", r"\Delta\omega_p/\omega", "full width at half maximum of the peak"),
    "peak_share": Quantity("1", "p", "share of the oscillating power in the peak"),
    "phase_slips": Quantity("1", "N_s", "changes between the two phases of the answer"),
    "lifetime": Quantity("s", r"\tau_s", "mean time between phase slips"),
    "lifetime_low": Quantity("s", r"\tau_{s-}", "lower end of its 95 % interval"),
    "lifetime_high": Quantity("s", r"\tau_{s+}", "upper end of its 95 % interval"),
    "sign_autocorrelation": Quantity("1", "C", "autocorrelation of the phase of the answer"),
    "order_parameter_decay": Quantity(
        "rad", r"\langle s_0 Z_n\rangle", "order parameter since the first period looked at"
    ),
    "lag": Quantity("1", "m", "lag in drive periods"),
    "period": Quantity("1", "n", "number of the drive period, from time zero"),
    "drive_period": Quantity("s", "T", "drive period"),
    "status": Quantity("1", "", "kind of answer at half the driving frequency"),
}


class Peak(NamedTuple):
    """The strongest line near half the driving frequency; frequencies over that of the drive."""

    frequency: float
    amplitude: float
    width: float
    share: float


def subharmonic_peak(angles: Floats, velocities: Floats, drive_frequency: float) -> Peak:
    """Return the spectral peak near half the driving frequency, in drive frequencies and rad.

    Parameters
    ----------
    angles, velocities : ndarray, shape (trajectory, period)
        Stroboscopic angles [rad] and angular velocities [rad/s], once per drive period.
    drive_frequency : float
        w [rad/s].

    Returns
    -------
    Peak
        ``frequency`` and ``width`` in drive frequencies; NaN where there is no oscillation.

    Notes
    -----
    The spectrum of ``angle - i velocity/(w/2)``, means removed, under a Hann window, eight times
    padded, its square averaged over trajectories. One sample per period of a real signal does not
    distinguish w/2 + d from w/2 - d; the velocity does. The place is that of the parabola through
    the highest three points, the width that at half of it, 1.44/periods for a steady tone.
    ``share`` counts two bins to each side of the peak against all but the mean and its two bins.
    """
    signal = angles - 1j * velocities / (0.5 * drive_frequency)
    signal = signal - signal.mean(axis=1, keepdims=True)
    count = signal.shape[1]
    window = np.hanning(count + 1)[:-1]
    size = _PADDING * count
    spectrum = np.fft.fft(signal * window, size, axis=1) / window.sum()
    power = np.mean(np.abs(spectrum) ** 2, axis=0)
    frequency = np.arange(size) / size
    inside = np.flatnonzero((frequency >= WINDOW[0]) & (frequency <= WINDOW[1]))
    top = int(inside[np.argmax(power[inside])])
    left, middle, right = power[top - 1], power[top], power[top + 1]
    if not middle > 0.0:
        return Peak(math.nan, 0.0, math.nan, math.nan)
    bend = left - 2.0 * middle + right
    shift = 0.5 * (left - right) / bend if bend < 0.0 else 0.0
    highest = middle - 0.25 * (left - right) * shift
    width = sum(_to_half(power, top, way, 0.5 * highest) for way in (-1, 1)) / size
    reach = _LOBE * _PADDING
    offset = np.minimum(np.arange(size), size - np.arange(size))
    near = np.abs(np.arange(size) - top) <= reach
    share = power[near].sum() / power[(offset > reach) | near].sum()
    return Peak((top + shift) / size, math.sqrt(highest), width, float(share))


def _to_half(power: Floats, top: int, way: int, level: float) -> float:
    """Return how many points from the top the power first falls to a level, on lines between."""
    place, size = top, len(power)
    for _ in range(size // 2):
        ahead = power[(place + way) % size]
        if ahead <= level:
            here = power[place % size]
            return abs(place - top) + float((here - level) / (here - ahead))
        place += way
    return size / 2.0


def sign_states(demodulated: Floats) -> NDArray[np.int8]:
    """Return which of the two phases a motion is in, +1 or -1, of the input's shape.

    A trigger with hysteresis: the state changes where the signal reaches half its r.m.s. value on
    the other side, so that small wiggles about zero are no phase slips.
    """
    level = 0.5 * math.sqrt(float(np.mean(demodulated**2)))
    states = np.where(demodulated >= level, 1, np.where(demodulated <= -level, -1, 0))
    states = states.astype(np.int8)
    result = np.empty_like(states)
    # What comes before the first clear state counts as that one.
    clear = states != 0
    first = np.take_along_axis(states, np.argmax(clear, axis=1)[:, None], axis=1)[:, 0]
    last = np.where(first == 0, 1, first).astype(np.int8)
    for n in range(states.shape[1]):
        last = np.where(states[:, n] != 0, states[:, n], last)
        result[:, n] = last
    return result


@analyses.register("time_crystal", checked_system, checked_vertical)
def time_crystal(
    system: System,
    drive: Drive | None = None,
    *,
    frequency_ratio: Annotated[Sequence[float] | None, POSITIVE] = None,
    drive_amplitude: Annotated[Sequence[float] | None, NON_NEGATIVE] = None,
    noise_strength: Annotated[float, NON_NEGATIVE] = 0.0,
    trajectories: int = 1,
    noise_seed: Annotated[int, STREAMS] = 0,
    periods: Annotated[int, Range(16, COUNT.high, open_high=True)] = 256,
    transient_periods: Annotated[int, NON_NEGATIVE] = 200,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    tolerance: float = 1e-6,
    contact: str | None = "exact",
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return the order parameter [rad] and the line at half the driving frequency of one toy.

    Stroboscopic measures of discrete time crystals (Else, Bauer & Nayak, 2016; Yao et al., 2017).

    Parameters
    ----------
    system : System
        What moves; of two balls, the right one is analysed.
    drive : PeriodicDrive
        The drive, whose frequency and amplitude stand where no others are given.
    frequency_ratio : sequence of float, optional
        Driving over natural frequencies [1].
    drive_amplitude : sequence of float, optional
        Amplitudes [m].
    noise_strength : float
        Strength of velocity kicks [rad/s^(3/2)].
    trajectories : int
        Trajectories with their own random streams; more than one needs noise.
    noise_seed : int
        Seed of the streams.
    periods, transient_periods : int
        Drive periods that are analysed (at least 16), and those before them.
    initial_angle, initial_angular_velocity, initial_offset, tolerance, contact, rest_speed
        As for `latolato.sweep`; by default the start is 0.1 rad beside where the system hangs.

    Returns
    -------
    xarray.Dataset
        Over ``drive_amplitude`` and ``frequency_ratio``: ``order_parameter``,
        ``order_parameter_size``, ``order_parameter_best``, ``peak_frequency``,
        ``peak_amplitude``, ``peak_width``, ``peak_share``, ``phase_slips``, ``lifetime`` with its
        95 % interval, ``drive_period`` and ``status``; also over ``lag``
        ``sign_autocorrelation`` and over ``period`` ``order_parameter_decay``. The status is
        "no motion", "no subharmonic" (an answer of period 1), "locked" (a sharp line
        at half the driving frequency), "drifting" (a sharp line beside it), "broad" (chaos or
        noise) or "no answer"; without a subharmonic the peak, slips and lifetimes are NaN.

    Raises
    ------
    InputError
        For a parameter outside its range, a drive without a period, several trajectories without
        noise.

    Notes
    -----
    ``Z = <(-1)^n angle(nT)>`` with n counted from time zero, where the drive has its phase
    `drive_phase`: its sign distinguishes the two motions, one period apart, and changes with the
    start. The angle is taken modulo 2 pi in [-pi, pi), from the upright position
    if the motion is mostly above its pivot. ``order_parameter`` keeps
    the sign when it averages over trajectories, so that it decays with phase slips;
    ``order_parameter_size`` does not. Where the answer happens to pass its middle at the instants
    nT, Z is small though the answer is not: ``order_parameter_best``, slips, lifetime,
    autocorrelation and decay look along the best direction of the plane of angle and
    ``velocity/(w/2)``, means removed, which stands for the best stroboscopic phase. Signs are read
    with hysteresis (`sign_states`); ``order_parameter_decay`` takes each trajectory times its
    first sign. Independent slips make ``C(m) = exp(-2 m T/lifetime)``.
    ``lifetime`` is the time looked at over the slips; without any it is NaN and only
    ``lifetime_low`` is known. The peak is that of `subharmonic_peak`; a width of 1.44/periods
    (attribute ``resolution``) is none, and "locked" and "drifting" have at most twice that and at
    least half of the oscillating power in it.

    The attribute ``caution`` names what one toy cannot show: rigidity and lifetime of a many-body
    phase. With noise, points share their streams. What this can miss: slips that come and
    go within a period; a line outside 1/4 to 3/4 of the driving frequency; other answers than the
    one that the start leads to. The pair's usual answer at e = 0.9 has period 1: no subharmonic.

    Examples
    --------
    >>> import latolato as ll
    >>> pendulum = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    >>> drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)
    >>> result = time_crystal(pendulum, drive, periods=64, transient_periods=400)
    >>> result.status.item(), f"{result.peak_frequency.item():.3f}"
    ('locked', '0.500')
    """
    drive = checked_vertical(drive)
    ratios = np.array([drive.drive_frequency / system.natural_frequency])
    ratios = ratios if frequency_ratio is None else np.array(frequency_ratio)
    amplitudes = np.array([drive.drive_amplitude] if drive_amplitude is None else drive_amplitude)
    if trajectories > 1 and noise_strength == 0.0:
        raise broken_analysis("alike_trajectories", {"count": trajectories})
    start = start_options(
        system, initial_angle, initial_angular_velocity, initial_offset, beside=0.1
    )
    axes: dict[str, Any] = {"drive_amplitude": amplitudes}
    noise = None
    if noise_strength > 0.0:
        noise = VelocityKicks(noise_strength=noise_strength, noise_seed=noise_seed)
        axes["noise_stream"] = range(trajectories)
    result: list[list[dict[str, Any]]] = []
    for ratio in ratios:
        frequency = ratio * system.natural_frequency
        grid = sweep(
            system,
            replace(drive, drive_frequency=frequency),
            axes=axes,
            duration=(transient_periods + periods) * math.tau / frequency,
            observables=[PoincareSection(periods=periods)],
            noise=noise,
            tolerance=tolerance,
            contact=contact,
            rest_speed=rest_speed,
            **start,
        )
        if "ball" in grid.dims:
            grid = grid.isel(ball=0)
        shape = (len(amplitudes), trajectories, periods)
        angles = grid.section_angle.values.reshape(shape)
        velocities = grid.section_angular_velocity.values.reshape(shape)
        valid = has_answer(grid.status).reshape(shape[:2])
        first = transient_periods + 1
        result.append(
            [
                _measures(angles[i][valid[i]], velocities[i][valid[i]], frequency, first)
                for i in range(len(amplitudes))
            ]
        )
    dims: dict[str, tuple[str, ...]] = {
        "sign_autocorrelation": ("lag",),
        "order_parameter_decay": ("period",),
    }
    points = ("drive_amplitude", "frequency_ratio")
    variables = {
        name: (
            points + dims.get(name, ()),
            np.array([[row[i][name] for row in result] for i in range(len(amplitudes))]),
        )
        for name in result[0][0]
    }
    rates = ratios * system.natural_frequency
    return labelled(
        variables | {"drive_period": ("frequency_ratio", math.tau / rates)},
        system=system,
        drive=drive,
        coordinates={
            "drive_amplitude": amplitudes,
            "frequency_ratio": ratios,
            "lag": np.arange(periods // 2),
            "period": np.arange(first, first + periods),
        },
        quantities=_QUANTITIES,
        settings={**start, "caution": CAUTION, "resolution": _HANN_WIDTH / periods},
    )


def _measures(angles: Floats, velocities: Floats, frequency: float, first: int) -> dict[str, Any]:
    """Return all variables of one point, from arrays of shape (trajectory, period)."""
    periods = angles.shape[1]
    signs = np.where((first + np.arange(periods)) % 2 == 0, 1.0, -1.0)
    result: dict[str, Any] = dict.fromkeys(
        ("order_parameter", "order_parameter_size", "order_parameter_best", "peak_frequency",
         "peak_amplitude", "peak_width", "peak_share", "phase_slips", "lifetime", "lifetime_low",
         "lifetime_high"),
        math.nan,
    )  # fmt: skip
    result["sign_autocorrelation"] = np.full(periods // 2, math.nan)
    result["order_parameter_decay"] = np.full(periods, math.nan)
    result["status"] = NO_ANSWER
    if not len(angles) or not np.all(np.isfinite(angles)):
        return result
    # Motion about the upright position is counted from there: elsewhere the cut would part it.
    side = 0.0 if np.cos(angles).mean() < 0.0 else math.pi
    angles = np.remainder(angles + side, math.tau) - math.pi
    each = (signs * angles).mean(axis=1)
    result["order_parameter"] = float(each.mean())
    result["order_parameter_size"] = float(np.abs(each).mean())
    peak = subharmonic_peak(angles, velocities, frequency)
    motion = np.sqrt(np.mean((velocities / frequency) ** 2 + (angles - angles.mean()) ** 2))
    result["peak_amplitude"] = peak.amplitude
    if peak.amplitude < LEAST_AMPLITUDE:
        result["status"] = NO_MOTION if motion < LEAST_AMPLITUDE else NO_SUBHARMONIC
        return result
    result |= {
        "peak_frequency": peak.frequency,
        "peak_width": peak.width,
        "peak_share": peak.share,
        **_survival(_demodulated(signs, angles, velocities, frequency), math.tau / frequency),
    }
    if peak.share < SHARP or peak.width > WIDEST * _HANN_WIDTH / periods:
        result["status"] = BROAD
    else:
        is_half = abs(peak.frequency - 0.5) <= 0.5 * _HANN_WIDTH / periods
        result["status"] = LOCKED if is_half else DRIFTING
    return result


def _demodulated(signs: Floats, angles: Floats, velocities: Floats, frequency: float) -> Floats:
    """Return (-1)^n times the answer along its best direction, shape (trajectory, period)."""
    plane = (angles - angles.mean()) - 1j * (velocities - velocities.mean()) / (0.5 * frequency)
    plane = signs * plane
    # Squares do not see the sign: both phases of the answer have one direction.
    turned: Floats = np.real(plane * np.exp(-0.5j * np.angle(np.mean(plane**2))))
    return turned if turned[:, 0].mean() >= 0.0 else -turned


def _survival(demodulated: Floats, period: float) -> dict[str, Any]:
    """Return order, slips, lifetime and autocorrelation of an answer, (trajectory, period)."""
    from latolato.analysis.first_passage_time import censored_mean

    states = sign_states(demodulated).astype(np.float64)
    count, periods = states.shape
    slips = int(np.count_nonzero(np.diff(states, axis=1)))
    life = censored_mean(count * (periods - 1) * period, slips)
    return {
        "order_parameter_best": float(abs(demodulated.mean())),
        "order_parameter_decay": (states[:, :1] * demodulated).mean(axis=0),
        "phase_slips": float(slips),
        "lifetime": life.mean,
        "lifetime_low": life.low,
        "lifetime_high": life.high,
        "sign_autocorrelation": np.array(
            [np.mean(states[:, : periods - m] * states[:, m:]) for m in range(periods // 2)]
        ),
    }
