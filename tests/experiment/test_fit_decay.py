"""A free decay gives back the damping, the length and the drag law that made it."""

import json
import math
import sys

import numpy as np
import pytest

from latolato.core.errors import InputError
from latolato.experiment.fits import decay, free_swing
from latolato.experiment.fits.decay import fit_decay
from latolato.experiment.fits.least_squares import ConvergenceError, Data, Guess, solve
from latolato.experiment.fits.result import load_fit
from latolato.experiment.fits.sight import Sight
from latolato.physics.drives import Harmonic
from latolato.physics.pendulum import Pendulum
from track_tables import ARM, PLACE, decay_table, motion_table, noise

SINGLE = {"length": 0.3630, "mass": 0.10804, "damping": 0.00274}
COUPLED = {"length": 0.2450, "mass": 0.10644, "damping": 0.00506}


@pytest.mark.parametrize("body", [SINGLE, COUPLED], ids=["single", "coupled"])
def test_the_papers_decays_give_the_papers_damping(body):
    errors = {"damping": [], "damping_envelope": [], "length": []}
    for seed in range(3):
        table = decay_table(**body, seed=seed)
        fit = fit_decay(table, mass=body["mass"], compare=False, profile=False)
        for name in errors:
            truth = body[name.removesuffix("_envelope")]
            assert abs(fit[name].value - truth) < 4.0 * fit[name].sigma
            errors[name].append(abs(fit[name].value / truth - 1.0))
    assert np.median(errors["damping"]) < 0.015
    assert np.median(errors["damping_envelope"]) < 0.04
    assert np.median(errors["length"]) < 0.003


def test_the_truth_lies_within_two_sigma_as_often_as_it_should():
    misses = []
    for seed in range(24):
        noise = {"seed": seed, "correlation": (0.0, 0.8)[seed % 2]}
        table = decay_table(**SINGLE, **noise, angle=0.3 + 0.03 * seed, duration=8.0)
        fit = fit_decay(table, mass=SINGLE["mass"], method="equation", compare=False, profile=False)
        pair = ("damping", "length")
        misses += [(fit[name].value - SINGLE[name]) / fit[name].sigma for name in pair]
    # 48 numbers: 95 percent and 68 percent within three deviations of the binomial.
    assert np.mean(np.abs(misses) < 2.0) > 0.85
    assert 0.47 < np.mean(np.abs(misses) < 1.0) < 0.89


def test_a_pivot_seen_aside_is_within_the_deviations():
    misses = []
    for seed in range(10):
        aside = np.random.default_rng(seed).normal(scale=PLACE, size=2)
        table = decay_table(
            **SINGLE,
            seed=seed,
            angle=0.4 + 0.04 * seed,
            size=1.2e-4,
            pivot_error=aside,
            duration=10.0,
        )
        fit = fit_decay(table, mass=SINGLE["mass"], compare=False, profile=False)
        for name in ("damping", "damping_envelope", "length"):
            truth = SINGLE[name.removesuffix("_envelope")]
            misses.append((fit[name].value - truth) / fit[name].sigma)
    # Without the pivot's error the lengths alone miss by ten deviations.
    assert np.mean(np.abs(misses) < 2.0) >= 0.85


def test_where_the_pivot_is_comes_out_of_a_wide_swing_and_the_profile_knows_of_it():
    table = decay_table(**SINGLE, angle=1.0, size=1.2e-4, pivot_error=(0.2, -0.3))
    fit = fit_decay(table, mass=SINGLE["mass"], compare=False)
    for name, pixels in (("pivot_error_x", 0.2), ("pivot_error_y", -0.3)):
        place = fit[name]
        assert place.unit == "m"
        assert abs(place.value - pixels * SINGLE["length"] / ARM) < 3.0 * place.sigma
        assert place.sigma < 0.1 * SINGLE["length"] / ARM
    assert fit["length"].low < SINGLE["length"] < fit["length"].high
    assert fit["damping"].low < SINGLE["damping"] < fit["damping"].high


def test_a_table_without_pixels_has_no_error_of_its_pivot():
    table = decay_table(**SINGLE, duration=6.0)
    fit = fit_decay(table, mass=0.1, compare=False, profile=False)
    assert "pivot_error_x" not in fit
    scaled = table.copy()
    scaled.attrs["metres_per_pixel"] = 1e-3
    assert "pivot_error_x" in fit_decay(scaled, mass=0.1, compare=False, profile=False)


