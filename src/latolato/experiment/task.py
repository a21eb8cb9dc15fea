"""A video that is ready to be tracked: its set-up, given, read or found, and its first reading."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from pathlib import Path
from typing import Any, Literal

import numpy as np

from latolato.core.errors import InputError, Sentence, reading
from latolato.experiment.rules import broken, place_text
from latolato.experiment.sidecar import (
    OUTSIDE,
    Setup,
    checked_place,
    read_sidecar,
    with_changes,
)
from latolato.experiment.tracking.propose import proposal_text, propose
from latolato.experiment.tracking.sample import Sample, read_sample
from latolato.experiment.tracking.steady import Bar, steadied
from latolato.experiment.video import Video, open_video

Place = Sequence[float]
Pivot = Place | Literal["outside"]
Progress = Callable[[float], None]
# Share of the first reading in the work.
READ = 0.3
# How near to each other a pivot and balls may be [pixels].
_APART = 8.0
# Fewest frames that show a motion.
_FEWEST = 8
# How far from where it is clicked, and from its rod, a ball may reach, as a share of the arm.
_ABOUT = 0.15
# How far from the picture a pivot may be, in diagonals of the picture.
_FARTHEST = 10.0


@dataclass
class Task:
    """A video that is ready to be tracked."""

    video: Video
    setup: Setup
    sample: Sample | None = None
    warnings: list[Sentence] = field(default_factory=list)
    # Of a ball that was found, roughly [pixels].
    radius: float | None = None
    # Where the set-up was read from, None if it was given or found.
    setup_file: Path | None = None


def prepare(
    path: Path,
    pivot: Pivot | Sequence[Pivot] | None,
    balls: int | Sequence[Place] | None,
    settings: dict[str, Any],
    sidecar: str | Path | None = None,
    progress: Progress | None = None,
) -> Task:
    """The tracking task, set up by the arguments, by a sidecar, or as found in the video."""
    declared = with_changes(Setup(pivot=None, balls=()), settings)
    clicks = None if isinstance(balls, int) or balls is None else list(balls)
    count = balls if isinstance(balls, int) else len(clicks) if clicks else None
    if count is not None and count not in (1, 2):
        raise InputError("must be 1 or 2", parameter="balls", value=count)
    own = _own_pivots(pivot)
    if own:
        if count == 1:
            raise InputError("two pivots need two {parameter}", parameter="balls", value=count)
        count = 2
    with reading(path):
        if pivot is None and clicks is None and sidecar is not None and Path(sidecar).is_file():
            stored = read_sidecar(sidecar, path)
            if settings.get("click_frame") not in (None, stored.click_frame):
                raise InputError(
                    f"is {stored.click_frame} in '{sidecar}', which has the places of that frame",
                    parameter="click_frame",
                    way_out="remove the file, or point at pivot and balls",
                )
            setup = with_changes(stored, settings)
            both = {one[:2]: one for one in (*stored.corrections, *setup.corrections)}
            setup = replace(setup, corrections=tuple(sorted(both.values())))
            if count is not None and count != len(setup.balls):
                raise InputError(
                    f"'{sidecar}' is made for {len(setup.balls)} balls, not {count}",
                    way_out="remove it, or point at pivot and balls",
                )
            video = _video_of(path, setup, setup.slow_motion)
            messages = [proposal_text(setup)] if setup.is_proposed else []
            return Task(video, _checked(setup, video), warnings=messages, setup_file=Path(sidecar))
        pivots = own or (None if pivot is None else _checked_pivot(pivot), None)
        pointed_at = {"pivot": pivots[0], "pivot_2": pivots[1], "balls": clicks}
        setup = with_changes(declared, {**pointed_at, "has_own_pivots": bool(own)})
        video = _video_of(path, setup, settings.get("slow_motion"))
        setup = replace(setup, slow_motion=video.slow_motion)
        if settings.get("click_frame") is None:
            setup = replace(setup, click_frame=video.first_frame)
        setup = _checked(setup, video)
        if pivot is not None and clicks is not None:
            return Task(video, _right_first(setup))
        video, sample = read_task(video, setup, progress)
        known = OUTSIDE if own or (pivot is not None and setup.pivot is None) else setup.pivot
        proposal, size, sample = propose(
            video, sample, pivot=known, balls=clicks, count=count, optics=setup.optics,
            click_frame=settings.get("click_frame"),
        )  # fmt: skip
        pivot_1, pivot_2 = proposal.pivot, proposal.pivot_2
        if own:
            places = [place for place in own if place is not None]
            if clicks is None and len(places) == 2:
                pivots = tuple(sorted(places, reverse=True))
            pivot_1, pivot_2 = pivots
        setup = replace(
            setup, pivot=pivot_1, pivot_2=pivot_2, balls=proposal.balls, is_proposed=True,
            is_pivot_found=pivot is None,
            has_own_pivots=bool(own) or proposal.has_own_pivots,
            click_frame=proposal.click_frame if clicks is None else setup.click_frame,
        )  # fmt: skip
        return Task(video, setup, sample, [proposal_text(setup)], size)


def _checked_pivot(pivot: Any) -> tuple[float, float] | None:
    """Return a pivot's place [pixels], None where it is out of the picture and to be fitted."""
    return None if isinstance(pivot, str) and pivot == OUTSIDE else checked_place("pivot", pivot)


