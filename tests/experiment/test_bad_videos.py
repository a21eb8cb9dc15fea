"""What cannot be tracked: one line that says why, exit code 2, and nothing written."""

import dataclasses
import re
from fractions import Fraction

import cv2
import numpy as np
import pytest

import latolato as ll
from latolato.cli.main import main
from latolato.experiment.track_table import read_table
from latolato.experiment.video import Limits, open_video
from little_videos import encoded, sound_alone, trimmed

GREY = [np.full((64, 96), 90 + k % 3, np.uint8) for k in range(24)]


def refused(capsys, tmp_path, *arguments):
    """Return the line that a refusal prints; nothing may be written."""
    output = tmp_path / "out"
    output.mkdir(exist_ok=True)
    code = main(["track", *map(str, arguments), "--output", str(output / "table.csv")])
    lines = capsys.readouterr().err.strip().splitlines()
    assert code == 2
    assert not list(output.iterdir())
    assert len(lines) == 1, lines
    return lines[0]


CLICKS = ("--pivot", "48,10", "--ball", "48,50", "--length", "0.3")


def test_what_is_no_video_is_refused(tmp_path, capsys):
    file = tmp_path / "note.mp4"
    file.write_text("hello")
    assert "cannot be read as a video" in refused(capsys, tmp_path, file, *CLICKS)


def test_a_playlist_of_other_files_is_refused(tmp_path, capsys):
    clip = encoded(tmp_path / "grey.mp4", GREY)
    file = tmp_path / "list.m3u8"
    file.write_text(f"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\n{clip}\n#EXT-X-ENDLIST\n")
    assert "cannot be read as a video" in refused(capsys, tmp_path, file, *CLICKS)


def test_a_missing_and_an_empty_file_are_refused(tmp_path, capsys):
    assert "there is no video" in refused(capsys, tmp_path, tmp_path / "none.mp4", *CLICKS)
    empty = tmp_path / "empty.mp4"
    empty.touch()
    assert "is empty" in refused(capsys, tmp_path, empty, *CLICKS)


