"""Versions of installed packages, read once, and of what is written to files."""

from functools import lru_cache
from importlib.metadata import version
from typing import Any

from latolato.core.errors import InputError

# Of scenarios, result files and stores. It counts up when an older latolato would misread what a
# newer one writes; the newer one reads older formats, or names the version that does.
FORMAT = 1


@lru_cache
def version_of(package: str = "latolato") -> str:
    """Return the version of an installed package."""
    return version(package)


def check_format(number: Any, what: str) -> None:
    """Raise InputError unless a file is of a format that this version reads."""
    if number not in range(1, FORMAT + 1):
        raise InputError(
            f"the {{parameter}} of {what} must be at most {FORMAT}",
            parameter="format",
            value=number,
            way_out="use a newer latolato",
        )
