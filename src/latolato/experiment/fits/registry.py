"""The fits by name, what commands and pages need from each, and what is known before any fit."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from latolato.core.registry import Registry
from latolato.experiment.rules import broken
from latolato.experiment.track_table import balls_of, has_own_pivots
from latolato.physics.pendulum import GRAVITY, LatoLato, Pendulum, System

if TYPE_CHECKING:
    import xarray as xr

    from latolato.experiment.fits.result import Fit


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


@dataclass(frozen=True, kw_only=True)
class FitKind:
    """A fit as commands and pages offer it.

    Parameters
    ----------
    function : callable
        Takes a track table and keyword arguments and returns a `Fit`. The options of
        ``latolato fit NAME`` come from its signature and docstring.
    title : str
        Heading on a page.
    headline : tuple of str
        The estimates that a page shows first; by default all.
    is_slow : bool
        Whether a page waits for a click before it fits.
    hint : str
        Text that a page then shows next to the button.
    fewest_balls : int
        How many balls a table must have for a page to offer the fit.
    system : callable
        Returns the system that a page plays after a fit, or None; by default that of the fit.
    is_predicted : bool
        Whether a page draws the motion that is computed from its start on, not the fitted curve.
    is_on_page : bool
        Whether pages offer it; else only Python and the command line do.

    Examples
    --------
    >>> from latolato.experiment.fits import fits
    >>> fits["decay"].function.__name__
    'fit_decay'
    """

    function: Callable[..., Fit]
    title: str
    headline: tuple[str, ...] = ()
    is_slow: bool = False
    hint: str = ""
    fewest_balls: int = 1
    system: Callable[[Fit, Apparatus, xr.Dataset], System | None] = lambda fit, *_: fit.system
    is_predicted: bool = False
    is_on_page: bool = True

    @property
    def parameters(self) -> Mapping[str, inspect.Parameter]:
        """What the function takes."""
        return inspect.signature(self.function).parameters

    def fit(self, table: xr.Dataset, apparatus: Apparatus, **part: float) -> Fit:
        """Return the fit of a table, or of a part of it, with what is known of the apparatus.

        `part` is the first instant used (``start``) and the last one (``end``) [s].
        """
        arguments = part | {
            name: value
            for name, value in vars(apparatus).items()
            if name in self.parameters and value is not None
        }
        if "system" in self.parameters:
            arguments["system"] = apparatus.guess(table)
        return self.function(table, **arguments)


fits: Registry[FitKind] = Registry("fit")
