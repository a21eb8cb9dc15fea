"""Balls on strings beside balls on rods, and beside SciPy with events, in CPU time.

Work: (a) one run on rods and one on strings of a pendulum that loops, of the toy and of two balls;
(b) a sweep of the toy with cords that go slack (l = 0.186 m, r = 0.012 m, e = 0.822, e_s = 0,
C/(m l) = 0.16 1/s) over A0/l in (0, 1] and w/w0 in (0, 6], from 0.5 rad above contact, for 60 s,
beside a program around SciPy's solve_ivp (DOP853) with terminal events for slack, taut and contact
at some of the same points, each at several tolerances. One thread, without compilation; the error
of both is the median of the final angle's, beside a run at 1e-10, at points whose motion is regular
and moves. Compared are times at equal errors and at equal tolerances.
Prints tables and records the ratio at equal errors.

``python benchmarks/strings.py [--points N] [--sample N]``
"""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import latolato as ll
from latolato.paper.string_toys import CORD_PAIR, CORD_TOY
from ratios import least_times, record, time_at

DURATION, OFFSET = 60.0, 0.5
OWN_TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
SCIPY_TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
EQUAL_ERROR = 1e-7  # rad
REGULAR = 1e-6  # rad, of the final angle between runs at 1e-10 and 1e-11
STRINGS = replace(CORD_TOY, suspension="string")
L, R, E = CORD_TOY.length, CORD_TOY.radius, CORD_TOY.restitution
G, RATE = CORD_TOY.gravity, CORD_TOY.damping / (CORD_TOY.mass * CORD_TOY.length)
LOW, HIGH = CORD_TOY.contact_angle_low, CORD_TOY.contact_angle_high
# Events closer than this to the last one are the last one again [s].
SAME = 1e-9


def single_runs() -> list[dict[str, Any]]:
    """Return CPU times of runs on rods and on strings."""
    w = 2.5 * CORD_TOY.natural_frequency
    drive = ll.Harmonic(drive_amplitude=0.5 * L, drive_frequency=w)
    pendulum = ll.Pendulum(length=L, mass=CORD_TOY.mass, damping=CORD_TOY.damping)
    angles: dict[str, Any] = {"pendulum": 0.5, "toy": LOW + OFFSET, "two balls": None}
    systems = {"pendulum": pendulum, "toy": CORD_TOY, "two balls": CORD_PAIR}
    rows = []
    for name, system in systems.items():
        start = angles[name] or (LOW + OFFSET, -LOW - OFFSET)

        def run(each: Any, start: Any = start) -> Any:
            return ll.simulate(each, drive, initial_angle=start, duration=300.0)

        rods, strings = least_times(
            partial(run, system), partial(run, replace(system, suspension="string"))
        )
        rows.append(
            {"system": name, "rods_ms": 1e3 * rods, "strings_ms": 1e3 * strings,
             "ratio": strings / rods}
        )  # fmt: skip
    return rows


class Peer:
    """The toy with e_s = 0 by SciPy: one ball against the mirror X = r, event by event."""

    def __init__(self, amplitude: float, frequency: float, tolerance: float) -> None:
        self.amplitude, self.frequency, self.tolerance = amplitude, frequency, tolerance

    def fall(self, t: float) -> float:
        """Return g + y0''."""
        w = self.frequency
        return G - self.amplitude * w * w * math.cos(w * t)

    def taut(self, t: float, s: np.ndarray) -> list[float]:
        """Return the slopes of angle and angular velocity."""
        return [s[1], -self.fall(t) * math.sin(s[0]) / L - RATE * s[1]]

    def slack(self, t: float, s: np.ndarray) -> list[float]:
        """Return the slopes of x, y and their velocities."""
        return [s[2], s[3], -RATE * s[2], -self.fall(t) - RATE * s[3]]

    def tension(self, t: float, s: np.ndarray) -> float:
        """Return the tension over the mass."""
        return float(L * s[1] ** 2 + self.fall(t) * math.cos(s[0]))

    def final_angle(self) -> float:
        """Return the angle at the end of a run."""

        def low(t: float, s: np.ndarray) -> float:
            return s[0] - LOW

        def high(t: float, s: np.ndarray) -> float:
            return s[0] - HIGH

        def spare(t: float, s: np.ndarray) -> float:
            return L - math.hypot(s[0], s[1])

        def gap(t: float, s: np.ndarray) -> float:
            return s[0] - R

        def pull(t: float, s: np.ndarray) -> float:
            return self.tension(t, s)

        events: dict[bool, list[Any]] = {True: [pull, low, high], False: [spare, gap]}
        for each in (pull, low, spare, gap):
            each.terminal, each.direction = True, -1.0  # type: ignore[attr-defined]
        high.terminal, high.direction = True, 1.0  # type: ignore[attr-defined]
        t, s, is_taut = 0.0, np.array([LOW + OFFSET, 0.0]), True
        while t < DURATION:
            if is_taut and self.tension(t, s) <= 0.0:
                s, is_taut = _loose(s), False
            slope = self.taut if is_taut else self.slack
            found = solve_ivp(
                slope, (t, DURATION), s, "DOP853", events=events[is_taut],
                rtol=self.tolerance, atol=self.tolerance * (1.0 if is_taut else L),
            )  # fmt: skip
            before, t, s = t, float(found.t[-1]), found.y[:, -1]
            if found.status != 1:
                break
            which = next(i for i, each in enumerate(found.t_events) if each.size)
            if is_taut and which == 0:
                s, is_taut = _loose(s), False
            elif is_taut:
                wall = (LOW, HIGH)[which - 1]
                s = np.array([wall, -E * s[1]])
                if t - before < SAME:  # the end of a Zeno sequence: the ball rests until it lifts
                    t, s = self.rest(t, wall), np.array([wall, 0.0])
            elif which == 1:
                s[0], s[2] = R, -E * s[2]
            else:
                angle = math.atan2(s[0], -s[1])
                along = s[2] * math.cos(angle) + s[3] * math.sin(angle)
                s, is_taut = np.array([angle, along / L]), True
        return float(s[0] if is_taut else math.atan2(s[0], -s[1]))

    def rest(self, t: float, wall: float) -> float:
        """Return when a ball at rest on a wall leaves it."""
        times = t + np.arange(1, 2000) * (2.0 * math.pi / self.frequency / 1000.0)
        falls = np.array([self.fall(each) for each in times]) * math.cos(wall)
        lifts = np.flatnonzero(falls < 0.0)
        return float(times[lifts[0]]) if lifts.size else DURATION


