"""From pixels to angles about the moving pivot: centre of the circle, scale, direction of gravity.

The centre that a template gives lies near the hinge, not on it. Seen from the moving pivot, the
ball runs on a circle about the hinge, which shows the offset when the arc is wide. A circle fitted
in the image instead would be biased, for a driven pivot moves in phase with the swing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from latolato.experiment.tracking.follow import Followed

# Arc above which the circle tells its centre [rad], and offset that a click may have [pixels, arm].
_WIDE_ARC = math.radians(60.0)
_NEAR, _NEAR_SHARE = 5.0, 0.01
# Arc from which the hinge's place across it is looked for [rad]; errors of a click and of distances
# on the whole [pixels].
_NARROW_ARC, _CLICK, _UNROUND = math.radians(12.0), 1.0, 0.15
# Residual of the circle above which lens or perspective are suspected [pixels, arm].
_ROUND, _ROUND_SHARE = 0.35, 1.2e-3
# Stroke of the pivot from which its axis is taken as vertical [pixels].
_STROKE = 6.0
# Distance from its axis at which a pivot was not seen right [standard deviations], and how far it
# may scatter about an axis as a share of its stroke.
_JUMP, _ASIDE = 4.0, 0.02
# Lean from which a motion of the pivot is no drive [rad].
_LEAN = math.radians(40.0)
# Error of positions that no scatter shows [pixels].
_SYSTEMATIC = 0.05
# Samples from which on distances from the circle tell of errors, and the distance from which it is
# no chance [standard deviations].
_FEW, _FAR_OFF = 20, 4.0
# Parts of the pivot's axis that are compared.
_PARTS = 8
# How much larger errors along the circle may be than across.
_ROUGH = 2.0


@dataclass(frozen=True, kw_only=True)
class Optics:
    """What is declared of the camera.

    Parameters
    ----------
    row_time : float
        Time between the exposures of two rows of a rolling shutter [s]; a frame's time stamp is
        that of its first row.
    lens_k1, lens_k2 : float
        Radial distortion: an undistorted distance ``s`` from the middle of the picture, in units of
        half its diagonal, is seen at ``s (1 + k1 s^2 + k2 s^4)``.
    """

    row_time: float = 0.0
    lens_k1: float = 0.0
    lens_k2: float = 0.0


@dataclass
class Calibration:
    """Geometry of a clip.

    Attributes
    ----------
    angles, sigmas : numpy.ndarray, shape (frame, ball)
        Angles from gravity's direction [rad].
    pivots, centres : numpy.ndarray, shape (frame, [ball,] 2)
        Undistorted positions (column, row) [pixels], the pivot at its hinge.
    arm : float
        Distance from hinge to ball [pixels].
    offset : numpy.ndarray, shape (2,)
        From the clicked pivot to the hinge [pixels].
    tilt : float
        Direction of gravity from straight down in the image, positive to the right [rad].
    tilt_source : str
        ``"drive axis"``, ``"rest position"`` or ``"image"``.
    arc : float
        Range of angles seen [rad].
    circle_residual : float
        Root mean square distance from the circle [pixels].
    offset_sigma : float
        Standard deviation of what all angles have in common: gravity's direction and the hinge's
        place [rad]; NaN if gravity's direction is unknown.
    warnings : list of str
        What the user should know.
    """

    angles: np.ndarray
    sigmas: np.ndarray
    pivots: np.ndarray
    centres: np.ndarray
    arm: float
    offset: np.ndarray
    tilt: float
    tilt_source: str
    arc: float
    circle_residual: float
    offset_sigma: float
    warnings: list[str] = field(default_factory=list)


def calibrate(
    seen: Followed, size: tuple[int, int], rotation: int, optics: Optics | None = None
) -> Calibration:
    """Return angles about the hinge from positions in the image.

    Parameters
    ----------
    seen : Followed
        Raw positions.
    size : tuple of int
        Width and height of the picture as displayed [pixels].
    rotation : int
        Clockwise turn between sensor and display [degrees].
    optics : Optics
        What is declared of the camera.
    """
    optics = optics or Optics()
    pivots = _on_rail(undistorted(seen.pivots, size, optics))
    centres = undistorted(seen.centres, size, optics)
    balls = centres.shape[1]
    if optics.row_time:
        delay_pivot = optics.row_time * _sensor_row(seen.pivots, size, rotation)
        delay_ball = optics.row_time * _sensor_row(seen.centres, size, rotation)
        about = np.stack(
            [
                _moved(seen.times + delay_pivot, pivots, seen.times + delay_ball[:, b])
                for b in range(balls)
            ],
            axis=1,
        )
        pivots = _moved(seen.times + delay_pivot, pivots, seen.times)
    else:
        about = np.repeat(pivots[:, None], balls, axis=1)
    is_measured = np.isin(seen.flags, ("ok", "collision", "occluded")) & np.isfinite(seen.angles)
    is_clean = seen.flags == "ok"
    away = centres - about
    use = is_clean if is_clean.sum() >= 20 else is_measured
    reach = np.where(use, np.hypot(away[..., 0], away[..., 1]), np.nan)
    noise = float(np.nanmin([_scatter(seen.times, reach[:, b]) for b in range(balls)] + [1e3]))
    offset, arm, arc, residual, warnings = _hinge(away[use], seen.angles[use], noise)
    raw = np.arctan2(away[..., 0] - offset[0], away[..., 1] - offset[1])
    angles = seen.angles + np.remainder(raw - seen.angles + math.pi, 2.0 * math.pi) - math.pi
    if optics.row_time:
        for b in range(balls):
            angles[:, b] = _moved(seen.times + delay_ball[:, b], angles[:, b : b + 1], seen.times)[
                :, 0
            ]
    off = np.hypot(away[..., 0] - offset[0], away[..., 1] - offset[1]) - arm
    sigmas = _honest(seen.times, angles, seen.sigmas, off, seen.spreads, is_clean, arm)
    tilt, source = _gravity(pivots, angles, is_clean)
    if source == "image":
        warnings.append(
            "gravity's direction is unknown (the pivot rests and no free decay was seen): "
            "angles are from straight down in the picture"
        )
    return Calibration(
        angles - tilt,
        sigmas,
        pivots + offset,
        centres,
        arm,
        offset,
        tilt,
        source,
        arc,
        residual,
        _offset_sigma(pivots, source, arc, residual, arm),
        warnings,
    )


def unsmeared(times: np.ndarray, pivots: np.ndarray, exposure: float) -> np.ndarray:
    """Return where the pivot is amid the exposure from its means over the exposure [s].

    The mean of a bent path over a time ``e`` lies ``a e^2/24`` beside its middle.
    """
    if len(times) < 3 or exposure <= 0.0:
        return pivots
    early = np.diff(pivots, axis=0) / np.diff(times)[:, None]
    bend = np.zeros_like(pivots)
    bend[1:-1] = 2.0 * np.diff(early, axis=0) / (times[2:] - times[:-2])[:, None]
    bend[0], bend[-1] = bend[1], bend[-2]
    return np.asarray(pivots - bend * exposure**2 / 24.0)


def undistorted(places: np.ndarray, size: tuple[int, int], optics: Optics) -> np.ndarray:
    """Return positions as a lens without distortion would show them [pixels]."""
    if not (optics.lens_k1 or optics.lens_k2):
        return places
    middle = (np.array(size) - 1.0) / 2.0
    unit = 0.5 * math.hypot(*size)
    seen = (places - middle) / unit
    distance = np.linalg.norm(seen, axis=-1, keepdims=True)
    true = distance.copy()
    for _ in range(30):  # a contraction for the distortions of usable lenses
        true = distance / (1.0 + optics.lens_k1 * true**2 + optics.lens_k2 * true**4)
    straight: np.ndarray = middle + seen * (true / np.maximum(distance, 1e-12)) * unit
    return straight


def _sensor_row(places: np.ndarray, size: tuple[int, int], rotation: int) -> np.ndarray:
    """Return the sensor's row of displayed positions."""
    x, y = places[..., 0], places[..., 1]
    width, height = size
    if rotation == 90:
        return np.asarray(width - 1.0 - x)
    if rotation == 180:
        return np.asarray(height - 1.0 - y)
    return np.asarray(x) if rotation == 270 else np.asarray(y)


