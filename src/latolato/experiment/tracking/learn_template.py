"""Learns a clip whose bobs are not discs: the pivot, and a template of the bob and of its body."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from latolato.core.errors import InputError
from latolato.experiment.tracking.appearance import Colours
from latolato.experiment.tracking.geometry import Geometry
from latolato.experiment.tracking.learn import ImageModel, first_sightings, fit_sample
from latolato.experiment.tracking.paint import filled
from latolato.experiment.tracking.route import Route
from latolato.experiment.tracking.sample import Sample
from latolato.experiment.tracking.teach import Sighting
from latolato.experiment.tracking.template import Template
from latolato.experiment.video import Frame, Video

# Half the side of the patch where it is not given: over the radius of the bob, or over the arm.
ROUND, SHARE = 1.4, 0.15
# First guess of what a template does not explain, of the part of it that is the bob, and of its
# width over that of the patch.
_NOISE, _CORE = 0.03, 0.6
# Least contrast of the bob with the wall, as a share of white.
_PLAIN = 0.02
# How often the template is learned again, and from how many of the slowest bobs.
_ROUNDS, _TEACHERS = 3, 16
# Share of the body that must be explained for a frame to teach.
_TEACHES = 0.7
# A pixel is the bob's if the wall would leave this many times more of it unexplained, and this
# share of the contrast.
_CLEAR, _CLEAR_SHARE = 4.0, 0.25
# Share of the contrast beyond which residuals belong to something else.
_OUTLYING = 0.35


def learn_template_model(
    video: Video,
    sample: Sample,
    geometry: Geometry,
    balls: list[np.ndarray],
    half: float | None,
    route: Route,
    progress: Callable[[float], None] | None = None,
) -> ImageModel:
    """The image model of a clip whose bobs are followed by a template.

    Parameters
    ----------
    video, sample : Video, Sample
        The clip and the frames to learn from.
    geometry : Geometry
        What the bobs turn about.
    balls : list of numpy.ndarray, shape (2,)
        The point of each bob that is followed, in the clicked frame [pixels].
    half : float or None
        Half the side of the patch about the click [pixels]; None: 0.15 of the arm.
    route : Route
        Where the bobs roughly are in all frames.

    Raises
    ------
    InputError
        If the patch is not found in any other frame.
    """
    frames = sample.from_click
    medians, pivots = sample.medians, geometry.pivots
    arm = geometry.arm(balls)
    reach = math.ceil(half or SHARE * arm)
    side = 2 * reach + 1
    away = np.hypot(*(np.indices((side, side)) - reach))
    colours = Colours.of(video)
    look = Template(
        colours, np.zeros((side, side, 3)), np.where(away <= reach + 0.5, _NOISE**2, math.inf),
        away <= _CORE * reach, 1.0, _CORE * reach,
    )  # fmt: skip
    first = Sighting(0, balls[0], pivots[0], _angle(balls[0], pivots[0]), 0.0, 1.0, np.zeros(2))
    _learn(look, frames, [first], medians)
    scene = ImageModel(geometry.tracker, look, arm, len(balls), tilt=geometry.tilt)
    scene.lean = _lean(route, sample.click, balls, pivots[0])
    sightings: list[Sighting] = []
    for round_ in range(_ROUNDS):
        if round_ == 0:
            sightings = first_sightings(scene, frames, pivots, route)
        sightings = fit_sample(scene, frames, sightings, pivots, tolerant=1)
        others = {one.frame for one in sightings if one.frame > 1}
        if not others:
            raise InputError(
                f"nothing like the patch at ({balls[0][0]:g}, {balls[0][1]:g}) was found in other "
                "frames",
                way_out="point at the middle of the bob, or choose another patch",
            )
        teachers = [one for one in sightings if one.explained > _TEACHES] or sightings
        arms = [np.hypot(*scene.tilt.flat(one.centre - one.pivot)) for one in teachers]
        scene.arm = float(np.median(arms))
        teachers.sort(key=lambda one: abs(one.speed) if math.isfinite(one.speed) else math.inf)
        _learn(look, frames, teachers[:_TEACHERS], medians)
        if progress:
            progress((round_ + 1) / _ROUNDS)
    scene.explained = float(np.median([one.explained for one in sightings]))
    return scene


def _lean(route: Route, number: int, balls: list[np.ndarray], pivot: np.ndarray) -> float:
    """Return by which angle what is pointed at is ahead of the middle of what moves [rad]."""
    if not (0 <= number < len(route.times) and route.is_seen[number].all()):
        return 0.0
    places = route.places[number]
    each = [
        math.remainder(_angle(ball, pivot) - _angle(place, pivot), math.tau)
        for ball, place in zip(balls, places, strict=True)
    ]
    return float(np.mean(each))


def _angle(place: np.ndarray, pivot: np.ndarray) -> float:
    """Return the angle of a place from straight down about a pivot [rad]."""
    return math.atan2(*(place - pivot))


def _learn(
    look: Template, frames: list[Frame], sightings: list[Sighting], medians: tuple[np.ndarray, ...]
) -> None:
    """Learn picture, variance and body again from bobs where they were found."""
    own, wall = (
        np.stack([look.seen(planes, one.centre, one.angle) for one, planes in each])
        for each in (
            [(one, frames[one.frame][2:]) for one in sightings],
            [(one, medians) for one in sightings],
        )
    )
    inside = np.isfinite(look.variance) & np.isfinite(own).all(axis=(0, 3))
    look.picture = filled(np.median(own, axis=0))
    as_wall = np.median(np.mean((own - wall) ** 2, axis=-1), axis=0)
    rest = np.median(np.mean((own - look.picture) ** 2, axis=-1), axis=0)
    if len(sightings) < 3:  # one patch explains itself
        rest = np.full_like(as_wall, _NOISE**2)
    contrast = float(np.quantile(as_wall[inside], 0.95))
    if contrast < _PLAIN**2:
        raise InputError(
            "the patch around the click looks like the wall",
            way_out="point at the bob, or make the patch larger",
        )
    look.variance = np.where(inside, 2.0 * rest, math.inf)
    body = inside & (as_wall > np.maximum(_CLEAR * rest, _CLEAR_SHARE**2 * contrast))
    if body.any():
        look.body = body
        look.limit = _OUTLYING * math.sqrt(contrast)
        look.radius = float(np.quantile(np.abs(look.offsets[body][:, 0]), 0.95)) + 0.5
    look.weighed()
