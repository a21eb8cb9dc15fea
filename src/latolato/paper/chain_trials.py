"""Sets of trials of Figs. 9 and 11 through the chain: some by synthetic video, others simulated."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato import Harmonic, LatoLato, Pendulum
from latolato.paper import chain
from latolato.paper.cases import variable

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, kw_only=True)
class Trials:
    """Trials of one system, a set of equally many for each driving amplitude.

    Attributes
    ----------
    sets : tuple of (float, tuple of float)
        Driving amplitude [m] and the trials' frequency ratios of each set.
    by_video : tuple of int
        For each set, which of its trials goes through a video.
    start : tuple of (str, object)
        Of each run, as for `latolato.simulate`.
    duration, transient : float
        Of each run, and how much of it passes before the motion is judged [s].
    sigmas : tuple of (str, float)
        Standard deviations of the system's parameters that a comparison allows for.
    """

    system: Pendulum | LatoLato
    sets: tuple[tuple[float, tuple[float, ...]], ...]
    by_video: tuple[int, ...]
    start: tuple[tuple[str, Any], ...]
    duration: float
    transient: float
    fps: float = 30.0
    first_seed: int = 0
    sigmas: tuple[tuple[str, float], ...]

    def clips(self) -> list[chain.Clip]:
        """Return the trials, set by set."""
        places = [(amplitude, ratio) for amplitude, ratios in self.sets for ratio in ratios]
        return [
            chain.Clip(
                system=self.system,
                drive=Harmonic(
                    drive_amplitude=amplitude,
                    drive_frequency=ratio * self.system.natural_frequency,
                ),
                start=self.start,
                duration=self.duration,
                fps=self.fps,
                seed=seed,
            )
            for seed, (amplitude, ratio) in enumerate(places, start=self.first_seed)
        ]

    def table(self, quick: bool, full: bool) -> xr.Dataset:
        """Return the trial table: one trial of each set, all or none through a video."""
        clips = self.clips()
        size = len(clips) // len(self.sets)
        one_each = [size * i + number for i, number in enumerate(self.by_video)]
        by_video = range(len(clips)) if full else one_each
        return gather(clips, () if quick else by_video, self.transient)


def gather(clips: Sequence[chain.Clip], by_video: Collection[int], transient: float) -> xr.Dataset:
    """Return the trial table of clips, those at the numbers `by_video` through a video."""
    from latolato import collect_trials

    tables = [
        chain.film(clip) if i in by_video else chain.sample(clip) for i, clip in enumerate(clips)
    ]
    return collect_trials(tables, transient=transient)


def note_sources(dataset: xr.Dataset, title: str, failed: str) -> xr.Dataset:
    """Return a comparison of trials that says which went through a video, and which failed."""
    is_video = dataset.source.values == "synthetic video"
    videos, others = int(is_video.sum()), int((~is_video).sum())
    dataset = dataset.assign(
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
    dataset.attrs |= {"title": title, "chain": made}
    return dataset
