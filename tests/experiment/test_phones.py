"""Files as phones and cameras write them: what is shown, when, and whether all is there."""

import warnings

import numpy as np
import pytest

import latolato as ll
from latolato.cli.main import main
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.tracking.kernels.layers import linear_light
from latolato.experiment.video import open_video
from little_videos import encoded, pictures_of, slowed, turned

GREY = [np.full((64, 96), 90 + k % 3, np.uint8) for k in range(24)]


@pytest.fixture(scope="module")
def fast(tmp_path_factory):
    """A driven swing, filmed with 240 frames a second: the file and its true table."""
    path = tmp_path_factory.mktemp("clips") / "fast.mp4"
    drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.0)
    run = ll.simulate(ll.Pendulum(length=0.363, mass=0.1), drive, initial_angle=0.9, duration=0.9)
    camera = Camera(width=320, height=240, fps=240.0)
    return path, synthesise_video(run, path, Scene(ball_radius=0.02), camera, seed=2)


def place(truth, name):
    return truth.attrs[f"{name}_pixel_u"], truth.attrs[f"{name}_pixel_v"]


def tracked(path, truth, **options):
    return ll.track(
        path,
        pivot=place(truth, "pivot"),
        balls=[place(truth, "ball_1")],
        length=0.363,
        radius=0.02,
        **options,
    )


# How frames are stored: file, encoder, planes, and what else the encoder needs.
FORMATS = {
    "hvc1": ("clip.mov", "libx265", "yuv420p", {"codec_tag": "hvc1"}),
    "hev1 10 bit": ("clip.mp4", "libx265", "yuv420p10le", {}),
    "full range": ("clip.mp4", "libx264", "yuvj420p", {}),
    "ProRes": ("clip.mov", "prores_ks", "yuv422p10le", {}),
    "Motion JPEG": ("clip.avi", "mjpeg", "yuvj422p", {}),
    "VP9": ("clip.webm", "libvpx-vp9", "yuv420p", {"deadline": "realtime", "b": "4000000"}),
    "AV1": ("clip.mp4", "libsvtav1", "yuv420p", {"preset": "12", "svtav1-params": "avif=0"}),
    "RGB": ("clip.mov", "png", "rgb24", {}),
}


# Planes that another format has as well, in files of the same kind.
ALIKE = ("hvc1", "AV1")


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] if n in ALIKE else []) for n in FORMATS]
)
def test_angles_do_not_depend_on_how_frames_are_stored(swing, tmp_path, name):
    import av

    file, codec, layout, options = FORMATS[name]
    assert codec in av.codecs_available, "PyAV's packages have all of them"
    pictures = pictures_of(swing.path)[:45]
    if codec == "libx265":
        options = {**options, "x265-params": "log-level=none"}
    stamps = [1500 * k for k in range(len(pictures))]
    path = encoded(tmp_path / file, pictures, stamps, codec, 60, layout, **options)
    table = tracked(path, swing.truth)
    error = table.angle_1.values - swing.truth.angle_1.values[: len(pictures)]
    assert (table.flag_1 == "ok").mean() > 0.95
    # Errors of neighbouring frames are alike: their mean square scatters about one.
    assert np.sqrt(np.mean((error / table.angle_sigma_1.values) ** 2)) < 1.5


def test_frames_of_odd_size_are_tracked(swing, tmp_path):
    pictures = [picture[:-1, :-1] for picture in pictures_of(swing.path)[:60]]
    path = encoded(tmp_path / "odd.mov", pictures, [1500 * k for k in range(60)], "mjpeg", 60,
                   "yuvj420p")  # fmt: skip
    assert (open_video(path).width, open_video(path).height) == (319, 239)
    error = tracked(path, swing.truth).angle_1.values - swing.truth.angle_1.values[:60]
    assert np.sqrt(np.mean(error**2)) < 4e-3  # half a pixel


@pytest.mark.parametrize("aspect,size", [("4/3", (128, 64)), ("3/4", (96, 85)), ("1/1", (96, 64)),
                                         ("1281/1280", (96, 64))])  # fmt: skip
def test_pixels_are_shown_as_squares(tmp_path, aspect, size):
    from fractions import Fraction

    path = encoded(tmp_path / "wide.mp4", GREY, sample_aspect_ratio=Fraction(aspect))
    video = open_video(path)
    assert (video.width, video.height) == size
    assert next(video.frames()).luma.shape == size[::-1]


@pytest.mark.parametrize(
    "matrix", [(1, 0, 0, 1), (0, 1, -1, 0), (-1, 0, 0, -1), (0, -1, 1, 0),
               (-1, 0, 0, 1), (1, 0, 0, -1), (0, 1, 1, 0), (0, -1, -1, 0)]
)  # fmt: skip
def test_frames_are_turned_and_mirrored_as_players_show_them(swing, tmp_path, matrix):
    stored = next(open_video(turned(swing.path, tmp_path / "0.mp4", (1, 0, 0, 1))).frames()).luma
    path = turned(swing.path, tmp_path / "turned.mp4", matrix)
    video = open_video(path)
    shown = next(video.frames()).luma
    y, x = np.indices(stored.shape)
    a, b, c, d = matrix
    columns, rows = a * x + c * y, b * x + d * y
    assert shown.shape == (video.height, video.width)
    np.testing.assert_array_equal(shown[rows - rows.min(), columns - columns.min()], stored)


