"""Fig. 13: the linear equation grows without bound, the full one beats."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.analysis.closed_forms import mathieu_growth_rate
from latolato.figures import measure, paper, style
from latolato.figures.cases import SAMPLES_PER_PERIOD, instants, quantity, stack
from latolato.figures.claim import Limit, Numbers, Statement

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

STATEMENTS = (
    Statement(
        name="linear-growth",
        where="Fig. 13a, b",
        words=(
            "when ω = 2ω0, the amplitude will exhibit exponential growth. The actual result is "
            "indeed so"
        ),
        printed=(
            Limit("growth_error_a", "relative error of exponential growth with damping", high=1e-4),
            Limit("growth_error_b", "the same without damping", high=1e-4),
            Limit("growth_a", "growth rate with damping", low=0.0, unit="1/s"),
        ),
        finding=(
            "The solutions of Fig. 13a, b grow at {growth_a:.5f} 1/s with damping and at "
            "{growth_b:.5f} 1/s without, over a factor of {factor_a:.0e}."
        ),
        why=(
            "Runs of eq14 grow from period to period at the rate of Hill's determinant "
            "({hill_a:.5f} and {hill_b:.5f} 1/s)."
        ),
    ),
    Statement(
        name="nonlinear-beats",
        where="Fig. 13c, d",
        words="the amplitude growth becomes bounded and begins to exhibit fluctuations",
        printed=(
            Limit("largest_c", "largest angle with damping", high=np.pi, unit="rad"),
            Limit("largest_d", "largest angle without damping", high=np.pi, unit="rad"),
            Limit("depth_c", "depth of the first beat with damping, relative", low=0.1),
            Limit("depth_d", "depth of the first beat without damping, relative", low=0.1),
        ),
        finding=(
            "In Fig. 13c, with damping, the beats reach {beat_c1:.3f}, {beat_c2:.3f} and "
            "{beat_c3:.3f} rad, {spacing_c:.1f} s apart; in Fig. 13d, without damping, they reach "
            "{beat_d1:.3f}, {beat_d2:.3f} and {beat_d3:.3f} rad, {spacing_d:.1f} s apart."
        ),
        why="The restoring torque follows the sine: a large swing slows down and leaves resonance.",
    ),
    Statement(
        name="damping-and-occurrence",
        where="Fig. 13 and supplement",
        words=(
            "damping exerts a more pronounced influence on motion details in nonlinear systems. "
            "But it has no substantial impact on … the occurrence of parametric resonance"
        ),
        printed=(
            Limit("growth_a", "growth rate with damping", low=0.0, unit="1/s"),
            Limit("growth_b", "growth rate without damping", low=0.0, unit="1/s"),
            Limit(
                "late_ratio",
                "depth of the beats in the last 100 s, with over without damping",
                high=0.1,
            ),
        ),
        finding=(
            "In Fig. 13 the pendulum is resonant with damping and without it; damping takes "
            "{rate_loss:.1%} off the growth rate, but {depth_loss:.1%} off the late beats."
        ),
        why=(
            "C/(2ml) is subtracted from the growth rate, which here is {growth_ratio:.0f} times "
            "larger. Near the edges of the tongue damping does decide."
        ),
    ),
    Statement(
        name="saturation-by-damping",
        where="text on Fig. 2",
        words=(
            "leads to the stagnation of amplitude changes. The reason for this is the presence of "
            "the damping term"
        ),
        printed=(
            Limit(
                "largest_d",
                "largest angle without damping, if damping is what bounds it",
                low=np.pi,
                unit="rad",
            ),
        ),
        finding=(
            "In Fig. 13d, without damping, the angle stays below {largest_d:.4f} rad, and its "
            "beats return to {beat_d1:.4f}, {beat_d2:.4f} and {beat_d3:.4f} rad."
        ),
        why="Detuning by the amplitude bounds the motion; damping only removes the beats.",
    ),
    Statement(
        name="subharmonic",
        where="Introduction",
        words=(
            "exponentially growing solutions of the Mathieu equation exhibit identical patterns "
            "to the subharmonic responses of time crystals"
        ),
        printed=(
            Limit("sign_a", "sign of the factor per drive period, eq14", high=-1.0),
            Limit("sign_c", "the same for eq10 in the last 50 s", high=-1.0),
            Limit(
                "two_period_change",
                "change over two drive periods in the last 50 s of eq10, relative",
                high=0.02,
            ),
        ),
        finding=(
            "In Fig. 13 the angle changes its sign from one drive period to the next, and after "
            "two periods it has returned within {two_period_change:.2%}."
        ),
        why=(
            "In the primary tongue the Floquet multiplier is negative, so the response has twice "
            "the drive's period. One pendulum shows the pattern, not the rigidity of a time "
            "crystal."
        ),
    ),
)


def data(quick: bool = False) -> xr.Dataset:
    """Return the four panels' angles."""
    from latolato.simulation.run import simulate

    times = instants(DURATION, paper.DRIVE.drive_frequency)
    runs = {
        panel: simulate(system, paper.DRIVE, initial_angle=paper.SMALL_ANGLE, times=times)
        for panel, (system, _) in CASES.items()
    }
    rates = [
        mathieu_growth_rate(
            drive_amplitude=paper.DRIVE.drive_amplitude,
            drive_frequency=paper.DRIVE.drive_frequency,
            **paper.body(system),
        )
        for system, _ in CASES.values()
    ]
    return stack(runs, title=TITLE, keep=("angle", "angular_velocity")).assign(
        growth_rate=quantity(
            "growth_rate", "case", np.array(rates), long_name="growth rate by Hill's determinant"
        ),
        damping=quantity("damping", "case", [system.damping for system, _ in CASES.values()]),
    )


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 13's statements need."""
    time = dataset.time.values
    found: dict[str, float] = {}
    for case in ("a", "b"):
        angle = dataset.angle.sel(case=case).values
        rate, sign = measure.growth_per_period(
            time, angle, samples_per_period=SAMPLES_PER_PERIOD, first=MEASURED_FROM, last=DURATION
        )
        hill = float(dataset.growth_rate.sel(case=case))
        found |= {
            f"growth_{case}": rate,
            f"sign_{case}": sign,
            f"hill_{case}": hill,
            f"growth_error_{case}": abs(rate / hill - 1.0),
            f"factor_{case}": float(np.max(np.abs(angle)) / abs(angle[0])),
        }
    for case in ("c", "d"):
        chosen = dataset.sel(case=case)
        when, sizes = measure.peaks(time, chosen.angle.values, chosen.angular_velocity.values)
        beat_times, beat_sizes = measure.beats(when, sizes)
        between = sizes[(when > beat_times[0]) & (when < beat_times[1])]
        late = sizes[when > DURATION - 100.0]
        found |= {
            f"largest_{case}": float(sizes.max()),
            f"depth_{case}": float(1.0 - between.min() / beat_sizes[0]),
            f"late_depth_{case}": float(1.0 - late.min() / late.max()),
            f"spacing_{case}": float(beat_times[1] - beat_times[0]),
        }
        found |= {f"beat_{case}{i + 1}": float(beat_sizes[i]) for i in range(3)}
    strobe = dataset.angle.sel(case="c").values[::SAMPLES_PER_PERIOD]
    strobe = strobe[-int(50.0 / (time[SAMPLES_PER_PERIOD] - time[0])) :]
    rate = found["hill_a"]
    return found | {
        "sign_c": float(np.sign(np.max(strobe[1:] / strobe[:-1]))),
        "two_period_change": float(np.max(np.abs(strobe[2:] / strobe[:-2] - 1.0))),
        "late_ratio": found["late_depth_c"] / found["late_depth_d"],
        "depth_loss": 1.0 - found["late_depth_c"] / found["late_depth_d"],
        "rate_loss": 1.0 - rate / found["hill_b"],
        "growth_ratio": found["hill_b"] / (found["hill_b"] - rate),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) to (d)."""
    figure, axes = style.new_figure(2, 2, height=4.2)
    time = dataset.time.values
    shown = time <= LINEAR_SHOWN
    for axis, (case, (_, equation)) in zip(axes.flat, CASES.items(), strict=True):
        chosen = dataset.sel(case=case)
        damping = float(chosen.damping)
        title = f"{equation}, $C$ = {damping:g}" + (" kg m/s" if damping else "")
        style.panel_title(axis, case, title)
        if case in "ab":
            angle = chosen.angle.values[shown]
            axis.plot(time[shown], angle, color=style.GREEN, lw=0.7)
            # The envelope through the largest swing shown.
            top = int(np.argmax(np.abs(angle)))
            envelope = abs(angle[top]) * np.exp(
                float(chosen.growth_rate) * (time[shown] - time[top])
            )
            for sign in (-1.0, 1.0):
                axis.plot(time[shown], sign * envelope, color=style.INK, lw=style.THIN, ls="--")
            axis.set_xlim(0.0, LINEAR_SHOWN)
            axis.annotate(
                f"growth rate {float(chosen.growth_rate):.5f} 1/s",
                (0.04, 0.92),
                xycoords="axes fraction",
                fontsize=style.SMALL,
                va="top",
            )
        else:
            axis.plot(time, chosen.angle, color=style.BLUE, lw=0.5)
            when, sizes = measure.peaks(time, chosen.angle.values, chosen.angular_velocity.values)
            beat_times, beat_sizes = measure.beats(when, sizes)
            marked = beat_sizes > measure.VISIBLE_BEAT * sizes[-40:].mean()
            axis.plot(
                beat_times[marked], beat_sizes[marked], "o", ms=2.4, color=style.RED, clip_on=False
            )
            axis.set_xlim(0.0, DURATION)
        axis.set_xlabel(style.label(dataset.time))
    highest = 1.08 * float(np.abs(dataset.angle.sel(case=["c", "d"])).max())
    for axis in axes[1]:
        axis.set_ylim(-highest, highest)
    for row in axes:
        row[0].set_ylabel(style.label(dataset.angle, short=True))
    return figure
