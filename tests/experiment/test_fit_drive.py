"""A pivot's track gives back the drive that moved it."""

import numpy as np
import pytest

import latolato as ll
from latolato.experiment.fits.drive import fit_drive
from track_tables import drive_table

STEADY = ll.Harmonic(drive_amplitude=0.03, drive_frequency=10.09, drive_phase=1.0)
STEP = ll.FrequencySchedule(
    drive_amplitude=0.03, times=[0.0, 14.166], drive_frequencies=[19.83, 15.11]
)


@pytest.mark.parametrize("correlation", [0.0, 0.7])
def test_a_steady_drive_is_found_within_its_sigma(correlation):
    misses = []
    for seed in range(12):
        table = drive_table(STEADY, seed=seed, correlation=correlation, duration=20.0)
        fit = fit_drive(table, profile=False)
        assert isinstance(fit.drive, ll.Harmonic)
        for name in ("drive_amplitude", "drive_frequency", "drive_phase"):
            truth = getattr(STEADY, name)
            misses.append((fit[name].value - truth) / fit[name].sigma)
            assert fit[name].value == pytest.approx(truth, rel=4e-3)
        assert fit.drive.drive_frequency == pytest.approx(10.09, rel=1e-4)
        assert "It is steady." in fit.verdict
        assert "leaves out that of the scale" in fit.verdict
    assert np.mean(np.abs(misses) < 2.0) > 0.85
    assert 0.47 < np.mean(np.abs(misses) < 1.0) < 0.89


@pytest.mark.parametrize("guide", ["below", "above"])
def test_the_second_harmonic_tells_a_crank_and_its_guide(guide):
    crank = ll.CrankSlider(
        drive_amplitude=0.03, drive_frequency=12.0, connecting_rod_length=0.3, guide=guide
    )
    fit = fit_drive(drive_table(crank))
    sign = 1.0 if guide == "above" else -1.0
    ratio = fit["crank_ratio"]
    assert abs(ratio.value - 0.1 * sign) < 4.0 * ratio.sigma
    assert fit.drive.guide == guide
    assert fit.drive.connecting_rod_length == pytest.approx(0.3, rel=0.05)
    assert f"guide {guide}" in fit.verdict
    amplitude = fit.dataset.harmonic_amplitude.sel(harmonic=2).item()
    assert amplitude == pytest.approx(0.03 * 0.1 / 4.0, rel=0.05)


@pytest.mark.parametrize("ramp", [0.0, 1.5])
def test_a_step_is_found_with_both_frequencies_and_its_time(ramp):
    drive = ll.FrequencySchedule(
        drive_amplitude=0.03, times=STEP.times, drive_frequencies=STEP.drive_frequencies, ramp=ramp
    )
    fit = fit_drive(drive_table(drive, correlation=0.5))
    assert fit["drive_frequency"].value == pytest.approx(19.83, rel=5e-4)
    assert fit["drive_frequency_final"].value == pytest.approx(15.11, rel=5e-4)
    assert fit["step_time"].value == pytest.approx(14.166, abs=0.05)
    assert isinstance(fit.drive, ll.FrequencySchedule)
    assert fit.drive.ramp == pytest.approx(ramp, abs=0.05)
    assert fit.dataset.attrs["stages"] == 2


def test_two_steps_are_found_and_the_number_of_stages_may_be_set():
    drive = ll.FrequencySchedule(
        drive_amplitude=0.03, times=[0.0, 8.0, 20.0], drive_frequencies=[19.83, 15.11, 15.5]
    )
    fit = fit_drive(drive_table(drive))
    assert fit.dataset.drive_frequencies.values == pytest.approx([19.83, 15.11, 15.5], rel=5e-4)
    assert fit.dataset.stage_start.values == pytest.approx([0.0, 8.0, 20.0], abs=0.05)
    assert fit_drive(drive_table(STEADY), stages=1).dataset.attrs["stages"] == 1


def test_a_drifting_frequency_is_reported_and_is_no_step():
    chirp = ll.Chirp(
        drive_amplitude=0.03, drive_frequency=10.0, drive_frequency_final=10.5, sweep_time=30.0
    )
    fit = fit_drive(drive_table(chirp))
    assert "not steady" in fit.verdict
    assert fit["frequency_drift"].value == pytest.approx(0.5 / 30.0, rel=0.01)
    assert fit["drive_amplitude"].value == pytest.approx(0.03, rel=4e-3)
    assert isinstance(fit.drive, ll.Chirp)


def test_a_pivot_at_rest_and_too_few_periods_are_refused():
    table = drive_table(ll.Harmonic(drive_amplitude=0.0, drive_frequency=1.0), duration=5.0)
    with pytest.raises(ValueError, match="the pivot is at rest"):
        fit_drive(table)
    with pytest.raises(ValueError, match="at least 3 periods"):
        fit_drive(drive_table(STEADY, duration=1.0))
    with pytest.raises(ValueError, match=r"stages must lie in \[1, 4\]"):
        fit_drive(drive_table(STEADY, duration=5.0), stages=7)
    unknown = drive_table(STEADY, duration=5.0)
    unknown["pivot_y"].values[:] = np.nan
    with pytest.raises(ValueError, match="holds no number"):
        fit_drive(unknown)


@pytest.mark.parametrize("metres_per_pixel,is_crank", [(1e-2, False), (1e-6, True)])
def test_a_crank_is_reported_only_above_a_tenth_of_a_pixel(metres_per_pixel, is_crank):
    crank = ll.CrankSlider(drive_amplitude=0.03, drive_frequency=15.0, connecting_rod_length=0.3)
    table = drive_table(crank, duration=10.0).assign_attrs(metres_per_pixel=metres_per_pixel)
    fit = fit_drive(table, profile=False)
    # The second harmonic is A0^2/(4 L) = 0.75 mm.
    assert ("crank_ratio" in fit.estimates) == is_crank
