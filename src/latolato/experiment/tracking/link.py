"""Paths of what moves: chains of blobs through all frames of a clip, seen from both ends at once.

The best chain is found by dynamic programming (Viterbi): each blob is worth something by itself, a
step that the speed before it does not lead to costs, and so does a frame without a blob. Nothing is
predicted, lost or searched for again: what comes later tells which way was right.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from latolato.experiment.tracking.detect import Blobs, Copies

# Frames that a chain may bridge with its speed, and what each of them costs.
_BRIDGED, _MISSED = 8, 0.25
# What a chain costs that goes on anywhere else, and how much more as something hardly alike; a step
# at the edge of what is expected, the longest one in those, and what a step costs from one frame to
# the next that is longer still.
_JUMP, _OTHER, _STEP, _MOST_STEP, _LEAP = 2.5, 1.5, 0.6, 3.0, 0.6
# How far from where its speed leads a blob is expected: radii, share of the step, pixels; and where
# the speed is unknown.
_NEAR, _BENT, _LOOSE = 1.0, 0.35, 2.0
_FIRST, _FIRST_LOOSE = 6.0, 8.0
# Contrast from which a blob is clear, which is that of the clearest in half of the frames, between
# these [steps of 255]; share of it from which one counts, and how much less a long one counts.
_CLEAR, _CLEAREST, _FAINT, _LONG = 12.0, 40.0, 0.25, 0.15
# Colours that differ by so many steps of 255 are hardly alike; light counts half, for it changes
# with shading. The least share of a colour in a smear, and how much directions of colour count.
ALIKE, WEIGHTS, _FAINTEST, _DIRECTION = 25.0, np.array([0.5, 1.0, 1.0]), 0.1, 1.5
# By which factor a leap is longer than the steps before and after it, and the share of a long step
# from which one is fast.
_LEAPS, _FAST = 2.0, 0.6
# Share of the way that something typically goes without a leap below which a part hardly moves, and
# how far from the rest of the path it is something else then [radii].
_HARDLY, _ASIDE = 0.25, 2.0
# How much longer than wide a thing is a rod, and no ball.
_ROD = 5.0
# Logarithm of the ratio of radii that are hardly alike.
_SIZE = 0.7
# What a step between blobs that are hardly alike costs, and how much more one of quite others.
_UNLIKE, _MOST_UNLIKE = 0.4, 4.0
# How quickly the look of a chain follows that of its blobs, and how many that ended are kept.
_FOLLOWS, _ENDS = 0.2, 30
# What a blob is worth at most that is not what is looked for, as a share of one that is.
_UNLIKELY = 0.3
# From which worth a blob is clearly something; the share of clear ones that are the shortest.
_CLEARLY, _SLOW = 0.5, 0.25
# What a blob at a click is worth, and how near it must be: radii and pixels.
_CLICKED, _AT_CLICK, _AT_CLICK_LOOSE = 10.0, 2.0, 4.0
# By how much of the arm the distance from where a pivot is clicked varies: by tilts and by drives.
_DRIVEN = 0.35
# By how much colours [steps of 255], radii, lengths and ways of two balls may differ, in which
# share of the frames in which the one moves the other is seen, and in which share two that were
# linked apart may be at one place, as where their blobs merge.
_SAME_COLOUR, _AS_LARGE, _AS_LONG, _AS_FAR, _TWICE = 45.0, 1.7, 2.5, 0.3, 0.4
_AT_ONE_PLACE = 0.05
# A blob that is where others are in this share of the frames rests.
_RESTS = 0.5


@dataclass(frozen=True)
class Trajectory:
    """Where something that moves is in each frame.

    Attributes
    ----------
    places : numpy.ndarray, shape (frame, 2)
        Column and row [pixels]; NaN where it was not detected.
    radii, lengths : numpy.ndarray, shape (frame,)
        Of its blobs [pixels].
    colours : numpy.ndarray, shape (frame, 3)
        Of its blobs [steps of 255].
    """

    places: np.ndarray
    radii: np.ndarray
    lengths: np.ndarray
    colours: np.ndarray

    @property
    def is_seen(self) -> np.ndarray:
        """In which frames it was detected, shape (frame,)."""
        return np.asarray(np.isfinite(self.places[:, 0]))

    @property
    def radius(self) -> float:
        """Typical half width [pixels]."""
        return float(np.nanmedian(self.radii)) if self.is_seen.any() else math.nan

    @property
    def is_rod(self) -> bool:
        """Whether it is a rod and no ball: long and thin, even where it is slow."""
        is_long = self.is_seen.any() and np.nanquantile(self.lengths, 0.1) > _ROD * self.radius
        return bool(is_long)

    @cached_property
    def parts(self) -> list[np.ndarray]:
        """Numbers of the frames in which it was detected, cut where it leaps.

        A leap is a step that is longer than those before and after it lead to expect: at an impact
        a ball turns, but does not leap.
        """
        known = np.flatnonzero(self.is_seen)
        if len(known) < 3:
            return [known]
        ways = np.linalg.norm(np.diff(self.places[known], axis=0), axis=1)
        frames = np.diff(known)
        speeds = np.pad(ways / frames, 1, mode="edge")
        expected = frames * np.maximum(speeds[:-2], speeds[2:])
        leaps = np.flatnonzero(ways > self.radius + 1.0 + _LEAPS * expected) + 1
        return np.split(known, leaps)

    @cached_property
    def travel(self) -> float:
        """How far it typically goes without a leap [pixels].

        That is the mean extent of its parts between leaps, by the ways gone there: how long it
        rests does not count.
        """
        parts = [self.places[part] for part in self.parts if len(part)]
        gone = [float(np.linalg.norm(np.diff(part, axis=0), axis=1).sum()) for part in parts]
        if not sum(gone) > 0.0:
            return 0.0
        return float(np.average([_span(part) for part in parts], weights=gone))

    @property
    def roughness(self) -> float:
        """How much its steps from frame to frame differ from those before, as a share of them.

        A swing of ``n`` frames has ``2 sin(pi/n)``, what leaps about at random 1 and more.
        """
        steps = np.diff(self.places, axis=0)
        bends = np.linalg.norm(np.diff(steps, axis=0), axis=1)
        known, ways = np.isfinite(bends), np.linalg.norm(steps, axis=1)
        longest = np.maximum(ways[:-1], ways[1:])[known].sum()
        return float(bends[known].sum() / longest) if longest > 0.0 else math.inf

    def without_rests(self) -> Trajectory:
        """Return it without the parts that hardly move and are off the others: something else."""
        parts = [part for part in self.parts if len(part)]
        rests = [_span(self.places[part]) < _HARDLY * self.travel for part in parts]
        ways = [self.places[part] for part, rest in zip(parts, rests, strict=True) if not rest]
        values = [each.copy() for each in (self.places, self.radii, self.lengths, self.colours)]
        for part, rest in zip(parts, rests, strict=True):
            if rest and ways:
                away = np.concatenate(ways) - np.median(self.places[part], axis=0)
                if np.linalg.norm(away, axis=1).min() > _ASIDE * self.radius:
                    for each in values:
                        each[part] = np.nan
        return Trajectory(*values)

    @property
    def moves(self) -> np.ndarray:
        """In which frames it is seen to go about as fast as it ever does, shape (frame,)."""
        ways = np.linalg.norm(np.diff(self.places, axis=0, append=np.nan), axis=1)
        if not np.isfinite(ways).any():
            return self.is_seen
        with np.errstate(invalid="ignore"):
            return np.asarray(ways >= _FAST * np.nanquantile(ways, 0.95))

    @property
    def extent(self) -> float:
        """How far it spreads: see `extent_of` [pixels]."""
        return extent_of(self.places[self.is_seen])


def _span(places: np.ndarray) -> float:
    """Return the diagonal of all that places (place, 2) span [pixels]."""
    return float(np.hypot(*np.ptp(places, axis=0)))


def extent_of(places: np.ndarray) -> float:
    """Return the diagonal of what places (place, 2) span, but for a fiftieth at each end."""
    low, high = np.quantile(places, [0.02, 0.98], axis=0)
    return float(np.hypot(*(high - low)))


def are_alike(first: Trajectory, other: Trajectory) -> bool:
    """Return whether two things that move may be the two balls of a pair of one colour."""
    if not may_be_pair(first, other):
        return False
    one, two = (np.nanmedian(track.colours, axis=0) for track in (first, other))
    return float(np.linalg.norm((one - two) * WEIGHTS)) < _SAME_COLOUR


def may_be_pair(first: Trajectory, other: Trajectory) -> bool:
    """Return whether two things that move may be two balls by their sizes, ways and places."""
    if not (first.is_seen & other.is_seen).any():
        return False
    is_as_large = 1.0 / _AS_LARGE < other.radius / first.radius < _AS_LARGE
    # How long it is where it is slow, and not smeared.
    long, short = sorted(float(np.nanquantile(each.lengths, 0.1)) for each in (first, other))[::-1]
    is_as_long = long < _AS_LONG * short
    goes_as_far = other.travel > _AS_FAR * first.travel
    # Balls are never at one place; a thing that is one's path up to an impact and then the other's
    # is no second ball.
    apart = np.linalg.norm(first.places - other.places, axis=1)
    is_other = np.nanquantile(apart, _AT_ONE_PLACE) > first.radius
    # Where balls rest against each other, they may be one blob.
    is_often = other.is_seen[first.moves].mean() > _TWICE
    return bool(is_as_large and is_as_long and goes_as_far and is_other and is_often)


def best_chain(
    blobs: list[Blobs], worth: list[np.ndarray], radius: float, dear: float = 1.0
) -> np.ndarray:
    """Return the number of the best chain's blob in each frame, -1 for none, shape (frame,).

    Parameters
    ----------
    blobs : list of Blobs
        What moves in each frame.
    worth : list of numpy.ndarray, shape (blob,)
        What each blob is worth by itself, 1 for one that is surely right.
    radius : float
        Of what is followed, roughly [pixels].
    dear : float
        By which factor leaps, and going on anywhere else, cost more.

    Notes
    -----
    A blob keeps the speed and the typical look of the best chain that ends there, so a chain that
    is worse up to a blob and better beyond it may be missed. A chain that ends may go on anywhere
    later, for a price.
    """
    # Frame by frame in one array: the blobs of the last frames are a slice of it.
    all_ = Blobs(*map(np.concatenate, zip(*blobs, strict=True)))
    frames = np.repeat(np.arange(len(blobs)), [len(own.radii) for own in blobs])
    firsts = np.searchsorted(frames, np.arange(len(blobs) + 1)).tolist()
    # Of the best chain that ends at a blob: worth, speed [pixels per frame], look, blob before.
    totals, speeds, looks = np.zeros(len(frames)), np.full((len(frames), 2), np.nan), _looks(all_)
    origins, goes_on = np.full(len(frames), -1), np.zeros(len(frames), bool)
    own_looks, places = looks.copy(), all_.places
    ended = np.zeros(0, int)
    for frame, (first, beyond) in enumerate(pairwise(firsts)):
        early, begin = (firsts[max(frame - k, 0)] for k in (_BRIDGED + 1, _BRIDGED))
        both = np.concatenate([ended, early + np.flatnonzero(~goes_on[early:begin])])
        ended = both[np.argsort(-totals[both], kind="stable")[:_ENDS]]
        before = np.concatenate([ended, np.arange(begin, first)])
        if first == beyond or not len(before):
            totals[first:beyond] += worth[frame]
            continue
        # First the leaps from chains that ended, then the steps from the last frames.
        now, jumps = slice(first, beyond), len(ended)
        costs = _unlike(own_looks[now], looks[before])
        costs[:, :jumps] = dear * (_JUMP + _OTHER * costs[:, :jumps])
        costs[:, jumps:] *= _UNLIKE
        costs[:, jumps:] += _steps(
            places, speeds, frames, now, slice(begin, first), radius, dear * _LEAP
        )
        values = totals[before] - costs
        at = np.argmax(values, axis=1)
        best = values[np.arange(len(at)), at]
        better = np.flatnonzero(best > 0.0)
        source, at, best = before[at[better]], at[better], best[better]
        better += first
        totals[better], origins[better], goes_on[source] = best, source, True
        looks[better] = looks[source]
        speeds[better] = places[better] - places[source]
        speeds[better] /= (frame - frames[source])[:, None]
        speeds[better[at < jumps]] = np.nan
        totals[now] += worth[frame]
        looks[now] += _FOLLOWS * (own_looks[now] - looks[now])
    chain = np.full(len(blobs), -1)
    node = int(np.argmax(totals)) if np.any(totals > 0.0) else -1
    while node >= 0:
        chain[frames[node]] = node - firsts[frames[node]]
        node = int(origins[node])
    return chain


def _looks(blobs: Blobs) -> np.ndarray:
    """Return what tells blobs from each other, shape (blob, 4): 1 if they are hardly alike.

    That is which way their colour differs from the background, for a smear is a mixture of the
    two, and their size.
    """
    change = (blobs.colours - blobs.walls) * WEIGHTS
    length = np.maximum(np.linalg.norm(change, axis=1), ALIKE)
    size = np.log(np.maximum(blobs.radii, 0.1)) / _SIZE
    return np.column_stack([_DIRECTION * change / length[:, None], size])


def _unlike(looks: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return how unlike looks are, shape (look, other): 1 for hardly alike."""
    first, *rest = (
        (one[:, None] - other) ** 2 for one, other in zip(looks.T, others.T, strict=True)
    )
    return np.asarray(np.minimum(first + sum(rest), _MOST_UNLIKE))


