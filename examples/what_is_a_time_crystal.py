"""What a time crystal is, and what of one a single toy can show.

A drive of period T makes the world the same again after T. A discrete time crystal answers with a
longer period, mostly 2T: it chooses one of two phases, as a magnet chooses up or down. Measured
once per drive period its angle flips sign, so Z = <(-1)^n angle(nT)> is not zero and opposite for
the two choices; and its spectrum has a sharp line at half the driving frequency, whatever the
detuning: it is *locked*.

The driven pendulum does all this: parametric resonance is period doubling. The colliding pair
mostly does not: it bounces once per drive period. Noise makes the pendulum slip from one phase to
the other, after a mean lifetime that falls steeply with the strength of the noise.

That is all that one toy can show, and Faraday saw it in 1831. A time crystal is a *phase of many
coupled units*: its locking is rigid against a change of any unit, and its lifetime grows without
bound with their number. One toy has no number of units to grow. Period doubling: yes. Time crystal:
no.

Run it with a file name such as crystal.png to draw the picture as well.
"""

import sys

import numpy as np

import latolato as ll
from latolato.figures import style

PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9)
DRIVE = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)
KICKS = (0.2, 0.25, 0.3, 0.35, 0.4)  # rad/s^(3/2)

# Two phases to choose from, and a line that stays at one half.
signs = [
    ll.analysis.time_crystal(PENDULUM, DRIVE, initial_angle=angle).order_parameter.item()
    for angle in (0.1, -0.1)
]
print(f"started on either side the pendulum has Z = {signs[0]:+.4f} and {signs[1]:+.4f} rad")
ratios = np.linspace(1.85, 2.15, 25)
tuned = ll.analysis.time_crystal(
    PENDULUM, DRIVE, frequency_ratio=ratios, transient_periods=400
).squeeze()
locked = tuned.status.values == "locked"
place = tuned.peak_frequency.values[locked]
print(f"tuned from w/w0 = {ratios[locked][0]:.3f} to {ratios[locked][-1]:.3f} it stays locked:")
print(f"the line is between {place.min():.6f} and {place.max():.6f} driving frequencies")
assert abs(place - 0.5).max() < 1e-4

# The colliding pair over its map.
toy = ll.analysis.response_period_map(
    TOY, drive_amplitude=np.linspace(0.02, 0.5, 25), frequency_ratio=np.linspace(0.2, 5.0, 25),
    initial_offset=0.05,
)  # fmt: skip
for motion in ("period 1", "period 2", "aperiodic"):
    share = toy.active_share.sel(motion=motion).item()
    print(f"the colliding pair, where it moves: {100 * share:.0f} % {motion}")

# Noise makes the phase slip.
life = []
for kick in KICKS:
    found = ll.analysis.time_crystal(
        PENDULUM, DRIVE, noise_strength=kick, trajectories=64, periods=400
    ).squeeze()
    life.append((found.lifetime.item(), found.lifetime_low.item(), found.lifetime_high.item()))
    print(f"kicks of {kick} rad/s^(3/2): the phase lives {life[-1][0]:.0f} s")

if len(sys.argv) > 1:
    with style.use_style():
        figure, ((left, right),) = style.new_figure(1, 2, height=2.7)
        left.plot(ratios[locked], place, "o", ms=3, label="the answer")
        left.plot(ratios, 1.0 / ratios, color=style.GREY, label="small free swings")
        left.set(xlabel="frequency ratio ω/ω0", ylabel="frequency over that of the drive")
        left.legend()
        style.panel_title(left, "a", "the line does not follow the detuning")
        mean, low, high = np.transpose(life)
        right.errorbar(KICKS, mean, yerr=(mean - low, high - mean), fmt="o", ms=3)
        right.set(xlabel="strength of the kicks [rad/s³ᐟ²]", ylabel="lifetime of the phase [s]")
        right.set(yscale="log", ylim=(20, 1000), xlim=(0.18, 0.42))
        style.panel_title(right, "b", "noise makes the phase slip")
        style.save_figure(figure, sys.argv[1])
