"""Trials of Figs. 9 and 11 through the chain: some by synthetic video, the rest simulated."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.figures import chain, style
from latolato.figures.cases import variable

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


def gathered(
    clips: Sequence[chain.Clip], by_video: Collection[int], transient: float
) -> xr.Dataset:
    """Return the trial table of clips, those at the numbers `by_video` through a video."""
    from latolato.experiment.trials import collect_trials

    tables = [
        chain.filmed(clip) if i in by_video else chain.sampled(clip) for i, clip in enumerate(clips)
    ]
    return collect_trials(tables, transient=transient)


def marked(found: xr.Dataset, title: str, failed: str) -> xr.Dataset:
    """Return a comparison of trials that says which went through a video, and which failed."""
    is_video = found.source.values == "synthetic video"
    videos, others = int(is_video.sum()), int((~is_video).sum())
    found = found.assign(
        by_video=variable(
            "trial", is_video.astype(np.int8), units="1",
            long_name="whether the trial went through a video (1) or was simulated (0)",
        )
    )  # fmt: skip
    made = f"{videos} trials by synthetic video, {others} simulated with the tracker's noise."
    if not videos:
        made = f"All {others} trials are simulated with the tracker's noise."
    if failed:
        made += f" {len(failed.split(' | '))} more gave no row: {failed}."
    found.attrs |= {"title": title, "chain": made}
    return found


def draw_squares(axes: Axes, dataset: xr.Dataset, x: Any, y: Any) -> Any:
    """Draw a square around each trial by video and return the legend's entry, None without any."""
    own = dataset.by_video.values == 1
    if not own.any():
        axes.set_title("all trials simulated")
        return None
    axes.set_title("trials simulated or by synthetic video")
    return axes.scatter(
        x[own], y[own], s=70.0, marker="s", facecolors="none", edgecolors=style.INK,
        linewidths=0.9, zorder=5, label="by synthetic video",
    )  # fmt: skip
