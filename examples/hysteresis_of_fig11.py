"""Hysteresis of Fig. 11: one drive, two answers, and where the jump between them is.

A pendulum is slower the further it swings, so between its walls the toy bounces in step with a
*slower* drive on a *wider* path: the branch of periodic bouncing leans to the left (softening). It
cannot lean for ever. At a fold the stable motion meets an unstable one and both vanish; a toy that
is led there by lowering the frequency has to jump, and comes to rest. On the way up rest lasts
until lift-off, A0 w^2 > g. Between fold and lift-off the answer depends on the past: hysteresis.

`continue_orbit` follows the branch by solving for periodic motions, stable or not, and turns round
the fold; at the fold a Floquet multiplier is one. `hysteresis` knows nothing of branches: it sweeps
the frequency in small steps like an experimenter. Both must agree on the jump downwards. The fold
moves left as the drive gets stronger, so the loop becomes wider.

Lengths and damping are the paper's (Fig. 10); radius and restitution are assumed.
Run it with a file name such as loop.png to draw the picture as well.
"""

import sys

import numpy as np

import latolato as ll
from latolato.figures import style

TOY = ll.LatoLato(length=0.245, mass=0.10644, radius=0.0196, damping=0.00506, restitution=0.9)
AMPLITUDES = (0.02, 0.03, 0.04)  # A0 [m]
STEP = 0.02  # of the frequency ratio in the sweeps


def drive(amplitude):
    """Return a cosine; its frequency is the one from which a branch is followed."""
    frequency = 3.5 * TOY.natural_frequency
    return ll.Harmonic(drive_amplitude=amplitude, drive_frequency=frequency)


branches = [
    ll.analysis.continue_orbit(
        TOY, drive(amplitude), low=1.0, high=3.8, direction="down", points=500,
        initial_angle=0.3, initial_angular_velocity=1.0,
    )
    for amplitude in AMPLITUDES
]  # fmt: skip
sweeps = ll.analysis.hysteresis(
    TOY, drive(0.03), drive_amplitude=AMPLITUDES, duration=40.0, least_jump=0.03,
    frequency_ratio=np.arange(1.0, 4.21, STEP),
)  # fmt: skip

folds = []
for amplitude, branch in zip(AMPLITUDES, branches, strict=True):
    fold = branch.special_value.values[branch.special_kind.values == "fold"][0]
    up, down = sweeps.jump_ratio.sel(drive_amplitude=amplitude).values
    folds.append(fold)
    lift_off = np.sqrt(0.245 / amplitude)
    print(f"A0 = {1e3 * amplitude:.0f} mm: fold at w/w0 = {fold:.4f}, lift-off at {lift_off:.4f};")
    print(f"    the sweeps jump down at {down:.2f} and rise at {up:.2f}")
    assert abs(down - fold) < STEP, "the sweep jumps within one step of the fold"
slope = (folds[-1] - folds[0]) / (AMPLITUDES[-1] - AMPLITUDES[0])
print(f"The fold moves by {1e-3 * slope:.3f} natural frequencies for each mm of amplitude.")

if len(sys.argv) > 1:
    with style.use_style():
        figure, (panels,) = style.new_figure(1, 3, height=2.7, sharey=True)
        for panel, letter, amplitude, branch in zip(
            panels, "abc", AMPLITUDES, branches, strict=True
        ):
            for way, colour in (("up", style.BLUE), ("down", style.ORANGE)):
                swept = np.degrees(
                    sweeps.largest_angle.sel(drive_amplitude=amplitude, direction=way)
                )
                panel.plot(
                    swept.frequency_ratio, swept, "o", ms=3, color=colour, label=f"sweep {way}"
                )
            x, y = branch.frequency_ratio, np.degrees(branch.largest_angle)
            panel.plot(x, y.where(branch.is_stable == 1), color=style.INK, label="stable")
            panel.plot(x, y.where(branch.is_stable == 0), ":", color=style.INK, label="unstable")
            panel.set(xlabel="frequency ratio $\\omega/\\omega_0$")
            style.panel_title(panel, letter, f"$A_0$ = {1e3 * amplitude:.0f} mm")
        panels[0].set(ylabel="largest angle [°]")
        panels[0].legend()
        style.save_figure(figure, sys.argv[1])
