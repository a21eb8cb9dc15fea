"""Fig. 13: the linear equation grows without bound, the full one beats."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.analysis import growth_rate
from latolato.figures import style
from latolato.paper import measure
from latolato.paper import systems as paper
from latolato.paper.cases import SAMPLES_PER_PERIOD, instants, quantity, stack
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "Linear growth and nonlinear beats"
CAPTION = (
    "The pendulum of Fig. 2 by the small-angle equation 14, (a) with damping and (b) without, and "
    "by equation 10, (c) with damping and (d) without. The broken lines in (a) and (b) grow at "
    "the rate that Hill's determinant gives. Dots in (c) and (d) mark the beats' maxima."
)
DURATION = 300.0  # s
LINEAR_SHOWN = 60.0  # s, beyond it the straight axis shows the last swings only
CASES = {
    "a": (paper.LINEAR, "equation 14"),
    "b": (paper.LINEAR_UNDAMPED, "equation 14"),
    "c": (paper.PENDULUM, "equation 10"),
    "d": (paper.UNDAMPED, "equation 10"),
}
# Growth is measured once the fastest growing part prevails.
MEASURED_FROM = 40.0  # s


def data(quick: bool = False) -> xr.Dataset:
    """Return the four panels' angles."""
    from latolato import simulate

    times = instants(DURATION, paper.DRIVE.drive_frequency)
    runs = {
        panel: simulate(system, paper.DRIVE, initial_angle=paper.SMALL_ANGLE, times=times)
        for panel, (system, _) in CASES.items()
    }
    rates = [float(growth_rate(system, paper.DRIVE).growth_rate) for system, _ in CASES.values()]
    return stack(runs, title=TITLE, keep=("angle", "angular_velocity")).assign(
        growth_rate=quantity(
            "growth_rate", "case", np.array(rates), long_name="growth rate by Hill's determinant"
        ),
        damping=quantity("damping", "case", [system.damping for system, _ in CASES.values()]),
    )


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 13's statements need."""
    time = dataset.time.values
    result: dict[str, float] = {}
    for case in ("a", "b"):
        angle = dataset.angle.sel(case=case).values
        rate, sign = measure.growth_per_period(
            time, angle, samples_per_period=SAMPLES_PER_PERIOD, first=MEASURED_FROM, last=DURATION
        )
        hill = float(dataset.growth_rate.sel(case=case))
        result |= {
            f"growth_{case}": rate,
            f"sign_{case}": sign,
            f"hill_{case}": hill,
            f"growth_error_{case}": abs(rate / hill - 1.0),
            f"factor_{case}": float(np.max(np.abs(angle)) / abs(angle[0])),
        }
    for case in ("c", "d"):
        run = dataset.sel(case=case)
        when, sizes = measure.peaks(time, run.angle.values, run.angular_velocity.values)
        beat_times, beat_sizes = measure.beats(when, sizes)
        between = sizes[(when > beat_times[0]) & (when < beat_times[1])]
        late = sizes[when > DURATION - 100.0]
        result |= {
            f"largest_{case}": float(sizes.max()),
            f"depth_{case}": float(1.0 - between.min() / beat_sizes[0]),
            f"late_depth_{case}": float(1.0 - late.min() / late.max()),
            f"spacing_{case}": float(beat_times[1] - beat_times[0]),
        }
        result |= {f"beat_{case}{i + 1}": float(beat_sizes[i]) for i in range(3)}
    strobe = dataset.angle.sel(case="c").values[::SAMPLES_PER_PERIOD]
    strobe = strobe[-int(50.0 / (time[SAMPLES_PER_PERIOD] - time[0])) :]
    rate = result["hill_a"]
    return result | {
        "sign_c": float(np.sign(np.max(strobe[1:] / strobe[:-1]))),
        "two_period_change": float(np.max(np.abs(strobe[2:] / strobe[:-2] - 1.0))),
        "late_ratio": result["late_depth_c"] / result["late_depth_d"],
        "depth_loss": 1.0 - result["late_depth_c"] / result["late_depth_d"],
        "rate_loss": 1.0 - rate / result["hill_b"],
        "growth_ratio": result["hill_b"] / (result["hill_b"] - rate),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) to (d)."""
    figure, axes = style.new_figure(2, 2, height=4.2)
    time = dataset.time.values
    early = time <= LINEAR_SHOWN
    for axis, (case, (_, equation)) in zip(axes.flat, CASES.items(), strict=True):
        run = dataset.sel(case=case)
        damping = float(run.damping)
        title = f"{equation}, $C$ = {damping:g}" + (" kg m/s" if damping else "")
        style.panel_title(axis, case, title)
        if case in "ab":
            angle = run.angle.values[early]
            axis.plot(time[early], angle, color=style.GREEN, lw=0.7)
            # The envelope through the largest swing shown.
            top = int(np.argmax(np.abs(angle)))
            envelope = abs(angle[top]) * np.exp(float(run.growth_rate) * (time[early] - time[top]))
            for sign in (-1.0, 1.0):
                axis.plot(time[early], sign * envelope, color=style.INK, lw=style.THIN, ls="--")
            axis.set_xlim(0.0, LINEAR_SHOWN)
            axis.annotate(
                f"growth rate {float(run.growth_rate):.5f} 1/s",
                (0.04, 0.92),
                xycoords="axes fraction",
                fontsize=style.SMALL,
                va="top",
            )
        else:
            axis.plot(time, run.angle, color=style.BLUE, lw=0.5)
            when, sizes = measure.peaks(time, run.angle.values, run.angular_velocity.values)
            beat_times, beat_sizes = measure.beats(when, sizes)
            visible = beat_sizes > measure.VISIBLE_BEAT * sizes[-40:].mean()
            axis.plot(
                beat_times[visible],
                beat_sizes[visible],
                "o",
                ms=2.4,
                color=style.RED,
                clip_on=False,
            )
            axis.set_xlim(0.0, DURATION)
        axis.set_xlabel(style.label(dataset.time))
    highest = 1.08 * float(np.abs(dataset.angle.sel(case=["c", "d"])).max())
    for axis in axes[1]:
        axis.set_ylim(-highest, highest)
    for row in axes:
        row[0].set_ylabel(style.label(dataset.angle, short=True))
    return figure
