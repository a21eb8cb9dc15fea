"""Fig. 12: a high driving frequency first, then a low one, and what lasts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato import FrequencySchedule, Harmonic
from latolato.figures import style
from latolato.paper import systems as paper
from latolato.paper.cases import Floats, Residuals, instants, quantity, stack, variable
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE = "Stepping the driving frequency"
CAPTION = (
    "Right ball of the colliding pair, ω/ω0 = 3.136 until 4.166 s, then 2.389 (shaded), started "
    "at rest in contact. "
    f"{paper.COUPLED_WORDS} are assumed. "
    "(a) The frequency steps at once; (b) it moves within 0.5 s. Thin lines: other drive phases "
    "at the start. The green line is a start at rest with the second frequency only. (c) Angle "
    "after 40 s for first-stage ratios that all round to 3.136. (d) What lasts, against the drive "
    "phase, for the stepped start (blue) and for starts with the second frequency only, released "
    "the given angle above contact (green). Lasting motions are a large swing, small hops and "
    "rest; which one is met depends on details that the printed digits do not fix."
)
DURATION = 12.0  # s shown
SETTLED = (35.0, 40.0)  # s, where the settled angle is read
RAMPS = (0.0, paper.LONGEST_RAMP)
PHASES = 16
PUSHES = (0.0, 0.05, 0.1, 0.2)  # rad above the contact angle
# Lasting motions above this angle are the large one.
LARGE = np.deg2rad(20.0)
_ROUNDING = 0.0005  # half of the last printed digit of a ratio


def data(quick: bool = False) -> xr.Dataset:
    """Return curves for two ramps and several phases, and the settled angles of many starts."""
    w0 = paper.COUPLED.natural_frequency
    first, second = paper.STAGE_RATIOS
    phases = np.arange(PHASES) * (2.0 * np.pi / PHASES)
    starts = phases[:: PHASES // 4]
    times = instants(DURATION, first * w0)
    runs = {
        f"{ramp:g} s, {i}": _stepped(first, ramp, phase, times)
        for ramp in RAMPS
        for i, phase in enumerate(starts)
    }
    runs["rest"] = _alone(0.0, 0.0, times)
    ratios = first + np.linspace(-_ROUNDING, _ROUNDING, 81 if quick else 161)
    late = np.linspace(*SETTLED, 501)
    residuals = Residuals()

    def lasting(run: xr.Dataset) -> float:
        return float(residuals.of(run).angle.max())

    dataset = stack(runs, title=TITLE).assign(
        lasting_by_ratio=quantity(
            "angle",
            ("ramp", "frequency_ratio"),
            [[lasting(_stepped(ratio, ramp, 0.0, late)) for ratio in ratios] for ramp in RAMPS],
            long_name="settled angle",
        ),
        lasting_stepped=quantity(
            "angle",
            "drive_phase",
            [lasting(_stepped(first, 0.0, phase, late)) for phase in phases],
            long_name="settled angle with the step",
        ),
        lasting_pushed=quantity(
            "angle",
            ("initial_offset", "drive_phase"),
            [[lasting(_alone(push, phase, late)) for phase in phases] for push in PUSHES],
            long_name="settled angle without the step",
        ),
    )
    return dataset.assign(residuals.variables()).assign_coords(
        ramp=quantity("ramp", "ramp", list(RAMPS)),
        frequency_ratio=quantity(
            "frequency_ratio", "frequency_ratio", ratios, long_name="first-stage frequency ratio"
        ),
        drive_phase=quantity("drive_phase", "drive_phase", phases),
        initial_offset=quantity("initial_offset", "initial_offset", list(PUSHES)),
        switch_time=variable((), paper.SWITCH_TIME, units="s", long_name="time of the step"),
        second_ratio=quantity("frequency_ratio", (), second, long_name="second-stage ratio"),
    )


def _stepped(ratio: float, ramp: float, phase: float, times: Floats) -> xr.Dataset:
    """Return a run from rest in contact with both stages."""
    from latolato import simulate

    w0 = paper.COUPLED.natural_frequency
    drive = FrequencySchedule(
        drive_amplitude=paper.COUPLED_AMPLITUDE,
        times=[0.0, paper.SWITCH_TIME],
        drive_frequencies=[ratio * w0, paper.STAGE_RATIOS[1] * w0],
        ramp=ramp,
        drive_phase=phase,
    )
    return simulate(paper.COUPLED, drive, initial_offset=0.0, times=times)


def _alone(offset: float, phase: float, times: Floats) -> xr.Dataset:
    """Return a run with the second frequency only, released at rest above contact."""
    from latolato import simulate

    drive = Harmonic(
        drive_amplitude=paper.COUPLED_AMPLITUDE,
        drive_frequency=paper.STAGE_RATIOS[1] * paper.COUPLED.natural_frequency,
        drive_phase=phase,
    )
    return simulate(paper.COUPLED, drive, initial_offset=offset, times=times)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 12's statements need."""
    stepped, pushed = dataset.lasting_stepped.values, dataset.lasting_pushed
    by_ratio = dataset.lasting_by_ratio
    rest = float(pushed.sel(initial_offset=0.0).max())
    hard = pushed.sel(initial_offset=PUSHES[-1]).values
    middle = len(dataset.frequency_ratio) // 2
    at_once, ramped = (float(by_ratio.sel(ramp=ramp)[middle]) for ramp in RAMPS)
    gravity, w0 = paper.COUPLED.gravity, paper.COUPLED.natural_frequency
    first, second = (ratio * w0 for ratio in paper.STAGE_RATIOS)
    return {
        "gain": at_once / rest,
        "gain_over_push": at_once / float(hard.max()),
        "stepped_degrees": float(np.rad2deg(at_once)),
        "ramped_degrees": float(np.rad2deg(ramped)),
        "small_degrees": float(
            np.rad2deg(by_ratio.values[by_ratio.values < LARGE].max(initial=rest))
        ),
        "rest_degrees": float(np.rad2deg(rest)),
        "pushed_degrees": float(np.rad2deg(hard.max())),
        "ramp_change": ramped / at_once,
        "share_rounding": _share(by_ratio.values),
        "share_phases": _share(stepped),
        "share_pushed": _share(hard),
        "acceleration_1": paper.COUPLED_AMPLITUDE * first**2 / gravity,
        "acceleration_2": paper.COUPLED_AMPLITUDE * second**2 / gravity,
        "threshold_mm": 1e3 * gravity / first**2,
    }


