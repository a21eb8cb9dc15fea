"""Temporary files of a server are gone after it, however it ends."""

import json
import os
import tempfile
from pathlib import Path

from websockets.sync.client import connect

from app_server import start_server, stop_server
from latolato.app.scratch import remove_orphans, scratch_folder


def test_temporary_files_lie_in_a_folder_that_is_removed(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with scratch_folder() as folder:
        assert Path(tempfile.mkdtemp()).parent == folder
        assert os.environ["TMPDIR"] == str(folder)
        remove_orphans(tmp_path)
        assert folder.is_dir()
    assert not list(tmp_path.iterdir())
    assert tempfile.gettempdir() == str(tmp_path)


def test_only_folders_without_a_server_are_removed(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    other = tmp_path / "of-somebody-else"
    other.mkdir()
    with scratch_folder() as kept:
        orphan, link = tmp_path / "latolato-app-orphan", tmp_path / "latolato-app-link"
        (orphan / "clips").mkdir(parents=True)
        (orphan / "lock").write_text(f"{os.getpid()} on this machine")  # its number is used again
        link.symlink_to(other)
        remove_orphans(tmp_path)
        assert sorted(tmp_path.iterdir()) == sorted([other, kept, link])


def test_what_a_killed_server_left_is_removed_by_the_next(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    killed = start_server()
    home = killed.address.rstrip("/")
    address = killed.address.replace("http", "ws") + "ws/experiment"
    with connect(f"{address}/desk", origin=home) as desk, connect(address, origin=home) as socket:
        key = json.loads(desk.recv())["desk"]
        socket.send(json.dumps({"desk": key, "do": "example", "kind": "toy"}))
        assert json.loads(socket.recv())["state"] == "waiting"
        left = list(tmp_path.glob("latolato-app-*"))
        assert list(left[0].glob("latolato-clips-*/*"))
        killed.process.kill()
        killed.process.wait()
    killed.process.stdout.close()
    assert left[0].is_dir()
    following = start_server()
    assert not left[0].exists()
    stop_server(following)
    assert not list(tmp_path.glob("latolato-app-*"))
