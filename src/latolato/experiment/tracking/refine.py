"""Measures pivot and balls in every frame of a clip, from where they roughly are."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from latolato.experiment.calibration.hinge import CLICK_SIGMA
from latolato.experiment.tracking.appearance import arc, fit_balls, samples_for
from latolato.experiment.tracking.learn import ImageModel
from latolato.experiment.tracking.pivot import PivotFollower
from latolato.experiment.tracking.positions import Positions
from latolato.experiment.tracking.route import Route, velocities
from latolato.experiment.tracking.sample import Sample
from latolato.experiment.tracking.teach import SMALLEST_DISC
from latolato.experiment.video import Frame, Video

# Places set by hand in a frame that was read [pixels], by ball from 0 on.
Corrections = Callable[[int], Mapping[int, np.ndarray]]
# Shares of what a ball's pixels typically explain, to be measured, and to be measured as whole; and
# the share of them that may look more like the wall: a long smear is nearly transparent.
_MEASURED, _WHOLE, _WALL = 0.4, 0.82, 0.5
# The same for a dot, a ball whose pattern turns through the light, or one that no one template
# describes because it looks otherwise from frame to frame: less than this share looks like it.
_WHOLE_TURNING, _DESCRIBED = 0.55, 0.85
# A ball that lies this many times farther off the curve through its neighbours than usual, away
# from contacts, and of which less than this share is seen, is drawn aside by what hides it.
_SURPRISING, _UNTOUCHED, _CALM = 6.0, 0.96, 0.15
# Time between measured samples that is bridged [s], and how uncertain accelerations are then, as a
# share of the typical one.
_PATIENCE, _UNSURE_FORCE = 0.3, 0.3
# Share of the steps from frame to frame below which those of a ball typically are: a swing's 95th
# percentile is its fastest step, and a few leaps there and back are no measure of it.
_FAST = 0.95
# A step this many times longer than others is a leap, also through a gap of so many frames.
_LEAP, _LONG_GAP = 1.5, 6
# Change of speed within a gap, over that by the typical force, from which something struck a ball.
_TURNED = 2.5
# Error of a smear that is worth a second look [pixels], and how many later frames tell that.
_SMEAR, _AHEAD = 0.5, 2
# By how much the exposure may be longer than was learned, and contacts how much before the middle
# of an exposure count as its own: shares of the interval.
_UNSURE_EXPOSURE, _BEFORE = 0.04, 0.25
# How far a ball may have moved since the picture that a frame repeats: pixels, radii.
_STALE, _STALE_SHARE = 0.5, 0.05
# Error of a centre that residuals do not show [pixels].
_FLOOR = 0.03
# How far from the circle, and from where it roughly is, a centre may lie, in radii; from the circle
# also as a share of the arm, for the pivot may be a little beside the place pointed at; and from
# where it is also as a share of its smear, of which the ends are faint.
OFF_CIRCLE, _OFF_ROUTE, OFF_SHARE, _OFF_SMEAR = 0.4, 1.0, 0.02, 0.25
# By how much two balls may seem to overlap, as a share of the angle at which they touch. In 60
# synthetic clips they did by 0.02 at most, and by 0.06 and more where one was taken for the other.
_OVERLAP = 0.08


def refine(
    video: Video,
    sample: Sample,
    scene: ImageModel,
    route: Route,
    progress: Callable[[float], None] | None = None,
    corrections: Corrections | None = None,
) -> Positions:
    """Positions of pivot and balls in every frame.

    Parameters
    ----------
    video, sample, scene : Video, Sample, ImageModel
        The clip, its first reading and what was learned of it.
    route : Route
        Where the balls roughly are.
    progress : callable, optional
        Called with the fraction done.
    corrections : callable, optional
        Returns the places of balls that are set by hand in a frame, which was read already.

    Notes
    -----
    A frame is fitted again if its neighbours, once they are fitted, say that its smear is another
    one. So each frame is decoded once, and few are in memory.
    """
    refiner = _Refiner(scene, sample, route, corrections or (lambda _: {}))
    count, repeats = len(sample.times), sample.repeats
    for frame in video.frames():
        n = frame.number
        if n >= count:  # the file has grown since
            break
        refiner.measure(frame._replace(time=float(sample.times[n])), bool(repeats[n]))
        if progress and n % 16 == 0:
            progress(n / count)
    refiner.finish()
    return refiner.judged(repeats, sample.is_converted)


@dataclass
class _Shot:
    """A frame that was fitted, and may be again."""

    frame: Frame
    pivot: np.ndarray
    guesses: np.ndarray
    velocities: np.ndarray


class _Refiner:
    """What is measured, frame by frame."""

    def __init__(
        self, scene: ImageModel, sample: Sample, route: Route, corrections: Corrections
    ) -> None:
        count, balls = len(sample.times), scene.balls
        self.scene, self.interval, self.corrections = scene, sample.interval, corrections
        self.route = route
        self.velocities, self.bends = np.nan_to_num(route.velocities[0]), route.velocities[1]
        self.angles = route.angles(scene.pivot.place(np.zeros(2))) + scene.lean
        self.out = Positions.unknown(sample.times, balls, scene.look.radius)
        self.out.body = scene.look.body
        self.explained, self.hidden = np.zeros((count, balls)), np.ones((count, balls))
        self.guesses = np.full((count, balls), np.nan)
        self.is_fixed = np.zeros((count, balls), bool)
        self.pivots = PivotFollower(scene.pivot, self.interval)
        self.gap = 2.0 * math.asin(min(scene.look.radius / scene.arm, 1.0)) if balls == 2 else 0.0
        self.waiting: list[_Shot] = []

    def measure(self, frame: Frame, is_stale: bool) -> None:
        """Fit a frame's pivot and balls, and the frame before again if its smear changed."""
        n = frame.number
        pivot = self.out.pivots[n] = self.pivots.place_in(frame, is_stale)
        fixed = self.corrections(n)
        guesses = self.guesses[n] = self._expected(n, pivot, fixed)
        shot = _Shot(frame, pivot, guesses.copy(), self.velocities[n].copy())
        self._fit(shot, self.bends[n], tolerant=1)
        self._retry(shot)
        for b, place in fixed.items():
            self._fix(n, b, pivot, place)
        self.waiting.append(shot)
        if len(self.waiting) > _AHEAD:
            self._again(self.waiting.pop(0))

    def finish(self) -> None:
        """Fit the last frames again if their smears changed."""
        for shot in self.waiting:
            self._again(shot)

    def _expected(self, n: int, pivot: np.ndarray, fixed: Mapping[int, np.ndarray]) -> np.ndarray:
        """Return the angles about the pivot at which balls should be, NaN where that is unknown."""
        raw = np.arctan2(*(self.route.places[n] - pivot).T) + self.scene.lean
        angles = raw + math.tau * np.rint((self.angles[n] - raw) / math.tau)
        for b, place in fixed.items():
            base = angles[b] if math.isfinite(angles[b]) else 0.0
            angles[b] = base + math.remainder(math.atan2(*(place - pivot)) - base, math.tau)
        if len(angles) == 2 and np.isfinite(angles).all():
            middle, apart = 0.5 * (angles[0] + angles[1]), angles[0] - angles[1]
            apart = math.tau * math.floor(apart / math.tau) + min(
                max(apart % math.tau, self.gap), math.tau - self.gap
            )
            angles[:] = middle + 0.5 * apart, middle - 0.5 * apart
        return np.asarray(angles)

    def _fit(self, shot: _Shot, bends: np.ndarray, tolerant: int) -> None:
        """Fit the balls of a frame from where they are expected; keep what was measured."""
        scene, n, pivot = self.scene, shot.frame.number, shot.pivot
        known = np.flatnonzero(np.isfinite(shot.guesses)).tolist()
        if not known:
            return
        exposure = scene.look.exposure * self.interval
        centres = arc(pivot, shot.guesses, scene.reach(shot.guesses))
        paths = {b: self._path(centres[b], shot.velocities[b], bends[b], exposure) for b in known}
        groups = [[b] for b in known]
        if len(known) == 2:
            apart = np.min(np.hypot(*(paths[0][:, None] - paths[1][None]).T))
            if apart < 3.3 * scene.look.radius:
                groups = [[0, 1]]
        for group in groups:
            fit = fit_balls(
                scene.look, shot.frame[2:], {b: paths[b] for b in group}, pivot, tolerant=tolerant
            )
            for k, b in enumerate(group):
                # The exposure's path moves as a whole; the state is that of its middle.
                centre = centres[b] + fit.shift[k]
                own = fit.covariance[2 * k : 2 * k + 2, 2 * k : 2 * k + 2]
                self._keep(n, b, pivot, centre, own, shot.guesses[b])
                self.explained[n, b], self.hidden[n, b] = fit.explained[k], fit.hidden[k]

    def _keep(
        self,
        n: int,
        ball: int,
        pivot: np.ndarray,
        centre: np.ndarray,
        covariance: np.ndarray,
        guess: float,
    ) -> None:
        """Keep a measured centre with its errors along and across the circle."""
        out, away = self.out, centre - pivot
        angle, distance = math.atan2(*away), float(np.hypot(*away))
        outwards = away / distance
        across = np.array([outwards[1], -outwards[0]])
        out.centres[n, ball] = centre
        out.angles[n, ball] = guess + math.remainder(angle - guess, math.tau)
        reach = float(self.scene.reach(np.array(guess)))
        out.sigmas[n, ball] = math.sqrt(across @ covariance @ across + _FLOOR**2) / reach
        out.spreads[n, ball] = math.sqrt(outwards @ covariance @ outwards + _FLOOR**2)

    def _fix(self, n: int, ball: int, pivot: np.ndarray, place: np.ndarray) -> None:
        """Keep a place that is set by hand."""
        self._keep(n, ball, pivot, place, CLICK_SIGMA**2 * np.eye(2), self.guesses[n, ball])
        self.explained[n, ball], self.hidden[n, ball] = self.scene.explained, 0.0
        self.is_fixed[n, ball] = True

    def _retry(self, shot: _Shot) -> None:
        """Look for balls that are not where they should be where their last angles lead."""
        n, out = shot.frame.number, self.out
        bad = ~self._is_good(slice(n, n + 1))[0]
        if n < 3 or not bad.any():
            return
        before = np.where(self._is_good(slice(n - 3, n)), out.angles[n - 3 : n], np.nan)
        led = 3.0 * before[2] - 3.0 * before[1] + before[0]
        again = bad & np.isfinite(led)
        if not again.any():
            return
        former = [values[n].copy() for values in self._values]
        guesses = self.guesses[n].copy()
        self.guesses[n] = np.where(again, led, guesses)
        places = [out.centres[n - 2, b] for b in range(len(led))]
        passed = float(out.times[n - 1] - out.times[n - 2])
        speeds = (out.centres[n - 1] - np.array(places)) / passed
        other = _Shot(shot.frame, shot.pivot, self.guesses[n].copy(), shot.velocities.copy())
        other.velocities[again] = speeds[again]
        self._fit(other, np.zeros((len(led), 2)), tolerant=2)
        worse = ~self._is_good(slice(n, n + 1))[0]
        for values, one in zip(self._values, former, strict=True):
            values[n][worse] = one[worse]
        self.guesses[n] = np.where(worse, guesses, self.guesses[n])
        shot.guesses = self.guesses[n].copy()
        shot.velocities = np.where(worse[:, None], shot.velocities, other.velocities)

    @property
    def _values(self) -> tuple[np.ndarray, ...]:
        """What a fit of a frame gives."""
        out = self.out
        return out.centres, out.angles, out.sigmas, out.spreads, self.explained, self.hidden

    @staticmethod
    def _path(
        centre: np.ndarray, velocity: np.ndarray, bend: np.ndarray, exposure: float
    ) -> np.ndarray:
        """Return a ball's centres within the exposure, shape (sample, 2)."""
        count = samples_for(float(np.hypot(*velocity)) * exposure)
        late = exposure * ((np.arange(count) + 0.5) / count - 0.5)[:, None]
        return np.asarray(centre + late * velocity + 0.5 * late**2 * bend)

    def _again(self, shot: _Shot) -> None:
        """Fit a frame again if those around it say that its smear is another one."""
        if not self.scene.look.exposure > 0.0:
            return
        n = shot.frame.number
        near = slice(max(n - _AHEAD, 0), n + _AHEAD + 1)
        centres = np.where(self._is_good(near)[..., None], self.out.centres[near], np.nan)
        speed, bend = velocities(self.out.times[near], centres, self.scene.look.radius)
        speed, bend = speed[n - near.start], bend[n - near.start]
        is_known = np.isfinite(centres[n - near.start, :, 0]) & np.isfinite(speed).all(axis=-1)
        change = np.where(is_known, np.linalg.norm(speed - shot.velocities, axis=-1), 0.0)
        exposure = self.scene.look.exposure * self.interval
        if not (change * exposure > _SMEAR).any():
            return
        shot.velocities = np.where(is_known[:, None], speed, shot.velocities)
        shot.guesses = np.where(is_known, self.out.angles[n], shot.guesses)
        fixed = [(b, self.out.centres[n, b].copy()) for b in np.flatnonzero(self.is_fixed[n])]
        self._fit(shot, np.where(is_known[:, None], bend, 0.0), tolerant=0)
        for b, place in fixed:
            self._fix(n, int(b), shot.pivot, place)

    def _is_old(self, repeats: np.ndarray, good: np.ndarray) -> np.ndarray:
        """Return which balls have not moved since the last fresh picture as they should have.

        They should have if the motion before it, the next fresh picture and a curve through the
        fresh ones, in which they are `good`, all say so: a ball that is held until then has not
        moved by the first, one that is caught by the second, and one that turns by the last.
        """
        from scipy.interpolate import Akima1DInterpolator

        scene, angles, times = self.scene, self.out.angles, self.out.times
        frames, fresh = np.arange(len(repeats)), np.flatnonzero(~repeats)
        number = np.searchsorted(fresh, frames, side="right")
        before, earlier = (fresh[np.maximum(number - k, 0)] for k in (1, 2))
        after = fresh[np.minimum(number, len(fresh) - 1)]
        # How many frames' motion is to be expected, of the last one between fresh pictures.
        share = (frames - before) / np.maximum(before - earlier, 1)
        gone = [share[:, None] * np.abs(angles[before] - angles[earlier])]
        is_last = (after <= frames)[:, None]
        gone.append(np.where(is_last, gone[0], np.abs(angles[after] - angles[before])))
        curved = np.zeros_like(angles)
        for b in range(scene.balls):
            known = ~repeats & good[:, b]
            if known.sum() > 2:
                path = Akima1DInterpolator(times[known], angles[known, b])
                curved[:, b] = np.abs(path(times, extrapolate=True) - angles[before, b])
        led = np.fmin.reduce([*gone, curved]) * scene.arm
        moved = np.abs(angles - angles[before]) * scene.arm
        with np.errstate(invalid="ignore"):
            is_old = (moved < 0.5 * led) | (self.explained < _WHOLE * scene.explained)
            return np.asarray(is_old & (led > max(_STALE, _STALE_SHARE * scene.look.radius)))

    def _is_good(self, frames: slice) -> np.ndarray:
        """Return which balls were measured: not hidden, on the circle, where they may be."""
        scene, out = self.scene, self.out
        away = out.centres[frames] - out.pivots[frames][:, None]
        smear = np.linalg.norm(self.velocities[frames], axis=-1) * scene.look.exposure
        size = max(scene.look.radius, self.route.radius) + _OFF_SMEAR * smear * self.interval
        jump = np.abs(out.angles[frames] - self.guesses[frames]) * scene.arm / size
        seen = self.route.is_seen[frames]
        with np.errstate(invalid="ignore"):
            good = (
                (self.explained[frames] >= _MEASURED * scene.explained)
                & (self.hidden[frames] <= _WALL)
                & (scene.off(away) <= max(OFF_CIRCLE * scene.look.radius, OFF_SHARE * scene.arm))
                & (jump <= np.where(seen, 1.0, 2.0) * _OFF_ROUTE)
            )
        if scene.balls == 2:
            between = np.remainder(out.angles[frames, 0] - out.angles[frames, 1], math.tau)
            slack = _OVERLAP * self.gap
            with np.errstate(invalid="ignore"):
                apart = (between > self.gap - slack) & (between < math.tau - self.gap + slack)
            good &= (apart | ~np.isfinite(between))[:, None]
        return np.asarray(good | self.is_fixed[frames])

    def judged(self, repeats: np.ndarray, is_converted: bool) -> Positions:
        """Return the positions with their flags.

        A picture that seems to repeat the one before is out of date if pictures are repeated
        regularly, or if a ball has not moved as those around say.
        """
        scene, out = self.scene, self.out
        good = self._is_good(slice(None))
        good &= self.is_fixed | ~(repeats[:, None] & (is_converted | self._is_old(repeats, good)))
        if scene.balls == 2:
            good &= ~may_be_other(out.angles, good, gap=self.gap) | self.is_fixed
        out.give_up(~good)
        out.flags[good] = "ok"
        for b in range(scene.balls):
            take_off_turns(out.angles[:, b])
        contacts = contact_times(out.times, out.angles, self.gap) if scene.balls == 2 else []
        near = (0.5 * scene.look.exposure + _UNSURE_EXPOSURE) * self.interval
        early = max(near, _BEFORE * self.interval)
        late = np.array(contacts)[None] - out.times[:, None]
        is_contact = ((late >= -early) & (late <= near)).any(axis=1)
        is_calm = ~((late < 0.0) & (late > -_CALM)).any(axis=1)
        is_dot = scene.look.radius < SMALLEST_DISC
        is_varied = scene.look.is_spinning or scene.explained < _DESCRIBED or is_dot
        for b in range(scene.balls):
            off = off_curve(out.times, out.angles[:, b])
            usual = np.nanmedian(np.abs(off)) if np.isfinite(off).any() else 0.0
            spread = np.hypot(1.4826 * usual, out.sigmas[:, b])
            with np.errstate(invalid="ignore"):
                is_drawn = (
                    (np.abs(off) > _SURPRISING * spread)
                    & (self.explained[:, b] < _UNTOUCHED * scene.explained)
                    & is_calm
                    & (not is_varied)
                )
            out.sigmas[is_drawn, b] = np.fmax(out.sigmas[is_drawn, b], np.abs(off[is_drawn]))
            whole = _WHOLE_TURNING if is_varied else _WHOLE
            partly = good[:, b] & ((self.explained[:, b] < whole * scene.explained) | is_drawn)
            out.flags[good[:, b] & is_contact, b] = "collision"
            out.flags[partly, b] = "occluded"
            out.flags[self.is_fixed[:, b], b] = "manual"
            self._bridge(b)
        return out

    def _bridge(self, ball: int) -> None:
        """Fill short gaps between measured angles of a ball by a smooth curve."""
        from scipy.interpolate import CubicHermiteSpline

        out, scene = self.out, self.scene
        known = np.flatnonzero(np.isfinite(out.angles[:, ball]))
        if len(known) < 4:
            return
        times, angles = out.times[known], out.angles[known, ball]
        rates = np.gradient(angles, times)
        forces = np.abs(np.gradient(rates, times))
        unsure = _UNSURE_FORCE * float(np.quantile(forces, 0.9))
        for k in np.flatnonzero(np.diff(known) > 1).tolist():
            span = times[k + 1] - times[k]
            if span > _PATIENCE:
                continue
            inside = np.arange(known[k] + 1, known[k + 1])
            # Slopes at the ends from the sides that are measured.
            slopes = [
                (angles[k] - angles[k - 1]) / (times[k] - times[k - 1]) if k else rates[k],
                (angles[k + 2] - angles[k + 1]) / (times[k + 2] - times[k + 1])
                if k + 2 < len(known)
                else rates[k + 1],
            ]
            # A contact amid the gap: what lies between is not smooth.
            if abs(slopes[1] - slopes[0]) > _TURNED * unsure / _UNSURE_FORCE * span:
                continue
            curve = CubicHermiteSpline(times[k : k + 2], angles[k : k + 2], slopes)
            out.angles[inside, ball] = curve(out.times[inside])
            out.sigmas[inside, ball] = unsure * span**2 / 8.0 + scene.look.radius / scene.arm / 8.0
            out.flags[inside, ball] = "predicted"
            at = out.angles[inside, ball]
            out.centres[inside, ball] = arc(out.pivots[inside], at, scene.reach(at))


