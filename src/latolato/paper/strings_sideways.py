"""Whether the mirror motion survives a hand that also moves sideways, on rods and on strings."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING

import numpy as np

from latolato import Harmonic, PlanarHarmonic
from latolato.figures import style
from latolato.paper.cases import Residuals, stack, variable
from latolato.paper.claim import Numbers
from latolato.paper.string_toys import (
    COLOURS,
    CORD_PAIR,
    CORD_TOY,
    ELASTIC,
    INELASTIC,
    RODS,
    label_of,
    on_each,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from latolato.paper.cases import Floats

TITLE = "A hand that also moves sideways"
FREQUENCY = 2.5 * CORD_TOY.natural_frequency  # rad/s
AMPLITUDE = 0.5 * CORD_TOY.length  # m, up and down
PERIOD = 2.0 * math.pi / FREQUENCY
SETTLING, PERIODS, PER_PERIOD = 200, 150, 20
PUSH = 0.5  # rad above the contact angle
# Horizontal over vertical amplitude.
SHARES, QUICK_SHARES = np.geomspace(1e-4, 1.0, 41), np.geomspace(1e-4, 1.0, 9)
# How the horizontal motion leads, and the balls' start.
WAYS = {"tilted line": 0.0, "ellipse": 0.5 * math.pi}
CYCLE, PUSHED = "cycle", "push"
KEPT_MIRRORED = 0.5  # rad, an asymmetry up to which the motion counts as mirrored
CAPTION = (
    f"The toy of the least drive as two free balls, A0 = {AMPLITUDE / CORD_TOY.length:g} l, ω = "
    f"2.5 ω0, {PERIODS} periods. (a) Root mean square of |θ right + θ left|, taken to [0, π], in "
    "the second half, for runs that begin in the settled mirror motion; dotted: twice the angle of "
    "a hand that moves on a tilted line. Crosses: the strings tangle before the end. (b) Hits "
    "above the pivot per period on the tilted line. (c) When strings tangle on the tilted "
    f"line, if they do, for runs that begin in the settled motion (full) and {PUSH:g} rad above "
    "contact (open)."
)
FINDING = (
    "The settled mirror motion survives a small motion of the hand sideways: its axis leans by "
    "{lean:.2f} times the angle of the line on which the hand moves, and {tops:.0f} hit above the "
    "pivot per period remains, up to a horizontal amplitude of {limit_rods:.0%} of the vertical "
    "one (on an ellipse {limit_ellipse:.0%}). At {next_rods:.0%} ({next_ellipse:.0%}) the "
    "asymmetry jumps to {jump:.1f} rad, and strings go slack: from there on {tangled:.0%} of the "
    "runs on strings tangle, all within {tangle:.0f} of {periods:.0f} periods, and of those that "
    "begin with a push {lost:.0%} tangle, down to the smallest sideways motion of {least:g}, but "
    "none without any."
)
CHECK = (
    "Without sideways motion two free balls stay mirrored to {mirror:.0e} rad. The asymmetry grows "
    "in proportion to the sideways motion (power {power:.3f} below a hundredth), and as long as no "
    "string goes slack rods and strings give equal asymmetries to {same:.0e} rad."
)


def _cycle() -> tuple[float, float, xr.Dataset]:
    """Return angle and angular velocity of the settled mirror motion, and the run."""
    from latolato import simulate

    run = simulate(
        CORD_TOY,
        Harmonic(drive_amplitude=AMPLITUDE, drive_frequency=FREQUENCY),
        initial_offset=PUSH,
        times=np.linspace(0.0, SETTLING * PERIOD, SETTLING + 1),
    )
    return float(run.angle[-1]), float(run.angular_velocity[-1]), run


def _asymmetry(run: xr.Dataset) -> Floats:
    """Return |right angle + left angle| taken to [0, pi], shape (time,) up to a tangle."""
    angle = run.angle.values
    total: Floats = (angle[0] + angle[1])[np.isfinite(angle[0])]
    return np.abs((total + math.pi) % (2.0 * math.pi) - math.pi)


def data(quick: bool = False) -> xr.Dataset:
    """Return asymmetry, hits above the pivot and the time of a tangle over the sideways motion."""
    from latolato import simulate

    shares = QUICK_SHARES if quick else SHARES
    angle, velocity, settled = _cycle()
    low = CORD_TOY.contact_angle_low + PUSH
    starts = {CYCLE: (angle, velocity), PUSHED: (low, 0.0)}
    pairs, residuals = on_each(CORD_PAIR), Residuals()
    times = np.linspace(0.0, PERIODS * PERIOD, PERIODS * PER_PERIOD + 1)
    shape = (len(pairs), len(WAYS), len(starts), len(shares) + 1)
    asymmetry, tops, ends, slack = (np.zeros(shape) for _ in range(4))
    for i in np.ndindex(shape):
        pair, phase = list(pairs.values())[i[0]], list(WAYS.values())[i[1]]
        x, v = list(starts.values())[i[2]]
        share = 0.0 if i[3] == 0 else shares[i[3] - 1]
        with warnings.catch_warnings():
            # Where balls meet strings the picture ends a line, so `ends` says it.
            warnings.filterwarnings("ignore", "the run stopped", RuntimeWarning)
            run = simulate(
                pair,
                PlanarHarmonic(
                    vertical_amplitude=AMPLITUDE,
                    horizontal_amplitude=share * AMPLITUDE,
                    drive_frequency=FREQUENCY,
                    horizontal_phase=phase,
                ),
                initial_angle=(x, -x),
                initial_angular_velocity=(v, -v),
                times=times,
                tolerance=1e-8,
            )
        residuals.of(run)
        sizes = _asymmetry(run)
        kinds = run.contact_kind.values
        asymmetry[i] = math.sqrt(np.mean(sizes[len(sizes) // 2 :] ** 2))
        ends[i] = times[len(sizes) - 1] / PERIOD
        tops[i] = (kinds == "top").sum() / max(ends[i], 1.0)
        slack[i] = (kinds == "slack").any()
    dims = ("suspension", "way", "start", "share")
    return stack({"settled": settled}, title=TITLE).assign(
        asymmetry=variable(dims, asymmetry, units="rad", long_name="root mean square asymmetry"),
        tops=variable(dims, tops, units="1", long_name="hits above the pivot per period"),
        end=variable(dims, ends, units="1", long_name="periods until strings tangle"),
        was_slack=variable(dims, slack, units="1", long_name="whether a string went slack"),
        **residuals.variables(),
    ).assign_coords(
        suspension=variable("suspension", list(pairs), units="1", long_name="suspension"),
        way=variable("way", list(WAYS), units="1", long_name="path of the hand"),
        start=variable("start", list(starts), units="1", long_name="start"),
        share=variable(
            "share",
            np.concatenate([[0.0], shares]),
            units="1",
            long_name="horizontal over vertical amplitude",
        ),
    )  # fmt: skip


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return how far the axis leans, up to where the motion stays mirrored, and the checks."""
    share, settled = dataset.share.values, dataset.sel(start=CYCLE)
    tilted = settled.sel(way="tilted line")
    rods = tilted.asymmetry.sel(suspension=RODS).values
    small = (share > 0.0) & (share < 0.01)
    power = np.polyfit(np.log(share[small]), np.log(rods[small]), 1)[0]
    strings, on_rods = settled.sel(suspension=INELASTIC), settled.sel(suspension=RODS)
    taut = strings.was_slack.values == 0.0
    difference = np.abs(strings.asymmetry.values - on_rods.asymmetry.values)[taut]
    limits = {
        way: share[settled.asymmetry.sel(suspension=RODS, way=way).values < KEPT_MIRRORED].max()
        for way in WAYS
    }
    beyond = {way: share > limit for way, limit in limits.items()}
    on_both = settled.sel(suspension=[INELASTIC, ELASTIC])
    ends = np.hstack([on_both.end.sel(way=way).values[:, beyond[way]] for way in WAYS])
    on_push = dataset.sel(start=PUSHED, suspension=[INELASTIC, ELASTIC]).end.values
    pushed, still = on_push[..., 1:], on_push[..., 0]
    kept = share <= limits["tilted line"]
    return {
        "lean": float(np.median(rods[small] / (2.0 * share[small]))),
        "power": float(power),
        "same": float(difference.max()),
        "mirror": float(settled.asymmetry.values[..., 0].max()),
        "limit_rods": float(limits["tilted line"]),
        "limit_ellipse": float(limits["ellipse"]),
        "tops": float(tilted.tops.values[:, kept].min()),
        "next_rods": float(share[beyond["tilted line"]][0]),
        "next_ellipse": float(share[beyond["ellipse"]][0]),
        "least": float(share[1]),
        "lost_still": float((still < PERIODS).mean()),
        "jump": float(rods[beyond["tilted line"]][0]),
        "tangled": float((ends < PERIODS).mean()),
        "tangle": float(ends[ends < PERIODS].max(initial=0.0)),
        "periods": float(PERIODS),
        "lost": float((pushed < PERIODS).mean()),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) to (c)."""
    figure, axes = style.new_figure(1, 3, sharex=True, height=2.9)
    share = dataset.share.values[1:]
    sizes, tops, ends = axes[0]
    moved = dataset.isel(share=slice(1, None))
    for name, colour in COLOURS.items():
        wide = 2.6 if name == RODS else style.LINE
        for way, dashes in (("tilted line", "-"), ("ellipse", (0, (3, 1.5)))):
            part = moved.sel(suspension=name, way=way, start=CYCLE)
            is_whole = part.end.values >= PERIODS
            sizes.loglog(
                share, part.asymmetry.where(is_whole), ls=dashes, color=colour, lw=wide,
                label=f"{label_of(name)}" if dashes == "-" else None,
            )  # fmt: skip
            sizes.scatter(
                share[~is_whole], part.asymmetry.values[~is_whole], marker="x", s=10.0,
                linewidths=0.8, color=colour,
            )  # fmt: skip
        part = moved.sel(suspension=name, way="tilted line", start=CYCLE)
        tops.semilogx(share, part.tops.where(part.end >= PERIODS), color=colour, lw=wide)
        if name != RODS:
            pushed = moved.sel(suspension=name, way="tilted line", start=PUSHED)
            for each, look in ((part, {"ms": 3.0}), (pushed, {"ms": 3.5, "mfc": "none"})):
                at = each.end.where(each.end < PERIODS)
                ends.semilogy(share, at, "o", color=colour, mew=0.7, **look)
    sizes.plot(share, 2.0 * np.arctan(share), color=style.INK, lw=style.THIN, ls=":")
    sizes.set_ylabel("asymmetry [rad]")
    tops.set_ylabel("hits above the pivot per period")
    tops.set_ylim(0.0)
    ends.set_ylabel("periods until a tangle")
    sizes.set_xlim(0.8 * share[0], 1.25 * share[-1])  # whole markers at both ends
    titles = ("asymmetry", "hits above the pivot", "strings tangle")
    for panel, letter, title in zip(axes[0], "abc", titles, strict=True):
        panel.set_xlabel("horizontal over vertical")
        style.panel_title(panel, letter, title)
    sizes.plot([], [], color=style.INK, label="tilted line")
    sizes.plot([], [], color=style.INK, ls=(0, (3, 1.5)), label="ellipse")
    figure.legend(loc="outside lower center", ncols=5)
    return figure
