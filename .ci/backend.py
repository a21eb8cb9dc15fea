"""Hatchling, with the numerical code compiled into wheels and source distributions.

An editable installation has none: there `make kernels` compiles it.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling import build
from hatchling.build import *  # noqa: F403 - all other hooks are its own

# LLVM reads what older versions of it wrote: these have the oldest of the llvmlites that are
# allowed, for every Python.
_COMPILERS = [
    "numba==0.62.1; python_version < '3.14'",
    "numba==0.63.1; python_version >= '3.14'",
    "ziglang==0.17.1",  # links WebAssembly
]


def _compile() -> None:
    """Compile the numerical code unless it is there."""
    program = Path(__file__).with_name("kernels.py")
    subprocess.run([sys.executable, str(program)], check=True)


def get_requires_for_build_wheel(*given: Any, **named: Any) -> list[str]:
    """Return what building a wheel needs."""
    return [*build.get_requires_for_build_wheel(*given, **named), *_COMPILERS]


def get_requires_for_build_sdist(*given: Any, **named: Any) -> list[str]:
    """Return what building a source distribution needs."""
    return [*build.get_requires_for_build_sdist(*given, **named), *_COMPILERS]


def build_wheel(*given: Any, **named: Any) -> str:
    """Build a wheel and return its name."""
    _compile()
    return build.build_wheel(*given, **named)


def build_sdist(*given: Any, **named: Any) -> str:
    """Build a source distribution and return its name."""
    _compile()
    return build.build_sdist(*given, **named)
