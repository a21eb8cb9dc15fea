"""Pivots that the picture does not show, and two balls about pivots of their own."""

import json
import warnings
from types import SimpleNamespace

import av
import numpy as np
import pytest

import latolato as ll
from latolato.cli.main import main
from latolato.core.errors import InputError
from latolato.experiment.calibration.circle import doubt_about, unseen_circle
from latolato.experiment.calibration.lens import Optics, distorted
from latolato.experiment.calibration.orbit import drive_of
from latolato.experiment.encode import TICKS, write_video
from latolato.experiment.follow import _settle_drive
from latolato.experiment.overlay import place_of, places_of
from latolato.experiment.sidecar import sidecar_path
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.track_table import read_table, table_of_ball, write_table
from latolato.experiment.tracking.positions import Positions, meetings

BALL = ll.Pendulum(length=0.363, mass=0.1, damping=0.003)
SIZE = 320, 240
SCALE = 1500.0
ARM = SCALE * BALL.length
TIMES = np.arange(0.0, 8.0, 1 / 30)


def swing(arm=1200.0, amplitude=0.15, noise=0.1, ellipse=0.0, drive=0.0, seed=0):
    """Return places of a ball about a pivot above the picture, shape (frame, 1, 2)."""
    phase = 2.0 * np.pi * TIMES / 2.6 + 0.3
    angle = amplitude * np.exp(-0.02 * TIMES) * np.cos(phase)
    places = np.stack([160.0 + arm * np.sin(angle), 200.0 - arm + arm * np.cos(angle)], axis=-1)
    places[:, 1] += ellipse * np.sin(phase) - drive * np.cos(10.0 * TIMES)
    places += noise * np.random.default_rng(seed).standard_normal(places.shape)
    return places[:, None]


def slack():
    """Return places of a ball whose string is slack now and then."""
    places = swing(600.0, 0.3)
    places[:, 0, 1] -= 60.0 * np.maximum(np.sin(10.0 * TIMES), 0.0) ** 2
    return places


def circle_of(places, declared=None):
    return unseen_circle(places, SIZE, declared=declared, has_lens=False)


@pytest.mark.parametrize("k1", [-0.01, 0.0, 0.01])
@pytest.mark.parametrize("arm,amplitude", [(200.0, 0.8), (600.0, 0.25), (3000.0, 0.05)])
def test_the_arm_is_that_of_the_arc_give_or_take_its_deviation(arm, amplitude, k1):
    seen = distorted(swing(arm, amplitude), SIZE, Optics(lens_k1=k1))
    circle = circle_of(seen)
    assert abs(circle.arm - arm) < 2.0 * circle.scale_sigma * circle.arm
    away = circle.centre - [160.0, 200.0 - arm]
    assert np.all(np.abs(away) < 2.5 * np.sqrt(np.diag(circle.covariance)[:2]))
    assert doubt_about(TIMES, seen, circle) is None


def test_noise_alone_makes_the_deviation_where_there_is_much():
    arms = [circle_of(swing(noise=3.0, seed=seed)) for seed in range(40)]
    pulls = [(one.arm / 1200.0 - 1.0) / one.scale_sigma for one in arms]
    assert 0.4 < np.sqrt(np.mean(np.square(pulls))) < 1.3  # of it and what no scatter shows


@pytest.mark.parametrize(
    "places,reason",
    [
        (swing(arm=1e9, amplitude=2e-7), "too straight"),
        (swing(arm=12000.0, amplitude=0.012), "too straight"),
        (swing(600.0, 0.3, drive=4.0), "move outside the picture, by 4.0 pixels at 1.6 Hz, or at "
         "a frequency that looks the same in 30 frames a second"),
        (swing(600.0, 0.3, drive=8.0, noise=2.0), "move outside the picture, by "),
        # One motion of the pivot does not explain what a slack string leaves.
        (slack(), "not a circle"),
        (np.concatenate([swing(300.0, 0.4), swing(150.0, 0.8)], axis=1), "not a circle"),
        (swing()[:10], "too rarely"),
    ],
)  # fmt: skip
def test_a_path_that_does_not_show_a_pivot_at_rest_is_doubted(places, reason):
    assert reason in doubt_about(TIMES[: len(places)], places, circle_of(places))


