"""What a synthetic video shows and how it is filmed: options with units and ranges."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from latolato.core.errors import InputError
from latolato.core.quantities import COUNT, NON_NEGATIVE, POSITIVE, UNIT_INTERVAL, Quantity, Range
from latolato.core.registry import check_fields, checked_choice, checked_count
from latolato.experiment.calibration.lens import Optics

BACKGROUNDS = ("plain", "gradient", "texture", "wood")
ROTATIONS = (0, 90, 180, 270)
# H.264 takes even sizes only; larger pictures than this are refused.
SIZES = (64, 4096)


def _number(
    default: float, unit: str, description: str, allowed: Range = NON_NEGATIVE, **options: Any
) -> Any:
    """Return a field that holds one number with its unit and range."""
    quantity = Quantity(unit, "", description)
    metadata = {"quantity": quantity, "range": allowed, "description": description}
    return field(default=default, metadata=metadata, **options)


def _text(default: str, description: str, choices: tuple[str, ...] = ()) -> Any:
    """Return a field that holds a word or a colour ``#rrggbb`` (sRGB)."""
    return field(default=default, metadata={"description": description, "choices": choices})


@dataclass(frozen=True, kw_only=True)
class Scene:
    """What is in front of the camera; lengths in m, positions from the mean pivot, y up.

    A length of 0 omits that part of the mechanism.
    """

    ball_colour: str = _text("#e8590c", "colour of the balls")
    ball_radius: float = _number(0.0, "m", "radius of a ball if the run has none; 0: l/15")
    centre_length: float = _number(0.0, "m", "pivot to the ball's centre; 0: the length of the run")
    ambient: float = _number(0.35, "1", "ambient light; 1 draws flat discs", UNIT_INTERVAL)
    gloss: float = _number(0.25, "1", "strength of the highlight", UNIT_INTERVAL)
    metal: float = _number(0.0, "1", "1 for a ball that reflects its surroundings", UNIT_INTERVAL)
    pattern: float = _number(0.0, "1", "width of a band around the ball, relative to its diameter",
                             Range(0.0, 1.0))  # fmt: skip
    rod_width: float = _number(0.004, "m", "width of rods; strings are about 0.001")
    block_width: float = _number(0.05, "m", "width of the block that carries the pivot")
    block_height: float = _number(0.03, "m", "height of the block")
    bolt_radius: float = _number(0.006, "m", "radius of the hinge bolt")
    rail_width: float = _number(0.018, "m", "width of the rail that guides the block")
    background: str = _text("plain", "what the wall looks like", BACKGROUNDS)
    wall_colour: str = _text("#d9d6ce", "colour of the wall")
    contrast: float = _number(0.5, "1", "strength of gradient, texture or wood", UNIT_INTERVAL)
    shadow_darkness: float = _number(0.0, "1", "light that the shadow removes", UNIT_INTERVAL)
    post_width: float = _number(0.0, "m", "width of a vertical post in front")
    post_x: float = _number(0.06, "m", "where the post stands", Range())
    hand_radius: float = _number(0.0, "m", "size of a hand that passes in front")
    hand_time: float = _number(3.0, "s", "when the hand is below the pivot")
    parked_x: float = _number(0.0, "m", "where a second ball is parked; with y = 0: none", Range())
    parked_y: float = _number(0.0, "m", "where a second ball is parked", Range())

    def __post_init__(self) -> None:
        check_fields(self)
        for name in ("ball_colour", "wall_colour"):
            linear_colour(name, getattr(self, name))
        checked_choice("background", self.background, BACKGROUNDS)

    @property
    def is_parked(self) -> bool:
        """Whether a second ball is parked aside."""
        return self.parked_x != 0.0 or self.parked_y != 0.0


