"""Films of pendulums with known truth, painted ray by ray.

A second opinion on `latolato.experiment.synthetic`: it shares no code, no method and no codec with
it. A pixel is the mean of rays, each with its own place in the pixel and its own moment of the
exposure (Cook, Porter and Carpenter 1984, distributed ray tracing), so that soft edges and motion
blur come from one sum. Then come vignetting, shot and read noise, and the tone curve of BT.709,
where `synthetic` has that of sRGB.

`films` holds the films by name, `shoot` writes one and returns its truth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numba
import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

import latolato as ll
from little_videos import encoded

# Distance between the samples of a run [s].
DENSE = 1e-4
# Fewest rays of a pixel, and rays for each pixel of the longest smear.
RAYS, RAYS_PER_PIXEL = 48, 2.0
# Standard deviation of the lens's blur [pixels].
LENS = 0.5
# Pixels around the picture that are painted too, for a camera that moves.
MARGIN = 16
# Towards the light, which is above the camera and to its left: right, down, to the viewer.
LIGHT = np.array([-0.45, -0.55, 0.70]) / math.hypot(0.45, 0.55, 0.70)
# Ambient light, strength and sharpness of the highlight.
AMBIENT, HIGHLIGHT, SHININESS = 0.3, 0.35, 24.0
# Surfaces of balls.
FLAT, SHADED, PATTERNED = range(3)
# Largest signal [electrons] and read noise [electrons].
FULL_WELL, READ_NOISE = 9000.0, 6.0
# A hand's width over its height, and how fast it leaves [pixel/s].
HAND_SHAPE, HAND_SPEED = 1.6, 420.0

# Suffix, layout and options of each codec.
CODECS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "mpeg4": (".avi", "yuv420p", {"bit_rate": 6_000_000}),
    "mjpeg": (".avi", "yuvj420p", {"bit_rate": 30_000_000}),
    "libvpx-vp9": (".webm", "yuv420p", {"crf": "24", "deadline": "realtime", "cpu-used": "6"}),
    "libx265": (
        ".mp4", "yuv420p", {"crf": "22", "preset": "veryfast", "x265-params": "log-level=none"},
    ),
}  # fmt: skip
ORANGE, BLUE, SKIN = (0.80, 0.13, 0.02), (0.03, 0.10, 0.45), (0.55, 0.28, 0.17)


@dataclass(frozen=True, kw_only=True)
class Film:
    """What is filmed and how; lengths in pixels, colours in linear light.

    Parameters
    ----------
    systems, starts : sequence
        One system, or a pendulum for each ball, and the initial state of each.
    drive : drive, optional
        Of all of them.
    seconds, size, rate : float, tuple and int
        Duration, columns and rows, and frames per second.
    arm, radius : float
        From pivot to centre of the longest pendulum; a ball's radius.
    centre : tuple
        The mean pivot's column and row.
    exposure : float
        Share of the time between frames.
    other_colour : tuple or None
        Of the second ball; None for that of the first.
    is_flat : bool
        Whether balls are discs of one colour, as if drawn, not spheres with light and shade.
    spin : float
        How fast a two-coloured ball turns about its rod [rad/s]; 0 for balls of one colour.
    rod_width, pivot_size : float
        Width of the rods, and side of the square block at the pivot.
    mottle : float
        Contrast of the wall's texture.
    shadow : tuple
        Shift of the shadow on the wall, to the right and down, and its softness.
    pole : tuple
        Left and right edge of a pole in front of the balls.
    clutter : sequence of tuple
        Places of balls at rest.
    held : float
        Until when a hand holds the balls [s]; it leaves then.
    knock : tuple
        When somebody knocks the camera [s], and by how many pixels the picture jumps.
    roll : float
        Angle by which the camera is turned about its axis [rad].
    slant : float
        Angle at which the camera, far away, looks at the swing from the side [rad].
    repeats : int
        Of so many pictures the last is shown twice, as in 24 a second converted to 30; 0 for none.
    codec : str
        A key of `CODECS`.
    """

    systems: Sequence[Any]
    drive: Any = None
    starts: Sequence[dict[str, float]]
    seconds: float = 3.0
    size: tuple[int, int] = (640, 480)
    rate: int = 60
    exposure: float = 0.5
    arm: float
    radius: float
    centre: tuple[float, float]
    colour: tuple[float, float, float] = ORANGE
    other_colour: tuple[float, float, float] | None = None
    is_flat: bool = False
    spin: float = 0.0
    wall: tuple[float, float, float] = (0.42, 0.40, 0.36)
    mottle: float = 0.03
    shadow: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rod_width: float = 3.0
    pivot_size: float = 14.0
    pivot_colour: tuple[float, float, float] = (0.10, 0.11, 0.13)
    pole: tuple[float, float] | None = None
    clutter: Sequence[tuple[float, float]] = ()
    held: float = 0.0
    knock: tuple[float, int, int] | None = None
    roll: float = 0.0
    slant: float = 0.0
    repeats: int = 0
    codec: str = "mpeg4"


@dataclass(frozen=True)
class Truth:
    """What a tracker should find, ball 1 being the right-hand one at first.

    Parameters
    ----------
    angles : ndarray, shape (ball, frame)
        Angle of each ball from straight down at the middle of what each picture shows [rad].
    pivots, places : ndarray, shapes (frame, 2) and (ball, frame, 2)
        Column and row of pivot and balls, before anybody knocks the camera.
    length, radius : float or None
        In metres; None if the arms differ.
    """

    angles: Any
    pivots: Any
    places: Any
    length: float | None
    radius: float | None


@dataclass(frozen=True)
class _Motion:
    """Samples of a motion: time [s], place of the pivot [m], each ball's angle [rad] and arm."""

    time: Any
    across: Any
    height: Any
    angles: list[Any]
    arms: list[float]
    film: Film

    def at(self, times: Any) -> tuple[Any, Any, Any]:
        """Angles (ball, ...), places of the pivot (..., 2) and of the balls (ball, ..., 2)."""
        film = self.film
        longest = max(system.length for system in film.systems)
        late = np.maximum(times - film.held, 0.0)
        across, up = (
            np.interp(late, self.time, each) * film.arm / longest
            for each in (self.across, self.height)
        )
        angles = np.array([np.interp(late, self.time, angle) for angle in self.angles])
        c, s = math.cos(film.roll), math.sin(film.roll)
        pivots = np.array(film.centre) + np.stack(
            [c * across - s * up, -s * across - c * up], axis=-1
        )
        reach = np.array(self.arms).reshape(-1, *[1] * (angles.ndim - 1))
        across, down = math.cos(film.slant) * reach * np.sin(angles), reach * np.cos(angles)
        places = pivots + np.stack([c * across + s * down, c * down - s * across], axis=-1)
        return angles, pivots, places


