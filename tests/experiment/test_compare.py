"""Comparisons: what is alike is found alike, and what differs is measured."""

import json
import math

import numpy as np
import pytest

import latolato as ll
from latolato.cli.main import main
from latolato.core.errors import InputError
from latolato.experiment.comparison.motion import phases
from latolato.experiment.comparison.response import peak_of
from latolato.experiment.fits.windows import motion_at
from latolato.experiment.track_table import write_table
from latolato.experiment.trial_statistics import cohen_kappa
from latolato.experiment.trial_table import trial_table, write_trials
from latolato.paper.grids import PAIR_OBSERVABLES, PENDULUM_OBSERVABLES
from track_tables import decay_table, motion_table

SINGLE = ll.Pendulum(length=0.363, mass=0.10804, damping=0.00274)
PAIR = ll.LatoLato(length=0.245, mass=0.10644, damping=0.00506, radius=0.0196, restitution=0.9)
DRIVE = ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.09)
# Those of the figures, so that kernels are compiled once.
WATCHED = PENDULUM_OBSERVABLES


@pytest.fixture(scope="module")
def table():
    result = motion_table(SINGLE, DRIVE, duration=30.0, initial_angle=0.1)
    result.attrs["length"] = 0.363
    return result


@pytest.fixture(scope="module")
def grid():
    return ll.sweep(
        SINGLE,
        axes={
            "drive_amplitude": np.linspace(0.01, 0.04, 16),
            "frequency_ratio": np.linspace(1.7, 2.3, 31),
        },
        duration=40.0,
        transient=30.0,
        initial_angle=0.2,
        observables=WATCHED,
    )


def trials_on(grid, shift=0.0):
    """Trials whose classes are those of a map at places moved by `shift` in frequency."""
    amplitude, ratio = np.meshgrid(grid.drive_amplitude[2::4], grid.frequency_ratio[1::3])
    moved = grid.motion_class.sel(
        drive_amplitude=np.unique(amplitude), frequency_ratio=ratio[:, 0] + shift, method="nearest"
    )
    names = np.array(["none", "weak", "strong"])[moved.values.T.astype(int)]
    columns = {
        "drive_amplitude": amplitude.ravel(),
        "drive_amplitude_sigma": np.full(amplitude.size, 2e-4),
        "frequency_ratio": ratio.ravel(),
        "class": names.ravel(),
        "length": np.full(amplitude.size, 0.363),
    }
    return trial_table(columns)


def test_a_motion_is_followed_with_residuals_of_the_noise_and_no_phase(table):
    result = ll.compare(table, SINGLE)
    # Noise is 1 mrad; the start is known to a fifth of that and grows.
    assert float(result.residual_rms) < 2e-3
    assert float(result.phase_rms_late) < 5e-3
    assert float(result.followed_until) == result.time.values[-1]
    assert "for all" in result.attrs["verdict"]
    pulls = result.angle_residual / np.hypot(1e-3, result.angle_computed_sigma)
    assert float(np.mean(np.abs(pulls) < 3.0)) > 0.97


def test_a_motion_that_cannot_be_computed_to_the_end_is_refused(table, monkeypatch):
    def until_ten_seconds(*arguments, **options):
        angles, velocities, slopes = motion_at(*arguments, **options)
        late = arguments[3] > 10.0
        return np.where(late, np.nan, angles), np.where(late, np.nan, velocities), slopes

    monkeypatch.setattr("latolato.experiment.fits.windows.motion_at", until_ten_seconds)
    with pytest.raises(InputError, match="does not reach the end of the record"):
        ll.compare(table, SINGLE, drive=DRIVE)


def test_a_wrong_length_shows_in_residual_and_phase(table):
    wrong = ll.compare(table, ll.Pendulum(length=0.375, mass=0.10804, damping=0.00274))
    assert float(wrong.residual_rms_late) > 0.05
    assert float(wrong.followed_until) < 25.0
    assert "until" in wrong.attrs["verdict"]