def test_an_arm_that_stretches_is_no_pivot_that_moves():
    angle, pivot = 0.9 * np.cos(5.2 * TIMES), np.array([160.0, 20.0])
    rod = np.stack([np.sin(angle), np.cos(angle)], axis=-1)
    more = 5.0 * np.cos(9.0 * TIMES + 1.0)[:, None]
    noise = 0.15 * np.random.default_rng(1).standard_normal(rod.shape)
    assert drive_of(TIMES, (pivot + (150.0 + more) * rod + noise)[:, None], pivot) is None
    driven = drive_of(TIMES, (pivot + 150.0 * rod + more * [0.0, 1.0] + noise)[:, None], pivot)
    assert driven.amplitude == pytest.approx(5.0, abs=0.1)


def test_a_drive_that_is_elsewhere_by_the_measured_paths_is_refused():
    angle, pivot = 0.9 * np.cos(5.2 * TIMES), np.array([160.0, 20.0])
    places = pivot + 150.0 * np.stack([np.sin(angle), np.cos(angle)], axis=-1)
    places[:, 1] += 5.0 * np.cos(9.0 * TIMES + 1.0)
    rough = drive_of(TIMES, places[:, None], pivot)
    seen = Positions.unknown(TIMES, 1, 10.0)
    seen.flags[:] = "ok"
    seen.centres[:, 0] = places + np.array([40.0, 0.0])
    video, setup = SimpleNamespace(width=320, height=240), SimpleNamespace(optics=Optics())
    task = SimpleNamespace(video=video, setup=setup, warnings=[])
    with pytest.raises(InputError, match=r"driven at \(160, \d+\), or at \(200, \d+\); point at"):
        _settle_drive(task, None, seen, rough, np.zeros(2))


@pytest.mark.parametrize("count", [0, 5])
def test_too_few_places_tell_of_no_drive(count):
    places = np.full((len(TIMES), 1, 2), np.nan)
    places[:count] = swing(drive=4.0)[:count]
    assert drive_of(TIMES, places, np.array([160.0, -1000.0])) is None


def test_a_swing_on_an_ellipse_is_no_motion_of_the_pivot():
    places = swing(ellipse=2.0)
    circle = circle_of(places)
    assert circle.residual > 1.0
    assert doubt_about(TIMES, places, circle) is None
    assert abs(circle.arm - 1200.0) < 2.0 * circle.scale_sigma * circle.arm


def test_a_declared_pivot_is_believed_unless_the_arc_says_otherwise():
    places = swing(3000.0, 0.05)
    free, near = circle_of(places), circle_of(places, np.array([160.0, -2850.0]))
    assert near.is_declared
    assert near.scale_sigma < 0.02 < free.scale_sigma
    assert 2950.0 < near.arm < 3060.0
    wrong = circle_of(places, np.array([160.0, -800.0]))
    assert not wrong.is_declared
    assert wrong.arm == free.arm
    assert "declared at (160, -800) is not the centre" in wrong.warnings[0]


@pytest.fixture(scope="session")
def above(tmp_path_factory):
    """A free swing about a pivot 344 pixels above the picture, and its truth."""
    path = tmp_path_factory.mktemp("above") / "above.mp4"
    run = ll.simulate(BALL, initial_angle=0.25, duration=4.0)
    scene = Scene(ball_radius=0.008, rod_width=0.003)
    place = {"pivot_u": 160.0, "pivot_v": 200.0 - ARM}
    camera = Camera(width=320, height=240, fps=30.0, pixels_per_metre=SCALE, **place)
    return path, synthesise_video(run, path, scene, camera, seed=2)


