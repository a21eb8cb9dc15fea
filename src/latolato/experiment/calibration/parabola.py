"""The top of a curve between samples."""

from __future__ import annotations

from typing import Any

import numpy as np


def parabola_top(x: Any, y: Any) -> tuple[float, float]:
    """Place and height of the top of the parabola through three samples.

    Those of the second sample where the parabola opens upwards.
    """
    (x0, x1, x2), (y0, y1, y2) = (np.asarray(values, float).tolist() for values in (x, y))
    early, late = (y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1)
    a = (late - early) / (x2 - x0)
    b = early + a * (x1 - x0)
    if a >= 0.0:
        return x1, y1
    top = min(max(-b / (2.0 * a), x0 - x1), x2 - x1)
    return x1 + top, a * top * top + b * top + y1
