"""A pivot's track gives back the drive that moved it."""

import dataclasses

import numpy as np
import pytest

import latolato as ll
from latolato.experiment.fits.drive import fit_drive, with_scale
from latolato.experiment.fits.pivots import pivot_for
from latolato.experiment.fits.result import Estimate
from track_tables import drive_table, noise, planar_table

STEADY = ll.Harmonic(drive_amplitude=0.03, drive_frequency=10.09, drive_phase=1.0)
# Correlations of the noise: where deviations forget the second, they are too small by 2.4.
NOISES = 0.0, 0.7
STEP = ll.FrequencySchedule(
    drive_amplitude=0.03, times=[0.0, 14.166], drive_frequencies=[19.83, 15.11]
)


def test_a_steady_drive_is_found_within_its_sigma():
    misses = []
    for seed in range(12):
        table = drive_table(STEADY, seed=seed, correlation=NOISES[seed % 2], duration=12.0)
        fit = fit_drive(table, profile=False)
        assert isinstance(fit.drive, ll.Harmonic)
        for name in ("drive_amplitude", "drive_frequency", "drive_phase"):
            truth = getattr(STEADY, name)
            misses.append((fit[name].value - truth) / fit[name].sigma)
            assert fit[name].value == pytest.approx(truth, rel=4e-3)
        assert fit.drive.drive_frequency == pytest.approx(10.09, rel=1e-4)
        assert "It is steady." in fit.verdict
        assert "does not include that of the scale" in fit.verdict
    assert np.mean(np.abs(misses) < 2.0) > 0.85
    assert 0.47 < np.mean(np.abs(misses) < 1.0) < 0.89


def test_the_deviation_of_an_amplitude_includes_that_of_the_scale():
    table = drive_table(STEADY, duration=12.0)
    plain = fit_drive(table)
    scale = {"metres_per_pixel": 1e-3, "metres_per_pixel_sigma": 5e-6}
    table.attrs |= {**scale, "scale_source": "length"}
    fit = fit_drive(table)
    amplitude, own = fit["drive_amplitude"], plain["drive_amplitude"].sigma
    assert amplitude.value == plain["drive_amplitude"].value
    assert amplitude.sigma == pytest.approx(np.hypot(own, 5e-3 * amplitude.value))
    widths = [(each.high - each.low) / each.sigma for each in (amplitude, plain["drive_amplitude"])]
    assert widths[0] == pytest.approx(widths[1])
    assert fit["drive_frequency"] == plain["drive_frequency"]
    assert "includes that of the scale (0.5 %)" in fit.verdict
    # Beside a length that made the scale it does not count: an error of it makes both larger.
    system = ll.Pendulum(length=0.2, mass=0.05)
    swinging = table.assign(angle_1=("frame", 0.3 * np.cos(7.0 * table["time"].values)))
    first, last = (float(swinging["time"].values[place]) for place in (0, -1))
    for source, expected in (("length", own), ("stick", amplitude.sigma)):
        swinging.attrs["scale_source"] = source
        sigmas = pivot_for(None, swinging, system.length, first, last).deviations
        assert sigmas["drive_amplitude"] == pytest.approx(expected, rel=0.05)


def test_an_amplitude_near_zero_keeps_an_interval_from_zero_on():
    wide = with_scale(Estimate(1e-3, 8e-4, "m", low=0.0, high=2.6e-3), 0.02)
    assert wide.low == 0.0
    assert wide.high > 2.6e-3


ELLIPSE = ll.PlanarHarmonic(
    vertical_amplitude=0.03, horizontal_amplitude=0.005, drive_frequency=10.09,
    vertical_phase=1.0, horizontal_phase=2.2,
)  # fmt: skip
HORIZONTAL = ("horizontal_amplitude", "horizontal_phase")


def with_across(amplitude):
    """The ellipse with another horizontal amplitude."""
    return dataclasses.replace(ELLIPSE, horizontal_amplitude=amplitude)


def test_both_directions_of_an_ellipse_are_found_within_their_sigma():
    misses = {name: [] for name in HORIZONTAL}
    for seed in range(30):
        drive, correlation = with_across((0.005, 0.03)[seed % 2]), NOISES[seed % 2]
        table = planar_table(drive, seed=seed, correlation=correlation, duration=8.0)
        fit = fit_drive(table, stages=1, profile=False)
        assert isinstance(fit.drive, ll.PlanarHarmonic)
        for name in misses:
            misses[name].append((fit[name].value - getattr(drive, name)) / fit[name].sigma)
            assert getattr(fit.drive, name) == fit[name].value
        assert fit.drive.vertical_amplitude == fit["drive_amplitude"].value
        assert fit.drive.vertical_phase == fit["drive_phase"].value
    assert " rad ahead of the height." in fit.verdict
    for errors in misses.values():
        # Of 30 normal numbers the mean has the deviation 0.18, the root mean square 0.13.
        assert abs(np.mean(errors)) < 0.6
        assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.45