def _steps(
    places: np.ndarray, speeds: np.ndarray, frames: np.ndarray, now: slice, before: slice,
    radius: float, leap: float,
) -> np.ndarray:  # fmt: skip
    """Return what steps from earlier blobs to those of a frame cost, shape (blob, earlier).

    None from one frame to the next costs more than a `leap`.
    """
    apart = frames[now.start] - frames[before]
    is_known = np.isfinite(speeds[before, 0])
    led = np.where(is_known[:, None], speeds[before], 0.0) * apart[:, None]
    # Column by column: numpy is slow along an axis of two.
    u, v = (
        place[:, None] - earlier - way
        for place, earlier, way in zip(places[now].T, places[before].T, led.T, strict=True)
    )
    reach = np.where(
        is_known,
        _NEAR * radius + _BENT * np.linalg.norm(led, axis=-1) + _LOOSE,
        _FIRST * radius * apart + _FIRST_LOOSE,
    )
    off = np.sqrt(u * u + v * v)
    cost = _STEP * (off / reach) ** 2 + _MISSED * (apart - 1)
    cost[off > _MOST_STEP * reach] = np.inf
    # From one frame to the next it may leap: a fast ball at few frames a second.
    return np.asarray(np.minimum(cost, np.where(apart == 1, leap, np.inf)))


