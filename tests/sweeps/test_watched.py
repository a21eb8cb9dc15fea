"""How much motion sweeps have computed, told while they do."""

import latolato as ll
from latolato.sweeps.watched import watched

BALL = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)


def _sweep(duration, chunk_size=None):
    axes = {"initial_angle": [0.1, 0.2, 0.3, 0.4]}
    ll.sweep(BALL, axes=axes, duration=duration, observables=["largest_angle"],
             chunk_size=chunk_size)  # fmt: skip


def test_motion_of_all_sweeps_in_a_block_adds_up_chunk_by_chunk():
    told = []
    with watched(told.append):
        _sweep(2.0, chunk_size=2)
        _sweep(3.0)
    assert told == [4.0, 8.0, 20.0]


def test_nothing_is_told_outside_of_the_block():
    told = []
    with watched(told.append):
        pass
    _sweep(1.0)
    assert told == []
