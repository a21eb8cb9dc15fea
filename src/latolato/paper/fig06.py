"""Fig. 6: where the energy of the colliding pair comes from and goes to."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from latolato import Harmonic
from latolato.figures import style
from latolato.paper import systems as paper
from latolato.paper.cases import SAMPLES_PER_PERIOD, instants, stack
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "The energy of one ball of the pair"
CAPTION = (
    "Energies and powers per ball (the pair has twice these), driving amplitude 0.2 m, started "
    "with a push. (a) Power of the drive, dissipated power, and total energy. (b) Kinetic, "
    "potential and total energy; the inset enlarges the dissipated power."
)
DURATION = 20.0  # s
PUSHED, REST, SHORT = "pushed", "rest", "short"
KEPT = (
    "angle",
    "kinetic_energy",
    "potential_energy",
    "total_energy",
    "drive_power",
    "damping_power",
    "drive_work",
    "damping_loss",
    "impact_loss",
)
# A toy of a quarter of the length that moves alike, twice as fast.
SCALE = 0.25


def data(quick: bool = False) -> xr.Dataset:
    """Return energies and powers with a push, from rest, and of a shorter toy that moves alike."""
    from latolato import simulate

    toy, drive = paper.TOY, paper.STRONG_DRIVE
    times = instants(DURATION, drive.drive_frequency, per_period=2 * SAMPLES_PER_PERIOD)
    faster = SCALE**-0.5
    short = replace(
        toy,
        length=SCALE * toy.length,
        radius=SCALE * toy.radius,
        damping=SCALE * faster * toy.damping,  # the same C/(m l w0)
    )
    short_drive = Harmonic(
        drive_amplitude=SCALE * drive.drive_amplitude,
        drive_frequency=faster * drive.drive_frequency,
    )
    runs = {
        PUSHED: simulate(toy, drive, initial_offset=paper.PUSH, times=times),
        REST: simulate(toy, drive, initial_offset=0.0, times=times),
        SHORT: simulate(short, short_drive, initial_offset=paper.PUSH, times=times),
    }
    return stack(runs, title=TITLE, keep=KEPT)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 6's statements need."""
    toy = paper.TOY
    run = dataset.sel(case=PUSHED)
    period = slice(None, None, 2 * SAMPLES_PER_PERIOD)
    work = np.diff(run.drive_work.values[period])
    change = np.diff(run.total_energy.values[period])
    loss = np.diff(run.damping_loss.values[period])
    kinetic, potential, total = (
        run[name].values for name in ("kinetic_energy", "potential_energy", "total_energy")
    )
    scale = toy.mass * toy.gravity * toy.length
    mean_input = float(np.abs(run.drive_power).mean())
    mean_damping = float(run.damping_power.mean())
    ratio, ratio_short = (
        float(part.drive_power.max() / part.total_energy.max())
        for part in (_first(run, 1.0), _first(dataset.sel(case=SHORT), SCALE**0.5))
    )
    return {
        "work_rest": float(np.abs(dataset.drive_work.sel(case=REST)).max()),
        "same_sign": float(np.mean(np.sign(work) == np.sign(change))),
        "residual": float(run.energy_residual / run.largest_energy),
        "loss_share": float(loss.sum() / np.abs(work).sum()),
        "mean_input": mean_input,
        "mean_damping": mean_damping,
        "power_ratio": mean_input / mean_damping,
        "excess": float(max(np.max(kinetic - total), np.max(potential - total))),
        # eq2's U is lower by m g l, and so is its E.
        "excess_eq2": float(np.max(kinetic - (total - scale))),
        "touch_potential": float(np.min((total - potential) / total)),
        "peak_ratio": ratio,
        "peak_ratio_short": ratio_short,
        "peak_ratio_change": ratio_short / ratio,
    }


def _first(run: xr.Dataset, scale: float) -> xr.Dataset:
    """Return the first half of the shown time, in the toy's own time scale.

    Later the chaotic motion no longer stays alike: it amplifies rounding errors.
    """
    return run.sel(time=slice(0.0, 0.5 * scale * DURATION))


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) and (b)."""
    figure, axes = style.new_figure(2, 1, sharex=True, height=4.8)
    (a,), (b,) = axes
    run = dataset.sel(case=PUSHED)
    time = run.time.values
    a.plot(time, run.drive_power, color=style.ORANGE, lw=0.8, label=_named(run.drive_power))
    a.plot(time, run.damping_power, color=style.RED, lw=0.8, label=_named(run.damping_power))
    a.plot(time, run.total_energy, color=style.INK, lw=style.LINE, label=_named(run.total_energy))
    a.set_ylabel("power [W], energy [J]")
    style.panel_title(a, "a", "powers and total energy of one ball")
    b.plot(time, run.kinetic_energy, color=style.RED, lw=0.7, label=_named(run.kinetic_energy))
    b.plot(time, run.potential_energy, color=style.BLUE, lw=0.7, label=_named(run.potential_energy))
    b.plot(time, run.total_energy, color=style.INK, lw=style.LINE, label=_named(run.total_energy))
    b.set_ylabel("energy [J]")
    top = float(run.total_energy.max())
    b.set_ylim(0.0, 1.75 * top)
    b.set_xlim(0.0, DURATION)
    b.set_xlabel(style.label(dataset.time))
    style.panel_title(b, "b", "energies of one ball")
    for panel in (a, b):  # above the panel, where it hides nothing
        panel.legend(**style.ABOVE, ncols=3, columnspacing=1.2, borderpad=0.0)
    inset = b.inset_axes((0.62, 0.63, 0.37, 0.36))
    inset.plot(time, run.damping_power, color=style.RED, lw=style.THIN)
    inset.set_xlim(0.0, DURATION)
    inset.set_ylim(bottom=0.0)
    inset.set_ylabel(style.label(run.damping_power, short=True), fontsize=style.SMALL)
    return figure


def _named(variable: xr.DataArray) -> str:
    """Return a legend entry, e.g. ``kinetic energy $T$``."""
    name = str(variable.attrs["long_name"]).removesuffix(", per ball").split(" in the ")[0]
    return f"{name.split(' above ')[0]} ${variable.attrs['symbol']}$"
