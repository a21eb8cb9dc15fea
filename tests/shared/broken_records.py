"""Free swings with a planted break: what goes wrong with clocks, films, units and angles."""

from dataclasses import dataclass

import numpy as np

import latolato as ll
from latolato.experiment.track_table import track_table
from track_tables import PICTURE, about_pivot, noise


@dataclass(frozen=True)
class Record:
    """A track table with what is true of its pendulum, and what was done to it."""

    kind: str
    size: float
    table: object
    length: float
    decay_rate: float
    mass: float = 0.1
    breaks: bool = True


class _Maker:
    """One random pendulum and its camera."""

    def __init__(self, random):
        self.random = random
        self.length = random.uniform(0.2, 1.5)
        self.rate = np.exp(random.uniform(np.log(0.004), np.log(0.06)))
        self.mass = 0.1
        self.angle = np.exp(random.uniform(np.log(0.1), np.log(1.2)))
        self.fps = float(random.choice([15.0, 24.0, 30.0, 30.0, 60.0]))
        period = 2.0 * np.pi * np.sqrt(self.length / 9.8)
        self.duration = period * random.uniform(10.0, 30.0)
        self.noise = np.exp(random.uniform(np.log(2e-4), np.log(3e-3)))
        self.correlation = float(random.choice([0.0, 0.0, 0.5, 0.8]))
        self.systematic = float(random.choice([0.0, 1e-4]))

    def times(self):
        return np.arange(0.0, self.duration, 1.0 / self.fps)

    def system(self, rate=None, **more):
        damping = 2.0 * (self.rate if rate is None else rate) * self.mass * self.length
        return ll.Pendulum(length=self.length, mass=self.mass, damping=damping, **more)

    def swing(self, times, rate=None, start=None, **more):
        start = start or {"initial_angle": self.angle}
        late = np.maximum(times - times[0], 0.0)
        return ll.simulate(self.system(rate, **more), times=late, **start)

    def seen(self, angle):
        """Angles with noise, and with what a tracker bends them by twice a swing."""
        errors = noise(len(angle), self.random.integers(1 << 30), self.correlation, self.noise)
        bent = self.systematic * np.sin(3.0 * angle / max(np.max(np.abs(angle)), 1e-9))
        return angle + errors + bent

    def record(self, kind, size, times, angle, **more):
        attributes = more.pop("attributes", {})
        sigma = np.full(len(times), self.noise)
        table = track_table({"time": times, "angle_1": angle, "angle_sigma_1": sigma}, attributes)
        return Record(kind, size, table, self.length, self.rate, self.mass, **more)

    # One method for each kind of record.

    def clean(self):
        times = self.times()
        return self.record("clean", 0.0, times, self.seen(self.swing(times).angle.values),
                           breaks=False)  # fmt: skip

    def placed(self):
        times = self.times()
        error = self.random.normal(scale=0.15, size=2)
        angle = self.seen(about_pivot(self.swing(times).angle.values, error))
        return self.record("pivot beside", 0.0, times, angle, attributes=PICTURE, breaks=False)

    def unix(self):
        times = self.times()
        angle = self.seen(self.swing(times).angle.values)
        return self.record("Unix clock", 0.0, times + 1.7e9, angle, breaks=False)

    def offset(self):
        times = self.times()
        size = self.random.uniform(0.5, 1.5) * self.angle
        angle = self.seen(self.swing(times).angle.values) + size
        return self.record("offset", size, times, angle, breaks=False)

    def few(self):
        period = 2.0 * np.pi * np.sqrt(self.length / 9.8)
        size = self.random.uniform(3.2, 9.0)
        times = np.arange(0.0, self.duration, period / size)
        angle = self.seen(self.swing(times).angle.values)
        return self.record("few samples", size, times, angle, breaks=False)

    def gap(self):
        times = self.times()
        angle = self.seen(self.swing(times).angle.values)
        size = self.random.uniform(0.05, 0.7)
        first = self.random.uniform(0.12, 0.88 - size)
        kept = (times < first * self.duration) | (times > (first + size) * self.duration)
        return self.record("gap", size, times[kept], angle[kept], breaks=False)

    def grows(self):
        times = self.times()
        size = self.random.uniform(0.3, 1.5) / self.duration
        self.angle *= 0.4
        # Backwards, a swing that decays grows.
        run = self.swing(times, rate=size)
        self.rate = -size
        return self.record("growing", size, times, self.seen(run.angle.values[::-1]), breaks=False)

    def no_drag(self):
        self.rate = 0.0
        times = self.times()
        angle = self.seen(self.swing(times).angle.values)
        return self.record("no drag", 0.0, times, angle, breaks=False)

    def pause(self):
        size = np.exp(self.random.uniform(np.log(0.1), np.log(6.0)))
        at = self._somewhere()
        times = self.times()
        true = np.where(times > at, times + size, times)
        return self.record("pause", size, times, self.seen(self.swing(true).angle.values))

    def pace(self):
        size = float(self.random.choice([0.25, 0.5, 0.9, 0.97, 1.03, 1.1, 2.0, 4.0]))
        at = self._somewhere()
        until = self.random.choice([self.duration, at + 0.25 * self.duration])
        times = self.times()
        speed = np.where((times > at) & (times < until), size, 1.0)
        true = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) / self.fps)])
        return self.record("pace", size, times, self.seen(self.swing(true).angle.values))

    def drag(self):
        size = float(self.random.choice([2.0, 4.0, 8.0]))
        at = self._somewhere()
        times = self.times()
        late = times > at
        early = self.swing(times[~late])
        state = {
            "initial_angle": float(early.angle.values[-1]),
            "initial_angular_velocity": float(early.angular_velocity.values[-1]),
        }
        after = self.swing(times[np.flatnonzero(late)[0] - 1 :], rate=size * self.rate, start=state)
        angle = np.concatenate([early.angle.values, after.angle.values[1:]])
        return self.record("drag", size, times, self.seen(angle))

    def films(self):
        at = self._somewhere()
        times = self.times()
        late = times > at
        size = self.random.uniform(0.3, 1.6)
        start = {
            "initial_angle": self.angle * size,
            "initial_angular_velocity": float(self.random.normal()) * self.angle,
        }
        angle = np.concatenate(
            [
                self.swing(times[~late]).angle.values,
                self.swing(times[late], start=start).angle.values,
            ]
        )
        return self.record("two films", size, times, self.seen(angle))

    def turn(self):
        size = float(self.random.choice([np.pi, 2.0 * np.pi]))
        at = self._somewhere()
        until = self.random.choice([self.duration + 1.0, at + 0.3 * self.duration])
        times = self.times()
        angle = self.seen(self.swing(times).angle.values)
        return self.record("turn", size, times, angle + size * ((times > at) & (times < until)))

    def unit(self):
        self.angle = self.random.uniform(0.4, 1.2)
        self.rate = max(self.rate, 0.6 / self.duration)
        times = self.times()
        angle = self.seen(self.swing(times).angle.values)
        return self.record("unit", 0.0, times, np.radians(angle))

    def law(self):
        size = self.random.uniform(0.5, 2.0)
        self.angle = self.random.uniform(0.3, 1.2)
        period = 2.0 * np.pi * np.sqrt(self.length / 9.8)
        # Of a swing of this size a rate of `size` in the record.
        quadratic = size * 2.0 * self.mass * self.length / self.duration / (
            self.angle * 2.0 * np.pi / period)  # fmt: skip
        self.rate = np.nan
        times = self.times()
        angle = self.swing(times, rate=0.0, quadratic_damping=quadratic * 1.2).angle.values
        return self.record("drag law", size, times, self.seen(angle))

    def repeated(self):
        size = self.random.uniform(0.03, 0.3)
        times = self.times()
        angle = self.seen(self.swing(times).angle.values)
        for i in np.flatnonzero(self.random.uniform(size=len(times)) < size):
            angle[i] = angle[max(i - 1, 0)]
        return self.record("repeated frames", size, times, angle, breaks=False)

    def _somewhere(self):
        return self.random.uniform(0.25, 0.75) * self.duration


WHOLE = ("clean", "placed", "unix", "offset", "few", "gap", "grows", "no_drag", "repeated")
BROKEN = ("pause", "pace", "drag", "films", "turn", "unit", "law")


def make_record(kind, seed):
    """One random record of a kind; the same for the same seed."""
    return getattr(_Maker(np.random.default_rng([seed, *kind.encode()])), kind)()
