"""Balls on strings or rods, by an event-driven program of its own: SciPy's DOP853 at 1e-13.

It shares nothing with latolato. A taut ball is integrated as an angle, a slack one as a point in
the plane, both with the same Cartesian acceleration (gravity, pivot, drag). Every mode change is
located on the dense output of a step, and the next step begins there.

String: it goes slack where its tension falls through zero, or at once where the tension is
negative. Where a slack ball reaches the length outwards, its radial velocity v becomes ``-es v``;
it is taut if es = 0, or if ``v/l < rest_speed`` and the tension would be positive.

Impact: an impulse J along the line of centres acts together with an impulse S >= 0 of each string
that is taut at that instant. J makes the relative normal velocity, after all reactions, ``-e``
times what it was (Newton). S keeps a taut string from getting longer: it is zero where J pushes
the ball inwards, and makes the radial velocity zero otherwise, whatever es is. As a taut string
has no radial velocity before, the solution is ``J = (1 + e) v / sum(mobilities)``: the mobility of
a ball along the normal n is ``(1 - (n . radial)^2)/m`` if its string reacts and 1/m otherwise. The
energy ``(1 - e^2) v^2/(2 sum(mobilities))`` is impact loss; none is gained. Rods react both ways.
For equal lengths this is the rods' rule ``w1 -> P - e I2 D/(I1 + I2)``. The mirror-symmetric toy
meets the plane X = radius, which does not move.

Both at once: strings first, then balls, until nothing approaches; then tensions are looked at.
"""

from __future__ import annotations

import math
from collections import namedtuple
from dataclasses import dataclass
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

TAUT, SLACK, REST = 0, 1, 2
LEDGER = ("drive_work", "damping_loss", "impact_loss", "capture_loss", "retension_loss")
# Gaps [m] that count as none, and speeds [m/s] that count as no approach, where several things
# happen at once: rounding makes some 1e-16 of both.
TOUCH, STILL = 1e-12, 1e-14
LEVEL = 1e-15  # gaps [m] that rounding hides
PARTS = 8  # of a step, at whose ends guards are looked at


@dataclass(frozen=True)
class Body:
    l: float
    m: float
    C: float = 0.0
    C2: float = 0.0
    r: float = 0.0


# What happened to which ball (-1: to both), and (angular, radial) velocities of each.
Event = namedtuple("Event", "time kind ball before after")