def _moving(film: Film) -> _Motion:
    """Run what is filmed, in dense samples."""
    times = np.arange(0.0, film.seconds + 0.1, DENSE)
    angles, arms, across, height = [], [], np.zeros_like(times), np.zeros_like(times)
    longest = max(system.length for system in film.systems)
    for system, start in zip(film.systems, film.starts, strict=True):
        run = ll.simulate(system, film.drive, times=times, duration=float(times[-1]), **start)
        height = run["pivot_height"].values
        if film.drive is not None and film.drive.moves_across:
            across = run["pivot_across"].values
        signs = (1.0, -1.0) if isinstance(system, ll.LatoLato) else (1.0,)
        angles += [sign * run["angle"].values for sign in signs]
        arms += [film.arm * system.length / longest] * len(signs)
    return _Motion(times, across - across.mean(), height - height.mean(), angles, arms, film)


@numba.njit
def _ball_colour(x, y, radius, along, spin, surface, colour, light):
    """Colour of a ball's surface at a distance (x, y) from its centre [pixel], lit from one side.

    `along` points from the pivot to the ball.
    """
    if surface == FLAT:
        return colour[0], colour[1], colour[2]
    right, down = x / radius, y / radius
    front = math.sqrt(max(1.0 - right * right - down * down, 0.0))
    facing = right * light[0] + down * light[1] + front * light[2]
    diffuse = AMBIENT + (1.0 - AMBIENT) * max(facing, 0.0)
    # The light reflected towards the viewer, who is straight in front.
    shine = HIGHLIGHT * max(2.0 * facing * front - light[2], 0.0) ** SHININESS
    paint = 1.0
    if surface == PATTERNED:
        across = right * along[1] - down * along[0]
        longitude = math.atan2(across, front) + spin
        paint = 1.0 if math.sin(3.0 * longitude) > 0.0 else 0.3
    return (
        paint * diffuse * colour[0] + shine,
        paint * diffuse * colour[1] + shine,
        paint * diffuse * colour[2] + shine,
    )


