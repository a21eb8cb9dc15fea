"""What a type checker sees of the package: `make lint` runs mypy on this file, no test does."""

from typing import assert_type

import xarray as xr

import latolato as ll

toy = ll.LatoLato(length=0.245, mass=0.1, radius=0.02)
shake = ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.0)
assert_type(toy, ll.LatoLato)
assert_type(shake, ll.Harmonic)
assert_type(ll.simulate(toy, shake, initial_angle=0.5, duration=1.0), xr.Dataset)
assert_type(ll.analysis.floquet(toy, shake, initial_angle=0.5), xr.Dataset)
assert_type(ll.analysis.undriven_period(length=0.245, initial_angle=0.5), float)

# Each of these is an error to a type checker; a comment that hides none is one itself.
ll.analysis.floquet(toy, shake, initial_angel=0.5)  # type: ignore[call-arg]
ll.analysis.lyapunov_spectrum(toy, shake, duration="long")  # type: ignore[arg-type]
ll.analysis.floquet()  # type: ignore[call-arg]
