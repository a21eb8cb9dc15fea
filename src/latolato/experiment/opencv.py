"""OpenCV, which is imported where it is used: it is in the extra `video`."""

from __future__ import annotations

from typing import Any

from latolato.core.errors import import_extra


def import_cv2() -> Any:
    """Return OpenCV."""
    return import_extra("cv2", "video", "finding balls and drawing on videos")
