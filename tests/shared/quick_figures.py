"""What the figures compute when they are quick, once for all tests of a worker."""

from functools import cache

from latolato.figures import catalogue

EVIDENCE = catalogue.evidence()


@cache
def quick_data(name):
    """Return the data of a figure or of a text's number."""
    return EVIDENCE[name].data(quick=True)
