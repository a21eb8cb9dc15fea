"""The picture of a clip without what moves, also where a ball rests in most of the clip.

The median of each pixel over time shows what is there in most frames. Where a ball rests for longer
than it swings, as after a collision or in a hand, that is the ball, and its absence would look like
a thing of its own. Such a pixel has a second steady colour: that of the frames that differ from the
median, if these agree with each other. Of the two pictures that this makes of a place, one shows
the outline of a thing, and the other one the background: its colours go on across that outline.

A ball that swings by less than about three radii covers the middle of its place in most frames, so
the median shows it, too. If the colours from around that place are filled in, the ball stands out
in each frame, as a disc of one size. Then what is behind it is what other frames show there; only
what none of them shows stays filled in.
"""

from __future__ import annotations

import numpy as np

from latolato.experiment.opencv import import_cv2

# Frames of which the picture is made.
_SAMPLED = 61
# Differences of colour count more than those of light, which shadows have too.
_CHROMA = 2
# A difference is one above this many standard deviations of the noise, and above some steps of 255.
_CLEAR, _LEAST = 6.0, 9.0
# Fewest frames that make a second colour steady, the part of the largest difference from which they
# show it, and the part of a clear difference by which they typically differ from it at most.
_FEWEST, _CLEARLY, _STEADY = 3, 0.7, 0.5
# Fewest pixels that make a thing, the share of them that differs in a picture without it, and how
# far its rim reaches beyond [pixels].
_SMALLEST, _WHOLLY, _RIM = 6, 0.8, 2
# By which factor the outline of a thing is at least fainter in the picture without it, and how much
# clearer parts of it may be there, as a share of the outline before. Those of balls that left were
# up to 0.1, and 0.34 in a clip in which a bob never leaves its place as a whole.
_FAINTER, _CUT = 0.6, 0.2
# Share of the frames in which pixels differ about a ball that stays in its place, and not about its
# string; part of the widest disc in what differs that is wider than strings; the smallest ball
# [pixels], and the longest thing in which a ball stays [radii].
_OFTEN, _WIDE, _SMALL, _STAYS = 0.1, 0.8, 4.0, 5.0
# By which factor the radius of a ball varies at most from frame to frame, which share of its place
# it covers in some frame at least, how far it goes at least and at most [radii], and up to where
# what is about it may be its rim [radii].
_STEADY_SIZE, _COVERS, _GOES, _ABOUT = 0.9, 0.75, (0.5, 3.0), 1.2
# How far colours are taken over from around what is filled in [pixels].
_AROUND = 3.0


def background_of(pictures: np.ndarray) -> np.ndarray:
    """Return the picture (row, column, 3) of what rests behind all that is ever elsewhere.

    `pictures` are those of all frames, shape (frame, row, column, 3): luma, blue and red chroma
    [steps of 255]. What moves by less than about half its width stays in the background.
    """
    count = len(pictures)
    some = np.unique(np.linspace(0, count - 1, min(count, _SAMPLED)).astype(int))
    middle = len(some) // 2
    # By strips of rows: the pictures of a whole clip need not be in memory twice.
    strips = (
        np.partition(pictures[some, row : row + 32], middle, axis=0)[middle]
        for row in range(0, pictures.shape[1], 32)
    )
    median = np.concatenate(list(strips))
    return _uncovered(_vacated(median, pictures[some]), pictures[some])


def difference(picture: np.ndarray, wall: np.ndarray) -> np.ndarray:
    """Return how much each pixel differs [steps of 255]."""
    cv2 = import_cv2()
    luma, blue, red = cv2.split(cv2.absdiff(picture, wall))
    return np.asarray(cv2.max(luma, cv2.multiply(cv2.max(blue, red), _CHROMA)))