def test_a_truncated_video_is_refused(swing, tmp_path, capsys):
    whole = swing.path.read_bytes()
    cut = tmp_path / "cut.mp4"
    cut.write_bytes(whole[: len(whole) // 2])  # its index comes first: half the frames are there
    assert "cut" in refused(capsys, tmp_path, cut, *swing.options)
    cut.write_bytes(whole[:200])
    assert "cut off" in refused(capsys, tmp_path, cut, *swing.options)


def test_a_damaged_video_is_refused_with_the_frame(swing, tmp_path, capsys):
    damaged = bytearray(swing.path.read_bytes())
    middle = len(damaged) // 2
    damaged[middle : middle + 600] = bytes(255 - k % 256 for k in range(600))
    path = tmp_path / "damaged.mp4"
    path.write_bytes(damaged)
    told = refused(capsys, tmp_path, path, *swing.options)
    count = int(re.search(r"the file is damaged: frame (\d+) cannot be decoded", told)[1])
    assert "--end" in told
    # What is before that frame can be tracked, to its last frame.
    end = float(swing.truth.time[count - 1])
    table = tmp_path / "part.csv"
    options = [*swing.options, "--end", f"{end} s", "--output", str(table)]
    assert main(["track", str(path), *options]) == 0
    assert read_table(table).sizes["frame"] == count


def test_a_video_whose_last_frames_are_missing_is_tracked_and_told_of(swing, tmp_path):
    whole = swing.path.read_bytes()
    cut = tmp_path / "cut.mp4"
    cut.write_bytes(whole[: int(0.955 * len(whole))])
    with pytest.warns(RuntimeWarning, match="frames that the file declares are missing: it is cut"):
        table = ll.track(cut, pivot=swing.pivot, balls=swing.balls, length=swing.length)
    assert 3 < swing.truth.sizes["frame"] - table.sizes["frame"] < 12


@pytest.mark.parametrize("begin,end", [(0.5, None), (0.5, 1.5)])
def test_what_an_edit_list_cuts_away_is_not_missing(swing, tmp_path, begin, end):
    path = trimmed(swing.path, tmp_path / "trimmed.mp4", begin, end)
    times = swing.truth.time.values
    shown = np.flatnonzero((times > begin - 1e-6) & (times < (end or np.inf) - 1e-6))
    video = open_video(path)
    assert video.frame_count == len(shown)
    found = [frame.time for frame in video.frames()]
    np.testing.assert_allclose(found, times[shown] - begin, atol=1e-3)


def test_a_trimmed_video_is_tracked_without_a_word_about_its_frames(swing, tmp_path):
    path = trimmed(swing.path, tmp_path / "trimmed.mp4", 1.0)
    with pytest.warns(RuntimeWarning) as told:
        table = ll.track(path, length=swing.length)
    assert [str(one.message)[:18] for one in told] == ["found in the video"]
    truth = swing.truth.angle_1.values[-table.sizes["frame"] :]
    error = (table.angle_1.values - truth)[table.flag_1.values == "ok"]
    assert np.sqrt(np.mean(error**2)) < 4e-3  # a pixel is 8 mrad here


def test_a_trimmed_video_that_is_cut_off_is_refused(swing, tmp_path, capsys):
    whole = trimmed(swing.path, tmp_path / "trimmed.mp4", 0.5)
    data = whole.read_bytes()  # its index comes first
    cut = tmp_path / "cut.mp4"
    cut.write_bytes(data[: int(0.6 * len(data))])
    assert "is cut off" in refused(capsys, tmp_path, cut, *swing.options)


def test_a_video_without_frames_is_refused(tmp_path, capsys):
    import av

    path = tmp_path / "none.mkv"
    with av.open(str(path), "w") as file:
        stream = file.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        file.start_encoding()
    told = refused(capsys, tmp_path, path, *CLICKS)
    assert "cannot be read" in told or "no frame" in told


def test_sound_alone_is_refused(tmp_path, capsys):
    path = sound_alone(tmp_path / "sound.mp4")
    assert "no video stream" in refused(capsys, tmp_path, path, *CLICKS)


def test_ten_hours_are_refused_before_they_are_read(tmp_path, capsys):
    path = encoded(tmp_path / "long.mp4", GREY[:10], [90_000 * 4000 * k for k in range(10)])
    assert "at most 3600 s" in refused(capsys, tmp_path, path, *CLICKS)


def test_frames_that_are_too_large_are_refused(tmp_path, capsys):
    # FFmpeg itself makes none of 16384 x 16384.
    path = encoded(tmp_path / "large.mp4", [np.zeros((4096, 8192), np.uint8)])
    assert "frames of 8192 x 4096 pixels, at most" in refused(capsys, tmp_path, path, *CLICKS)


@pytest.mark.parametrize(
    "limit,text",
    [
        ("pixels=1000", "at most 1000 pixels"),
        ("frames=5", "at most 5 frames"),
        ("memory=1e5", "bytes of memory, at most 100000 bytes"),
        ("duration=0.1 s", "at most 0.1 s"),
    ],
)
def test_limits_are_options(tmp_path, capsys, limit, text):
    path = encoded(tmp_path / "grey.mp4", GREY)
    said = refused(capsys, tmp_path, path, *CLICKS, "--limit", limit)
    assert text in said
    assert "raise the limit of its" in said
    assert "--" not in said  # pages show it too


def test_limits_hold_while_decoding_where_the_container_says_nothing(tmp_path):
    path = encoded(tmp_path / "grey.mp4", GREY)
    video = dataclasses.replace(open_video(path), limits=Limits(frames=5))
    with pytest.raises(ValueError, match=r"6 frames are there, at most 5 .*limit of its frames"):
        list(video.frames())
    video = dataclasses.replace(video, limits=Limits(duration=0.2))
    with pytest.raises(ValueError, match=r"at most 0\.2 s are allowed.*limit of its duration"):
        list(video.frames())


def test_pictures_with_gaps_are_refused(tmp_path, capsys):
    folder = tmp_path / "pictures"
    folder.mkdir()
    for k in (1, 2, 4, 5):
        (folder / f"frame_{k:03d}.png").write_bytes(b"")
    assert "1 to 5, 3 missing" in refused(capsys, tmp_path, folder, *CLICKS)
    said = refused(capsys, tmp_path, folder / "frame_%03d.png", *CLICKS)
    assert "names a sequence of pictures (pictures 1 to 5, 3 missing in " in said
    (folder / "frame_001.png").write_bytes(b"x")
    assert "is a picture" in refused(capsys, tmp_path, folder / "frame_001.png", *CLICKS)


def test_time_stamps_that_fall_are_refused_with_a_reason(tmp_path, capsys):
    # Frames of an intra codec are decoded in the order of the file, whatever their stamps.
    stamps = [3000 * k for k in range(24)]
    stamps[10], stamps[11] = stamps[11], stamps[10]
    path = with_stamps(tmp_path / "falls.mov", stamps)
    assert "time stamps must increase" in refused(capsys, tmp_path, path, *CLICKS)


def test_time_stamps_may_be_uneven(tmp_path):
    stamps = np.cumsum([3000 + 700 * (k % 3) for k in range(24)])
    path = with_stamps(tmp_path / "uneven.mov", [int(stamp) for stamp in stamps])
    times = np.array([frame.time for frame in open_video(path).frames()])
    np.testing.assert_allclose(np.diff(times), np.diff(stamps) / 90_000, atol=1e-4)


def with_stamps(path, stamps):
    """Write grey frames with presentation times as they are given."""
    import av

    with av.open(str(path), "w") as file:
        stream = file.add_stream("mjpeg", rate=30)
        stream.width, stream.height, stream.pix_fmt = 96, 64, "yuvj420p"
        packets = []
        for k, picture in enumerate(GREY):
            frame = av.VideoFrame.from_ndarray(np.repeat(picture[..., None], 3, 2), format="rgb24")
            frame.pts = k
            packets += stream.encode(frame)
        packets += stream.encode()
        for k, packet in enumerate(packets):
            packet.dts, packet.pts = 3000 * k, stamps[k] + 60_000
            packet.time_base = Fraction(1, 90_000)
            file.mux(packet)
    return path


def test_a_click_outside_the_frame_is_refused(swing, tmp_path, capsys):
    told = refused(capsys, tmp_path, swing.path, "--pivot", "90,10", "--ball", "900,10")
    assert "ball at (900, 10) lies outside the frame of 320 x 240" in told
    told = refused(capsys, tmp_path, swing.path, "--pivot", "9e5,10", "--ball", "10,10")
    assert "the pivot at (900000, 10) is farther than" in told
    told = refused(capsys, tmp_path, swing.path, "--pivot", "90,10", "--ball", "10,nan")
    assert "ball must be a column and a row" in told


def test_a_ball_that_is_nowhere_is_refused(tmp_path, capsys):
    path = encoded(tmp_path / "grey.mp4", GREY)
    told = refused(capsys, tmp_path, path)
    assert "no moving ball was found" in told
    assert "point at pivot and ball" in told


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_a_rod_without_a_ball_is_refused_for_that(tmp_path, capsys, share):
    ends = [
        np.array([160.0, 30.0]) + 120.0 * np.array([np.sin(angle), np.cos(angle)])
        for angle in 0.6 * np.cos(0.15 * np.arange(90))
    ]
    pictures = [
        cv2.line(
            np.full((240, 320), 230, np.uint8), (160, 30), np.rint(end).astype(int).tolist(), 20, 3
        )
        for end in ends
    ]
    path = encoded(tmp_path / "rod.mp4", pictures)
    place = (1.0 - share) * np.array([160.0, 30.0]) + share * ends[0]
    click = "{:.0f},{:.0f}".format(*place)
    told = refused(capsys, tmp_path, path, "--pivot", "160,30", "--ball", click)
    assert "what moves is long and thin, and no ball stands out from it" in told


def test_too_few_frames_are_refused(tmp_path, capsys):
    path = encoded(tmp_path / "short.mp4", GREY[:4])
    assert "too few frames (4): tracking needs at least 8" in refused(
        capsys, tmp_path, path, *CLICKS
    )


def test_a_sidecar_of_another_video_is_refused(swing, toy, tmp_path, capsys):
    from latolato.experiment.sidecar import Setup, write_sidecar

    setup = Setup(pivot=swing.pivot, balls=tuple(swing.balls), length=0.363)
    sidecar = write_sidecar(setup, toy.path, tmp_path / "toy.csv.track.toml")
    told = refused(capsys, tmp_path, swing.path, "--sidecar", sidecar)
    assert "belongs to another video" in told


@pytest.mark.parametrize(
    "text,reason",
    [
        ("sha256 = 3", "does not name its video"),
        ("[[", "is not a TOML"),
        ('sha256 = "HASH"\n[geometry]\npivto = [1, 2]', "did you mean 'pivot'"),
        ('sha256 = "HASH"\n[geometry]\nballs = [[1]]', "a column and a row"),
        ('sha256 = "HASH"\n[geometry]\nballs = [[1, 2]]\nlength = "long"', "must be a number"),
        ('sha256 = "HASH"\n[geometry]\nballs = [[1, 2]]\nlength = -1', "must lie in (0, inf)"),
        ('sha256 = "HASH"\n[geometry]\nballs = 3', "balls must be a list, got 3"),
        ('sha256 = "HASH"\n[geometry]\nballs = [[1, 2]]\ncorrections = 3', "must be a list, got 3"),
        ('sha256 = "HASH"\n[geometry]\nballs = [[1, 2]]\npivot_2 = 3', "pivot_2 must be a column"),
        ('sha256 = "HASH"\n[limits]\npixels = "many"', "pixels must be a number, got 'many'"),
        ('sha256 = "HASH"\n[limits]\nframes = true', "frames must be a number, got True"),
    ],
)
def test_a_broken_sidecar_is_refused(swing, tmp_path, capsys, text, reason):
    from latolato.experiment.video import digest_of

    sidecar = tmp_path / "broken.toml"
    sidecar.write_text(text.replace("HASH", digest_of(swing.path)))
    assert reason in refused(capsys, tmp_path, swing.path, "--sidecar", sidecar)


@pytest.mark.parametrize(
    "arguments,reason",
    [
        (("--pivot", "12"), "a column and a row"),
        (("--balls", "3"), "must be 1 or 2"),
        (("--balls", "2", "--ball", "1,2"), "--balls 2 needs --ball 2 times"),
        (("--length", "3 kg"), "length must be given in m"),
        (("--length", "-1 m", *CLICKS[:4]), "length must lie in (0, inf) m, got -1"),
        (("--slow-motion", "0", *CLICKS[:4]), "--slow-motion must lie in (0, inf)"),
        (("--limit", "pixel=3"), "did you mean 'pixels'"),
        (("--limit", "pixels=many"), "pixels must be a whole number, got 'many'"),
        (("--limit", "duration=0 s"), "duration must be positive"),
    ],
)
def test_options_that_make_no_sense_are_refused(swing, tmp_path, capsys, arguments, reason):
    assert reason in refused(capsys, tmp_path, swing.path, *arguments)


def test_tables_of_several_videos_need_names_of_their_own(swing, tmp_path, capsys):
    assert main(["track", str(swing.path), str(swing.path), "--output", str(tmp_path)]) == 2
    assert "would both be written" in capsys.readouterr().err
    table = str(tmp_path / "one.csv")
    assert main(["track", str(swing.path), "b.mp4", "--output", table]) == 2
    assert "need a folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    "given, reason",
    [
        (["--ball", "91,11"], "pivot and ball must be at least 8 pixels apart"),
        (["--ball", "60,90", "--ball", "61,90"], "two balls must be at least 8 pixels apart"),
        (
            ["--ball", "60,90", "--row-time", "1"],
            "--row-time must let 240 rows fit between two frames 0.0167 s apart, got 1; give the "
            "time from one row to the next, not that of all rows",
        ),
        (["--ball", "60,90", "--row-time", "-1"], "--row-time must lie in [0, inf) s"),
        (["--ball", "60,90", "--lens-k1", "nan"], "--lens-k1 must be a number"),
        (["--ball", "60,90", "--lens-k2", "5"], "--lens-k2 must lie in [-1, 1]"),
    ],
)
def test_places_and_cameras_that_cannot_be_are_refused(swing, tmp_path, capsys, given, reason):
    told = refused(capsys, tmp_path, swing.path, "--pivot", "90,10", *given)
    assert reason in told
