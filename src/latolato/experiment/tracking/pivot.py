"""Where the pivot is in each frame: a template learned from the video, moved to fit each frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.ndimage import binary_dilation, gaussian_filter, label

from latolato.experiment.rules import broken, place_text
from latolato.experiment.tracking.kernels import shifts as kernels
from latolato.experiment.video import Frame

# Residuals beyond this many standard deviations count little.
_LIMIT = 16.0
# Least distance of the pivot from the edge of the picture [pixels].
_MARGIN = 4
# Shifts smaller than this are noise: the pivot rests; smears below the second are none [pixels].
_STILL, _SMEARED = 0.2, 0.3
# Arm up to which the sizes of the picture's details below hold as they are, and grow beyond: in a
# larger picture of the same pivot they are larger, and it moves by more pixels [pixels].
_USUAL_ARM = 340.0
# Half sides of templates that are tried, and of the part that shows the change [pixels].
_SIZES, _INNER = (6, 9, 13, 19, 27, 38, 54), 9
# Half side, as a share of the arm, of the template that all that moves with the pivot may join.
_GROWN = 0.15
# Least difference from the wall that shows the pivot: luma levels, share of the contrast.
_SHOWS, _SHOWS_SHARE = 4.0, 0.3
# How much of the wall around the pivot belongs to its edge [pixels].
_EDGE = 2
# Shares of the frames, the slowest first, that a template is learned from, and how far the pivot
# moves between them for the wall to be told from it [pixels].
_SLOWEST, _SPREAD = (0.4, 0.6, 0.8), 2.0
# Frames in which templates of several sizes are compared.
_JUDGES = 8
# Pixels by which a template moves that does not rest, and the share of the clearness of one that
# rests at which it is believed.
_MOVES, _SUFFICES = 4.0, 0.5
# Share of the frames in which a string may hide what belongs to a template, and how wide it may be
# to either side: in radii of the ball, and in pixels at least.
_HIDDEN, _WIDTH, _LEAST_WIDTH = 0.7, 0.2, 2.0
# Range of luma about a pivot below which nothing shows it, as in a dark room: it then rests; over
# how many pixels a single frame is averaged for that, for it has noise [pixels].
_PLAIN, _GRAIN = 10.0, 1.5
# Fewest pixels a template may be compared at.
_FEWEST = 12
# Noise that is assumed at first, as a share of the template's contrast.
_SHARE = 0.08
# Pixels of a template that a search looks at, and their largest distance.
_LOOKED_AT, _APART = 250.0, 6.0
# How far the pivot may come from where it is in the first frame, and from one frame to the next, as
# shares of the arm: a drive amplitude of 0.4 of the length from end to end, 0.3 at 3 Hz and 25
# frames a second; and in small pictures at least [pixels].
_FARTHEST, _NEXT, _LEAST_NEXT = 0.8, 0.25, 37.0
# The same to either side: half as far, for a search takes as long as its places are many.
_FARTHEST_ASIDE = 0.4
# How far from where it is expected a pivot is looked for, sideways and up or down [pixels].
_ASIDE, _ROOM = 2.0, 3.0
# Steps of a wide search, the share of its places about which all are looked at, and how many these
# are at least.
_COARSE, _LIKELY, _FEWEST_LIKELY = 4, 0.03, 30
# How much worse than usual a template fits that is looked for everywhere, and how much better it
# must fit there; error of a smear that is worth a second look [pixels].
_WORSE, _WORSE_BY, _BETTER, _SMEAR = 1.4, 0.1, 0.7, 1.0
# How far beyond the shifts of the sample the pivot may move: pixels, and share of their range.
_SLACK, _SLACK_SHARE = 4.0, 0.3


class Strings(NamedTuple):
    """Where strings or rods are seen: a template that they join follows them, not the pivot.

    `directions` are unit vectors from the pivot to balls, one a frame and ball, of shape (string,
    2), `half_width` is how far to either side something may belong to a string, which begins at a
    distance from the pivot [pixels].
    """

    directions: np.ndarray
    half_width: float
    begins: float = 0.0

    @classmethod
    def between(cls, pivot: np.ndarray, places: np.ndarray, radius: float) -> Strings:
        """Return those to places (place, 2) of balls of a radius, which have some [pixels]."""
        away = places - pivot
        lengths = np.hypot(*away.T)[:, None]
        return cls(away / np.maximum(lengths, 1.0), _WIDTH * radius + _LEAST_WIDTH)

    def clear(self, half: int) -> np.ndarray:
        """Return which pixels of a round template they seldom hide, shape (row, column)."""
        down, across = np.indices((2 * half + 1, 2 * half + 1)) - half
        away = np.hypot(across, down)
        hidden = np.zeros(away.shape)
        for x, y in self.directions:
            is_beside = np.abs(across * y - down * x) < self.half_width
            hidden += is_beside & (across * x + down * y > self.begins)
        return (away <= half + 0.5) & (hidden <= _HIDDEN * len(self.directions))


_NO_STRINGS = Strings(np.empty((0, 2)), 0.0)


@dataclass
class PivotTracker:
    """Follows a template of the pivot.

    Attributes
    ----------
    origin : numpy.ndarray, shape (2,)
        Position of the pivot in the first frame (column, row) [pixels].
    template, weight : numpy.ndarray, shape (row, column)
        Luma around the pivot and its inverse variance; 0 where rods or the wall are seen.
    reach : numpy.ndarray, shape (2, 2)
        Least and largest shift seen in the sample (column, row) [pixels].
    exposure : float
        Share of the frame interval in which light is collected.
    anchor : numpy.ndarray, shape (2,)
        Shift that the template has in the first frame, where the pivot was pointed at.
    is_still : bool
        Whether the pivot rests.
    enlarged : float
        How many times larger than usual the pivot's picture is, from 1 on.
    strings : Strings
        What hangs from the pivot, and does not belong to it.
    motion : callable or None
        Where the pivot is at times (time,) [pixels], if the balls tell and the picture does not.
    """

    origin: np.ndarray
    template: np.ndarray
    weight: np.ndarray
    reach: np.ndarray
    exposure: float = 0.0
    anchor: np.ndarray = field(default_factory=lambda: np.zeros(2))
    is_still: bool = False
    enlarged: float = 1.0
    strings: Strings = _NO_STRINGS
    motion: Callable[[np.ndarray], np.ndarray] | None = None

    @classmethod
    def unseen(
        cls, place: np.ndarray, motion: Callable[[np.ndarray], np.ndarray] | None = None
    ) -> PivotTracker:
        """Return one that follows nothing: of a pivot that the picture does not show.

        It rests, or moves as it is known to.
        """
        nothing = np.zeros((1, 1))
        return cls(place, nothing, nothing, np.zeros((2, 2)), is_still=True, motion=motion)

    @property
    def half(self) -> int:
        """Half the template's side [pixels]."""
        return (int(self.template.shape[0]) - 1) // 2

    def place(self, shift: np.ndarray) -> np.ndarray:
        """Positions of the pivot (column, row) for shifts (..., 2) [pixels]."""
        at: np.ndarray = self.origin + shift - self.anchor
        return at

    def place_at(self, times: np.ndarray) -> np.ndarray:
        """Positions of a pivot that the picture does not show, shape (time, 2) [pixels]."""
        if self.motion is None:
            return np.repeat(self.origin[None], len(times), axis=0)
        return self.motion(times)

    def locate(
        self,
        luma: np.ndarray,
        guess: np.ndarray | None,
        velocity: np.ndarray,
        room: np.ndarray | float = 0.0,
    ) -> tuple[np.ndarray, float]:
        """Return the pivot's shift from the origin [pixels] and how badly the template fits.

        Parameters
        ----------
        luma : numpy.ndarray
            The frame's luma.
        guess : numpy.ndarray or None
            Expected shift; None searches the whole reach.
        velocity : numpy.ndarray
            Pixels per frame interval, by which the template is smeared.
        room : numpy.ndarray, shape (2,), or float
            How much farther from the guess than usual it may be [pixels].
        """
        if self.is_still:
            return np.zeros(2), 0.0
        model, (across, down) = self.template, velocity * self.exposure
        length = float(np.hypot(across, down))
        if length >= _SMEARED:
            model = kernels.smeared(self.template, across, down, int(np.ceil(length)) + 1)
        corners, cost = self._costs(luma, guess, model, room)
        corner = self.origin - self.half
        shift: np.ndarray = corners[np.argmin(cost)] - corner
        least = kernels.refine_shift(luma, model, self.weight, _LIMIT, corner, shift)
        return shift, least / max(float(np.count_nonzero(self.weight)), 1.0)

    def margin(self, luma: np.ndarray) -> tuple[float, np.ndarray]:
        """Return how much worse the template fits elsewhere than at its best shift, and that."""
        corners, cost = self._costs(luma, None, self.template)
        best = corners[np.argmin(cost)]
        away = np.abs(corners - best).max(axis=1)
        far = cost[away > max(3, self.half // 3)]
        shift: np.ndarray = best - (self.origin - self.half)
        return float(far.min() - cost.min()) if len(far) else 0.0, shift

    def _costs(
        self,
        luma: np.ndarray,
        guess: np.ndarray | None,
        model: np.ndarray,
        room: np.ndarray | float = 0.0,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return corners by whole pixels and how badly the template fits there.

        A wide search looks at all places where a coarse one fits best.
        """
        low, high = np.floor(self.reach[0]), np.ceil(self.reach[1])
        if guess is not None:
            near = np.rint(np.clip(guess, *self.reach))
            usual = np.ceil(self.enlarged * np.array([_ASIDE, _ROOM]))
            around = usual + np.ceil(room)
            # Never much beyond the reach, however uncertain the guess is.
            low, high = (
                np.maximum(near - around, low - usual),
                np.minimum(near + around, high + usual),
            )
        is_wide = guess is None or np.max(room) >= _LEAST_NEXT
        # In an enlarged picture the template's details are too; the rest is refined below.
        fine = round(self.enlarged) if is_wide else 1
        shifts = _grid(low, high, _COARSE * fine if is_wide else fine)
        stride = _stride(self.weight > 0.0, _APART * self.enlarged)

        def compared(shifts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            corners = np.rint(self.origin - self.half + shifts).astype(np.int64)
            cost = np.empty(len(corners))
            kernels.search_shift(luma, model, self.weight, corners, _LIMIT, stride, cost)
            return corners, cost

        corners, cost = compared(shifts)
        if is_wide:
            likely = shifts[np.argsort(cost)[: max(_FEWEST_LIKELY, int(_LIKELY * len(cost)))]]
            around = fine * _grid(np.full(2, -_COARSE // 2), np.full(2, _COARSE // 2), 1)
            more = compared((likely[:, None] + around).reshape(-1, 2))
            corners, cost = np.concatenate([corners, more[0]]), np.concatenate([cost, more[1]])
        return corners, cost


def learn_pivot(
    frames: list[Frame],
    behind: np.ndarray,
    click: np.ndarray,
    arm: float,
    aside: float,
    strings: Strings,
) -> tuple[PivotTracker, np.ndarray]:
    """Return a tracker of the pivot and its shifts in the sample, shape (frame, 2).

    Parameters
    ----------
    frames : list of Frame
        The sample; the click belongs to the first.
    behind : numpy.ndarray
        Median of the luma over the sample.
    click : numpy.ndarray, shape (2,)
        The pivot in the first frame (column, row) [pixels].
    arm : float
        Distance from pivot to ball [pixels], from which the template's size and the largest
        possible drive amplitude come.
    aside : float
        How far to either side the pivot may move [pixels]; beyond 0.4 of the arm it is not looked
        for.
    strings : Strings
        What hangs from the pivot.
    """
    size = np.array([frames[0].luma.shape[1], frames[0].luma.shape[0]])
    room = int(min(*np.minimum(click, size - 1 - click)))
    if room < _MARGIN:
        raise broken("pivot_at_edge", {"place": place_text(click), "least": _MARGIN})
    half = min(max(_SIZES), room)
    # The median does not show a pivot that never comes back to where it was.
    rests, clicked = (_patch(each, click.astype(float), half) for each in (behind, frames[0].luma))
    if max(np.ptp(rests), np.ptp(gaussian_filter(clicked, _GRAIN))) < _PLAIN:
        return PivotTracker.unseen(click), np.zeros((len(frames), 2))
    tracker = _distinct(frames, behind, click.astype(float), arm, room, aside, strings)
    shifts = _first_shifts(tracker, frames, arm)
    # A pivot at rest is not learned again: rods that swing about it would join.
    rounds = 0 if _is_resting(shifts) else 4
    for round_ in range(rounds):
        shifts = locate_all(tracker, frames, shifts)
        spread = np.array([np.quantile(shifts, 0.03, axis=0), np.quantile(shifts, 0.97, axis=0)])
        slack = _SLACK * tracker.enlarged + _SLACK_SHARE * (spread[1] - spread[0])
        tracker.reach = spread + np.array([-slack, slack])
        if round_ == 1:  # the shifts are known: more of what moves with the pivot joins
            largest = int(tracker.enlarged * max(_SIZES))
            grown = min(max(2 * tracker.half, int(_GROWN * arm)), largest, room)
            tracker.template = np.zeros((2 * grown + 1, 2 * grown + 1))
        if round_ == 2:  # next to the pivot a string shows by not moving with it
            tracker.strings = strings._replace(begins=_INNER * tracker.enlarged)
        learn_template(tracker, frames, behind, shifts)
    if rounds:
        _trim(tracker)
        shifts = locate_all(tracker, frames, shifts)
    if _is_resting(shifts):
        tracker.is_still = True
        shifts[:] = 0.0
    tracker.anchor = shifts[0].copy()
    return tracker, shifts


def _trim(tracker: PivotTracker) -> None:
    """Cut off the rim of a template that is not compared anywhere."""
    half = tracker.half
    used = np.abs(np.argwhere(tracker.weight > 0.0) - half)
    kept = min(half, int(used.max(initial=0)) + _EDGE)
    inner = slice(half - kept, half + kept + 1)
    tracker.template = tracker.template[inner, inner].copy()
    tracker.weight = tracker.weight[inner, inner].copy()


def _grid(low: np.ndarray, high: np.ndarray, step: int) -> np.ndarray:
    """Return shifts (shift, 2) between two, the least included, by a step [pixels]."""
    columns, rows = (np.arange(*each, step) for each in zip(low, high + step, strict=True))
    shifts = np.empty((len(rows), len(columns), 2))
    shifts[..., 0], shifts[..., 1] = columns, rows[:, None]
    return shifts.reshape(-1, 2)


def _stride(used: np.ndarray, apart: float) -> int:
    """Return of how many pixels along a line one is looked at: of small objects all."""
    return int(min(max((np.count_nonzero(used) / _LOOKED_AT) ** 0.5, 1.0), apart))


def _is_resting(shifts: np.ndarray) -> bool:
    """Return whether shifts (frame, 2) are noise."""
    away = np.abs(shifts - np.median(shifts, axis=0))
    scatter = 1.4826 * np.median(away, axis=0)
    return bool(np.all((scatter < _STILL) & (np.quantile(away, 0.9, axis=0) < 2.0 * _STILL)))


def _first_shifts(tracker: PivotTracker, frames: list[Frame], arm: float) -> np.ndarray:
    """Return the pivot's shifts in the sample; a frame's successor is looked for nearby."""
    shifts: list[np.ndarray] = []
    room = max(_LEAST_NEXT, _NEXT * arm)
    for k, frame in enumerate(frames):
        follows = k > 0 and frame.number == frames[k - 1].number + 1
        guess = shifts[-1] if follows else None
        shifts.append(tracker.locate(frame.luma, guess, np.zeros(2), room)[0])
    return np.array(shifts)


def velocities(frames: list[Frame], shifts: np.ndarray) -> np.ndarray:
    """Return shifts per frame interval in the sample, NaN where no neighbour tells."""
    speed = np.full((len(frames), 2), np.nan)
    for k in range(len(frames) - 1):
        if frames[k + 1].number == frames[k].number + 1:
            speed[k] = speed[k + 1] = shifts[k + 1] - shifts[k]
    return speed


def locate_all(tracker: PivotTracker, frames: list[Frame], shifts: np.ndarray) -> np.ndarray:
    """Return the pivot's shifts in the sample, near and smeared as the last ones tell."""
    speed = np.nan_to_num(velocities(frames, shifts))
    each = zip(frames, shifts, speed, strict=True)
    return np.array([tracker.locate(frame.luma, near, v)[0] for frame, near, v in each])


def learn_template(
    tracker: PivotTracker,
    frames: list[Frame],
    behind: np.ndarray,
    shifts: np.ndarray,
) -> None:
    """Make template and weight again from the slower frames, moved onto each other."""
    speed = np.hypot(*velocities(frames, shifts).T)
    slow = np.ones(len(frames), bool)
    for share in _SLOWEST if np.isfinite(speed).any() else ():
        slowest = speed <= max(1.0, float(np.nanquantile(speed, share)))
        # If all of them are at one turning point, the wall there seems to move with the pivot.
        if slowest.sum() >= 6 and _is_moving(shifts[slowest]) == _is_moving(shifts):
            slow = slowest
            break
    frames = [frame for frame, is_slow in zip(frames, slow, strict=True) if is_slow]
    shifts = shifts[slow]
    half = tracker.half
    inside = tracker.strings.clear(half)
    stack = np.stack(
        [
            _patch(f.luma, tracker.origin + shift, half)
            for f, shift in zip(frames, shifts, strict=True)
        ]
    )
    wall = np.stack([_patch(behind, tracker.origin + shift, half) for shift in shifts])
    template = np.median(stack, axis=0)
    as_wall = np.median((stack - wall) ** 2, axis=0)
    moves = _is_moving(shifts)
    rest = stack - template
    if moves:
        rest = _unmoved(rest, template, inside, as_wall)
    own = np.median(rest**2, axis=0)
    is_object = np.ones_like(inside)
    if moves:
        # A plain wall looks the same wherever it is: it joins only where it shows the edge.
        is_object = own < 0.5 * as_wall + 1.0
        is_sure = inside & (own < 0.25 * as_wall) & (as_wall > _SHOWS**2)
        if np.count_nonzero(is_sure) >= _FEWEST:
            is_object &= binary_dilation(_innermost(is_sure), iterations=_EDGE)
    is_object &= own < 20.0 * (np.median(own[inside]) + 4.0)
    tracker.weight = np.where(inside & is_object, 1.0 / (own + 4.0), 0.0)
    tracker.template = template


def _is_moving(shifts: np.ndarray) -> bool:
    """Return whether shifts (frame, 2) show more than one place of the pivot."""
    return float(np.ptp(np.quantile(shifts, [0.1, 0.9], axis=0), axis=0).sum()) > _SPREAD


def _unmoved(
    rest: np.ndarray, template: np.ndarray, inside: np.ndarray, as_wall: np.ndarray
) -> np.ndarray:
    """Return residuals (frame, row, column) without what a shift of each frame explains.

    Otherwise the edges, which alone tell where the pivot is, would be believed the least.
    """
    clear = inside & (as_wall > max(_SHOWS**2, _SHOWS_SHARE**2 * float(as_wall[inside].max())))
    if np.count_nonzero(clear) < _FEWEST:
        return rest
    slopes = np.stack(np.gradient(template)[::-1])
    own = slopes[:, clear]
    out = np.empty_like(rest)
    for k, each in enumerate(rest):
        seen, step = each[clear], np.zeros(2)
        for _ in range(3):
            left = seen - step @ own
            limit = max(3.0 * float(np.median(np.abs(left))), 1.0)
            trust = own / (1.0 + (left / limit) ** 2)
            step = np.linalg.solve(trust @ own.T + np.eye(2), trust @ seen)
        step = np.clip(step, -1.0, 1.0)
        out[k] = each - np.tensordot(step, slopes, 1)
    return out


def _innermost(mask: np.ndarray) -> np.ndarray:
    """Return the connected part of a mask that is nearest to the middle and not tiny.

    Others are where the pivot rested in the median of the frames.
    """
    parts, _ = label(binary_dilation(mask, iterations=_EDGE + 1))
    parts[~mask] = 0
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    away = np.hypot(*(np.indices(mask.shape) - (mask.shape[0] - 1) // 2))
    away[sizes[parts] < min(_FEWEST, sizes.max())] = np.inf
    nearest: np.ndarray = parts == parts.ravel()[np.argmin(away)]
    return nearest


def _distinct(
    frames: list[Frame],
    behind: np.ndarray,
    click: np.ndarray,
    arm: float,
    room: int,
    aside: float,
    strings: Strings,
) -> PivotTracker:
    """Return the tracker with the template that is found most clearly at one place per frame.

    A textured wall is found very clearly, always at the same place: templates are tried with and
    without what looks as the median of the frames does, and one that moves needs less to win.
    """
    enlarged = max(1.0, arm / _USUAL_ARM)
    tall = _FARTHEST * arm
    wide = min(aside, _FARTHEST_ASIDE * arm)
    inner = int(_INNER * enlarged)
    reach = np.array([[-wide, -tall], [wide, tall]])
    some = frames[:: max(1, len(frames) // _JUDGES)]
    best: dict[bool, tuple[float, PivotTracker]] = {}
    for half in sorted({min(int(size * enlarged), room) for size in _SIZES}):
        template = _patch(frames[0].luma, click, half)
        inside = strings.clear(half)
        contrast = float(np.ptp(np.quantile(template, [0.05, 0.95])))
        change = np.abs(template - _patch(behind, click, half))
        near = slice(max(half - inner, 0), half + inner + 1)
        own = float(np.quantile(change[near, near], 0.95))
        shows = inside & binary_dilation(change > max(_SHOWS, _SHOWS_SHARE * own))
        for used, height in ((inside, contrast), (shows, own)):
            if np.count_nonzero(used) < _FEWEST:
                continue
            noise = min(max(_SHARE * height, 1.0), 8.0)
            weight = np.where(used, 1.0 / noise**2, 0.0)
            tracker = PivotTracker(
                click, template, weight, reach, enlarged=enlarged, strings=strings
            )
            margins, shifts = zip(*(tracker.margin(frame.luma) for frame in some), strict=True)
            margin = float(np.quantile(margins, 0.25))
            moves = bool(np.ptp(shifts, axis=0).max() > _MOVES * enlarged)
            if moves not in best or margin > best[moves][0]:
                best[moves] = (margin, tracker)
    resting, moving = best.get(False), best.get(True)
    if moving is None or (resting is not None and moving[0] < _SUFFICES * resting[0]):
        moving = resting
    assert moving is not None
    return moving[1]


def _patch(plane: np.ndarray, centre: np.ndarray, half: int) -> np.ndarray:
    """Return a square of a plane about a position, interpolated."""
    out = np.empty((2 * half + 1, 2 * half + 1))
    kernels.resample(plane, centre[0] - half, centre[1] - half, out)
    return out


class PivotFollower:
    """Finds the pivot in one frame after the other, each near where the last ones lead."""

    def __init__(self, tracker: PivotTracker, interval: float) -> None:
        self.tracker, self.interval = tracker, interval
        # Times and shifts of the last frames, and how badly the template usually fits.
        self.shifts: list[tuple[float, np.ndarray]] = []
        self.cost = 0.0

    def place_in(self, frame: Frame, is_stale: bool) -> np.ndarray:
        """Return the pivot's place in a frame, or where it should be if that shows an older one."""
        tracker = self.tracker
        if tracker.motion is not None:
            return np.asarray(tracker.place_at(np.array([frame.time]))[0])
        guess, velocity, room = None, np.zeros(2), np.zeros(2)
        if len(self.shifts) >= 3:
            # A drive of w turns w dt of its phase in a frame: that share of its bend is unknown.
            guess, velocity, room = self._extrapolated(frame.time)
            guess = np.clip(guess, *tracker.reach)
        shift, cost = tracker.locate(frame.luma, guess, velocity, room)
        if guess is not None and cost > _WORSE * self.cost + _WORSE_BY:
            wide, wide_cost = tracker.locate(frame.luma, None, velocity)
            if wide_cost < _BETTER * cost:
                shift, cost = wide, wide_cost
        if guess is not None:
            exact = self._arrived(frame.time, shift)
            if np.max(np.abs(exact - velocity)) * tracker.exposure > _SMEAR:
                shift, cost = tracker.locate(frame.luma, shift, exact)
        if guess is not None and is_stale and not tracker.is_still:
            shift, cost = guess, self.cost
        self.cost = 0.9 * self.cost + 0.1 * cost if guess is not None else cost
        self.shifts = [*self.shifts[-3:], (frame.time, shift)]
        return tracker.place(shift)

    def _extrapolated(self, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the shift and velocity per interval to be expected, and half the last bend."""
        (t0, p0), (t1, p1), (t2, p2) = self.shifts[-3:]
        early, late = (p1 - p0) / (t1 - t0), (p2 - p1) / (t2 - t1)
        bend = 2.0 * (late - early) / (t2 - t0)
        passed = time - t2
        guess = p2 + (late + 0.5 * bend * (t2 - t1 + passed)) * passed
        velocity = (late + bend * (0.5 * (t2 - t1) + passed)) * self.interval
        return guess, velocity, 0.5 * np.abs(bend) * self.interval**2

    def _arrived(self, time: float, shift: np.ndarray) -> np.ndarray:
        """Return the velocity per interval at a frame whose shift is known."""
        (t0, p0), (t1, p1) = self.shifts[-2:]
        early, late = (p1 - p0) / (t1 - t0), (shift - p1) / (time - t1)
        bend = 2.0 * (late - early) / (time - t0)
        return np.asarray((late + 0.5 * bend * (time - t1)) * self.interval)