def test_high_dynamic_range_becomes_linear_light(tmp_path):
    # ITU-R BT.2408: diffuse white is 75 % of HLG, 26.5 % of its light, and 58 % of PQ, 203 cd/m^2.
    codes = np.arange(255 * 4 + 2) / (255.0 * 4)
    assert np.interp(0.75, codes, linear_light("hlg")) == pytest.approx(0.265, abs=1e-3)
    assert np.interp(0.5, codes, linear_light("hlg")) == pytest.approx(1.0 / 12.0, rel=1e-3)
    assert np.interp(0.58, codes, linear_light("pq")) == pytest.approx(0.203, abs=2e-3)
    assert np.interp(1.0, codes, linear_light("hlg")) == pytest.approx(1.0, abs=1e-3)
    for code, tone in ((18, "hlg"), (16, "pq"), (1, "srgb")):
        path = encoded(tmp_path / f"{tone}.mp4", GREY, codec="libx265", layout="yuv420p10le",
                       color_trc=code, colorspace=9, color_primaries=9,
                       **{"x265-params": "log-level=none"})  # fmt: skip
        video = open_video(path)
        assert (video.tone, video.matrix) == (tone, "bt2020")


def test_interlaced_frames_are_refused(tmp_path):
    path = encoded(tmp_path / "fields.mp4", GREY, **{"x264-params": "tff=1"})
    with pytest.raises(ValueError, match=r"interlaced.*bwdif"):
        open_video(path)


# Rates of filming and of showing, the factor between them, and whether it is sure.
@pytest.mark.parametrize(
    "filmed,shown,factor,is_sure",
    [
        ("240.0", 30, 8.0, True),
        ("240.0", 240, 1.0, True),
        ("119.88", 30, 4.0, True),
        ("240", 25, 9.6, True),
        ("30.0", 29, 1.0, True),
        ("30.0", 15, 2.0, False),  # as in the dark
        ("60.0", 30, 2.0, False),
        ("2.0", 30, 2.0 / 30.0, False),
        ("many", 30, 1.0, True),
        ("nan", 30, 1.0, True),
        ("-240", 30, 1.0, True),
    ],
)
def test_the_rate_of_filming_gives_the_slow_motion(tmp_path, filmed, shown, factor, is_sure):
    stamps = [round(90_000 / shown * k) for k in range(24)]
    path = encoded(tmp_path / "clip.mp4", GREY, stamps, rate=shown,
                   metadata={"com.android.capture.fps": filmed})  # fmt: skip
    video = open_video(path)
    assert video.clock.slow_motion == pytest.approx(factor, rel=1e-3)
    assert video.clock.is_sure == is_sure
    assert video.slow_motion == (video.clock.slow_motion if is_sure else 1.0)
    assert open_video(path, slow_motion=3.0).slow_motion == 3.0


def test_frames_left_out_do_not_change_the_rate_of_showing(tmp_path):
    stamps = np.cumsum([3000 + 3000 * (k % 5 == 0) for k in range(24)]).tolist()
    path = encoded(tmp_path / "clip.mp4", GREY, stamps,
                   metadata={"com.android.capture.fps": "240"})  # fmt: skip
    assert open_video(path).slow_motion == 8.0


def test_a_file_that_declares_slow_motion_has_the_times_of_the_scene(fast, tmp_path, capsys):
    path, truth = fast
    slow = slowed(path, tmp_path / "slow.mp4", 8, 240.0)
    table = tracked(slow, truth)  # a warning would be an error
    np.testing.assert_allclose(table.time, truth.time, atol=1e-4)
    assert table.attrs["slow_motion"] == 8.0
    options = [slow, "--length", "36.3 cm", "--pivot", "{},{}".format(*place(truth, "pivot")),
               "--ball", "{},{}".format(*place(truth, "ball_1"))]  # fmt: skip
    assert main(["track", *map(str, options), "--output", str(tmp_path / "t.csv")]) == 0
    line = "240 frames a second filmed, 30 shown: times divided by 8 (from the file)"
    assert line in capsys.readouterr().out
    # Its set-up makes the same table.
    assert "slow_motion = 8.0" in (tmp_path / "t.csv.track.toml").read_text()


def test_what_is_given_overrides_the_file_and_is_checked_by_the_swing(fast, tmp_path):
    path, truth = fast
    slow = slowed(path, tmp_path / "slow.mp4", 8, 240.0)
    warning = "is 8 times too slow for its length and gravity: declare a slow motion of 8"
    with pytest.warns(RuntimeWarning, match=warning):
        table = tracked(slow, truth, slow_motion=1.0)
    assert table.time.values[-1] == pytest.approx(8.0 * truth.time.values[-1], rel=1e-3)
    with pytest.warns(RuntimeWarning, match=r"2 times too fast.*declare a slow motion of 8"):
        tracked(slow, truth, slow_motion=16.0)


