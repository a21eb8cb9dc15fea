"""Compiles kernels with numba and keeps them on disk, keyed by everything they depend on.

numba's own cache looks at the file of the outermost function only. Ours hashes all sources of the
kernel layers together with the library versions, so an edit anywhere below a kernel recompiles it.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
from collections.abc import Callable, Iterable
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator
from numba.core.runtime.nrt import rtsys
from numba.extending import register_jitable

from latolato.numerics.compiler import tell_it_is_there
from latolato.scalar import for_each_formula

# Only kernels call parts: without entries for Python and C they compile in two thirds of the time.
_PART: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def _make_callable(function: Callable[..., Any]) -> None:
    """Let compiled code call a formula."""
    register_jitable(**_PART, forceinline=True)(function)  # small, and lanes need it


for_each_formula(_make_callable)
tell_it_is_there()

_LAYERS = ("scalar.py", "physics", "observables", "numerics")


@lru_cache(maxsize=1)
def sources_hash() -> str:
    """Return a digest of the kernel layers' sources and of the compiler's version."""
    digest = hashlib.sha256()
    root = Path(__file__).resolve().parents[1]
    for layer in _LAYERS:
        path = root / layer
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(file.read_bytes())
    digest.update(f"{numba.__version__} {llvmlite.__version__} {sys.version}".encode())
    return digest.hexdigest()[:24]


def cache_directory() -> Path:
    """Return the folder of compiled kernels; ``LATOLATO_CACHE_DIR`` overrides the default."""
    chosen = os.environ.get("LATOLATO_CACHE_DIR")
    if chosen:
        return Path(chosen)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData/Local"))
    elif sys.platform == "darwin":
        base = Path.home() / "Library/Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return base / "latolato"


class _Locator(_CacheLocator):
    """Puts every kernel below one folder, stamped by the hash of all sources."""

    # numba's warning of code that cannot be kept (as with NUMBA_OPT=0) names a place.
    _py_file, _lineno = __file__, 1

    def __init__(self, *_: Any) -> None:
        self._path = str(cache_directory() / sources_hash())

    def ensure_cache_path(self) -> None:
        os.makedirs(self._path, exist_ok=True)

    def get_cache_path(self) -> str:
        return self._path

    def get_source_stamp(self) -> str:
        return sources_hash()

    def get_disambiguator(self) -> str:
        return ""

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> _Locator:
        return cls()


class _Implementation(CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012 - as numba declares it


class _KernelCache(FunctionCache):
    """A cache whose index key is the kernel's own name instead of pickled closure cells."""

    _impl_class = _Implementation

    def __init__(self, py_func: Any, key: str) -> None:
        super().__init__(py_func)  # type: ignore[no-untyped-call]
        self._key = key

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        return (sig, codegen.magic_tuple(), self._key)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load a kernel without what only compiling needs: 0.2 s of imports, half of them SciPy."""
        # What compiled code may call lies in these two.
        rtsys.initialize(target_context)
        import_module("numba.cpython.hashing")
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)  # type: ignore[no-untyped-call]


def law_key(*laws: Callable[..., Any]) -> str:
    """Return a text that identifies formulas: where they stand and what their code is."""
    parts = []
    for law in laws:
        code = law.__code__
        body = hashlib.sha256(code.co_code + repr(code.co_consts).encode()).hexdigest()[:12]
        parts.append(f"{law.__module__}.{law.__qualname__}.{body}")
    return "+".join(parts)


def hooks_key(hooks: Iterable[Iterable[tuple[int, Callable[..., Any]]]]) -> str:
    """Return a text that identifies observables' formulas and slots."""
    return ";".join("+".join(f"{at}@{law_key(f)}" for at, f in hook) for hook in hooks)


# Multiply-adds may be fused: faster and rounded once less, but not to the bits of plain Python.
_OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True, "fastmath": {"contract"}}


def compile_kernel(
    make: Callable[..., Callable[..., Any]], name: str, *laws: Callable[..., Any]
) -> Callable[..., Any]:
    """Return the kernel that `make` folds from laws, compiled, with a disk cache.

    ``make(*laws, compile_part)`` compiles its parts by the function it is given. Every part gets a
    name of its own kernel: libraries that two processes compiled may be loaded by a third, and
    parts of one name would be taken for each other there.
    """
    key = f"{name}:{law_key(*laws)}"
    suffix = hashlib.sha256(key.encode()).hexdigest()[:16]

    def rename(function: Callable[..., Any]) -> None:
        function.__qualname__ = f"{function.__qualname__}_{suffix}"

    def compile_part(function: Callable[..., Any], *, inline: bool = False) -> Any:
        rename(function)
        return numba.njit(**_OPTIONS, **_PART, forceinline=inline)(function)

    function = make(*laws, compile_part)
    rename(function)
    dispatcher = numba.njit(**_OPTIONS)(function)
    with contextlib.suppress(OSError):  # a read-only home: compile in every process
        dispatcher._cache = _KernelCache(function, key)
    compiled: Callable[..., Any] = dispatcher
    return compiled
