"""How laws become trajectories: splitting steps, contact times, compiled kernels."""
