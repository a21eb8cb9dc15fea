"""How the toy starts by itself on strings and on rods, just above A0 w^2 = g."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato import Harmonic
from latolato.figures import style
from latolato.paper.cases import quantity, stack, variable
from latolato.paper.claim import Numbers
from latolato.paper.string_toys import (
    COLOURS,
    ELASTIC,
    INELASTIC,
    PAPER_TOY,
    RODS,
    label_of,
    on_each,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE = "How the toy starts by itself"
RATIO = 2.0  # w/w0
STRENGTH = 1.2  # A0 w^2/g
PERIODS, SHOWN = 40, 2.2  # periods of the drive: of a run, in the first panels
PER_PERIOD = 200
# Largest accelerations of the pivot [g], across the onset.
STRENGTHS, QUICK_STRENGTHS = np.linspace(0.9, 1.6, 71), np.linspace(0.9, 1.6, 8)
SCAN_PERIODS = 100
CAPTION = (
    f"The toy of Fig. 4 with e = {PAPER_TOY.restitution:g}, from rest at the contact angle, driven "
    f"at ω = {RATIO:g} ω0. (a) to (c) A0 ω² = {STRENGTH:g} g: distance from the pivot and angle "
    "above the contact angle during the first two periods, and the angle later. Triangles: the "
    "balls hit each other; squares: strings snap taut. (d) The largest angle above the contact "
    f"angle during {SCAN_PERIODS} periods against the largest acceleration of the pivot; zeros are "
    "left out."
)
FINDING = (
    "Rods and strings leave rest at the same drive, A0 ω² = g, but on strings both balls fly "
    "straight up side by side, by {rise_mm:.0f} mm at first, until the strings snap taut and throw "
    "them against each other. If the snap takes all of the velocity along the string (e_s = 0), "
    "the start is that of rods to first order in the contact angle and in the height of the "
    "flight: the first hits, at {hit_rod:.4f} rad/s, differ by {hit_change:.3%}, and after "
    "{periods:.0f} periods both toys still make small hops, of {hops_rods:.1f} mrad on rods and "
    "{hops_inelastic:.1f} mrad on strings. With e_s = 0.9 the strings throw the balls up again, "
    "the hops grow, and the toy reaches the top after {top_periods:.0f} periods."
)
CHECK = (
    "Below the onset nothing moves on any suspension ({below:g} rad). The weakest drive of the "
    "scan that moves the balls has A0 ω² = {onset_rods:.2f} g on rods, {onset_inelastic:.2f} g "
    "with e_s = 0 and {onset_elastic:.2f} g with e_s = 0.9. To first order the angular velocity "
    "of the first hit is minus the integral of (g + y0'') sin θmin/l over the flight, both for a "
    "rod and for a ball that falls back into its string and keeps the velocity across it. The "
    "first hits agree accordingly."
)
_KINDS = {"bottom": ("v", 16.0), "taut": ("s", 9.0)}


def _drive() -> Harmonic:
    """Return the drive of the runs."""
    w = RATIO * PAPER_TOY.natural_frequency
    return Harmonic(drive_amplitude=STRENGTH * PAPER_TOY.gravity / w**2, drive_frequency=w)


def data(quick: bool = False) -> xr.Dataset:
    """Return runs from rest, their contacts, and how far a toy gets over the drive's strength."""
    from latolato import simulate, sweep

    drive = _drive()
    period = 2.0 * math.pi / drive.drive_frequency
    times = np.linspace(0.0, PERIODS * period, PERIODS * PER_PERIOD + 1)
    toys = on_each(PAPER_TOY)
    runs = {
        name: simulate(toy, drive, initial_offset=0.0, times=times) for name, toy in toys.items()
    }
    dataset = stack(runs, title=TITLE)
    distances = [
        run.distance.values if "distance" in run else np.full(len(times), PAPER_TOY.length)
        for run in runs.values()
    ]
    strengths = QUICK_STRENGTHS if quick else STRENGTHS
    rises = [
        sweep(
            toy,
            Harmonic(drive_amplitude=0.1, drive_frequency=drive.drive_frequency),
            axes={"drive_acceleration_ratio": strengths},
            duration=SCAN_PERIODS * period,
            initial_offset=0.0,
            observables=["largest_angle"],
            tolerance=1e-8,
        ).largest_angle.values
        - toy.contact_angle_low
        for toy in toys.values()
    ]
    kinds = [run.contact_kind.values for run in runs.values()]
    owners = np.repeat(list(runs), [len(each) for each in kinds])
    return dataset.assign(
        distance=quantity("distance", ("case", "time"), np.stack(distances)),
        contact_time=variable(
            "contact",
            np.concatenate([run.contact_time.values for run in runs.values()]),
            units="s",
            long_name="time of a contact",
        ),
        contact_kind=variable(
            "contact", np.concatenate(kinds).astype(str), units="1", long_name="kind of a contact"
        ),
        contact_case=variable("contact", owners, units="1", long_name="case of a contact"),
        contact_speed=quantity(
            "angular_velocity_before",
            "contact",
            np.concatenate([run.angular_velocity_before.values for run in runs.values()]),
        ),
        rise=variable(
            ("case", "strength"), rises, units="rad", long_name="largest rise above contact"
        ),
    ).assign_coords(strength=quantity("drive_acceleration_ratio", "strength", strengths))


