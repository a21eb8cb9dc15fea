"""Where a sweep runs: one executor a file, each the same plan with the same results.

An executor is a function ``execute(plan, numbers, **options)`` that yields ``(number, (values,
reason))`` for every chunk of `numbers`, in any order, and cleans up when its generator is closed.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from typing import Any

from latolato.core.errors import InputError
from latolato.core.registry import suggest
from latolato.sweeps.chunk import Values

Execute = Callable[..., Iterator[tuple[int, tuple[Values, str]]]]

# How each executor rounds. Executors of one family give the same bits, which a store relies on.
ROUNDING = {"threads": "compiled", "reference": "python", "dask": "compiled", "cuda": "cuda"}
EXECUTORS = tuple(ROUNDING)


def executor_named(name: str) -> Execute:
    """Return the executor of that name; its module is imported on use.

    Raises
    ------
    InputError
        For an unknown name, with the closest known one.
    """
    if name not in EXECUTORS:
        raise InputError(f"unknown executor '{name}': {suggest(str(name), list(EXECUTORS))}")
    module: Any = importlib.import_module(f"{__name__}.{name}")
    execute: Execute = module.execute
    return execute
