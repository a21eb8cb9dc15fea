"""A track: its columns, its set-up, what is drawn of it, and many at once."""

import json
import re

import numpy as np
import pytest

import latolato as ll
from latolato.cli.main import main
from latolato.experiment.overlay import places_of
from latolato.experiment.sidecar import Setup, read_sidecar, sidecar_path, write_sidecar
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.task import prepare
from latolato.experiment.track_table import read_table
from latolato.experiment.tracking.learn import learn_image_model
from latolato.experiment.tracking.propose import propose
from latolato.experiment.tracking.sample import read_sample
from latolato.experiment.video import open_video

COLUMNS_1 = "frame,time,pivot_x,pivot_y,ball_1_x,ball_1_y,angle_1,angle_sigma_1,flag_1"
COLUMNS_2 = (
    "frame,time,pivot_x,pivot_y,ball_1_x,ball_1_y,ball_2_x,ball_2_y,"
    "angle_1,angle_2,angle_sigma_1,angle_sigma_2,flag_1,flag_2"
)


@pytest.fixture(scope="session")
def tracked(swing, tmp_path_factory):
    """The folder that the command line wrote for one ball."""
    folder = tmp_path_factory.mktemp("tracked")
    names = {"output": "swing.csv", "overlay": "swing.mp4", "report": "swing.html"}
    targets = [part for key, name in names.items() for part in (f"--{key}", str(folder / name))]
    assert main(["track", str(swing.path), *swing.options, *targets]) == 0
    return folder


def test_the_table_has_its_columns_header_and_one_row_per_frame(swing, tracked):
    lines = (tracked / "swing.csv").read_text().splitlines()
    rows = [line for line in lines if not line.startswith("#")]
    assert rows[0] == COLUMNS_1
    assert len(rows) == 1 + swing.truth.sizes["frame"]
    assert "# table: track" in lines
    assert "# source: swing.mp4" in lines


def test_angles_and_times_are_those_of_the_truth(swing, tracked):
    table = read_table(tracked / "swing.csv")
    np.testing.assert_allclose(table.time, swing.truth.time, atol=1e-9)
    ok = table.flag_1.values == "ok"
    assert ok.mean() > 0.95
    error = (table.angle_1 - swing.truth.angle_1).values[ok]
    assert np.sqrt(np.mean(error**2)) < 4e-3  # a pixel is 8 mrad here


def test_a_sidecar_makes_the_identical_table_again(swing, tracked, tmp_path, capsys):
    sidecar, again = sidecar_path(tracked / "swing.csv"), tmp_path / "again.csv"
    assert main(["track", str(swing.path), "--sidecar", str(sidecar), "--output", str(again)]) == 0
    assert f"set-up read from {sidecar}\n" in capsys.readouterr().out
    assert again.read_text() == (tracked / "swing.csv").read_text()
    # A table's own set-up needs no naming.
    assert main(["track", str(swing.path), "--output", str(again)]) == 0
    assert f"set-up read from {sidecar_path(again)}\n" in capsys.readouterr().out
    assert again.read_text() == (tracked / "swing.csv").read_text()


def test_a_click_lives_on_in_no_other_table(swing, tmp_path, capsys):
    wrong = Setup(pivot=(300.0, 200.0), balls=((20.0, 20.0),))
    for earlier in (tmp_path / "wrong.csv", swing.path):
        write_sidecar(wrong, swing.path, sidecar_path(earlier))
    try:
        arguments = ["track", str(swing.path), "--length", f"{swing.length} m", "--json"]
        assert main([*arguments, "--output", str(tmp_path / "right.csv")]) == 0
        found = json.loads(capsys.readouterr().out)
        assert main([*arguments, "--propose", "--output", str(tmp_path / "right.png")]) == 0
        proposed = json.loads(capsys.readouterr().out)
    finally:
        sidecar_path(swing.path).unlink()
    assert found["setup_file"] is None
    assert any("found in the video" in text for text in found["warnings"])
    assert read_sidecar(sidecar_path(tmp_path / "wrong.csv"), swing.path) == wrong
    assert np.hypot(*(np.array(proposed["ball"][0]) - swing.balls[0])) < 2.0
    assert proposed["setup_file"] is None


def test_a_set_up_of_another_video_is_replaced_with_its_table(swing, toy, tmp_path, capsys):
    output = tmp_path / "one.csv"
    setup = Setup(pivot=toy.pivot, balls=tuple(toy.balls))
    write_sidecar(setup, toy.path, sidecar_path(output))
    assert main(["track", str(swing.path), "--length", "36.3 cm", "--output", str(output)]) == 0
    assert "set-up read from" not in capsys.readouterr().out
    assert len(read_sidecar(sidecar_path(output), swing.path).balls) == 1


