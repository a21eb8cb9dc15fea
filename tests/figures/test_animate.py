"""Animations show the run to scale, at the asked speed, and are written whole or not at all."""

import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import latolato as ll
from latolato.core.errors import InputError
from latolato.figures import style
from latolato.figures.animate import MOST_FRAMES, SIZES, Scene, animate, string_points

TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=0.9)
DRIVE = ll.Harmonic(drive_amplitude=0.2, drive_frequency=6.26)
BALL = ll.Ball(length=1.0, mass=0.8, radius=0.1)
SIZE = SIZES[".mp4"]
OUTLINE = 2.4  # pixels of a ball's width that its outline covers


@pytest.fixture(scope="module")
def run():
    return ll.simulate(TOY, DRIVE, initial_angle=1.0, duration=2.0)


def scene(run, size=SIZE):
    with style.use_style():
        return Scene(run, size, "")


def blob(picture, colour):
    """Columns and rows of the pixels of one colour in the left part, where the toy is."""
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])
    part = picture[:, : int(0.43 * picture.shape[1]), :3].astype(int)
    rows, columns = np.nonzero(np.abs(part - wanted).max(axis=2) < 12)
    return SimpleNamespace(x=columns, y=rows, width=np.ptp(columns) + 1, height=np.ptp(rows) + 1)


@pytest.mark.parametrize("instant", [0.0, 0.37, 1.9])
def test_balls_and_rods_are_drawn_to_scale(run, instant):
    picture = scene(run).picture(instant)
    right, left = blob(picture, style.BLUE), blob(picture, style.RED)
    angle = float(np.interp(instant, run.time, run.angle))
    scale = (right.width + OUTLINE) / (2.0 * TOY.radius)  # pixels per metre
    apart = right.x.mean() - left.x.mean()
    # one pixel in a width of about 30
    assert apart / scale == pytest.approx(2.0 * math.sin(angle), rel=0.035)
    assert right.width == pytest.approx(right.height, abs=2)  # round, to one pixel at each end
    assert right.y.mean() == pytest.approx(left.y.mean(), abs=1)  # mirror-symmetric


def test_the_balls_touch_when_they_collide(run):
    instant = float(run.contact_time[0])
    picture = scene(run).picture(instant)
    right, left = blob(picture, style.BLUE), blob(picture, style.RED)
    # the outlines of both balls, 0.6 points or 1.1 pixels each, lie between the fills
    assert 0 < right.x.min() - left.x.max() <= 4


def test_the_pivot_moves_with_the_drive(run):
    moving = scene(run)
    up, down = (blob(moving.picture(t), style.GREY) for t in (0.0, math.pi / 6.26))
    ball = blob(moving.picture(0.0), style.BLUE)
    scale = (ball.width + OUTLINE) / (2.0 * TOY.radius)
    travelled = (down.y.mean() - up.y.mean()) / scale
    assert travelled == pytest.approx(2.0 * 0.2, rel=0.07)  # one pixel in 30, two in 60


def test_a_picture_does_not_depend_on_those_before(run):
    moving = scene(run)
    first = moving.picture(0.5).copy()
    moving.picture(1.7)
    np.testing.assert_array_equal(moving.picture(0.5), first)


def test_the_cursor_moves_over_the_curve(run):
    moving = scene(run)

    def cursor(instant):
        right = moving.picture(instant)[100:400, int(0.5 * SIZE[0]) :, :3]
        dark = (right.max(axis=2) < 80).sum(axis=0)
        return np.flatnonzero(dark > 250).max()

    assert cursor(0.5) < cursor(1.0) < cursor(1.5)


def test_two_different_balls_have_their_own_sizes():
    right = ll.Ball(length=1.0, mass=0.8, radius=0.05)
    left = ll.Ball(length=0.9, mass=0.8, radius=0.15)
    pair = ll.BallPair(right=right, left=left)
    run = ll.simulate(pair, initial_angle=(0.8, -0.6), duration=1.0)
    picture = scene(run).picture(0.0)
    widths = [blob(picture, colour).width + OUTLINE for colour in (style.RED, style.BLUE)]
    assert widths[0] / widths[1] == pytest.approx(3.0, rel=0.06)  # one pixel of about 20


@pytest.mark.parametrize(
    "system", [ll.Pendulum(length=1.0, mass=1.0), ll.Mathieu(length=1.0, mass=1.0)]
)
def test_a_pendulum_without_a_radius_is_shown_with_a_ball(system):
    run = ll.simulate(system, initial_angle=0.5, duration=1.0)
    assert blob(scene(run).picture(0.0), style.BLUE).width > 5


@given(share=st.floats(0.0, 1.0 - 2e-6), angle=st.floats(0.0, 6.3), length=st.floats(0.05, 2.0))
def test_a_slack_string_is_drawn_with_its_own_length(share, angle, length):
    x, y = share * length * math.sin(angle), -share * length * math.cos(angle)
    points = string_points(x, y, length)
    np.testing.assert_allclose(points[:, [0, -1]], [[0.0, x], [0.0, y]], atol=1e-15 * length)
    drawn = np.hypot(*np.diff(points)).sum()
    # 32 chords: a parabola folded back on itself lacks 1/32^2 of its length at its bend.
    assert drawn == pytest.approx(length, rel=1e-3)
    assert (points[1] <= max(0.0, y) + 1e-15).all()  # it hangs


def test_a_taut_string_is_a_straight_line():
    np.testing.assert_array_equal(string_points(0.6, -0.8, 1.0), [[0.0, 0.6], [0.0, -0.8]])