@numba.njit
def _distance_to_rod(u, v, pivot, ball):
    """Distance of a point from the line between pivot and ball [pixel]."""
    du, dv = ball[0] - pivot[0], ball[1] - pivot[1]
    share = ((u - pivot[0]) * du + (v - pivot[1]) * dv) / max(du * du + dv * dv, 1e-9)
    share = min(max(share, 0.0), 1.0)
    return math.sqrt((u - pivot[0] - share * du) ** 2 + (v - pivot[1] - share * dv) ** 2)


@numba.njit
def _paint(
    frame, wall, mask, offsets, pivots, balls, hands, spins, radius, rod, block, shadow, colours,
    surface, light,
):  # fmt: skip
    """Paint the pixels of a mask, each the mean of its rays; all else in the frame stays.

    Front to back: hand, balls, block with its hinge, rods, wall with the shadows on it.

    Parameters
    ----------
    frame, wall : ndarray, shape (row, column, 3)
        What is painted, and the wall alone, in linear light.
    mask : ndarray, shape (row, column)
        Not 0 wherever anything but the wall may be seen.
    offsets, pivots : ndarray, shape (ray, 2)
        Place of each ray in the pixel, and of the pivot at its moment.
    balls : ndarray, shape (ball, ray, 2)
    hands : ndarray, shape (ray, 3)
        Place and radius of the hand.
    spins : ndarray, shape (ray,)
        Angle of a ball about its rod.
    radius, rod, block : float
        Radius of a ball, width of a rod, half the side of the block.
    shadow : tuple
        Its shift and its softness.
    surface : int
        `FLAT`, `SHADED` or `PATTERNED`.
    colours : ndarray, shape (4, 3)
        Of the first ball, block, hand and the second ball.
    """
    count, rays = balls.shape[:2]
    along = np.zeros(2)
    for row in range(frame.shape[0]):
        for column in range(frame.shape[1]):
            if not mask[row, column]:
                continue
            total_r, total_g, total_b = 0.0, 0.0, 0.0
            for ray in range(rays):
                u, v = column + offsets[ray, 0], row + offsets[ray, 1]
                pivot = pivots[ray]
                hand_u = (u - hands[ray, 0]) / HAND_SHAPE
                if hand_u**2 + (v - hands[ray, 1]) ** 2 < hands[ray, 2] ** 2:
                    total_r += colours[2, 0]
                    total_g += colours[2, 1]
                    total_b += colours[2, 2]
                    continue
                is_seen = False
                for ball in range(count):
                    x, y = u - balls[ball, ray, 0], v - balls[ball, ray, 1]
                    if x * x + y * y < radius * radius:
                        along[0] = balls[ball, ray, 0] - pivot[0]
                        along[1] = balls[ball, ray, 1] - pivot[1]
                        along /= max(math.sqrt(along[0] ** 2 + along[1] ** 2), 1e-9)
                        colour = colours[3 * ball]
                        r, g, b = _ball_colour(
                            x, y, radius, along, spins[ray], surface, colour, light
                        )
                        total_r, total_g, total_b = total_r + r, total_g + g, total_b + b
                        is_seen = True
                        break
                if is_seen:
                    continue
                x, y = abs(u - pivot[0]), abs(v - pivot[1])
                if x < block and y < block:
                    bright = 4.0 if x * x + y * y < 0.16 * block * block else 1.0
                    total_r += bright * colours[1, 0]
                    total_g += bright * colours[1, 1]
                    total_b += bright * colours[1, 2]
                    continue
                lit = 1.0
                for ball in range(count):
                    if _distance_to_rod(u, v, pivot, balls[ball, ray]) < 0.5 * rod:
                        is_seen = True
                        break
                    if shadow[2] > 0.0:
                        u_0, v_0 = u - shadow[0], v - shadow[1]
                        x, y = u_0 - balls[ball, ray, 0], v_0 - balls[ball, ray, 1]
                        inside = 0.5 + (radius - math.sqrt(x * x + y * y)) / shadow[2]
                        inside = min(max(inside, 0.0), 1.0)
                        lit *= 1.0 - 0.45 * inside * inside * (3.0 - 2.0 * inside)
                        behind = _distance_to_rod(u_0, v_0, pivot, balls[ball, ray])
                        lit *= 1.0 - 0.25 * max(1.0 - behind / (rod + shadow[2]), 0.0)
                if is_seen:
                    total_r, total_g, total_b = total_r + 0.05, total_g + 0.05, total_b + 0.055
                    continue
                total_r += lit * wall[row, column, 0]
                total_g += lit * wall[row, column, 1]
                total_b += lit * wall[row, column, 2]
            frame[row, column, 0] = total_r / rays
            frame[row, column, 1] = total_g / rays
            frame[row, column, 2] = total_b / rays


