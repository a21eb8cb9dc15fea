"""From pixels to angles about the moving pivot: centre of the circle, scale, direction of gravity.

The centre that a template gives is near the hinge, not exactly on it. Seen from the moving pivot,
the ball runs on a circle about the hinge, which shows the offset when the arc is wide. A circle
fitted in the image instead would be biased, for a driven pivot moves in phase with the swing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from latolato.core.errors import Sentence
from latolato.experiment.calibration.circle import Circle
from latolato.experiment.calibration.deviations import (
    SYSTEMATIC,
    honest_deviations,
    scatter_of,
    time_scatter,
)
from latolato.experiment.calibration.gravity import (
    STROKE,
    Gravity,
    angle_offset_sigma,
    find_gravity,
    is_upside_down,
)
from latolato.experiment.calibration.hinge import (
    CLICK_SIGMA,
    Hinge,
    find_hinge,
    other_centre,
    range_of,
)
from latolato.experiment.calibration.lens import Optics, lens_errors, undistorted
from latolato.experiment.calibration.swing import Motion
from latolato.experiment.calibration.tilt import Tilt, fit_tilt
from latolato.experiment.rules import broken, place_text, said
from latolato.experiment.tracking.positions import Positions

# Distance from its axis at which a pivot was not seen right [standard deviations], and how far it
# may scatter about an axis as a share of its stroke.
_JUMP, _ASIDE = 4.0, 0.02
# How near its circle a ball is whose string is taut, as a share of the radius.
_TAUT = 0.05
# Distance of two balls that may rest against each other, in radii: that of contact and its error.
_TOUCH = 2.1


@dataclass
class Calibration:
    """Geometry of a clip.

    Attributes
    ----------
    angles, sigmas : numpy.ndarray, shape (frame, ball)
        Angles from gravity's direction [rad].
    pivots, centres : numpy.ndarray, shape (frame, [ball,] 2)
        Undistorted positions (column, row) [pixels], the pivot at its hinge.
    hinge : Hinge
        The centre of the circle.
    gravity : Gravity
        The direction of gravity.
    angle_offset_sigma : float
        Standard deviation of the error that all angles share: direction of gravity and position
        of the hinge [rad].
    motion : Motion
        What was seen of balls and pivot, with angles from straight down in the picture.
    warnings : list of Sentence
        What the user should know.
    tilt : Tilt
        How obliquely the camera looks, which angles and `arm` are corrected for.
    """

    angles: np.ndarray
    sigmas: np.ndarray
    pivots: np.ndarray
    centres: np.ndarray
    hinge: Hinge
    gravity: Gravity
    angle_offset_sigma: float
    motion: Motion
    warnings: list[Sentence] = field(default_factory=list)
    tilt: Tilt = field(default_factory=Tilt)

    @property
    def arm(self) -> tuple[float, float]:
        """Distance from hinge to ball and its standard deviation [pixels]."""
        hinge = self.hinge
        if hinge.is_seen:
            return hinge.arm, hinge.sigma_along(self.gravity.direction)
        return hinge.arm, hinge.arm * hinge.scale_sigma


def calibrate(
    seen: Positions,
    size: tuple[int, int],
    *,
    rotation: int,
    optics: Optics | None = None,
    circle: Circle | None = None,
    pivot_sigma: float = CLICK_SIGMA,
) -> Calibration:
    """Return angles about the hinge from positions in the image.

    Parameters
    ----------
    seen : Positions
        Raw positions.
    size : tuple of int
        Width and height of the picture as displayed [pixels].
    rotation : int
        Clockwise turn between sensor and display [degrees].
    optics : Optics
        What is declared of the camera.
    circle : Circle
        The pivot, if the picture does not show it.
    pivot_sigma : float
        Standard deviation of the place where the pivot was taken to be [pixels].

    Raises
    ------
    InputError
        If the picture stands on its head.
    """
    optics = optics or Optics()
    if circle is None:
        pivots = _on_rail(undistorted(seen.pivots, size, optics))
    else:
        pivots = np.repeat(circle.centre[None], len(seen.times), axis=0)
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
    is_measured = seen.is_measured & np.isfinite(seen.angles)
    is_clean = seen.flags == "ok"
    away = centres - about
    use = is_clean if is_clean.sum() >= 20 else is_measured
    noise, tilt, sigmas, in_picture = _noise(seen.times, away, use), Tilt(), seen.sigmas, away
    if circle is None:
        hinge = find_hinge(away[use], seen.angles[use], noise=noise, pivot_sigma=pivot_sigma)
        if not optics.row_time:
            tilt = fit_tilt(centres[use], about[use], size=size, pivot_sigma=pivot_sigma) or tilt
        if tilt.angle > 0.0:
            unsure, shown = tilt.errors(away), np.linalg.norm(away, axis=-1)
            away = tilt.flat(away)
            noise = _noise(seen.times, away, use)
            hinge = find_hinge(away[use], seen.angles[use], noise=noise, pivot_sigma=pivot_sigma)
            # What a turn in the picture is in the plane.
            slopes = (shown / np.linalg.norm(away, axis=-1)) ** 2 / math.cos(tilt.angle)
            sigmas = np.hypot(sigmas * slopes, unsure)
            slant = f"{math.degrees(tilt.angle):.3g} ± {math.degrees(tilt.sigma):.1g}"
            hinge.warnings.append(said("oblique_camera", angle=slant))
    else:
        hinge = _unseen_hinge(circle, range_of(seen.angles[use]))
    offset, warnings = hinge.offset, hinge.warnings
    raw = np.arctan2(away[..., 0] - offset[0], away[..., 1] - offset[1])
    angles = seen.angles + np.remainder(raw - seen.angles + math.pi, 2.0 * math.pi) - math.pi
    if optics.row_time:
        for b in range(balls):
            angles[:, b] = _moved(seen.times + delay_ball[:, b], angles[:, b : b + 1], seen.times)[
                :, 0
            ]
    off = np.hypot(away[..., 0] - offset[0], away[..., 1] - offset[1]) - hinge.arm
    if circle is not None:  # they were followed about a place that was known less well
        before = np.linalg.norm(seen.centres - seen.pivots[:, None], axis=-1)
        sigmas = sigmas * float(np.nanmedian(before)) / hinge.arm
    honest = honest_deviations(
        seen.times, angles, sigmas=sigmas, off=off, spreads=seen.spreads, is_clean=is_clean,
        arm=hinge.arm,
    )  # fmt: skip
    is_broken = np.isin(seen.flags, ("collision", "lost"))
    late = time_scatter(
        seen.times, angles, is_clean=is_clean, is_broken=is_broken, noise=noise / hinge.arm
    )
    if late > 0.0:
        speeds = np.gradient(angles, seen.times, axis=0)
        # Next to unknown angles, the fastest.
        speeds[np.isnan(speeds)] = np.nanmax(np.abs(speeds))
        honest = np.hypot(honest, late * speeds)
        warnings.append(said("late_stamps", late=1e3 * late))
    honest = np.hypot(honest, hinge.sway / hinge.arm)
    sigmas = np.where(seen.flags == "manual", sigmas, honest)
    wrong = None
    if hinge.is_seen and not (optics.lens_k1 or optics.lens_k2 or tilt.angle):
        wrong = lens_errors(
            centres, about, use=use, angles=raw, size=size, noise=noise, pivot_sigma=pivot_sigma
        )
    if wrong is not None and np.median(np.abs(wrong[use])) > np.median(sigmas[use]):
        sigmas = np.hypot(sigmas, wrong)
        if not warnings:
            off = 1e3 * float(np.nanmax(np.abs(wrong[use])))
            warnings.append(said("distorted_path", off=off))
    elsewhere = other_centre(
        in_picture[use], seen.angles[use], hinge, noise=noise, pivot_sigma=pivot_sigma
    )
    if elsewhere is not None:
        sigmas = np.hypot(sigmas, _turned_otherwise(angles, in_picture - elsewhere, use))
        place = place_text(np.nanmedian(seen.pivots, axis=0) + elsewhere)
        pixels = f"{np.hypot(*elsewhere):.0f}"
        warnings.append(said("other_centre", place=place, pixels=pixels))
    motion = _motion(
        seen, away=away - offset, angles=angles, pivots=tilt.flat(pivots), arm=hinge.arm
    )
    down = find_gravity(motion, hinge)
    if down.swing is None and is_upside_down(motion):
        raise broken("upside_down")
    shared = angle_offset_sigma(down, hinge)
    if tilt.angle > 0.0 and down.source != "swing":
        # An oval's middle moves with its axes: the hinge is no better known than before.
        shared = math.hypot(shared, pivot_sigma / hinge.arm)
    sigmas = np.hypot(sigmas, _shared_error(angles, down, shared, hinge))
    if down.source == "image":
        warnings.append(said("unknown_gravity", angle=f"{math.degrees(down.sigma):.0f}"))
    return Calibration(
        angles=angles - down.direction,
        sigmas=sigmas,
        pivots=pivots + tilt.seen(offset),
        centres=centres,
        hinge=hinge,
        gravity=down,
        angle_offset_sigma=shared,
        motion=motion,
        warnings=warnings,
        tilt=tilt,
    )


def _turned_otherwise(angles: np.ndarray, away: np.ndarray, use: np.ndarray) -> np.ndarray:
    """Return how far angles (frame, ball) are from those of places from another centre [rad].

    What all of them share is left out: that is the direction of gravity. Where no place is known,
    it is the typical difference.
    """
    apart = np.remainder(np.arctan2(away[..., 0], away[..., 1]) - angles + math.pi, math.tau)
    apart = np.abs(apart - np.median(apart[use]))
    return np.asarray(np.where(np.isfinite(apart), apart, np.median(apart[use])))


def _noise(times: np.ndarray, away: np.ndarray, use: np.ndarray) -> float:
    """Return the scatter of the distances of places (frame, ball, 2) from the pivot [pixels]."""
    reach = np.where(use, np.hypot(away[..., 0], away[..., 1]), np.nan)
    scatters = [scatter_of(times, reach[:, b]) for b in range(reach.shape[1])]
    # Where no scatter is known, all that is off the circle may be the circle's fault.
    return min((one for one in scatters if math.isfinite(one)), default=0.0)


def _motion(
    seen: Positions, *, away: np.ndarray, angles: np.ndarray, pivots: np.ndarray, arm: float
) -> Motion:
    """Return the motion of balls at places from the hinge and of the pivot, without slack strings.

    Angles are those from straight down in the picture [rad], places are in pixels.
    """
    is_taut = np.abs(np.linalg.norm(away, axis=-1) / arm - 1.0) < _TAUT
    is_free = (seen.flags == "ok") & is_taut
    if angles.shape[1] == 2:
        apart = np.linalg.norm(away[:, 0] - away[:, 1], axis=-1)
        closing = np.abs(np.gradient(apart))
        is_free &= (apart > _TOUCH * seen.radius + 1.5 * closing)[:, None]
    places = pivots / arm * [1.0, -1.0]
    return Motion(seen.times, np.where(is_taut, angles, np.nan), places, is_free)


def unsmeared(times: np.ndarray, pivots: np.ndarray, exposure: float) -> np.ndarray:
    """The pivot's positions amid the exposure [s], shape (frame, 2), from means over it.

    The mean of a bent path over a time ``e`` lies ``a e^2/24`` beside its middle.
    """
    if len(times) < 3 or exposure <= 0.0:
        return pivots
    early = np.diff(pivots, axis=0) / np.diff(times)[:, None]
    bend = np.zeros_like(pivots)
    bend[1:-1] = 2.0 * np.diff(early, axis=0) / (times[2:] - times[:-2])[:, None]
    bend[0], bend[-1] = bend[1], bend[-2]
    return np.asarray(pivots - bend * exposure**2 / 24.0)


def _unseen_hinge(circle: Circle, arc: float) -> Hinge:
    """Return the hinge at the centre of a circle, of which an arc [rad] was seen."""
    place = circle.covariance[:2, :2]
    return Hinge(
        np.zeros(2), np.sqrt(np.diag(place)), circle.arm, arc, circle.residual, circle.warnings,
        source="declared" if circle.is_declared else "arc", scale_sigma=circle.scale_sigma,
        aside=math.sqrt(float(np.linalg.eigvalsh(place)[0])),
    )  # fmt: skip


def _shared_error(angles: np.ndarray, down: Gravity, shared: float, hinge: Hinge) -> np.ndarray:
    """Return the standard deviations of what angles have in common with each other [rad].

    A hinge that lies higher or lower makes all angles smaller or larger; by how much they are so
    about a pivot that is not seen is stated once for all. Where gravity's direction is unknown,
    angles are those from straight down in the picture, and so are deviations.
    """
    if down.source == "image":
        level = Gravity(down.direction, down.source, 0.0)
        shared = angle_offset_sigma(level, hinge)
    if not hinge.is_seen:
        return np.full_like(angles, shared)
    along = hinge.sigma_along(down.direction) / hinge.arm
    return np.hypot(shared, np.sin(angles - down.direction) * along)


def _sensor_row(places: np.ndarray, size: tuple[int, int], rotation: int) -> np.ndarray:
    """Return the sensor's row of displayed positions."""
    x, y = places[..., 0], places[..., 1]
    width, height = size
    if rotation == 90:
        return np.asarray(width - 1.0 - x)
    if rotation == 180:
        return np.asarray(height - 1.0 - y)
    return np.asarray(x) if rotation == 270 else np.asarray(y)


def _moved(times: np.ndarray, values: np.ndarray, instants: np.ndarray) -> np.ndarray:
    """Return values (time, component) at nearby instants; NaN stays NaN."""
    from scipy.interpolate import Akima1DInterpolator

    out = np.full_like(values, np.nan)
    ok = np.isfinite(values).all(axis=1) & np.isfinite(times)
    if ok.sum() < 3:
        return out
    curve = Akima1DInterpolator(times[ok], values[ok], axis=0)
    target = ok & np.isfinite(instants)
    out[target] = curve(instants[target], extrapolate=True)
    return out


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
        keep = ok & (np.abs(aside) <= _JUMP * max(scatter, SYSTEMATIC))
    stroke = 2.0 * math.sqrt(2.0) * sizes[0] / math.sqrt(max(int(keep.sum()), 1))
    if stroke < STROKE or scatter > _ASIDE * stroke or keep.sum() < 0.7 * ok.sum():
        return pivots
    out = pivots.copy()
    jumps = ok & ~keep
    out[jumps] -= np.outer(aside[jumps], axes[1])
    return out
