"""How the tracker's inner loops are compiled.

They are loops over numbers on purpose: arithmetic of whole arrays brings code of numba's own, with
the sentences of its errors, and compiled a third longer.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

_Kernel = TypeVar("_Kernel", bound=Callable[..., Any])


def jit(kernel: _Kernel) -> _Kernel:
    """Return a kernel compiled; its machine code is kept between processes."""
    options: Any = {"error_model": "numpy", "fastmath": {"contract", "reassoc"}}
    compiled: Any = numba.njit(cache=True, nogil=True, **options)(kernel)
    # numba looks at a kernel's own file only; those that it calls may lie in another.
    with contextlib.suppress(AttributeError):
        compiled._cache._cache_file._source_stamp = _sources()
    return cast(_Kernel, compiled)


@lru_cache(maxsize=1)
def _sources() -> str:
    """Return a digest of the sources of all inner loops."""
    digest = hashlib.sha256()
    for file in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()
