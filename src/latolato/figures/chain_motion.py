"""Figs. 8 and 12 through the chain: one motion beside the computed one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import chain, comparisons, style
from latolato.figures.cases import variable
from latolato.figures.claim import Limit, Numbers, Statement
from latolato.figures.fits import ABOVE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# Frames of a report's video from which one is shown, in parts of the whole.
_SHOWN = 0.75


def statement(name: str, where: str, words: str) -> Statement:
    """Return the claim that a tracked motion and the computed one agree."""
    return Statement(
        name=name,
        where=f"{where}, through the chain",
        words=words,
        is_method_check=True,
        assumed=(
            Limit("residual", "difference of the angles in the last third", high=0.03, unit="rad"),
            Limit("phase", "difference of the phases there", high=0.03, unit="rad"),
            Limit("lasting_error", "relative difference of the lasting angles", high=0.01),
        ),
        assumption=(
            "A synthetic experiment with these parameters stands for the paper's: this tests the "
            "chain, not the paper's measurement."
        ),
        finding=(
            f"For a synthetic experiment like that of {where}, "
            "the angle computed on the fitted drive differs from the synthetic one by "
            "{residual_milli:.1f} mrad and {phase_milli:.1f} mrad of phase in the last third; the "
            "lasting angles are {synthetic:.2f}° (synthetic) and {computed:.2f}° (computed)."
        ),
        why=(
            "Only the initial angle and velocity are fitted, in the first {match:.1f} s; the drive "
            "is that fitted to the pivot's synthetic motion."
        ),
    )


def data(clip: chain.Clip, title: str, quick: bool) -> xr.Dataset:
    """Return the comparison of a clip, filmed or in a quick run sampled, with its own system."""
    from latolato.experiment.comparison.motion import compare_motion

    table = chain.sampled(clip) if quick else chain.filmed(clip)
    found = compare_motion(table, clip.system)
    # Nothing here is a measurement.
    found = found.rename({f"{n}_measured": f"{n}_synthetic" for n in ("largest", "lasting")})
    for name in ("largest_synthetic", "lasting_synthetic"):
        found[name].attrs["long_name"] = (
            found[name].attrs["long_name"].replace("measured", "synthetic")
        )
    # Where there is no phase its likeness is nothing.
    found = found.assign({n: found[n].fillna(0.0) for n in ("phase_difference", "likeness")})
    count = table.sizes["frame"]
    if quick:
        made = f"Made from {count} samples that are simulated with the tracker's noise."
    else:
        found["still"] = chain.still_of(clip, int(_SHOWN * count))
        found["rms_error"] = variable(
            (), table.attrs["rms_error"], units="rad", long_name="error of the tracked angle"
        )
        made = f"One synthetic video of {count} frames, tracked."
    found.attrs |= {"title": title, "chain": made}
    return found


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statement of a motion names."""
    synthetic, computed = float(dataset.lasting_synthetic), float(dataset.lasting_computed)
    residual, phase = float(dataset.residual_rms_late), float(dataset.phase_rms_late)
    return {
        "residual": residual,
        "residual_milli": 1e3 * residual,
        "phase": phase,
        "phase_milli": 1e3 * phase,
        "lasting_error": abs(synthetic / computed - 1.0),
        "synthetic": float(np.degrees(synthetic)),
        "computed": float(np.degrees(computed)),
        "match": float(dataset.attrs["match"]),
    }


def draw(dataset: xr.Dataset) -> Figure:
    """Return the frame, if there is a video, and angles, residual and phase."""
    filmed = "still" in dataset
    rows = ["angle", "residual", "phase"]
    figure, panels = style.new_mosaic(
        [["still", row] for row in rows] if filmed else [[row] for row in rows],
        height=4.0,
        height_ratios=[1.8, 0.9, 0.8],
        width_ratios=[1.0, 2.3] if filmed else None,
    )
    if filmed:
        chain.draw_still(panels["still"], dataset, "a")
    comparisons.draw_angles(panels["angle"], dataset)
    comparisons.draw_residual(panels["residual"], dataset)
    comparisons.draw_phase(panels["phase"], dataset)
    for letter, row in zip("bcd" if filmed else "abc", rows, strict=True):
        if row == "angle":
            style.panel_title(panels[row], letter, "tracked" if filmed else "simulated samples")
        else:
            style.panel_letter(panels[row], letter)
        panels[row].set_xlim(0.0, float(dataset.time[-1]))
        if row != "phase":
            panels[row].tick_params(labelbottom=False)
    panels["angle"].legend(**ABOVE, ncols=2)
    panels["phase"].set_xlabel(style.label(dataset.time))
    return figure
