"""Writes cases.json: high-precision trajectories by Taylor series in mpmath, independent of latolato.

    python tests/reference/make_cases.py

Motion, works and losses are integrated by their Taylor series (order 36, 34 digits; recurrences
for sine, cosine, product and square root), events are roots of the series by bisection and Newton.
Every case is computed twice, with another order and half the step; `agree_digits` is the smallest
agreement of the two over all stored numbers. The layout is that of trajectories.json.
"""

from __future__ import annotations

import json
from pathlib import Path

import mpmath as mp

mp.mp.dps = 34
GRAVITY = "9.8"


# --- series: lists of coefficients of powers of the time since the step began ---------------------
def product(a, b, k):
    """Coefficient k of a*b."""
    return mp.fdot(a[: k + 1], b[k::-1])


def sine_step(x, s, c, k):
    """Append coefficient k of sin x and cos x; s' = x' c, c' = -x' s."""
    weights = [j * x[j] for j in range(1, k + 1)]
    s.append(mp.fdot(weights, c[k - 1 :: -1]) / k)
    c.append(-mp.fdot(weights, s[k - 1 :: -1]) / k)


def evaluate(a, h):
    """Value of a series at h."""
    return mp.polyval(a[::-1], h)


# --- drives: the series of the pivot's acceleration about an instant -----------------------------
def cosine_series(phase, rate, order):
    """Series of cos(phase + rate s)."""
    return [rate**k * mp.cos(phase + k * mp.pi / 2) / mp.factorial(k) for k in range(order)]


def swept_series(phase, frequency, rate, order):
    """Series of cos and sin of phase + frequency s + rate s^2/2."""
    x = [phase, frequency, rate / 2] + [mp.mpf(0)] * order
    s, c = [mp.sin(phase)], [mp.cos(phase)]
    for k in range(1, order):
        sine_step(x, s, c, k)
    return s, c


def differentiate(a):
    """Series of the derivative."""
    return [k * a[k] for k in range(1, len(a))]


class Harmonic:
    kind = "harmonic"

    def __init__(self, a, w, phase="0"):
        self.a, self.w, self.phase = mp.mpf(a), mp.mpf(w), mp.mpf(phase)

    def starts(self):
        return []

    def acceleration(self, t, order):
        amplitude = -self.a * self.w**2
        return [amplitude * c for c in cosine_series(self.w * t + self.phase, self.w, order)]


class Swept:
    """Stages (start, frequency, rate of change); the phase is continuous."""

    kind = "frequency_schedule"

    def __init__(self, a, knots, phase="0"):
        self.a = mp.mpf(a)
        self.knots = [tuple(map(mp.mpf, knot)) for knot in knots]
        self.phases = [mp.mpf(phase)]
        for (t0, w, r), (t1, _, _) in zip(self.knots, self.knots[1:], strict=False):
            s = t1 - t0
            self.phases.append(self.phases[-1] + w * s + r * s * s / 2)

    def starts(self):
        return [t for t, _, _ in self.knots[1:]]

    def acceleration(self, t, order):
        i = max(j for j, (start, _, _) in enumerate(self.knots) if start <= t)
        start, w, r = self.knots[i]
        s = t - start
        _, c = swept_series(self.phases[i] + w * s + r * s * s / 2, w + r * s, r, order + 2)
        return differentiate(differentiate([self.a * x for x in c]))


class Crank:
    kind = "crank_slider"

    def __init__(self, a, w, rod, side, phase="0"):
        self.a, self.w, self.rod = mp.mpf(a), mp.mpf(w), mp.mpf(rod)
        self.side, self.phase = side, mp.mpf(phase)

    def starts(self):
        return []

    def acceleration(self, t, order):
        n = order + 2
        p = self.w * t + self.phase
        cosine = cosine_series(p, self.w, n)
        sine = cosine_series(p - mp.pi / 2, self.w, n)
        inner = [-(self.a**2) * product(sine, sine, k) for k in range(n)]
        inner[0] += self.rod**2
        root = [mp.sqrt(inner[0])]
        for k in range(1, n):
            cross = mp.fdot(root[1:k], root[k - 1 : 0 : -1]) if k > 1 else mp.mpf(0)
            root.append((inner[k] - cross) / (2 * root[0]))
        height = [self.a * c + self.side * r for c, r in zip(cosine, root, strict=True)]
        return differentiate(differentiate(height))


