"""Why the toy needs a push.

Two balls hang from one pivot and lean on each other. Shaking the pivot with y = A0 cos(w t) changes
gravity to g - A0 w^2 cos(w t) in its frame. As long as this stays positive it only presses the
balls together, now harder, now softer. So balls at rest stay at rest for ever, unless

    A0 w^2 > g,    that is    w/w0 > sqrt(l/A0).

`self_start` gives this amplitude; with `check=True` it also finds it by trying runs. Below it the
same shaking can keep a swing alive that is there already: one drive, two answers. The starts that
lead to swinging are its basin, and the first push is what brings a ball at rest into it. It shrinks
towards the lift-off frequency and is gone a little above it: just above, the balls only hop.

Run it with a file name such as push.png to draw the picture as well.
"""

import sys

import numpy as np
from matplotlib.colors import ListedColormap

import latolato as ll
from latolato.figures import style

TOY = ll.LatoLato(length=0.245, mass=0.10644, radius=0.0196, damping=0.00506, restitution=0.9)
AMPLITUDE = 0.03  # A0 [m]
RATIO = 2.0  # drive frequency over natural frequency
DRIVE = ll.Harmonic(drive_amplitude=AMPLITUDE, drive_frequency=RATIO * TOY.natural_frequency)

# The rule, beside what runs say.
rule = ll.analysis.self_start(TOY, RATIO, check=True)
needed, tried = rule.drive_amplitude.item(), rule.simulated_amplitude.item()
lift_off = np.sqrt(0.245 / AMPLITUDE)
print(f"At w/w0 = {RATIO} balls at rest lift off from A0 = {1e3 * needed:.4f} mm on,")
print(f"in runs from {1e3 * tried:.4f} mm. With 30 mm they lift off above w/w0 = {lift_off:.3f}.")
assert abs(tried / needed - 1.0) < 1e-9

# How hard a ball at rest must be pushed.
ratios = np.linspace(1.8, 3.4, 17)
push = ll.analysis.first_push(TOY, DRIVE, frequency_ratio=ratios, scan_points=40).squeeze()
for ratio, speed, status in zip(ratios, push.first_push.values, push.status.values, strict=True):
    print(f"  w/w0 = {ratio:.1f}: {speed:4.2f} rad/s ({status})")

# Where all starts lead, at one frequency.
basins = ll.analysis.basins(TOY, DRIVE, angle_points=80, velocity_points=80)
rests = basins.status.values == "rest"
share = basins.basin_fraction.values[rests].sum()
print(
    f"At w/w0 = {RATIO} {100 * share:.1f} % of the starts come to rest, all others keep swinging."
)

if len(sys.argv) > 1:
    with style.use_style():
        figure, ((left, right),) = style.new_figure(1, 2, height=2.9)
        left.plot(ratios, push.first_push, "o-", ms=3, clip_on=False)
        left.axvline(lift_off, color=style.RED, ls="--", label="lift-off")
        left.set(xlabel="frequency ratio $\\omega/\\omega_0$", ylabel="first push [rad/s]", ylim=0)
        left.legend(loc="upper right")
        style.panel_title(left, "a", "how hard to push balls at rest")
        right.pcolormesh(
            np.degrees(basins.initial_angle),
            basins.initial_angular_velocity,
            np.isin(basins.basin, np.flatnonzero(rests)).T,
            cmap=ListedColormap([style.PALE_BLUE, style.BLUE]),
            rasterized=True,
        )
        right.set(xlabel="initial angle [°]", ylabel="initial angular velocity [rad/s]")
        style.panel_title(right, "b", f"starts that come to rest (dark), ω/ω0 = {RATIO}")
        style.save_figure(figure, sys.argv[1])
