"""What a user can say about a video: options of `latolato track`, fields of a page."""

from __future__ import annotations

from latolato.core.parameters import Parameter
from latolato.core.quantities import ANY, POSITIVE, QUANTITIES, Quantity, Range


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


CAMERA = (
    _of_camera(
        "slow_motion", "slow motion: how many times slower than life it plays",
        "how many times slower than life it plays, by default as the file says", allowed=POSITIVE,
        default=None,
    ),
    _of_camera(
        "row_time", "time from row to row of a rolling shutter",
        "time between rows of a rolling shutter", unit="s",
    ),
    _of_camera(
        "lens_k1", "radial lens coefficient k1",
        "radial distortion, in units of half the diagonal",
    ),
    _of_camera("lens_k2", "radial lens coefficient k2", "its next order"),
)  # fmt: skip
VIDEO_PARAMETERS = {
    parameter.name: parameter
    for parameter in (
        _of_toy("length", "from pivot to ball centre: the scale"),
        _of_toy("radius", "radius of a ball, checked against the length"),
        _of_toy("gravity", "9.8 by default"),
        *CAMERA,
    )
}
