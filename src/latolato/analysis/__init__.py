"""Exact solutions and tools that read more out of a motion than its samples.

An analysis is a function in a module of its name, registered by a decorator; every module here is
loaded by discovery. Those below are named for type checkers.
"""

import importlib
import pkgutil

from latolato.analysis.basins import BasinEntropy, basin_entropy, basins
from latolato.analysis.bifurcation_curve import bifurcation_curve
from latolato.analysis.bifurcation_diagram import bifurcation_diagram
from latolato.analysis.closed_forms import (
    MathieuParameters,
    collision_times,
    damped_small_angle,
    damping_from_decay_rate,
    decay_rate,
    elastic_bounces,
    fall_time,
    impact_angular_velocity,
    mathieu_parameters,
    reflected_angle,
    zeno_time,
)
from latolato.analysis.continue_orbit import continue_orbit
from latolato.analysis.elliptic import undriven_motion, undriven_period
from latolato.analysis.first_passage_time import first_passage_time
from latolato.analysis.first_push import first_push
from latolato.analysis.floquet import floquet
from latolato.analysis.growth_rate import growth_rate
from latolato.analysis.hysteresis import hysteresis
from latolato.analysis.impact_map import impact_map
from latolato.analysis.inverted_limits import inverted_limits
from latolato.analysis.lyapunov_spectrum import lyapunov_spectrum
from latolato.analysis.pair_symmetry import pair_symmetry
from latolato.analysis.poincare_section import poincare_section
from latolato.analysis.protocol import Protocol
from latolato.analysis.registry import analyses
from latolato.analysis.response_period import response_period
from latolato.analysis.response_period_map import response_period_map
from latolato.analysis.self_start import self_start
from latolato.analysis.shortest_protocol import shortest_protocol
from latolato.analysis.stroboscopic import wilson_interval
from latolato.analysis.threshold_amplitude import threshold_amplitude
from latolato.analysis.time_crystal import time_crystal
from latolato.analysis.tongue_edges import tongue_edges

__all__ = [
    "BasinEntropy",
    "MathieuParameters",
    "Protocol",
    "analyses",
    "basin_entropy",
    "basins",
    "bifurcation_curve",
    "bifurcation_diagram",
    "collision_times",
    "continue_orbit",
    "damped_small_angle",
    "damping_from_decay_rate",
    "decay_rate",
    "elastic_bounces",
    "fall_time",
    "first_passage_time",
    "first_push",
    "floquet",
    "growth_rate",
    "hysteresis",
    "impact_angular_velocity",
    "impact_map",
    "inverted_limits",
    "lyapunov_spectrum",
    "mathieu_parameters",
    "pair_symmetry",
    "poincare_section",
    "reflected_angle",
    "response_period",
    "response_period_map",
    "self_start",
    "shortest_protocol",
    "threshold_amplitude",
    "time_crystal",
    "tongue_edges",
    "undriven_motion",
    "undriven_period",
    "wilson_interval",
    "zeno_time",
]

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")
globals().update(analyses)


def __dir__() -> list[str]:
    """Return the public names, those of further analyses among them."""
    return sorted({*__all__, *analyses})
