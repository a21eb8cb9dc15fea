"""A sweep on threads can be given up from outside."""

import threading

import numpy as np
import pytest

import latolato as ll
from latolato.sweeps.chunk import Cancelled
from latolato.sweeps.executors.threads import make_cancel, run_cancellable
from latolato.sweeps.plan import make_plan


def long_plan(duration):
    return make_plan(
        ll.LatoLato(length=1.0, mass=0.8, radius=0.1),
        axes={
            "drive_amplitude": np.linspace(0.1, 0.5, 20),
            "frequency_ratio": np.linspace(1.0, 5.0, 20),
        },
        initial_offset=0.2,
        duration=duration,
        observables=["largest_angle"],
        chunk_size=100,
    )


def test_a_flag_set_elsewhere_stops_kernels_in_the_middle_of_a_chunk():
    plan, cancel = long_plan(1e5), make_cancel()  # hours, if nobody stopped it
    timer = threading.Timer(1.0, lambda: cancel.__setitem__(0, 1))
    timer.start()
    with pytest.raises(Cancelled):
        list(run_cancellable(plan, range(plan.chunks), 2, cancel))
    timer.join()


def test_the_flag_serves_once():
    plan, cancel = long_plan(1.0), make_cancel()
    list(run_cancellable(plan, range(plan.chunks), 1, cancel))
    with pytest.raises(Cancelled):
        list(run_cancellable(plan, range(plan.chunks), 1, cancel))
