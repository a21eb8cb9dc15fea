"""Videos that pages upload: tracked in a process of their own, refused in one line, removed."""

import contextlib
import json
import math
import os
import random
import re
import time
from pathlib import Path

import numpy as np
import pytest

import latolato as ll
from app_server import start_server, stop_server
from clip_pages import end_of, english, one_line, opened
from latolato.app.experiment.jobs import compute
from latolato.app.experiment.work import WORK
from latolato.core.errors import InputError
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.track_table import read_table
from latolato.experiment.video import open_video
from little_videos import encoded, slowed
from page_blocks import unpack
from videos import rewritten

GREY = [np.full((64, 96), 90 + k % 3, np.uint8) for k in range(24)]


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    """A tiny video of a free swing and its true table."""
    path = tmp_path_factory.mktemp("clips") / "tiny.mp4"
    run = ll.simulate(
        ll.Pendulum(length=0.363, mass=0.1, damping=0.01), initial_angle=0.6, duration=5.0
    )
    camera = Camera(width=200, height=160, fps=20.0)
    return path, synthesise_video(run, path, Scene(ball_radius=0.025), camera)


@pytest.fixture
def page():
    with opened() as (result, _):
        yield result


def workers(parent=None):
    """Processes that do jobs for a process, by default for this one."""
    parent = parent or os.getpid()
    result = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            fields = status.read_text().rpartition(")")[2].split()
            command = (status.parent / "cmdline").read_bytes()
            is_worker = b"anyio.to_process" in command
            if int(fields[1]) == parent and is_worker and fields[0] != "Z":
                result.append(int(status.parent.name))
    return result


def wait(is_so):
    """Wait until something is so."""
    deadline = time.monotonic() + 20.0
    while not is_so():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def begun(socket):
    """Wait until a process works on a job; return its number."""
    while json.loads(socket.receive()["text"])["state"] == "waiting":
        pass
    (process,) = workers()
    return process


def test_a_page_knows_what_a_file_says_of_slow_motion_and_plays_it_as_it_is(clip, tmp_path):
    path, truth = clip
    for capture_rate, is_sure in ((120.0, True), (20.0, False)):
        slow = slowed(path, tmp_path / "slow.mp4", 4, capture_rate)
        job = {"path": str(slow), "folder": str(tmp_path), "name": "slow.mp4"}
        seen, _ = WORK["look"](job, lambda stage, share: None)
        assert seen["clock"] == {
            "capture_rate": capture_rate, "shown_rate": pytest.approx(5.0),
            "slow_motion": pytest.approx(capture_rate / 5.0), "is_sure": is_sure,
        }  # fmt: skip
        times = [frame.time for frame in open_video(tmp_path / "copy.mp4").frames()]
        np.testing.assert_allclose(times, 4.0 * truth["time"], atol=1e-3)
    places = {"pivot": seen["proposal"]["pivot"], "balls": seen["proposal"]["balls"]}
    job["description"] = {**places, "length": "36.3 cm"}
    done, arrays = WORK["track"](job, lambda stage, share: None)
    assert any("declare one of 4" in text for text in map(english, done["warnings"]))
    job["description"]["slow_motion"] = "4"
    done, arrays = WORK["track"](job, lambda stage, share: None)
    assert not any("slow" in text for text in map(english, done["warnings"]))
    _, points = unpack(arrays["points"].tobytes())
    np.testing.assert_allclose(points["time"], truth["time"], atol=1e-3)
    np.testing.assert_allclose(points["media_time"], 4.0 * truth["time"], atol=1e-3)


def test_a_page_has_the_part_of_a_video_before_its_damage(clip, tmp_path):
    path, truth = clip
    content = bytearray(path.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 600] = bytes(255 - k % 256 for k in range(600))
    damaged = tmp_path / "damaged.mp4"
    damaged.write_bytes(content)
    job = {"path": str(damaged), "folder": str(tmp_path), "name": "damaged.mp4"}
    seen, arrays = WORK["look"](job, lambda stage, share: None)
    count = seen["frames"]
    assert 20 < count < truth.sizes["frame"]
    assert f"frame {count} cannot be decoded" in english(seen["damage"])
    np.testing.assert_allclose(arrays["time"], truth.time[:count], atol=1e-3)
    places = {"pivot": seen["proposal"]["pivot"], "balls": seen["proposal"]["balls"]}
    job["description"] = {**places, "length": "36.3 cm", "last_frame": count - 1}
    _, arrays = WORK["track"](job, lambda stage, share: None)
    _, points = unpack(arrays["points"].tobytes())
    np.testing.assert_allclose(points["time"], truth.time[:count], atol=1e-3)