def test_a_sidecar_that_is_read_is_warned_of_and_so_is_what_was_found_for_it(swing, tmp_path):
    setup = Setup(
        pivot=swing.pivot, balls=tuple(swing.balls), length=swing.length, is_proposed=True
    )
    sidecar = write_sidecar(setup, swing.path, tmp_path / "one.toml")
    with pytest.warns(RuntimeWarning) as told:
        table = ll.track(swing.path, sidecar=sidecar)
    texts = [str(one.message) for one in told]
    assert texts[0] == f"set-up read from {sidecar}"
    assert texts[1].startswith("found in the video: --pivot")
    assert table.attrs["warnings"] == texts[1]


@pytest.mark.parametrize(
    "name, value, reason",
    [
        ("slow_motion", None, "must be a number, got None"),
        ("corrections", None, "must be a list, got None"),
        ("pivot_2", 3, "must be a column and a row"),
    ],
)
def test_a_setup_names_the_value_at_fault(name, value, reason):
    with pytest.raises(ll.InputError, match=f"^{name} {reason}"):
        Setup(pivot=None, balls=(), **{name: value})


def test_a_setup_survives_its_file(swing, tmp_path):
    setup = Setup(pivot=(1.5, 2.0), balls=((3.0, 4.25), (5.0, 6.0)), length=0.1, is_proposed=True)
    path = write_sidecar(setup, swing.path, tmp_path / "one.toml")
    assert read_sidecar(path, swing.path) == setup
    nowhere = Setup(pivot=None, balls=((3.0, 4.0),))
    assert read_sidecar(write_sidecar(nowhere, swing.path, path), swing.path) == nowhere


def test_the_overlay_has_the_frames_of_the_video(swing, tracked):
    video = open_video(tracked / "swing.mp4")
    times = [frame.time for frame in video.frames()]
    np.testing.assert_allclose(times, swing.truth.time, atol=1e-4)
    assert (video.width, video.height) == (320, 240)


def test_places_in_the_picture_are_those_of_the_truth(swing, tracked):
    pivots, balls = places_of(read_table(tracked / "swing.csv"), (320, 240))
    assert np.hypot(*(pivots[0] - swing.pivot)) < 0.5
    assert np.hypot(*(balls[0, 0] - swing.balls[0])) < 0.5


def test_the_report_asks_nothing_of_a_network(tracked):
    page = (tracked / "swing.html").read_text()
    assert page.count("data:image/png;base64,") >= 4
    assert not re.search(r"""(src|href)=["'](?!data:|#)""", page)
    assert "url(" not in page
    assert "$" not in re.sub(r"base64,[^\"]*", "", page)


def test_two_balls_have_their_columns_and_a_summary(toy, tmp_path, capsys):
    output = tmp_path / "toy.csv"
    arguments = ["track", str(toy.path), *toy.options, "--output", str(output), "--json"]
    assert main(arguments) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["balls"] == 2
    assert found["drive_amplitude"] == pytest.approx(0.02, rel=0.03)
    assert found["drive_frequency"] == pytest.approx(10.0, rel=0.02)
    rows = [line for line in output.read_text().splitlines() if not line.startswith("#")]
    assert rows[0] == COLUMNS_2


@pytest.mark.parametrize("name", ["swing", "toy"])
def test_pivot_and_balls_are_found_without_clicks(name, request):
    clip = request.getfixturevalue(name)
    video = open_video(clip.path)
    found, *_ = propose(video, read_sample(video))
    assert len(found.balls) == len(clip.balls)
    assert np.hypot(*(np.array(found.pivot) - clip.pivot)) < 3.0
    for ball, true in zip(found.balls, clip.balls, strict=True):
        assert np.hypot(*(np.array(ball) - true)) < 2.0


@pytest.mark.parametrize(
    "model,initial_angle",
    [
        (ll.Pendulum(length=0.3, mass=0.1, damping=0.003), 0.3),
        (ll.LatoLato(length=0.3, mass=0.1, damping=0.003, radius=0.025, restitution=0.8), 0.9),
    ],
)
def test_balls_about_a_pivot_that_moves_in_no_one_harmonic_are_found(
    model, initial_angle, tmp_path
):
    times, rate = np.linspace(0.0, 4.2, 800), model.natural_frequency
    heights = 0.02 * np.cos(1.95 * rate * times) + 0.015 * np.cos(3.1 * rate * times)
    drive = ll.MeasuredPivot(times=times, pivot_heights=heights)
    run = ll.simulate(model, drive, initial_angle=initial_angle, duration=4.0)
    camera = Camera(width=480, height=360, fps=60.0)
    scene = Scene(ball_radius=0.022, rod_width=0.003)
    truth = synthesise_video(run, tmp_path / "hand.mp4", scene, camera, seed=3)
    with pytest.warns(RuntimeWarning):
        table = ll.track(tmp_path / "hand.mp4")
    for name in [name for name in ("angle_1", "angle_2") if name in truth]:
        ok = table[name.replace("angle", "flag")].values == "ok"
        off = np.abs(table[name].values - truth[name].values)[ok]
        sigmas = table[name.replace("angle", "angle_sigma")].values[ok]
        assert ok.mean() > 0.9
        assert np.sqrt(np.mean(off**2)) < 1.5e-3
        assert np.mean(off < 2.0 * sigmas) > 0.93


