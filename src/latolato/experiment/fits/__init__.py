"""Fits of track tables; every module of this folder is loaded by discovery.

A fit is one file with a function of a track table that returns a `Fit`, registered with its words
as a `FitKind`. Its picture is the module of its name in `latolato.figures.fits`.
"""

from __future__ import annotations

import importlib
import pkgutil

from latolato.experiment.fits.registry import fits

__all__ = ["fits"]

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")