def test_a_wrong_slow_motion_does_not_lose_the_ball_and_is_told(swing):
    with pytest.warns(RuntimeWarning) as told:
        ll.track(
            swing.path, pivot=swing.pivot, balls=swing.balls, length=swing.length, slow_motion=32.0
        )
    assert any("declare a slow motion of 1" in str(each.message) for each in told)


def test_slow_motion_that_the_file_does_not_declare_is_suggested(fast, tmp_path):
    path, truth = fast
    with pytest.warns(RuntimeWarning, match="declare a slow motion of 4, or correct the length"):
        tracked(slowed(path, tmp_path / "slow.mp4", 4), truth)


def test_a_file_of_few_frames_may_be_slow_motion_or_dark(swing, tmp_path):
    path = slowed(swing.path, tmp_path / "slow.mp4", 2, 60.0)
    said = "60 frames a second were filmed and 30 are shown: if it is slow motion, declare one of 2"
    with pytest.warns(RuntimeWarning) as told:
        tracked(path, swing.truth)
    texts = [str(one.message) for one in told]
    assert any(said in text for text in texts)
    assert any("declare a slow motion of 2" in text for text in texts)


@pytest.mark.parametrize("suffix", ["mp4", "mov", "mkv"])
def test_frames_keep_their_time_stamps(tmp_path, suffix):
    stamps = np.cumsum([3000 + 900 * (k % 3) for k in range(24)]).tolist()
    path = encoded(tmp_path / f"uneven.{suffix}", GREY, stamps, max_b_frames=3)
    times = [frame.time for frame in open_video(path).frames()]
    # Matroska rounds to milliseconds.
    np.testing.assert_allclose(times, np.array(stamps) / 90_000, atol=6e-4)


def test_frames_without_time_stamps_are_refused_with_a_way_out(tmp_path):
    path = encoded(tmp_path / "clip.h264", GREY)
    with pytest.raises(ValueError, match=r"frame 0 has no time stamp.*-framerate"):
        list(open_video(path).frames())


# Files of which the last bytes are missing.
@pytest.mark.parametrize("name,share,said", [
    ("index_last.mp4", 0.6, "cut off: its last"), ("clip.mkv", 0.6, "cut off: "),
    ("clip.avi", 0.6, "cut off: "), ("clip.mov", 0.9, "cut off: its last"),
])  # fmt: skip
def test_a_file_that_is_cut_off_is_refused_as_such(swing, tmp_path, name, share, said):
    codec = "mpeg4" if name.endswith("avi") else "libx264"
    stamps = [1500 * k for k in range(90)]
    path = encoded(tmp_path / name, pictures_of(swing.path)[:90], stamps, codec, 60)
    assert not open_video(path).is_cut_off
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(ValueError, match=said):
        list(open_video(path).frames())


@pytest.mark.parametrize("suffix", ["mp4", "mkv"])
def test_sound_that_goes_on_after_the_picture_cuts_nothing_off(swing, tmp_path, suffix):
    import av

    path = tmp_path / f"sound.{suffix}"
    with av.open(str(swing.path)) as old, av.open(str(path), "w") as new:
        stream = old.streams.video[0]
        copy = new.add_stream_from_template(stream)
        sound = new.add_stream("aac", rate=8000)
        for k in range(40):  # 5 s, twice as long as the picture
            frame = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), "fltp", "mono")
            frame.sample_rate, frame.pts = 8000, 1024 * k
            new.mux(sound.encode(frame))
        new.mux(sound.encode())
        for packet in old.demux(stream):
            if packet.dts is not None:
                packet.stream = copy
                new.mux(packet)
    video = open_video(path)
    assert len(list(video.frames())) == swing.truth.sizes["frame"]
    # Matroska rounds time stamps to milliseconds, which may just show.
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="the time stamps are off by about 0.[1-6]")
        tracked(path, swing.truth)  # any other warning would be an error


def test_a_file_that_declares_a_longer_time_than_its_frames_cuts_nothing_off(swing, tmp_path):
    import av

    path = tmp_path / "long.mp4"
    with av.open(str(swing.path)) as old, av.open(str(path), "w") as new:
        stream = old.streams.video[0]
        copy = new.add_stream_from_template(stream)
        packets = [packet for packet in old.demux(stream) if packet.dts is not None]
        packets[-1].duration *= 60  # the last frame stays for a second
        for packet in packets:
            packet.stream = copy
            new.mux(packet)
    assert len(list(open_video(path).frames())) == swing.truth.sizes["frame"]


def test_an_empty_end_of_a_file_is_no_missing_part(swing, tmp_path):
    path = tmp_path / "padded.mp4"
    path.write_bytes(swing.path.read_bytes() + bytes(1000))
    assert not open_video(path).is_cut_off
