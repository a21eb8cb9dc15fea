"""Fig. 4: the colliding pair as printed, with a push, and as a fixed-step clamp would draw it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato import ClampContact
from latolato.figures import style
from latolato.paper import measure
from latolato.paper import systems as paper
from latolato.paper.cases import instants, stack
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "The colliding pair under strong and weak drive"
CAPTION = (
    "Angle of the right ball of the mirror-symmetric pair, elastic impacts; left column: driving "
    "amplitude 0.2 m, right column: 0.02 m, on scales of their own. (a, b) As printed: at rest on "
    "the contact angle nothing ever moves. (c, d) With a push: started at rest "
    f"{paper.PUSH_WORDS}. "
    "(e, f) As printed, but with a fixed-step code that puts a ball found beyond the wall back on "
    "it and reverses its velocity: the motion grows out of the method's error, later for a "
    "smaller step. Grey lines: the contact angles."
)
DURATION = 100.0  # s
COARSE, FINE = 5e-3, 1e-3  # s, steps of the clamp
DRIVES = {"strong": paper.STRONG_DRIVE, "weak": paper.WEAK_DRIVE}
# A ball this far above the wall has visibly left it.
ONSET = 0.01  # rad


def data(quick: bool = False) -> xr.Dataset:
    """Return the angles from rest, with a push, and by the clamp at two steps."""
    from latolato import simulate

    times = instants(DURATION, paper.STRONG_DRIVE.drive_frequency, per_period=100)
    runs = {}
    for name, drive in DRIVES.items():
        for start, offset in (("rest", 0.0), ("push", paper.PUSH)):
            runs[f"{name}_{start}"] = simulate(paper.TOY, drive, initial_offset=offset, times=times)
        for kind, step in (("coarse", COARSE), ("fine", FINE)):
            runs[f"{name}_{kind}"] = simulate(
                paper.TOY,
                drive,
                initial_offset=0.0,
                times=times,
                contact=ClampContact(clamp_step=step),
            )
    return stack(runs, title=TITLE)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 4's statements need."""
    toy, time = paper.TOY, dataset.time.values
    low, high = toy.contact_angle_low, toy.contact_angle_high
    angle = {str(case): dataset.angle.sel(case=case).values for case in dataset.case.values}
    late = angle["weak_push"][time > DURATION - 10.0]
    exact = [values for case, values in angle.items() if case.endswith(("rest", "push"))]
    result: dict[str, float] = {
        "low": low,
        "high": high,
        "rise_strong_rest": float(angle["strong_rest"].max() - low),
        "largest_strong_push": float(angle["strong_push"].max()),
        "gap_strong_push": float(high - angle["strong_push"].max()),
        "late_weak_push": float(late.max() - low) / paper.PUSH,
        "lowest_gap": float(min(values.min() for values in exact) - low),
    }
    for name, drive in DRIVES.items():
        result[f"acceleration_{name}"] = drive.largest_acceleration / toy.gravity
    for kind in ("coarse", "fine"):
        result[f"onset_{kind}"] = measure.first_above(time, angle[f"strong_{kind}"], low + ONSET)
    for kind in ("bottom", "top"):
        count = dataset[f"{kind}_contacts"].sel(case="strong_push")
        result[f"{kind}_strong_push"] = float(count)
    return result | {"onset_ratio": result["onset_fine"] / result["onset_coarse"]}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) to (f)."""
    figure, axes = style.new_figure(3, 2, sharex=True, height=5.2)
    time = dataset.time.values
    toy = paper.TOY
    rows = (
        ("as printed", (("rest", style.BLUE, ""),)),
        ("with a push", (("push", style.BLUE, ""),)),
        (
            "clamp artefact",
            (("coarse", style.ORANGE, "step 5 ms"), ("fine", style.INK, "step 1 ms")),
        ),
    )
    for column, (name, drive) in enumerate(DRIVES.items()):
        for row, (title, curves) in enumerate(rows):
            axis = axes[row, column]
            for case, colour, text in curves:
                angle = dataset.angle.sel(case=f"{name}_{case}")
                axis.plot(time, angle, color=colour, lw=0.7, label=text)
            axis.axhline(toy.contact_angle_low, color=style.GREY, lw=style.THIN, zorder=0)
            if name == "strong":
                axis.axhline(toy.contact_angle_high, color=style.GREY, lw=style.THIN, zorder=0)
                axis.set_ylim(0.0, np.pi)
                style.pi_ticks(axis.yaxis, parts=4)
            else:
                axis.set_ylim(0.0, 0.42)
            if row == 2:
                axis.set_xlabel(style.label(dataset.time))
            axis.set_xlim(0.0, DURATION)
            letter = "abcdef"[2 * row + column]
            style.panel_title(axis, letter, f"{title}, $A_0$ = {drive.drive_amplitude:g} m")
    axes[2, 1].legend(loc="upper left", ncols=2)
    for wall, where, shift in (
        (toy.contact_angle_high, "contact at the top", -7),
        (toy.contact_angle_low, "contact at the bottom", 7),
    ):
        style.note(axes[0, 0], where, (DURATION, wall), (-2, shift), ha="right")
    for row in axes:
        row[0].set_ylabel(style.label(dataset.angle, short=True))
    return figure
