"""The laws that the engine is made of: drive, restoring force, and what a mode adds to them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from latolato.core.scalar import formula
from latolato.numerics.parts import Part, as_it_stands, inlined
from latolato.numerics.run_record import Run
from latolato.physics.drives.segment import CHANGES
from latolato.physics.pendulum import (
    SLOPES,
    potential_linear,
    potential_sine,
    restoring_linear,
    restoring_sine,
    slope_linear,
    slope_sine,
)

Formula = Callable[..., float]


class PlaneLaws(NamedTuple):
    """What else of the pivot's motion counts in the plane: formulas ``(t, segment)``.

    Attributes
    ----------
    across_acceleration : formula
        The horizontal acceleration [m/s^2].
    up_velocity, across_velocity : formulas
        The velocities, which air at rest in the room makes a difference to [m/s].
    """

    across_acceleration: Formula
    up_velocity: Formula
    across_velocity: Formula


class Laws(NamedTuple):
    """Formulas of the equation of motion.

    Attributes
    ----------
    pivot_acceleration : formula ``(t, segment)``
        Of the drive [m/s^2].
    restoring, slope, potential : formulas ``(angle, is_linear)``
        The restoring factor, its slope and its potential; `is_linear` selects the package's law.
    push, push_slope, push_potential : formulas ``(angle, run)``
        What a mode adds to the acceleration [rad/s^2], its slope and its potential [1/s^2].
    plane : PlaneLaws or None
        Of a pivot that moves sideways, of strings and of air at rest in the room.
    changes : tuple of formulas ``(t, segment, change)``
        The derivatives with respect to a parameter of `pivot_acceleration` and, in the plane, of
        the formulas of `PlaneLaws`; none where no run asks for them. See `engine.sensitivity`.
    """

    pivot_acceleration: Formula
    restoring: Formula
    slope: Formula
    potential: Formula
    push: Formula
    push_slope: Formula
    push_potential: Formula
    plane: PlaneLaws | None = None
    changes: tuple[Formula, ...] = ()


@formula
def no_push(angle: float, run: Run) -> float:
    """Zero."""
    return 0.0


@formula
def _restoring(angle: float, is_linear: int) -> float:
    """Restoring factor of a system of the package."""
    return restoring_linear(angle) if is_linear != 0 else restoring_sine(angle)


@formula
def _slope(angle: float, is_linear: int) -> float:
    """Slope of `_restoring`."""
    return slope_linear(angle) if is_linear != 0 else slope_sine(angle)


@formula
def _potential(angle: float, is_linear: int) -> float:
    """Potential of `_restoring`."""
    return potential_linear(angle) if is_linear != 0 else potential_sine(angle)


class RestoringLaws(NamedTuple):
    """Restoring factor, its slope and its potential, as in `Laws`."""

    restoring: Formula
    slope: Formula
    potential: Formula


def restoring_laws(
    restoring: Formula, potential: Formula, part: Part = as_it_stands
) -> RestoringLaws:
    """Return a restoring law with its slope and potential; those of the package share all code."""
    if restoring in (restoring_sine, restoring_linear):
        return RestoringLaws(
            restoring=_restoring,
            slope=_slope,
            potential=_potential,
        )
    part, own_slope = inlined(part), SLOPES[restoring]

    @part
    def own_restoring(angle: float, is_linear: int) -> float:
        return restoring(angle)

    @part
    def slope(angle: float, is_linear: int) -> float:
        return own_slope(angle)

    @part
    def own_potential(angle: float, is_linear: int) -> float:
        return potential(angle)

    return RestoringLaws(
        restoring=own_restoring,
        slope=slope,
        potential=own_potential,
    )


def laws_of(
    pivot_acceleration: Formula,
    restoring: Formula,
    potential: Formula,
    *plane: Formula,
    part: Part = as_it_stands,
) -> Laws:
    """Return the laws of a system under a drive; `plane` are none or those of `PlaneLaws`."""
    result = restoring_laws(restoring, potential, part)
    in_plane = PlaneLaws(*plane) if plane else None
    return Laws(pivot_acceleration, *result, no_push, no_push, no_push, in_plane)


def with_changes(laws: Laws) -> Laws:
    """Return laws that know their derivatives with respect to parameters."""
    formulas = (laws.pivot_acceleration, *(laws.plane or ()))
    return laws._replace(changes=tuple(CHANGES[formula] for formula in formulas))