def _loose(s: np.ndarray) -> np.ndarray:
    """Return place and velocity of a ball whose string goes slack, a little inside its end."""
    sin, cos = math.sin(s[0]), math.cos(s[0])
    inside = L * (1.0 - 1e-12)
    return np.array([inside * sin, -inside * cos, L * s[1] * cos, L * s[1] * sin])


def sweeps(points: int, sample: int) -> dict[str, Any]:
    """Return CPU times per point of the sweep and of SciPy, and their errors."""
    side = math.isqrt(points)
    share = np.arange(1, side + 1) / side
    axes = {"amplitude_ratio": share, "frequency_ratio": 6.0 * share}

    def run(tolerance: float) -> Any:
        return ll.sweep(
            STRINGS, axes=axes, duration=DURATION, initial_offset=OFFSET,
            observables=["final_angle", "slack_fraction"], tolerance=tolerance, workers=1,
        )  # fmt: skip

    exact, finer = (run(tolerance).final_angle.values for tolerance in (1e-10, 1e-11))
    regular = (np.abs(finer - exact) < REGULAR) & (exact > LOW)
    chosen = np.random.default_rng(1).choice(side**2, sample, replace=False)

    def run_peer(tolerance: float) -> list[float]:
        frequencies = 6.0 * share * CORD_TOY.natural_frequency
        return [
            Peer(share[i] * L, frequencies[j], tolerance).final_angle()
            for i, j in zip(*np.divmod(chosen, side), strict=True)
        ]

    seconds = least_times(
        *(partial(run, tolerance) for tolerance in OWN_TOLERANCES),
        *(partial(run_peer, tolerance) for tolerance in SCIPY_TOLERANCES),
        turns=2,
    )
    own, peer = [], []
    for tolerance in OWN_TOLERANCES:
        error = np.median(np.abs(run(tolerance).final_angle.values - exact)[regular])
        own.append((seconds.pop(0) / side**2, float(error)))
    for tolerance in SCIPY_TOLERANCES:
        errors = np.abs(run_peer(tolerance) - exact.ravel()[chosen])[regular.ravel()[chosen]]
        peer.append((seconds.pop(0) / sample, float(np.median(errors))))
    return {
        "points": side**2,
        "own": dict(zip(OWN_TOLERANCES, own, strict=True)),
        "SciPy": dict(zip(SCIPY_TOLERANCES, peer, strict=True)),
        "slack": float((run(1e-6).slack_fraction.values > 0.0).mean()),
        "regular": float(regular.mean()),
    }


def main() -> None:
    """Measure, print, record."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--points", type=int, default=324)
    parser.add_argument("--sample", type=int, default=12)
    options = parser.parse_args()
    for row in single_runs():
        print(
            f"{row['system']:10} rods {row['rods_ms']:7.2f} ms, strings {row['strings_ms']:7.2f} "
            f"ms, ratio {row['ratio']:.2f}"
        )
    found = sweeps(options.points, options.sample)
    own, peer = found["own"], found["SciPy"]
    print(
        f"sweep of {found['points']} points: {found['slack']:.0%} go slack, "
        f"{found['regular']:.0%} move regularly"
    )
    for name, rows in (("own", own), ("SciPy", peer)):
        for tolerance, (seconds, error) in rows.items():
            print(f"{name:6} {tolerance:.0e}: {1e3 * seconds:8.3f} ms, {error:.1e} rad")
    for tolerance in sorted(own.keys() & peer.keys()):
        ratio = peer[tolerance][0] / own[tolerance][0]
        print(f"SciPy's time over ours at tolerance {tolerance:g}: {ratio:.0f}")
    record(
        "a point of a map on strings over 60 s, error 1e-7 rad",
        "the toy on cords that go slack, one thread; the median error of final angles",
        time_at(EQUAL_ERROR, list(own.values())),
        {"SciPy": time_at(EQUAL_ERROR, list(peer.values()))},
    )


if __name__ == "__main__":
    main()