def test_a_page_begins_with_the_frame_that_shows_the_ball(clip, tmp_path):
    path, truth = clip

    def empty_at_first(frames, number):
        if number >= 10:
            return frames[number][1]
        return np.uint8(np.median([picture for _, picture in frames[::5]], axis=0))

    late = rewritten(path, tmp_path / "late.mp4", empty_at_first)
    job = {"path": str(late), "folder": str(tmp_path), "name": "late.mp4"}
    proposal = WORK["look"](job, lambda stage, share: None)[0]["proposal"]
    at = proposal["click_frame"]
    assert at >= 10
    scale = truth.attrs["metres_per_pixel"]
    u = truth.attrs["pivot_pixel_u"] + (truth.ball_1_x[at] - truth.pivot_x[0]) / scale
    v = truth.attrs["pivot_pixel_v"] - (truth.ball_1_y[at] - truth.pivot_y[0]) / scale
    assert proposal["balls"][0] == pytest.approx([float(u), float(v)], abs=2.0)


def test_a_video_is_looked_at_tracked_fitted_and_gone_with_its_page(clip):
    path, truth = clip
    with opened() as (page, store):
        clip = page.clip(path.read_bytes(), "my%20swing.mp4")
        seen = page.do(do="look", clip=clip)["done"]
        assert (seen["width"], seen["height"], seen["frames"]) == (200, 160, truth.sizes["frame"])
        for name in ("pivot", "ball_1"):
            place = seen["proposal"]["pivot" if name == "pivot" else "balls"]
            u, v = place if name == "pivot" else place[0]
            # A pixel off is what a click is off.
            assert abs(u - truth.attrs[f"{name}_pixel_u"]) < 2.0
            assert abs(v - truth.attrs[f"{name}_pixel_v"]) < 2.0
        description = {
            "pivot": seen["proposal"]["pivot"], "balls": seen["proposal"]["balls"],
            "length": "36.3 cm", "radius": "25 mm", "mass": "100 g", "is_proposed": True,
            "is_pivot_found": True,
        }  # fmt: skip
        answer = page.do(do="track", clip=clip, description=description)
        done = answer["done"]
        damping = done["fits"]["decay"]["values"]["damping"]
        assert damping["value"] == pytest.approx(0.01, rel=0.02)  # 5 s of 200 x 160 pixels
        assert english(done["fits"]["drive"]["error"]).startswith("the pivot is at rest")
        swings = done["fits"]["decay"]["values"]["natural_frequency"]["value"] / math.tau
        # As many digits as the uncertainty has: two of it at most.
        told = done["finding"][0]["values"]["rate"].split()[0]
        assert float(told) == pytest.approx(swings, rel=1e-3)
        assert done["trials"] == []
        assert "pivot is at rest" in english(done["no_trial"])
        assert done["fits"]["decay"]["play"]["system"] == "pendulum"

        about, points = unpack(answer["points"].tobytes())
        table = page.file(clip, "track.csv").content
        kept = path.parent / "table.csv"
        kept.write_bytes(table)
        np.testing.assert_allclose(points["angle"][0], read_table(kept)["angle_1"], atol=1e-6)
        assert read_table(kept).attrs["source"] == "my swing.mp4"
        setup = page.file(clip, "setup.toml").text
        assert 'video = "my swing.mp4"' in setup
        assert "pivot_found = true" in setup
        _, ghost = unpack(answer["model"].tobytes())
        away = np.hypot(*(ghost["centre"] - points["centre"]))
        assert np.nanmax(away) < 0.5  # pixels
        for name in ("overlay.mp4", "report.html", "track.nc"):
            assert page.file(clip, name).status_code == 404
        assert page.do(do="export", clip=clip, file="overlay.mp4")["done"]
        answer = page.file(clip, "overlay.mp4")
        assert answer.status_code == 200
        assert answer.headers["content-disposition"] == "attachment"
        part = page.client.get(f"/api/experiment/{clip}/copy.mp4", headers={"range": "bytes=0-9"})
        assert (part.status_code, len(part.content)) == (206, 10)
        folder = store.folder
        assert [each.name for each in folder.iterdir()] == [clip]
        page.socket.close()
        while store.desks:
            time.sleep(0.02)
        assert not list(folder.iterdir())
        assert page.file(clip, "track.csv").status_code == 422
    assert not folder.exists()
    assert about["balls"] == 1


