"""Learns from balls found in a sample: colours, edge, noise, exposure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from latolato.experiment.calibration.parabola import parabola_top
from latolato.experiment.calibration.tilt import Tilt
from latolato.experiment.rules import broken
from latolato.experiment.tracking.appearance import Appearance, arc, fit_balls, samples_for
from latolato.experiment.tracking.body import learn_body
from latolato.experiment.tracking.edge import Shot, measured_edge
from latolato.experiment.tracking.kernels import layers as kernels
from latolato.experiment.tracking.paint import filled, quantile_of_seen, turned, unmixed_paint
from latolato.experiment.video import Frame

# Radius below which a ball has no edge to measure [pixels].
SMALLEST_DISC = 3.0
# Share of the contrast between ball and wall from which a residual is something else.
OUTLYING = 0.3
# Share of a ball's pixels that must look like one for a frame to teach.
_TEACHES = 0.8
# How many of the slowest balls of each look teach it.
_TEACHERS = 16
# How many of the fastest balls tell the exposure.
_FASTEST = 6
# While the exposure is unknown: most pixels per frame over the radius, and how many such balls are
# needed, for a ball to have an edge.
_HARDLY, _FEWEST_SHOTS = 0.4, 3
# How many of the slowest balls tell an edge otherwise, and shares by which the radius is varied.
_SLOWEST, _WIDTHS = 6, (0.08, 0.03)
# Frames whose ball moved less than this share of its radius in an interval teach its colours.
_SLOW = 0.4
# Balls around which noise is learned.
_RINGS = 16
# Share of what colours that stay leave unexplained below which a pattern turns: 0.28 to 0.75 of
# most balls with a stripe, 0.85 and more without. How often pattern and shading are divided.
_TURNS, _DIVIDED = 0.8, 4
# The share of frames that tells how much colours vary: a pattern that moves past shows a pixel two
# colours, the rarer one this rarely; and the mean square of three colours there, over its mean.
_RARER, _AT_RARER = 0.8, 1.547
# Share of the residual of something else by which colours must vary to count as a pattern.
_VARIED = 0.25


@dataclass
class Sighting:
    """A ball found in a frame of the sample."""

    frame: int
    centre: np.ndarray
    pivot: np.ndarray
    angle: float
    speed: float
    explained: float
    drift: np.ndarray
    ball: int = 0

    def path(self, arm: float, exposure: float) -> np.ndarray:
        """Return the ball's centres within the exposure, shape (sample, 2)."""
        smear = 0.0 if math.isnan(self.speed) else self.speed * exposure
        count = samples_for(abs(smear) * arm + exposure * float(np.hypot(*self.drift)))
        angles = self.angle + smear * ((np.arange(count) + 0.5) / count - 0.5)
        steps = exposure * ((np.arange(count) + 0.5) / count - 0.5)
        path = arc(self.pivot + steps[:, None] * self.drift, angles, arm)
        return np.asarray(path + (self.centre - path.mean(axis=0)))


def learn_look(
    look: Appearance,
    frames: list[Frame],
    sightings: list[Sighting],
    medians: tuple[np.ndarray, ...],
    is_first: bool,
    tilt: Tilt,
) -> float:
    """Learn radius, softness, colours and noise again from the balls; return their arm.

    `medians` are the planes of what rests.
    """
    good = [one for one in sightings if one.explained > _TEACHES] or sightings
    arms = [float(np.hypot(*tilt.flat(one.centre - one.pivot))) for one in good]
    arm = float(np.median(arms))
    known = sorted(
        [one for one in good if not math.isnan(one.speed)] or good, key=lambda one: abs(one.speed)
    )
    # The slowest of each look, in turn.
    ranked = zip_longest(*(own[:_TEACHERS] for own in _by_look(look, known)))
    teachers = [one for each in ranked for one in each if one is not None]
    has_edge = look.body is None and look.radius >= SMALLEST_DISC
    if has_edge:
        _learn_edge(look, frames, teachers, sightings, arm, is_first)
        _learn_paint(look, frames, teachers, arm)
    elif look.body is not None:
        learn_body(look, frames, teachers, medians)
    else:  # smears are longer than it, and hide its colours
        look.radius_sigma = look.blur
    clear = _learn_noise(look, frames, good)
    if has_edge:
        _learn_variance(look, frames, teachers, arm, clear)
    return arm


