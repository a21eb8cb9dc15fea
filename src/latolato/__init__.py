"""Driven and colliding pendula: simulate, map, analyse, measure and play.

Quantities are in SI units and radians; angles are measured from the downward vertical.
"""

from __future__ import annotations

from typing import Any

from latolato.physics.contacts import Clamp, Exact, NoContact
from latolato.physics.drives import (
    Chirp,
    CrankSlider,
    FrequencySchedule,
    Harmonic,
    MeasuredPivot,
    Static,
)
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import (
    Ball,
    BallPair,
    LatoLato,
    Mathieu,
    Pendulum,
    equivalent_pendulum,
)
from latolato.simulate import simulate

# Names that are imported on first use, with the module they live in.
_LATE: dict[str, str] = {}

__all__ = [
    "Ball",
    "BallPair",
    "Chirp",
    "Clamp",
    "CrankSlider",
    "Exact",
    "FrequencySchedule",
    "Harmonic",
    "LatoLato",
    "Mathieu",
    "MeasuredPivot",
    "NoContact",
    "Pendulum",
    "Static",
    "VelocityKicks",
    "equivalent_pendulum",
    "simulate",
]


def __getattr__(name: str) -> Any:
    """Import a late name."""
    if name == "__version__":
        from importlib.metadata import version

        return version("latolato")
    if name not in _LATE:
        raise AttributeError(f"module 'latolato' has no attribute '{name}'")
    import importlib

    value = getattr(importlib.import_module(_LATE[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return [*__all__, "__version__"]