def _contacts(dataset: xr.Dataset, case: str, kind: str) -> xr.Dataset:
    """Return the contacts of a kind of a case."""
    is_one = (dataset.contact_case == case) & (dataset.contact_kind == kind)
    return dataset[["contact_time", "contact_speed"]].isel(contact=is_one.values)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the onsets, the first hits, and when the toy reaches the top."""
    drive = _drive()
    hits = {case: _contacts(dataset, case, "bottom").contact_speed.values[0] for case in COLOURS}
    strength, rise = dataset.strength.values, dataset.rise
    onsets = {case: strength[rise.sel(case=case).values > 0.0].min() for case in COLOURS}
    period = 2.0 * math.pi / drive.drive_frequency
    tops = _contacts(dataset, ELASTIC, "top").contact_time.values
    first = dataset.time.values <= period
    return {
        "rise_mm": 1e3 * float(
            PAPER_TOY.length - dataset.distance.sel(case=INELASTIC).values[first].min()
        ),
        "hit_rod": -float(hits[RODS]),
        "hit_change": float(abs(hits[INELASTIC] / hits[RODS] - 1.0)),
        "top_periods": float(tops[0] / period) if tops.size else math.inf,
        "below": float(np.abs(rise.values[:, strength < 1.0]).max()),
        "onset_rods": float(onsets[RODS]),
        "onset_inelastic": float(onsets[INELASTIC]),
        "onset_elastic": float(onsets[ELASTIC]),
        "periods": float(PERIODS),
        "hops_rods": 1e3 * _late(dataset, RODS),
        "hops_inelastic": 1e3 * _late(dataset, INELASTIC),
    }  # fmt: skip


def _late(dataset: xr.Dataset, case: str) -> float:
    """Return the largest rise above contact in the last ten periods [rad]."""
    angle = dataset.angle.sel(case=case).values[-10 * PER_PERIOD :]
    return float(angle.max() - PAPER_TOY.contact_angle_low)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) to (d)."""
    figure, axes = style.new_figure(2, 2, height=4.6)
    period = 2.0 * math.pi / _drive().drive_frequency
    time = dataset.time.values / period
    early = time <= SHOWN
    low = PAPER_TOY.contact_angle_low
    for case, colour in COLOURS.items():
        run = dataset.sel(case=case)
        height = 1e3 * (run.distance.values - PAPER_TOY.length)
        rise = 1e3 * (run.angle.values - low)
        # Wide under the others, which coincide with it.
        wide = 2.6 if case == RODS else style.LINE
        axes[0, 0].plot(time[early], height[early], color=colour, lw=wide, label=label_of(case))
        axes[0, 1].plot(time[early], rise[early], color=colour, lw=wide)
        for panel, values in ((axes[0, 0], height), (axes[0, 1], rise)):
            _mark(panel, dataset, case, (time, values))
        axes[1, 0].plot(time, run.angle.values - low, color=colour, lw=style.THIN)
        axes[1, 1].semilogy(
            dataset.strength, run.rise.where(run.rise > 0.0), color=colour, marker=".", ms=2.5,
            lw=style.THIN,
        )  # fmt: skip
    axes[0, 0].set_ylabel("distance minus length [mm]")
    axes[0, 1].set_ylabel("angle above contact [mrad]")
    axes[1, 0].set_ylabel("angle above contact [rad]")
    axes[1, 1].set_ylabel("largest angle above contact [rad]")
    axes[1, 1].axvline(1.0, color=style.GREY, lw=style.THIN, ls=(0, (4, 3)))
    axes[1, 1].set_xlim(float(dataset.strength[0]), float(dataset.strength[-1]))
    axes[1, 1].set_xlabel(style.label(dataset.strength, short=True))
    for panel in (axes[0, 0], axes[0, 1], axes[1, 0]):
        panel.set_xlabel("time [periods of the drive]")
    titles = ("the balls fly up", "and are thrown together", "later", "the onset is the same")
    for panel, letter, title in zip(axes.ravel(), "abcd", titles, strict=True):
        style.panel_title(panel, letter, title)
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def _mark(panel: Axes, dataset: xr.Dataset, case: str, curve: tuple[object, object]) -> None:
    """Mark early hits and snaps on a curve of time [periods]."""
    time, values = (np.asarray(each) for each in curve)
    period = 2.0 * math.pi / _drive().drive_frequency
    for kind, (marker, size) in _KINDS.items():
        at = _contacts(dataset, case, kind).contact_time.values / period
        at = at[at <= SHOWN]
        panel.scatter(
            at, np.interp(at, time, values), s=size, marker=marker, color=COLOURS[case],
            linewidths=0.0, zorder=3,
        )  # fmt: skip
