"""Filming conditions of synthetic videos that tests and benchmarks share: `conditions`."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from latolato.experiment.synthetic.scene import Camera, Scene


class Condition(NamedTuple):
    """Values of scene and camera that differ from a clean video's: plain wall, good light."""

    scene: Mapping[str, Any] = {}
    camera: Mapping[str, Any] = {}

    def make(
        self, scene: Mapping[str, Any] | None = None, camera: Mapping[str, Any] | None = None
    ) -> tuple[Scene, Camera]:
        """Scene and camera, with further values overriding the condition's."""
        return Scene(**{**self.scene, **(scene or {})}), Camera(**{**self.camera, **(camera or {})})


conditions = {
    "clean": Condition(),
    "texture": Condition(scene={"background": "texture", "shadow_darkness": 0.4}),
    "wood": Condition(
        scene={
            "background": "wood", "wall_colour": "#b98a5a", "pattern": 0.25, "shadow_darkness": 0.4,
        }
    ),
    "variable": Condition(camera={"jitter": 0.15, "drop": 0.06}),
    "rotated": Condition(camera={"width": 960, "height": 1280, "rotation": 90}),
    "tilted": Condition(camera={"roll": 0.122}),
    "blur": Condition(camera={"fps": 30.0, "exposure": 0.9}),
    "lowlight": Condition(
        camera={
            "brightness": 0.22, "electrons": 350.0, "read_noise": 5.0, "exposure": 0.5, "crf": 23,
        }
    ),
    "compressed": Condition(camera={"width": 640, "height": 480, "crf": 34}),
    "steel": Condition(
        scene={
            "ball_colour": "#c9ccd1", "metal": 0.85, "gloss": 0.7, "background": "gradient",
            "wall_colour": "#8f9296", "shadow_darkness": 0.3,
        }
    ),
    "occluded": Condition(scene={"post_width": 0.03, "hand_radius": 0.03}),
    # 14 ms from the first row to the last
    "rolling": Condition(camera={"row_time": 15e-6}),
    "lens": Condition(camera={"k1": -0.08, "k2": 0.01}),
}  # fmt: skip