@pytest.mark.parametrize(
    "model",
    [
        ll.Pendulum(length=0.3, mass=0.1, damping=0.003),
        ll.LatoLato(length=0.3, mass=0.1, damping=0.003, radius=0.025, restitution=0.8),
    ],
)
def test_striped_balls_about_an_unmarked_driven_pivot_are_found_whole(model, tmp_path):
    drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.7 * model.natural_frequency)
    run = ll.simulate(model, drive, initial_angle=0.6, duration=4.0)
    scene = Scene(
        ball_radius=0.025, pattern=0.3, rod_width=0.0, block_width=0.0, block_height=0.0,
        bolt_radius=0.0, rail_width=0.0, background="plain",
    )  # fmt: skip
    truth = synthesise_video(
        run, tmp_path / "striped.mp4", scene, Camera(width=400, height=300, fps=30.0), seed=3
    )
    with pytest.warns(RuntimeWarning):
        table = ll.track(tmp_path / "striped.mp4")
    assert "found in the video" in table.attrs["warnings"]
    found = [name for name in ("angle_1", "angle_2") if name in truth]
    assert [name for name in ("angle_1", "angle_2") if name in table] == found
    for name in found:
        ok = table[name.replace("angle", "flag")].values == "ok"
        off = (table[name].values - truth[name].values[table.frame.values])[ok]
        assert ok.mean() > 0.9
        assert np.sqrt(np.mean(off**2)) < 3e-3


def test_a_pivot_that_is_clicked_is_believed_though_balls_are_found(swing, tmp_path):
    for pivot in (None, swing.pivot):
        setup = prepare(swing.path, pivot, None, {}).setup
        assert setup.is_proposed
        assert setup.is_pivot_found == (pivot is None)
        write_sidecar(setup, swing.path, tmp_path / "setup.toml")
        assert read_sidecar(tmp_path / "setup.toml", swing.path).is_pivot_found == (pivot is None)
    with pytest.warns(RuntimeWarning):
        found, clicked = (ll.track(swing.path, pivot=each) for each in (None, swing.pivot))
    sigmas = [each.attrs["pivot_offset_y_sigma"] for each in (found, clicked)]
    assert sigmas[1] < sigmas[0]


def test_a_proposal_is_drawn(swing, tmp_path, capsys):
    picture = tmp_path / "found.png"
    assert main(["track", str(swing.path), "--propose", "--output", str(picture)]) == 0
    assert "--pivot" in capsys.readouterr().out
    assert picture.read_bytes()[:4] == b"\x89PNG"
    assert list(tmp_path.iterdir()) == [picture]


def test_without_a_length_angles_are_known_and_positions_are_in_pixels(swing):
    with pytest.warns(RuntimeWarning, match="length is unknown"):
        table = ll.track(swing.path, pivot=swing.pivot, balls=swing.balls)
    assert table.attrs["geometry"] == "angles"
    assert np.isnan(table.ball_1_x).all()
    assert abs(float(table.ball_1_u[0]) - swing.balls[0][0]) < 0.5
    error = (table.angle_1 - swing.truth.angle_1).values[table.flag_1.values == "ok"]
    assert np.sqrt(np.mean(error**2)) < 4e-3


@pytest.fixture(scope="session")
def cropped(swing, tmp_path_factory):
    """The lower part of a clip, without its pivot."""
    import av

    from latolato.experiment.encode import TICKS, write_video

    path = tmp_path_factory.mktemp("cropped") / "cropped.mp4"
    with av.open(str(swing.path)) as file:
        frames = [
            (round(f.time * TICKS), f.to_ndarray(format="rgb24")[100:])
            for f in file.decode(video=0)
        ]
    planes = (
        (
            stamp,
            av.VideoFrame.from_ndarray(np.ascontiguousarray(part), format="rgb24").to_ndarray(
                format="yuv420p"
            ),
        )
        for stamp, part in frames
    )
    write_video(path, planes, fps=60.0, crf=20, rotation=0)
    return path


