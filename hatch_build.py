"""Puts the compiled pieces into wheels and source distributions: see `.ci/kernels.py`."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CustomBuildHook(BuildHookInterface):  # type: ignore[type-arg]
    """Compiles them unless they are there."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, except for editable installations: there `make kernels` does."""
        if version != "editable":
            subprocess.run([sys.executable, ".ci/kernels.py"], cwd=self.root, check=True)
