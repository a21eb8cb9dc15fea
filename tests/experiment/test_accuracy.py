"""How well angles are measured: clips of two renderers, whose truth is known, and limits for each.

A line for each clip, and how long tracking it took:

    python -m pytest tests/experiment/test_accuracy.py -rP

The first renderer is `latolato.experiment.synthetic` under all its filming conditions, with one
driven ball, two, and one that swings freely. The second is `films`, whose films are harder. Clicks
are rounded to whole pixels.
"""

from __future__ import annotations

import dataclasses
import time
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest

import films
import latolato as ll
from conditions import conditions
from latolato.experiment.calibration.lens import Optics
from latolato.experiment.synthetic.synthesise import synthesise_video

ONE = ll.Pendulum(length=0.363, mass=0.108, damping=0.00274)
TWO = ll.LatoLato(length=0.245, mass=0.1064, damping=0.005, radius=0.02, restitution=0.9)
# An angle that is that uncertain is not known.
UNCERTAIN = 0.5
# Error from which a ball is taken for another one; two that touch are farther apart [rad].
_APART = 0.05


@dataclass(frozen=True)
class Limits:
    """What the samples flagged ok of a clip must reach.

    Parameters
    ----------
    rms : float
        Largest root mean square error [mrad].
    ok : float
        Smallest share of samples that are ok.
    within : float
        Smallest share of these within two standard deviations of the truth.
    ratio : tuple
        Smallest and largest root mean square error over the median standard deviation. Larger
        deviations than needed are seen here, not in `within`: where all samples share an error,
        all of them are within two deviations, or none.
    warns : str
        What a warning must say.
    former : float
        Root mean square error before the tracker was rebuilt [mrad]; half of it is the aim. 0 for
        none.
    fails : str
        Why the tracker does not reach it; empty if it does. The limits are then the aim.
    """

    rms: float
    _: dataclasses.KW_ONLY
    ok: float = 0.98
    within: float = 0.93
    ratio: tuple[float, float] = (0.5, 2.0)
    warns: str = ""
    former: float = 0.0
    fails: str = ""