class Still(Harmonic):
    kind = "fixed_pivot"

    def __init__(self):
        super().__init__("0", "1")


# --- one ball over one step -----------------------------------------------------------------------
class Ball:
    def __init__(self, length, mass, damping="0", quadratic="0", coulomb="0", linear=False):
        self.l, self.m = mp.mpf(length), mp.mpf(mass)
        self.c, self.q, self.f = mp.mpf(damping), mp.mpf(quadratic), mp.mpf(coulomb)
        self.linear = linear

    @property
    def inertia(self):
        return self.m * self.l**2

    def series(self, angle, speed, sign, lift, gravity, order):
        """Series of angle, speed, drive power and drag power; sign is that of the speed."""
        x, v = [angle], [speed]
        s, c = [mp.sin(angle)], [mp.cos(angle)]
        total = [gravity + lift[0], *lift[1:]]
        for k in range(order - 1):
            pull = x if self.linear else s
            a = -product(total, pull, k) / self.l - self.c / (self.m * self.l) * v[k]
            if self.q:
                a -= sign * self.q / (self.m * self.l) * product(v, v, k)
            if self.f and k == 0:
                a -= sign * self.f / (self.m * self.l)
            v.append(a / (k + 1))
            x.append(v[k] / (k + 1))
            if not self.linear:
                sine_step(x, s, c, k + 1)
        pull = x if self.linear else s
        flow = [product(v, pull, k) for k in range(order)]
        power = [-self.m * self.l * product(lift, flow, k) for k in range(order)]
        square = [product(v, v, k) for k in range(order)]
        loss = [self.l * self.c * w for w in square]
        if self.q:
            loss = [a + self.l * self.q * sign * product(square, v, k) for k, a in enumerate(loss)]
        if self.f:
            loss = [a + self.l * self.f * sign * w for a, w in zip(loss, v, strict=True)]
        return x, v, power, loss

    def energy(self, angle, speed, gravity):
        height = angle**2 / 2 if self.linear else 1 - mp.cos(angle)
        return self.inertia * speed**2 / 2 + self.m * gravity * self.l * height


def integral(a):
    """Series of the integral from zero."""
    return [mp.mpf(0)] + [w / (k + 1) for k, w in enumerate(a)]


def first_root(function, h, pieces=24):
    """Smallest s in (0, h] at which function goes from positive to zero or below; or None."""
    tiny = h * mp.mpf(10) ** -12  # a motion that starts on the wall is first above it
    old = tiny
    for k in range(1, pieces + 1):
        new = h * k / pieces
        if function(new) <= 0:
            low, high = old, new
            for _ in range(130):
                middle = (low + high) / 2
                low, high = (middle, high) if function(middle) > 0 else (low, middle)
            return high
        old = new
    return None


