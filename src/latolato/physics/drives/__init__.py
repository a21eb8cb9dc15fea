"""Motions of the pivot: each a sequence of smooth segments with scalar formulas.

A drive is a frozen class with its parameters as fields, which the formula `write` turns into smooth
segments of the motion; integrators end a step where a segment begins. A `Segment` is of one of a
few forms (at rest, a cosine, a crank, a polynomial), and one compiled kernel serves all of them. To
add a drive, write one file in this folder with one class and the `register` decorator: every module
here is discovered and loaded. A drive whose motion has another form provides its own formulas; see
`Drive`.
"""

from __future__ import annotations

import importlib
import pkgutil

from latolato.physics.drives.base import Drive, PeriodicDrive, drives

from latolato.physics.drives.harmonic import Harmonic, FixedPivot  # isort: skip - the simplest first
from latolato.physics.drives.schedule import Chirp, FrequencySchedule  # isort: skip
from latolato.physics.drives.crank import CrankSlider
from latolato.physics.drives.measured import MeasuredPivot
from latolato.physics.drives.planar import PlanarHarmonic
from latolato.physics.drives.segment import Segment
from latolato.physics.drives.stages import StagedHarmonic

__all__ = [
    "Chirp",
    "CrankSlider",
    "Drive",
    "FixedPivot",
    "FrequencySchedule",
    "Harmonic",
    "MeasuredPivot",
    "PeriodicDrive",
    "PlanarHarmonic",
    "Segment",
    "StagedHarmonic",
    "drives",
]

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")
