"""The cache folder: what is read back, what is refused, and that neither stops a run."""

from __future__ import annotations

import hashlib
import os
import pickle
import shutil
import subprocess
import sys
import urllib.request
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import pytest

from app_server import start_server, stop_server
from latolato.core import cache
from latolato.numerics import jit
from latolato.numerics.abi import sources_hash
from page_blocks import unpack


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache folder of a process that has not warned yet."""
    monkeypatch.setenv("LATOLATO_CACHE_DIR", str(tmp_path / "kernels"))
    cache.warn.cache_clear()
    return tmp_path / "kernels"


def make(_compile_part):
    def double(x):
        return 2.0 * x

    return double


def run_kernel():
    """Run a kernel as a new process would; return whether it was read, and the warnings."""
    kernel = jit.compile_kernel(make, "double")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assert kernel(21.0) == 42.0
    assert all(w.category is RuntimeWarning for w in caught)
    return bool(kernel._cache_hits), [str(w.message) for w in caught]


def only_file(folder):
    (result,) = (path for path in folder.rglob("*") if path.is_file())
    return result


def flipped(at):
    def damage(content):
        changed = bytearray(content)
        changed[at * (len(content) - 1) // 10] ^= 4
        return bytes(changed)

    return damage


def with_checksum(content):
    return hashlib.sha256(content).digest() + content


DAMAGE = {
    "empty": lambda content: b"",
    "short": lambda content: content[:7],
    "truncated": lambda content: content[:-1],
    "longer": lambda content: content + b"\0",
    "other": lambda content: b"something else",
    "no pickle": lambda content: with_checksum(b"something else"),
    "no kernel": lambda content: with_checksum(pickle.dumps((1, 2))),
    **{f"bit {tenth}": flipped(tenth) for tenth in range(11)},
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_kernel_is_compiled_again_with_one_warning(folder, damage):
    assert run_kernel() == (False, [])
    assert run_kernel() == (True, [])
    file = only_file(folder)
    file.write_bytes(damage(file.read_bytes()))

    was_read, (warning,) = run_kernel()

    assert not was_read
    assert "compiled again" in warning
    assert run_kernel() == (True, [])


def test_every_flipped_bit_of_a_file_is_noticed(folder):
    file = folder / "file"
    cache.write(file, b"content")
    assert cache.read(file) == b"content"
    stored = file.read_bytes()
    for bit in range(8 * len(stored)):
        changed = bytearray(stored)
        changed[bit // 8] ^= 1 << bit % 8
        file.write_bytes(changed)
        with pytest.raises(ValueError, match="checksum"):
            cache.read(file)


class Planted:
    """A pickle that runs code of another user's choice."""

    def __init__(self, mark):
        self.mark = mark

    def __reduce__(self):
        return os.mkdir, (str(self.mark),)


def by_others(path):
    path.chmod(0o666)


def by_the_group(path):
    path.chmod(0o620)


def of_another(path):
    if os.geteuid() != 0:
        pytest.skip("only root can give a file to another user")
    os.chown(path, 12345, -1)


REFUSED = pytest.mark.parametrize(
    "hand_over, reason",
    [
        (by_others, "can be written by other users"),
        (by_the_group, "can be written by other users"),
        (of_another, "belongs to another user"),
    ],
)


@REFUSED
def test_a_kernel_that_others_could_plant_is_refused_with_a_reason(
    folder, tmp_path, hand_over, reason
):
    run_kernel()
    file = only_file(folder)
    mark = tmp_path / "mark"
    file.write_bytes(with_checksum(pickle.dumps(Planted(mark))))
    hand_over(file)

    was_read, (warning,) = run_kernel()

    assert not was_read
    assert reason in warning
    assert not mark.exists()
    assert run_kernel() == (True, [])


@REFUSED
@pytest.mark.parametrize("level", [0, 1])
def test_a_folder_that_others_can_write_to_is_not_used(folder, hand_over, reason, level):
    run_kernel()
    file = only_file(folder)
    kept = file.read_bytes()
    place = [folder, file.parent][level]
    hand_over(place)
    place.chmod(place.stat().st_mode | 0o700)

    was_read, (warning,) = run_kernel()

    assert not was_read
    assert str(place) in warning
    assert reason in warning
    assert "LATOLATO_CACHE_DIR" in warning
    assert file.read_bytes() == kept