class Run:
    """A trajectory of one or two balls with walls, rest and friction."""

    def __init__(self, balls, drive, angles, speeds, walls=None, e="1", order=36, step="0.1"):
        self.balls, self.drive = balls, drive
        self.x, self.v = [mp.mpf(a) for a in angles], [mp.mpf(w) for w in speeds]
        self.low, self.high = walls or (None, None)
        self.e, self.order, self.step = mp.mpf(e), order, mp.mpf(step)
        self.g = mp.mpf(GRAVITY)
        self.t, self.work, self.damped, self.lost = (mp.mpf(0) for _ in range(4))
        self.contacts, self.states = [], []
        self.compression_first, self.compression_total = None, mp.mpf(0)
        lift = drive.acceleration(self.t, 2)[0]
        self.signs = [
            self.sign_of(b, x, v, lift) for b, x, v in zip(balls, self.x, self.v, strict=True)
        ]

    def sign_of(self, ball, angle, speed, lift):
        if speed != 0:
            return mp.sign(speed)
        return -mp.sign((self.g + lift) * mp.sin(angle))

    def gap(self, angles):
        return angles[0] if len(angles) == 1 else angles[0] - angles[1]

    def impact(self, kind):
        before = list(self.v)
        if len(self.balls) == 1:
            self.v = [-self.e * self.v[0]]
            self.lost += self.balls[0].inertia * (before[0] ** 2 - self.v[0] ** 2) / 2
        else:
            i1, i2 = (b.inertia for b in self.balls)
            mean = (i1 * before[0] + i2 * before[1]) / (i1 + i2)
            d = before[0] - before[1]
            self.v = [mean - self.e * i2 * d / (i1 + i2), mean + self.e * i1 * d / (i1 + i2)]
            self.lost += (1 - self.e**2) / 2 * i1 * i2 / (i1 + i2) * d**2
        self.contacts.append((kind, self.t, list(self.x), before, list(self.v)))
        self.signs = [mp.sign(v) for v in self.v]

    def release(self, when):
        """Stay at rest on the wall until `when`."""
        while self.targets and self.targets[0] < when:
            self.t = self.targets.pop(0)
            self.record()
        self.t = when
        self.contacts.append(("release", when, list(self.x), [mp.mpf(0)], [mp.mpf(0)]))

    def record(self):
        energies = [
            b.energy(x, v, self.g) for b, x, v in zip(self.balls, self.x, self.v, strict=True)
        ]
        self.states.append(
            (self.t, list(self.x), list(self.v), energies, self.work, self.damped, self.lost)
        )

    def until(self, times, rest_until=None):
        """Integrate to the last of `times`, recording the state at each."""
        self.targets = [mp.mpf(t) for t in times]
        if rest_until is not None:
            self.release(rest_until)
        stops = sorted(self.drive.starts())
        while self.targets:
            ahead = [s for s in stops if s > self.t]
            limit = min([self.targets[0], *ahead[:1]])
            h = min(self.step, limit - self.t)
            lift = self.drive.acceleration(self.t, self.order)
            parts = [
                b.series(x, v, sign, lift, self.g, self.order)
                for b, x, v, sign in zip(self.balls, self.x, self.v, self.signs, strict=True)
            ]
            event, kind = h, None
            if self.low is not None:
                for name, wall, side in (("bottom", self.low, 1), ("top", self.high, -1)):
                    s = first_root(
                        lambda s, wall=wall, side=side: (
                            side * (self.gap([evaluate(p[0], s) for p in parts]) - wall)
                        ),
                        event,
                    )
                    if s is not None:
                        event, kind = s, name
            for i, b in enumerate(self.balls):
                if b.q or b.f:
                    s = first_root(lambda s, i=i: self.signs[i] * evaluate(parts[i][1], s), event)
                    if s is not None:
                        event, kind = s, ("turn", i)
            if len(self.balls) == 1:
                self.follow_compression(parts[0], lift, event)
            self.x = [evaluate(p[0], event) for p in parts]
            self.v = [evaluate(p[1], event) for p in parts]
            self.work += sum(evaluate(integral(p[2]), event) for p in parts)
            self.damped += sum(evaluate(integral(p[3]), event) for p in parts)
            self.t = limit if kind is None and h == limit - self.t else self.t + event
            if kind in ("bottom", "top"):
                wall = self.low if kind == "bottom" else self.high
                if len(self.balls) == 1:
                    self.x = [wall]
                self.impact(kind)
            elif kind is not None:
                i = kind[1]
                lift0 = self.drive.acceleration(self.t, 2)[0]
                free = -(self.g + lift0) * mp.sin(self.x[i]) * self.balls[i].m
                assert abs(free) > self.balls[i].f, "it sticks"
                self.v[i] = mp.mpf(0)
                self.signs[i] = mp.sign(free)
            if self.t == self.targets[0]:
                self.record()
                self.targets.pop(0)
        return self

    def follow_compression(self, part, lift, event):
        ball = self.balls[0]
        if ball.linear:
            return

        def tension(s):
            return ball.l * evaluate(part[1], s) ** 2 + (self.g + evaluate(lift, s)) * mp.cos(
                evaluate(part[0], s)
            )

        n = 24
        for k in range(n):
            a, b = event * k / n, event * (k + 1) / n
            left, right = tension(a), tension(b)
            if left < 0 and self.compression_first is None:
                self.compression_first = self.t
            if (left < 0) != (right < 0):
                low, high = a, b
                for _ in range(130):
                    middle = (low + high) / 2
                    low, high = (
                        (middle, high) if (tension(middle) < 0) == (left < 0) else (low, middle)
                    )
                if left < 0:
                    self.compression_total += high - a
                else:
                    self.compression_total += b - high
                    if self.compression_first is None:
                        self.compression_first = self.t + high
            elif left < 0:
                self.compression_total += b - a


