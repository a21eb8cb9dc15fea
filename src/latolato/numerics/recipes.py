"""How a piece of compiled code is made, and what comes of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

Formula = Callable[..., Any]

# How the keys of recipes begin whose pieces loop over lanes.
LANE_PIECES = ("lane_flight:", "lane_locate:")


class Piece(NamedTuple):
    """A piece: its address for other pieces, and what calls it from Python.

    What numba compiled stays where it is as long as there is a reference to `call`.
    """

    address: int
    call: Callable[..., Any]


class Recipe(NamedTuple):
    """How a piece is made.

    Attributes
    ----------
    maker : str
        ``module:function`` within `latolato.numerics`; called with the laws, with what makes a
        function a part, and with the settings it returns the function to compile.
    kind : str
        What the piece returns and takes, such as ``void(int64, float64)``.
    laws : tuple of formulas
    settings : tuple of pairs
        Further arguments of the maker, by name.
    """

    maker: str
    kind: str
    laws: tuple[Formula, ...] = ()
    settings: tuple[tuple[str, Any], ...] = ()

    @property
    def key(self) -> str:
        """A text that tells recipes apart, the same in every version of Python."""
        laws = [f"{law.__module__}.{law.__qualname__}" for law in self.laws]
        return f"{self.maker}({', '.join([*laws, *(f'{n}={v}' for n, v in self.settings)])})"