def contact_times(times: np.ndarray, angles: np.ndarray, gap: float) -> list[float]:
    """Return when two balls met [s], at the bottom or at the top.

    From either side the distance between them is followed to where they touch; both sides agree
    between the same two frames.

    Parameters
    ----------
    times : numpy.ndarray, shape (frame,)
        Time stamps [s].
    angles : numpy.ndarray, shape (frame, 2)
        Measured angles [rad]; NaN where unknown.
    gap : float
        Angle between balls that touch [rad].
    """
    known = np.flatnonzero(np.isfinite(angles).all(axis=1))
    times, between = times[known], angles[known, 0] - angles[known, 1]
    contacts: list[float] = []
    if len(known) < 3:
        return contacts
    rates = np.diff(between) / np.diff(times)
    for wall, sign in ((gap, 1.0), (math.tau - gap, -1.0)):
        left = sign * (between - wall)
        for k in range(1, len(times) - 1):
            # Closing before frame k, opening after it or after the next one.
            before, after = sign * rates[k - 1], sign * rates[k]
            if not before < 0.0:
                continue
            until = times[k] + left[k] / -before
            if until <= times[k + 1] and after > before * 0.5:
                contacts.append(float(np.clip(until, times[k - 1], times[k + 1])))
    return contacts


def may_be_other(angles: np.ndarray, good: np.ndarray, *, gap: float) -> np.ndarray:
    """Return where one of two balls that is seen alone after a leap or a gap may be the other one.

    Parameters
    ----------
    angles : numpy.ndarray, shape (frame, 2)
        Angles [rad].
    good : numpy.ndarray of bool, shape (frame, 2)
        Which of them were measured.
    gap : float
        Angle between balls that touch [rad].

    Returns
    -------
    numpy.ndarray of bool, shape (frame, 2)
    """
    doubtful = np.zeros(good.shape, bool)
    angles = np.where(good, angles, np.nan)
    steps = np.abs(np.diff(angles, axis=0))
    if not np.isfinite(steps).any():
        return doubtful
    most = _LEAP * float(np.nanquantile(steps, _FAST)) + 0.5 * gap
    for b in range(2):
        known = np.flatnonzero(good[:, b])
        apart = np.diff(known)
        far = np.abs(np.diff(angles[known, b])) > most * np.minimum(apart, _LONG_GAP)
        # Where neither is seen they may meet.
        is_alone = ~good[known[1:], 1 - b] & ~good[known[1:] - 1, 1 - b]
        for k in np.flatnonzero(far | ((apart > 1) & is_alone)).tolist():
            after = np.arange(known[k + 1], len(good))
            both = np.flatnonzero(good[after].all(axis=1))
            doubtful[after[: both[0]] if len(both) else after, b] = True
    return doubtful


def take_off_turns(angles: np.ndarray) -> None:
    """Take whole turns off angles (frame,) after which a ball cannot have made them.

    A rough path may run past the pivot where nothing like the ball was seen. Angles that are
    unknown are NaN.
    """
    known = np.flatnonzero(np.isfinite(angles))
    apart, steps = np.diff(known), np.diff(angles[known])
    turns = np.rint(steps / math.tau)
    in_frames = np.abs(steps - math.tau * turns)[apart == 1]
    if not (turns.any() and len(in_frames)):
        return
    turns[apart * float(np.quantile(in_frames, _FAST)) >= math.pi] = 0.0
    angles[known[1:]] -= math.tau * np.cumsum(turns)


def off_curve(times: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return how far angles (frame,) lie off the cubic through two neighbours on each side."""
    out = np.full(len(angles), np.nan)
    if len(angles) < 5:
        return out
    inner = angles[2:-2]
    out[2:-2] = inner - (4.0 * (angles[1:-3] + angles[3:-1]) - angles[:-4] - angles[4:]) / 6.0
    return out
