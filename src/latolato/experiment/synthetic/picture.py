"""Pictures of a pendulum as a camera sees it: a background made once, and what moves in front."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError
from latolato.experiment.calibration.lens import distorted, undistorted
from latolato.experiment.opencv import import_cv2
from latolato.experiment.synthetic.render import BOLT, Floats, Image, Look, develop, paint
from latolato.experiment.synthetic.scene import Camera, Scene, linear_colour

# Normal numbers that all frames' noise is read from, at random places.
_NOISE_SIZE = 1 << 22
_CODES = 1 << 14
# A place whose undistorted one is not found to this is not shown by the lens [pixels].
_FOLDED = 1e-3

# Colours of band, rods, block, bolt, rail, post and hand (sRGB); where light comes from; and the
# shift of shadows to the right and upwards, and the width of their edges [m].
_BAND, _ROD, _BLOCK, _BOLT = "#f4f1e8", "#4a4d52", "#8d939c", "#1c1e22"
_RAIL, _POST, _SKIN = "#c3c7cc", "#3b6b4c", "#c98d6b"
_LIGHT, _SHADOW, _SOFT = (-0.45, 0.6), (0.03, -0.03), 0.008
# Length of the hand's arm and how far the fingers reach from the palm's middle, in its radii, and
# how far down it passes, over the length.
_ARM, _FINGERS, _DEPTH = 60.0, 2.3, 0.8

# First column and row of a part of the picture, and those after its last.
Box = tuple[int, int, int, int]


class Projection:
    """Where points of the scene appear in the picture.

    Parameters
    ----------
    camera : Camera
        Its scale and pivot must be given.
    """

    def __init__(self, camera: Camera) -> None:
        self.camera = camera
        self.scale = camera.pixels_per_metre
        self.cosine, self.sine = math.cos(camera.roll), math.sin(camera.roll)
        # The clicked pivot is a point of the picture as shown.
        u, v = self.straightened(np.array(camera.pivot_u), np.array(camera.pivot_v))
        self.origin = (float(u), float(v))

    def flat(self, x: Any, y: Any) -> tuple[Floats, Floats]:
        """Return u, v [pixel] of points [m] in the picture of a lens without distortion."""
        x = x * math.cos(self.camera.yaw)
        u = self.origin[0] + self.scale * (self.cosine * x - self.sine * y)
        v = self.origin[1] - self.scale * (self.sine * x + self.cosine * y)
        return np.asarray(u), np.asarray(v)

    def in_picture(self, x: Any, y: Any) -> tuple[Floats, Floats]:
        """Return u, v [pixel] of points [m] in the picture."""
        return self.distorted(*self.flat(x, y))

    def distorted(self, u: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Columns and rows at which a lens shows undistorted points of the picture [pixels]."""
        camera = self.camera
        shown = distorted(np.stack([u, v], axis=-1), (camera.width, camera.height), camera.optics)
        return shown[..., 0], shown[..., 1]

    def straightened(self, u: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Return the undistorted places of points of the picture."""
        camera, shown = self.camera, np.stack([u, v], axis=-1)
        true = undistorted(shown, (camera.width, camera.height), camera.optics)
        if not np.allclose(self.distorted(true[..., 0], true[..., 1]), (u, v), atol=_FOLDED):
            raise InputError(
                "k1, k2 must not fold the picture over itself",
                value=(camera.k1, camera.k2),
                way_out="give smaller ones or a longer focal_length",
            )
        return true[..., 0], true[..., 1]


class Renderer:
    """Makes the frames of one video.

    Its `background` is what does not move, in linear light, shape (height, width, 3).

    Parameters
    ----------
    scene, camera : Scene, Camera
        The camera with its scale and pivot.
    radii : tuple of float
        Radius of each ball [m].
    heights : tuple of float
        Lowest and highest place of the pivot [m].
    length : float
        Length of the longer pendulum [m].
    seed : int
        Of texture and noise.
    """

    def __init__(
        self,
        scene: Scene,
        camera: Camera,
        *,
        radii: tuple[float, ...],
        heights: tuple[float, float],
        length: float,
        seed: int,
    ) -> None:
        self.scene, self.camera, self.seed = scene, camera, seed
        self.radii, self.length = radii, length
        self.projection = Projection(camera)
        random = np.random.default_rng([seed, 0])
        shape = (camera.height, camera.width)
        self._maps = self._pixel_maps()
        self.look, self.colours = _look(scene, self.projection, radii), _colours(scene)
        wall = make_wall(scene, shape, random)
        self._draw_rail(wall, heights)
        if scene.is_parked:
            self._draw_parked(wall)
        self._wall = wall
        self._pad = math.ceil(3.5 * camera.blur)
        self.background = self._blurred(self._covered(wall, 0, 0, None))
        self._noise = random.standard_normal(_NOISE_SIZE, dtype=np.float32)
        self._gain = _gain(camera)
        self._tones = _tones()

    def frame(self, number: int, states: Floats, hand_x: float | None) -> NDArray[np.uint8]:
        """Return the YUV 4:2:0 planes of a frame, shape (3 height/2, width), as stored.

        Parameters
        ----------
        number : int
            Of the frame; fixes its noise.
        states : ndarray, shape (moment, line, point, 2)
            Undistorted u, v of pivot and balls [pixel].
        hand_x : float or None
            Where the hand is [m].
        """
        light = self.picture(states, hand_x)
        camera = self.camera
        height, width = camera.height, camera.width
        random = np.random.default_rng([self.seed, 1, number])
        offsets = random.integers(0, _NOISE_SIZE - 3 * width, height)
        luma = np.empty((height, width), np.uint8)
        chroma = np.empty((2, height // 2, width // 2), np.uint8)
        shot = 1.0 / camera.electrons
        read = (camera.read_noise / camera.electrons) ** 2
        develop(light, self._gain, self._noise, offsets, shot, read, self._tones, luma, chroma)
        turns = camera.rotation // 90
        planes = [np.rot90(plane, turns) for plane in (luma, *chroma)]
        stored = np.concatenate([np.ascontiguousarray(plane).ravel() for plane in planes])
        return stored.reshape(-1, planes[0].shape[1])

    def picture(self, states: Floats, hand_x: float | None = None) -> Image:
        """Return the picture in linear light, shape (height, width, 3), without noise."""
        u0, v0, u1, v1 = self._box(states, hand_x)
        wall: Any = self._wall[v0:v1, u0:u1]
        total = np.zeros(wall.shape, np.float32)
        camera, pad = self.camera, self._pad
        if camera.rotation in (90, 180):  # stored lines from the picture's other end
            states = np.ascontiguousarray(states[:, ::-1])
        axis = 1 if camera.rotation in (90, 270) else 0
        paint(total, (u0, v0), wall, states, axis, self._maps, self.look, self.colours)
        total /= np.float32(states.shape[0])
        part = self._blurred(self._covered(wall + total, u0, v0, hand_x))
        # Blurring has continued the part's edges, where the background goes on.
        left, top = pad if u0 > 0 else 0, pad if v0 > 0 else 0
        right, bottom = pad if u1 < camera.width else 0, pad if v1 < camera.height else 0
        whole = self.background.copy()
        whole[v0 + top : v1 - bottom, u0 + left : u1 - right] = part[
            top : len(part) - bottom, left : part.shape[1] - right
        ]
        return whole

    def covered(self, u: float, v: float, ball: int, hand_x: float | None) -> float:
        """Return the part of a ball's disc that post and hand hide; u, v undistorted."""
        radius = self.radii[ball] * self.projection.scale
        grid = np.linspace(-1.0, 1.0, 25)
        du, dv = np.meshgrid(grid, grid)
        inside = du * du + dv * dv <= 1.0
        hidden = np.zeros(int(inside.sum()))
        for front in self._fronts(hand_x):
            alpha, _ = front(u + radius * du[inside], v + radius * dv[inside])
            hidden = np.maximum(hidden, alpha)
        return float(hidden.mean())

    def _box(self, states: Floats, hand_x: float | None) -> Box:
        """Return the part of the picture that differs from the background."""
        look = self.look
        low, high = states.min(axis=(0, 1, 2)), states.max(axis=(0, 1, 2))
        margin = max(*look.radii, look.rod, look.bolt)
        margin = max(margin, math.hypot(look.block_u, look.block_v)) + 2.0
        low, high = low - margin, high + margin
        if look.shadow > 0.0:
            shift = np.array([look.shadow_u, look.shadow_v])
            soft = 0.5 * look.softness
            low = np.minimum(low, low + shift - soft)
            high = np.maximum(high, high + shift + soft)
        if hand_x is not None:
            corners = self._hand_corners(hand_x)
            low, high = np.minimum(low, corners.min(axis=0)), np.maximum(high, corners.max(axis=0))
        return self._box_of(low, high)

    def _box_of(self, low: Floats, high: Floats) -> Box:
        """Return the part of the picture of undistorted places, with what its blur reaches."""
        camera, projection = self.camera, self.projection
        if camera.has_lens:
            # Places beyond those of the picture's edges may be folded back into it.
            first, last = np.array([(each.min(), each.max()) for each in self._maps]).T
            low, high = np.clip(low, first, last), np.clip(high, first, last)
            edge = np.linspace(0.0, 1.0, 33)
            us, vs = np.meshgrid(
                low[0] + edge * (high[0] - low[0]), low[1] + edge * (high[1] - low[1])
            )
            us, vs = projection.distorted(us, vs)
            low = np.array([us.min() - 2.0, vs.min() - 2.0])
            high = np.array([us.max() + 2.0, vs.max() + 2.0])
        grow = 2 * self._pad + 1
        size_uv = np.array([camera.width, camera.height])
        first = np.clip(np.floor(low).astype(int) - grow, 0, size_uv - 2)
        last = np.clip(np.ceil(high).astype(int) + grow + 1, first + 2, size_uv)
        return int(first[0]), int(first[1]), int(last[0]), int(last[1])

    def _pixel_maps(self) -> tuple[Image, Image]:
        """Return the undistorted place of every pixel, or nothing without a lens."""
        if not self.camera.has_lens:
            return np.zeros((0, 0), np.float32), np.zeros((0, 0), np.float32)
        v, u = np.mgrid[0 : self.camera.height, 0 : self.camera.width].astype(np.float64)
        u, v = self.projection.straightened(u, v)
        return u.astype(np.float32), v.astype(np.float32)

    def _places(self, shape: tuple[int, int], u0: int, v0: int) -> tuple[Any, Any]:
        """Return the undistorted place of every pixel of a part."""
        rows, columns = slice(v0, v0 + shape[0]), slice(u0, u0 + shape[1])
        if self.camera.has_lens:
            return self._maps[0][rows, columns], self._maps[1][rows, columns]
        u = np.arange(columns.start, columns.stop, dtype=np.float32)[None, :]
        v = np.arange(rows.start, rows.stop, dtype=np.float32)[:, None]
        return u, v

    def _scene_places(self, u: Any, v: Any) -> tuple[Any, Any]:
        """Return x, y [pixel, from the mean pivot, y up] of undistorted points."""
        projection = self.projection
        du, dv = u - projection.origin[0], v - projection.origin[1]
        return (
            projection.cosine * du - projection.sine * dv,
            -projection.sine * du - projection.cosine * dv,
        )

    def _draw_rail(self, wall: Image, heights: tuple[float, float]) -> None:
        """Draw the rail that guides the block."""
        scene, scale = self.scene, self.projection.scale
        if scene.rail_width <= 0.0:
            return
        x, y = self._scene_places(*self._places(wall.shape[:2], 0, 0))
        half = 0.5 * scene.rail_width * scale
        low = scale * (heights[0] - scene.block_height)
        part = np.clip(0.5 + half - np.abs(x), 0.0, 1.0) * np.clip(0.5 + y - low, 0.0, 1.0)
        shade = 1.0 - 0.3 * np.clip(np.abs(x) / half, 0.0, 1.0) ** 2
        colour = np.array(linear_colour("rail_colour", _RAIL), np.float32)
        part = part.astype(np.float32)[..., None]
        wall += part * (shade.astype(np.float32)[..., None] * colour - wall)

    def _draw_parked(self, wall: Image) -> None:
        """Draw the parked ball with its shadow, resting on nothing that moves."""
        u, v = self.projection.flat(self.scene.parked_x, self.scene.parked_y)
        states = np.array([[[(float(u), float(v))] * 2]])
        look = self.look._replace(rod=0.0, block_u=0.0, block_v=0.0, bolt=0.0)
        total = np.zeros_like(wall)
        paint(total, (0, 0), wall, states, 0, self._maps, look, self.colours)
        wall += total

    def _post(self, u: Any, v: Any) -> tuple[Any, Any]:
        """Return how much the post hides at undistorted points, and its linear colour (..., 3)."""
        scene, scale = self.scene, self.projection.scale
        x = self._scene_places(u, v)[0] - scene.post_x * scale
        half = 0.5 * scene.post_width * scale
        round_ = np.sqrt(np.clip(1.0 - ((x + 0.3 * half) / (1.4 * half)) ** 2, 0.0, 1.0))
        colour = np.array(linear_colour("post_colour", _POST), np.float32)
        return np.clip(0.5 + half - np.abs(x), 0.0, 1.0), (0.55 + 0.45 * round_)[..., None] * colour

    def _hand(self, u: Any, v: Any, hand_x: float) -> tuple[Any, Any]:
        """Return how much the hand hides at undistorted points, and its linear colour (..., 3).

        It is a palm with four fingers and an arm.
        """
        scale = self.projection.scale
        size = self.scene.hand_radius * scale
        x, y = self._scene_places(u, v)
        x, y = (x - hand_x * scale) / size, (y + _DEPTH * self.length * scale) / size
        gap = np.hypot(x, y) - 1.0
        for lean, reach in ((-0.55, 1.7), (-0.18, 2.0), (0.18, 1.95), (0.6, 1.6)):
            gap = np.minimum(gap, _capsule(x, y, (0.6 * lean, 0.3), (lean, reach), 0.22))
        gap = size * np.minimum(gap, _capsule(x, y, (0.0, 0.0), (0.0, -_ARM), 0.62))
        shade = 0.6 + 0.4 * np.clip(-gap / (0.5 * size), 0.0, 1.0)
        colour = np.array(linear_colour("hand_colour", _SKIN), np.float32)
        return np.clip(0.5 - gap, 0.0, 1.0), shade[..., None] * colour

    def _hand_corners(self, hand_x: float) -> Floats:
        """Return undistorted u, v of corners that hold hand and arm [pixel], shape (4, 2)."""
        size, middle = self.scene.hand_radius, -_DEPTH * self.length
        x, y = np.meshgrid(
            (hand_x - size, hand_x + size), (middle - (_ARM + 1.0) * size, middle + _FINGERS * size)
        )
        return np.stack(self.projection.flat(x.ravel(), y.ravel()), axis=-1)

    def _fronts(self, hand_x: float | None) -> list[Any]:
        """Return what is in front of the balls: how much each hides at places, and its colour."""
        fronts: list[Any] = [self._post] if self.scene.post_width > 0.0 else []
        if hand_x is not None:
            fronts.append(partial(self._hand, hand_x=hand_x))
        return fronts

    def _covered(self, part: Image, u0: int, v0: int, hand_x: float | None) -> Image:
        """Return a part of the picture with post and hand in front."""
        for front in self._fronts(hand_x):
            alpha, colour = front(*self._places(part.shape[:2], u0, v0))
            part = np.asarray(part + alpha[..., None] * (colour - part), np.float32)
        return part

    def _blurred(self, image: Image) -> Image:
        """Return an image blurred by the optics; its edges are continued."""
        if self._pad == 0:
            return image
        cv2, size = import_cv2(), 2 * self._pad + 1
        edge = {"sigmaX": self.camera.blur, "borderType": cv2.BORDER_REPLICATE}
        return np.asarray(cv2.GaussianBlur(image, (size, size), **edge))


def _capsule(x: Any, y: Any, start: tuple[float, float], end: tuple[float, float], r: float) -> Any:
    """Return the signed distance from a thick line."""
    du, dv = end[0] - start[0], end[1] - start[1]
    along = ((x - start[0]) * du + (y - start[1]) * dv) / (du * du + dv * dv)
    along = np.clip(along, 0.0, 1.0)
    return np.hypot(x - start[0] - along * du, y - start[1] - along * dv) - r


def _look(scene: Scene, projection: Projection, radii: tuple[float, ...]) -> Look:
    """Return sizes in pixels and the light."""
    scale = projection.scale
    # Light and shadow are directions of the scene, which the camera sees turned.
    turn = np.array([[projection.cosine, -projection.sine], [-projection.sine, -projection.cosine]])
    light = turn @ np.array(_LIGHT)
    shadow = scale * turn @ np.array(_SHADOW)
    return Look(
        radii=(scale * radii[0], scale * radii[-1]),
        rod=0.5 * scale * scene.rod_width,
        block_u=0.5 * scale * scene.block_width,
        block_v=0.5 * scale * scene.block_height,
        bolt=scale * scene.bolt_radius,
        cosine=projection.cosine,
        sine=projection.sine,
        light_u=float(light[0]),
        light_v=float(light[1]),
        light_w=math.sqrt(max(1.0 - float(light @ light), 0.0)),
        ambient=scene.ambient,
        gloss=scene.gloss,
        metal=scene.metal,
        pattern=scene.pattern,
        shadow=scene.shadow_darkness,
        shadow_u=float(shadow[0]),
        shadow_v=float(shadow[1]),
        softness=max(scale * _SOFT, 1.0),
    )


def _colours(scene: Scene) -> Floats:
    """Return the linear colours in the order of `latolato.experiment.synthetic.render`."""
    texts = [scene.ball_colour, scene.ball_colour, _BAND, _ROD, _BLOCK, _BOLT]
    assert len(texts) == BOLT + 1
    return np.array([linear_colour("ball_colour", text) for text in texts])


def _gain(camera: Camera) -> Image:
    """Return the light that reaches each pixel: less in the corners (cos^4 law, first order)."""
    v, u = np.mgrid[-1.0 : 1.0 : camera.height * 1j, -1.0 : 1.0 : camera.width * 1j]
    loss = camera.vignetting * 0.5 * (u * u + v * v)
    return np.asarray(camera.brightness * (1.0 - loss), np.float32)


def _tones() -> Image:
    """Return the sRGB code value in [0, 1] of linear light, evenly sampled (IEC 61966-2-1)."""
    x = np.linspace(0.0, 1.0, _CODES)
    codes = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1.0 / 2.4) - 0.055)
    return np.asarray(codes, np.float32)


