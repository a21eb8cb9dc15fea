"""Named filming conditions that tests, reports and the command line share: `conditions`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from latolato.core.registry import Registry
from latolato.experiment.synthetic.scene import Camera, Scene


@dataclass(frozen=True, kw_only=True)
class Condition:
    """How a synthetic video differs from a clean one.

    Parameters
    ----------
    description : str
        In words.
    scene, camera : mapping
        Values of `Scene` and `Camera` that differ from their defaults.
    """

    description: str
    scene: Mapping[str, Any] = field(default_factory=dict)
    camera: Mapping[str, Any] = field(default_factory=dict)

    def make(
        self, scene: Mapping[str, Any] | None = None, camera: Mapping[str, Any] | None = None
    ) -> tuple[Scene, Camera]:
        """Return scene and camera, with further values overriding the condition's.

        Examples
        --------
        >>> scene, camera = conditions["blur"].make(camera={"fps": 25.0})
        >>> camera.fps, camera.exposure
        (25.0, 0.9)
        """
        return (
            replace(Scene(), **{**self.scene, **(scene or {})}),
            replace(Camera(), **{**self.camera, **(camera or {})}),
        )


conditions: Registry[Condition] = Registry("condition")


def _add(name: str, description: str, **changes: Mapping[str, Any]) -> None:
    conditions.register(name)(Condition(description=description, **changes))


_SHADOW = {"shadow_darkness": 0.4}
_add("clean", "plain wall, good light, 60 frames a second")
_add("texture", "mottled wall with a shadow on it", scene={"background": "texture", **_SHADOW})
_add(
    "wood",
    "wooden planks with a shadow on them, a band around the ball",
    scene={"background": "wood", "wall_colour": "#b98a5a", "pattern": 0.25, **_SHADOW},
)
_add("variable", "frame times that scatter, missing frames", camera={"jitter": 0.15, "drop": 0.06})
_add(
    "rotated",
    "stored lying on its side, with the turn as metadata",
    camera={"width": 960, "height": 1280, "rotation": 90},
)
_add("tilted", "camera turned by 7 degrees", camera={"roll": 0.122})
_add(
    "blur",
    "30 frames a second, exposed for 0.9 of the time",
    camera={"fps": 30.0, "exposure": 0.9},
)
_add(
    "lowlight",
    "little light, much noise, long exposure",
    camera={"brightness": 0.22, "electrons": 350.0, "read_noise": 5.0, "exposure": 0.5, "crf": 23},
)
_add(
    "compressed",
    "640 x 480, compressed strongly",
    camera={"width": 640, "height": 480, "crf": 34},
)
_add(
    "steel",
    "mirroring steel balls before a grey wall",
    scene={
        "ball_colour": "#c9ccd1",
        "metal": 0.85,
        "gloss": 0.7,
        "background": "gradient",
        "wall_colour": "#8f9296",
        "shadow_darkness": 0.3,
    },
)
_add(
    "occluded",
    "a post in front, and a hand that passes",
    scene={"post_width": 0.03, "hand_radius": 0.03},
)
_add("rolling", "rolling shutter: 14 ms from the first row to the last", camera={"row_time": 15e-6})
_add("lens", "barrel distortion", camera={"k1": -0.08, "k2": 0.01})