def _own_pivots(pivot: Any) -> tuple[tuple[float, float] | None, ...]:
    """Return the places of two pivots, nothing for one or none."""
    if pivot is None or isinstance(pivot, str) or all(isinstance(one, Real) for one in pivot):
        return ()
    if len(pivot) != 2:
        raise InputError("must be one pivot, or two", parameter="pivot", value=len(pivot))
    return tuple(_checked_pivot(one) for one in pivot)


def _right_first(setup: Setup) -> Setup:
    """Return a set-up whose right-hand ball comes first if balls have pivots of their own."""
    if not setup.has_own_pivots or setup.balls[0][0] >= setup.balls[1][0]:
        return setup
    return replace(setup, balls=setup.balls[::-1], pivot=setup.pivot_2, pivot_2=setup.pivot)


def _video_of(path: Path, setup: Setup, slow_motion: float | None) -> Video:
    """Return the part of a video that a set-up names, at the file's own pace if none is known."""
    start = -math.inf if setup.start is None else setup.start
    end = math.inf if setup.end is None else setup.end
    if not start < end:
        raise InputError(f"must lie after start ({start:g} s)", parameter="end", value=end)
    video = open_video(path, slow_motion=slow_motion, limits=setup.limits, start=start, end=end)
    return replace(video, region=setup.region)


def check_count(frames: int) -> None:
    """Refuse a video of too few frames."""
    if frames < _FEWEST:
        raise broken("too_few_frames", {"count": frames, "least": _FEWEST})


def read_task(video: Video, setup: Setup, progress: Progress | None) -> tuple[Video, Sample]:
    """Return a video as a camera at rest would have taken it, and its first reading."""
    tell = part_of(progress, 0.0, READ)
    sample = read_sample(video, tell, setup.click_frame - video.first_frame)
    check_count(len(sample.times))
    hidden = []
    for ball, own in zip(setup.balls, setup.pivots, strict=True):
        arm = math.dist(ball, own or (0.5 * video.width, 0.0))
        hidden.append(Bar(np.array(ball), np.array(own or ball), _ABOUT * arm))
    return steadied(video, sample, hidden)


def _checked(setup: Setup, video: Video) -> Setup:
    """Return a set-up that is complete: balls in frame and region, the pivot not too far away."""
    if (setup.stick is None) != (setup.stick_length is None):
        missing = "stick" if setup.stick is None else "stick_length"
        raise broken("half_stick", parameter=missing)
    named = [("ball", place) for place in setup.balls]
    named += [("end of the stick", place) for place in setup.stick or ()]
    for frame, ball, u, v in setup.corrections:
        named.append((f"correction of ball {ball} in frame {frame}", (u, v)))
    if setup.region is not None:
        left, top, right, bottom = setup.region
        if min(right, bottom) < 0.0 or left > video.width - 1 or top > video.height - 1:
            raise InputError(
                f"the region from ({left:g}, {top:g}) to ({right:g}, {bottom:g}) lies outside the "
                f"frame of {video.width} x {video.height} pixels"
            )
        for u, v in setup.balls:
            if not (left <= u <= right and top <= v <= bottom):
                corners = {"one": place_text((left, top)), "other": place_text((right, bottom))}
                raise broken("outside_region", {"place": place_text((u, v)), **corners})
    for name, (u, v) in named:
        if not video.shows((u, v)):
            raise InputError(
                f"{name} at ({u:g}, {v:g}) lies outside the frame of {video.width} x "
                f"{video.height} pixels"
            )
    for own, centre in zip(setup.pivots, setup.balls, strict=True):
        if own is not None and math.dist(own, centre) < _APART:
            raise broken("pivot_on_ball", {"least": _APART})
    if len(setup.balls) == 2 and math.dist(setup.balls[0], setup.balls[1]) < _APART:
        raise broken("near_balls", {"least": _APART})
    readout = setup.optics.row_time * video.height
    if video.frame_rate and readout * video.frame_rate > 1.0:
        frames = {"rows": video.height, "pause": 1.0 / video.frame_rate}
        row_time = setup.optics.row_time
        raise broken("long_readout", frames, parameter="row_time", value=row_time)
    reach = _FARTHEST * math.hypot(video.width, video.height)
    for u, v in filter(None, (setup.pivot, setup.pivot_2)):
        if math.hypot(u - 0.5 * video.width, v - 0.5 * video.height) > reach:
            raise InputError(
                f"the pivot at ({u:g}, {v:g}) is farther than {reach:.0f} pixels from the picture",
                way_out=f"use '{OUTSIDE}' to fit it from the arc",
            )
    return setup


def part_of(progress: Progress | None, low: float, high: float) -> Progress | None:
    """Return a progress that goes from one share of the work to another."""
    if progress is None:
        return None
    tell = progress
    return lambda share: tell(low + (high - low) * share)
