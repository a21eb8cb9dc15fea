"""How the answer to a drive depends on where its frequency came from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.registry import analyses, labelled
from latolato.analysis.starts import checked_system, start_options
from latolato.physics.drives import CrankSlider, Drive, Harmonic, drives
from latolato.physics.pendulum import Mathieu, Pendulum, System
from latolato.quantities import NON_NEGATIVE, POSITIVE, QUANTITIES, Quantity
from latolato.registry import checked_number
from latolato.start import DEFAULT_REST_SPEED
from latolato.sweep import sweep

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

LOOP, NO_LOOP, UNKNOWN = "hysteresis", "no hysteresis", "no answer"
# What is swept when nothing is said [w/w0].
_DEFAULT_RATIOS = (1.6, 3.6, 81)

_ENDS = ("largest_angle_after_transient", "final_angle", "final_angular_velocity")

_QUANTITIES = {
    "direction": Quantity("1", "", "way along the frequencies"),
    "jump_ratio": Quantity("1", r"\omega_j/\omega_0", "frequency ratio of the largest jump"),
    "jump_height": Quantity("rad", r"\Delta\theta_j", "change of the largest angle at the jump"),
    "loop_area": Quantity("rad", "S", "area between both ways, over the frequency ratio"),
    "bistable_low": Quantity("1", r"r_-", "lowest frequency ratio with two answers"),
    "bistable_high": Quantity("1", r"r_+", "highest frequency ratio with two answers"),
    "status": Quantity("1", "", "whether the answer depends on the way"),
}


@analyses.register("hysteresis")
def hysteresis(
    system: System,
    drive: Drive | None = None,
    *,
    frequency_ratio: Sequence[float] | None = None,
    drive_amplitude: Sequence[float] | None = None,
    duration: float = 60.0,
    transient: float | None = None,
    least_jump: float = 0.1,
    least_motion: float = 1e-3,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    tolerance: float = 1e-6,
    contact: str | None = "exact",
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return the largest angles [rad] of slow sweeps of the driving frequency, up and down.

    The experiment behind Paper Figs. 9 and 11, each step begun where the one before ended.

    Parameters
    ----------
    system : System
        What moves; of two balls the larger angle counts.
    drive : Harmonic or CrankSlider
        The drive; its frequency is swept.
    frequency_ratio : sequence of float, optional
        Driving over natural frequencies [1], increasing; by default 81 from 1.6 to 3.6.
    drive_amplitude : sequence of float, optional
        Amplitudes [m]; by default that of the drive.
    duration : float
        How long each frequency is held [s].
    transient : float, optional
        The beginning of that time whose angles do not count [s]; by default half of it.
    least_jump : float
        Change of the largest angle between neighbours, and difference between both ways, that
        counts as a jump [rad].
    least_motion : float
        A free pendulum whose motion has died down below this is begun again with it at the next
        frequency [rad], as some disturbance always is there; walls make rest lasting, and nothing
        is added.
    initial_angle, initial_angular_velocity, initial_offset
        The start of both sweeps, as for `latolato.simulate`; by default the system hangs at rest.
    tolerance, contact, rest_speed
        As for `latolato.sweep`.

    Returns
    -------
    xarray.Dataset
        Over ``drive_amplitude``: ``largest_angle`` (also over ``direction``, "up" and "down", and
        ``frequency_ratio``), ``jump_ratio`` and ``jump_height`` (also over ``direction``),
        ``loop_area``, ``bistable_low``, ``bistable_high`` and ``status``: "hysteresis", "no
        hysteresis" (jumps may still exist; the bistable range is NaN) or "no answer".

    Raises
    ------
    ValueError
        For a parameter outside its range, a drive without one frequency, or a linear system.

    Notes
    -----
    ``loop_area`` is the integral of ``|down - up|`` over the frequency ratio by trapezes; a jump's
    ratio is the middle of the two neighbours with the largest change, known to half their distance,
    and NaN where no change reaches `least_jump`. What it can miss: branches that neither sweep
    visits; a fold where the time per frequency is too short for the slow growth there, which
    widens the loop. A pendulum has to grow from `least_motion`: jumps come late unless half the
    duration is about ten growth times. A toy at rest in contact leaves it only where
    ``A0 w^2 > g``.

    Examples
    --------
    >>> import latolato as ll
    >>> toy = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.0196, restitution=0.9)
    >>> drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.1)
    >>> found = hysteresis(toy, drive, frequency_ratio=[2.0, 2.4, 2.8, 3.2], duration=30.0)
    >>> found.status.values.tolist(), found.jump_ratio.sel(direction="up").values.tolist()
    (['hysteresis'], [3.0])
    """
    system = checked_system(system)
    if isinstance(system, Mathieu):
        raise ValueError(
            "a Mathieu system is linear: it grows or decays, and has no two answers; take a "
            "Pendulum"
        )
    if not isinstance(drive, (Harmonic, CrankSlider)):
        name = "no" if drive is None else f"a {drives.name_of(drive)}"
        raise ValueError(f"{name} drive has no frequency to sweep: give a Harmonic one")
    ratios = _listed("frequency_ratio", frequency_ratio, np.linspace(*_DEFAULT_RATIOS))
    if len(ratios) < 2 or np.any(np.diff(ratios) <= 0.0):
        raise ValueError("the values of frequency_ratio must be two or more and increase; sort them")
    amplitudes = _listed("drive_amplitude", drive_amplitude, [drive.drive_amplitude])
    held = checked_number("duration", duration, POSITIVE, "s")
    jump = checked_number("least_jump", least_jump, POSITIVE, "rad")
    least = checked_number("least_motion", least_motion, NON_NEGATIVE, "rad")
    begin = 0.5 * held if transient is None else transient
    start = start_options(system, initial_angle, initial_angular_velocity, initial_offset)
    options: dict[str, Any] = {
        "duration": held,
        "transient": begin,
        "tolerance": tolerance,
        "contact": contact,
        "rest_speed": rest_speed,
    }
    if isinstance(system, Pendulum) and not system.has_contacts:
        angles = _stirred(system, drive, amplitudes, ratios, start, least, options)
    else:
        grid = sweep(
            system,
            drive,
            axes={"drive_amplitude": amplitudes, "frequency_ratio": ratios},
            observables=["largest_angle_after_transient"],
            continuation="frequency_ratio",
            direction="both",
            **options,
            **start,
        )
        largest = grid.largest_angle_after_transient
        if "ball" in largest.dims:
            largest = largest.max("ball", skipna=False)
        angles = largest.transpose("drive_amplitude", "direction", "frequency_ratio").values
    rows = [_loop(np.array(ratios), up, down, jump) for up, down in angles]
    variables: dict[str, Any] = {
        "largest_angle": (("drive_amplitude", "direction", "frequency_ratio"), angles)
    }
    both = ("drive_amplitude", "direction")
    for name in rows[0]:
        dims = both if name.startswith("jump") else both[:1]
        variables[name] = (dims, np.array([row[name] for row in rows]))
    return labelled(
        "hysteresis",
        variables,
        coordinates={
            "drive_amplitude": ("drive_amplitude", np.array(amplitudes)),
            "direction": ("direction", np.array(["up", "down"])),
            "frequency_ratio": ("frequency_ratio", np.array(ratios)),
        },
        quantities=_QUANTITIES,
        system=system,
        drive=drive,
        settings={
            "duration": held,
            "transient": begin,
            "least_jump": jump,
            "least_motion": least,
            "tolerance": tolerance,
            "rest_speed": rest_speed,
            **{k: v for k, v in start.items() if v is not None},
        },
    )


