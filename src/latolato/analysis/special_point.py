"""A special point of a branch, from which another branch or a curve can begin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from latolato.analysis.flow import varied
from latolato.analysis.rules import broken_analysis
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System

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
        system, drive = varied(system, drive, at.attrs["parameter"], float(at["special_value"]))
        sides = ("",) if system.angles == 1 else ("_right", "_left")
        start = []
        for name in ("angle", "angular_velocity"):
            numbers = tuple(float(at[f"special_initial_{name}{side}"]) for side in sides)
            start.append(numbers if system.angles == 2 else numbers[0])
        angle, velocity = start
        kind, period = str(at["special_kind"].item()), int(at.attrs["period"])
        return cls(kind, system, drive, angle, velocity, period)


def _shown(at: xr.DataArray | Any) -> Any:
    """Return what a refusal shows of something that is no special point."""
    return at if isinstance(at, (int, float, str)) else type(at).__name__
