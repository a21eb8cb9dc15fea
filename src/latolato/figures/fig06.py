"""Fig. 6: where the energy of the colliding pair comes from and goes to."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import paper, style
from latolato.figures.cases import SAMPLES_PER_PERIOD, instants, stack
from latolato.figures.claim import Limit, Numbers, Statement
from latolato.physics.drives import Harmonic

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

_PUSHED = f"The pair starts at rest {paper.PUSH_WORDS}; as printed all powers vanish."

STATEMENTS = (
    Statement(
        name="power-decides-trend",
        where="Fig. 6a and text",
        words=(
            "When the input power predominantly resides in the positive regime, the total energy "
            "demonstrates an increasing trend"
        ),
        printed=(Limit("work_rest", "work of the drive from rest", low=1e-6, unit="J"),),
        assumed=(
            Limit(
                "same_sign",
                "share of drive periods in which net work and change of energy have one sign",
                low=0.9,
            ),
        ),
        assumption=_PUSHED,
        finding=(
            "In Fig. 6 the energy changes in the direction of the drive's work in {same_sign:.0%} "
            "of the drive periods."
        ),
        why=(
            "Change of energy = work - losses: the ledger closes to {residual:.0e} of the largest "
            "energy, and damping takes {loss_share:.1%} of the work's turnover."
        ),
    ),
    Statement(
        name="small-dissipation",
        where="Fig. 6 and text",
        words="the input power's substantial magnitude advantage over the … dissipative power",
        printed=(Limit("work_rest", "work of the drive from rest", low=1e-6, unit="J"),),
        assumed=(Limit("power_ratio", "mean |input power| over mean dissipated power", low=10.0),),
        assumption=_PUSHED,
        finding=(
            "In Fig. 6 the mean magnitudes of the drive's power and of the damping's power are "
            "{mean_input:.2f} W and {mean_damping:.3f} W, a factor of {power_ratio:.0f}."
        ),
        why="C l θ'² is small beside m l A0 ω² |θ' sin θ| once the swing is large.",
    ),
    Statement(
        name="envelope-of-energies",
        where="Fig. 6b and text",
        words=(
            "the total energy curve also serves as the envelope for both kinetic and potential "
            "energy"
        ),
        printed=(
            Limit(
                "excess_eq2",
                "largest excess of kinetic over total energy with eq2's U",
                high=1e-9,
                unit="J",
            ),
        ),
        assumed=(
            Limit("excess", "largest excess of T or U over E", high=1e-9, unit="J"),
            Limit("touch_potential", "smallest (E - U)/E of the swings", high=1e-3),
        ),
        assumption=(
            "U = m g l (1 - cos θ) is meant, counted from the lowest point, and a push as in the "
            "other claims."
        ),
        finding=(
            "In Fig. 6 the total energy is never below T or U if U is counted from the lowest "
            "point; with eq2's U = -m g l cos θ the kinetic energy would exceed it by up to "
            "{excess_eq2:.2f} J."
        ),
        why="Both parts must be positive for their sum to be an envelope: eq2 makes U negative.",
    ),
    Statement(
        name="envelope-of-power",
        where="Fig. 6a and text",
        words=(
            "the total energy curve effectively approximates the envelope of the input power curve"
        ),
        printed=(
            Limit(
                "peak_ratio_change",
                "peak power over peak energy [1/s], changed by a toy that moves alike at another "
                "size",
                0.9,
                1.1,
            ),
        ),
        finding=(
            "The largest drive power in W over the largest energy in J is {peak_ratio:.2f} for "
            "the toy of Fig. 6 and {peak_ratio_short:.2f} for a toy of a quarter of the length "
            "that moves alike."
        ),
        why=(
            "Joule and watt differ by a time: at this length their numbers happen to be alike. "
            "The ratio follows √(g/l)."
        ),
    ),
)


def data(quick: bool = False) -> xr.Dataset:
    """Return energies and powers with a push, from rest, and of a shorter toy that moves alike."""
    from latolato.simulation.run import simulate

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
        panel.legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, columnspacing=1.2, borderpad=0.0
        )
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
