"""Which frames of a video are used, and in which of them pivot and balls are pointed at."""

import av
import numpy as np
import pytest

import latolato as ll
from latolato.cli.main import main
from latolato.core.errors import InputError
from latolato.experiment.encode import TICKS, write_video
from latolato.experiment.sidecar import read_sidecar, sidecar_path
from latolato.experiment.track_table import read_table
from latolato.experiment.video import open_video


def _pictures(clip):
    """Return the pictures of a clip, red, green and blue."""
    with av.open(str(clip.path)) as file:
        return [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]


def _changed(clip, path, change):
    """Write a clip whose pictures are changed by a function of their number."""
    pictures = (change(number, picture) for number, picture in enumerate(_pictures(clip)))
    planes = (
        (round(time * TICKS), av.VideoFrame.from_ndarray(picture, format="rgb24"))
        for time, picture in zip(clip.truth.time.values, pictures, strict=True)
    )
    frames = ((stamp, frame.to_ndarray(format="yuv420p")) for stamp, frame in planes)
    write_video(path, frames, fps=60.0, crf=20, rotation=0)
    return path


def _assert_true(table, clip, ball=1):
    """Check the angles of a table, and that most of them were measured."""
    ok = table[f"flag_{ball}"].values != "lost"
    truth = clip.truth.isel(frame=table.frame.values)
    np.testing.assert_allclose(table.time, truth.time, atol=1e-9)
    error = (table[f"angle_{ball}"].values - truth[f"angle_{ball}"].values)[ok]
    assert ok.mean() > 0.95
    assert np.sqrt(np.mean(error**2)) < 4e-3  # a pixel is 8 mrad here


def test_a_part_of_a_video_has_the_rows_of_its_frames_and_is_made_again(swing, tmp_path, capsys):
    output, overlay = tmp_path / "part.csv", tmp_path / "part.mp4"
    pivot, balls = swing.places_at(30)
    arguments = ["track", str(swing.path), "--start", "500 ms", "--end", "1.8 s",
                 "--pivot", "{},{}".format(*pivot), "--ball", "{},{}".format(*balls[0]),
                 "--length", f"{swing.length} m"]  # fmt: skip
    assert main([*arguments, "--output", str(output), "--overlay", str(overlay)]) == 0
    table = read_table(output)
    assert table.frame.values.tolist() == list(range(30, 109))
    _assert_true(table, swing)
    assert len(list(open_video(overlay).frames())) == table.sizes["frame"]
    setup = read_sidecar(sidecar_path(output), swing.path)
    assert (setup.start, setup.end, setup.click_frame) == (0.5, 1.8, 30)
    first = output.read_text()
    assert main(["track", str(swing.path), "--output", str(output)]) == 0
    assert "set-up read from" in capsys.readouterr().out
    assert output.read_text() == first


@pytest.mark.parametrize("part", [{}, {"start": 0.3}, {"end": 1.0}])
def test_balls_are_pointed_at_in_any_frame_in_or_beside_the_part(toy, part):
    pivot, balls = toy.places_at(70)
    table = ll.track(toy.path, pivot=pivot, balls=balls, length=toy.length, click_frame=70, **part)
    for ball in (1, 2):
        _assert_true(table, toy, ball)


def test_balls_are_found_in_the_frame_that_is_chosen(swing):
    pivot, balls = swing.places_at(120)
    with pytest.warns(RuntimeWarning, match="found in the video"):
        table = ll.track(swing.path, length=swing.length, click_frame=120)
    found = [table.attrs[f"ball_1_pixel_{axis}"] for axis in "uv"]
    assert np.hypot(*np.subtract(found, balls[0])) < 2.0
    assert abs(table.attrs["pivot_pixel_v"] - pivot[1]) < 3.0
    _assert_true(table, swing)


def test_a_ball_that_comes_later_is_pointed_at_where_it_is(swing, tmp_path):
    wall = np.median(_pictures(swing), axis=0).astype(np.uint8)
    path = _changed(swing, tmp_path / "late.mp4", lambda k, each: wall if k < 15 else each)
    pivot, balls = swing.places_at(40)
    table = ll.track(path, pivot=pivot, balls=balls, length=swing.length, click_frame=40)
    flags = table.flag_1.values
    assert set(flags[:15]) == {"lost"}
    assert (flags[15:] == "ok").mean() > 0.95
    ok = flags == "ok"
    error = (table.angle_1.values - swing.truth.angle_1.values)[ok]
    assert np.sqrt(np.mean(error**2)) < 4e-3


