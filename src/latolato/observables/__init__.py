"""Numbers gathered while a trajectory runs; every module of this folder is discovered and loaded.

To add an observable, write one file with one class and the `register` decorator;
see `latolato.observables.base.Observable` for what it may define.
"""

from __future__ import annotations

import importlib
import pkgutil

from latolato.observables.angles import (
    LargestAngle,
    LargestAngleAfterTransient,
    MotionClass,
    SelfStart,
)
from latolato.observables.base import Observable, Outcome, Step, observables
from latolato.observables.contacts import BottomContacts, ImpactSpeed, RestFraction, TopContacts
from latolato.observables.crossings import Crossings, Rotations
from latolato.observables.energy import MeanEnergy
from latolato.observables.final import (
    CompressionFraction,
    EnergyLedger,
    FinalAngle,
    FinalAngularVelocity,
    PoincareSection,
)
from latolato.observables.passage import FirstPassage
from latolato.observables.period import ResponsePeriod, ResponseSamples
from latolato.observables.strings import (
    FirstSlack,
    LargestStringImpulse,
    RetensionLoss,
    SlackFraction,
)
from latolato.observables.word import ContactWord, contact_words

__all__ = [
    "BottomContacts",
    "CompressionFraction",
    "ContactWord",
    "Crossings",
    "EnergyLedger",
    "FinalAngle",
    "FinalAngularVelocity",
    "FirstPassage",
    "FirstSlack",
    "ImpactSpeed",
    "LargestAngle",
    "LargestAngleAfterTransient",
    "LargestStringImpulse",
    "MeanEnergy",
    "MotionClass",
    "Observable",
    "Outcome",
    "PoincareSection",
    "ResponsePeriod",
    "ResponseSamples",
    "RestFraction",
    "RetensionLoss",
    "Rotations",
    "SelfStart",
    "SlackFraction",
    "Step",
    "TopContacts",
    "contact_words",
    "observables",
]

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")