@dataclass
class Strings:
    """One ball, the toy of mirror symmetry (``walls``), or two free balls."""

    bodies: list
    walls: bool = False
    string: bool = True
    lab: bool = False  # drag relative to the room
    e: float = 1.0
    es: float = 0.0
    A0: float = 0.0
    w: float = 0.0
    phase: float = 0.0
    Ax: float = 0.0
    phx: float = 0.0
    g: float = 9.8
    rest_speed: float = 1e-7
    max_step: float = 4e-3

    def accelerated(self, b, t, u, v):
        """Acceleration of a free ball relative to the pivot, and powers of pivot and drag."""
        w, p, q = self.w, self.w * t + self.phx, self.w * t + self.phase
        ax, ay = -self.Ax * w * w * math.cos(p), -self.A0 * w * w * math.cos(q)
        x, y = u, v
        if self.lab:
            x, y = u - self.Ax * w * math.sin(p), v - self.A0 * w * math.sin(q)
        k = (b.C + b.C2 * math.hypot(x, y) / b.l) / (b.m * b.l)
        work, damped = -b.m * (ax * u + ay * v), b.m * k * (x * u + y * v)
        return -ax - k * x, -self.g - ay - k * y, work, damped

    def placed(self, i, y):
        """Position and velocity in the plane."""
        l, s = self.bodies[i].l, y[4 * i : 4 * i + 4]
        if self.modes[i] == SLACK:
            return tuple(s)
        a, c, w = math.sin(s[0]), math.cos(s[0]), s[1]
        return l * a, -l * c, l * w * c, l * w * a

    def pulled(self, i, t, y):
        """Angular acceleration of a taut ball and the tension per mass."""
        b, (th, w) = self.bodies[i], y[4 * i : 4 * i + 2]
        s, c = math.sin(th), math.cos(th)
        ax, ay, *_ = self.accelerated(b, t, b.l * w * c, b.l * w * s)
        return (ax * c + ay * s) / b.l, b.l * w * w + ax * s - ay * c

    def slope(self, t, y):
        result = np.zeros(len(y))
        for i, b in enumerate(self.bodies):
            _, _, u, v = self.placed(i, y)
            ax, ay, work, damped = self.accelerated(b, t, u, v)
            result[-2] += work
            result[-1] += damped
            if self.modes[i] == SLACK:
                result[4 * i : 4 * i + 4] = u, v, ax, ay
            elif self.modes[i] == TAUT:
                result[4 * i : 4 * i + 2] = y[4 * i + 1], self.pulled(i, t, y)[0]
        return result

    def radial(self, i, y):
        """Unwrapped angle, distance, angular and radial velocity."""
        x, z, u, v = self.placed(i, y)
        if self.modes[i] != SLACK:
            return y[4 * i], self.bodies[i].l, y[4 * i + 1], 0.0
        d, th = math.hypot(x, z), math.atan2(x, -z)
        th += 2.0 * math.pi * round((self.turned[i] - th) / (2.0 * math.pi))
        return th, d, (u * -z + v * x) / d**2, (x * u + z * v) / d

    def normal(self, y):
        """Gap of what can collide, its rate, and the normal that points to the first ball."""
        x, z, u, v = self.placed(0, y)
        if self.walls:
            return x - self.bodies[0].r, u, (1.0, 0.0)
        a, b, c, d = self.placed(1, y)
        apart = math.hypot(x - a, z - b)
        n = (x - a) / apart, (z - b) / apart
        gap = apart - self.bodies[0].r - self.bodies[1].r
        return gap, n[0] * (u - c) + n[1] * (v - d), n

    def guards(self, t, y):
        """What must stay positive: kind, ball, value, and a rate, negative where it closes."""
        for i, b in enumerate(self.bodies):
            if self.modes[i] == SLACK:
                x, z, u, v = self.placed(i, y)
                yield "taut", i, (b.l**2 - x * x - z * z) / (2 * b.l), -(x * u + z * v) / b.l
            elif self.modes[i] == REST:
                yield "release", i, self.pressed(t, y), -1.0
            elif self.string:
                yield "slack", i, self.pulled(i, t, y)[1], -1.0
        if (self.walls or len(self.bodies) == 2) and self.modes[0] != REST:
            yield "contact", 0, *self.normal(y)[:2]

    def pressed(self, t, y):
        """Angular acceleration towards the plane."""
        return -math.copysign(1.0, math.cos(y[0])) * self.pulled(0, t, y)[0]

    def located(self, a, b, at):
        """First event between two instants: its time, kind and ball; None without one."""
        found = []
        for n, (kind, ball, value, rate) in enumerate(self.guards(b, at(b))):
            if value >= 0.0 or rate >= 0.0:
                assert value > -TOUCH, ("a short event was missed", kind, a, b)
                continue

            def guard(t, n=n, part=2):
                return list(self.guards(t, at(t)))[n][part]

            start = a
            if guard(a, part=3) > 0.0:  # it opens first, perhaps from zero
                start = brentq(lambda t, guard=guard: guard(t, part=3), a, b, xtol=1e-16)
                if guard(start) <= LEVEL:  # hidden by rounding: up and down take as long
                    found.append((min(2.0 * start - a, b), kind, ball))
                    continue
            root = a if guard(start) <= 0.0 else brentq(guard, start, b, xtol=1e-16, rtol=1e-15)
            found.append((root, kind, ball))
        return min(found, default=None)

    def loosen(self, i):
        x = self.placed(i, self.y)
        self.turned[i], self.modes[i] = self.y[4 * i], SLACK
        self.y[4 * i : 4 * i + 4] = x

    def tighten(self, i, t):
        """Let a string that a ball stretches react: it is taut, or the ball bounces."""
        b, before, kept = self.bodies[i], self.speeds(), self.y[4 * i : 4 * i + 4].copy()
        th, d, w, out = self.radial(i, self.y)
        self.modes[i], self.y[4 * i : 4 * i + 4] = TAUT, (th, w * d / b.l, 0.0, 0.0)
        caught = out / b.l < self.rest_speed and self.pulled(i, t, self.y)[1] > 0.0
        es = 0.0 if caught else self.es
        if es > 0.0:
            kept[2:] -= (1.0 + es) * out / d * kept[:2]
            self.modes[i], self.y[4 * i : 4 * i + 4] = SLACK, kept
        self.losses[2] += 0.5 * b.m * out**2 * (1.0 - es**2)
        self.snaps.append(b.m * out * (1.0 + es))
        self.log(t, "taut", i, before)

    def strike(self, t):
        """Let balls collide that touch and approach."""
        before, (_, rate, n) = self.speeds(), self.normal(self.y)
        slow = self.e < 1.0 and -rate / self.bodies[0].l < self.rest_speed
        assert not slow or self.walls, "sticking contact of two balls is not described here"
        slow &= self.modes[0] == TAUT and self.pressed(t, self.y) > 0.0
        e = 0.0 if slow else self.e
        states = [self.placed(i, self.y) for i in self.balls]
        # The share of J along each string, where it reacts.
        shares = [
            (1 - 2 * i) * (n[0] * x + n[1] * z) / b.l * (self.modes[i] == TAUT)
            for i, (b, (x, z, _, _)) in enumerate(zip(self.bodies, states, strict=True))
        ]
        shares = [max(s, 0.0) if self.string else s for s in shares]
        mobility = sum((1 - s * s) / b.m for s, b in zip(shares, self.bodies, strict=True))
        J = -(1.0 + e) * rate / mobility
        self.losses[1 if slow else 0] += 0.5 * (1.0 - e * e) * rate**2 / mobility
        self.reactions.append(J * max(shares))
        pushed = []
        for i, (b, (x, z, u, v)) in enumerate(zip(self.bodies, states, strict=True)):
            u += J * ((1 - 2 * i) * n[0] - shares[i] * x / b.l) / b.m
            v += J * ((1 - 2 * i) * n[1] - shares[i] * z / b.l) / b.m
            if self.modes[i] == TAUT and shares[i] == 0.0 and self.string:  # inwards
                self.loosen(i)
                pushed.append(i)
            if self.modes[i] == TAUT:
                self.y[4 * i + 1] = 0.0 if self.walls and e == 0.0 else (v * x - u * z) / b.l**2
            else:
                self.y[4 * i : 4 * i + 4] = x, z, u, v
        th = [self.radial(i, self.y)[0] for i in self.balls]
        apart = 2.0 * th[0] if self.walls else th[0] - th[1]
        self.log(t, "bottom" if apart % (2.0 * math.pi) < math.pi else "top", -1, before)
        for i in pushed:
            self.log(t, "slack", i)

    def settle(self, t, fired=None):
        """Let everything happen that happens at this instant, ``fired`` for certain."""
        released = fired == ("release", 0)
        if released:
            self.modes[0] = TAUT
        elif fired and fired[0] == "slack":
            self.loosen(fired[1])
            self.log(t, "slack", fired[1])
        for _ in range(10_000):
            outwards = [
                i
                for i, (_, d, _, out) in enumerate(self.radial(i, self.y) for i in self.balls)
                if self.modes[i] == SLACK
                and (fired == ("taut", i) or self.bodies[i].l - d < TOUCH)
                and out > STILL
            ]
            contacts = (self.walls or len(self.bodies) == 2) and self.modes[0] != REST
            gap, rate = self.normal(self.y)[:2] if contacts else (1.0, 0.0)
            if outwards:
                self.tighten(outwards[0], t)
            elif gap < TOUCH and rate < -STILL:
                self.strike(t)
            else:
                break
            fired = None
        still = self.walls and self.modes[0] == TAUT and gap < TOUCH and self.y[1] == 0.0
        if still and not released and self.pressed(t, self.y) > 0.0:
            self.modes[0] = REST
        for i in self.balls:
            # T = 0 is left to the guard: it goes either way from there.
            if self.string and self.modes[i] == TAUT and self.pulled(i, t, self.y)[1] < -STILL:
                self.loosen(i)
                self.log(t, "slack", i)

    def speeds(self):
        return tuple(self.radial(i, self.y)[2:] for i in self.balls)

    def log(self, t, kind, ball, before=None):
        after = self.speeds()
        self.events.append(Event(float(t), kind, ball, before or after, after))

    def run(self, start, times):
        """Return the motion from angle, angular velocity and perhaps distance of each ball.

        It has ``samples``, arrays (ball, time) or (time,) by name, ``events``, the time for which
        each ball was slack, and all impulses [N s] of strings that became taut (``snaps``) and of
        taut strings at impacts (``reactions``).
        """
        count, rows, t, times = len(self.bodies), [], 0.0, np.asarray(times, dtype=float)
        self.balls, self.losses, slack_time = range(count), np.zeros(3), np.zeros(count)
        self.modes, self.turned, self.y = [TAUT] * count, [0.0] * count, np.zeros(4 * count + 2)
        self.events, self.snaps, self.reactions = [], [], []
        for i, (th, w, *rest) in enumerate(start):
            self.y[4 * i : 4 * i + 2], self.turned[i] = (th, w), th
            if rest and rest[0] < self.bodies[i].l:
                d, s, c = rest[0], math.sin(th), math.cos(th)
                self.y[4 * i : 4 * i + 4] = d * s, -d * c, d * w * c, d * w * s
                self.modes[i] = SLACK
        self.settle(0.0)

        def write(y):
            placed = zip(self.bodies, (self.placed(i, y) for i in self.balls), strict=True)
            energies = [
                (0.5 * b.m * (u * u + v * v), b.m * self.g * (b.l + z))
                for b, (_, z, u, v) in placed
            ]
            balls = [(*self.radial(i, y), self.modes[i] == SLACK) for i in self.balls]
            rows.append((balls, energies, (y[-2], y[-1], *self.losses)))

        solver, last = None, times[-1]
        while t < last:
            solver = solver or DOP853(
                self.slope, t, self.y, last, max_step=self.max_step, rtol=1e-13, atol=1e-15
            )
            solver.step()
            at, parts = solver.dense_output(), pairwise(np.linspace(t, solver.t, PARTS + 1))
            event = next(filter(None, (self.located(a, b, at) for a, b in parts)), None)
            end = event[0] if event else solver.t
            while times[len(rows)] < end:
                write(at(times[len(rows)]))
            slack_time += (end - t) * (np.array(self.modes) == SLACK)
            self.y = at(end) if event else solver.y.copy()
            self.turned = [self.radial(i, self.y)[0] for i in self.balls]
            t = end
            if event:
                self.settle(t, event[1:])
                solver = None
        write(self.y)
        balls, energies, ledger = (np.array(part, dtype=float) for part in zip(*rows, strict=True))
        names = ("angle", "distance", "angular_velocity", "radial_velocity", "slack")
        samples = dict(zip(names, balls.transpose(2, 1, 0), strict=True))
        samples |= dict(zip(("kinetic_energy", "potential_energy"), energies.T, strict=True))
        samples |= dict(zip(LEDGER, ledger.T, strict=True))
        return SimpleNamespace(
            samples=samples, events=self.events, slack_time=slack_time, snaps=self.snaps,
            reactions=self.reactions,
        )  # fmt: skip
