"""Colours of balls and background, taken from frames."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import distance_transform_edt, find_objects, label, map_coordinates

from latolato.experiment.opencv import import_cv2
from latolato.experiment.tracking.appearance import Appearance, Colours
from latolato.experiment.video import Frame

# Part of its largest share of the exposure from which the ball covers a pixel long enough to show
# its colours.
_SEEN = 0.5


def filled(behind: np.ndarray) -> np.ndarray:
    """Return the background with unseen places filled, in place, from their nearest neighbours."""
    unseen = ~np.isfinite(behind).all(axis=-1)
    if not unseen.any() or unseen.all():
        return behind
    # Neighbours are next to what is unseen, and the whole picture may be large.
    rows, columns = (np.flatnonzero(unseen.any(axis=axis)) for axis in (1, 0))
    part = np.s_[max(rows[0] - 1, 0) : rows[-1] + 2, max(columns[0] - 1, 0) : columns[-1] + 2]
    nearest = distance_transform_edt(unseen[part], return_distances=False, return_indices=True)
    behind[part] = behind[part][tuple(nearest)]
    return behind


def first_paint(
    shots: list[tuple[Frame, np.ndarray, float]], colours: Colours, radius: float
) -> np.ndarray:
    """Return the typical colours of balls: frame, centre and turn of each [pixels, rad]."""
    each = [
        painted(frame[2:], at, turn, colours, radius, 0.88 * radius) for frame, at, turn in shots
    ]
    return filled(np.median(each, axis=0))


def painted(
    planes: tuple[np.ndarray, ...],
    centre: np.ndarray,
    turn: float,
    colours: Colours,
    radius: float,
    inner: float,
) -> np.ndarray:
    """Return the colours of planes about a centre, turned back; NaN beyond `inner`."""
    corner, shape = _around(centre, radius)
    image = np.nan_to_num(colours.window(planes, corner, shape))
    return _turned_back(image, centre - corner, turn, radius, inner)


def unmixed_paint(
    look: Appearance,
    ball: int,
    frame: Frame,
    path: np.ndarray,
    pivot: np.ndarray,
    turn: float,
    inner: float,
) -> np.ndarray:
    """Return a ball's colours about its centre, turned back, without the wall that shows through.

    Parameters
    ----------
    look : Appearance
        Edge, exposure and background.
    ball : int
        Its number.
    frame : Frame
        What shows the ball.
    path : numpy.ndarray, shape (sample, 2)
        Its centres within the exposure [pixels].
    pivot : numpy.ndarray, shape (2,)
        The pivot [pixels].
    turn : float
        By how much its colours are turned [rad].
    inner : float
        Distance from the centre from which they are NaN [pixels]. So they are where it is seldom
        during the exposure.
    """
    centre = path.mean(axis=0)
    corner, shape = _around(centre, look.radius)
    share = look.ball(ball, path, pivot, corner, shape)[..., 3:]
    mixed = look.colours.window(frame[2:], corner, shape)
    is_seen = share > _SEEN * share.max()
    image = np.full_like(mixed, np.nan)
    np.divide(mixed - (1.0 - share) * look.wall(corner, shape), share, image, where=is_seen)
    return _turned_back(image, centre - corner, turn, look.radius, inner)


def quantile_of_seen(each: np.ndarray, share: float) -> np.ndarray:
    """Return a quantile of values (ball, ...) over those that are known, NaN where none is."""
    order = np.sort(each, axis=0)  # puts them first
    at = share * np.maximum(np.isfinite(order).sum(axis=0) - 1, 0)
    low, high = (
        np.take_along_axis(order, end.astype(int)[None], axis=0)[0]
        for end in (np.floor(at), np.ceil(at))
    )
    return np.asarray(low + (at - np.floor(at)) * (high - low))


def _half(radius: float) -> int:
    """Return half the side of a paint [pixels]."""
    return int(np.ceil(1.3 * radius)) + 2


def _around(centre: np.ndarray, radius: float) -> tuple[np.ndarray, tuple[int, int]]:
    """Return corner and shape of the window from which a paint about a centre is taken."""
    reach = int(1.5 * _half(radius)) + 2
    return np.floor(centre).astype(int) - reach, (2 * reach + 2, 2 * reach + 2)


def _turned_back(
    image: np.ndarray, centre: np.ndarray, turn: float, radius: float, inner: float
) -> np.ndarray:
    """Return the colours of an image about a centre, turned back; NaN beyond `inner`."""
    half = _half(radius)
    j, i = np.indices((2 * half + 1, 2 * half + 1)) - half
    x = centre[0] + i * math.cos(turn) + j * math.sin(turn)
    y = centre[1] - i * math.sin(turn) + j * math.cos(turn)
    paint = np.empty((*i.shape, 3), np.float32)
    for k in range(3):
        map_coordinates(image[..., k], (y, x), paint[..., k], 1, mode="nearest")
    paint[np.hypot(i, j) > inner] = np.nan
    return paint


def turned(paint: np.ndarray, turn: float) -> np.ndarray:
    """Return colours (row, column, 3) about a centre turned back, as by `painted` [rad]."""
    cv2, half = import_cv2(), (len(paint) - 1) / 2
    back = cv2.getRotationMatrix2D((half, half), -math.degrees(turn), 1.0)
    return np.asarray(cv2.warpAffine(paint, back, paint.shape[:2], borderMode=cv2.BORDER_REPLICATE))


def learn_background(
    medians: tuple[np.ndarray, ...],
    frames: list[Frame],
    colours: Colours,
    covered: list[tuple[int, np.ndarray]],
    window: tuple[np.ndarray, np.ndarray],
    reach: float,
) -> np.ndarray:
    """Return the background of a window in linear light, shape (row, column, 3).

    What balls hid in much of the sample comes from the other frames, or else from its neighbours.

    Parameters
    ----------
    medians : tuple of numpy.ndarray
        Planes of what most of the frames show.
    frames, colours : list of Frame, Colours
        The sample, and how its planes are light.
    covered : list of (int, numpy.ndarray)
        Numbers of frames in the sample, each with a place of a ball [pixels].
    window : tuple of numpy.ndarray, shape (2,)
        First column and row, and the first ones beyond [pixels].
    reach : float
        How far balls hide what is behind them [pixels].
    """
    low, (width, height) = window[0], window[1] - window[0]
    behind = colours.window(medians, low, (int(height), int(width)))
    discs = [[at - low for k, at in covered if k == n] for n in range(len(frames))]
    count = np.zeros(behind.shape[:2], np.uint8)
    for own in discs:
        count += _under(own, reach, count.shape)
    often = count > 0.2 * len(frames)
    for part in find_objects(label(often)[0]):
        here, corner = often[part], np.array([part[1].start, part[0].start])
        shown = np.empty((len(frames), np.count_nonzero(here), 3), np.float32)
        for k, frame in enumerate(frames):
            shown[k] = colours.window(frame[2:], low + corner, here.shape)[here]
            shown[k][_under([at - corner for at in discs[k]], reach, here.shape)[here]] = np.nan
        # The lower median of frames that show a pixel, which sorting puts first; none: unknown.
        shown.sort(axis=0)
        middle = np.maximum(np.isfinite(shown).sum(axis=0) - 1, 0) // 2
        behind[part][here] = np.take_along_axis(shown, middle[None], axis=0)[0]
    return filled(behind)


def _under(places: list[np.ndarray], reach: float, shape: tuple[int, ...]) -> np.ndarray:
    """Return which pixels of a window are nearer than `reach` to one of some places in it."""
    is_under = np.zeros(shape, bool)
    for x, y in places:
        left, top = max(0, int(x - reach)), max(0, int(y - reach))
        part = is_under[top : max(0, int(y + reach) + 2), left : max(0, int(x + reach) + 2)]
        j, i = np.ogrid[: part.shape[0], : part.shape[1]]
        part |= np.hypot(i + left - x, j + top - y) < reach
    return is_under