def tracked(path, **arguments):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ll.track(path, **arguments)


def click(truth):
    return truth.attrs["ball_1_pixel_u"], truth.attrs["ball_1_pixel_v"]


@pytest.fixture(scope="session")
def fitted(above):
    return tracked(above[0], pivot="outside", balls=[click(above[1])], length=BALL.length)


def test_angles_about_an_unseen_pivot_share_one_factor_and_else_are_as_good_as_they_say(
    above, fitted
):
    attrs, truth = fitted.attrs, above[1]
    assert (attrs["geometry"], attrs["pivot_source"]) == ("metric", "arc")
    assert abs(attrs["arm_pixels"] / ARM - 1.0) < 2.0 * attrs["angle_scale_sigma"] < 0.1
    assert attrs["metres_per_pixel"] == pytest.approx(BALL.length / attrs["arm_pixels"])
    ok = fitted.flag_1.values == "ok"
    assert ok.mean() > 0.95
    true, angle = truth.angle_1.values[ok], fitted.angle_1.values[ok]
    factor = np.sum(true * angle) / np.sum(true**2)
    assert abs(factor - 1.0) < 2.0 * attrs["angle_scale_sigma"]
    pulls = (angle - factor * true) / fitted.angle_sigma_1.values[ok]
    assert np.mean(np.abs(pulls) < 2.0) > 0.9
    assert np.median(fitted.angle_sigma_1) < 1e-3 < np.ptp(true) * attrs["angle_scale_sigma"]
    assert "it is assumed to be at rest at (160, -34" in attrs["warnings"]
    np.testing.assert_allclose(fitted.pivot_y, 0.0, atol=1e-12)
    pivot, _ = places_of(fitted, SIZE)
    assert abs(pivot[0, 1] - (200.0 - ARM)) < 2.0 * attrs["pivot_offset_y_sigma"]


def test_a_decay_pins_the_pivot_and_its_deviations_hold(fitted):
    fit = ll.fit_decay(fitted, mass=BALL.mass, compare=False, profile=False)
    for name in ("length", "damping"):
        assert abs(fit[name].value - getattr(BALL, name)) < 3.0 * fit[name].sigma
    # Large swings are slower: that tells the scale of the angles better than the arc does.
    error = BALL.length * fitted.attrs["angle_scale_sigma"]
    assert fit["pivot_error_y"].sigma < 0.5 * error
    quadratic = ll.fit_decay(
        fitted, mass=BALL.mass, law="quadratic", method="equation", compare=False, profile=False
    )
    sure = fitted.assign_attrs(pivot_offset_y_sigma=0.15)
    other = ll.fit_decay(
        sure, mass=BALL.mass, law="quadratic", method="equation", compare=False, profile=False
    )
    # A drag that goes with the square of the angle takes the uncertainty of its scale.
    assert quadratic["quadratic_damping"].sigma > 1.2 * other["quadratic_damping"].sigma


def test_what_is_not_found_in_the_picture_is_fitted_and_a_sidecar_makes_it_again(
    above, tmp_path, capsys
):
    output = tmp_path / "above.csv"
    arguments = ["track", str(above[0]), "--output", str(output)]
    assert main(arguments) == 0
    told = capsys.readouterr().out
    assert "out of the picture at (160, -34" in told
    assert "--pivot outside --ball" in told
    first = output.read_text()
    assert "# pivot_source: arc" in first
    assert main(arguments) == 0
    assert "set-up read from" in capsys.readouterr().out
    assert output.read_text() == first


def test_a_declared_place_out_of_the_picture_is_the_pivot(above, tmp_path, capsys):
    place = f"160,{200.0 - ARM:.0f}"
    arguments = ["track", str(above[0]), "--pivot", place, "--json"]
    assert main([*arguments, "--report", str(tmp_path / "page.html")]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["geometry"], told["pivot_source"]) == ("angles", "declared")
    assert told["angle_scale_sigma"] < 0.02
    assert "as declared, assumed at rest" in (tmp_path / "page.html").read_text()