def worth_of(
    blobs: Blobs, clear: float, colour: np.ndarray | None = None, radius: float | None = None
) -> np.ndarray:
    """Return what blobs are worth by themselves, shape (blob,): clear, round, and alike.

    `clear` is the contrast of a clear one [steps of 255].
    """
    long = blobs.lengths / np.maximum(blobs.radii, 0.1)
    share = np.clip((blobs.contrasts / clear - _FAINT) / (1.0 - _FAINT), 0.0, 1.0)
    worth = share * np.clip(1.0 + _LONG * (4.0 - long), 0.2, 1.0)
    if colour is not None:
        # The nearest mixture of the colour and the wall there: a smear is one.
        whole = (colour - blobs.walls) * WEIGHTS
        seen = (blobs.colours - blobs.walls) * WEIGHTS
        share = np.sum(whole * seen, axis=1) / np.maximum(np.sum(whole**2, axis=1), 1.0)
        away = seen - np.clip(share, _FAINTEST, 1.0)[:, None] * whole
        worth = worth * (0.1 + 0.9 * np.exp(-np.sum((away / ALIKE) ** 2, axis=1)))
    if radius is not None:
        worth = worth * np.exp(-((np.log(np.maximum(blobs.radii, 0.1) / radius) / _SIZE) ** 2))
    return np.asarray(worth)