@pytest.mark.parametrize(
    "settings, match",
    [
        ({"start": 2.0, "end": 1.0}, r"end must lie after start \(2 s\), got 1"),
        ({"start": 9.0}, "start must lie before the end of the video at 2.48333 s, got 9"),
        ({"start": 1.001, "end": 1.002}, "no frame lies between start"),
        ({"start": 1.0, "end": 1.1}, "too few frames .7.: tracking needs at least 8"),
        ({"click_frame": 150}, "the video has no frame 150"),
        ({"click_frame": -1}, "click_frame must lie in"),
    ],
)
def test_a_part_without_a_motion_is_refused(swing, settings, match):
    with pytest.raises(InputError, match=match):
        ll.track(swing.path, pivot=swing.pivot, balls=swing.balls, **settings)


def test_the_frame_of_a_set_up_stays_that_of_its_places(swing, tmp_path):
    sidecar = tmp_path / "one.toml"
    ll.track(swing.path, pivot=swing.pivot, balls=swing.balls, length=swing.length, sidecar=sidecar)
    with pytest.raises(InputError, match="click_frame is 0 in"):
        ll.track(swing.path, sidecar=sidecar, click_frame=5)
    with pytest.warns(RuntimeWarning, match="set-up read"):
        table = ll.track(swing.path, sidecar=sidecar, start=1.0)
    assert int(table.frame[0]) == 60
    _assert_true(table, swing)


@pytest.fixture(scope="session")
def fair(swing, tmp_path_factory):
    """A swing below a larger ball that runs to and fro."""
    v, u = np.mgrid[:240, :320]

    def disturbed(number, picture):
        picture = picture.copy()
        picture[np.hypot(u - 160 - 130 * np.cos(0.06 * number), v - 20) < 14] = (20, 60, 200)
        return picture

    return _changed(swing, tmp_path_factory.mktemp("fair") / "fair.mp4", disturbed)


def test_balls_are_looked_for_in_the_region_only(swing, fair):
    with pytest.warns(RuntimeWarning, match="found in the video"):
        table = ll.track(fair, length=swing.length, region=(0, 60, 319, 239))
    assert table.attrs["region"] == "0,60,319,239"
    _assert_true(table, swing)
    # A pivot that is known tells as well which of the two swings about it.
    with pytest.warns(RuntimeWarning, match="found in the video"):
        table = ll.track(fair, balls=1, pivot=swing.pivot, length=swing.length)
    _assert_true(table, swing)


def test_a_ball_outside_the_region_is_not_seen(swing, tmp_path):
    output = tmp_path / "part.csv"
    arguments = ["track", str(swing.path), *swing.options, "--output", str(output)]
    assert main([*arguments, "--region", "150,100,319,239"]) == 0
    table = read_table(output)
    truth = swing.truth.ball_1_x.values - swing.truth.pivot_x.values
    outside = truth < -0.1
    assert outside.any()
    assert set(table.flag_1.values[outside]) <= {"predicted", "lost"}
    inside = truth > 0.0
    assert np.isin(table.flag_1.values[inside], ["ok", "occluded"]).mean() > 0.95
    error = (table.angle_1.values - swing.truth.angle_1.values)[table.flag_1.values == "ok"]
    assert np.sqrt(np.mean(error**2)) < 4e-3
    first = output.read_text()
    assert main(["track", str(swing.path), "--output", str(output)]) == 0
    assert output.read_text() == first


@pytest.mark.parametrize(
    "region, match",
    [
        ((10, 10, 5, 50), "region must be left, top, right and bottom in pixels"),
        ((10, 10, 50), "region must be left, top, right and bottom in pixels"),
        ((0, 0, 100, 100), "lies outside the region from"),
    ],
)
def test_a_region_that_is_none_is_refused(swing, region, match):
    with pytest.raises(InputError, match=match):
        ll.track(swing.path, pivot=swing.pivot, balls=swing.balls, region=region)


def test_a_region_may_be_larger_than_the_picture_but_not_beside_it(swing):
    table = ll.track(
        swing.path, pivot=swing.pivot, balls=swing.balls, length=swing.length,
        region=(-10, 0, 320, 240),
    )  # fmt: skip
    _assert_true(table, swing)
    with pytest.raises(InputError, match=r"region from \(320, 0\) to \(400, 90\) lies outside"):
        ll.track(swing.path, region=(320, 0, 400, 90))


def test_a_picture_that_stands_on_its_head_is_refused(swing, tmp_path):
    path = _changed(swing, tmp_path / "turned.mp4", lambda k, each: each[::-1, ::-1].copy())
    (u, v), balls = swing.pivot, [(319 - x, 239 - y) for x, y in swing.balls]
    with pytest.raises(InputError, match="is upside down") as caught:
        ll.track(path, pivot=(319 - u, 239 - v), balls=balls, length=swing.length)
    assert "ffmpeg" in caught.value.way_out
