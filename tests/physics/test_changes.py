"""Derivatives of laws with respect to parameters, beside differences in many digits."""

from __future__ import annotations

from types import SimpleNamespace

import mpmath
import numpy as np
import pytest

from latolato.physics.damping import (
    drift_quadratic_weights,
    drift_rate_weights,
    effective_time,
    effective_time_slope,
)
from latolato.physics.drives import segment
from latolato.physics.drives.segment import CHANGES, Segment

_WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
_TINY = mpmath.mpf(10) ** -20


def slope(function, width=1e-4):
    """Return the derivative at zero by a central difference of eighth order."""
    ends = ((k, sign) for k in range(1, 5) for sign in (1, -1))
    return sum(s * _WEIGHTS[k - 1] * function(s * k * width) for k, s in ends) / width


@pytest.mark.parametrize("formula", CHANGES)
@pytest.mark.parametrize(
    "form", [segment.STILL, segment.COSINE, segment.SWEPT, segment.CRANK, segment.POLYNOMIAL]
)
def test_the_pivots_motion(form, formula):
    random = np.random.default_rng(int(form))
    names = Segment._fields
    for _ in range(30):
        p = dict(zip(names, random.uniform(-1.0, 1.0, len(names)), strict=True))
        p |= {"form": form, "side": random.choice([-1.0, 1.0])}
        p |= {"rod": random.uniform(3.0, 5.0), "frequency": random.uniform(1.0, 5.0)}
        d = dict(zip(names, random.uniform(-1.0, 1.0, len(names)), strict=True))
        d |= {"form": 0.0, "side": 0.0}
        t = random.uniform(0.0, 2.0)

        def moved(e, p=p, d=d, t=t):
            return formula(t, SimpleNamespace(**{name: p[name] + e * d[name] for name in names}))

        found = CHANGES[formula](t, SimpleNamespace(**p), SimpleNamespace(**d))
        assert found == pytest.approx(slope(moved), rel=1e-9, abs=1e-9)


def test_an_earlier_start_is_a_later_time():
    p = Segment(form=segment.COSINE, frequency=3.0, phase=0.4, c0=0.2)
    earlier = Segment(start=-1.0)
    wanted = slope(lambda e: segment.pivot_acceleration(0.7 + e, p))
    assert segment.pivot_acceleration_change(0.7, p, earlier) == pytest.approx(wanted, rel=1e-10)


@pytest.mark.parametrize("rate", [0.0, 1e-9, 1e-3, 0.1, 3.0])
@pytest.mark.parametrize("quadratic", [0.0, 1e-8, 1e-3, 0.3, 2.0])
def test_a_drift_under_drag(rate, quadratic):
    random = np.random.default_rng(1)
    body = SimpleNamespace(damping_rate=rate, quadratic=quadratic)
    for _ in range(20):
        change = SimpleNamespace(
            damping_rate=random.uniform(-1.0, 1.0), quadratic=random.uniform(-1.0, 1.0)
        )
        sign = random.choice([-1.0, 1.0])
        velocity, interval = sign * random.uniform(0.0, 5.0), random.uniform(-0.04, 0.2)

        def drifted(e, change=change, sign=sign, velocity=velocity, interval=interval):
            c1 = mpmath.mpf(rate) + e * change.damping_rate
            c2 = mpmath.mpf(quadratic) + e * change.quadratic
            time = (1 - mpmath.exp(-c1 * interval)) / c1
            grown = 1 + c2 * sign * velocity * time
            return mpmath.log(grown) / (c2 * sign), velocity * (1 - c1 * time) / grown

        with mpmath.workdps(60):
            above, below = drifted(_TINY), drifted(-_TINY)
            wanted = [float((a - b) / (2 * _TINY)) for a, b in zip(above, below, strict=True)]
        time, time_slope = effective_time(rate, interval), effective_time_slope(rate, interval)
        weights = np.column_stack([
            drift_rate_weights(velocity, sign, time, time_slope, body),
            drift_quadratic_weights(velocity, sign, time, body),
        ])  # fmt: skip
        found = weights @ [change.damping_rate, change.quadratic]
        assert found == pytest.approx(wanted, rel=1e-11, abs=1e-14)