def _rays(smear: float) -> tuple[Any, Any]:
    """Places in the pixel (ray, 2) and moments of the exposure (ray,) from -0.5 to 0.5.

    Each is spread evenly, and their means are zero: what rests and what moves evenly have their
    centres where the truth says.
    """
    count = int(max(RAYS, RAYS_PER_PIXEL * smear))
    points = qmc.Halton(5, seed=3).random(count)
    offsets = points[:, :2] - 0.5 + LENS * ndtri(points[:, 2:4])
    moments = (np.argsort(np.argsort(points[:, 4])) + 0.5) / count - 0.5
    return offsets - offsets.mean(axis=0), moments


def _wall(film: Film, random: Any) -> Any:
    """The wall with a gradient, its texture and the clutter on it, shape (row, column, 3)."""
    width, height = film.size[0] + 2 * MARGIN, film.size[1] + 2 * MARGIN
    texture = np.zeros((height, width))
    for blur, share in ((2.5, 0.5), (7.0, 0.8), (25.0, 1.0)):
        noise = cv2.GaussianBlur(random.standard_normal((height, width)), (0, 0), blur)
        texture += share * noise / noise.std()
    slope = np.linspace(1.15, 0.85, width) * np.linspace(1.05, 0.95, height)[:, None]
    tone = slope * np.exp(film.mottle * texture)
    wall = np.ascontiguousarray(tone[..., None] * np.array(film.wall), dtype=np.float64)
    offsets, _ = _rays(0.0)
    for place in film.clutter:
        still = np.tile(np.array(place) + MARGIN, (len(offsets), 1))
        _layers(film, wall, wall.copy(), offsets, still, still[None], False)
    return wall


def _whole(place: Any) -> tuple[int, int]:
    """The pixel nearest to a place."""
    return round(float(place[0])), round(float(place[1]))


def _layers(
    film: Film, frame: Any, wall: Any, offsets: Any, pivots: Any, balls: Any,
    is_hung: bool = True, hands: Any = None, times: Any = None,
) -> None:  # fmt: skip
    """Paint pivot, rods, balls and hand; places of rays, all in pixels of the painted frame."""
    far = np.tile([-1e6, -1e6, 0.0], (len(offsets), 1))
    hands = far if hands is None else hands
    mask = np.zeros(frame.shape[:2], np.uint8)
    # Rays are up to about 3 pixels from the middle of theirs.
    room = film.rod_width + 4.0
    for ray in range(len(offsets)):
        for shift, soft in (((0.0, 0.0), 0.0), (film.shadow[:2], film.shadow[2])):
            pivot = _whole(pivots[ray] + shift)
            cv2.circle(mask, pivot, round(film.pivot_size + 4.0), 255, -1)
            for ball in balls:
                place = _whole(ball[ray] + shift)
                cv2.line(mask, pivot, place, 255, round(2.0 * (room + soft)))
                cv2.circle(mask, place, round(film.radius + room + soft), 255, -1)
        if hands[ray, 2]:
            across, down = _whole(hands[ray, 2] * np.array([HAND_SHAPE, 1.0]) + 5.0)
            cv2.ellipse(mask, _whole(hands[ray]), (across, down), 0.0, 0.0, 360.0, 255, -1)
    _paint(
        frame, wall, mask, offsets, pivots, balls, hands,
        np.zeros(len(offsets)) if times is None else film.spin * times, film.radius,
        film.rod_width if is_hung else 0.0, 0.5 * film.pivot_size if is_hung else 0.0,
        film.shadow,
        np.array([film.colour, film.pivot_colour, SKIN, film.other_colour or film.colour]),
        FLAT if film.is_flat else PATTERNED if film.spin else SHADED, LIGHT,
    )  # fmt: skip


