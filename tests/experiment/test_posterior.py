"""Draws of unknown parameters: their density, what they cover, and what is said of them."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import latolato as ll
from latolato.cli.main import main
from latolato.core.errors import InputError
from latolato.experiment.fits import posterior
from latolato.experiment.fits.model import described
from latolato.experiment.fits.posterior import Density, _Scales, fit_posterior
from latolato.experiment.fits.result import Fit, load_fit
from latolato.experiment.track_table import write_table
from latolato.physics.pendulum import systems
from track_tables import motion_table

SWING = ll.Pendulum(length=0.363, mass=0.108, damping=0.00274)
TOY = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.02, restitution=0.9)
BALL = ll.Ball(length=0.245, mass=0.106, damping=0.005, radius=0.02)
PAIR = ll.BallPair(right=BALL, left=replace(BALL, length=0.25), restitution=0.9)
SLOW = ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.09)
FAST = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.1)
ALL = {"ball": None, "start": None, "end": None, "window": None}


def differences(density, q):
    """Central differences of the density."""
    steps = 1e-4 * np.eye(len(q))
    return np.array([(density(q + e)[0] - density(q - e)[0]) / 2e-4 for e in steps])


CASES = {
    "swing": (SWING, None, {"initial_angle": 0.7}, ["length", "damping", "angle_offset"]),
    "tracked": (SWING, None, {"initial_angle": 0.7, "pivot_error": (0.1, 0.1)}, None),
    "driven": (SWING, "measured", {"initial_angle": 0.3, "drive": SLOW}, None),
    "fitted": (SWING, None, {"initial_angle": 0.3, "drive": SLOW}, None),
    "amplitude": (SWING, SLOW, {"initial_angle": 0.3, "drive": SLOW}, ["drive_amplitude"]),
    "toy": (TOY, FAST, {"initial_angle": 0.5, "drive": FAST}, None),
    "pair": (PAIR, FAST, {"initial_angle": (0.5, -0.3), "drive": FAST}, ["restitution"]),
}


@pytest.mark.parametrize("case", CASES)
def test_the_gradient_is_that_of_the_density(case):
    system, drive, made, unknown = CASES[case]
    table = motion_table(system, duration=4.0, correlation=0.5, **made)
    prior = {"length": 1e-3} if unknown is None or "length" in unknown else None
    if isinstance(system, ll.BallPair):
        prior = None
    density = Density(described(table, system, drive, unknown, prior=prior, fits_pivot=True, **ALL))
    for seed in range(3):
        q = np.random.default_rng(seed).normal(size=len(density.names))
        value, gradient = density(q)
        assert math.isfinite(value)
        usual = 2e-3 * max(1.0, float(np.max(np.abs(gradient))))
        np.testing.assert_allclose(gradient, differences(density, q), atol=usual)
        # The solution is near the top, and the numbers are scaled to be like one another there.
        assert float(gradient @ gradient) < 100.0 * len(q)


def test_numbers_without_bounds_stand_for_all_in_a_range():
    low, high = np.array([0.0, 0.0, -math.inf]), np.array([math.inf, 1.0, math.inf])
    scales = _Scales(low, high)
    for u in (-30.0, -2.0, 0.3, 4.0):
        values, slopes, logs, slopes_of_logs = scales.inside(np.full(3, u))
        above, below = (scales.inside(np.full(3, u + e)) for e in (1e-5, -1e-5))
        assert ((low <= values) & (values <= high)).all()
        assert slopes == pytest.approx((above[0] - below[0]) / 2e-5, rel=1e-4, abs=1e-9)
        assert logs == pytest.approx(np.log(slopes), abs=1e-9)
        assert slopes_of_logs == pytest.approx((above[2] - below[2]) / 2e-5, abs=1e-4)
        again, widths = scales.outside(values, 1e-20 * slopes)
        assert again == pytest.approx(np.full(3, u), rel=1e-6)
        assert widths == pytest.approx([1e-20, 1e-20, 1e-20 * slopes[2]])
    at, widths = scales.outside(np.array([0.0, 1.0, 0.0]), np.full(3, 0.1))
    assert scales.inside(at)[0] == pytest.approx([0.05, 0.95, 0.0])
    assert (widths <= 1.0).all()


@pytest.fixture(scope="module")
def swing():
    return motion_table(SWING, initial_angle=0.7, duration=4.0)


@pytest.fixture(scope="module")
def found(swing):
    return fit_posterior(swing, replace(SWING, length=0.36, damping=0.003), draws=300)


def test_the_draws_agree_with_least_squares_where_these_are_right(swing, found):
    fit = ll.fit_model(swing, SWING)
    for name, truth in (("length", 0.363), ("damping", 0.00274)):
        assert abs(found[name].value - truth) < 4.0 * found[name].sigma
        assert abs(found[name].value - fit[name].value) < 0.3 * fit[name].sigma
        assert found[name].sigma == pytest.approx(fit[name].sigma, rel=0.25)
        assert found[name].low < fit[name].value < found[name].high
    assert found.describes
    assert "4 chains of 300 draws, which agree (R-hat 1.0" in found.verdict
    assert found.dataset.attrs["band_share"] == pytest.approx(0.95, abs=0.03)
    scale = found.dataset["nuisance_draw"].sel(nuisance="noise_scale")
    assert float(scale.mean()) == pytest.approx(1.0, abs=0.15)


def test_a_seed_gives_the_same_draws(swing, monkeypatch):
    monkeypatch.setattr(posterior, "_LEARNING", 20)
    one, same, other = (
        fit_posterior(swing, SWING, unknown=["length"], draws=20, chains=2, seed=seed).draws
        for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one["length"], same["length"])
    assert not np.array_equal(one["length"], other["length"])


@pytest.fixture
def quick(monkeypatch):
    """Draws of a normal density about least squares, in which a test may spoil something."""

    def replace_draws(spoil=lambda values, broken, names: None):
        def drawn(density, draws, chains, seed):
            q = np.random.default_rng(seed).normal(size=(chains, draws, len(density.names)))
            values = np.apply_along_axis(density.values, -1, q)
            broken = np.zeros(values.shape[:2], dtype=bool)
            spoil(values, broken, density.names)
            return values, broken

        monkeypatch.setattr(posterior, "sampled", drawn)

    return replace_draws


def test_few_draws_and_chains_that_disagree_are_no_result(swing, quick):
    quick()
    assert fit_posterior(swing, SWING).describes
    few = fit_posterior(swing, SWING, draws=40)
    assert not few.describes
    assert few.dataset.attrs["break"] in ("chains", "draws")
    assert few.verdict.endswith("Its values are kept for inspection.")

    def apart(values, broken, names):
        values[0, :, names.index("length")] += 2.0 * values[..., names.index("length")].std()

    quick(apart)
    off = fit_posterior(swing, SWING)
    assert "The chains do not agree" in off.verdict
    assert "for length" in off.doubt

    def alike(values, broken, names):
        values[:] = np.repeat(values[:, ::40], 40, axis=1)

    quick(alike)
    slow = fit_posterior(swing, SWING, draws=2000)
    assert "The draws are too few" in slow.verdict or "do not agree" in slow.verdict

    def lost(values, broken, names):
        broken[:, ::20] = True

    quick(lost)
    assert "lost its way on 5 % of its paths" in fit_posterior(swing, SWING).verdict


def test_what_is_known_beforehand_narrows_what_samples_leave_open(swing, quick):
    # Gravity and length act only by their ratio, and by the damping over the length: a known one
    # would tell them apart.
    quick()
    unknown = ["gravity", "length", "damping"]
    got = fit_posterior(swing, SWING, unknown=unknown, prior={"length": 2e-3})
    assert got.describes
    assert got["length"].sigma == pytest.approx(2e-3, rel=0.15)
    assert got["gravity"].sigma == pytest.approx(9.8 * 2e-3 / 0.363, rel=0.15)
    draws = got.draws
    ratio = (draws["gravity"] / draws["length"]).values
    assert ratio.std() / ratio.mean() < 1e-4
    assert abs(ratio.mean() - 9.8 / 0.363) < 5.0 * ratio.std()


def test_samples_that_contradict_a_prior_are_not_sampled(swing):
    # A tight one holds the length where it was given, and the samples say so nevertheless.
    for prior, times in ((1e-3, "13"), (1e-5, "[0-9.]+")):
        words = "The samples contradict the prior of length: they alone give 0.36"
        with pytest.raises(InputError, match=f"{words}.* {times} standard deviations from"):
            fit_posterior(swing, replace(SWING, length=0.35), prior={"length": prior})


def test_a_restitution_near_one_stays_below_it(quick):
    quick()
    bouncy = replace(TOY, restitution=0.999)
    table = motion_table(bouncy, FAST, initial_angle=0.5, duration=1.0, size=0.02)
    got = fit_posterior(table, bouncy, FAST, unknown=["restitution"])
    draws = got.draws["restitution"].values
    assert draws.max() <= 1.0
    assert got["restitution"].sigma > 1e-3
    # Least squares put a part of their interval where no restitution is.
    fit = ll.fit_model(table, bouncy, FAST, vary=["restitution"])
    assert fit["restitution"].high > 1.0 > got["restitution"].high


def test_a_model_that_does_not_describe_its_record_is_not_sampled():
    table = motion_table(SWING, initial_angle=0.7, duration=8.0)
    table["angle_1"].values[240:] *= 0.8
    words = "nothing to sample: The model does not describe this record.*; give start and end to"
    with pytest.raises(InputError, match=words):
        fit_posterior(table, SWING)


def test_bad_input_is_refused_with_the_reason(swing):
    for arguments, words in {
        ("lenght",): "did you mean 'length'",
        ("mass",): "mass acts only through damping/mass",
    }.items():
        with pytest.raises(InputError, match=words):
            fit_posterior(swing, SWING, unknown=list(arguments))
    for prior, words in (
        ({"damping": 1.0}, "'damping' is not among what is fitted"),
        ({"length": -1.0}, "the prior of length"),
        ([1.0], "must map names"),
    ):
        with pytest.raises(InputError, match=words):
            fit_posterior(swing, SWING, unknown=["length"], prior=prior)
    with pytest.raises(InputError, match="draws"):
        fit_posterior(swing, SWING, draws=0)
    with pytest.raises(InputError, match="chains"):  # one has nothing to agree with
        fit_posterior(swing, SWING, chains=1)
    for seed, words in ((-1, "seed must lie in"), ("one", "seed must be a whole number")):
        with pytest.raises(InputError, match=words):
            fit_posterior(swing, SWING, seed=seed)
    with pytest.raises(InputError, match="ball must be 1 in this table, got 0"):
        fit_posterior(swing, SWING, ball=0)


def test_a_posterior_is_stored_drawn_and_made_by_a_command(tmp_path, capsys):
    table = motion_table(TOY, FAST, initial_angle=0.5, duration=2.0)
    path = write_table(table, tmp_path / "toy.csv")
    result, picture = tmp_path / "toy.nc", tmp_path / "toy.png"
    system = ["--system", "latolato", "--length", "0.245", "--mass", "0.106", "--radius", "0.02"]
    rest = ["--damping", "0.005", "--drive-amplitude", "3 cm", "--drive-frequency", "15.1"]
    wanted = ["--unknown", "restitution", "--unknown", "length", "--prior", "length = 1 mm"]
    files = ["--output", str(result), "--plot", str(picture), "--draws", "250"]
    assert main(["fit", "posterior", str(path), *system, *rest, *wanted, *files]) == 0
    assert re.search(r"\nrestitution +0\.(9|89)", capsys.readouterr().out)
    assert picture.stat().st_size > 30_000
    again = load_fit(result)
    assert set(again.draws) == {"restitution", "length"}
    assert again.draws["length"].dims == ("chain", "draw")
    assert main(["fit", "posterior", str(path), *system, "--prior", "lenght = 1 mm"]) == 2
    assert "length" in capsys.readouterr().err


class TestPrediction:
    """What trials will do, by draws of what is not known."""

    DRIVE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=14.0)

    def posterior(self, restitution, system=TOY):
        """A posterior whose restitution has these draws, without sampling."""
        draws = np.asarray(restitution).reshape(2, -1)
        attributes = {"fit": "posterior", "verdict": "", "drive": "fixed_pivot"}
        attributes["system_description"] = json.dumps(systems.described(system))
        parts = {f"restitution_{part}": 0.0 for part in ("sigma", "low", "high")}
        value = ((), 0.9, {"units": "1"})
        variables = {"restitution": value, **parts, "restitution_draw": (("chain", "draw"), draws)}
        return Fit(xr.Dataset(variables, attrs=attributes))

    def test_the_probability_is_the_share_of_draws_in_each_class(self):
        values = np.linspace(0.1, 0.99, 60)
        options = {"duration": 20.0, "transient": 15.0, "initial_offset": 0.3}
        got = ll.predict(self.posterior(values), self.DRIVE, draws=60, **options)
        twice = ll.predict(
            self.posterior(np.tile(values, 2)), self.DRIVE, draws=120, **options
        )  # as chains repeat draws
        assert twice["probability_none"] == got["probability_none"]
        each = ll.sweep(
            TOY, self.DRIVE, axes={"restitution": values}, observables=[ll.MotionClass()], **options
        )["motion_class"].values
        for number, name in enumerate(("none", "weak", "strong")):
            assert float(got[f"probability_{name}"]) == pytest.approx(np.mean(each == number))
        assert len(set(each)) > 1  # else the numbers could not tell a mistake
        assert "P(strong) = " in got.attrs["verdict"]
        assert float(got["probability_strong_low"]) <= float(got["probability_strong"])

    def test_the_class_of_two_balls_is_that_of_the_stronger_motion(self):
        values = np.linspace(0.1, 0.99, 20)
        options = {"duration": 20.0, "transient": 15.0, "initial_angle": (0.8, -0.8)}
        got = ll.predict(self.posterior(values, PAIR), self.DRIVE, draws=20, **options)
        each = ll.sweep(
            PAIR, self.DRIVE, axes={"restitution": values}, observables=[ll.MotionClass()],
            **options,
        )["motion_class"].max("ball")  # fmt: skip
        assert not got.dims
        for number, name in enumerate(("none", "weak", "strong")):
            assert float(got[f"probability_{name}"]) == pytest.approx(np.mean(each == number))
        assert len(set(each.values)) > 1  # else the numbers could not tell a mistake

    def test_it_is_a_map_over_axes(self, tmp_path):
        axes = {"drive_amplitude": [0.0, 0.02, 0.03], "drive_frequency": [12.0, 14.0]}
        got = ll.predict(
            self.posterior(np.linspace(0.1, 0.99, 20)), self.DRIVE, axes=axes, draws=20,
            duration=10.0, transient=5.0, initial_offset=0.3,
        )  # fmt: skip
        assert got["probability_none"].shape == (3, 2)
        assert (got["probability_none"].sel(drive_amplitude=0.0) == 1.0).all()
        total = sum(got[f"probability_{name}"] for name in ("none", "weak", "strong"))
        np.testing.assert_allclose(total, 1.0)
        path = ll.save(got, tmp_path / "map.nc")
        ll.plot(ll.load(path)).savefig(tmp_path / "map.png")

    def test_bad_input_is_refused_with_the_reason(self):
        good = self.posterior(np.linspace(0.5, 0.9, 20))
        with pytest.raises(InputError, match="'restitution' is unknown, and cannot be an axis"):
            ll.predict(good, self.DRIVE, axes={"restitution": [0.5]})
        with pytest.raises(InputError, match="must be what fit_posterior returns"):
            ll.predict(Fit(good.dataset.drop_vars("restitution_draw")), self.DRIVE)
        for other in (None, "toy.nc", good.dataset):
            with pytest.raises(InputError, match="must be what fit_posterior returns"):
                ll.predict(other, self.DRIVE)
        with pytest.raises(InputError, match="seed must lie in"):
            ll.predict(good, self.DRIVE, seed=-1)
        doubted = Fit(good.dataset.assign_attrs(describes=0, doubt="The draws are too few."))
        with pytest.raises(InputError, match="no result: The draws are too few"):
            ll.predict(doubted, self.DRIVE)
        measured = Fit(good.dataset.assign_attrs(drive="measured_pivot"))
        with pytest.raises(InputError, match="moved as it was measured"):
            ll.predict(measured)