# --- the cases --------------------------------------------------------------------------------------
ONE = "single pendulum, no contacts"
WALLS = "mirror-symmetric pair with contacts"
TWO = "two independent balls"


def walls_of(length, radius):
    low = mp.asin(mp.mpf(radius) / mp.mpf(length))
    return low, mp.pi - low


def cases():
    """Yield name, description, model, parameters, function of (order, step) that runs it."""

    def one(ball, drive, angle, speed, times, order, step, **options):
        return Run([ball], drive, [angle], [speed], order=order, step=step, **options).until(times)

    def common(ball, drive, angle, speed, times, **more):
        result = {
            "gravity": GRAVITY,
            "length": ball["length"],
            "mass": ball["mass"],
            "damping": ball.get("damping", "0"),
            **drive,
            "initial_angle": angle,
            "initial_angular_velocity": speed,
            "duration": times[-1],
        }
        result.update(more)
        return result

    def case(name, text, model, ball, drive, made, angle, speed, times, radius=None, e="1", **more):
        extra, options = {}, {}
        if radius is not None:
            extra = {"radius": radius, "restitution": e}
            options = {"walls": walls_of(ball["length"], radius), "e": e}
        for key, theirs in (("quadratic", "quadratic_damping"), ("coulomb", "coulomb_damping")):
            if key in ball:
                extra[theirs] = ball[key]
        return (
            name,
            text,
            model,
            common(ball, drive, angle, speed, times, **extra, **more),
            lambda order, step: one(
                Ball(**ball), made(), angle, speed, times, order, step, **options
            ),
        )

    ball = {"length": "1", "mass": "0.8", "damping": "0.02"}
    harmonic = {
        "drive": "harmonic",
        "drive_amplitude": "0.2",
        "drive_frequency": "6.26",
        "drive_phase": "0.3",
    }
    yield case(
        "N01_top_contacts", "both walls are met, e = 0.95", WALLS, ball, harmonic,
        lambda: Harmonic("0.2", "6.26", "0.3"), "0.9", "7", ["1", "2.5", "4", "5"],
        radius="0.1", e="0.95",
    )  # fmt: skip
    # Lift-off: rest at the low wall until A0 w^2 cos(w t + phase) = g.
    amplitude, frequency, phase = "0.25", "8", "3.5"

    def lifted(order, step):
        low, high = walls_of("1", "0.1")
        run = Run(
            [Ball(**ball)], Harmonic(amplitude, frequency, phase), [low], ["0"],
            walls=(low, high), e="0.9", order=order, step=step,
        )  # fmt: skip
        w, a = mp.mpf(frequency), mp.mpf(amplitude)
        when = (2 * mp.pi - mp.acos(mp.mpf(GRAVITY) / (a * w * w)) - mp.mpf(phase)) / w
        run.signs = [mp.mpf(1)]
        return run.until(["0.2", "0.5", "1", "1.5"], rest_until=when)

    yield (
        "N02_lift_off_after_rest", "starts at rest on the low wall; A0 w^2 = 1.63 g", WALLS,
        common(
            ball,
            {"drive": "harmonic", "drive_amplitude": amplitude, "drive_frequency": frequency, "drive_phase": phase},
            "contact_angle_low", "0", ["1.5"], radius="0.1", restitution="0.9",
        ),
        lifted,
    )  # fmt: skip
    for side, guide in ((-1, "below"), (1, "above")):
        yield case(
            f"N03_crank_slider_{guide}", "the paper's motor, lam = 0.2, without walls", ONE,
            {"length": "0.363", "mass": "0.10804", "damping": "0.00274"},
            {"drive": "crank_slider", "drive_amplitude": "0.02", "drive_frequency": "10.09",
             "drive_phase": "0.5", "connecting_rod_length": "0.1", "guide": guide},
            lambda side=side: Crank("0.02", "10.09", "0.1", side, "0.5"), "0.3", "0",
            ["1", "5", "10", "20"],
        )  # fmt: skip
    yield case(
        "N04_crank_slider_walls", "crank slider below, lam = 0.25, e = 0.8", WALLS,
        {"length": "0.245", "mass": "0.10644", "damping": "0.00506"},
        {"drive": "crank_slider", "drive_amplitude": "0.03", "drive_frequency": "15.1",
         "drive_phase": "0", "connecting_rod_length": "0.12", "guide": "below"},
        lambda: Crank("0.03", "15.1", "0.12", -1), "0.8", "0", ["0.7", "1.5", "3"],
        radius="0.02", e="0.8",
    )  # fmt: skip
    yield case(
        "N05_slack", "swings beyond the horizontal: the rod is pushed for a while", ONE,
        {"length": "1", "mass": "0.8", "damping": "0.05"},
        {"drive": "harmonic", "drive_amplitude": "0.05", "drive_frequency": "5", "drive_phase": "0"},
        lambda: Harmonic("0.05", "5"), "0.2", "5.4", ["1", "2", "5", "8"],
    )  # fmt: skip
    yield case(
        "N06_frequency_step", "Fig. 12's step, phase-continuous", WALLS,
        {"length": "0.245", "mass": "0.10644", "damping": "0.00506"},
        {"drive": "frequency_schedule", "drive_amplitude": "0.03", "times": ["0", "2.166"],
         "drive_frequencies": ["19.83", "15.11"], "ramp": "0", "drive_phase": "0"},
        lambda: Swept("0.03", [("0", "19.83", "0"), ("2.166", "15.11", "0")]), "0.4", "0",
        ["1", "2.166", "3", "4"], radius="0.02", e="0.9",
    )  # fmt: skip
    yield case(
        "N07_frequency_ramp", "the step with a ramp of 0.5 s, without walls", ONE,
        {"length": "0.245", "mass": "0.10644", "damping": "0.00506"},
        {"drive": "frequency_schedule", "drive_amplitude": "0.03", "times": ["0", "2"],
         "drive_frequencies": ["19.83", "15.11"], "ramp": "0.5", "drive_phase": "0.2"},
        lambda: Swept("0.03", [("0", "19.83", "0"), ("2", "19.83", mp.mpf("-4.72") / mp.mpf("0.5")),
                               ("2.5", "15.11", "0")], "0.2"),
        "0.4", "0", ["1", "2.25", "3", "6"],
    )  # fmt: skip
    yield case(
        "N08_chirp", "linear sweep through the resonance", ONE,
        {"length": "1", "mass": "0.8", "damping": "0.05"},
        {"drive": "chirp", "drive_amplitude": "0.1", "drive_frequency": "7",
         "drive_frequency_final": "5", "sweep_time": "10", "drive_phase": "0"},
        lambda: Swept("0.1", [("0", "7", "-0.2"), ("10", "5", "0")]), "0.3", "0",
        ["5", "10", "15"],
    )  # fmt: skip
    for name, start, times in (("decay", "0.2", ["10", "40"]), ("growth", "0.001", ["20", "60"])):
        w = "5.9" if name == "decay" else "6.26"
        yield case(
            f"N09_eq14_{name}", "the linear model, Fig. 2 parameters", "linear pendulum (eq14)",
            {"length": "1", "mass": "0.8", "damping": "0.05", "linear": True},
            {"drive": "harmonic", "drive_amplitude": "0.05", "drive_frequency": w, "drive_phase": "0"},
            lambda w=w: Harmonic("0.05", w), start, "0", times,
        )  # fmt: skip
    yield case(
        "N10_quadratic_drag", "linear and quadratic drag through turning points", ONE,
        {"length": "1", "mass": "0.8", "damping": "0.02", "quadratic": "0.05"},
        {"drive": "harmonic", "drive_amplitude": "0.1", "drive_frequency": "6.1", "drive_phase": "0"},
        lambda: Harmonic("0.1", "6.1"), "1.2", "0", ["2", "5", "10"],
    )  # fmt: skip
    yield case(
        "N11_coulomb_drag", "all drags, with walls, e = 0.9", WALLS,
        {"length": "1", "mass": "0.8", "damping": "0.02", "quadratic": "0.02", "coulomb": "0.05"},
        {"drive": "harmonic", "drive_amplitude": "0.15", "drive_frequency": "6.1", "drive_phase": "0"},
        lambda: Harmonic("0.15", "6.1"), "1.2", "0", ["1", "3", "5"], radius="0.1", e="0.9",
    )  # fmt: skip

    right = {"length": "1", "mass": "0.8", "damping": "0.02"}
    left = {"length": "0.95", "mass": "0.5", "damping": "0.03"}
    radii = ("0.1", "0.09")

    def unequal(order, step):
        l1, l2 = mp.mpf(right["length"]), mp.mpf(left["length"])
        reach = sum(map(mp.mpf, radii))
        theta = mp.acos((l1**2 + l2**2 - reach**2) / (2 * l1 * l2))
        run = Run(
            [Ball(**right), Ball(**left)], Harmonic("0.1", "6.5", "0.2"), ["0.7", "-0.5"],
            ["0", "0.3"], walls=(theta, 2 * mp.pi - theta), e="0.85", order=order, step=step,
        )  # fmt: skip
        return run.until(["1", "2", "3"])

    yield (
        "N12_unequal_balls", "unequal masses, lengths, radii and damping, e = 0.85", TWO,
        {"gravity": GRAVITY, "drive": "harmonic", "drive_amplitude": "0.1", "drive_frequency": "6.5",
         "drive_phase": "0.2", "restitution": "0.85", "duration": "3",
         "ball1": {**right, "radius": radii[0], "initial_angle": "0.7", "initial_angular_velocity": "0"},
         "ball2": {**left, "radius": radii[1], "initial_angle": "-0.5", "initial_angular_velocity": "0.3"}},
        unequal,
    )  # fmt: skip