def test_the_horizontal_phase_far_from_time_zero_has_the_frequencys_uncertainty():
    misses = []
    for seed in range(10):
        table = planar_table(with_across(0.03), duration=80.0, seed=seed)
        fit = fit_drive(table, stages=1, start=70.0, profile=False)
        phase = fit["horizontal_phase"]
        misses.append((phase.value - 2.2) / phase.sigma)
        # At 75 s; noise alone gives 2e-4 m/0.03 m sqrt(2/600) = 4e-4 rad.
        assert phase.sigma == pytest.approx(75.0 * fit["drive_frequency"].sigma, rel=0.05)
    # Of 10 normal numbers the root mean square has the deviation 0.22.
    assert 0.5 < np.sqrt(np.mean(np.square(misses))) < 1.55


def test_without_a_horizontal_motion_the_drive_is_harmonic_and_the_fit_says_so():
    seen = 0
    for seed in range(10):
        table = planar_table(with_across(0.0), seed=seed, duration=8.0)
        fit = fit_drive(table, stages=1, profile=False)
        seen += not isinstance(fit.drive, ll.Harmonic)
        assert fit["horizontal_amplitude"].low >= 0.0
        assert "No horizontal motion was detected (0.0" in fit.verdict
        # A phase of nothing may be any.
        assert fit["horizontal_phase"].sigma > 0.25
    assert seen == 0


def test_a_tilt_that_the_table_allows_is_no_horizontal_motion():
    # 0.3 mm in step with 30 mm: the direction of gravity is wrong by 10 mrad.
    drive = dataclasses.replace(with_across(3e-4), horizontal_phase=1.0)
    assert isinstance(fit_drive(planar_table(drive), profile=False).drive, ll.PlanarHarmonic)
    table = planar_table(drive, angle_offset_sigma=5e-3)
    fit = fit_drive(table, profile=False)
    assert isinstance(fit.drive, ll.Harmonic)
    assert fit["horizontal_amplitude"].sigma == pytest.approx(5e-3 * 0.03, rel=0.02)
    # A quarter of a period ahead it is none.
    table = planar_table(with_across(3e-4), angle_offset_sigma=0.0)
    assert isinstance(fit_drive(table, profile=False).drive, ll.PlanarHarmonic)


def test_a_track_that_may_bend_by_a_tenth_of_a_pixel_shows_no_less():
    table = planar_table(with_across(3e-4), metres_per_pixel=1e-2)
    fit = fit_drive(table, profile=False)
    assert isinstance(fit.drive, ll.Harmonic)
    assert fit["horizontal_amplitude"].sigma == pytest.approx(0.25e-3, rel=0.02)


def test_a_stepped_drive_says_what_it_leaves_out():
    table = drive_table(STEP)
    time = table["time"].values
    phase = 19.83 * time - (19.83 - 15.11) * np.maximum(time - 14.166, 0.0)
    table["pivot_x"].values[:] = 0.004 * np.cos(phase - 0.8) + noise(len(time), 5, 0.0, 2e-4)
    fit = fit_drive(table, profile=False)
    assert fit["horizontal_amplitude"].value == pytest.approx(
        0.004, abs=4.0 * fit["horizontal_amplitude"].sigma
    )
    assert fit["horizontal_phase"].value == pytest.approx(-0.8, abs=0.02)
    assert isinstance(fit.drive, ll.FrequencySchedule)
    assert "behind the height, which the drive FrequencySchedule leaves out." in fit.verdict


@pytest.mark.parametrize("values", [0.0, np.nan])
def test_a_table_without_horizontal_positions_has_no_numbers_of_them(values):
    table = planar_table(ELLIPSE)
    table["pivot_x"].values[:] = values
    fit = fit_drive(table, profile=False)
    assert isinstance(fit.drive, ll.Harmonic)
    assert not [name for name in fit.dataset if "horizontal" in name or "across" in name]
    assert "orizontal" not in fit.verdict


def test_samples_without_a_horizontal_position_are_left_out():
    table = planar_table(ELLIPSE)
    table["pivot_x"].values[200:500] = np.nan
    fit = fit_drive(table, profile=False)
    size = fit["horizontal_amplitude"]
    assert size.value == pytest.approx(0.005, abs=4.0 * size.sigma)
    known = np.isfinite(fit.dataset.pivot_across.values)
    assert known.sum() == len(known) - 300
    gaps = (fit.dataset.pivot_across - fit.dataset.pivot_across_fit).values[known]
    assert np.std(gaps) == pytest.approx(2e-4, rel=0.1)


