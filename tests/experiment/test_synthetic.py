"""Synthetic videos: what is painted lies where the truth says, and the file says when."""

import dataclasses
import json
import math

import numpy as np
import pytest

import latolato as ll
from conditions import conditions
from latolato.cli.main import main
from latolato.core.errors import InputError
from latolato.experiment.encode import write_video
from latolato.experiment.quality import pivot_numbers, pivot_text
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import prepare, synthesise_video
from latolato.experiment.track_table import read_table

# A ball alone, drawn flat, so that its centroid is its centre.
ALONE = Scene(
    ambient=1.0, gloss=0.0, rod_width=0.0, block_width=0.0, block_height=0.0, bolt_radius=0.0,
    rail_width=0.0,
)  # fmt: skip
SMALL = Camera(width=320, height=240, vignetting=0.0)
SWING = ll.Pendulum(length=0.363, mass=0.1, damping=0.003)
DRIVE = ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.0)
# An edge is a ramp of one pixel whatever its direction, which moves a ball of 10 pixels by 0.011.
NEAR = 0.02  # pixel


@pytest.fixture(scope="module")
def run():
    return ll.simulate(SWING, DRIVE, initial_angle=0.6, duration=0.8)


@pytest.fixture(scope="module")
def pair():
    toy = ll.LatoLato(length=0.245, mass=0.1, damping=0.005, radius=0.02, restitution=0.9)
    return ll.simulate(toy, initial_angle=0.5, duration=0.8)


def centroid(film, number, columns=slice(None)):
    """Return u and v of what differs from the wall."""
    light = np.abs(film.picture(number) - film.renderer.background).sum(axis=2)
    v, u = np.mgrid[0 : light.shape[0], 0 : light.shape[1]]
    mask = np.zeros_like(light)
    mask[:, columns] = light[:, columns]
    return (mask * u).sum() / mask.sum(), (mask * v).sum() / mask.sum()


def true_pixel(film, number, ball=1):
    """Return u and v of a ball's centre by the truth."""
    truth = film.truth()
    x, y = (float(truth[f"ball_{ball}_{axis}"][number]) for axis in "xy")
    u, v = film.renderer.projection.in_picture(x, y)
    return float(u), float(v)


@pytest.mark.parametrize("roll", [0.0, 0.2, math.pi])
def test_the_ball_is_painted_where_the_truth_says(run, roll):
    film = prepare(run, ALONE, dataclasses.replace(SMALL, roll=roll, exposure=0.02))
    for number in (0, 17, 30):
        assert centroid(film, number) == pytest.approx(true_pixel(film, number), abs=NEAR)


def test_truth_is_the_projection_of_the_run(run):
    camera = dataclasses.replace(SMALL, pixels_per_metre=500.0, pivot_u=160.0, pivot_v=40.0)
    film = prepare(run, ALONE, camera)
    truth = film.truth()
    again = ll.simulate(SWING, DRIVE, initial_angle=0.6, times=film.begin + film.times)
    # The truth is interpolated from samples 0.1 ms apart.
    np.testing.assert_allclose(truth.angle_1, again.angle, atol=2e-7)
    height = again.pivot_height - again.pivot_height.mean()
    np.testing.assert_allclose(truth.pivot_y, height, atol=1e-8)
    angle = np.arctan2(truth.ball_1_x - truth.pivot_x, truth.pivot_y - truth.ball_1_y)
    np.testing.assert_allclose(truth.angle_1, angle, atol=1e-12)
    first = truth.isel(frame=0)
    assert truth.attrs["pivot_pixel_v"] == pytest.approx(40.0 - 500.0 * float(first.pivot_y))
    assert truth.attrs["ball_1_pixel_u"] == pytest.approx(160.0 + 500.0 * float(first.ball_1_x))


def test_a_smear_is_centred_on_the_middle_of_the_exposure(run):
    camera = dataclasses.replace(SMALL, fps=30.0, exposure=0.9)
    film = prepare(run, ALONE, camera)
    for number in (5, 11):
        moments = film.states(number)
        length = math.dist(moments[0, 0, 1], moments[-1, 0, 1])
        assert length > 5.0  # pixel, or the test would say little
        # A smear is bent: its mean lies off the middle by acceleration x exposure^2/24.
        bend = 20.0 * film.renderer.projection.scale * 0.03**2 / 24.0
        assert centroid(film, number) == pytest.approx(true_pixel(film, number), abs=bend)