def test_a_pair_is_followed_through_its_impacts():
    w0 = PAIR.natural_frequency
    drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.4 * w0)
    table = motion_table(PAIR, drive, duration=8.0, initial_offset=0.3)
    result = ll.compare(table, PAIR)
    assert float(result.residual_rms) < 3e-3
    assert float(np.nanmin(result.coherence)) > 0.99


def test_a_decay_is_compared_with_its_own_fit():
    table = decay_table(length=0.363, mass=0.10804, damping=0.00274, duration=12.0)
    fit = ll.fit_decay(table, mass=0.10804, method="equation", compare=False, profile=False)
    result = ll.compare(table, fit, match=12.0)
    assert float(result.residual_rms) == pytest.approx(1e-3, rel=0.1)
    assert result.attrs["sigma_of_length"] == fit["length"].sigma


@pytest.mark.parametrize("ahead", [-0.8, 0.3])
def test_the_phase_difference_of_two_swings_is_found(ahead):
    time = np.arange(0.0, 30.0, 1.0 / 60.0)
    time += np.random.default_rng(0).uniform(-4e-3, 4e-3, len(time))
    one, other = (np.exp(0.05 * time) * np.cos(5.0 * time + shift) for shift in (ahead, 0.0))
    phase, alike = phases(time, one, other, 2.0 * np.pi / 10.0)
    known = np.isfinite(phase)
    assert known.mean() > 0.75
    assert phase[known] == pytest.approx(np.full(known.sum(), ahead), abs=0.03)
    assert alike[known].min() > 0.99


def test_trials_from_the_map_agree_with_it(grid):
    result = ll.compare(trials_on(grid), grid, draws=10, sigmas={"length": 5e-4})
    assert float(result.agreement) == 1.0
    assert float(result.kappa) == 1.0
    assert float(result.agreement_high) == 1.0
    assert float(result.agreement_low) < 1.0
    assert int(result.confusion.sum()) == result.sizes["trial"]
    assert np.trace(result.confusion.values) == result.sizes["trial"]
    inside = (
        np.abs(result.boundary_x - result.boundary_computed) <= result.boundary_half_gap + 0.011
    )
    assert bool(inside.all())
    assert set(result.boundary_side.values.tolist()) == {"left", "right"}


def test_moved_trials_agree_less_and_by_a_shifted_boundary(grid):
    result = ll.compare(trials_on(grid, shift=0.08), grid, draws=0)
    assert float(result.agreement) < 0.85
    assert float(result.kappa) < 0.7
    assert float((result.boundary_x - result.boundary_computed).mean()) < -0.04


def test_doubt_about_the_length_widens_the_agreement(grid):
    trials = trials_on(grid)
    sure, unsure = (ll.compare(trials, grid, draws=20, sigmas={"length": s}) for s in (1e-6, 2e-2))
    assert float(unsure.agreement_sigma_parameters) > 2.0 * float(sure.agreement_sigma_parameters)
    assert float(unsure.chance_of_agreement.mean()) < float(sure.chance_of_agreement.mean())


def test_kappa_has_its_textbook_value():
    # Cohen's 1960 layout: 20 yes-yes, 5 yes-no, 10 no-yes, 15 no-no.
    one = np.repeat([1, 1, 0, 0], [20, 5, 10, 15])
    other = np.repeat([1, 0, 1, 0], [20, 5, 10, 15])
    assert cohen_kappa(one, other) == pytest.approx(0.4)


def test_the_place_of_a_peak_is_known_by_parabola_cliff_or_end():
    random = np.random.default_rng(1)
    x = np.linspace(2.0, 3.0, 11)
    round_top = peak_of(x, 1.0 - (x - 2.43) ** 2, np.full(11, 1e-3), np.full(11, 1e-4), random)
    assert round_top.kind == "parabola"
    assert abs(round_top.place - 2.43) < 3.0 * round_top.sigma < 0.1
    cliff = peak_of(x, np.where(x < 2.35, 0.1, 1.4 - 0.2 * x))
    assert (cliff.kind, cliff.place) == ("cliff", pytest.approx(2.35))
    assert cliff.sigma == pytest.approx(0.1 / math.sqrt(12.0))
    end = peak_of(x, -x + 5.0)
    assert (end.kind, end.place, end.sigma) == ("end", 2.0, pytest.approx(0.1))