def _moved(times: np.ndarray, values: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return values (time, component) at nearby instants; NaN stays NaN."""
    from scipy.interpolate import Akima1DInterpolator

    out = np.full_like(values, np.nan)
    ok = np.isfinite(values).all(axis=1) & np.isfinite(times)
    if ok.sum() < 3:
        return out
    curve = Akima1DInterpolator(times[ok], values[ok], axis=0, extrapolate=True)
    target = ok & np.isfinite(wanted)
    out[target] = curve(wanted[target])
    return out


def _honest(
    times: np.ndarray,
    angles: np.ndarray,
    sigmas: np.ndarray,
    off: np.ndarray,
    spreads: np.ndarray,
    is_clean: np.ndarray,
    arm: float,
) -> np.ndarray:
    """Return standard deviations that are not below the scatter seen in the clip [rad].

    A fit's residuals know nothing of errors that neighbouring pixels share (compression, texture)
    nor of the pivot's. Two things do, and the larger raises all deviations by one factor: the
    scatter about the quintic through the six neighbours, and the distances from the circle (`off`,
    `spreads` as the fits say [pixels]), which also see what lasts for many frames. The quintic is
    believed up to twice the other: fast swings between contacts are none. A ball that is far off
    the circle is no better known along it.
    """
    raised: np.ndarray = np.hypot(sigmas, _SYSTEMATIC / arm)
    stated = np.hypot(spreads, _SYSTEMATIC)
    for b in range(angles.shape[1]):
        clean = is_clean[:, b] & np.isfinite(off[:, b] / stated[:, b])
        if not clean.any():
            continue
        factor = 1.0
        rest = off[:, b] - float(np.median(off[clean, b]))
        if clean.sum() >= _FEW:
            pulls = np.abs(rest[clean] / stated[clean, b])
            limit = _FAR_OFF * 1.4826 * float(np.median(pulls))
            factor = max(factor, float(np.sqrt(np.mean(np.minimum(pulls, limit) ** 2))))
        scatter = _scatter(times, np.where(clean, angles[:, b], np.nan))
        if math.isfinite(scatter):
            along = scatter / float(np.median(raised[clean, b]))
            factor = max(factor, min(along, _ROUGH * factor))
        raised[:, b] *= factor
        far = clean & (np.abs(rest) > _FAR_OFF * factor * stated[:, b])
        raised[far, b] = np.maximum(raised[far, b], np.abs(rest[far]) / arm)
    return raised


def _scatter(times: np.ndarray, values: np.ndarray) -> float:
    """Return the noise of a smooth series: what neighbours do not foretell (robust)."""
    if len(values) < 20:
        return math.nan
    others = np.array([-3, -2, -1, 1, 2, 3])
    at = np.arange(3, len(values) - 3)
    apart = times[at[:, None] + others] - times[at][:, None]
    weights = np.ones_like(apart)
    for j in range(6):
        for k in range(6):
            if j != k:
                weights[:, j] *= apart[:, k] / (apart[:, k] - apart[:, j])
    rest = values[at] - np.sum(weights * values[at[:, None] + others], axis=1)
    rest = rest / np.sqrt(1.0 + np.sum(weights**2, axis=1))
    rest = rest[np.isfinite(rest)]
    return 1.4826 * float(np.median(np.abs(rest))) if len(rest) >= 10 else math.nan


def _hinge(
    away: np.ndarray, angles: np.ndarray, noise: float
) -> tuple[np.ndarray, float, float, float, list[str]]:
    """Return the hinge's offset, the arm, the arc, the circle's residual and warnings.

    `noise` is the scatter of the distances [pixels], which is no fault of the circle.
    """
    from scipy.optimize import least_squares

    warnings: list[str] = []
    distance = np.hypot(away[:, 0], away[:, 1])
    arm = float(np.median(distance)) if len(distance) else math.nan
    turned = np.mod(angles + math.pi, 2.0 * math.pi) - math.pi
    arc = float(np.ptp(np.quantile(turned, [0.005, 0.995]))) if len(turned) else 0.0
    none = np.zeros(2)
    if len(away) < 20:
        return none, arm, arc, math.nan, warnings

    def rest(p: np.ndarray) -> np.ndarray:
        return np.asarray(np.hypot(away[:, 0] - p[0], away[:, 1] - p[1]) - p[2])

    fit = least_squares(rest, [0.0, 0.0, arm], loss="soft_l1", f_scale=0.3)
    offset, found = fit.x[:2], float(fit.x[2])
    residual = float(1.4826 * np.median(np.abs(rest(fit.x))))
    as_clicked = float(1.4826 * np.median(np.abs(distance - arm)))
    if arc < _WIDE_ARC:
        return _across(away, angles, arc, arm), arm, arc, as_clicked, warnings
    # Lenses and perspective make an oval: its second harmonic beside the circle.
    direction = np.arctan2(away[:, 0] - offset[0], away[:, 1] - offset[1])
    waves = np.stack([np.cos(2 * direction), np.sin(2 * direction)], axis=-1)
    oval = float(np.hypot(*np.linalg.lstsq(waves, rest(fit.x), rcond=None)[0]))
    limit = max(_ROUND, _ROUND_SHARE * found, 2.0 * noise)
    too_far = float(np.hypot(*offset)) > max(_NEAR, _NEAR_SHARE * found)
    bent = math.sqrt(max(residual**2 - noise**2, 0.0))
    if bent > limit or oval > 1.5 * limit or too_far:
        warnings.append(
            f"the ball does not run on a circle about the pivot (centre off by "
            f"{np.hypot(*offset):.1f} pixels, residual {max(bent, oval):.2f} pixels): lens or "
            "perspective; the pivot is used as clicked"
        )
        return none, arm, arc, as_clicked, warnings
    return offset, found, arc, residual, warnings


def _across(away: np.ndarray, angles: np.ndarray, arc: float, arm: float) -> np.ndarray:
    """Return the hinge's offset across the middle of a narrow arc, along which it tells nothing.

    Distances grow along the arc when the hinge lies aside; the click is believed to `_CLICK`, the
    distances on the whole to `_UNROUND`.
    """
    if arc < _NARROW_ARC:
        return np.zeros(2)
    middle = 0.5 * float(np.sum(np.quantile(angles, [0.005, 0.995])))
    lean = np.sin(np.mod(angles - middle + math.pi, 2.0 * math.pi) - math.pi)
    distance = np.hypot(away[:, 0], away[:, 1])
    # distance = arm + offset * lean, with the offset drawn to zero.
    centred = lean - lean.mean()
    fitted = float(np.sum(centred * distance) / np.sum(centred**2))
    error = _UNROUND / float(np.std(lean))
    offset = fitted / (1.0 + (error / _CLICK) ** 2)
    if abs(offset) > max(_NEAR, _NEAR_SHARE * arm):
        return np.zeros(2)
    return offset * np.array([math.cos(middle), -math.sin(middle)])


def _on_rail(pivots: np.ndarray) -> np.ndarray:
    """Return pivots with those on their axis that jump aside, where a rod or the wall misled.

    Only a pivot that runs up and down an axis and mostly stays on it has such.
    """
    ok = np.isfinite(pivots).all(axis=1)
    keep = ok.copy()
    for _ in range(4):
        if keep.sum() < 20:
            return pivots
        middle = pivots[keep].mean(axis=0)
        _, sizes, axes = np.linalg.svd(pivots[keep] - middle, full_matrices=False)
        aside = (pivots - middle) @ axes[1]
        scatter = 1.4826 * float(np.median(np.abs(aside[ok])))
        keep = ok & (np.abs(aside) <= _JUMP * max(scatter, _SYSTEMATIC))
    stroke = 2.0 * math.sqrt(2.0) * sizes[0] / math.sqrt(max(int(keep.sum()), 1))
    if stroke < _STROKE or scatter > _ASIDE * stroke or keep.sum() < 0.7 * ok.sum():
        return pivots
    out = pivots.copy()
    jumps = ok & ~keep
    out[jumps] -= np.outer(aside[jumps], axes[1])
    return out


def _gravity(pivots: np.ndarray, angles: np.ndarray, is_clean: np.ndarray) -> tuple[float, str]:
    """Return gravity's direction from straight down in the image, and where it comes from."""
    ok = np.isfinite(pivots).all(axis=1)
    centred = pivots[ok] - pivots[ok].mean(axis=0)
    _, sizes, axes = np.linalg.svd(centred, full_matrices=False)
    stroke = 2.0 * math.sqrt(2.0) * sizes[0] / math.sqrt(max(len(centred), 1))
    is_upright = abs(float(axes[0][1])) > math.cos(_LEAN)
    if stroke > _STROKE and sizes[1] < 0.2 * sizes[0] and is_upright:
        axis = axes[0] * np.sign(axes[0][1])
        return float(math.atan2(axis[0], axis[1])), "drive axis"
    if stroke < 0.25 * _STROKE or not is_upright:
        rest = _rest_position(angles, is_clean)
        if rest is not None:
            return rest, "rest position"
    return 0.0, "image"


def _offset_sigma(
    pivots: np.ndarray, source: str, arc: float, residual: float, arm: float
) -> float:
    """Return the standard deviation of what all angles have in common [rad].

    Where the pivot passes, the wall draws it aside by as much in every stroke: the means in parts
    of its axis scatter about a straight line, and neighbouring parts alike, which doubles the
    error of the line. About the rest position the hinge's place cancels.
    """
    if source == "rest position":
        return 0.5 * _UNROUND / arm
    if source == "image":
        return math.nan
    ok = np.isfinite(pivots).all(axis=1)
    _, _, axes = np.linalg.svd(pivots[ok] - pivots[ok].mean(axis=0), full_matrices=False)
    along, aside = (pivots[ok] @ axis for axis in axes)
    part = np.floor((along - along.min()) / (np.ptp(along) + 1e-9) * _PARTS).astype(int)
    count = np.bincount(part, minlength=_PARTS)
    seen = count > 0
    if seen.sum() < 4:
        return math.nan
    places = (np.bincount(part, along, _PARTS) / np.maximum(count, 1))[seen]
    means = (np.bincount(part, aside, _PARTS) / np.maximum(count, 1))[seen]
    line = np.polyfit(places, means, 1)
    rest = means - np.polyval(line, places)
    scatter = math.sqrt(float(np.sum(rest**2)) / (len(rest) - 2))
    axis = 2.0 * scatter / math.sqrt(float(np.sum((places - places.mean()) ** 2)))
    if arc >= _WIDE_ARC:
        hinge = 0.5 * residual
    elif arc >= _NARROW_ARC:
        hinge = 1.0 / math.hypot(1.0 / _CLICK, arc / (2.0 * math.sqrt(2.0) * _UNROUND))
    else:
        hinge = _CLICK
    return math.hypot(axis, hinge / arm)


def _rest_position(angles: np.ndarray, is_clean: np.ndarray) -> float | None:
    """Return the angle about which free swings decay, from three successive extremes each.

    ``(a1 + 2 a2 + a3)/4`` of successive extremes is the rest position up to second order of the
    decrement, whatever the amplitude. Two balls of equal frequency have it in the mean of their
    angles, which impacts between equal balls do not change.
    """
    swings = [angles[:, b] for b in range(angles.shape[1])]
    clean = [is_clean[:, b] for b in range(angles.shape[1])]
    moves = [np.nanstd(s) > 0.01 for s in swings]
    if len(swings) == 2 and all(moves):
        swing, ok = 0.5 * (swings[0] + swings[1]), np.isfinite(swings[0] + swings[1])
        if np.nanstd(swing) < 0.02:
            return float(np.nanmedian(swing))
    elif any(moves):
        b = moves.index(True)
        swing, ok = swings[b], clean[b] & np.isfinite(swings[b])
    else:
        return None
    extremes = _extremes(swing[ok])
    if len(extremes) < 4:
        return None
    middles = 0.25 * (extremes[:-2] + 2.0 * extremes[1:-1] + extremes[2:])
    # Only swings below a right angle all the way have no other rest position beside.
    return float(np.median(middles)) if np.max(np.abs(extremes)) < 2.0 else None


def _extremes(swing: np.ndarray) -> np.ndarray:
    """Return successive extremes of a swing, each from a parabola through its top."""
    middle = float(np.median(swing))
    side = np.sign(swing - middle)
    changes = np.flatnonzero(np.diff(side) != 0) + 1
    found = []
    for begin, end in pairwise(changes):
        part = swing[begin:end] - middle
        if len(part) < 5:
            continue
        k = int(np.argmax(np.abs(part)))
        a, b = max(0, k - max(2, len(part) // 6)), min(len(part), k + max(2, len(part) // 6) + 1)
        t = np.arange(a, b) - k
        c2, c1, c0 = np.polyfit(t, part[a:b], 2)
        found.append(middle + (c0 - c1 * c1 / (4.0 * c2) if c2 != 0.0 else part[k]))
    return np.array(found)
