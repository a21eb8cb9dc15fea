"""Chaos, and why two balls do not stay mirror images of each other.

Chaos is the growth of tiny differences; its rate is the largest Lyapunov exponent. An impact acts
on differences by its saltation matrix. However wild the motion is, the one-ball model has

    lambda_1 + lambda_2 = -C/(m l) + 2 f ln e,    f impacts per second.

That model takes the left ball for the mirror image of the right one. Two real balls also have a
mean angle S, which impacts leave alone, and which obeys along the mirrored motion

    S'' + C/(m l) S' + (g + y'')/l cos(angle) S = 0.

Where S grows from nothing, the symmetry is lost. Strong shaking does that, and so does a weak one
far below lift-off: two balls at rest against each other swing as *one* pendulum with the gravity
g cos(angle), and shaken at twice its frequency that is parametrically unstable. The one-ball model
shows rest there, and nothing else.

Run it with a file name such as chaos.png to draw the picture as well.
"""

import math
import sys

import numpy as np

import latolato as ll
from latolato.figures import style

TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9)
BALL, ANGLE = TOY.balls[0], TOY.contact_angle_low
PAIR = ll.BallPair(right=BALL, left=BALL, restitution=0.9)
FREQUENCY = 2.0 * TOY.natural_frequency
WEAK = ll.Harmonic(drive_amplitude=0.05, drive_frequency=FREQUENCY)
STRONG = ll.Harmonic(drive_amplitude=0.475, drive_frequency=FREQUENCY)
PERIOD = math.tau / FREQUENCY

# Chaos under strong shaking.
chaos = ll.analysis.lyapunov_spectrum(TOY, STRONG, initial_offset=0.2, duration=1000.0)
largest, smallest = chaos.lyapunov_exponents.values
print(f"exponents {largest:.3f} and {smallest:.3f} per second: {chaos.status.item()}")
print(f"the sum rule is missed by {abs(chaos.sum_rule_residual.item()):.0e}")
amplitudes = np.linspace(0.3, 0.5, 81)
cut = ll.sweep(
    TOY, STRONG, axes={"drive_amplitude": amplitudes}, initial_offset=0.2, duration=600.0,
    transient=200.0, observables=["lyapunov_exponent"],
)  # fmt: skip

# Rest under weak shaking: the pair as one pendulum.
pair = ll.analysis.pair_symmetry(
    TOY, WEAK, initial_offset=0.0, duration=150 * PERIOD, transient=50 * PERIOD
)
pendulum = ll.Pendulum(length=1.0, mass=0.8, damping=0.02, gravity=9.8 * math.cos(ANGLE))
shaken = ll.Harmonic(drive_amplitude=0.05 * math.cos(ANGLE), drive_frequency=FREQUENCY)
expected = ll.analysis.growth_rate(pendulum, shaken).growth_rate.item()
grown = pair.transverse_exponent.item()
print(f"shaken with 0.2 g the pair at rest leaves its symmetry as exp({grown:.6f} t);")
print(f"one pendulum, by Hill's determinant, would grow as exp({expected:.6f} t)")
assert abs(grown - expected) < 1e-6

means = {}
for name, drive, offset in (("at rest, weak", WEAK, 0.0), ("chaotic, strong", STRONG, 0.2)):
    start = (ANGLE + offset + 1e-9, -ANGLE - offset + 1e-9)
    run = ll.simulate(PAIR, drive, initial_angle=start, duration=120.0)
    means[name] = abs(run.angle.mean("ball"))
    lost = run.time.values[np.argmax(means[name].values > 0.01)]
    print(f"{name}: a mean angle of 1e-9 rad has grown to 0.01 rad after {lost:.0f} s")

if len(sys.argv) > 1:
    with style.use_style():
        figure, ((left, right),) = style.new_figure(1, 2, height=2.7)
        left.axhline(0.0, color=style.GREY, lw=style.THIN)
        left.plot(amplitudes, cut.lyapunov_exponent, ".-", ms=3, lw=style.THIN)
        left.set(xlabel="drive amplitude $A_0$ [m]", ylabel="largest Lyapunov exponent [1/s]")
        style.panel_title(left, "a", "chaos sets in (ω/ω0 = 2)")
        for (name, mean), colour in zip(means.items(), (style.BLUE, style.RED), strict=True):
            right.semilogy(mean.time, mean.clip(1e-11), lw=style.THIN, color=colour, label=name)
        right.set(xlabel="time [s]", ylabel="mean angle |S| [rad]")
        right.legend(loc="lower right")
        style.panel_title(right, "b", "two balls leave their mirror images")
        style.save_figure(figure, sys.argv[1])
