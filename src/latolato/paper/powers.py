"""Powers of ten in sentences: ``1.6e-04`` as people write it."""

from __future__ import annotations

import re
from collections.abc import Callable

_TIMES = "\N{NO-BREAK SPACE}\N{MULTIPLICATION SIGN}\N{NO-BREAK SPACE}"
_ZERO = re.compile(r"(?<![\w.])0(?:\.0+)?e[+-]0+\b")
_NUMBER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e([+-])0*(\d+)\b")


def rewritten_powers(text: str, raise_: Callable[[str], str]) -> str:
    """Return text with numbers such as ``1.6e-04`` as a factor times a power of ten.

    The factor 1 is left out; zero is 0.

    Parameters
    ----------
    text : str
        Text with numbers as Python formats them.
    raise_ : callable
        Returns the superscript of an exponent such as ``-9``.

    Examples
    --------
    >>> rewritten_powers("0e+00 and 1e+16", lambda power: f"^{power}")
    '0 and 10^16'
    """

    def power(match: re.Match[str]) -> str:
        factor, sign, exponent = match.groups()
        ten = "10" + raise_(sign.replace("+", "") + exponent)
        return ten if factor == "1" else f"{factor}{_TIMES}{ten}"

    return _NUMBER.sub(power, _ZERO.sub("0", text))
