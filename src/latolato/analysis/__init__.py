"""Exact solutions and tools that read more out of a motion than its samples."""

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

__all__ = [
    "MathieuParameters",
    "collision_times",
    "damped_small_angle",
    "damping_from_decay_rate",
    "decay_rate",
    "elastic_bounces",
    "fall_time",
    "fold_angle",
    "impact_angular_velocity",
    "mathieu_growth_rate",
    "mathieu_parameters",
    "mathieu_threshold_amplitude",
    "mathieu_tongue_edges",
    "undriven_motion",
    "undriven_period",
    "zeno_time",
]
