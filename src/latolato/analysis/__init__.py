"""Exact solutions and tools that read more out of a motion than its samples."""

from latolato.analysis.activation_time import activation_time
from latolato.analysis.closed_forms import (
    MathieuParameters,
    collision_times,
    damped_small_angle,
    damping_from_decay_rate,
    decay_rate,
    elastic_bounces,
    fall_time,
    fold_angle,
    impact_angular_velocity,
    mathieu_growth_rate,
    mathieu_parameters,
    mathieu_threshold_amplitude,
    mathieu_tongue_edges,
    undriven_motion,
    undriven_period,
    zeno_time,
)
from latolato.analysis.continuation import continue_orbit
from latolato.analysis.floquet import floquet
from latolato.analysis.growth_rate import growth_rate
from latolato.analysis.hysteresis import hysteresis
from latolato.analysis.inverted_limits import inverted_limits
from latolato.analysis.lyapunov import lyapunov_spectrum
from latolato.analysis.protocol import Protocol
from latolato.analysis.registry import analyses
from latolato.analysis.self_start import self_start
from latolato.analysis.shortest_protocol import shortest_protocol
from latolato.analysis.symmetry import pair_symmetry
from latolato.analysis.threshold_amplitude import threshold_amplitude
from latolato.analysis.time_crystal import time_crystal
from latolato.analysis.tongue_edges import tongue_edges

__all__ = [
    "MathieuParameters",
    "Protocol",
    "activation_time",
    "analyses",
    "collision_times",
    "continue_orbit",
    "damped_small_angle",
    "damping_from_decay_rate",
    "decay_rate",
    "elastic_bounces",
    "fall_time",
    "floquet",
    "fold_angle",
    "growth_rate",
    "hysteresis",
    "impact_angular_velocity",
    "inverted_limits",
    "lyapunov_spectrum",
    "mathieu_growth_rate",
    "mathieu_parameters",
    "mathieu_threshold_amplitude",
    "mathieu_tongue_edges",
    "pair_symmetry",
    "self_start",
    "shortest_protocol",
    "threshold_amplitude",
    "time_crystal",
    "tongue_edges",
    "undriven_motion",
    "undriven_period",
    "zeno_time",
]
