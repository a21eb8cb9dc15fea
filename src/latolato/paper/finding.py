"""Results beyond the paper: a picture, what it shows, and how that was checked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from latolato.paper.claim import Numbers, filled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True)
class Finding:
    """A result with its picture.

    Attributes
    ----------
    title, caption : str
        Of the picture.
    finding : str
        Two sentences on what was found, a template that numbers are written into by ``str.format``.
    check : str
        How it was checked, a template as well.
    data, numbers, draw : callable
        As those of a figure (`latolato.paper.claim.Evidence`).
    """

    title: str
    caption: str
    finding: str
    check: str
    data: Callable[..., xr.Dataset]
    numbers: Callable[[xr.Dataset], Numbers]
    draw: Callable[[xr.Dataset], Figure]

    def words(self, dataset: xr.Dataset) -> tuple[str, str]:
        """Return finding and check with the numbers of a dataset."""
        numbers = self.numbers(dataset)
        return filled(self.finding, numbers), filled(self.check, numbers)