def _exposed(film: Film, motion: _Motion, wall: Any, time: float) -> Any:
    """What the sensor receives about an instant, shape (row, column, 3)."""
    half = 0.5 * film.exposure / film.rate
    ends = motion.at(time + half * np.array([-1.0, 0.0, 1.0]))[2]
    smear = float(np.hypot(*np.diff(ends, axis=1).transpose(2, 0, 1)).sum(axis=1).max())
    offsets, moments = _rays(smear)
    times = time + 2.0 * half * moments
    _, pivots, balls = motion.at(times)
    hands = None
    if film.held > 0.0:
        # Below and to the right of the first ball; it leaves to the right.
        gone = HAND_SPEED * np.maximum(times - film.held, 0.0)
        grip = motion.at(np.zeros(1))[2][0, 0] + MARGIN + [1.9 * film.radius, 0.5 * film.radius]
        hands = np.column_stack(
            [grip[0] + gone, grip[1] + 0.5 * gone, 0 * gone + 1.2 * film.radius]
        )
    frame = wall.copy()
    _layers(film, frame, wall, offsets, pivots + MARGIN, balls + MARGIN, True, hands, times)
    if film.pole is not None:
        left, right = (round(edge) + MARGIN for edge in film.pole)
        rounding = np.sqrt(1.0 - np.linspace(-0.95, 0.95, right - left) ** 2)
        frame[:, left:right] = (0.05 + 0.2 * rounding)[:, None] * np.array([0.5, 0.9, 0.6])
    return frame


def _developed(linear: Any, random: Any) -> Any:
    """A picture of 8 bits with vignetting, noise and the tone curve of BT.709."""
    height, width = linear.shape[:2]
    across, down = np.linspace(-1, 1, width) ** 2, np.linspace(-1, 1, height) ** 2
    signal = linear * (1.0 - 0.12 * (across + down[:, None]))[..., None]
    deviation = np.sqrt(np.maximum(signal, 0.0) / FULL_WELL + (READ_NOISE / FULL_WELL) ** 2)
    signal = signal + deviation * random.standard_normal(signal.shape, dtype=np.float32)
    signal = np.clip(signal, 0.0, 1.0)
    curve = np.where(signal < 0.018, 4.5 * signal, 1.099 * signal**0.45 - 0.099)
    return np.round(255.0 * curve).astype(np.uint8)


def shoot(film: Film, stem: Path, *, seed: int = 1) -> tuple[Path, Truth]:
    """Write a film to `stem` with the suffix of its codec; return the file and its truth."""
    suffix, layout, options = CODECS[film.codec]
    random = np.random.default_rng(seed)
    motion = _moving(film)
    # Which picture each frame shows, and the time from one picture to the next.
    shown, interval = np.arange(int(film.seconds * film.rate) - 1), 1.0 / film.rate
    if film.repeats:
        shown -= (shown + 1) // (film.repeats + 1)
        interval *= (film.repeats + 1) / film.repeats
    times = film.exposure / film.rate + interval * shown
    wall = _wall(film, random)
    pictures: list[Any] = []
    for k, time in enumerate(times):
        if k and shown[k] == shown[k - 1]:
            pictures.append(pictures[-1])
            continue
        jump = film.knock[1:] if film.knock and time >= film.knock[0] else (0, 0)
        left, top = MARGIN - jump[0], MARGIN - jump[1]
        frame = _exposed(film, motion, wall, time)
        seen = frame[top : top + film.size[1], left : left + film.size[0]]
        pictures.append(_developed(seen, random))
    stamps = [90_000 // film.rate * k for k in range(len(pictures))]
    path = stem.with_suffix(suffix)
    encoded(path, pictures, stamps, film.codec, film.rate, layout, **options)
    angles, pivots, places = motion.at(times)
    lengths = {system.length for system in film.systems}
    length = lengths.pop() if len(lengths) == 1 else None
    order = np.argsort(-places[:, 0, 0])
    radius = length and length * film.radius / film.arm
    return path, Truth(angles[order], pivots, places[order], length, radius)


def _single(length: float = 0.363) -> Any:
    return ll.Pendulum(length=length, mass=0.108, damping=0.00274)


_TOY = ll.LatoLato(length=0.245, mass=0.1064, damping=0.005, radius=0.02, restitution=0.9)


def _two(ratio: float = 2.3, drive_amplitude: float = 0.03, *, arm: float, **other: Any) -> Film:
    """A driven toy of two balls that meet."""
    drive = ll.Harmonic(
        drive_amplitude=drive_amplitude, drive_frequency=ratio * _TOY.natural_frequency
    )
    settings = {"starts": [{"initial_angle": 0.9}], "centre": (320.0, 150.0), **other}
    return Film(
        systems=[_TOY], drive=drive, arm=arm, radius=arm * _TOY.radius / _TOY.length, **settings
    )


def _sideways(amplitude: float) -> Any:
    """A drive that moves the pivot of a single pendulum to the side."""
    return ll.PlanarHarmonic(
        horizontal_amplitude=amplitude, vertical_amplitude=0.0,
        drive_frequency=0.6 * _single().natural_frequency,
    )  # fmt: skip


def _one(*, is_driven: bool = True, **other: Any) -> Film:
    """One ball, driven or free."""
    system = _single()
    drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=1.95 * system.natural_frequency)
    settings = {
        "drive": drive if is_driven else None, "starts": [{"initial_angle": 0.6}], "arm": 240.0,
        "radius": 16.0, "centre": (320.0, 110.0), **other,
    }  # fmt: skip
    return Film(systems=[system], **settings)