def test_angles_are_seen_about_the_pivot_of_the_table():
    angles = np.array([-7.0, -1.0, 0.0, 0.3, 2.9, 9.0])
    error = {"pivot_error_x": 0.02, "pivot_error_y": -0.03, "angle_offset": 0.1}
    sight = Sight(np.ones(6), 1.0)
    result = sight.seen(angles, error) - 0.1 - math.atan2(0.02, 0.97)
    direct = np.arctan2(np.sin(angles) - 0.02, np.cos(angles) - 0.03)
    assert np.remainder(result - direct + 1.0, 2.0 * np.pi) == pytest.approx(np.ones(6))
    assert np.abs(result - angles).max() < 0.05  # turns are kept
    assert sight.seen(np.zeros(6), {**error, "smear_error_x": 0.0}) == pytest.approx(0.1)
    moving = Sight(np.array([0.0, 0.5, 1.0]), 1.0).seen(
        np.zeros(3), error | {"smear_error_x": 0.01}
    )
    assert moving - 0.1 == pytest.approx([0.0, -0.005, -0.01], rel=0.05)


def test_what_samples_do_not_tell_keeps_its_prior():
    data = Data(np.arange(50.0), noise(50, 1), np.full(50, 1e-3), np.zeros(50, dtype=np.int64))
    guesses = {
        "level": Guess(0.1),
        "unseen": Guess(0.3, prior=0.02),
        "half": Guess(0.0, prior=2e-4),
    }
    result = solve(lambda p: np.full(50, p["level"] + p["half"]) + 0.0 * p["unseen"], guesses, data)
    assert result.values["unseen"] == pytest.approx(0.0, abs=1e-6)
    assert result.sigma("unseen") == pytest.approx(0.02, rel=1e-3)
    alone = solve(lambda p: np.full(50, p["level"]), {"level": Guess(0.1)}, data)
    assert result.sigma("level") == pytest.approx(math.hypot(alone.sigma("level"), 2e-4), rel=0.05)


def test_correlated_noise_widens_what_it_should():
    wide, plain = (
        fit_decay(
            decay_table(**SINGLE, correlation=correlation), mass=1.0, compare=False, profile=False
        )
        for correlation in (0.8, 0.0)
    )
    assert wide.dataset.attrs["autocorrelation"] == pytest.approx(0.8, abs=0.1)
    assert plain.dataset.attrs["autocorrelation"] < 0.1
    assert wide["decay_rate"].sigma > 1.5 * plain["decay_rate"].sigma


def test_a_held_ball_flagged_samples_and_outliers_are_left_out():
    table = decay_table(**SINGLE, held=1.5)
    table["angle_1"].values[300:330] += 0.3
    table["flag_1"].values[300:330] = "occluded"
    table["angle_1"].values[[400, 500]] += 0.2
    table["angle_1"].values[450:460] = np.nan
    fit = fit_decay(table, mass=SINGLE["mass"], compare=False, profile=False)
    assert 1.5 < fit.dataset.attrs["start"] < 2.2
    assert fit.dataset.attrs["outliers"] == 2
    assert fit["damping"].value == pytest.approx(SINGLE["damping"], rel=0.01)
    assert "2 outliers were left out" in fit.verdict


def test_the_drag_law_is_identified():
    body = {"length": 0.36, "mass": 0.1}
    cases = {
        "linear": {"damping": 0.003},
        "quadratic": {"quadratic_damping": 0.002},
        "linear+coulomb": {"damping": 0.003, "coulomb_damping": 0.001},
    }
    for law, drags in cases.items():
        table = decay_table(**body, **drags, angle=0.8, duration=12.0)
        fit = fit_decay(table, mass=0.1, law="best", method="equation", profile=False)
        assert fit.dataset.attrs["law"] == law
        for name, value in drags.items():
            assert fit[name].value == pytest.approx(value, rel=0.1)
        assert f"{law[0].upper()}{law[1:]} drag describes this decay best" in fit.verdict


def test_laws_are_compared_also_where_a_start_leads_astray():
    # Quadratic and Coulomb drag alone, started without either, never come back.
    table = decay_table(**COUPLED, angle=0.61, duration=16.0, seed=0)
    fit = fit_decay(table, mass=COUPLED["mass"], method="equation", profile=False)
    assert "quadratic or coulomb drag alone is excluded" in fit.verdict
    assert fit["damping"].value == pytest.approx(COUPLED["damping"], rel=0.002)


