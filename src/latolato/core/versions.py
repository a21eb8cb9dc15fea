"""Versions of installed packages, read once."""

from functools import lru_cache
from importlib.metadata import version


@lru_cache
def version_of(package: str = "latolato") -> str:
    """Return the version of an installed package."""
    return version(package)