_NO_CIRCLE = "not move on a circle"
# What was reached plus 10 %. A share or a ratio is named where it is outside the common limits,
# which is where deviations are too large (ratios below 0.5) or too small. Errors that all samples
# share make the deviations: where only the error falls, both numbers do, so that their quotient,
# the largest deviation, does not grow.
SYNTHETIC: dict[str, Limits] = {
    "clean one": Limits(0.12, ratio=(0.3, 2.0)),
    "clean two": Limits(0.14, ratio=(0.375, 2.0)),
    "clean free": Limits(0.11, ratio=(0.3, 2.0)),
    "texture one": Limits(0.48),
    "texture two": Limits(0.66, ratio=(0.465, 2.0)),
    "texture free": Limits(0.44, ratio=(0.3, 2.0)),
    "wood one": Limits(1.12, ratio=(0.3, 2.0)),
    "wood two": Limits(1.97, ratio=(0.3, 2.0)),
    "wood free": Limits(1.94),
    "variable one": Limits(0.13, ratio=(0.3, 2.0)),
    "variable two": Limits(0.13, ok=0.97, ratio=(0.3, 2.0)),
    "variable free": Limits(0.11, ratio=(0.3, 2.0)),
    "rotated one": Limits(0.16, ratio=(0.3, 2.0)),
    "rotated two": Limits(0.18, ratio=(0.4, 2.0)),
    "rotated free": Limits(0.09, ratio=(0.2, 2.0)),
    "tilted one": Limits(0.13, ratio=(0.3, 2.0)),
    "tilted two": Limits(0.16, ratio=(0.3, 2.0)),
    "tilted free": Limits(0.12, ratio=(0.3, 2.0)),
    "blur one": Limits(
        0.30, ratio=(0.2, 2.0), former=0.266,
        fails="0.35 mrad, 0.5 in a part: distances off by 0.1 pixels move the hinge by half one",
    ),
    "blur two": Limits(
        0.59, ok=0.92, ratio=(0.2, 2.0), former=0.53,
        fails="1.1 mrad and 91 % ok: smears as long as the balls are wide",
    ),
    "blur free": Limits(0.19, ratio=(0.4, 2.0), former=0.24),
    "lowlight one": Limits(0.40),
    "lowlight two": Limits(0.41, ok=0.97),
    "lowlight free": Limits(0.29, former=0.26, fails="0.35 mrad, most of it gravity's direction"),
    "compressed one": Limits(1.53, ratio=(0.4, 2.0)),
    "compressed two": Limits(2.54),
    "compressed free": Limits(1.00),
    "steel one": Limits(0.30, ok=0.88, ratio=(0.3, 2.0)),
    "steel two": Limits(
        0.56, ok=0.85,
        fails="0.62 mrad, 85 % ok: reflections that pass are taken for what hides a ball",
    ),
    "steel free": Limits(
        0.32, ok=0.97, ratio=(0.2, 2.0),
        fails="96.7 % ok: two more frames of 300 count as hidden since smears are drawn evenly",
    ),
    "occluded one": Limits(0.28, ok=0.92, ratio=(0.4, 2.0)),
    "occluded two": Limits(
        0.25, ok=0.81, former=0.22,
        fails="67 % ok, 0.34 mrad: after both were behind the post it is not sure which is which",
    ),
    "occluded free": Limits(
        0.19, ok=0.85, fails="75 % ok: more of what the post touches counts as hidden",
    ),
    "rolling one": Limits(0.14, ratio=(0.3, 2.0)),
    # What no deviation contains, as the documentation says.
    "rolling one undeclared": Limits(39.0, within=0.14, ratio=(0.5, 10.0), warns=_NO_CIRCLE),
    "rolling two": Limits(2.39, ok=0.97, ratio=(0.5, 3.6)),
    "rolling two undeclared": Limits(
        42.0, ok=0.97, within=0.20, ratio=(0.5, 5.5), warns=_NO_CIRCLE
    ),
    "rolling free": Limits(0.12, ratio=(0.3, 2.0)),
    "rolling free undeclared": Limits(31.0, within=0.01, ratio=(0.5, 99.0)),
    "lens one": Limits(0.86, ok=0.96, former=0.78, fails="1.0 mrad"),
    "lens one undeclared": Limits(5.48, ok=0.96, ratio=(0.3, 2.0), warns=_NO_CIRCLE),
    "lens two": Limits(0.62, ratio=(0.4, 2.0)),
    "lens two undeclared": Limits(3.89, ratio=(0.2, 2.0), warns=_NO_CIRCLE),
    "lens free": Limits(0.94, former=0.85, fails="1.06 mrad, most of them the lens's"),
    "lens free undeclared": Limits(2.04, ratio=(0.1, 2.0), warns=_NO_CIRCLE),
}  # fmt: skip

FILMS: dict[str, Limits] = {
    "plain": Limits(0.28, ratio=(0.32, 2.0), former=0.572),
    "texture two": Limits(0.69, ok=0.97, ratio=(0.4, 2.0), former=0.973),
    "spin": Limits(
        1.5, ok=0.95, former=18.5,
        fails="5.7 mrad: stripes that pass still draw the ball aside",
    ),
    "blur two": Limits(1.81, ok=0.92, ratio=(0.2, 2.0), former=2.40),
    "occluded": Limits(1.15, ok=0.91, former=1.375),
    "clutter two": Limits(
        0.68, ok=0.97, former=0.843, fails="deviations of 2.05 times the error, 2 are allowed",
    ),
    "free": Limits(0.87, former=0.849),
    "top two": Limits(0.46, ok=0.96, ratio=(0.4, 2.0), former=0.520),
    "dot": Limits(0.58, ok=0.93),
    "arms": Limits(0.89),
    # A fifth of the pictures repeats another. A hand hides a third of the ball for a second. What
    # may be a lens makes an oval uncertain.
    "repeated": Limits(0.53, ok=0.79, ratio=(0.3, 2.0), former=1.708),
    "held": Limits(0.44, ok=0.72, ratio=(0.3, 2.0), former=1.164),
    "knocked": Limits(0.52, ratio=(0.331, 2.0), former=1.017),
    "askew": Limits(0.51, ratio=(0.05, 2.0), former=2.703),
    "swaying": Limits(0.26, ratio=(0.2, 2.0)),
    "colours two": Limits(0.95, ok=0.97),
    "tilted two": Limits(0.74, ok=0.97, ratio=(0.2, 2.0), former=1.199),
}  # fmt: skip