def test_indistinguishable_laws_leave_the_numbers_of_linear_drag():
    # As of a film of nine seconds: the terms of the fullest law take each other's place.
    table = decay_table(
        **SINGLE, duration=9.0, fps=30.0, size=2e-4, pivot_error=(0.05, -0.05), seed=1
    )
    fit = fit_decay(table, mass=SINGLE["mass"], profile=False)
    assert fit["damping"].value == pytest.approx(SINGLE["damping"], rel=0.01)
    assert fit.dataset.attrs["law"] == "linear"
    assert "cannot be told apart" in fit.verdict or "linear drag describes" in fit.verdict.lower()
    assert "Do not trust" not in fit.verdict


def refusing(monkeypatch, *laws):
    """Let the fits of these laws end without having converged."""
    real = free_swing.fit_equation

    def fit(data, first, terms, aside, **options):
        if any(decay.LAWS[law] == tuple(terms) for law in laws):
            raise ConvergenceError("the fit did not converge")
        return real(data, first, terms, aside, **options)

    for module in (decay, free_swing):
        monkeypatch.setattr(module, "fit_equation", fit)


@pytest.mark.parametrize("compare", [True, False])
def test_a_law_that_does_not_converge_falls_back_to_a_part_of_it(monkeypatch, compare):
    refusing(monkeypatch, "linear+quadratic+coulomb", "linear+coulomb")
    table = decay_table(**SINGLE, duration=8.0)
    fit = fit_decay(
        table, mass=SINGLE["mass"], law="linear+coulomb", compare=compare, profile=False
    )
    assert fit.dataset.attrs["law"] == "linear"
    assert "coulomb_damping" not in fit
    assert fit["damping"].value == pytest.approx(SINGLE["damping"], rel=0.01)
    assert (
        "The fit with linear+coulomb drag did not converge: these are the numbers for linear drag."
        in fit.verdict
    )
    lost = "linear+coulomb, linear+quadratic+coulomb are not compared: their fits did not converge"
    assert (lost in fit.verdict) == compare


def test_a_fit_that_does_not_converge_at_all_says_so_and_blames_no_unit(monkeypatch):
    table = decay_table(**SINGLE, duration=8.0)
    with monkeypatch.context() as patch:
        refusing(patch, *decay.LAWS)
        with pytest.raises(ConvergenceError, match="did not converge"):
            fit_decay(table, mass=SINGLE["mass"], law="best", profile=False)
    data = Data(np.arange(50.0), noise(50, 1), np.full(50, 1e-3), np.zeros(50, dtype=np.int64))
    with pytest.raises(ConvergenceError) as caught:
        solve(lambda p: np.full(50, p["a"] + p["b"]), {"a": Guess(3.0), "b": Guess(5.0)}, data,
              limit=3)  # fmt: skip
    assert str(caught.value) == (
        "the fit of a and b did not converge in 3 trials; fit fewer parameters, or use another part"
    )


def test_a_solution_that_follows_next_to_no_sample_is_refused():
    # Of most samples the model knows nothing: all that lie 5 rad from it would be outliers.
    first, second = np.eye(50)[:2]
    data = Data(np.arange(50.0), 5.0 + noise(50, 1), np.full(50, 1e-3), np.zeros(50, dtype=int))
    with pytest.raises(ConvergenceError, match="the fit of a and b follows only 2 of 50 samples"):
        solve(lambda p: p["a"] * first + p["b"] * second, {"a": Guess(3.0), "b": Guess(4.0)}, data)


def test_gravity_may_be_tilted_and_the_swing_large():
    table = decay_table(length=0.3, mass=0.1, damping=0.004, angle=2.4)
    table["angle_1"].values[:] += 0.02
    fit = fit_decay(table, mass=0.1, compare=False)
    assert fit["angle_offset"].value == pytest.approx(0.02, abs=3e-4)
    assert fit["damping"].value == pytest.approx(0.004, rel=0.003)
    assert fit["damping_envelope"].value == pytest.approx(0.004, rel=0.01)
    assert fit["damping"].low < fit["damping"].value < fit["damping"].high


def test_the_piece_between_start_and_end_alone_must_have_a_pivot_at_rest():
    table = decay_table(**SINGLE, duration=12.0)
    time = table.time.values
    table["pivot_y"].values[:] = np.where(time < 3.0, 0.02 * np.cos(12.0 * time), 0.0)
    with pytest.raises(ValueError, match="set start and end to a part where it is at rest"):
        fit_decay(table)
    fit = fit_decay(table, mass=SINGLE["mass"], start=3.5, compare=False, profile=False)
    assert fit["damping"].value == pytest.approx(SINGLE["damping"], rel=0.01)