@pytest.fixture(scope="module")
def responses():
    """Trials computed at their places, and the comparison with the same system."""
    ratios, amplitudes = np.linspace(1.9, 2.9, 11), [0.02, 0.03]
    run = ll.sweep(
        PAIR,
        axes={"drive_amplitude": amplitudes, "frequency_ratio": ratios},
        duration=30.0,
        transient=20.0,
        initial_offset=0.15,
        observables=PAIR_OBSERVABLES,
    )
    late = run.largest_angle_after_transient.values
    columns = {
        "drive_amplitude": np.repeat(amplitudes, 11),
        "frequency_ratio": np.tile(ratios, 2),
        "largest_angle": run.largest_angle.values.ravel(),
        "largest_angle_after_transient": late.ravel(),
        "largest_angle_after_transient_sigma": np.full(22, 0.01),
        "length": np.full(22, 0.245),
    }
    trials = trial_table(columns)
    options = {"initial_offset": 0.15, "duration": 30.0, "transient": 20.0, "points": 61}
    return trials, ll.compare(trials, PAIR, draws=3, sigmas={"restitution": 0.01}, **options)


def test_response_curves_of_the_same_system_agree(responses):
    _, result = responses
    assert result.angle_at_trial.values == pytest.approx(
        result.largest_angle_after_transient.values, abs=1e-4
    )
    assert "agree within 3" in result.attrs["verdict"]
    assert np.all(result.peak_measured_sigma > 0.0)
    # The peak moves to the left with the amplitude (Fig. 11).
    assert result.peak_computed_place[1] < result.peak_computed_place[0]


@pytest.mark.parametrize("error", [-0.1, 0.1])
@pytest.mark.parametrize("count", [11, 41])
def test_an_error_of_the_scale_that_trials_share_does_not_shrink_with_their_number(error, count):
    ratios, amplitude = np.linspace(1.9, 2.9, count), 0.03
    start = {"duration": 30.0, "transient": 20.0, "initial_offset": 0.15}
    run = ll.sweep(
        PAIR,
        axes={"drive_amplitude": [amplitude], "frequency_ratio": ratios},
        observables=PAIR_OBSERVABLES,
        **start,
    )
    late = run.largest_angle_after_transient.values.ravel()
    columns = {
        "drive_amplitude": np.full(count, amplitude * (1.0 + error)),
        "drive_amplitude_sigma": np.full(count, amplitude * abs(error)),
        "frequency_ratio": ratios,
        "largest_angle": run.largest_angle.values.ravel(),
        "largest_angle_after_transient": late,
        "largest_angle_after_transient_sigma": np.full(count, 0.01),
        "length": np.full(count, PAIR.length),
    }
    result = ll.compare(trial_table(columns), PAIR, **start)
    # What was measured has the true place, what is computed that of the wrong amplitude.
    away = float(result.peak_computed_place[0] - result.peak_measured_place[0])
    # An error of one deviation, and half a cell of the measured curve where it has few trials.
    sigma = float(result.peak_computed_sigma[0])
    assert abs(away) <= 2.0 * sigma + 0.5 * (ratios[1] - ratios[0])
    assert "agree within 3" in result.attrs["verdict"]


def test_an_error_of_the_scale_moves_all_trials_on_a_map_alike(grid):
    few, many = (trials_on(grid).isel(trial=np.tile(np.arange(40), n)) for n in (1, 9))
    one, other = (
        float(ll.compare(trials, grid, draws=40).agreement_sigma_parameters)
        for trials in (few, many)
    )
    assert other == pytest.approx(one, rel=0.5)
    assert one > 0.0