def clear_difference(pictures: np.ndarray, wall: np.ndarray) -> float:
    """Return from which difference on a pixel differs by more than noise [steps of 255]."""
    some = pictures[:: max(1, len(pictures) // 12)]
    typical = np.median([difference(picture, wall) for picture in some], axis=0)
    return max(_LEAST, _CLEAR * (1.4826 * float(np.median(typical)) + 0.3))


def _vacated(median: np.ndarray, pictures: np.ndarray) -> np.ndarray:
    """Return a median picture, with the background where a ball never leaves its place."""
    cv2 = import_cv2()
    limit = clear_difference(pictures, median)
    apart = np.stack([difference(picture, median) for picture in pictures])
    often = np.asarray((apart > limit).mean(axis=0) > _OFTEN).astype(np.uint8)
    often = cv2.morphologyEx(often, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    outlines, _ = cv2.findContours(often, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    result = median.copy()
    for outline in outlines:
        if min(cv2.boundingRect(outline)[2:]) > 2.0 * _SMALL:
            thing = cv2.drawContours(np.zeros_like(often), [outline], -1, 1, cv2.FILLED)
            for place in _places_of_balls(thing):
                _vacate(result, pictures, place, limit)
    return result


def _places_of_balls(thing: np.ndarray) -> list[np.ndarray]:
    """Return the parts of a thing that are wider than strings and no longer than a ball's place."""
    cv2 = import_cv2()
    depth = cv2.distanceTransform(thing, cv2.DIST_L2, 5)
    radius = float(depth.max())
    if radius < _SMALL:
        return []
    reach = _WIDE * radius
    away = cv2.distanceTransform((depth <= reach).astype(np.uint8), cv2.DIST_L2, 5)
    count, parts = cv2.connectedComponents((away < reach).astype(np.uint8))
    rim, places = np.ones((2 * _RIM + 1,) * 2, np.uint8), []
    for part in range(1, count):
        place = (parts == part).astype(np.uint8)
        _, sides, _ = cv2.minAreaRect(cv2.findNonZero(place))
        if max(sides) <= _STAYS * radius:
            places.append(cv2.dilate(place, rim))
    return places


def _vacate(result: np.ndarray, pictures: np.ndarray, place: np.ndarray, limit: float) -> None:
    """Write what is behind a ball into `result` if one is always in a place.

    That is what frames show in which it is elsewhere, or else what goes on from around it.
    """
    cv2 = import_cv2()
    x, y, width, height = cv2.boundingRect(place)
    part = np.s_[y : y + height, x : x + width]
    if place[[0, -1]].any() or place[:, [0, -1]].any():  # it may be cut there
        return
    wall, own = cv2.inpaint(result, place, _AROUND, cv2.INPAINT_TELEA)[part], place[part]
    discs = np.array([_disc(own & (difference(each[part], wall) > limit)) for each in pictures])
    radius = float(np.median(discs[:, 2]))
    covers = np.stack([
        cv2.circle(np.zeros_like(own), (round(u), round(v)), round(_ABOUT * radius) + 1, 1, -1)
        for u, v, _ in discs
    ])  # fmt: skip
    small, large = np.quantile(discs[:, 2], [0.1, 0.9])
    goes = float(np.hypot(*np.ptp(np.quantile(discs[:, :2], [0.02, 0.98], axis=0), axis=0)))
    is_ball = small > _STEADY_SIZE * large and _GOES[0] * radius < goes < _GOES[1] * radius
    if not is_ball or covers.max(axis=0)[own > 0].mean() < _COVERS:
        return
    never = own.copy()
    for row, column in np.argwhere(own):
        seen = pictures[covers[:, row, column] == 0, y + row, x + column]
        if len(seen) >= _FEWEST:
            result[y + row, x + column] = np.median(seen, axis=0)
            never[row, column] = 0
    rest = np.zeros_like(place)
    rest[part] = never
    result[...] = cv2.inpaint(result, rest, _AROUND, cv2.INPAINT_TELEA)


def _disc(mask: np.ndarray) -> tuple[float, float, float]:
    """Return the largest disc in a mask without its holes: column, row and radius [pixels]."""
    cv2 = import_cv2()
    whole = cv2.copyMakeBorder(mask, 1, 1, 1, 1, cv2.BORDER_CONSTANT)
    outlines, _ = cv2.findContours(whole, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(whole, outlines, -1, 1, cv2.FILLED)
    _, radius, _, (u, v) = cv2.minMaxLoc(cv2.distanceTransform(whole, cv2.DIST_L2, 5))
    return u - 1.0, v - 1.0, radius


def _uncovered(median: np.ndarray, pictures: np.ndarray) -> np.ndarray:
    """Return a median picture, with the background where something rests that moves at times."""
    cv2 = import_cv2()
    limit = clear_difference(pictures, median)
    apart = np.stack([difference(picture, median) for picture in pictures])
    rows, columns = np.nonzero((apart > limit).sum(axis=0) >= _FEWEST)
    if not len(rows):
        return median
    # A thing that rests a little aside differs too, but less than what is behind it.
    at = apart[:, rows, columns].astype(np.float32)
    most = np.partition(at, -_FEWEST, axis=0)[-_FEWEST]
    shows = at >= np.maximum(_CLEARLY * most, limit)
    values = pictures[:, rows, columns].astype(np.float32)
    weights = shows / shows.sum(axis=0, dtype=np.float32)
    second = np.einsum("fp,fpc->pc", weights, values)
    apart_from_it = np.abs(values - second).max(axis=-1)
    is_steady = np.einsum("fp,fp->p", weights, apart_from_it) < _STEADY * limit
    rows, columns, shows = rows[is_steady], columns[is_steady], shows[:, is_steady]
    change = np.zeros(median.shape, np.float32)
    change[rows, columns] = _weighted(second[is_steady]) - _weighted(median[rows, columns])
    # A thing and what it leaves behind differ from each other in opposite ways.
    _, ways = np.linalg.eigh(np.einsum("jic,jid->cd", change, change))
    way = change @ ways[:, -1]
    result = median.copy()
    for side in (way > 0.0, way < 0.0):
        count, labels, stats, _ = cv2.connectedComponentsWithStats(side.astype(np.uint8))
        own = labels[rows, columns]
        for number in range(1, count):
            is_away = shows[:, own == number].mean(axis=1) > _WHOLLY
            if stats[number][4] >= _SMALLEST and is_away.sum() >= _FEWEST:
                _take_away(result, median, pictures[is_away], labels == number, stats[number])
    return result


def _take_away(
    result: np.ndarray,
    median: np.ndarray,
    pictures: np.ndarray,
    thing: np.ndarray,
    box: np.ndarray,
) -> None:
    """Write what is behind a thing into `result` if the median shows its outline.

    `pictures` are those in which its pixels, the `thing`, are different: those without it if it is
    one, and those with it if the median shows the background. It lies in a `box`, which begins
    with column, row, width and height.
    """
    cv2 = import_cv2()
    x, y, width, height = box[:4].tolist()
    part = np.s_[
        max(0, y - _RIM - 2) : y + height + _RIM + 2, max(0, x - _RIM - 2) : x + width + _RIM + 2
    ]
    mask, square = thing[part].astype(np.uint8), np.ones((2 * _RIM + 1,) * 2, np.uint8)
    whole = cv2.dilate(mask, square) > 0
    other = np.median(pictures[(slice(None), *part)], axis=0).astype(np.uint8)
    without = np.where(whole[..., None], other, median[part])
    outline = whole & (cv2.erode(mask, square, borderValue=0) == 0)
    before, after = _steps(median[part])[outline], _steps(without)[outline]
    # Through a thing that never leaves its place as a whole the outline would be a new one.
    cut = np.maximum(after - before, 0.0).mean()
    if after.mean() < _FAINTER * before.mean() and cut < _CUT * before.mean():
        result[part][whole] = without[whole]


def _steps(picture: np.ndarray) -> np.ndarray:
    """Return how much colours change from pixel to pixel, shape (row, column)."""
    cv2 = import_cv2()
    weighted = _weighted(picture)
    across, down = (cv2.Sobel(weighted, cv2.CV_32F, dx, 1 - dx) for dx in (1, 0))
    return np.asarray(np.sqrt((across**2 + down**2).sum(axis=-1)))


def _weighted(picture: np.ndarray) -> np.ndarray:
    """Return light and colours by how much they count, shape (row, column, 3)."""
    return picture.astype(np.float32) * np.array([1.0, _CHROMA, _CHROMA], np.float32)