_HD = {"size": (1280, 720), "rate": 30}
_CAST = (14.0, 10.0, 9.0)

films: dict[str, Film] = {
    "plain": _one(codec="mjpeg", is_flat=True),
    "texture two": _two(arm=210.0, mottle=0.14, shadow=_CAST),
    "spin": _one(spin=9.0, codec="mjpeg", shadow=_CAST),
    "blur two": _two(
        arm=330.0, centre=(640.0, 220.0), **_HD, exposure=0.9, shadow=_CAST, codec="libx265"
    ),
    "occluded": _one(pole=(350.0, 374.0), mottle=0.06, codec="libx265"),
    "clutter two": _two(
        arm=210.0, clutter=[(90.0, 60.0), (560.0, 400.0), (120.0, 420.0)], shadow=_CAST
    ),
    "free": _one(
        is_driven=False, arm=420.0, radius=30.0, centre=(640.0, 140.0), **_HD, mottle=0.08,
        shadow=(30.0, 16.0, 14.0), colour=BLUE, codec="libx265", seconds=4.0,
    ),
    "top two": _two(
        2.6, 0.045, arm=160.0, centre=(320.0, 240.0), codec="mjpeg",
        starts=[{"initial_angle": 0.5, "initial_angular_velocity": 12.0}],
    ),
    "dot": _one(
        is_driven=False, **_HD, arm=330.0, radius=2.0, centre=(640.0, 160.0), exposure=0.9,
        starts=[{"initial_angle": 0.65}], colour=(0.9, 0.9, 0.85), wall=(0.0004, 0.0004, 0.0005),
        rod_width=0.0, pivot_size=5.0, pivot_colour=(0.12, 0.005, 0.005), seconds=4.0,
    ),
    "arms": Film(
        systems=[_single(0.4), _single(0.24)],
        starts=[{"initial_angle": 0.6}, {"initial_angle": -0.7}],
        arm=300.0, radius=16.0, centre=(320.0, 90.0), rate=30, exposure=0.4, mottle=0.06,
        codec="libvpx-vp9", seconds=4.0,
    ),
    "repeated": _one(rate=30, repeats=4, exposure=0.4, mottle=0.05, seconds=4.0),
    "held": _one(
        is_driven=False, starts=[{"initial_angle": 0.7}], rate=30, exposure=0.4, held=1.0,
        mottle=0.05, seconds=4.0, codec="libvpx-vp9",
    ),
    "knocked": _one(knock=(1.5, 5, -3), mottle=0.12, shadow=_CAST),
    "askew": _one(slant=0.6, mottle=0.06, codec="libvpx-vp9"),
    "swaying": _one(drive=_sideways(0.02), starts=[{"initial_angle": 0.3}], mottle=0.05),
    "colours two": _two(arm=210.0, other_colour=BLUE, mottle=0.06, shadow=_CAST),
    "tilted two": _two(arm=210.0, roll=0.1, mottle=0.08, shadow=_CAST, codec="libvpx-vp9"),
}  # fmt: skip