# Which part of a clip `make test` films, to the same limits. Between them: contacts, a wall with
# shadows, motion blur, a hidden ball.
QUICK = {"texture two": 0.65, "blur one": 0.4, "occluded one": 0.4}


@dataclass(frozen=True)
class _Clip:
    """A file, the true angles (ball, frame) [rad], and the arguments of `track`."""

    path: Path
    angles: Any
    arguments: dict[str, Any]


@dataclass(frozen=True)
class _Accuracy:
    """What was reached; the same names as in `Limits`, and the median and largest deviation."""

    ok: float
    within: float
    rms: float
    sigma: float
    largest: float
    swaps: int

    @property
    def ratio(self) -> float:
        """Error over deviation."""
        return 1e-3 * self.rms / self.sigma


def _synthesised(name: str, folder: Path, part: float = 1.0) -> _Clip:
    """Film under a condition, or only the first part of it."""
    condition, balls, *optics = name.split()
    system, ratio, angle = (TWO, 2.3, 0.9) if balls == "two" else (ONE, 1.95, 0.6)
    drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=ratio * system.natural_frequency)
    if balls == "free":
        run = ll.simulate(system, None, initial_angle=0.7, duration=5.0 * part)
    else:
        run = ll.simulate(system, drive, initial_angle=angle, duration=4.0 * part)
    scene, camera = conditions[condition].make(scene={"ball_radius": 0.02})
    path = folder / "clip.mp4"
    truth = synthesise_video(run, path, scene, camera, seed=7)
    clicks = truth.attrs
    pivot, *places = [
        (round(clicks[f"{part}_pixel_u"]), round(clicks[f"{part}_pixel_v"]))
        for part in ("pivot", "ball_1", "ball_2")
        if f"{part}_pixel_u" in clicks
    ]
    declared = Optics(row_time=camera.row_time, lens_k1=camera.k1, lens_k2=camera.k2)
    angles = np.stack([truth[f"angle_{k + 1}"].values for k in range(len(places))])
    return _Clip(path, angles, {
        "pivot": pivot, "balls": places, "length": clicks["length"], "radius": clicks["radius"],
        "optics": Optics() if optics == ["undeclared"] else declared,
    })  # fmt: skip


def _filmed(name: str, folder: Path) -> _Clip:
    """Film with the second renderer."""
    path, truth = films.shoot(films.films[name], folder / "clip")
    clicks = np.rint([truth.pivots[0], *truth.places[:, 0]]).tolist()
    arguments = {"pivot": clicks[0], "balls": clicks[1:]}
    if truth.length is not None:
        arguments |= {"length": truth.length, "radius": truth.radius}
    return _Clip(path, truth.angles, arguments)


