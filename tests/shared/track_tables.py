"""Track tables with known truth: simulated angles with white or correlated noise."""

import numpy as np

import latolato as ll
from latolato.experiment.track_table import track_table

NOISE = 1e-3  # rad
# What a table of a small video says, and the deviation of its pivot's place [pixels].
ARM, PLACE = 330.0, 0.15
PICTURE = {"arm_pixels": ARM, "pivot_offset_x_sigma": PLACE, "pivot_offset_y_sigma": PLACE}


def noise(count, seed, correlation=0.0, size=NOISE):
    """Noise of standard deviation `size`, of first-order autoregression."""
    generator = np.random.default_rng(seed)
    errors = generator.normal(size=count)
    for i in range(1, count):
        fresh = np.sqrt(1.0 - correlation**2) * errors[i]
        errors[i] = correlation * errors[i - 1] + fresh
    return size * errors


def about_pivot(angle, pivot_error):
    """Angles about a pivot that is taken to be right of and above the real one, in pixels."""
    aside, above = np.array(pivot_error) / ARM
    seen = np.arctan2(np.sin(angle) - aside, np.cos(angle) + above)
    return angle + np.remainder(seen - angle + np.pi, 2.0 * np.pi) - np.pi


def decay_table(
    *, length, mass, damping=0.0, angle=0.6, duration=15.0, held=0.0, seed=0, correlation=0.0,
    fps=60.0, size=NOISE, pivot_error=None, **more,
):  # fmt: skip
    """A free decay as a tracker sees it, after `held` seconds in a hand.

    With a `pivot_error` [pixels] the table says how well it knows its pivot.
    """
    system = ll.Pendulum(length=length, mass=mass, damping=damping, **more)
    time = np.arange(0.0, held + duration, 1.0 / fps)
    free = time >= held
    swing = ll.simulate(system, initial_angle=angle, times=time[free] - time[free][0])
    angles = np.concatenate([np.full((~free).sum(), angle), swing.angle.values])
    attributes = {"length": length}
    if pivot_error is not None:
        angles = about_pivot(angles, pivot_error)
        attributes |= PICTURE
    angles = angles + noise(len(time), seed, correlation, size)
    columns = {"time": time, "angle_1": angles, "angle_sigma_1": np.full(len(time), size)}
    return track_table(columns, attributes)


def planar_table(drive, *, duration=20.0, seed=0, correlation=0.0, size=2e-4, **attributes):
    """A pivot that moves as a `PlanarHarmonic`, as a tracker sees it; `size` is the noise in m."""
    time = np.arange(0.0, duration, 1.0 / 60.0)
    (segment,) = drive.segments(duration)
    columns = {"time": time}
    for place, (name, formula) in enumerate((("pivot_x", drive.across), ("pivot_y", drive.height))):
        clean = np.array([formula(t, segment) for t in time])
        columns[name] = clean + noise(len(time), seed + 1000 * place, correlation, size)
    return track_table(columns, attributes)


def drive_table(drive, *, duration=30.0, fps=60.0, seed=0, correlation=0.0, size=2e-4):
    """A pivot that moves as `drive`, as a tracker sees it; `size` is the noise in m."""
    time = np.arange(0.0, duration, 1.0 / fps)
    still = ll.Pendulum(length=1.0, mass=1.0)
    height = ll.simulate(still, drive, initial_angle=0.0, times=time).pivot_height.values
    height = height - height.mean() + noise(len(time), seed, correlation, size)
    return track_table({"time": time, "pivot_x": 0.0 * time, "pivot_y": height})


def motion_table(
    system, drive=None, *, duration=15.0, fps=60.0, seed=0, correlation=0.0, size=NOISE,
    pivot_error=None, **start,
):  # fmt: skip
    """A system's motion as a tracker sees it; of a `LatoLato` both balls.

    With a `pivot_error` [pixels] the table says how well it knows its pivot.
    """
    time = np.arange(0.0, duration, 1.0 / fps)
    run = ll.simulate(system, drive, times=time, **start)
    angles = np.atleast_2d(run.angle.values)
    if isinstance(system, ll.LatoLato):
        angles = np.array([angles[0], -angles[0]])
    attributes = {}
    if pivot_error is not None:
        angles = about_pivot(angles, pivot_error)
        attributes = PICTURE
    columns = {"time": time, "pivot_y": run.pivot_height.values + noise(len(time), seed, 0.0, 2e-4)}
    for ball, angle in enumerate(angles, 1):
        columns[f"angle_{ball}"] = angle + noise(len(time), seed + 1000 * ball, correlation, size)
        columns[f"angle_sigma_{ball}"] = np.full(len(time), size)
    return track_table(columns, attributes)