def test_slack_balls_under_a_pivot_that_moves_sideways_are_drawn_where_they_are():
    pair = ll.BallPair(right=BALL, left=BALL, suspension="string")
    drive = ll.PlanarHarmonic(
        vertical_amplitude=0.2, horizontal_amplitude=0.3, drive_frequency=9.0, horizontal_phase=1.0
    )
    start = {"initial_angle": (0.6, -0.5), "initial_distance": (0.6, 0.8)}
    run = ll.simulate(pair, drive, **start, duration=1.0)
    moving, places, drawn = scene(run), [], []
    for at in (0, 30, -1):
        now, picture = run.isel(time=at), moving.picture(float(run.time[at]))
        for ball, colour in (("right", style.BLUE), ("left", style.RED)):
            there, of_ball = blob(picture, colour), now.sel(ball=ball)
            distance, angle = float(of_ball.distance), float(of_ball.angle)
            across = float(now.pivot_across) + distance * math.sin(angle)
            up = float(now.pivot_height) - distance * math.cos(angle)
            places.append((across, up))
            drawn.append((there.x.mean(), -there.y.mean()))
    apart, seen = (np.array(each) - each[0] for each in (places, drawn))
    scale = (there.width + OUTLINE) / (2.0 * BALL.radius)
    # one pixel of either centre, and one in the width of 20 of a ball
    np.testing.assert_allclose(seen / scale, apart, rtol=0.05, atol=2.0 / scale)


def test_an_mp4_has_the_asked_frames_and_duration(run, tmp_path):
    av = pytest.importorskip("av", reason="MP4 needs the extra 'video'")
    done = []
    path = animate(run, tmp_path / "run.mp4", speed=2.0, fps=25, progress=done.append)
    with av.open(str(path)) as film:
        stream = film.streams.video[0]
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(stream)]
        assert (stream.width, stream.height) == SIZE
        assert stream.average_rate == 25
        assert stream.codec_context.pix_fmt == "yuv420p"  # what browsers play
    assert len(frames) == 26  # one second and its first frame
    assert done[-1] == 1.0
    assert done == sorted(done)
    # the loss of H.264 at this quality is less than half of what another instant would differ by
    right, wrong = (
        np.abs(frames[-1].astype(int) - scene(run).picture(instant)[:, :, :3]).mean()
        for instant in (2.0, 1.0)
    )
    assert 2.0 * right < wrong


def test_a_gif_has_the_asked_duration_and_shows_the_run(run, tmp_path):
    path = animate(run, tmp_path / "run.gif", speed=2.0, fps=25)
    with Image.open(path) as film:
        assert film.size == SIZES[".gif"]
        assert film.info["loop"] == 0
        assert film.n_frames == 26
        assert film.info["duration"] == 40
        moving = scene(run, film.size)
        for index in (0, 10, 25):
            film.seek(index)
            shown = np.asarray(film.convert("RGB")).astype(int)
            wanted = moving.picture(index / 25 * 2.0)[:, :, :3].astype(int)
            other = moving.picture((index + 13) / 25 * 2.0 % 2.0)[:, :, :3].astype(int)
            # the loss of 255 colours is less than half of what another instant would differ by
            assert 2.0 * np.abs(shown - wanted).mean() < np.abs(shown - other).mean()
            assert (shown[-60, 60] == 255).all()  # the ground stays white


def test_a_run_that_ends_early_is_shown_up_to_its_end(tmp_path):
    run = ll.simulate(TOY, DRIVE, initial_angle=1.0, duration=2.0)
    run["angle"][run.time > 1.0] = np.nan
    with Image.open(animate(run, tmp_path / "run.gif", fps=10)) as film:
        assert film.n_frames in (10, 11)  # the last sample may lie just before 1 s


@pytest.mark.parametrize(
    "options, message",
    [
        ({"speed": 0.0}, r"speed must lie in \(0, 1e\+06\], got 0"),
        ({"speed": math.nan}, "speed must be a number, got nan"),
        ({"fps": 0.5}, r"fps must lie in \[1, 100\] Hz, got 0.5"),
        ({"fps": 1000.0}, r"fps must lie in \[1, 100\]"),
        ({"speed": 1e-4}, f"may have {MOST_FRAMES} frames, got .*; raise speed"),
    ],
)
def test_numbers_out_of_range_are_refused_and_nothing_is_written(run, tmp_path, options, message):
    with pytest.raises(ValueError, match=message):
        animate(run, tmp_path / "run.gif", **options)
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_suffix_is_refused_with_the_known_ones(run, tmp_path):
    with pytest.raises(ValueError, match=r"must end in \.mp4, \.gif, got 'run.avi'"):
        animate(run, tmp_path / "run.avi")


def test_a_dataset_that_is_no_run_is_refused(run, tmp_path):
    with pytest.raises(ValueError, match="animate needs a run"):
        animate(run.drop_vars("angle"), tmp_path / "run.gif")


def test_mp4_without_its_extra_names_it(run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(InputError, match=r'pip install "\.\[video\]", or write a \.gif'):
        animate(run, tmp_path / "run.mp4")


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_an_interrupted_animation_leaves_no_file(run, tmp_path, suffix):
    if suffix == ".mp4":
        pytest.importorskip("av", reason="MP4 needs the extra 'video'")

    def interrupt(_):
        assert list(tmp_path.iterdir()), "it should have begun to write"
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        animate(run, tmp_path / f"run{suffix}", progress=interrupt)
    assert list(tmp_path.iterdir()) == []