def make_wall(scene: Scene, shape: tuple[int, int], random: np.random.Generator) -> Image:
    """Return the background in linear light, shape (height, width, 3)."""
    base = np.array(linear_colour("wall_colour", scene.wall_colour), np.float32)
    wall = np.broadcast_to(base, (*shape, 3)).astype(np.float32)
    if scene.background == "plain" or scene.contrast == 0.0:
        return wall
    v, u = np.mgrid[0.0 : 1.0 : shape[0] * 1j, 0.0 : 1.0 : shape[1] * 1j]
    if scene.background == "gradient":
        light = 1.0 + scene.contrast * (0.6 * (0.5 - u) + 0.8 * (0.5 - v))
        tint = np.array([1.05, 1.0, 0.93], np.float32) ** np.float32(scene.contrast)
        return np.asarray(wall * light[..., None] * tint, np.float32)
    if scene.background == "texture":
        strength = 0.22
        sizes = (240.0, 90.0, 30.0, 10.0, 4.0)
        light = sum(_clouds(shape, (s, s), random) * 0.85**i for i, s in enumerate(sizes))
        tint = _clouds(shape, (150.0, 150.0), random)
    else:
        strength = 0.42
        plank = 140.0
        grain = _clouds(shape, (4.0, 300.0), random) + 0.6 * _clouds(shape, (12.0, 500.0), random)
        warp = 8.0 * _clouds(shape, (60.0, 260.0), random)
        ring = np.sin((v * shape[0] + warp * 3.0) / 5.5 + 2.0 * grain)
        row = np.floor(v * shape[0] / plank).astype(int)
        tone = random.normal(0.0, 0.8, row.max() + 1)[row]
        gap = np.abs(v * shape[0] / plank % 1.0 * plank - 1.0) < 1.5
        light = 0.5 * grain + 0.35 * ring + 0.6 * tone - 2.5 * gap
        tint = 0.8 + 0.5 * tone
    factor = np.exp(strength * scene.contrast * light)[..., None]
    warmth = np.array([0.2, 0.0, -0.3]) * strength * scene.contrast * tint[..., None]
    return np.asarray(np.clip(wall * factor * np.exp(warmth), 0.0, 1.0), np.float32)


def _clouds(
    shape: tuple[int, int], size: tuple[float, float], random: np.random.Generator
) -> Floats:
    """Return smooth noise of unit variance with structures of a size [pixel], v and u."""
    from scipy.interpolate import BSpline

    noise = random.standard_normal([math.ceil(n / s) + 4 for n, s in zip(shape, size, strict=True)])
    for axis, (n, s) in enumerate(zip(shape, size, strict=True)):
        # Uniform cubic B-splines, the one of index i centred at i.
        knots = np.arange(noise.shape[axis] + 4) - 2.0
        places = 1.0 + np.arange(n) / s + random.uniform()
        splines = BSpline.design_matrix(places, knots, 3)
        noise = np.moveaxis(splines @ np.moveaxis(noise, axis, 0), 0, axis)
    return np.asarray(noise / noise.std())
