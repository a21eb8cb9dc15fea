"""Derivatives of random runs beside differences of runs, to find any that is wrong and not NaN.

A case is a random system (rods and strings, one ball and two, all drags), drive, start and
parameter. Central differences of eighth order at several widths, of runs at tolerance 1e-13, are
compared with each other: where they agree, the derivative must agree with them too. Samples after
a contact that not all runs have, or within its shift, have no derivative to compare. Takes how many
cases and the first seed; prints the cases that disagree, and how many could be compared.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

import latolato as ll
from latolato.core.errors import InputError
from latolato.simulation.plan import RunPlan, make_run_plan
from latolato.simulation.run import record
from latolato.simulation.sensitivity import known_parameters
from latolato.simulation.vary import replaced

# Weights of the central difference of eighth order, at 1 to 4 widths.
WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
# Widths, as shares of the parameter.
WIDTHS = (1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 1e-7)
KEYS = ("angle", "angular_velocity")
TOLERANCE = 1e-13
# A derivative is wrong if it is further off than the differences from each other, this many times,
# and than this share of the largest one; the differences must agree to the second share.
SURE, ENOUGH, CLEAR = 30.0, 1e-6, 1e-3
# What runs at this tolerance scatter by, at the least [rad].
ROUNDING = 1e-14
# Parameters that are set from others: ratios have their own test.
LEFT_OUT = ("frequency_ratio", "amplitude_ratio", "drive_acceleration_ratio")


def random_ball(rng: Any, drags: Any, length: float) -> dict[str, float]:
    """Return the parameters of a ball."""
    ball = {
        "length": length,
        "mass": rng.uniform(0.05, 1.0),
        "radius": rng.uniform(0.05, 0.2) * length,
    }
    names = ("damping", "quadratic_damping", "coulomb_damping")
    return ball | {n: rng.uniform(0.0, 0.1) for n, is_on in zip(names, drags, strict=True) if is_on}


def random_system(rng: Any) -> Any:
    """Return a system."""
    kind = rng.choice(["pendulum", "toy", "pair", "mathieu"], p=[0.25, 0.35, 0.3, 0.1])
    is_string = kind != "mathieu" and rng.random() < 0.35
    drags = rng.random(3) < [0.8, 0.35, 0.0 if is_string else 0.35]
    more: dict[str, Any] = {}
    if is_string:
        more = {"suspension": "string", "string_restitution": rng.choice([0.0, 0.3, 0.8])}
    if kind != "mathieu" and rng.random() < 0.3:
        more["drag_frame"], drags[1] = "lab", False
    own = random_ball(rng, drags, rng.uniform(0.2, 1.2))
    restitution = rng.choice([0.0, rng.uniform(0.1, 0.95), rng.uniform(0.6, 1.0), 1.0])
    if kind == "toy":
        return ll.LatoLato(**own, restitution=restitution, **more)
    if kind == "pair":
        other = random_ball(rng, drags, own["length"] + rng.uniform(-0.6, 0.6) * own["radius"])
        balls = {"right": ll.Ball(**own), "left": ll.Ball(**other)}
        return ll.BallPair(**balls, restitution=restitution, **more)
    del own["radius"]
    if kind == "pendulum":
        return ll.Pendulum(**own, **more)
    return ll.Mathieu(**{k: v for k, v in own.items() if k in ("length", "mass", "damping")})


def random_drive(rng: Any, system: Any) -> Any:
    """Return a drive, or None."""
    first = system.balls[0]
    size = rng.uniform(0.01, 0.25) * first.length
    rate = system.natural_frequency * rng.uniform(0.5, 3.0)
    phase = rng.uniform(-3.0, 3.0)
    same = {"drive_amplitude": size, "drive_phase": phase}
    kinds = ["none", "harmonic", "chirp", "crank", "planar", "schedule", "staged"]
    kind = rng.choice(kinds, p=[0.15, 0.35, 0.12, 0.12, 0.1, 0.08, 0.08])
    if kind == "none":
        return None
    if kind == "chirp":
        final, span = rate * rng.uniform(0.6, 1.6), rng.uniform(0.5, 6.0)
        return ll.Chirp(drive_frequency=rate, drive_frequency_final=final, sweep_time=span, **same)
    if kind == "crank":
        rod, guide = size * rng.uniform(1.3, 5.0), str(rng.choice(["above", "below"]))
        return ll.CrankSlider(drive_frequency=rate, connecting_rod_length=rod, guide=guide, **same)
    if kind == "planar" and not isinstance(system, (ll.LatoLato, ll.Mathieu)):
        return ll.PlanarHarmonic(
            vertical_amplitude=size, horizontal_amplitude=size * rng.random(),
            drive_frequency=rate, vertical_phase=phase, horizontal_phase=rng.uniform(-3.0, 3.0),
        )  # fmt: skip
    if kind == "schedule":
        how = {"ramp": rng.uniform(0.05, 0.4)} if rng.random() < 0.5 else {"step_impulse": True}
        return ll.FrequencySchedule(
            times=[0.0, rng.uniform(0.6, 2.0), rng.uniform(2.5, 4.0)],
            drive_frequencies=[rate, 1.3 * rate, 0.8 * rate], **same, **how,
        )  # fmt: skip
    if kind == "staged":
        return ll.StagedHarmonic(
            times=[0.0, rng.uniform(0.6, 2.5)], drive_amplitudes=[size, 1.5 * size],
            drive_frequencies=[rate, 1.2 * rate], ramps=[0.1, 0.3], drive_phase=phase,
        )  # fmt: skip
    return ll.Harmonic(drive_frequency=rate, **same)


def random_start(rng: Any, system: Any) -> dict[str, Any]:
    """Return the arguments that begin a run."""
    if isinstance(system, ll.BallPair):
        near = 1.05 * system.contact_separation
        apart, middle = rng.uniform(near, min(2.5, math.tau - near)), rng.uniform(-0.5, 0.5)
        return {
            "initial_angle": (middle + 0.5 * apart, middle - 0.5 * apart),
            "initial_angular_velocity": tuple(2.0 * rng.normal(size=2)),
        }
    start: dict[str, Any] = {"initial_angular_velocity": 2.0 * rng.normal()}
    if not isinstance(system, ll.LatoLato):
        return start | {"initial_angle": rng.uniform(-2.8, 2.8)}
    if rng.random() < 0.3:
        return start | {"initial_offset": rng.uniform(0.05, 1.5)}
    return start | {"initial_angle": rng.uniform(system.contact_angle_low + 0.02, 2.8)}


def with_value(plan: RunPlan, parameter: Any, value: float) -> tuple[Any, Any, dict[str, Any]]:
    """Return system, drive and start with another value of a parameter."""
    system, drive = plan.system, plan.drive
    start = {"initial_angle": list(plan.start.angles), "initial_offset": [plan.offset],
             "initial_angular_velocity": list(plan.start.velocities)}  # fmt: skip
    if parameter.owner == "system":
        system = replaced(system, {parameter.path: value})
    elif parameter.owner == "drive":
        drive = replaced(drive, {parameter.path: value})
    else:
        stem = parameter.name.removesuffix("_right").removesuffix("_left")
        start[stem][parameter.name.endswith("_left")] = value
    del start["initial_angle" if plan.offset is not None else "initial_offset"]
    single = {name: tuple(v) if len(v) > 1 else v[0] for name, v in start.items()}
    return system, drive, single


def value_of(plan: RunPlan, parameter: Any) -> float:
    """Return the value of a parameter."""
    if parameter.owner != "run":
        value: Any = getattr(plan, parameter.owner)
        for name in parameter.path:
            value = getattr(value, name)
        return float(value)
    if parameter.name == "initial_offset":
        assert plan.offset is not None
        return plan.offset
    is_rate = parameter.name.startswith("initial_angular_velocity")
    numbers = plan.start.velocities if is_rate else plan.start.angles
    return numbers[parameter.name.endswith("_left")]


def differences(
    plan: RunPlan, parameter: Any, share: float, found: Mapping[str, Any]
) -> tuple[dict[str, Any], Any]:
    """Return derivatives by runs, and at which samples they can be compared."""
    value, times = value_of(plan, parameter), plan.instants
    width = share * (abs(value) or 1.0)
    total = {key: np.zeros_like(found[key]) for key in KEYS}
    kinds, contacts = list(found["contact_kind"]), np.asarray(found["contact_time"])
    usable, early, late = np.ones(len(times), dtype=bool), contacts.copy(), contacts.copy()
    for k, weight in enumerate(WEIGHTS, 1):
        for sign in (1.0, -1.0):
            system, drive, start = with_value(plan, parameter, value + sign * k * width)
            run = record(
                system, drive, times=times, duration=plan.end, tolerance=TOLERANCE, **start
            )
            for key in KEYS:
                total[key] += sign * weight * np.asarray(run[key]) / width
            own, instants = list(run["contact_kind"]), np.asarray(run["contact_time"])
            pairs = enumerate(zip(own, kinds, strict=False))
            same = next((i for i, (a, b) in pairs if a != b), min(len(own), len(kinds)))
            ends = [t[same] for t in (instants, contacts) if same < len(t)]
            usable &= times < min(ends, default=math.inf)
            early[:same] = np.minimum(early[:same], instants[:same])
            late[:same] = np.maximum(late[:same], instants[:same])
    for a, b in zip(early, late, strict=True):
        usable &= ~((times >= a - 1e-12) & (times <= b + 1e-12))
    return total, usable


def compared(seed: int) -> tuple[str, float, int, bool]:
    """Return a case in words, the worst error per scatter, and how many numbers were compared."""
    rng = np.random.default_rng(seed)
    system = random_system(rng)
    drive, start = random_drive(rng, system), random_start(rng, system)
    duration = rng.uniform(1.0, 6.0)
    times = np.sort(rng.uniform(0.05, 1.0, 9)) * duration
    options = {"times": times, "duration": duration, "tolerance": TOLERANCE, **start}
    plan = make_run_plan(system, drive, **options)
    known = {n: p for n, p in known_parameters(plan).items() if n not in LEFT_OUT}
    for name in rng.permutation(list(known)):
        try:
            found = record(system, drive, sensitivity_to=str(name), **options)
        except InputError:  # it does not act
            continue
        break
    sums = {key: (None, None, np.full(found[key].shape, np.inf), found[key]) for key in KEYS}
    for share in WIDTHS:
        try:
            total, usable = differences(plan, known[str(name)], share, found)
        except InputError:  # beyond a limit
            continue
        for key, (last, was_usable, scatter, best) in sums.items():
            apart = np.full(best.shape, np.inf)
            if last is not None:
                both = usable & was_usable
                blur = ROUNDING / (share * (abs(value_of(plan, known[str(name)])) or 1.0))
                apart = np.where(both, np.abs(total[key] - last) + blur, np.inf)
            closer = apart < scatter
            kept = np.where(closer, total[key], best)
            sums[key] = total[key], usable, np.where(closer, apart, scatter), kept
    worst, count = 0.0, 0
    for key, (_, _, scatter, best) in sums.items():
        own = np.asarray(found[f"{key}_sensitivity"])[0]
        seen = np.isfinite(scatter) & np.isfinite(own)
        if not seen.any():
            continue
        largest = np.max(np.abs(best[seen])) + 1e-12
        seen &= scatter < CLEAR * largest
        count += int(seen.sum())
        off = np.abs(own - best) / (SURE * scatter + ENOUGH * largest)
        worst = max(worst, float(np.max(off[seen], initial=0.0)))
    status = found.attrs["sensitivity_status"]
    words = f"{type(system).__name__} {system.suspension} {type(drive).__name__} {name}: {status}"
    return words, worst, count, status == "known"


def main() -> None:
    """Compare, and print."""
    cases, first = (int(sys.argv[i]) if len(sys.argv) > i else d for i, d in ((1, 1000), (2, 0)))
    warnings.simplefilter("ignore")
    numbers = compared_cases = known = wrong = 0
    for seed in range(first, first + cases):
        words, worst, count, is_known = compared(seed)
        numbers, compared_cases = numbers + count, compared_cases + (count > 0)
        known += is_known
        if worst > 1.0:
            wrong += 1
            print(f"seed {seed}, {words}: {worst:.3g} times what is allowed", flush=True)
    print(
        f"{cases} cases, {known} known to the end; {compared_cases} compared in {numbers} numbers, "
        f"{wrong} wrong"
    )


if __name__ == "__main__":
    main()
