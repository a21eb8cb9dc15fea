"""A pytest plugin of `mutants.py`: kernels run as plain Python, and quick tests come first.

The first run tries up to eight cases of each test and writes the times of those that pass within
`LONGEST` seconds to the file `TIMES`; later runs take these only. Mutants of observables are
compiled, since they are kernels of their own: all else comes from the kernels of the sources whose
digest is `KERNELS`.
"""

import json
import os
import random
import signal
from collections import defaultdict
from pathlib import Path

import hypothesis
import numpy as np

from latolato.core.cache import cache_directory
from latolato.numerics import integrate, jit, kernels, shipped
from latolato.numerics.abi import sources_hash
from latolato.numerics.derived import make_observer
from latolato.numerics.run_record import as_objects

TIMES, KERNELS = Path(os.environ["TIMES"]), os.environ["KERNELS"]
known = json.loads(TIMES.read_text()) if TIMES.exists() else {}
found = defaultdict(float)
# A mutant with which a known test takes six times as long has been noticed.
limit = float(os.environ["LONGEST"]) * (6.0 if known else 1.0)
os.environ["HYPOTHESIS_PROFILE"] = "plain"
hypothesis.settings.register_profile("plain", derandomize=True, deadline=None, max_examples=20)


def _folder(cache):
    return cache_directory() / "mutants" / sources_hash()


def _load(spec):
    observables = kernels.callback, kernels.step_report, kernels.jacobian_report
    return None if spec.make in observables else load(spec)


def _observe(observation, *laws):
    with np.errstate(all="ignore"):
        make_observer(*laws)(type(observation)(*map(_readable, observation)))


def _readable(value):
    is_record = isinstance(value, np.ndarray) and value.dtype.names
    return as_objects(value) if is_record else value


if KERNELS:
    load = shipped.load
    shipped.load, shipped.digest_of_sources = _load, lambda: KERNELS
    jit._KernelCache._folder = _folder
else:
    engine_of = integrate.engine_of
    integrate.engine_of = lambda *laws, **given: engine_of(*laws, **{**given, "compiled": False})
    integrate.observe = _observe
    prepare_cases = integrate.prepare_cases
    integrate.prepare_cases = lambda work, **_: prepare_cases(work, compiled=False)
    from latolato.sweeps import batches  # imports what was just replaced

    batches.run_fastest = lambda *args, cancel: batches.run_reference(*args)


class TooLongError(BaseException):
    """A test takes too long; no test expects this."""


def _interrupt(number, frame):
    raise TooLongError


def pytest_collection_modifyitems(items):
    if known:  # sorted coarsely: neighbours in a file share what they set up
        items[:] = [item for item in items if item.nodeid in known]
        items.sort(key=lambda item: int(2.0 * known[item.nodeid]))
        return
    cases, draw = defaultdict(list), random.Random(0)
    for item in items:
        cases[item.nodeid.partition("[")[0]].append(item)
    items[:] = [item for each in cases.values() for item in draw.sample(each, min(len(each), 8))]


def pytest_runtest_setup():
    signal.signal(signal.SIGALRM, _interrupt)
    signal.setitimer(signal.ITIMER_REAL, limit)


def pytest_runtest_teardown():
    signal.setitimer(signal.ITIMER_REAL, 0.0)


def pytest_runtest_logreport(report):
    found[report.nodeid] += report.duration if report.passed else float("inf")


def pytest_sessionfinish():
    if not known:
        TIMES.write_text(json.dumps({k: v for k, v in found.items() if v < float("inf")}))
