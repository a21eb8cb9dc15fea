"""What a user can declare about a video: options of `latolato track`, fields of a page."""

from __future__ import annotations

from latolato.core.parameters import Parameter
from latolato.core.quantities import ANY, NON_NEGATIVE, POSITIVE, QUANTITIES, Quantity, Range


def _of_camera(
    name: str, label: str, description: str, *, unit: str = "1", allowed: Range = ANY,
    default: float | None = 0.0,
) -> Parameter:  # fmt: skip
    return Parameter(
        name=name, owner="camera", kind=float, description=description,
        quantity=Quantity(unit, "", label), allowed=allowed, default=default,
    )  # fmt: skip


def _of_toy(name: str, description: str) -> Parameter:
    return Parameter(
        name=name, kind=float, description=description, quantity=QUANTITIES[name], allowed=POSITIVE
    )


CLIP = (
    Parameter(
        name="start", owner="clip", kind=float, description="first instant to use",
        quantity=Quantity("s", "", "first instant to use"),
    ),
    Parameter(
        name="end", owner="clip", kind=float, description="last instant to use",
        quantity=Quantity("s", "", "last instant to use"),
    ),
    Parameter(
        name="click_frame", owner="clip", kind=int, allowed=NON_NEGATIVE,
        description="number of the frame in which you point at pivot and balls, counted from "
        "0 at the start of the file; by default the first frame used",
        quantity=Quantity("", "", "frame in which you point at pivot and balls"),
    ),
)  # fmt: skip
SHAPES = ("disc", "template")
LOOK = (
    Parameter(
        name="shape", owner="look", kind=str, choices=SHAPES, default=SHAPES[0],
        description="how balls are recognised: as a disc, or by a template of the clicked bob",
        quantity=Quantity("", "", "shape"),
    ),
    Parameter(
        name="patch", owner="look", kind=float, allowed=Range(8.0, 1000.0),
        description="side of the template, a square around the click, in pixels; "
        "by default from the radius, or 0.3 of the distance from pivot to click",
        quantity=Quantity("1", "", "side of the template in pixels"),
    ),
)  # fmt: skip
CAMERA = (
    _of_camera(
        "slow_motion", "slow-motion factor",
        "slow-motion factor; by default from the file", allowed=POSITIVE,
        default=None,
    ),
    _of_camera(
        "row_time", "time between rows of a rolling shutter",
        "time between rows of a rolling shutter", unit="s",
    ),
    _of_camera(
        "lens_k1", "radial lens coefficient k1",
        "radial distortion, in units of half the diagonal",
    ),
    _of_camera("lens_k2", "radial lens coefficient k2", "radial distortion of the next order"),
)  # fmt: skip
VIDEO_PARAMETERS = {
    parameter.name: parameter
    for parameter in (
        _of_toy("length", "from pivot to ball centre; sets the scale"),
        _of_toy("radius", "radius of a ball; checked against the scale, or sets it if alone"),
        Parameter(
            name="stick_length",
            kind=float,
            description="length of the stick",
            allowed=POSITIVE,
            quantity=Quantity("m", "", "length of the stick"),
        ),
        _of_toy("gravity", "gravitational acceleration; 9.8 by default"),
        *CLIP,
        *LOOK,
        *CAMERA,
    )
}
