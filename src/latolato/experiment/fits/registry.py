"""The fits by name, with what commands and pages need from each."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from latolato.core.registry import Registry

if TYPE_CHECKING:
    import xarray as xr

    from latolato.experiment.fits.apparatus import Apparatus
    from latolato.experiment.fits.result import Fit
    from latolato.physics.pendulum import System


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

    def fit(self, table: xr.Dataset, apparatus: Apparatus) -> Fit:
        """Return the fit of a table with what is known of the apparatus and no other choice."""
        arguments = {
            name: value
            for name, value in vars(apparatus).items()
            if name in self.parameters and value is not None
        }
        if "system" in self.parameters:
            arguments["system"] = apparatus.guess(table)
        return self.function(table, **arguments)


fits: Registry[FitKind] = Registry("fit")