@pytest.mark.parametrize(
    "pivot,reason",
    [
        (["160,-9000"], "farther than 4000 pixels from the picture"),
        (["away"], "must be a column and a row"),
        (["1,1", "2,2", "3,3"], "may be given twice at most"),
    ],
)
def test_pivots_that_make_no_sense_are_refused(above, capsys, pivot, reason):
    options = [part for one in pivot for part in ("--pivot", one)]
    assert main(["track", str(above[0]), "--ball", "200,190", *options]) == 2
    assert reason in capsys.readouterr().err


def test_two_pivots_need_two_balls(above):
    with pytest.raises(InputError, match="two pivots need two balls"):
        ll.track(above[0], pivot=[(1, 1), "outside"], balls=1)
    with pytest.raises(InputError, match="only one moving ball was found, not two"):
        ll.track(above[0], pivot=["outside", "outside"])


def test_a_driven_pivot_out_of_the_picture_makes_no_angles(tmp_path):
    drive = ll.Harmonic(drive_amplitude=0.004, drive_frequency=9.0)
    run = ll.simulate(BALL, drive, initial_angle=0.4, duration=3.0)
    camera = Camera(
        width=320, height=240, fps=30.0, pixels_per_metre=700.0, pivot_u=160.0, pivot_v=-54.0
    )
    path = tmp_path / "driven.mp4"
    synthesise_video(run, path, Scene(ball_radius=0.017), camera, seed=2)
    table = tracked(path, pivot="outside", length=BALL.length)
    assert table.attrs["geometry"] == "unknown"
    assert "seems to move outside the picture, by 2." in table.attrs["warnings"]
    assert "at 1.4 Hz" in table.attrs["warnings"]


@pytest.fixture(scope="session")
def pair(above, tmp_path_factory):
    """Two pendulums side by side, the left one with its pivot in the picture, and their truths."""
    folder = tmp_path_factory.mktemp("pair")
    run = ll.simulate(BALL, initial_angle=0.5, duration=4.0)
    camera = Camera(
        width=320, height=240, fps=30.0, pixels_per_metre=440.0, pivot_u=160.0, pivot_v=40.0
    )
    left = folder / "left.mp4"
    truth = synthesise_video(run, left, Scene(ball_radius=0.02), camera, seed=3)
    pictures = []
    for path in (left, above[0]):
        with av.open(str(path)) as file:
            pictures.append([frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)])
    planes = (
        (
            round(time * TICKS),
            av.VideoFrame.from_ndarray(np.hstack(both), format="rgb24").to_ndarray(
                format="yuv420p"
            ),
        )
        for time, *both in zip(truth.time.values, *pictures, strict=True)
    )
    path = folder / "pair.mp4"
    write_video(path, planes, fps=30.0, crf=18, rotation=0)
    return path, above[1], truth


@pytest.fixture(scope="session")
def apart(pair):
    path, right, left = pair
    (u, v), other = click(right), click(left)
    return tracked(path, pivot=[(160.0, 40.0), "outside"], balls=[other, (u + 320.0, v)])


def test_each_of_two_balls_has_angles_about_its_own_pivot(pair, apart):
    assert (apart.attrs["pivot_source"], apart.attrs["pivot_source_2"]) == ("arc", "picture")
    for ball, truth in zip((1, 2), pair[1:], strict=True):
        ok = apart[f"flag_{ball}"].values == "ok"
        assert ok.mean() > 0.95
        shared = apart.attrs["angle_scale_sigma"] if ball == 1 else 0.0
        error = np.abs(apart[f"angle_{ball}"].values - truth.angle_1.values)[ok]
        limit = 2.0 * np.hypot(apart[f"angle_sigma_{ball}"].values, shared * np.abs(truth.angle_1))
        assert np.mean(error < limit.values[ok]) > 0.9
    left, _ = place_of(apart, "pivot_2", (640, 240)), None
    assert np.hypot(*(left[0] - [160.0, 40.0])) < 1.0
    right, balls = places_of(apart, (640, 240))
    assert abs(right[0, 0] - 480.0) < 1.0
    assert np.hypot(*(balls[0, 1] - click(pair[2]))) < 0.5