def test_files_and_folders_of_the_cache_are_private_whatever_the_umask(folder):
    before = os.umask(0)
    try:
        run_kernel()
    finally:
        os.umask(before)
    file = only_file(folder)
    assert [path.stat().st_mode & 0o777 for path in (folder, file.parent, file)] == [
        0o700, 0o700, 0o600,
    ]  # fmt: skip
    assert run_kernel() == (True, [])


@pytest.mark.parametrize("below", ["", "more"])
def test_a_cache_folder_that_is_a_file_costs_one_warning(tmp_path, monkeypatch, folder, below):
    folder.write_text("not a folder")
    monkeypatch.setenv("LATOLATO_CACHE_DIR", str(folder / below))

    was_read, (warning,) = run_kernel()

    assert not was_read
    assert f"'{folder}' is not a folder" in warning
    assert run_kernel() == (False, [])
    assert folder.read_text() == "not a folder"


def test_a_full_disk_costs_one_warning_and_leaves_no_file(folder):
    resource = pytest.importorskip("resource", reason="limits of file sizes are Unix's")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard))
    try:
        was_read, (warning,) = run_kernel()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not was_read
    assert "File too large" in warning
    assert not [path for path in folder.rglob("*") if path.is_file()]
    assert run_kernel() == (False, [])


def test_a_read_only_folder_costs_one_warning(folder, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied", str(folder))

    monkeypatch.setattr("tempfile.mkstemp", refuse)
    was_read, (warning,) = run_kernel()
    assert not was_read
    assert f"Permission denied: '{folder}'" in warning


def test_a_user_without_a_home_gets_one_warning(monkeypatch):
    for name in ("LATOLATO_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)

    def fail():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", fail)
    cache.warn.cache_clear()
    was_read, (warning,) = run_kernel()
    assert not was_read
    assert "no home folder" in warning


def test_what_many_write_at_once_is_read_whole_or_not_at_all(folder):
    contents = [bytes([i]) * 200_000 for i in range(8)]
    together = Barrier(len(contents))

    def write_and_read(content):
        for i in range(20):
            file = folder / str(i) / "file"  # all of them find no folder, and make it
            together.wait(timeout=60)
            cache.write(file, content)
            assert cache.read(file) in contents

    with ThreadPoolExecutor(len(contents)) as pool:
        list(pool.map(write_and_read, contents))
    assert sum(path.is_file() for path in folder.rglob("*")) == 20


@pytest.fixture
def damaged(tmp_path, monkeypatch):
    """A cache with the machine code of a run, every file of it empty."""
    from latolato.scenario.scenario import load_scenario

    load_scenario("zeno").record()
    folder = tmp_path / "damaged"
    folder.mkdir(mode=0o700)
    kept = cache.cache_directory() / sources_hash()
    shutil.copytree(kept, folder / kept.name)
    files = list(folder.rglob("*.o"))
    assert files
    for file in files:
        file.write_bytes(b"")
    monkeypatch.setenv("LATOLATO_CACHE_DIR", str(folder))
    return folder


@pytest.mark.slow
def test_damaged_machine_code_is_made_again(damaged):
    command = [sys.executable, "-m", "latolato", "simulate", "zeno"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "complete" in done.stdout
    assert "warning" not in done.stderr
    assert any(file.stat().st_size > 1000 for file in damaged.rglob("*.o"))


@pytest.mark.slow
def test_the_command_line_warns_in_one_line_that_nothing_can_be_kept(tmp_path, monkeypatch):
    file = tmp_path / "file"
    file.touch()
    monkeypatch.setenv("LATOLATO_CACHE_DIR", str(file))
    command = [sys.executable, "-m", "latolato", "simulate", "zeno"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (line,) = [line for line in done.stderr.splitlines() if "warning" in line]
    assert line.startswith("latolato: warning: machine code cannot be kept")


@pytest.mark.slow
@pytest.mark.usefixtures("damaged")
def test_the_application_gives_a_run_in_spite_of_damaged_kernels():
    server = start_server()
    try:
        settings = urllib.request.Request(
            f"{server.address}api/run",
            b'{"scenario": "zeno"}',
            {"Content-Type": "application/json"},
        )
        _, arrays = unpack(urllib.request.urlopen(settings).read())
    finally:
        stop_server(server)
    assert len(arrays["time"]) > 100
