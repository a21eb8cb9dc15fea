"""Observables that tests of sweeps gather together, so that their kernels are compiled once."""

from latolato.observables import FirstPassage, PoincareSection

# Without a drive there are no periods to sample.
WITHOUT_PERIODS = (
    "mean_energy",
    "crossings",
    "rotations",
    "largest_angle",
    "largest_angle_after_transient",
    "motion_class",
    "self_start",
    FirstPassage(threshold_angle=1.2),
    "bottom_contacts",
    "top_contacts",
    "impact_speed",
    "rest_fraction",
    "energy_ledger",
    "final_angle",
    "final_angular_velocity",
)
IN_LANES = (*WITHOUT_PERIODS, PoincareSection(periods=4))
# Compression is followed by single trajectories only: it keeps the others out of the lanes.
ALL = (*IN_LANES, "compression_fraction")
