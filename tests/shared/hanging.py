"""Stability of a pendulum that hangs under a cosine, as plain numbers."""

import warnings

import numpy as np

import latolato as ll


def pendulum(*, length=1.0, mass=1.0, damping=0.0, gravity=9.8):
    return ll.Pendulum(length=length, mass=mass, damping=damping, gravity=gravity)


def growth_rate(*, drive_amplitude, drive_frequency, **body):
    """Growth rates at each of some drives [1/s]."""
    amplitudes, frequencies = np.broadcast_arrays(drive_amplitude, drive_frequency)
    rates = [
        ll.analysis.growth_rate(
            pendulum(**body), ll.Harmonic(drive_amplitude=a, drive_frequency=w)
        ).growth_rate
        for a, w in zip(amplitudes.flat, frequencies.flat, strict=True)
    ]
    return np.reshape(rates, amplitudes.shape)


def tongue_edges(*, drive_amplitude, order=1, **body):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # NaN says that it is closed
        found = ll.analysis.tongue_edges(
            pendulum(**body), drive_amplitude=drive_amplitude, order=order
        )
    return float(found.low), float(found.high)


def threshold_amplitude(*, frequency_ratio=2.0, largest_amplitude_ratio=1.0, **body):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # NaN says that there is none
        found = ll.analysis.threshold_amplitude(
            pendulum(**body),
            frequency_ratio=frequency_ratio,
            largest_amplitude_ratio=largest_amplitude_ratio,
        )
    return float(found.drive_amplitude)
