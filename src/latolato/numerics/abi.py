"""What Python, compiled kernels and pages agree on: signatures, arguments as words, and sources.

A kernel takes and returns numbers and addresses of arrays and records, as C has them. What calls it
knows its address and its signature and does not depend on the code behind it. Nothing here imports
a compiler; `latolato.numerics.pointers` is how compiled code follows the same rules.
"""

from __future__ import annotations

import functools
import hashlib
import operator
import struct
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.core.versions import version_of

Formula = Callable[..., Any]

# ``rows(run, stop, most_steps)``, where `run` is an address; see `latolato.numerics.engine.loop`.
ENGINE = "int64(int64, float64, int64)"
# ``(words)`` of a named tuple that holds all arguments: see `words_of`.
BUNDLE = "void(int64)"
# ``(run, tolerance)``
ALLOWED = "float64(int64, float64)"
# ``lanes that wait(workspace, table, kicks, drifts of a step)``
LANE_STEP = "float64(int64, int64, int64, int64)"
# ``(workspace, kicks, drifts, nodes, stages)``
LANE_LOCATE = "void(int64, int64, int64, int64, int64)"
# ``(slots, workspace, matrix, number of the restoring law)``
LANE_REPORT = "void(int64, int64, int64, int64)"
# ``(slots, index of the first one, distance of slots, words of what is shown)``
CALLBACK = "void(int64, int64, int64, int64)"


class Kernel(NamedTuple):
    """A kernel: its address for other kernels, and what calls it from Python.

    What numba compiled stays where it is as long as there is a reference to `call`.
    """

    address: int
    call: Callable[..., Any]


class KernelSpec(NamedTuple):
    """Which kernel: what makes it, and how it is called.

    Attributes
    ----------
    make : callable
        Called with the laws, with what makes a function a part of a kernel (`Part`), and with the
        settings it returns the function to compile. Its name is the kernel's.
    signature : str
        What the kernel returns and takes, such as ``void(int64, float64)``.
    laws : tuple of formulas
    settings : tuple of pairs
        Further arguments of `make`, by name.
    for_lanes : bool
        Whether it loops over lanes, so that wide vectors make it faster.
    """

    make: Callable[..., Callable[..., Any]]
    signature: str
    laws: tuple[Formula, ...] = ()
    settings: tuple[tuple[str, Any], ...] = ()
    for_lanes: bool = False

    @property
    def name(self) -> str:
        """What the kernel does, such as ``engine``."""
        return self.make.__name__

    @property
    def key(self) -> str:
        """A text that tells kernels apart, the same in every version of Python."""
        laws = [f"{law.__module__}.{law.__qualname__}" for law in self.laws]
        return f"{self.name}({', '.join([*laws, *(f'{n}={v}' for n, v in self.settings)])})"


def words_of(value: Any, example: Any) -> list[int]:
    """The words of a value, from which compiled code reads it; see `pointers.Bundle`.

    A value is a number, an array, or a tuple of values. An array's words are its address, its
    shape and its strides.

    Raises
    ------
    TypeError
        If something is not of the kind that it has in `example`, for which the code was compiled.
    """
    if isinstance(example, tuple):
        pairs = zip(value, example, strict=True)
        return [word for part, like in pairs for word in words_of(part, like)]
    if isinstance(example, np.ndarray):
        _check_array(value, example)
        return [value.ctypes.data, *value.shape, *value.strides]
    if isinstance(example, float):
        return list(struct.unpack("q", struct.pack("d", value)))
    return [operator.index(value)]


def _check_array(value: Any, example: NDArray[Any]) -> None:
    """Raise unless a value is an array that compiled code can take for `example`."""
    if not isinstance(value, np.ndarray):
        raise TypeError(f"compiled code expects an array, got {type(value).__name__}")
    is_contiguous = value.flags.c_contiguous or not example.flags.c_contiguous
    if value.dtype != example.dtype or value.ndim != example.ndim or not is_contiguous:
        raise TypeError(
            f"compiled code expects a contiguous array of {example.dtype} in {example.ndim} "
            f"dimensions, got {value.dtype} in {value.ndim} with strides {value.strides}"
        )


# What kernels are compiled from, within the package.
_LAYERS = ("core/scalar.py", "physics", "observables", "numerics")


@functools.cache
def digest_of_sources() -> str:
    """The digest of the sources of the kernel layers."""
    digest = hashlib.sha256()
    root = Path(__file__).resolve().parents[1]
    for layer in _LAYERS:
        path = root / layer
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(file.read_bytes())
    return digest.hexdigest()[:24]


@functools.cache
def sources_hash() -> str:
    """The digest of the kernel layers' sources and of the versions of the compilers here."""
    text = f"{digest_of_sources()} {version_of('numba')} {version_of('llvmlite')} {sys.version}"
    return hashlib.sha256(text.encode()).hexdigest()[:24]
