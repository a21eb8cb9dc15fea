"""What people read about where two equal balls stay mirror images."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    pass

READING = (
    "Both balls start almost as mirror images. Below zero the difference dies out, and one "
    "ball tells all. Above zero it grows, and each ball goes its own way."
)
FIRST = {"duration": "300", "transient": ""}