def test_without_a_length_angles_are_known_and_a_model_fitted(clip, tmp_path):
    path, truth = clip
    places = [
        [truth.attrs[f"{name}_pixel_{axis}"] for axis in "uv"] for name in ("pivot", "ball_1")
    ]
    description = {"pivot": places[0], "balls": places[1:], "is_proposed": True}
    job = {
        "path": str(path), "folder": str(tmp_path), "name": "tiny.mp4", "description": description,
    }  # fmt: skip
    WORK["look"](job, lambda *_: None)
    stages = []
    done, arrays = WORK["track"](job, lambda stage, share: stages.append((stage, share)))
    assert [stage for stage, _ in stages][-1] == "fitting"
    assert max(share for stage, share in stages if stage == "tracking") == 1.0
    assert "pivot_found" not in (tmp_path / "setup.toml").read_text("utf-8")  # only the ball was
    about, points = unpack(arrays["points"].tobytes())
    assert about["attributes"]["geometry"] == "angles"
    assert "length is unknown" in " ".join(map(english, done["warnings"]))
    # By the dynamics: g/l from the period.
    assert done["fits"]["decay"]["values"]["length"]["value"] == pytest.approx(0.363, rel=2e-3)
    _, ghost = unpack(arrays["model"].tobytes())
    assert np.nanmax(np.hypot(*(ghost["centre"] - points["centre"]))) < 0.5  # pixels
    with pytest.raises(ValueError, match="length must be known"):
        WORK["fit"]({**job, "kind": "model"}, lambda *_: None)
    for name in ("report.html", "track.nc"):
        assert WORK["export"]({**job, "file": name}, lambda *_: None) == ({"file": name}, {})
        assert (tmp_path / name).stat().st_size > 0


def gif_of(width, height):
    """A picture that says that it is so large, in a few bytes."""
    size = width.to_bytes(2, "little") + height.to_bytes(2, "little")
    table = b"\x80\x00\x00" + bytes(6)
    return b"GIF89a" + size + table + b",\0\0\0\0" + size + b"\0\x02\x02\x44\x01\0;"


def bad_files(clip, folder):
    """Yield names and contents of files that cannot be tracked, with what is said of them.

    What tracking itself refuses is in `tests/experiment/test_bad_videos.py`.
    """
    long = encoded(folder / "long.mp4", GREY[:10], [90_000 * 4000 * k for k in range(10)])
    yield "noise.mp4", random.Random(1).randbytes(20_000), "cannot be read as a video"
    yield "join.mp4", f"ffconcat version 1.0\nfile {clip}\n".encode(), "cannot be read"
    yield "bomb.gif", gif_of(15000, 15000), "frames of 15000 x 15000 pixels, at most"
    # FFmpeg itself reads none of this size.
    yield "larger.gif", gif_of(65535, 65535), "size of its frames is unknown|cannot be read"
    yield "long.mp4", long.read_bytes(), "at most 3600 s"


def test_a_bad_video_is_refused_in_one_line_and_the_server_goes_on(page, clip, tmp_path):
    with contextlib.ExitStack() as jobs:
        answers = [
            (name, said, jobs.enter_context(page.begin(do="look", clip=page.clip(content, name))))
            for name, content, said in bad_files(clip[0], tmp_path)
        ]
        for name, said, socket in answers:
            text = one_line(end_of(socket))
            assert re.search(said, text), (name, text)
            assert name in text
    assert page.client.get("/registry.json").status_code == 200


def test_flipped_bits_break_nothing(page, clip):
    whole = clip[0].read_bytes()
    chance = random.Random(7)
    for _ in range(3):
        broken = bytearray(whole)
        for _ in range(40):
            broken[chance.randrange(len(broken))] ^= 1 << chance.randrange(8)
        answer = page.do(do="look", clip=page.clip(bytes(broken)))
        if "done" not in answer:
            one_line(answer)
    assert page.client.get("/registry.json").status_code == 200


def test_a_lack_of_memory_is_explained(monkeypatch, tmp_path):
    def large(job, tell):
        raise MemoryError

    monkeypatch.setitem(WORK, "look", large)
    with pytest.raises(InputError, match="needs more memory than there is"):
        compute({"do": "look", "name": "swing.mp4"}, tmp_path, lambda share, stage="": None)


def test_what_is_cancelled_or_whose_page_has_gone_is_killed_and_removed():
    with opened() as (page, store):
        for leave in (lambda: None, page.socket.close):
            with page.begin(do="example", kind="toy") as socket:
                process = begun(socket)
                leave()
            wait(lambda process=process: process not in workers())
            wait(lambda: not list(store.folder.iterdir()))
        assert not store.desks


