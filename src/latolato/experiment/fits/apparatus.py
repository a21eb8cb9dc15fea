"""What is known about an experiment before any fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from latolato.experiment.rules import broken
from latolato.experiment.track_table import balls_of, has_own_pivots
from latolato.physics.pendulum import GRAVITY, LatoLato, Pendulum

if TYPE_CHECKING:
    import xarray as xr

# First guesses where nothing is given: mass [kg], damping [kg m/s], restitution, ball over length.
_MASS, _DAMPING, _RESTITUTION, _SMALL = 0.1, 0.003, 0.9, 1.0 / 12.0


@dataclass(frozen=True, kw_only=True)
class Apparatus:
    """What is known about the pendulum before any fit, in SI units; None means unknown."""

    length: float | None = None
    length_sigma: float | None = None
    radius: float | None = None
    mass: float | None = None
    damping: float | None = None
    restitution: float | None = None
    gravity: float = GRAVITY

    @property
    def some_mass(self) -> float:
        """The mass, or a first guess of it [kg]."""
        return self.mass or _MASS

    def guess(self, table: xr.Dataset) -> Pendulum | LatoLato:
        """The system of a track table, with first guesses of unknown parameters.

        Raises
        ------
        InputError
            Without a length.
        """
        if not self.length:
            raise broken("scale_of_motion", parameter="length")
        common: dict[str, Any] = {
            "length": self.length,
            "mass": self.some_mass,
            "damping": _DAMPING if self.damping is None else self.damping,
            "gravity": self.gravity,
        }
        if balls_of(table) == 1 or has_own_pivots(table):
            return Pendulum(**common)
        radius = self.radius or table.attrs.get("measured_radius") or _SMALL * self.length
        restitution = _RESTITUTION if self.restitution is None else self.restitution
        return LatoLato(**common, radius=float(radius), restitution=restitution)