def length_of_clear(blobs: list[Blobs]) -> float:
    """Return the half length of clear blobs that are no smears, 0 if there are none [pixels]."""
    clear = _clear(blobs)
    lengths = [own.lengths[worth_of(own, clear) > _CLEARLY] for own in blobs]
    return float(np.quantile(np.concatenate(lengths), _SLOW)) if any(map(len, lengths)) else 0.0


def _clear(blobs: list[Blobs]) -> float:
    """Return the contrast of a clear blob: what is clearest in half of the frames that show any."""
    tops = [float(own.contrasts.max()) for own in blobs if len(own.contrasts)]
    return float(np.clip(np.median(tops), _CLEAR, _CLEAREST)) if tops else _CLEAREST


def link_clicked(
    blobs: list[Blobs],
    copies: Copies,
    click: np.ndarray,
    number: int,
    radius: float | None,
    pivot: np.ndarray | None = None,
) -> tuple[Trajectory, list[Blobs]]:
    """Return the path of what is clicked in a frame, and the blobs that are left.

    The click is a detection as any other, and surely right: where no blob is near it, as of a ball
    that rests in most of the clip, it is one by itself.

    Parameters
    ----------
    blobs, copies : list of Blobs, Copies
        What moves in each frame, and small pictures of these.
    click : numpy.ndarray, shape (2,)
        Column and row [pixels].
    number : int
        The frame; one beyond the clip is not looked at.
    radius : float or None
        Of what is clicked [pixels], None if it is not known.
    pivot : numpy.ndarray, shape (2,), optional
        About which it swings, in the clicked frame [pixels]; it may be driven.
    """
    blobs, colour = list(blobs), None
    worth = None
    if 0 <= number < len(blobs):
        own = blobs[number]
        away = np.linalg.norm(own.places - click, axis=1)
        near = away < np.maximum(_AT_CLICK * own.lengths, _AT_CLICK_LOOSE * copies.shrink)
        if near.any():
            at = int(np.argmin(np.where(near, away, np.inf)))
            radius, colour = float(own.radii[at]), own.colours[at]
        else:
            size = radius or 2.0 * copies.shrink
            colour, at = copies.colour(number, click, size), len(own.radii)
            row = (click, size, size, _CLEAREST, colour, colour)
            blobs[number] = own = Blobs(
                *(np.concatenate([values, [one]]) for values, one in zip(own, row, strict=True))
            )
        worth = np.full(len(own.radii), -_CLICKED)
        worth[at] = _CLICKED
    clear = _clear(blobs)
    worths = [worth_of(each, clear, colour, radius) for each in blobs]
    if pivot is not None:
        arm = float(np.hypot(*(click - pivot)))
        for own, each in zip(blobs, worths, strict=True):
            off = np.abs(np.linalg.norm(own.places - pivot, axis=1) / arm - 1.0)
            each *= np.exp(-((off / _DRIVEN) ** 2))
    if worth is not None:
        worths[number] = worth
    return _taken(blobs, best_chain(blobs, worths, radius or 2.0 * copies.shrink))


