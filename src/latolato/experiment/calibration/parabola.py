"""The top of a curve between samples."""

from __future__ import annotations

from typing import Any

import numpy as np


def parabola_top(x: Any, y: Any) -> tuple[float, float]:
    """Place and height of the top of the parabola through three samples.

    Those of the second sample where the parabola opens upwards.
    """
    x, y = np.asarray(x, float), np.asarray(y, float)
    a, b, c = np.polyfit(x - x[1], y, 2)
    if a >= 0.0:
        return float(x[1]), float(y[1])
    top = float(np.clip(-b / (2.0 * a), x[0] - x[1], x[2] - x[1]))
    return float(x[1] + top), float(a * top * top + b * top + c)
