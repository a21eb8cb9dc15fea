"""A special point of a branch, from which another branch or a curve can begin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.analysis.flow import varied
from latolato.analysis.rules import broken_analysis
from latolato.core.registry import describe, first_difference, flattened
from latolato.physics.drives import Drive, drives
from latolato.physics.pendulum import System, systems
from latolato.simulation.vary import DERIVED

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class SpecialPoint:
    """What is special, the laws there, and the motion.

    Attributes
    ----------
    kind : str
        As in `continue_orbit`.
    angle, angular_velocity : float or pair of float
        At time zero [rad], [rad/s].
    period : int
        Drive periods.
    """

    kind: str
    system: System
    drive: Drive
    angle: Any
    angular_velocity: Any
    period: int

    @classmethod
    def of(cls, at: Any, system: System, drive: Drive | None) -> SpecialPoint:
        """Return the point that ``branch.special[0]`` holds, of a branch of system and drive.

        Raises
        ------
        InputError
            If it is something else, or the drive is missing.
        """
        known = {*getattr(at, "coords", {}), *getattr(at, "attrs", {})}
        is_point = getattr(at, "ndim", None) == 0 and {"special_kind", "parameter"} <= known
        if not is_point or drive is None:
            raise broken_analysis("special_point", parameter="at", value=_shown(at))
        parameter = str(at.attrs["parameter"])
        here = laws_of(system, drive)
        names = [n for n in here if n not in (parameter, DERIVED.get(parameter))]
        if (name := first_difference(names, here, at.attrs)) is not None:
            gaps = {"name": name, "there": at.attrs.get(name, "none"), "here": here[name]}
            raise broken_analysis("point_of_other", gaps, parameter="at")
        system, drive = varied(system, drive, parameter, float(at["special_value"]))
        sides = ("",) if system.angles == 1 else ("_right", "_left")
        start = []
        for name in ("angle", "angular_velocity"):
            numbers = tuple(float(at[f"special_initial_{name}{side}"]) for side in sides)
            start.append(numbers if system.angles == 2 else numbers[0])
        angle, velocity = start
        kind, period = str(at["special_kind"].item()), int(at.attrs["period"])
        return cls(kind, system, drive, angle, velocity, period)


def laws_of(system: System, drive: Drive) -> dict[str, Any]:
    """Return the kinds and the parameters of the laws, as a special point holds them."""
    kinds = {"system": systems.name_of(system), "drive": drives.name_of(drive)}
    return {**kinds, **flattened(describe(system)), **flattened(describe(drive))}


def check_left_out(**others: Any) -> None:
    """Raise InputError for the first argument that is given beside a special point."""
    for name, value in others.items():
        is_default = name == "initial_angular_velocity" and not np.any(value)
        if value is not None and not is_default:
            raise broken_analysis("brought_by_point", parameter=name, value=value)


def _shown(at: xr.DataArray | Any) -> Any:
    """Return what a refusal shows of something that is no special point."""
    return at if isinstance(at, (int, float, str)) else type(at).__name__
