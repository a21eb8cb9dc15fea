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
    with av.open(str(swing.path)) as file:
        frames = [(f.time, f.to_ndarray(format="rgb24")) for f in file.decode(video=0)]
    # Frame 38 has the ball far from where it is in frames 0 to 14.
    late = [(t, frames[38][1] if k < 15 else picture) for k, (t, picture) in enumerate(frames)]
    wall = np.median([picture for _, picture in frames[::5]], axis=0).astype(np.uint8)
    late = [(t, wall if k < 15 else picture) for k, (t, picture) in enumerate(late)]
    path = tmp_path / "late.mp4"
    planes = (
        (
            round(t * TICKS),
            av.VideoFrame.from_ndarray(p, format="rgb24").to_ndarray(format="yuv420p"),
        )
        for t, p in late
    )
    write_video(path, planes, fps=60.0, crf=20, rotation=0)
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
        ({"start": 1.0, "end": 1.1}, "7 frames, a motion needs 8 or more"),
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
