"""Places that are set by hand: they stand in the table, and tracking goes on from them."""

import av
import numpy as np
import pytest

import latolato as ll
from latolato.cli.main import main
from latolato.core.errors import InputError
from latolato.experiment.encode import TICKS, write_video
from latolato.experiment.sidecar import read_sidecar, sidecar_path
from latolato.experiment.track_table import read_table

# Frames in which the ball cannot be seen.
HIDDEN = range(50, 85)


@pytest.fixture(scope="session")
def covered(swing, tmp_path_factory):
    """A swing that is hidden for longer than the equation of motion carries it."""
    path = tmp_path_factory.mktemp("covered") / "covered.mp4"

    with av.open(str(swing.path)) as file:
        pictures = [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]
    wall = np.median(pictures[::5], axis=0).astype(np.uint8)

    def planes():
        for number, (time, picture) in enumerate(
            zip(swing.truth.time.values, pictures, strict=True)
        ):
            if number in HIDDEN:
                picture[80:] = wall[80:]
            each = av.VideoFrame.from_ndarray(picture, format="rgb24")
            yield round(time * TICKS), each.to_ndarray(format="yuv420p")

    write_video(path, planes(), fps=60.0, crf=20, rotation=0)
    return path


def _by_hand(clip, number):
    """The option that says where somebody sees the ball."""
    _, (ball,) = clip.places_at(number)
    return ["--correct", "{}:1:{:g},{:g}".format(number, *ball)]


def test_a_place_set_by_hand_is_kept_and_tracking_goes_on_from_it(swing, covered, tmp_path):
    output = tmp_path / "covered.csv"
    assert main(["track", str(covered), *swing.options, "--output", str(output)]) == 0
    before = read_table(output)
    assert before.flag_1.values[80] == "lost"
    for number in (76, 78):  # the second joins the first
        assert main(["track", str(covered), *_by_hand(swing, number), "--output", str(output)]) == 0
    table = read_table(output)
    flags = table.flag_1.values
    assert set(flags[[76, 78]]) == {"manual"}
    pixel = 1.0 / table.attrs["arm_pixels"]
    error = np.abs(table.angle_1.values - swing.truth.angle_1.values)
    assert error[[76, 78]].max() < 1.5 * pixel
    assert table.angle_sigma_1.values[[76, 78]] == pytest.approx(pixel, rel=0.5)
    # Two places tell the velocity: carried on from there until it is seen again.
    assert set(flags[79 : HIDDEN.stop]) == {"predicted"}
    assert error[HIDDEN.stop - 1] < 15.0 * pixel
    assert (flags[HIDDEN.stop :] == "ok").mean() > 0.95
    # Before the first of them nothing is changed.
    np.testing.assert_allclose(table.angle_1[:40], before.angle_1[:40], atol=1e-3)
    setup = read_sidecar(sidecar_path(output), covered)
    assert [one[:2] for one in setup.corrections] == [(76, 1), (78, 1)]
    first = output.read_text()
    assert main(["track", str(covered), "--output", str(output)]) == 0
    assert output.read_text() == first


def test_a_ball_that_was_followed_wrongly_is_put_right(swing):
    right = ll.track(swing.path, pivot=swing.pivot, balls=swing.balls, length=swing.length)
    _, (ball,) = swing.places_at(60)
    aside = (ball[0] - 40.0, ball[1] + 20.0)  # two radii and more from where it is
    table = ll.track(
        swing.path,
        pivot=swing.pivot,
        balls=swing.balls,
        length=swing.length,
        corrections={60: {1: aside}, 62: {1: swing.places_at(62)[1][0]}},
    )
    assert table.flag_1.values[60] == table.flag_1.values[62] == "manual"
    assert abs(float(table.angle_1[60] - right.angle_1[60])) > 0.1
    np.testing.assert_allclose(table.angle_1[66:], right.angle_1[66:], atol=2e-3)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_place_is_set_by_hand_without_a_pivot_too(swing):
    place = swing.places_at(30)[1][0]
    settings = {"pivot": "outside", "balls": swing.balls, "end": 1.0}
    table = ll.track(swing.path, **settings, corrections={30: {1: place}})
    assert table.flag_1.values[30] == "manual"
    assert np.isin(table.flag_1.values, ["ok", "manual"]).mean() > 0.9


@pytest.mark.parametrize(
    "corrections, match",
    [
        ({30: {1: (400.0, 20.0)}}, r"correction of ball 1 in frame 30 at \(400, 20\) lies outside"),
        ({30: {2: (40.0, 20.0)}}, "ball 2 is corrected in frame 30, but there is only one"),
        ({150: {1: (40.0, 20.0)}}, "frame 150 is corrected, but only frames 0 to 149 are used"),
        ({30: {3: (40.0, 20.0)}}, r"ball of a correction must lie in \[1, 2\], got 3"),
        ({30: {1: (40.0,)}}, "corrections must be"),
    ],
)
def test_a_correction_that_is_none_is_refused(swing, corrections, match):
    with pytest.raises(InputError, match=match):
        ll.track(swing.path, pivot=swing.pivot, balls=swing.balls, corrections=corrections)


@pytest.mark.parametrize("text", ["30", "30:1", "a:1:3,4", "30:1:3", "30:1:3,4,5", "-3:1:3,4"])
def test_a_correction_on_the_command_line_has_four_numbers(swing, capsys, text):
    assert main(["track", str(swing.path), "--correct", text]) == 2
    assert "--correct must be" in capsys.readouterr().err
