"""The systems and drives whose parameters the paper prints, each typed once.

Where the paper leaves a parameter open, the value here is marked as assumed.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypedDict

from latolato import Harmonic, LatoLato, Mathieu, Pendulum

if TYPE_CHECKING:
    from latolato.physics.pendulum import OneBall

# Captions of Figs. 2, 3ab and 13.
PENDULUM = Pendulum(length=1.0, mass=0.8, damping=0.05)
UNDAMPED = Pendulum(length=1.0, mass=0.8, damping=0.0)
LINEAR = Mathieu(length=1.0, mass=0.8, damping=0.05)
LINEAR_UNDAMPED = Mathieu(length=1.0, mass=0.8, damping=0.0)
DRIVE = Harmonic(drive_amplitude=0.05, drive_frequency=6.26)
SMALL_ANGLE = 0.001  # rad, the start of these figures
RESONANT_FREQUENCY = 6.0  # rad/s, Fig. 3a
QUIET_FREQUENCY = 5.9  # rad/s, Fig. 3b
PRINTED_EDGE = 1.92  # w/w0, text after Fig. 3

# Captions of Figs. 4 and 6.
TOY = LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.1)
STRONG_DRIVE = Harmonic(drive_amplitude=0.2, drive_frequency=6.26)
WEAK_DRIVE = Harmonic(drive_amplitude=0.02, drive_frequency=6.26)
# Paper: starts at rest on the wall, where nothing would ever move; a push is assumed.
PUSH = 0.2  # rad above the low contact angle

# The sweeps of Figs. 3cd and 5: the largest ratios, and the length of a run.
LARGEST_AMPLITUDE_RATIO = 0.5
LARGEST_FREQUENCY_RATIO = 5.0
SWEEP_DURATION = 300.0  # s

# Single-pendulum experiment: text and captions of Figs. 7 and 8.
SINGLE = Pendulum(length=0.3630, mass=0.10804, damping=0.00274)
SINGLE_FREQUENCY = 10.09  # rad/s
SINGLE_AMPLITUDE = 0.015  # m, assumed: not printed
SINGLE_START = math.radians(1.0)  # rad, assumed: not printed

# Colliding-pair experiment: text and captions of Figs. 10 and 12.
ONE_BALL = Pendulum(length=0.2450, mass=0.10644, damping=0.00506)  # the other is parked aside
COUPLED = LatoLato(
    length=ONE_BALL.length,
    mass=ONE_BALL.mass,
    damping=ONE_BALL.damping,
    radius=0.08 * ONE_BALL.length,  # assumed: not printed
    restitution=0.9,  # assumed: not printed
)
PEAK_RATIOS = (2.2, 2.6)  # w/w0, between which the curves of Fig. 11 peak; shaded there
STAGE_RATIOS = (3.136, 2.389)  # w/w0
SWITCH_TIME = 4.166  # s
LONGEST_RAMP = 0.5  # s, the paper's bound
COUPLED_AMPLITUDE = 0.030  # m, assumed: not printed


# The assumed values above in words, for captions.
PUSH_WORDS = f"{PUSH:g} rad above the contact angle"
COUPLED_WORDS = (
    f"A0 = {1e3 * COUPLED_AMPLITUDE:g} mm, r/l = {COUPLED.radius / COUPLED.length:g} and e = "
    f"{COUPLED.restitution:g}"
)


class Body(TypedDict):
    """The parameters of a pendulum that the closed forms take."""

    length: float
    mass: float
    damping: float


def body(system: OneBall) -> Body:
    """Return length [m], mass [kg] and damping [kg m/s] of a system."""
    return {"length": system.length, "mass": system.mass, "damping": system.damping}