def numbers(run):
    """All stored numbers of a run."""
    result = []
    for t, x, v, energies, work, damped, lost in run.states:
        result += [t, *x, *v, *energies, work, damped, lost]
    for _, t, x, before, after in run.contacts:
        result += [t, *x, *before, *after]
    if run.compression_first is not None:
        result += [run.compression_first, run.compression_total]
    return result


def text(value):
    return mp.nstr(value, 30)


def main():
    out = {
        "_about": {
            "method": "mpmath Taylor series, see make_cases.py; agree_digits compares with another "
            "order and half the step, relative to max(|value|, 1e-3)",
            "units": "SI and radians; angle from the downward vertical",
            "contacts": "rows of kind release have no counterpart among impacts",
        }
    }
    for name, description, model, parameters, make in cases():
        run, check = make(36, "0.03"), make(44, "0.02")
        pairs = list(zip(numbers(run), numbers(check), strict=True))
        worst = max(abs(a - b) / max(abs(b), mp.mpf("1e-3")) for a, b in pairs)
        digits = 33.0 if worst == 0 else float(-mp.log10(worst))
        assert digits > 20, (name, digits)
        entry = {
            "description": description,
            "model": model,
            "parameters": parameters,
            "states": [
                {
                    "time": text(t),
                    "angle": [text(a) for a in x],
                    "angular_velocity": [text(a) for a in v],
                    "energy": [text(a) for a in energies],
                    "drive_work": text(work),
                    "damping_loss": text(damped),
                    "impact_loss": text(lost),
                }
                for t, x, v, energies, work, damped, lost in check.states
            ],
            "contacts": [
                {
                    "time": text(t),
                    "kind": kind,
                    "angle": [text(a) for a in x],
                    "velocity_before": [text(a) for a in before],
                    "velocity_after": [text(a) for a in after],
                }
                for kind, t, x, before, after in check.contacts
            ],
            "agree_digits": round(digits, 1),
        }
        if check.compression_first is not None:
            entry["compression_time"] = text(check.compression_first)
            entry["compression_fraction"] = text(
                check.compression_total / mp.mpf(parameters["duration"])
            )
        out[name] = entry
        print(name, round(digits, 1), len(check.contacts), "contacts", flush=True)
    file = Path(__file__).with_name("cases.json")
    file.write_text(json.dumps(out, indent=1) + "\n")


if __name__ == "__main__":
    main()