def test_a_wrong_declared_length_gives_a_warning():
    table = decay_table(**SINGLE, duration=6.0)
    fit = fit_decay(table, length=0.40, mass=0.1, compare=False, profile=False)
    assert "declared length 0.4 m is" in fit.verdict
    assert fit["length"].value == pytest.approx(0.363, rel=1e-3)


def test_a_fit_is_the_same_after_writing_and_json(tmp_path):
    table = decay_table(**SINGLE, duration=6.0)
    fit = fit_decay(table, mass=0.1, radius=0.02, compare=False, profile=False)
    again = load_fit(fit.save(tmp_path / "fit.nc"))
    assert again.to_dict() == fit.to_dict()
    stored = json.loads(json.dumps(fit.to_dict()))
    assert stored["values"]["damping"]["units"] == "kg*m/s"
    assert fit["centre_length"].value == pytest.approx(0.363 - 0.4 * 0.02**2 / 0.363, rel=1e-3)
    assert str(fit["damping"]).endswith("kg m/s")
    for variable in fit.dataset.variables.values():
        assert {"units", "long_name", "symbol"} <= variable.attrs.keys()
    with pytest.raises(KeyError, match="the fit has no 'dampng'"):
        fit["dampng"]


def test_without_a_mass_there_is_a_rate_but_no_coefficient():
    table = decay_table(**SINGLE, duration=8.0)
    fit = fit_decay(table, compare=False, profile=False)
    assert "damping" not in fit
    assert fit["decay_rate"].value == pytest.approx(0.0349325, rel=0.01)


@pytest.mark.parametrize(
    "options, said",
    [
        ({"ball": 2}, "ball must be 1"),
        ({"method": "guess"}, "method must be '"),
        ({"law": "cubic"}, "unknown drag law 'cubic'"),
        ({"law": "coulomb", "method": "envelope"}, "linear drag"),
        ({"mass": -1.0}, "mass must"),
        ({"start": 99.0}, "the table goes from 0 to"),
    ],
)
def test_bad_options_are_refused(options, said):
    with pytest.raises(ValueError, match=said):
        fit_decay(decay_table(**SINGLE, duration=3.0), **options)


def test_what_is_no_free_decay_is_refused():
    table = decay_table(**SINGLE, duration=5.0)
    driven = table.copy(deep=True)
    driven["pivot_y"].values[:] = 0.02 * np.cos(12.0 * table.time.values)
    with pytest.raises(ValueError, match="the pivot moves by 20 mm"):
        fit_decay(driven)
    pumped = motion_table(
        Pendulum(**SINGLE), Harmonic(drive_amplitude=0.02, drive_frequency=10.09),
        initial_angle=0.7, duration=4.0,
    )  # fmt: skip
    with pytest.raises(ValueError, match="the pivot moves by"):
        fit_decay(pumped, length=0.363)
    still = table.copy(deep=True)
    still["angle_1"].values[:] = 1e-3 * np.sin(1000.0 * table.time.values**2)
    with pytest.raises(ValueError, match="swing"):
        fit_decay(still)
    degrees = table.copy(deep=True)
    degrees["angle_1"].values[:] *= 180.0 / np.pi
    with pytest.raises(ValueError, match="more than half a turn"):
        fit_decay(degrees)
    lost = table.copy(deep=True)
    lost["flag_1"].values[:] = "lost"
    with pytest.raises(ValueError, match="0 samples flagged ok"):
        fit_decay(lost)


def test_a_missing_lmfit_is_named_with_its_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "lmfit", None)
    with pytest.raises(InputError, match=r'the package .lmfit.*pip install "\.\[video\]"'):
        fit_decay(decay_table(**SINGLE, duration=3.0))


def test_the_envelope_is_exact_for_large_swings():
    from latolato.experiment.fits.swings import amplitude_of, effective_amplitude

    sizes = np.array([1e-3, 0.5, 1.5, 2.8])
    assert amplitude_of(effective_amplitude(sizes)) == pytest.approx(sizes, rel=1e-4)
    assert effective_amplitude(np.array([1e-2])) == pytest.approx(1e-2, rel=1e-4)
    # The action of a small swing is A^2 (1 - 5 A^2/96), and this its root.
    assert effective_amplitude(np.array([0.2]))[0] / 0.2 - 1.0 == pytest.approx(
        -5.0 * 0.2**2 / 192.0, rel=0.05
    )
    assert math.isclose(effective_amplitude(np.array([0.0]))[0], 0.0)