def _by_look(look: Appearance, sightings: list[Sighting]) -> list[list[Sighting]]:
    """Return the sightings of the balls of each look; of one that was not seen, all of them."""
    return [
        [one for one in sightings if look.number(one.ball) == number] or sightings
        for number in range(len(look.paint))
    ]


def _learn_paint(
    look: Appearance, frames: list[Frame], teachers: list[Sighting], arm: float
) -> None:
    """Learn the balls' colours, and whether some of them turn with the rod.

    A pattern that turns is believed in if colours that stay leave clearly more unexplained, and
    then for as long as they leave more: on a narrow part of the circle, turning changes little.
    """
    look.variance = np.zeros((1, 1, 1), np.float32)
    share = 1.0 if look.is_spinning else _TURNS
    looks, costs = [], []
    for learn in (_learn_staying, _learn_turning):
        learn(look, frames, teachers, arm)
        look.whitened()
        cost = sum(
            fit_balls(
                look, frames[one.frame][2:], {one.ball: one.path(arm, look.exposure)}, one.pivot,
                rounds=1, tolerant=0,
            ).cost
            for one in teachers
        )  # fmt: skip
        looks.append((look.is_spinning, look.paint, look.shading))
        costs.append(cost)
    look.is_spinning, look.paint, look.shading = looks[costs[1] < share * costs[0]]
    look.whitened()


def _learn_staying(
    look: Appearance, frames: list[Frame], teachers: list[Sighting], arm: float
) -> None:
    """Learn colours that stay as the balls turn."""
    look.is_spinning, look.shading = False, None
    look.paint = np.stack([
        filled(quantile_of_seen(_paints(look, frames, own, arm), 0.5))
        for own in _by_look(look, teachers)
    ])  # fmt: skip


def _learn_turning(
    look: Appearance, frames: list[Frame], teachers: list[Sighting], arm: float
) -> None:
    """Learn colours that turn with the rod, and the shading that is added to them.

    Each is what the other leaves of the balls, so both are learned in turn.
    """
    look.is_spinning, look.shading = False, None
    groups, each = _by_look(look, teachers), []
    for is_spinning in (False, True):
        look.is_spinning = is_spinning
        each.append([[filled(one) for one in _paints(look, frames, own, arm)] for own in groups])
    divided = [
        _divided(staying, turning, [one.angle for one in own])
        for staying, turning, own in zip(*each, groups, strict=True)
    ]
    look.paint, look.shading = (np.stack(parts) for parts in zip(*divided, strict=True))


