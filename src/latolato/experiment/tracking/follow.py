"""Follows pivot and balls through all frames of a clip."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from latolato.experiment.calibration.hinge import CLICK
from latolato.experiment.tracking.appearance import (
    arc,
    best_angles,
    samples_for,
)
from latolato.experiment.tracking.learn import ImageModel
from latolato.experiment.tracking.positions import Positions
from latolato.experiment.tracking.predict import Prediction, Predictor
from latolato.experiment.tracking.sample import Sample
from latolato.experiment.video import Frame, Video
from latolato.physics.pendulum import restoring_sine

# Places set by hand in a frame that was read [pixels], by ball from 0 on.
Corrections = Callable[[int], Mapping[int, np.ndarray]]
# Shares of what a ball's pixels typically explain, to be measured, and to be measured as whole; and
# the share of them that may look more like the wall: a long smear is nearly transparent.
_MEASURED, _WHOLE, _WALL = 0.4, 0.82, 0.5
# The same for a ball whose pattern turns through the light, or that no one template describes
# because it looks otherwise from frame to frame: less than this share typically looks like it.
_WHOLE_TURNING, _DESCRIBED = 0.55, 0.85
# A ball that moved by this many standard deviations more than was expected, long after a contact
# [s], and of which less than this share is seen, is drawn aside by what hides it.
_SURPRISING, _UNTOUCHED, _CALM = 6.0, 0.96, 0.15
# Time after which a ball that was not seen is lost [s]; errors of what is expected from which it is
# lost at once, and from which whole turns are not told [rad].
_PATIENCE, _VAGUE, _TURNS = 0.3, 0.5, 1.0
# Least gain at which a ball that was lost is believed to be found.
_BELIEVED = 0.3
# Error of a smear that is worth a second look [pixels].
_SMEAR = 1.0
# By how much the exposure may be longer than was learned, as a share of the interval.
_UNSURE_EXPOSURE = 0.04
# Contacts this much before the middle of an exposure count as its own: a share of the interval.
_BEFORE = 0.25
# How far a ball may have moved since the picture that a frame repeats [pixels], and how many of
# the prediction's standard deviations from where it is expected show that it has.
_STALE, _SURE = 0.5, 4.0
# Error of a centre that residuals do not show [pixels].
_FLOOR = 0.03
# Error of a place within a smear, as a share of the error of the smear's length.
_IN_SMEAR = 0.3
# How far from the circle a centre may lie, as a share of the ball's radius.
_OFF_CIRCLE = 0.4


def follow(
    video: Video,
    sample: Sample,
    scene: ImageModel,
    stiffness: float,
    progress: Callable[[float], None] | None = None,
    corrections: Corrections | None = None,
) -> Positions:
    """Positions of pivot and balls in every frame.

    Parameters
    ----------
    video, sample, scene : Video, Sample, ImageModel
        The clip, its first reading and what was learned of it.
    stiffness : float
        Gravity over length [1/s^2], 0 if unknown: it is then taken from the sample.
    progress : callable, optional
        Called with the fraction done.
    corrections : callable, optional
        Returns the places of balls that are set by hand in a frame, which was read already.
    """
    count = len(sample.times)
    out = Positions.unknown(sample.times, scene.balls, scene.look.radius)
    out.body = scene.look.body
    follower = _Follower(scene, sample.interval, stiffness, sample.click)
    follower.corrections = corrections or follower.corrections
    repeats = sample.repeats
    for frame in video.frames():
        n = frame.number
        if n >= count:  # the file has grown since
            break
        frame = frame._replace(time=float(sample.times[n]))
        out.pivots[n] = follower.pivot_in(frame, repeats[n])
        centres, angles, sigmas, flags = follower.balls_in(frame, repeats[n])
        out.centres[n], out.angles[n], out.sigmas[n], out.flags[n] = centres, angles, sigmas, flags
        out.spreads[n] = follower.spreads
        if progress and n % 16 == 0:
            progress(n / count)
    return out


@dataclass
class _Measured:
    """What fits to a frame give of each ball.

    Angle and deviation [rad], centre, and the parts that look like a ball and more like the wall.
    """

    angles: np.ndarray
    sigmas: np.ndarray
    centres: np.ndarray
    explained: np.ndarray
    hidden: np.ndarray


class _Follower:
    """State carried from frame to frame."""

    def __init__(self, scene: ImageModel, interval: float, stiffness: float, click: int) -> None:
        self.scene, self.interval, self.click = scene, interval, click
        gap = 2.0 * math.asin(min(scene.look.radius / scene.arm, 1.0)) if scene.balls == 2 else 0.0
        self.predictor = Predictor(stiffness or scene.stiffness, gap, is_known=stiffness > 0.0)
        self.pivots: list[tuple[float, np.ndarray]] = []
        self.unseen = np.zeros(scene.balls)
        # When and at which angles balls were measured last, without a frame between.
        self.last = [[(-math.inf, float(angle))] for angle in scene.starts]
        # The pivot's acceleration over the arm [1/s^2].
        self.lift = 0.0
        self.is_begun = False
        # Places set by hand, and those of the frame at work.
        self.corrections: Corrections = lambda _: {}
        self.fixed: Mapping[int, np.ndarray] = {}
        # Balls that were found in the last frame, with a velocity that is not known.
        self.is_found = np.zeros(scene.balls, bool)
        self.pivot_cost = 0.0
        self.last_contact = -math.inf
        # Standard deviations of the last distances from the pivot [pixels].
        self.spreads = np.full(scene.balls, np.nan)
        # Contacts this close to the middle of an exposure [s] belong to it.
        self.near = (0.5 * scene.look.exposure + _UNSURE_EXPOSURE) * interval

    def pivot_in(self, frame: Frame, is_stale: bool) -> np.ndarray:
        """Return the pivot's place in a frame, or where it should be if that shows an older one."""
        tracker = self.scene.pivot
        guess, velocity, room = None, np.zeros(2), 0.0
        if len(self.pivots) >= 3:
            # A drive of w turns w dt of its phase in a frame: that share of its bend is unknown.
            guess, velocity, room = self._extrapolated(frame.time)
            guess = np.clip(guess, *tracker.reach)
        shift, cost = tracker.locate(frame.luma, guess, velocity, room)
        if guess is not None and cost > 1.4 * self.pivot_cost + 0.1:
            wide, wide_cost = tracker.locate(frame.luma, None, velocity)
            if wide_cost < 0.7 * cost:
                shift, cost = wide, wide_cost
        if guess is not None:
            exact = self._arrived(frame.time, shift)
            if np.max(np.abs(exact - velocity)) * tracker.exposure > _SMEAR:
                shift, cost = tracker.locate(frame.luma, shift, exact)
        if guess is not None and is_stale and not tracker.is_still:
            shift, cost = guess, self.pivot_cost
        self.pivot_cost = 0.9 * self.pivot_cost + 0.1 * cost if guess is not None else cost
        self.pivots = [*self.pivots[-3:], (frame.time, shift)]
        place: np.ndarray = tracker.place(shift)
        return place

    def _extrapolated(self, time: float) -> tuple[np.ndarray, np.ndarray, float]:
        """Return the shift and velocity per interval to be expected, and half the last bend."""
        (t0, p0), (t1, p1), (t2, p2) = self.pivots[-3:]
        early, late = (p1 - p0) / (t1 - t0), (p2 - p1) / (t2 - t1)
        bend = 2.0 * (late - early) / (t2 - t0)
        passed = time - t2
        guess = p2 + (late + 0.5 * bend * (t2 - t1 + passed)) * passed
        velocity = (late + bend * (0.5 * (t2 - t1) + passed)) * self.interval
        return guess, velocity, 0.5 * float(np.max(np.abs(bend))) * self.interval**2

    def _arrived(self, time: float, shift: np.ndarray) -> np.ndarray:
        """Return the velocity per interval at a frame whose shift is known."""
        (t0, p0), (t1, p1) = self.pivots[-2:]
        early, late = (p1 - p0) / (t1 - t0), (shift - p1) / (time - t1)
        bend = 2.0 * (late - early) / (time - t0)
        return np.asarray((late + 0.5 * bend * (time - t1)) * self.interval)

    def _pivot_motion(self, instants: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the pivot's places at instants near the last frame, and its upward acceleration.

        The acceleration is in pixels per second squared.
        """
        origin = self.scene.pivot.place(np.zeros(2))
        time, place = self.pivots[-1]
        if len(self.pivots) < 3:
            return np.broadcast_to(origin + place, (len(instants), 2)), 0.0
        (t0, p0), (t1, p1), (t2, p2) = self.pivots[-3:]
        early, late = (p1 - p0) / (t1 - t0), (p2 - p1) / (t2 - t1)
        acceleration = 2.0 * (late - early) / (t2 - t0)
        velocity = late + 0.5 * acceleration * (t2 - t1)
        passed = (instants - time)[:, None]
        places = origin + place + velocity * passed + 0.5 * acceleration * passed**2
        return places, float(-acceleration[1])

    def balls_in(
        self, frame: Frame, is_stale: bool
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return centres, angles, sigmas and flags of the balls in a frame.

        One that shows an older picture tells nothing of balls that should have moved since.
        """
        scene, predictor = self.scene, self.predictor
        pivot = scene.pivot.place(self.pivots[-1][1])
        if not self.is_begun:
            self._begin(frame)
        exposure = scene.look.exposure * self.interval
        speed = float(np.max(np.abs(predictor.velocities), initial=0.0))
        count = samples_for(speed * exposure * scene.arm)
        instants = frame.time + exposure * ((np.arange(count) + 0.5) / count - 0.5)
        places, lift = self._pivot_motion(instants)
        self.lift = lift / scene.arm
        until = frame.time + self.near
        expected = predictor.predict(frame.time, instants, self.lift, until)
        if self.is_found.any():
            self._retry(frame, pivot, expected, self.is_found)
            self.is_found[:] = False
        if frame.number == self.click:
            self._return_to(dict(enumerate(scene.starts)), expected)
        self.fixed = self.corrections(frame.number)
        self._return_to({b: math.atan2(*(at - pivot)) for b, at in self.fixed.items()}, expected)
        if np.any(self.unseen > _PATIENCE):
            search = self._search if scene.balls == 1 else self._search_both
            search(frame, pivot, expected)
        seen = self._measure(frame, pivot, places, expected, tolerant=0)
        bad = self._is_bad(pivot, seen, expected)
        if is_stale:
            turned = np.abs(expected.angles - predictor.angles)
            # Where it turns round it may seem to rest, unless the prediction knows better.
            known = _SURE * np.sqrt(expected.covariance[:, 0, 0])
            is_old = np.abs(seen.angles - expected.angles) > np.maximum(0.5 * turned, known)
            is_old |= seen.explained < _WHOLE * scene.explained
            bad |= is_old & (turned * scene.arm > _STALE)
            predictor.accept(frame.time, expected)
            return self._verdict(frame, pivot, seen, bad, expected)
        if bad.any() and self._retry(frame, pivot, expected, bad):
            seen = self._measure(frame, pivot, places, expected, tolerant=2)
            bad = self._is_bad(pivot, seen, expected)
        if scene.balls == 1 and bad[0] and self._search(frame, pivot, expected):
            seen = self._measure(frame, pivot, places, expected, tolerant=2)
            bad = self._is_bad(pivot, seen, expected)
        if self._bent(seen, expected, instants - frame.time, exposure) and not bad.any():
            seen = self._measure(frame, pivot, places, expected, tolerant=0)
            bad = self._is_bad(pivot, seen, expected)
        predictor.accept(frame.time, expected)
        return self._verdict(frame, pivot, seen, bad, expected)

    def _begin(self, frame: Frame) -> None:
        """Expect balls where they were clicked, or look for them if that was in another frame."""
        scene = self.scene
        sigma = 0.5 * scene.look.radius / scene.arm
        self.predictor.start(frame.time, scene.starts, scene.speeds / self.interval, sigma)
        self.unseen[:] = 0.0 if frame.number == self.click else math.inf
        self.is_begun = True

    def _return_to(self, angles: Mapping[int, float], expected: Prediction) -> None:
        """Expect balls at known angles, with unknown velocity if they were not expected there."""
        for b, angle in angles.items():
            away = math.remainder(angle - expected.angles[b], 2.0 * math.pi)
            spread = 3.0 * math.sqrt(expected.covariance[b, 0, 0])
            if abs(away) > max(spread, self.scene.look.radius / self.scene.arm):
                self._restart(expected, b, float(expected.angles[b] + away))
                self.unseen[b] = 0.0

    def _measure(
        self,
        frame: Frame,
        pivot: np.ndarray,
        places: np.ndarray,
        expected: Prediction,
        tolerant: int,
    ) -> _Measured:
        """Fit the balls from where they are expected."""
        scene, balls = self.scene, self.scene.balls
        turns = expected.path.T
        paths = [arc(places, turns[b], scene.reach(turns[b])) for b in range(balls)]
        arms = scene.reach(expected.guess)
        groups = [[b] for b in range(balls)]
        if balls == 2:
            apart = np.min(np.hypot(*(paths[0][:, None] - paths[1][None]).T))
            if apart < 3.3 * scene.look.radius:
                groups = [[0, 1]]
        angles, sigmas, explained, hidden = np.empty((4, balls))
        out = _Measured(angles, sigmas, np.empty((balls, 2)), explained, hidden)
        for group in groups:
            fit = scene.look.fit(frame[2:], [paths[b] for b in group], pivot, tolerant=tolerant)
            for k, b in enumerate(group):
                # The exposure's path moves as a whole; the state is that of its middle.
                centre = arc(pivot, expected.guess[b], arms[b]) + fit.shift[k]
                away = centre - pivot
                angle = math.atan2(away[0], away[1])
                turn = math.remainder(angle - expected.guess[b], 2.0 * math.pi)
                out.angles[b] = expected.guess[b] + turn
                outwards = away / np.hypot(*away)
                across = np.array([outwards[1], -outwards[0]])
                own = fit.covariance[2 * k : 2 * k + 2, 2 * k : 2 * k + 2]
                out.sigmas[b] = math.sqrt(across @ own @ across + _FLOOR**2) / arms[b]
                self.spreads[b] = math.sqrt(outwards @ own @ outwards + _FLOOR**2)
                out.centres[b] = centre
                out.explained[b], out.hidden[b] = fit.explained[k], fit.hidden[k]
        for b, place in self.fixed.items():
            angle = math.atan2(*(place - pivot))
            turn = math.remainder(angle - expected.guess[b], 2.0 * math.pi)
            out.angles[b], out.centres[b] = expected.guess[b] + turn, place
            out.sigmas[b], self.spreads[b] = CLICK / scene.arm, CLICK
            out.explained[b], out.hidden[b] = scene.explained, 0.0
        return out

    def _is_bad(self, pivot: np.ndarray, seen: _Measured, expected: Prediction) -> np.ndarray:
        """Return which balls were not measured: hidden, off the circle, or where none can be."""
        scene = self.scene
        off = scene.off(seen.centres - pivot)
        spread = np.sqrt(expected.covariance[:, 0, 0])
        jump = np.abs(seen.angles - expected.angles)
        bad: np.ndarray = (
            (seen.explained < _MEASURED * scene.explained)
            | (seen.hidden > _WALL)
            | (off > _OFF_CIRCLE * scene.look.radius)
            | (jump > 6.0 * spread + 0.5 * scene.look.radius / scene.arm)
        )
        if scene.balls == 2:
            between = seen.angles[0] - seen.angles[1]
            slack = 0.3 * self.predictor.gap
            if not self.predictor.gap - slack < between < 2 * math.pi - self.predictor.gap + slack:
                bad[:] = True
        bad[list(self.fixed)] = False
        return bad

    def _retry(
        self, frame: Frame, pivot: np.ndarray, expected: Prediction, bad: np.ndarray
    ) -> bool:
        """Move the expectation of badly fitted balls to the best place nearby."""
        scene = self.scene
        moved = False
        for b in np.flatnonzero(bad):
            spread = 4.0 * math.sqrt(expected.covariance[b, 0, 0])
            missed = 1.0 + self.unseen[b] / self.interval
            reach = min(max(spread, 2.0 * missed * scene.look.radius / scene.arm), math.pi)
            count = 2 * math.ceil(reach * scene.arm / scene.look.radius * 2.5) + 1
            trials = expected.angles[b] + np.linspace(-reach, reach, count)
            if scene.balls == 2:
                trials = trials[self._allowed(trials, int(b), expected)]
            if not len(trials):
                continue
            gain = scene.look.gains(frame[2:], pivot, scene.reach(trials), trials)
            best = int(np.argmax(gain))
            if gain[best] > _BELIEVED:
                expected.path[:, b] += trials[best] - expected.guess[b]
                expected.guess[b] = trials[best]
                moved = True
        return moved

    def _bent(
        self, seen: _Measured, expected: Prediction, instants: np.ndarray, exposure: float
    ) -> bool:
        """Expect the smears that what was measured says; return whether they are far different."""
        moved = False
        for b, covariance in enumerate(expected.covariance):
            gain = covariance[1, 0] / (covariance[0, 0] + seen.sigmas[b] ** 2)
            faster = gain * (seen.angles[b] - expected.angles[b])
            if abs(faster) * exposure * self.scene.arm > _SMEAR:
                expected.path[:, b] += seen.angles[b] - expected.guess[b] + faster * instants
                expected.guess[b] = seen.angles[b]
                moved = True
        return moved

    def _allowed(self, trials: np.ndarray, ball: int, expected: Prediction) -> np.ndarray:
        """Return which angles do not put a ball into or beyond the other one."""
        between = (trials - expected.guess[1 - ball]) * (1.0 if ball == 0 else -1.0)
        gap = 0.9 * self.predictor.gap
        allowed: np.ndarray = (between > gap) & (between < 2.0 * math.pi - gap)
        return allowed

    def _search(self, frame: Frame, pivot: np.ndarray, expected: Prediction) -> bool:
        """Expect the only ball where it is likeliest on the whole circle, if it is there."""
        scene = self.scene
        angles, gain = best_angles(scene.look, frame[2:], pivot, scene.arm, 1, scene.tilt)
        if gain[0] <= _BELIEVED:
            return False
        time, last = self.last[0][-1]
        passed, size = frame.time - time, scene.look.radius / scene.arm
        angle = expected.angles[0] + math.remainder(angles[0] - expected.angles[0], 2.0 * math.pi)
        self._restart(expected, 0, angle)
        if passed <= _PATIENCE:
            force = max(self.predictor.stiffness, self.predictor.noise)
            expected.velocities[0] = (angle - last) / passed
            expected.covariance[0] = size**2 * np.outer([1.0, 1.0 / passed], [1.0, 1.0 / passed])
            expected.covariance[0, 1, 1] += (0.5 * force * passed) ** 2
        return True

    def _search_both(self, frame: Frame, pivot: np.ndarray, expected: Prediction) -> None:
        """Look for balls that were lost on the whole circle."""
        scene = self.scene
        angles, gain = best_angles(scene.look, frame[2:], pivot, scene.arm, scene.balls, scene.tilt)
        if gain.min() < _BELIEVED:
            return
        lost = self.unseen > _PATIENCE
        if lost.all():
            # Nothing tells who is who but their order from right to left.
            order = np.argsort(angles)[::-1]
            for b in range(2):
                self._restart(expected, b, angles[order[b]])
            return
        kept = int(np.flatnonzero(~lost)[0])
        apart = [abs(math.remainder(a - expected.angles[kept], 2.0 * math.pi)) for a in angles]
        other = angles[int(np.argmax(apart))]
        base = expected.angles[kept]
        between = (other - base) % (2.0 * math.pi)
        self._restart(expected, 1 - kept, base + (between if kept == 1 else between - 2 * math.pi))

    def _restart(self, expected: Prediction, ball: int, angle: float) -> None:
        """Expect a ball somewhere else, with unknown velocity."""
        self.is_found[ball] = True
        expected.path[:, ball] += angle - expected.angles[ball]
        expected.angles[ball] = expected.guess[ball] = angle
        expected.velocities[ball] = 0.0
        speed = max(2.0 * math.sqrt(self.predictor.stiffness), 3.0)
        expected.covariance[ball] = np.diag(
            [(self.scene.look.radius / self.scene.arm) ** 2, speed**2]
        )

    def _learn_from(self, ball: int, time: float, angle: float) -> None:
        """Keep what was measured, and learn from three neighbouring angles without a contact."""
        is_next = self.unseen[ball] == 0.0 and time - self.last_contact > _CALM
        self.last[ball] = [*(self.last[ball][-2:] if is_next else []), (time, angle)]
        if len(self.last[ball]) == 3 and math.isfinite(self.last[ball][0][0]):
            (t0, a0), (t1, a1), (t2, a2) = self.last[ball]
            acceleration = 2.0 * ((a2 - a1) / (t2 - t1) - (a1 - a0) / (t1 - t0)) / (t2 - t0)
            # What the pivot's acceleration does is known.
            self.predictor.learn(a1, acceleration + self.lift * restoring_sine(a1))

    def _verdict(
        self,
        frame: Frame,
        pivot: np.ndarray,
        seen: _Measured,
        bad: np.ndarray,
        expected: Prediction,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Correct the state by what was measured; return the frame's row."""
        scene, predictor = self.scene, self.predictor
        balls, angles, sigmas = scene.balls, seen.angles, seen.sigmas
        centres, flags = np.full((balls, 2), np.nan), np.full(balls, "lost", "U9")
        early = max(self.near, _BEFORE * self.interval)
        self.last_contact = max([self.last_contact, *expected.contact_times])
        is_contact = any(-early <= t - frame.time <= self.near for t in expected.contact_times)
        for b, explained in enumerate(seen.explained):
            if not bad[b]:
                self._learn_from(b, frame.time, float(angles[b]))
                self.unseen[b] = 0.0
                centres[b] = seen.centres[b]
                off = abs(float(angles[b] - expected.angles[b]))
                spread = math.hypot(math.sqrt(expected.covariance[b, 0, 0]), float(sigmas[b]))
                is_varied = scene.look.is_spinning or scene.explained < _DESCRIBED
                is_drawn = (
                    not is_varied
                    and off > _SURPRISING * spread
                    and explained < _UNTOUCHED * scene.explained
                    and frame.time - self.last_contact > _CALM
                )
                if is_drawn:  # what hides a part of it has drawn it aside
                    sigmas[b] = max(float(sigmas[b]), off)
                predictor.correct(b, float(angles[b]), float(sigmas[b]))
                # Where in its smear a ball is depends on how long that is.
                unsure = math.sqrt(predictor.covariance[b, 1, 1]) * scene.look.exposure
                sigmas[b] = math.hypot(sigmas[b], _IN_SMEAR * unsure * self.interval)
                whole = _WHOLE_TURNING if is_varied else _WHOLE
                if b in self.fixed:
                    flags[b] = "manual"
                elif is_drawn or explained < whole * scene.explained:
                    flags[b] = "occluded"
                else:
                    flags[b] = "collision" if is_contact else "ok"
                continue
            self.unseen[b] += self.interval
            spread = math.sqrt(expected.covariance[b, 0, 0])
            if self.unseen[b] <= _PATIENCE and spread < _VAGUE:
                flags[b] = "predicted"
                angles[b], sigmas[b] = expected.angles[b], spread
                centres[b] = arc(pivot, angles[b], scene.reach(angles[b]))
            else:
                angles[b] = sigmas[b] = np.nan
            if spread > _TURNS and balls == 1:
                # How often it goes round nothing tells: it is believed not to.
                predictor.angles[b] = 2.0 * math.pi * round(self.last[b][-1][1] / (2.0 * math.pi))
                predictor.velocities[b] = 0.0
        return centres, angles, sigmas, flags
