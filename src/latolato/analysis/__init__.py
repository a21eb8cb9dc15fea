"""Exact solutions and tools that read more out of a motion than its samples."""

from latolato.analysis.basins import BasinEntropy, basin_entropy, basins
from latolato.analysis.bifurcation_diagram import bifurcation_diagram
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
from latolato.analysis.first_push import first_push
from latolato.analysis.impact_map import impact_map
from latolato.analysis.poincare_section import poincare_section
from latolato.analysis.response_period import response_period
from latolato.analysis.response_period_map import response_period_map
from latolato.analysis.stroboscopic import wilson

__all__ = [
    "BasinEntropy",
    "MathieuParameters",
    "basin_entropy",
    "basins",
    "bifurcation_diagram",
    "collision_times",
    "damped_small_angle",
    "damping_from_decay_rate",
    "decay_rate",
    "elastic_bounces",
    "fall_time",
    "first_push",
    "fold_angle",
    "impact_angular_velocity",
    "impact_map",
    "mathieu_growth_rate",
    "mathieu_parameters",
    "mathieu_threshold_amplitude",
    "mathieu_tongue_edges",
    "poincare_section",
    "response_period",
    "response_period_map",
    "undriven_motion",
    "undriven_period",
    "wilson",
    "zeno_time",
]
