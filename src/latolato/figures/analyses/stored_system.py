"""The system and the drive in the attributes of an analysis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields
from typing import TYPE_CHECKING, Any

from latolato.physics.drives import Drive, drives
from latolato.physics.pendulum import Ball, BallPair, System, systems

if TYPE_CHECKING:
    import xarray as xr

# What a drive has where the analysis varies it.
_VARIED = {"drive_amplitude": 0.0, "drive_frequency": 1.0}


def system_of(dataset: xr.Dataset) -> System:
    """Return the system of an analysis."""
    about = dataset.attrs
    kind = systems[about["system"]]
    if kind is BallPair:
        balls: dict[str, Any] = {
            side: Ball(**_known(Ball, about, f"{side}_")) for side in ("right", "left")
        }
        return BallPair(**balls, **_known(BallPair, about, without=tuple(balls)))
    system: System = kind(**_known(kind, about))
    return system


def drive_of(dataset: xr.Dataset) -> Drive:
    """Return the drive of an analysis."""
    kind = drives[dataset.attrs["drive"]]
    drive: Drive = kind(**_known(kind, {**_VARIED, **dataset.attrs}))
    return drive


def _known(
    kind: type, about: Mapping[Any, Any], prefix: str = "", without: Sequence[str] = ()
) -> dict[str, Any]:
    """Return the attributes that are parameters of a class."""
    names = [f.name for f in fields(kind) if f.init and f.name not in without]
    needed = {f.name for f in fields(kind) if f.init and f.default is MISSING}
    return {n: about[prefix + n] for n in names if n in needed or prefix + n in about}