@dataclass(frozen=True, kw_only=True)
class Camera:
    """How the scene is filmed; pixels count from the upper left corner of the picture shown.

    The time stamp of a frame is the middle of its first row's exposure. With a `row_time` row i of
    the stored picture is exposed ``i row_time`` later. A point at distance r from the picture's
    middle appears at ``r (1 + k1 q^2 + k2 q^4)``, q = r/`focal_length`.
    """

    width: int = field(default=1280, metadata={"description": "width as shown [pixel]"})
    height: int = field(default=960, metadata={"description": "height as shown [pixel]"})
    fps: float = _number(60.0, "1/s", "mean frame rate", Range(1.0, 1000.0))
    jitter: float = _number(0.0, "1", "scatter of time stamps, in frame times", Range(0.0, 0.3))
    drop: float = _number(0.0, "1", "fraction of frames that are missing", Range(0.0, 0.9))
    pixels_per_metre: float = _number(0.0, "1/m", "scale; 0: the motion fills the picture")
    pivot_u: float = _number(-1.0, "pixel", "mean pivot from the left; -1: fitted", Range())
    pivot_v: float = _number(-1.0, "pixel", "mean pivot from the top; -1: fitted", Range())
    roll: float = _number(0.0, "rad", "rotation of the scene in the picture, counter-clockwise",
                          Range(-3.2, 3.2))  # fmt: skip
    yaw: float = _number(0.0, "rad", "angle at which a distant camera looks at the swing's plane",
                         Range(-1.5, 1.5))  # fmt: skip
    rotation: int = field(
        default=0,
        metadata={
            "description": "rotation that a player applies, clockwise [deg]",
            "choices": ROTATIONS,
        },
    )
    row_time: float = _number(0.0, "s", "time between rows of a rolling shutter")
    k1: float = _number(0.0, "1", "radial lens coefficient", Range(-0.5, 0.5))
    k2: float = _number(0.0, "1", "second radial lens coefficient", Range(-0.5, 0.5))
    focal_length: float = _number(0.0, "pixel", "focal length; 0: half the diagonal")
    exposure: float = _number(0.25, "1", "share of the frame time that is exposed",
                              Range(0.0, 1.0, open_low=True))  # fmt: skip
    blur: float = _number(0.7, "pixel", "standard deviation of the optical blur", Range(0.0, 20.0))
    brightness: float = _number(1.0, "1", "light that reaches the sensor", Range(0.0, 4.0, True))
    electrons: float = _number(12000.0, "1", "electrons in a white pixel; few give shot noise",
                               POSITIVE)  # fmt: skip
    read_noise: float = _number(8.0, "1", "read noise [electrons]")
    vignetting: float = _number(0.08, "1", "light lost in the corners", UNIT_INTERVAL)
    crf: int = field(
        default=18, metadata={"description": "compression of H.264: 0 none, 51 strongest"}
    )

    def __post_init__(self) -> None:
        check_fields(self)
        low, high = SIZES
        for name, allowed in {"width": COUNT, "height": COUNT, "crf": Range(0, 51)}.items():
            object.__setattr__(self, name, checked_count(name, getattr(self, name), allowed))
        for name in ("width", "height"):
            size = getattr(self, name)
            if size % 2 or not low <= size <= high:
                raise InputError(
                    f"must be even and in [{low}, {high}] pixels", parameter=name, value=size
                )
        if self.rotation not in ROTATIONS:
            raise InputError(
                "must be one of 0, 90, 180, 270 deg", parameter="rotation", value=self.rotation
            )
        if self.row_time * self.rows * self.fps > 1.0:
            raise InputError(
                f"must let {self.rows} rows fit into a frame time of {1.0 / self.fps:g} s",
                parameter="row_time",
                value=self.row_time,
                way_out=f"give at most {1.0 / self.fps / self.rows:.3g} s",
            )

    @property
    def rows(self) -> int:
        """Rows of the stored picture."""
        return self.width if self.rotation in (90, 270) else self.height

    @property
    def optics(self) -> Optics:
        """What a user would declare about it to the tracker."""
        half_diagonal = 0.5 * math.hypot(self.width, self.height)
        wider = half_diagonal / (self.focal_length or half_diagonal)
        k1, k2 = self.k1 * wider**2, self.k2 * wider**4
        return Optics(row_time=self.row_time, lens_k1=k1, lens_k2=k2)

    @property
    def has_lens(self) -> bool:
        """Whether the lens distorts."""
        return self.k1 != 0.0 or self.k2 != 0.0


def linear_colour(name: str, text: str) -> tuple[float, float, float]:
    """Return the linear red, green and blue in [0, 1] of an sRGB colour ``#rrggbb``.

    Source: IEC 61966-2-1.

    Examples
    --------
    >>> linear_colour("ball_colour", "#ff0000")
    (1.0, 0.0, 0.0)
    """
    try:
        if len(text) != 7 or text[0] != "#":
            raise ValueError
        codes = [int(text[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
    except (TypeError, ValueError):
        raise InputError("must be a colour such as '#e8590c'", parameter=name, value=text) from None
    red, green, blue = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in codes)
    return red, green, blue