def _divided(
    staying: list[np.ndarray], turning: list[np.ndarray], angles: list[float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return what turns with the rod and what stays of colours seen in several frames.

    `staying` holds them as they are, `turning` turned back by the `angles` [rad].
    """
    paint = np.median(turning, axis=0)
    for _ in range(_DIVIDED):
        back = [turned(paint, -angle) for angle in angles]
        shading = np.median(np.subtract(staying, back), axis=0)
        back = [turned(shading, angle) for angle in angles]
        paint = np.median(np.subtract(turning, back), axis=0)
    return paint, shading


def _paints(
    look: Appearance, frames: list[Frame], teachers: list[Sighting], arm: float
) -> np.ndarray:
    """Return the colours within the edge of each ball, NaN beyond, without shading."""
    inner = look.radius - 1.6 * look.blur - 0.3
    paints = []
    for one in teachers:
        turn = one.angle if look.is_spinning else 0.0
        path = one.path(arm, look.exposure)
        paint = unmixed_paint(look, one.ball, frames[one.frame], path, one.pivot, turn, inner)
        if look.shading is not None:
            paint = paint - turned(look.shading[look.number(one.ball)], turn)
        paints.append(paint)
    return np.stack(paints)


def _learn_edge(
    look: Appearance,
    frames: list[Frame],
    teachers: list[Sighting],
    sightings: list[Sighting],
    arm: float,
    is_far: bool,
) -> None:
    """Learn radius and softness of the edge from balls cut out of their frames.

    While the exposure is unknown, only balls that hardly move have an edge to measure.
    """
    if look.exposure == 0.0:
        slow = [one for one in teachers if not abs(one.speed) * arm > _HARDLY * look.radius]
        if len(slow) < _FEWEST_SHOTS:
            _vary_edge(look, frames, teachers[:_SLOWEST], arm)
            return
        teachers = slow
    shots = []
    for one in teachers:
        path = one.path(arm, look.exposure)
        half = int(1.6 * look.radius + 0.5 * float(np.ptp(path, axis=0).max())) + 6
        corner, side = np.rint(one.centre).astype(int) - half, 2 * half + 1
        image = look.colours.window(frames[one.frame][2:], corner, (side, side))
        others = [o.centre - corner for o in sightings if o.frame == one.frame and o is not one]
        shots.append(
            Shot(
                image,
                look.wall(corner, (side, side)),
                path - corner,
                one.pivot - corner,
                one.angle if look.is_spinning else 0.0,
                np.reshape(others, (-1, 2)),
                look.number(one.ball),
            )
        )
    edge = measured_edge(shots, look.radius, look.blur, is_far)
    look.radius, look.blur, look.radius_sigma = edge.radius, edge.blur, edge.sigma


def _vary_edge(look: Appearance, frames: list[Frame], teachers: list[Sighting], arm: float) -> None:
    """Choose the radius and softness with which the colours learned so far explain most."""
    paths = [one.path(arm, look.exposure) for one in teachers]

    def cost() -> float:
        return sum(
            fit_balls(
                look, frames[one.frame][2:], {one.ball: path}, one.pivot, rounds=1, tolerant=0
            ).cost
            for one, path in zip(teachers, paths, strict=True)
        )

    for width in _WIDTHS:
        for name, low, high in (("radius", 0.0, 1e9), ("blur", 0.35, 0.25 * look.radius)):
            middle = getattr(look, name)
            spread = 3.0 * width if name == "blur" else width
            costs = {}
            for trial in np.clip(middle * (1.0 + spread * np.linspace(-1.5, 1.5, 7)), low, high):
                setattr(look, name, float(trial))
                costs[float(trial)] = cost()
            setattr(look, name, min(costs, key=costs.__getitem__))
    look.radius_sigma = look.blur


def _learn_noise(look: Appearance, frames: list[Frame], sightings: list[Sighting]) -> float:
    """Learn the covariance of what the background does not explain around the balls.

    Returns the residual from which something would be else than a ball of one colour.
    """
    outer, inner, rest_walls = [], [], []
    exposure = look.exposure or 0.5
    for one in sightings[:: max(1, len(sightings) // _RINGS)]:
        arm = float(np.hypot(*(one.pivot - one.centre)))
        smear = 0.0 if math.isnan(one.speed) else abs(one.speed) * exposure * arm
        half = int(1.7 * look.reach + 0.5 * smear) + 2
        side = 2 * half + 1
        corner = np.rint(one.centre).astype(int) - half
        image = look.colours.window(frames[one.frame][2:], corner, (side, side))
        wall = look.wall(corner, (side, side))
        j, i = np.indices((side, side))
        dx, dy = i + corner[0] - one.centre[0], j + corner[1] - one.centre[1]
        away = np.hypot(dx, dy)
        along = (one.pivot - one.centre) / np.hypot(*(one.pivot - one.centre))
        is_rod = (dx * along[0] + dy * along[1] > 0.0) & (
            np.abs(dx * along[1] - dy * along[0]) < 0.5 * look.radius
        )
        beyond = away - 0.5 * smear
        ring = (beyond > 1.15 * look.reach) & (beyond < 1.7 * look.reach) & ~is_rod
        if not np.isfinite(wall[ring]).any():
            continue
        outer.append((image - wall)[ring])
        rest_walls.append(np.nanmedian(wall[ring], axis=0))
        if one.explained > _TEACHES and smear < _SLOW * look.radius:
            m = (look.paint.shape[1] - 1) // 2
            core = away < look.reach
            turn = one.angle if look.is_spinning else 0.0
            back_x = dx[core] * math.cos(turn) - dy[core] * math.sin(turn)
            back_y = dx[core] * math.sin(turn) + dy[core] * math.cos(turn)
            p = np.clip(np.rint(back_x).astype(int) + m, 0, 2 * m)
            q = np.clip(np.rint(back_y).astype(int) + m, 0, 2 * m)
            number = look.number(one.ball)
            own = look.paint[number, q, p]
            if look.shading is not None:
                column, row = (np.rint(each[core]).astype(int) + m for each in (dx, dy))
                own = own + look.shading[number, row, column]
            inner.append((image[core] - own)[look.core[q, p]])
    rest = np.concatenate(outer) if outer else np.empty((0, 3))
    rest = rest[np.isfinite(rest).all(axis=1)]
    if len(rest) < 200:
        return look.scale
    size = np.linalg.norm(rest, axis=1)
    rest = rest[size <= np.quantile(size, 0.97)]
    covariance = rest.T @ rest / len(rest) + np.eye(3) * 2e-6
    look.weight = np.linalg.inv(covariance)
    look.whitened()
    own_scale = look.scale
    if inner:
        own = np.concatenate(inner)
        own = own[np.isfinite(own).all(axis=1)]
        squares = np.einsum("ni,ij,nj->n", own, look.weight, own)
        own_scale = float(np.sqrt(max(12.0, 2.0 * np.quantile(squares, 0.95))))
    gap = look.paint[:, look.core] - np.median(rest_walls, axis=0)
    squares = np.einsum("kni,ij,knj->kn", gap, look.weight, gap)
    contrast = float(np.median(squares, axis=1).min())
    if contrast == 0.0:
        raise broken("like_surroundings")
    # What the colours of the ball themselves leave open is no sign of something else.
    clear = OUTLYING * math.sqrt(contrast)
    look.scale = max(min(own_scale, 2.0 * clear), clear)
    return clear


def _learn_variance(
    look: Appearance, frames: list[Frame], teachers: list[Sighting], arm: float, clear: float
) -> None:
    """Learn how much the balls' colours vary from frame to frame, in variances of the noise.

    `clear` is the residual of something else than a ball of one colour.
    """
    variances = []
    for paint, own in zip(look.paint, _by_look(look, teachers), strict=True):
        each = _paints(look, frames, own, arm)
        squares = np.mean(((each - paint) @ look.whiten.T) ** 2, axis=-1)
        excess = quantile_of_seen(squares, _RARER) / _AT_RARER - 1.0
        excess[excess < (_VARIED * clear) ** 2] = 0.0
        variances.append(filled(excess[..., None])[..., 0])
    look.variance = np.stack(variances).astype(np.float32)


def learn_exposure(
    look: Appearance, frames: list[Frame], sightings: list[Sighting], arm: float, balls: int
) -> None:
    """Learn which share of the frame interval is exposed, from the fastest balls found."""
    moving = [one for one in sightings if abs(one.speed) * arm > 3.0 and one.explained > 0.3]
    if balls == 2:  # away from contacts, where the speed is not that of the pair of frames
        alone = []
        for one in moving:
            others = [o for o in sightings if o.frame == one.frame and o is not one]
            if all(np.hypot(*(o.centre - one.centre)) > 4.0 * look.radius for o in others):
                alone.append(one)
        moving = alone
    fastest = sorted(moving, key=lambda one: -abs(one.speed))[:_FASTEST]
    if len(fastest) < 3:
        return

    def cost(share: float) -> float:
        # The window is that of the longest smear, so that costs compare.
        return sum(
            _cost_in_window(look, frames[one.frame], one.path(arm, share), one, arm)
            for one in fastest
        )

    middle, step = (look.exposure, 0.05) if look.exposure > 0.0 else (0.5, 0.25)
    costs: dict[float, float] = {}
    while step > 0.04:
        for share in np.clip(middle + step * np.arange(-2, 3), 0.0, 1.0).round(4).tolist():
            if share not in costs:
                costs[share] = cost(share)
        middle, step = min(costs, key=costs.__getitem__), 0.5 * step
    places = sorted(costs)
    at, look.exposure = places.index(middle), middle
    if 0 < at < len(places) - 1:
        near = places[at - 1 : at + 2]
        look.exposure, _ = parabola_top(near, [-costs[place] for place in near])


def _cost_in_window(
    look: Appearance, frame: Frame, path: np.ndarray, one: Sighting, arm: float
) -> float:
    """Return the cost of a smeared ball after its shift was fitted, summed over pixels."""
    fit = fit_balls(look, frame[2:], {one.ball: path}, one.pivot)
    reach = abs(one.speed) * arm
    margin = 1.35 * look.reach + 2.0 * look.blur + 3.0
    ends = path + fit.shift[0]
    low = np.floor(one.centre - reach / 2.0 - margin).astype(int)
    high = np.ceil(one.centre + reach / 2.0 + margin).astype(int)
    shape = (int(high[1] - low[1] + 1), int(high[0] - low[0] + 1))
    layer = look.ball(one.ball, ends, one.pivot, low, shape)
    cost, *_ = kernels.normal_equations(
        look.patch(frame[2:], low, shape), layer[None], ends.mean(axis=0)[None], one.pivot,
        look.drawn(one.ball), look.scale,
    )  # fmt: skip
    return cost