def link_alike(
    blobs: list[Blobs], first: Trajectory, dear: float = 1.0
) -> tuple[Trajectory, list[Blobs]]:
    """Return the path of what looks like something that was linked, and the blobs that are left.

    Leaps cost more than usual by the factor `dear`.
    """
    colour, clear = np.nanmedian(first.colours, axis=0), _clear(blobs)
    worths = [worth_of(each, clear, colour, first.radius) - _UNLIKELY for each in blobs]
    return _taken(blobs, best_chain(blobs, worths, first.radius, dear))


def link_movers(blobs: list[Blobs], copies: Copies, most: int, dear: float) -> list[Trajectory]:
    """Return the paths of what moves, the best ones first, at most some.

    Leaps cost more than of what is clicked by the factor `dear`: nothing else tells what belongs
    together.

    Blobs that are always at the same place count little: they are where something was in most of
    the clip, or flickers.
    """
    resting, clear = _resting(blobs, copies), _clear(blobs)
    worths = [
        worth_of(own, clear) * (1.0 - 0.9 * rests)
        for own, rests in zip(blobs, resting, strict=True)
    ]
    paths: list[Trajectory] = []
    for _ in range(most):
        radii = np.concatenate(
            [own.radii[worth > _CLEARLY] for own, worth in zip(blobs, worths, strict=True)]
        )
        if not len(radii):
            break
        chain = best_chain(blobs, worths, float(np.median(radii)), dear)
        path, blobs = _taken(blobs, chain)
        worths = [
            np.delete(worth, at) if at >= 0 else worth
            for worth, at in zip(worths, chain, strict=True)
        ]
        paths.append(path)
    return paths


def _taken(blobs: list[Blobs], chain: np.ndarray) -> tuple[Trajectory, list[Blobs]]:
    """Return a chain as a path, and the blobs that are left."""
    count = len(blobs)
    places, radii = np.full((count, 2), np.nan), np.full(count, np.nan)
    lengths, colours = np.full(count, np.nan), np.full((count, 3), np.nan)
    left = list(blobs)
    for frame in np.flatnonzero(chain >= 0).tolist():
        own, at = blobs[frame], chain[frame]
        places[frame], radii[frame] = own.places[at], own.radii[at]
        lengths[frame], colours[frame] = own.lengths[at], own.colours[at]
        left[frame] = own.without(at)
    return Trajectory(places, radii, lengths, colours), left


def _resting(blobs: list[Blobs], copies: Copies) -> list[np.ndarray]:
    """Return which blobs are where others are in many frames, shape (blob,) for each frame."""
    rows, columns = copies.pictures.shape[1:3]
    seen = np.zeros((rows // 2 + 1, columns // 2 + 1))
    cells = [np.clip((copies.small(own.places) / 2.0).astype(int), 0, None) for own in blobs]
    for own in cells:
        u, v = own.T
        seen[np.minimum(v, seen.shape[0] - 1), np.minimum(u, seen.shape[1] - 1)] += 1.0
    # A blob may lie across the border of two cells.
    padded = np.pad(seen, 1)
    around = sum(
        padded[j : j + seen.shape[0], i : i + seen.shape[1]] for j in range(3) for i in range(3)
    )
    often = np.asarray(around) > _RESTS * len(blobs)
    return [
        often[np.minimum(own[:, 1], seen.shape[0] - 1), np.minimum(own[:, 0], seen.shape[1] - 1)]
        for own in cells
    ]