@pytest.mark.filterwarnings("ignore:found in the video|no period:RuntimeWarning")
def test_without_a_pivot_the_geometry_is_unknown_and_the_period_known(swing, cropped, tmp_path):
    with pytest.warns(RuntimeWarning, match="geometry is unknown"):
        table = ll.track(cropped, length=0.363)
    assert table.attrs["geometry"] == "unknown"
    assert np.isnan(table.angle_1).all()
    assert (table.flag_1 == "ok").mean() > 0.8
    ok = table.flag_1.values == "ok"
    away = np.hypot(table.ball_1_u - table.ball_1_u[0], table.ball_1_v - table.ball_1_v[0])
    scale = swing.truth.attrs["metres_per_pixel"]
    x, y = swing.truth.ball_1_x, swing.truth.ball_1_y
    np.testing.assert_allclose(
        away[ok], (np.hypot(x - x[0], y - y[0]) / scale).values[ok], atol=3.0
    )


@pytest.mark.filterwarnings("ignore:found in the video|no period|the pivot seems:RuntimeWarning")
def test_without_a_pivot_balls_are_followed_from_any_frame(cropped):
    tables = [ll.track(cropped, click_frame=number) for number in (0, 80)]
    places = [np.stack([t.ball_1_u, t.ball_1_v]) for t in tables]
    np.testing.assert_array_equal(*places)
    assert np.isfinite(places[0]).mean() > 0.8


def test_the_period_of_a_swing_comes_from_its_path():
    from latolato.experiment.period import period_of

    times = np.arange(0.0, 12.0, 1 / 30)
    angle = 0.5 * np.exp(-0.02 * times) * np.cos(2.0 * np.pi * times / 1.213 + 0.4)
    places = np.stack([200.0 + 300.0 * np.sin(angle), 300.0 * np.cos(angle)], axis=-1)
    places[40:55] = np.nan
    period, sigma = period_of(times, places)
    assert period == pytest.approx(1.213, rel=1e-3)
    assert sigma < 3e-3


def test_a_period_that_changes_has_a_deviation_that_covers_both_halves():
    from latolato.experiment.period import halves_apart, period_of

    times = np.arange(0.0, 24.0, 1 / 30)
    for late in (1.0, 1.02):
        phase = np.where(times < 12.0, times, 12.0 + (times - 12.0) / late)
        places = np.column_stack([100.0 * np.sin(2.0 * np.pi * phase), 0.0 * times])
        places += 0.3 * np.random.default_rng(1).standard_normal(places.shape)
        period, sigma = period_of(times, places)
        apart = halves_apart(times, places)
        if late == 1.0:
            assert apart is None
            assert sigma < 1e-3
        else:
            assert apart == pytest.approx((1.0, 1.02), abs=2e-3)
            assert all(abs(half - period) < 1.5 * sigma for half in apart)


def test_swings_that_are_hidden_are_counted_or_make_no_period():
    from latolato.experiment.period import period_of

    times = np.arange(600) / 25.0
    places = np.column_stack([100.0 * np.sin(2.0 * np.pi * times), 0.0 * times])
    # Every second swing is hidden but for its turning points.
    hidden = (times % 2.0 > 1.0) & (np.abs(places[:, 0]) < 90.0)
    seen = np.where(hidden[:, None], np.nan, places)
    assert period_of(times, seen)[0] == pytest.approx(1.0, rel=1e-3)
    seen[times % 1.0 > 0.4] = np.nan
    assert np.isnan(period_of(times, seen)[0])


def test_a_batch_survives_a_bad_file(swing, tmp_path, capsys):
    bad = tmp_path / "bad.mp4"
    bad.write_bytes(b"no video at all")
    folder = tmp_path / "tables"
    videos = [str(bad), str(swing.path)]
    code = main(["track", *videos, *swing.options, "--output", str(folder), "--workers", "1"])
    told = capsys.readouterr()
    assert code == 1
    assert "bad.mp4: it cannot be read" in told.err
    assert "1 of 2 videos failed" in told.err
    assert sorted(p.name for p in folder.iterdir()) == ["swing.csv", "swing.csv.track.toml"]


def test_what_a_wrong_radius_led_astray_is_learned_again_without_it(swing, monkeypatch):
    learned = []

    def astray(*args, **options):
        scene = learn_image_model(*args, **options)
        learned.append(args[4])
        if args[4] is not None:  # the radius declared: a circle beside the ball is taken for it
            scene.look.radius *= 1.3
            scene.explained = 0.8
        return scene

    monkeypatch.setattr("latolato.experiment.follow.learn_image_model", astray)
    radius = swing.truth.attrs["radius"]
    with pytest.warns(RuntimeWarning, match="the radius of a ball is"):
        table = ll.track(
            swing.path,
            pivot=swing.pivot,
            balls=swing.balls,
            length=swing.length,
            radius=1.4 * radius,
        )
    assert table.attrs["measured_radius"] == pytest.approx(radius, rel=0.05)
    for axis in "xy":  # how well the place of the pivot is known, in pixels
        assert 0.15 <= table.attrs[f"pivot_offset_{axis}_sigma"] < 1.1
    assert learned[1:] == [None]
