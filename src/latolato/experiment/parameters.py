"""What a user can declare about a video: options of `latolato track`, fields of a page."""

from __future__ import annotations

from typing import Any

from latolato.core.parameters import Parameter
from latolato.core.quantities import NON_NEGATIVE, POSITIVE, QUANTITIES, Quantity, Range


def _parameter(
    name: str,
    owner: str,
    description: str,
    *,
    label: str = "",
    unit: str = "1",
    usual: float | None = None,
    **more: Any,
) -> Parameter:
    """Return a parameter of a quantity of its own; its label is its description by default."""
    quantity = Quantity(unit, "", label or description, usual=usual)
    options = {"kind": float, "owner": owner, "description": description, **more}
    return Parameter(name=name, quantity=quantity, **options)


def _of_toy(name: str, description: str) -> Parameter:
    return Parameter(
        name=name, kind=float, description=description, quantity=QUANTITIES[name], allowed=POSITIVE
    )


CLIP = (
    _parameter("start", "clip", "first instant to use", unit="s"),
    _parameter("end", "clip", "last instant to use", unit="s"),
    _parameter(
        "click_frame", "clip",
        "number of the frame in which you point at pivot and balls, counted from "
        "0 at the start of the file; by default the first frame used",
        label="frame in which you point at pivot and balls", unit="", kind=int,
        allowed=NON_NEGATIVE,
    ),
)  # fmt: skip
SHAPES = ("disc", "template")
LOOK = (
    _parameter(
        "shape", "look", "how balls are recognised: as a disc, or by a template of the clicked bob",
        label="shape", unit="", kind=str, choices=SHAPES, default=SHAPES[0],
    ),
    _parameter(
        "patch", "look",
        "side of the template, a square around the click, in pixels; "
        "by default from the radius, or 0.3 of the distance from pivot to click",
        label="side of the template in pixels", allowed=Range(8.0, 1000.0),
    ),
)  # fmt: skip
CAMERA = (
    _parameter(
        "slow_motion", "camera", "slow-motion factor; by default from the file",
        label="slow-motion factor", allowed=POSITIVE,
    ),
    _parameter(
        "row_time", "camera", "time between rows of a rolling shutter", unit="s", default=0.0,
        allowed=NON_NEGATIVE,
    ),
    _parameter(
        "lens_k1", "camera", "radial distortion, in units of half the diagonal",
        label="radial lens coefficient k1", default=0.0, allowed=Range(-1.0, 1.0),
    ),
    _parameter(
        "lens_k2", "camera", "radial distortion of the next order",
        label="radial lens coefficient k2", default=0.0, allowed=Range(-1.0, 1.0),
    ),
)  # fmt: skip
VIDEO_PARAMETERS = {
    parameter.name: parameter
    for parameter in (
        _of_toy("length", "from pivot to ball centre; sets the scale"),
        _of_toy("radius", "radius of a ball; checked against the scale, or sets it if alone"),
        _parameter(
            "stick_length", "", "length of the stick", unit="m", usual=0.3, allowed=POSITIVE
        ),
        _of_toy("gravity", "gravitational acceleration; 9.8 by default"),
        *CLIP,
        *LOOK,
        *CAMERA,
    )
}