def test_uploads_are_limited_in_size(clip):
    content = clip[0].read_bytes()
    with opened(len(content)) as (page, store):
        answer = page.upload(content + b"x")
        assert answer.status_code == 413
        assert "limit for an upload" in answer.json()["error"]
        parts = (content[i : i + 1000] for i in range(0, len(content) + 1000, 1000))
        # In pieces of unknown number it is refused when it has become too large.
        answer = page.client.post(
            f"/api/experiment?desk={page.desk}", content=(p or b"too much" for p in parts)
        )
        assert answer.status_code == 413
        assert page.upload(b"").status_code == 422
        assert not list(store.folder.iterdir())
        key = page.clip(content)
        assert page.remove(key) == []
        assert not list(store.folder.iterdir())


def test_an_upload_that_breaks_off_leaves_nothing(page):
    messages = iter([
        {"type": "http.request", "body": b"begin", "more_body": True},
        {"type": "http.disconnect"},
    ])  # fmt: skip
    scope = {
        "type": "http", "method": "POST", "path": "/api/experiment", "http_version": "1.1",
        "query_string": f"desk={page.desk}".encode(), "scheme": "http", "root_path": "",
        "headers": [(b"host", b"127.0.0.1:8000"), (b"x-name", b"swing.mp4")],
    }  # fmt: skip
    sent = []

    async def receive():
        return next(messages)

    async def send(message):
        sent.append(message)

    page.client.portal.call(page.client.app, scope, receive, send)
    assert sent[0]["status"] == 400
    assert not list(page.client.app.state.clips.folder.iterdir())


def test_the_name_of_an_upload_is_never_a_path(page):
    answer = page.upload(b"x", b"..%2F..%2Fetc%0Apasswd")
    assert answer.json()["name"] == "../../etcpasswd"
    page.remove(answer.json()["clip"])


@pytest.mark.parametrize(
    "path",
    ["clip", "..%2Fclip", "track.csv"],
)
def test_only_the_results_of_a_clip_are_sent(page, path):
    clip = page.clip(b"secret")
    for key in (clip, "guess"):
        assert page.client.get(f"/api/experiment/{key}/{path}").status_code in (404, 405, 422)
    page.remove(clip)


def test_a_page_that_is_not_connected_has_no_place_for_clips(page):
    answer = page.upload(b"x", desk="guess")
    assert answer.status_code == 422
    assert "not connected" in answer.json()["error"]
    assert "no longer on the server" in one_line(page.do(do="look", clip="guess"))


def test_a_page_that_is_not_served_any_more_is_no_fault(page):
    page.socket.send_bytes(b"\x00\x01")  # nothing but its end matters
    assert page.upload(b"x").status_code == 200


def test_a_server_that_is_stopped_removes_its_clips_and_ends_their_work(tmp_path, monkeypatch):
    from websockets.sync.client import connect

    monkeypatch.setenv("TMPDIR", str(tmp_path))
    server = start_server()
    home = server.address.rstrip("/")
    address = server.address.replace("http", "ws") + "ws/experiment"
    with connect(f"{address}/desk", origin=home) as desk, connect(address, origin=home) as socket:
        key = json.loads(desk.recv())["desk"]
        socket.send(json.dumps({"desk": key, "do": "example", "kind": "toy"}))
        while not (result := workers(server.process.pid)):
            time.sleep(0.02)
        assert list(tmp_path.glob("latolato-clips-*/*"))
        stop_server(server)
    assert not list(tmp_path.glob("latolato-*"))
    # Also without a word from the server the worker would end: its input is closed.
    deadline = time.monotonic() + 10.0
    while Path(f"/proc/{result[0]}").exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not Path(f"/proc/{result[0]}").exists()


def test_the_free_swing_that_the_computer_films_is_measured_in_every_frame():
    with opened() as (page, _):
        made = page.do(do="example", kind="decay")["done"]
        proposal = made["proposal"]
        description = {
            "pivot": proposal["pivot"], "balls": proposal["balls"], "length": "36.3 cm",
            "radius": "20 mm", "mass": "108 g", "is_proposed": True,
            "is_pivot_found": True,
        }  # fmt: skip
        done = page.do(do="track", clip=made["clip"], description=description)["done"]
        assert "repeat" not in str(done)
        kinds = np.genfromtxt(
            page.file(made["clip"], "track.csv").text.splitlines(), str, delimiter=",", comments="#"
        )
        assert np.count_nonzero(kinds == "ok") == made["frames"]


def test_a_file_is_made_under_no_other_name(tmp_path):
    request = {"folder": str(tmp_path / "desk"), "file": "../report.html"}
    with pytest.raises(InputError, match=r"file must be one of track\.nc"):
        WORK["export"](request, lambda *_: None)
    assert not list(tmp_path.iterdir())