def test_frames_are_stamped_exactly(run, tmp_path):
    av = pytest.importorskip("av", reason="needs the extra video")
    camera = dataclasses.replace(SMALL, fps=29.97, jitter=0.2, drop=0.2)
    truth = synthesise_video(run, tmp_path / "clip.mp4", camera=camera, seed=3)
    with av.open(str(tmp_path / "clip.mp4")) as file:
        times = [float(frame.pts * frame.time_base) for frame in file.decode(video=0)]
    assert times == truth.time.values.tolist()
    assert len(set(np.round(np.diff(times), 4))) > 5


def test_the_truth_is_written_as_a_track_table(run, tmp_path):
    path = tmp_path / "truth.csv"
    truth = synthesise_video(run, tmp_path / "clip.mp4", camera=SMALL, truth=path)
    again = read_table(path)
    np.testing.assert_array_equal(again.angle_1, truth.angle_1)
    assert again.attrs["ball_1_pixel_u"] == truth.attrs["ball_1_pixel_u"]


@pytest.mark.parametrize("rotation", [0, 90, 180, 270])
def test_turning_the_stored_pictures_back_shows_the_ball_where_it_was_clicked(
    run, tmp_path, rotation
):
    av = pytest.importorskip("av", reason="needs the extra video")
    camera = dataclasses.replace(SMALL, rotation=rotation, crf=1)
    truth = synthesise_video(run, tmp_path / "clip.mp4", ALONE, camera)
    with av.open(str(tmp_path / "clip.mp4")) as file:
        frame = next(file.decode(video=0))
        output = np.rot90(frame.to_ndarray(format="rgb24"), frame.rotation // 90)
    assert output.shape == (240, 320, 3)
    v, u = np.nonzero(output[..., 0] > output[..., 2] + 80.0)  # orange
    # Means of whole pixels that are orange enough, with chroma of half the resolution.
    assert u.mean() == pytest.approx(truth.attrs["ball_1_pixel_u"], abs=0.5)
    assert v.mean() == pytest.approx(truth.attrs["ball_1_pixel_v"], abs=0.5)


@pytest.mark.parametrize("rotation", [0, 90, 180, 270])
def test_a_rolling_shutter_shows_the_ball_as_it_is_when_its_stored_row_is_read(run, rotation):
    row_time = 4e-5
    camera = dataclasses.replace(SMALL, rotation=rotation, row_time=row_time, exposure=0.01)
    film = prepare(run, ALONE, camera)
    projection, scale = film.renderer.projection, film.renderer.projection.scale
    u, v = true_pixel(film, 14)
    row = {0: v, 90: camera.width - 1 - u, 180: camera.height - 1 - v, 270: u}[rotation]
    angle = np.interp(
        film.begin + film.times[14] + row_time * row, film.motion.time, film.motion.angles[0]
    )
    truth = film.truth()
    x, y = 0.363 * math.sin(angle), float(truth.pivot_y[14]) - 0.363 * math.cos(angle)
    late_u, late_v = (float(number) for number in projection.in_picture(x, y))
    assert math.dist((u, v), (late_u, late_v)) > 0.6  # pixel
    # The pivot moves on by up to 0.2 m/s, and the rows of the ball differ by its diameter.
    near = scale * 0.2 * row_time * row + 0.3
    assert centroid(film, 14) == pytest.approx((late_u, late_v), abs=near)


def test_a_lens_moves_the_ball_as_its_coefficients_say(run):
    camera = dataclasses.replace(SMALL, k1=-0.12, k2=0.02, exposure=0.02, pixels_per_metre=450.0)
    film = prepare(run, ALONE, camera)
    # The outer half of a ball is shown smaller, which moves the centroid inwards.
    assert centroid(film, 0) == pytest.approx(true_pixel(film, 0), abs=0.1)
    projection = film.renderer.projection
    u, v = projection.flat(*(float(film.truth()[f"ball_1_{axis}"][0]) for axis in "xy"))
    assert abs(float(v) - true_pixel(film, 0)[1]) > 0.5
    there = projection.straightened(*projection.distorted(u, v))
    np.testing.assert_allclose(there, (u, v), atol=1e-9)


def test_the_same_seed_gives_the_same_file_and_another_seed_other_noise(run, tmp_path):
    files = [tmp_path / f"{i}.mp4" for i in range(3)]
    short = run.isel(time=slice(0, 40))
    for file, seed in zip(files, (5, 5, 6), strict=True):
        synthesise_video(short, file, camera=SMALL, seed=seed)
    one, same, other = (file.read_bytes() for file in files)
    assert one == same
    assert one != other


def test_balls_that_touch_in_an_exposure_are_flagged_and_the_left_one_mirrors_the_right(pair):
    film = prepare(pair, Scene(), SMALL)
    truth = film.truth()
    half = 0.5 * SMALL.exposure / SMALL.fps
    for number, time in enumerate(film.begin + film.times):
        hit = bool(np.any(np.abs(pair.contact_time - time) <= half))
        assert bool(truth.is_contact[number]) == hit
        assert str(truth.flag_2[number].values) == ("collision" if hit else "ok")
    np.testing.assert_array_equal(truth.angle_2, -truth.angle_1)
    touching = 2.0 * math.asin(0.02 / 0.245)
    assert float((truth.angle_1 - truth.angle_2).min()) >= touching - 1e-3


def test_a_ball_behind_the_post_is_flagged_and_not_seen(run):
    film = prepare(run, dataclasses.replace(ALONE, post_width=0.1, post_x=0.0), SMALL)
    truth = film.truth()
    number = int(np.argmin(np.abs(truth.angle_1.values)))
    assert float(truth.covered_1[number]) == pytest.approx(1.0)
    assert str(truth.flag_1[number].values) == "occluded"
    assert np.abs(film.picture(number) - film.renderer.background).max() < 0.02
    assert str(truth.flag_1[0].values) == "ok"


@pytest.mark.parametrize(
    "camera", [{}, {"roll": 0.4, "yaw": 0.5}, {"roll": -1.0, "k1": -0.12}, {"k1": 0.1, "blur": 2.0}]
)
def test_nothing_that_moves_is_cut_off(run, camera, monkeypatch):
    scene = Scene(ball_radius=0.02, post_width=0.05, post_x=0.1, hand_radius=0.04, hand_time=0.4)
    film = prepare(run, scene, dataclasses.replace(SMALL, **camera))
    numbers = range(0, len(film.stamps), 6)
    pictures = [film.picture(number) for number in numbers]
    whole = (0, 0, SMALL.width, SMALL.height)
    monkeypatch.setattr("latolato.experiment.synthetic.picture.Renderer._box_of", lambda *_: whole)
    for number, picture in zip(numbers, pictures, strict=True):
        assert np.abs(film.picture(number) - picture).max() < 1e-6


@pytest.mark.parametrize("part", ["block_height", "block_width", "rod_width", "bolt_radius"])
def test_a_part_without_size_is_left_out(run, part):
    scene = Scene(ambient=1.0, rail_width=0.0)
    whole, without = (
        prepare(run, each, SMALL).picture(3)
        for each in (scene, dataclasses.replace(scene, **{part: 0.0}))
    )
    assert np.isfinite(without).all()
    assert np.abs(whole - without).max() > 0.1


@pytest.mark.parametrize("name", conditions)
def test_every_condition_paints_frames_of_its_size(pair, name):
    scene, camera = conditions[name].make(camera={"width": 320, "height": 240, "row_time": 0.0})
    film = prepare(pair, scene, camera, seed=2)
    planes = film.frame(3)
    turned = camera.rotation in (90, 270)
    assert planes.shape == ((480, 240) if turned else (360, 320))
    assert planes.std() > 3.0  # codes: something is seen


def test_the_command_prints_clicks_that_lie_on_the_ball(tmp_path, capsys):
    video, table = tmp_path / "clip.mp4", tmp_path / "truth.csv"
    arguments = (
        f"synthesise fig02 --duration 0.2 --output {video} --truth {table} --camera width=320 "
        "--camera height=240 --seed 4 --json"
    )
    assert main([*arguments.split(), "--camera", "roll = 7 deg"]) == 0
    result = json.loads(capsys.readouterr().out)
    truth = read_table(table)
    assert result["frames"] == truth.sizes["frame"] == 12
    assert result["ball"][0][0] == pytest.approx(truth.attrs["ball_1_pixel_u"], abs=0.01)
    assert truth.attrs["gravity_direction"] == pytest.approx(np.radians(7.0))
    assert video.stat().st_size > 1000


def test_the_command_that_tracks_the_video_declares_its_camera(tmp_path, capsys):
    video = tmp_path / "clip.mp4"
    arguments = f"synthesise fig02 --duration 0.1 --output {video} --camera row_time=15e-6"
    more = "--camera width=320 --camera height=240 --camera k1=-0.02 --camera focal_length=100"
    assert main([*arguments.split(), *more.split()]) == 0
    # In units of half the diagonal, 200 pixels, instead of the focal length.
    assert "--row-time 1.5e-05 --lens-k1 -0.08\n" in capsys.readouterr().out


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"width": 641}, "width must be even and in [64, 4096] pixels, got 641"),
        ({"rotation": 45}, "rotation must be one of 0, 90, 180, 270 deg, got 45"),
        ({"fps": 0.0}, "fps must lie in [1, 1000] 1/s, got 0; give at least 1"),
        ({"crf": 52}, "crf must lie in [0, 51], got 52"),
        ({"row_time": 1.0}, "row_time must let 960 rows fit"),
    ],
)
def test_impossible_cameras_are_refused(arguments, message):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 - the message is compared below
        Camera(**arguments)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    "options, message",
    [
        ("--scene background=fog", "background must be 'plain', 'gradient', 'texture' or 'wood'"),
        ("--camera fsp=3", "--camera has no 'fsp': did you mean 'fps'?"),
        ("--scene ball_colour=red", "ball_colour must be a colour such as '#e8590c', got 'red'"),
        ("--radius 0.02", '--scene "ball_radius = 0.02"'),
        ("--camera crf=x", "crf must be a whole number, got 'x'"),
        ("--seed -1", "seed must be a whole number of at least 0, got -1"),
        ("--truth t.txt", "the name of a track table must end in"),
        ("--camera k1=-0.5", "k1, k2 must not fold the picture"),
    ],
)
def test_bad_options_are_refused_in_one_line_and_nothing_is_written(
    tmp_path, capsys, options, message
):
    video = tmp_path / "clip.mp4"
    arguments = f"synthesise fig02 --duration 0.1 --output {video} {options}"
    assert main(arguments.split()) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "up, aside, source, text",
    [
        (0.0, 0.02, "swing", "20 mm to each side at 8 rad/s (1.2732 Hz)"),
        (0.03, 0.0, "drive axis", "30 mm at 8 rad/s (1.2732 Hz)"),
        (0.03, 0.0, "vertical drive", "30 mm at 8 rad/s (1.2732 Hz), its axis taken as vertical"),
        (0.0, 0.0, "swing", "rests"),
    ],
)
def test_a_pivot_is_described_as_it_moves(up, aside, source, text):
    drive = ll.PlanarHarmonic(
        vertical_amplitude=up, horizontal_amplitude=aside, drive_frequency=8.0
    )
    swing = ll.simulate(ll.Pendulum(length=0.3, mass=0.1), drive, initial_angle=0.3, duration=4.0)
    table = prepare(swing, camera=Camera(width=64, height=64)).truth()
    attributes = {**table.attrs, "geometry": "metric", "gravity_source": source}
    told = pivot_text({**attributes, **pivot_numbers(table)})
    assert told.partition(":")[0] == text


def test_what_is_no_run_is_refused(run, tmp_path):
    with pytest.raises(InputError, match="needs a run"):
        synthesise_video(run.drop_attrs(), tmp_path / "clip.mp4")


def test_the_same_pictures_are_always_encoded_alike(tmp_path):
    # Large enough for the encoder's fast paths; x264 with AVX-512 failed this one time in four.
    random = np.random.default_rng(7)
    still = random.integers(60, 200, (360, 320), dtype=np.uint8)
    pictures = [(3000 * k, np.roll(still, 2 * k, axis=1)) for k in range(60)]
    files = []
    for number in range(8):
        path = tmp_path / f"{number}.mp4"
        write_video(path, iter(pictures), fps=30.0, crf=18, rotation=0)
        files.append(path.read_bytes())
    assert all(content == files[0] for content in files)
