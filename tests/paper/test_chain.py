"""Figures through the chain: a filmed clip gives what a sampled one gives, and says so."""

import numpy as np
import pytest

import latolato as ll
from latolato.paper import chain, chain_trials
from latolato.paper import systems as paper

PAIR = chain.Clip(
    system=paper.COUPLED,
    drive=ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.4 * paper.COUPLED.natural_frequency),
    start=(("initial_offset", 0.3),),
    duration=2.5,
    fps=60.0,
    size=(480, 360),
)


@pytest.fixture(scope="module")
def tables():
    return chain.film(PAIR), chain.sample(PAIR)


def test_a_filmed_pair_is_tracked_as_it_moves(tables):
    filmed, _ = tables
    assert filmed.attrs["rms_error"] < 2e-3
    for ball in (1, 2):
        assert np.mean(filmed[f"flag_{ball}"].values == "ok") > 0.8


def test_a_filmed_trial_is_the_row_of_a_sampled_one(tables):
    trials = chain_trials.gather([PAIR, PAIR], by_video=[0], transient=1.0)
    assert sorted(trials.source.values) == ["simulated", "synthetic video"]
    for name, tolerance in (
        ("drive_amplitude", 1.2e-4),
        ("drive_frequency", 1e-2),
        ("largest_angle", 3e-3),
        ("largest_angle_after_transient", 6e-3),
    ):
        assert float(np.ptp(trials[name].values)) < tolerance, name
    assert len(set(trials["class"].values)) == 1


def test_a_filmed_pair_is_compared_with_its_own_motion(tables):
    comparison = ll.compare(tables[0], paper.COUPLED, draws=2)
    assert float(comparison.residual_rms) < 5e-3


def test_a_still_is_a_small_picture_in_8_bits():
    dims, colours, about = chain.still_of(PAIR)
    assert dims == ("row", "column", "rgb")
    assert colours.dtype == np.uint8
    assert max(colours.shape) <= 320
    assert "video" in about["long_name"]
    # The wall is light, and something is painted on it.
    assert np.median(colours) > 180
    assert colours.min() < 80
