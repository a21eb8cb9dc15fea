"""Motions of the pivot: each a sequence of smooth stretches with scalar formulas.

A drive is a frozen class with its parameters as fields and three static formulas, `height`,
`velocity` and `acceleration` of ``(time, stretch)``. `stretches` lists where each smooth stretch
begins and the numbers (`stretch_fields`) that the formulas read from it; integrators end a step
at each such instant. Adding a drive is one file in this
folder with one class and the `register` decorator: every module here is loaded by discovery.
"""

from __future__ import annotations

import importlib
import pkgutil

from latolato.physics.drives.base import Drive, Stretch, drives

from latolato.physics.drives.harmonic import Harmonic, Static  # isort: skip - the simplest first
from latolato.physics.drives.schedule import Chirp, FrequencySchedule  # isort: skip
from latolato.physics.drives.crank import CrankSlider
from latolato.physics.drives.measured import MeasuredPivot
from latolato.physics.drives.stages import Stages

__all__ = [
    "Chirp",
    "CrankSlider",
    "Drive",
    "FrequencySchedule",
    "Harmonic",
    "MeasuredPivot",
    "Stages",
    "Static",
    "Stretch",
    "drives",
]

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")
