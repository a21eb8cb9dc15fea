"""What the figures compute when they are quick, once for all workers of a run."""

import os
import pickle
from functools import cache
from pathlib import Path

from latolato.paper import catalogue

EVIDENCE = catalogue.evidence()
RESULTS = catalogue.results()
_EVERYTHING = {**EVIDENCE, **RESULTS}


@cache
def quick_data(name):
    """Return the data of a figure, a text or a result, which the first to ask computes."""
    path = Path(os.environ["LATOLATO_TEST_FOLDER"], f"{name}.pickle")
    if not path.exists():
        unfinished = path.with_suffix(f".{os.getpid()}")
        unfinished.write_bytes(pickle.dumps(_EVERYTHING[name].data(quick=True)))
        unfinished.replace(path)
    return pickle.loads(path.read_bytes())


@cache
def picture_of(name):
    """Return a figure as its quick data give it, drawn once in each worker."""
    return _EVERYTHING[name].draw(quick_data(name))
