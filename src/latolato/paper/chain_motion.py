"""Figs. 8 and 12 through the chain: one motion beside the computed one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import comparisons, style
from latolato.paper import chain
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# Where in the video the frame is that is drawn, as a part of the whole.
_STILL_AT = 0.75


def data(clip: chain.Clip, title: str, quick: bool = False, full: bool = False) -> xr.Dataset:
    """Return the comparison of a clip, filmed or in a quick run sampled, with its own system."""
    from latolato.experiment.comparison.motion import compare_motion

    table = chain.sample(clip) if quick else chain.film(clip)
    dataset = compare_motion(table, clip.system)
    # Nothing here is a measurement.
    for name in ("largest_angle", "largest_angle_after_transient"):
        about = dataset[name].attrs
        about["long_name"] = about["long_name"].replace("measured", "synthetic")
    # Where there is no phase its coherence is nothing.
    dataset = dataset.assign({n: dataset[n].fillna(0.0) for n in ("phase_difference", "coherence")})
    count = table.sizes["frame"]
    if quick:
        made = f"Made from {count} samples that are simulated with the tracker's noise."
    else:
        dataset["still"] = chain.still_of(clip, int(_STILL_AT * count))
        dataset["rms_error"] = chain.error_of(table)
        made = f"One synthetic video of {count} frames, tracked."
    dataset.attrs |= {"title": title, "chain": made}
    return dataset


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statement of a motion names."""
    synthetic = float(dataset.largest_angle_after_transient)
    computed = float(dataset.largest_angle_after_transient_computed)
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


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the frame, if there is a video, and angles, residual and phase."""
    has_still = "still" in dataset
    rows = ["angle", "residual", "phase"]
    figure, panels = style.new_mosaic(
        [["still", row] for row in rows] if has_still else [[row] for row in rows],
        height=4.0,
        height_ratios=[1.8, 0.9, 0.8],
        width_ratios=[1.0, 2.3] if has_still else None,
    )
    if has_still:
        chain.draw_still(panels["still"], dataset, "a")
    comparisons.draw_angles(panels["angle"], dataset)
    comparisons.draw_residual(panels["residual"], dataset)
    comparisons.draw_phase(panels["phase"], dataset)
    for letter, row in zip("bcd" if has_still else "abc", rows, strict=True):
        if row == "angle":
            style.panel_title(panels[row], letter, "tracked" if has_still else "simulated samples")
        else:
            style.panel_letter(panels[row], letter)
        panels[row].set_xlim(0.0, float(dataset.time[-1]))
        if row != "phase":
            panels[row].tick_params(labelbottom=False)
    panels["angle"].legend(**style.ABOVE, ncols=2)
    panels["phase"].set_xlabel(style.label(dataset.time))
    return figure