def _stirred(
    system: System,
    drive: Harmonic | CrankSlider,
    amplitudes: list[float],
    ratios: list[float],
    start: dict[str, Any],
    least: float,
    options: dict[str, Any],
) -> Floats:
    """Return largest angles, (amplitude, direction, ratio), of motions that never die away."""
    count = len(amplitudes)
    found = np.full((count, 2, len(ratios)), math.nan)
    for way, order in enumerate((range(len(ratios)), reversed(range(len(ratios))))):
        angle = np.full(count, float(start["initial_angle"]))
        velocity = np.full(count, float(start["initial_angular_velocity"]))
        phase = np.full(count, drive.drive_phase)
        for place in order:
            frequency = ratios[place] * system.natural_frequency
            motion = np.hypot(angle, velocity / system.natural_frequency)
            angle = np.where(motion < least, np.copysign(least, angle), angle)
            grid = sweep(
                system,
                replace(drive, drive_frequency=frequency),
                axes={
                    "case": {
                        "drive_amplitude": amplitudes,
                        "initial_angle": angle,
                        "initial_angular_velocity": velocity,
                        "drive_phase": phase,
                    }
                },
                observables=_ENDS,
                **options,
            )
            found[:, way, place] = grid.largest_angle_after_transient
            angle = np.remainder(grid.final_angle.values + math.pi, math.tau) - math.pi
            velocity = grid.final_angular_velocity.values
            angle, velocity = np.nan_to_num(angle), np.nan_to_num(velocity)
            phase = np.remainder(phase + frequency * options["duration"], math.tau)
    return found


def _listed(name: str, values: Any, default: Any) -> list[float]:
    """Return the checked values of a parameter."""
    given = np.atleast_1d(default if values is None else values).tolist()
    if not given:
        raise ValueError(f"{name}: the list of values is empty; give one or leave it out")
    unit = QUANTITIES[name].unit
    return [checked_number(name, value, NON_NEGATIVE, unit) for value in given]


def _loop(ratios: Floats, up: Floats, down: Floats, least: float) -> dict[str, Any]:
    """Return jumps, area and range of one loop."""
    found: dict[str, Any] = {"jump_ratio": [], "jump_height": []}
    for angles, way in ((up, 1.0), (down, -1.0)):
        change = way * np.diff(angles)
        ratio = height = math.nan
        if np.all(np.isfinite(change)):
            i = int(np.argmax(np.abs(change)))
            if abs(change[i]) >= least:
                ratio, height = 0.5 * (ratios[i] + ratios[i + 1]), float(change[i])
        found["jump_ratio"].append(ratio)
        found["jump_height"].append(height)
    gap = np.abs(down - up)
    found["loop_area"] = float(np.trapezoid(gap, ratios))
    two = ratios[gap >= least]
    found["bistable_low"] = float(two[0]) if len(two) else math.nan
    found["bistable_high"] = float(two[-1]) if len(two) else math.nan
    is_known = math.isfinite(found["loop_area"])
    found["status"] = UNKNOWN if not is_known else (LOOP if len(two) else NO_LOOP)
    return found