def _measured(clip: _Clip, table: Any) -> _Accuracy:
    """Compare a track table with the truth."""
    true = clip.angles[:, table["frame"].values]
    angle, sigma, flag = (
        np.stack([table[f"{column}_{k + 1}"].values for k in range(len(true))])
        for column in ("angle", "angle_sigma", "flag")
    )
    # A ball may have turned over.
    error, other = (np.angle(np.exp(1j * (angle - each))) for each in (true, true[::-1]))
    ok = flag == "ok"
    assert ok.any()
    is_swapped = ok & (np.abs(other) < np.abs(error)) & (np.abs(error) > _APART) & (len(true) > 1)
    return _Accuracy(
        ok=float(ok.mean()),
        within=float(np.mean(np.abs(error[ok]) < 2.0 * sigma[ok])),
        rms=1e3 * float(np.sqrt(np.mean(error[ok] ** 2))),
        sigma=float(np.median(sigma[ok])),
        largest=float(sigma[ok].max()),
        swaps=int(is_swapped.sum()),
    )


def _check(name: str, clip: _Clip, limits: Limits) -> None:
    """Track a clip, print what was reached and compare it with the limits."""
    began = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        table = ll.track(clip.path, **clip.arguments)
    spent = time.process_time() - began
    reached = _measured(clip, table)
    told = table.attrs.get("warnings", "")
    print(
        f"{name:24} ok {reached.ok:4.2f}  within 2 sigma {reached.within:5.3f}  "
        f"rms {reached.rms:6.3f} mrad  sigma {1e3 * reached.sigma:6.3f} mrad  "
        f"{spent:4.1f} s  {told[:60]}"
    )
    assert reached.swaps == 0
    assert reached.largest < UNCERTAIN
    assert reached.ok >= limits.ok
    assert reached.rms <= limits.rms
    assert reached.within >= limits.within
    assert limits.ratio[0] <= reached.ratio <= limits.ratio[1]
    assert limits.warns in told


def _rows(table: dict[str, Limits]) -> list[Any]:
    """Names of clips."""
    rows = []
    for name, limits in table.items():
        fails = pytest.mark.xfail(reason=limits.fails, raises=AssertionError, strict=True)
        rows.append(pytest.param(name, marks=[fails] if limits.fails else []))
    return rows


@pytest.mark.parametrize("name", _rows({name: SYNTHETIC[name] for name in QUICK}))
def test_a_part_of_a_clip_is_measured_as_well_as_all_of_it(name, tmp_path):
    _check(name, _synthesised(name, tmp_path, QUICK[name]), SYNTHETIC[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", _rows(SYNTHETIC))
def test_clips_of_all_conditions_are_measured_well(name, tmp_path):
    _check(name, _synthesised(name, tmp_path), SYNTHETIC[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", _rows(FILMS))
def test_films_of_another_renderer_are_measured_well(name, tmp_path):
    _check(name, _filmed(name, tmp_path), FILMS[name])


def test_every_condition_and_every_film_has_limits():
    cases = {tuple(name.split()[:2]) for name in SYNTHETIC}
    assert cases == {(name, balls) for name in conditions for balls in ("one", "two", "free")}
    assert set(FILMS) == set(films.films)


def test_a_centroid_finds_the_balls_of_a_film_where_the_truth_says(tmp_path):
    film = dataclasses.replace(films.films["plain"], seconds=0.5)
    path, truth = films.shoot(film, tmp_path / "film")
    with av.open(str(path)) as file:
        frames = [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]
    # Red light, in which the ball alone is brighter than the wall.
    red = np.stack(frames)[..., 0].astype(float)
    wall = np.median(red, axis=0)
    found = []
    for (u, v), picture in zip(truth.places[0], red, strict=True):
        near = cv2.circle(
            np.zeros(wall.shape), (round(u), round(v)), round(2 * film.radius), 1.0, -1
        )
        level = np.percentile(picture[near > 0.0], 90)
        moments = cv2.moments(near * (picture > 0.5 * (level + wall)))
        found.append([moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]])
    errors = np.array(found) - truth.places[0]
    assert len(errors) == truth.angles.shape[1]
    assert np.abs(errors.mean(axis=0)).max() < 0.1
    assert np.sqrt((errors**2).mean(axis=0)).max() < 0.1