def test_two_pivots_are_found_without_clicks(pair):
    table = tracked(pair[0])
    assert (table.attrs["pivot_source"], table.attrs["pivot_source_2"]) == ("arc", "picture")
    found = [table.attrs[f"pivot_2_pixel_{axis}"] for axis in "uv"]
    assert np.hypot(*(np.array(found) - [160.0, 40.0])) < 4.0  # as near as a click
    right, left = (table[f"flag_{ball}"].values == "ok" for ball in (1, 2))
    assert min(right.mean(), left.mean()) > 0.9


def test_one_length_is_not_that_of_two_arms(pair):
    path, right, left = pair
    (u, v), other = click(right), click(left)
    with pytest.raises(InputError, match="one length cannot fit both"):
        tracked(path, pivot=["outside", (160, 40)], balls=[(u + 320, v), other], length=0.363)


def test_a_table_of_own_pivots_survives_its_file_and_gives_each_ball_alone(apart, tmp_path):
    again = read_table(write_table(apart, tmp_path / "pair.csv"))
    assert set(again.variables) == set(apart.variables)
    alone = table_of_ball(again, 2)
    np.testing.assert_array_equal(alone.angle_1, apart.angle_2)
    np.testing.assert_array_equal(alone.pivot_u, apart.pivot_2_u)
    assert alone.attrs["arm_pixels"] == apart.attrs["arm_pixels_2"]
    assert alone.attrs["ball_1_pixel_u"] == apart.attrs["ball_2_pixel_u"]
    assert "pivot_2_u" not in alone.variables
    assert not any("_2" in name for name in alone.attrs)


def test_fits_take_each_ball_about_its_own_pivot_and_none_takes_both(apart):
    for ball in (1, 2):
        fit = ll.fit_decay(apart, ball=ball, compare=False, profile=False, method="equation")
        assert abs(fit["length"].value - BALL.length) < 3.0 * fit["length"].sigma
        assert fit.dataset.attrs["ball"] == ball
    toy = ll.LatoLato(length=0.363, mass=0.1, damping=0.003, radius=0.02, restitution=0.9)
    with pytest.raises(InputError, match="separate pivots"):
        ll.fit_model(apart, toy)
    with pytest.raises(InputError, match="separate pivots"):
        ll.fit_restitution(apart, length=0.363)


def test_balls_about_pivots_of_their_own_meet_where_they_touch():
    gaps = np.array([50.0, 40.0, 30.0, 21.0, 27.0, 33.0])
    one, other = (Positions.unknown(np.arange(6.0), 1, 10.0) for _ in range(2))
    one.centres[:], other.centres[:] = 0.0, 0.0
    other.centres[:, 0, 0] = gaps
    assert meetings(one, other).tolist() == [False, False, False, True, False, False]


def test_a_set_up_of_two_pivots_is_read_again(pair, apart, tmp_path):
    path, right, left = pair
    (u, v), other = click(right), click(left)
    output = tmp_path / "pair.csv"
    clicks = [f"{u + 320.0},{v}", f"{other[0]},{other[1]}"]
    options = [part for one in clicks for part in ("--ball", one)]
    arguments = ["track", str(path), "--output", str(output)]
    assert main([*arguments, *options, "--pivot", "outside", "--pivot", "160,40"]) == 0
    first = output.read_text()
    assert "own_pivots = true" in sidecar_path(output).read_text()
    assert main(arguments) == 0
    assert output.read_text() == first