def test_every_comparison_is_drawn_from_a_file(table, grid, responses, tmp_path):
    result = {
        "motion": ll.compare(table, SINGLE, draws=2),
        "map": ll.compare(trials_on(grid, 0.05), grid, draws=2),
        "response": responses[1],
    }
    for name, dataset in result.items():
        again = ll.load(ll.save(dataset, tmp_path / f"{name}.nc"))
        assert ll.plot(again).axes, name
    with pytest.raises(ValueError, match="drawn whole"):
        ll.plot(result["map"], log=True)


def test_what_cannot_be_compared_is_refused(table, grid, responses):
    trials = responses[0]
    with pytest.raises(InputError, match="track table or trials"):
        ll.compare(3, SINGLE)
    with pytest.raises(ValueError, match="track table or a trial table"):
        ll.compare(grid, SINGLE)
    with pytest.raises(InputError, match="system or a fit"):
        ll.compare(table, grid)
    with pytest.raises(ValueError, match="no number 'lenght'"):
        ll.compare(table, SINGLE, sigmas={"lenght": 1e-3})
    far = trials.assign(frequency_ratio=trials.frequency_ratio + 5.0)
    with pytest.raises(ValueError, match="none of the 22 trials lies on the map"):
        ll.compare(far, grid)
    with pytest.raises(ValueError, match="holds no classes"):
        ll.compare(trials, grid[["mean_energy"]].assign_attrs(grid.attrs))
    with pytest.raises(ValueError, match="omit drive"):
        ll.compare(trials, PAIR, DRIVE)


def test_the_command_compares_motions_maps_and_responses(table, grid, responses, tmp_path, capsys):
    track, trials, chart = (tmp_path / n for n in ("track.csv", "trials.csv", "map.nc"))
    write_table(table, track)
    write_trials(trials_on(grid), trials)
    ll.save(grid, chart)
    system = ["--system", "pendulum", "--length", "36.3 cm", "--mass", "108.04 g"]
    system += ["--damping", "0.00274"]
    plot = ["--plot", str(tmp_path / "picture.png")]
    assert main(["compare", str(track), *system, *plot, "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["comparison"] == "motion"
    assert summary["values"]["residual_rms"]["value"] < 2e-3
    assert (tmp_path / "picture.png").stat().st_size > 10_000
    result = ["--output", str(tmp_path / "c.nc"), "--draws", "3", "--sigma", "length = 0.5 mm"]
    assert main(["compare", "--trials", str(trials), "--map", str(chart), *result]) == 0
    assert "100 % of" in capsys.readouterr().out
    write_trials(responses[0], trials)
    pair = ["--system", "latolato", "--length", "0.245", "--mass", "0.10644", "--radius", "0.0196"]
    pair += ["--damping", "0.00506", "--restitution", "0.9", "--initial-offset", "0.15"]
    pair += ["--duration", "30", "--transient", "20", "--draws", "2"]
    assert main(["compare", str(trials), *pair, *plot]) == 0
    assert "response peaks" in capsys.readouterr().out
    assert main(["plot", str(tmp_path / "c.nc"), "--animate", str(tmp_path / "c.gif")]) == 2
    assert "a comparison" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments, words",
    [
        ([], "name a track table"),
        (["TRACK"], "name what is computed"),
        (["TRACK", "--map", "x.nc"], "--map needs trials"),
        (["TRACK", "--system", "pendulum"], "needs --length [m]"),
        (["TRACK", "fig08", "--transient", "3"], "--transient does not belong"),
        (["TRACK", "fig08", "--sigma", "length"], "--sigma must be NAME=VALUE"),
        (["TRACK", "fig08", "--plot", "x.gif"], "picture must end in"),
        (["TRACK", "fig08", "--fit", "x.nc"], "not both"),
        (["nothing.csv", "fig08"], "there is no file"),
    ],
)
def test_bad_input_of_the_command_is_one_line(table, tmp_path, capsys, arguments, words):
    track = str(write_table(table.isel(frame=slice(0, 300)), tmp_path / "track.csv"))
    assert main(["compare", *(track if a == "TRACK" else a for a in arguments)]) == 2
    err = capsys.readouterr().err
    assert words in err
    assert err.count("\n") == 1