def _share(angles: Floats) -> float:
    """Return the share of settled angles that belong to the large swing."""
    return float(np.mean(angles > LARGE))


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) to (d)."""
    figure, panels = style.new_mosaic([["a", "b"], ["c", "d"]], height=4.6)
    time = dataset.time.values
    for name, ramp in zip("ab", RAMPS, strict=True):
        axis = panels[name]
        cases = [str(case) for case in dataset.case.values if str(case).startswith(f"{ramp:g} s")]
        axis.axvspan(paper.SWITCH_TIME, DURATION, color=style.PALE_BLUE, lw=0)
        for case in reversed(cases):
            main = case == cases[0]
            axis.plot(
                time,
                np.rad2deg(dataset.angle.sel(case=case)),
                color=style.BLUE if main else style.GREY,
                lw=0.9 if main else 0.4,
            )
        axis.plot(time, np.rad2deg(dataset.angle.sel(case="rest")), color=style.GREEN)
        axis.set_xlim(0.0, DURATION)
        axis.set_ylim(0.0, None)
        axis.set_xlabel(style.label(dataset.time))
        style.panel_title(axis, name, "step at once" if ramp == 0.0 else f"ramp of {ramp:g} s")
    panels["a"].set_ylabel(style.label(dataset.angle, short=True, unit="°"))
    c, d = panels["c"], panels["d"]
    for ramp, marker, colour in zip(RAMPS, "o+", (style.BLUE, style.RED), strict=True):
        c.plot(
            dataset.frequency_ratio,
            np.rad2deg(dataset.lasting_by_ratio.sel(ramp=ramp)),
            marker,
            ms=3.0,
            mew=0.6,
            mfc="none",
            color=colour,
            label="at once" if ramp == 0.0 else f"ramp {ramp:g} s",
        )
    c.ticklabel_format(axis="x", useOffset=False)
    c.set_xlim(*(paper.STAGE_RATIOS[0] + 1.06 * _ROUNDING * np.array([-1.0, 1.0])))
    c.set_xticks(paper.STAGE_RATIOS[0] + _ROUNDING * np.array([-1.0, 0.0, 1.0]))
    c.set_xlabel(style.label(dataset.frequency_ratio))
    c.set_ylabel("settled angle [°]")
    c.legend(loc="center left")
    style.panel_title(c, "c", "ratios that round to 3.136")
    _draw_phases(dataset, d)
    return figure


def _draw_phases(dataset: xr.Dataset, axis: Axes) -> None:
    """Draw panel (d): a row of marks for each start, filled where the large swing lasts."""
    rows = [("stepped", dataset.lasting_stepped.values)]
    for push in PUSHES[::-1]:
        name = f"{push:g} rad" if push else "rest"
        rows.append((name, dataset.lasting_pushed.sel(initial_offset=push).values))
    phases = dataset.drive_phase.values
    for row, (_, angles) in enumerate(rows):
        colour = style.BLUE if row == 0 else style.GREEN
        for is_large in (True, False):
            mask = (angles > LARGE) == is_large
            axis.plot(
                phases[mask],
                np.full(mask.sum(), row),
                "o",
                ms=4.2,
                mew=0.7,
                color=colour,
                mfc=colour if is_large else "none",
            )
    axis.set_yticks(range(len(rows)), [name for name, _ in rows])
    axis.set_ylim(len(rows) - 0.5, -0.5)
    axis.set_xlim(-0.25, 2.0 * np.pi)
    style.pi_ticks(axis.xaxis, parts=2)
    axis.set_xlabel(style.label(dataset.drive_phase))
    style.panel_title(axis, "d", "filled: large swing, open: hops or rest")