def test_a_fitted_pivot_moves_sideways_only_where_it_may():
    table = planar_table(ELLIPSE)
    both = pivot_for(None, table, 0.3, 0.0, 19.0, across=True)
    assert isinstance(both.drive, ll.PlanarHarmonic)
    varied = [
        {f.name for f in dataclasses.fields(o) if getattr(o, f.name) != getattr(both.drive, f.name)}
        for o, _ in both.others
    ]
    assert {"horizontal_amplitude"} in varied
    assert {"drive_frequency", "vertical_phase", "horizontal_phase"} in varied
    one = pivot_for(None, table, 0.3, 0.0, 19.0)
    assert isinstance(one.drive, ll.Harmonic)
    assert one.words == "the pivot's fitted drive without its horizontal part"


def test_a_spline_of_the_track_follows_both_directions_where_it_may():
    table = planar_table(with_across(0.02))
    both = pivot_for("measured", table, 0.3, 0.0, 19.0, across=True).drive
    assert both.moves_across
    assert both.across_sigma == pytest.approx(2e-4, rel=0.1)
    assert not pivot_for("measured", table, 0.3, 0.0, 19.0).drive.moves_across
    still = planar_table(with_across(0.0))
    assert not pivot_for("measured", still, 0.3, 0.0, 19.0, across=True).drive.moves_across
    # A swing at another frequency, in step with nothing, and one that no cosine describes.
    time = table["time"].values
    for swing in (
        0.01 * np.cos(5.0 * time),
        0.005 * np.cos(10.09 * time) + 2e-3 * np.cos(7.0 * time),
    ):
        other = planar_table(with_across(0.0)).copy(deep=True)
        other["pivot_x"].values[:] += swing
        assert isinstance(
            pivot_for(None, other, 0.3, 0.0, 19.0, across=True).drive, ll.MeasuredPivot
        )
        assert isinstance(pivot_for(None, other, 0.3, 0.0, 19.0).drive, ll.Harmonic)
    # A crank has no horizontal part.
    crank = ll.CrankSlider(drive_amplitude=0.03, drive_frequency=12.0, connecting_rod_length=0.3)
    other = drive_table(crank, duration=20.0)
    other["pivot_x"].values[:] = 0.01 * np.cos(12.0 * time) + noise(len(time), 5, 0.0, 2e-4)
    assert isinstance(pivot_for(None, other, 0.3, 0.0, 19.0, across=True).drive, ll.MeasuredPivot)
    assert isinstance(pivot_for(None, other, 0.3, 0.0, 19.0).drive, ll.CrankSlider)
    aside = planar_table(dataclasses.replace(with_across(0.02), vertical_amplitude=0.0))
    assert pivot_for(None, aside, 0.3, 0.0, 19.0, across=True).drive.moves_across


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
    table["pivot_y"].values[:] = 0.0
    with pytest.raises(ValueError, match=r"at rest: its height is the same in all frames$"):
        fit_drive(table)
    with pytest.raises(ValueError, match="at least 3 periods"):
        fit_drive(drive_table(STEADY, duration=1.0))
    with pytest.raises(ValueError, match=r"stages must lie in \[1, 4\]"):
        fit_drive(drive_table(STEADY, duration=5.0), stages=7)
    unknown = drive_table(STEADY, duration=5.0)
    unknown["pivot_y"].values[:] = np.nan
    with pytest.raises(ValueError, match="holds no numbers"):
        fit_drive(unknown)


def test_a_pivot_that_moves_sideways_only_is_not_at_rest():
    aside = planar_table(dataclasses.replace(with_across(0.02), vertical_amplitude=0.0))
    for noiseless in (False, True):
        if noiseless:
            aside["pivot_y"].values[:] = 0.0
        with pytest.raises(ValueError, match=r"only sideways, by 20 mm .*; use fit_model"):
            fit_drive(aside)
    # What the track scatters sideways is no motion.
    still = planar_table(dataclasses.replace(with_across(0.0), vertical_amplitude=0.0))
    with pytest.raises(ValueError, match="the pivot is at rest"):
        fit_drive(still)


@pytest.mark.parametrize("metres_per_pixel,is_crank", [(1e-2, False), (1e-6, True)])
def test_a_crank_is_reported_only_above_a_tenth_of_a_pixel(metres_per_pixel, is_crank):
    crank = ll.CrankSlider(drive_amplitude=0.03, drive_frequency=15.0, connecting_rod_length=0.3)
    table = drive_table(crank, duration=10.0).assign_attrs(metres_per_pixel=metres_per_pixel)
    fit = fit_drive(table, profile=False)
    # The second harmonic is A0^2/(4 L) = 0.75 mm.
    assert ("crank_ratio" in fit.estimates) == is_crank
