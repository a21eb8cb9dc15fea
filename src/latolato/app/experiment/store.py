"""Uploaded videos and tables on the server: few, of limited size, removed with their page."""

from __future__ import annotations

import math
import secrets
import shutil
import tempfile
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import anyio

from latolato.app.processes import Limits as ProcessLimits
from latolato.app.processes import Workers
from latolato.app.run_request import TooLargeError
from latolato.core.errors import InputError
from latolato.experiment.video import Limits

_LONGEST_NAME = 80
# What lies in the folder of a clip. Messages contain the name of the upload, never a path.
UPLOAD = "clip"
FILES = {
    "copy.mp4": "video/mp4",
    "track.csv": "text/csv; charset=utf-8",
    "track.nc": "application/x-netcdf",
    "setup.toml": "application/toml",
    "overlay.mp4": "video/mp4",
    "report.html": "text/html; charset=utf-8",
}
# The one that the page plays itself; others are downloads.
COPY = "copy.mp4"


@dataclass(frozen=True, kw_only=True)
class Allowance:
    """Limits of uploads and of the work on them.

    Attributes
    ----------
    upload, stored : int
        Size of one file, and of all on the server together [bytes].
    clips, desk_clips, desks : int
        Number of clips on the server, of one page, and of pages with clips.
    duration : float
        Longest clip [s].
    pixels, frames : int
        Largest frame, and most frames.
    memory : float
        Address space of the process that reads a clip [bytes].
    cpu_time, wall_time : float
        Longest work on a clip [s].
    stall, upload_time : float
        Longest pause of an upload, and longest upload [s].
    jobs, waiting : int
        Clips that are worked on at the same time, and jobs of one page that may wait.
    """

    upload: int = 500_000_000
    stored: int = 3_000_000_000
    clips: int = 40
    desk_clips: int = 16
    desks: int = 50
    duration: float = 600.0
    pixels: int = 3840 * 2160
    frames: int = 40_000
    memory: float = 6e9
    cpu_time: float = 1800.0
    wall_time: float = 1800.0
    stall: float = 30.0
    upload_time: float = 900.0
    jobs: int = 2
    waiting: int = 32

    @classmethod
    def of(cls, megabytes: float | None = None, minutes: float | None = None) -> Allowance:
        """Return the usual allowance with another size and length of a clip.

        Raises
        ------
        InputError
            Unless both are positive.

        Examples
        --------
        >>> most = Allowance.of(megabytes=2000, minutes=30)
        >>> most.upload, most.duration, most.frames
        (2000000000, 1800.0, 120000)
        """
        usual = cls()
        for name, value in (("video-megabytes", megabytes), ("video-minutes", minutes)):
            if value is not None and not 0.0 < value < math.inf:
                raise InputError("must be positive", parameter=name, value=value)
        size = usual.upload if megabytes is None else 1e6 * megabytes
        length = usual.duration if minutes is None else 60.0 * minutes
        larger, longer = max(1.0, size / usual.upload), max(1.0, length / usual.duration)
        return replace(
            usual,
            upload=int(size),
            stored=int(usual.stored * larger),
            upload_time=usual.upload_time * larger,
            duration=length,
            frames=int(usual.frames * longer),
            cpu_time=usual.cpu_time * longer,
            wall_time=usual.wall_time * longer,
        )

    @property
    def limits(self) -> Limits:
        """What the reader refuses by itself; half of the memory is for what is learned."""
        return Limits(
            duration=self.duration,
            pixels=self.pixels,
            frames=self.frames,
            memory=0.5 * self.memory,
        )

    @property
    def workers(self) -> Workers:
        """New processes that keep to this."""
        limits = ProcessLimits(memory=self.memory, cpu_time=self.cpu_time)
        return Workers(self.jobs, limits, self.wall_time)


@dataclass
class Clip:
    """One upload.

    Attributes
    ----------
    key : str
        Its name in addresses.
    folder : Path
        Where all of it lies.
    name : str
        What the user calls it, for people only.
    size : int
        Bytes received, and later of all that was made of them.
    is_whole : bool
        Whether it is complete: uploaded, or painted.
    about : dict
        The results of the work on it.
    trial : dict, optional
        Its row of the trial table.
    """

    key: str
    folder: Path
    name: str
    size: int = 0
    is_whole: bool = False
    about: dict[str, Any] = field(default_factory=dict)
    trial: dict[str, Any] | None = None

    @property
    def upload(self) -> Path:
        """Where the upload lies."""
        return self.folder / UPLOAD

    def weigh(self) -> None:
        """Count what lies in the folder."""
        with suppress(OSError):
            self.size = sum(path.stat().st_size for path in self.folder.iterdir())

    def file(self, name: str) -> Path | None:
        """The path of one of `FILES`, None if it is none of them or does not exist."""
        if name not in FILES:
            return None
        path = self.folder / name
        return path if path.is_file() else None


class Desk:
    """The clips of one open page and the work on them; both end when it closes."""

    def __init__(self, store: Store, key: str) -> None:
        self.key = key
        self.clips: dict[str, Clip] = {}
        self.running: set[anyio.CancelScope] = set()
        self._store = store

    def close(self) -> None:
        """End the work of this page and remove everything that is its own."""
        for scope in self.running:
            scope.cancel()
        for clip in list(self.clips.values()):
            self.remove(clip)
        self._store.desks.pop(self.key, None)

    def remove(self, clip: Clip) -> None:
        """Remove a clip, or what work wrote after that."""
        self.clips.pop(clip.key, None)
        shutil.rmtree(clip.folder, ignore_errors=True)

    @contextmanager
    def work_on(self, clip: Clip) -> Iterator[Path]:
        """Give the folder of a clip to work that ends with this page."""
        with anyio.CancelScope() as scope:
            self.running.add(scope)
            try:
                yield clip.folder
            finally:
                self.running.discard(scope)
                if clip.is_whole and clip.key in self.clips:
                    clip.weigh()
                else:
                    self.remove(clip)
        if scope.cancelled_caught:
            raise InputError(f"the page of {clip.name} has closed")

    def clip(self, key: Any) -> Clip:
        """Return a clip of this page.

        Raises
        ------
        InputError
            If there is none of that key.
        """
        if not isinstance(key, str) or key not in self.clips:
            raise InputError("this file is no longer on the server: upload it again")
        return self.clips[key]


class Store:
    """All clips of a server, below one temporary folder."""

    def __init__(self, allowance: Allowance | None = None) -> None:
        self.allowance = allowance or Allowance()
        self.desks: dict[str, Desk] = {}
        self._folder: Path | None = None

    @property
    def folder(self) -> Path:
        """The folder of this server, made when it is first needed."""
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix="latolato-clips-"))
        return self._folder

    def close(self) -> None:
        """Remove everything."""
        for desk in list(self.desks.values()):
            desk.close()
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None

    def open_desk(self) -> Desk:
        """Return a place for the clips of a page.

        Raises
        ------
        TooLargeError
            If as many pages as may be are open.
        """
        if len(self.desks) >= self.allowance.desks:
            raise TooLargeError(
                f"{self.allowance.desks} pages with videos are open: close one of them"
            )
        desk = Desk(self, secrets.token_urlsafe(12))
        self.desks[desk.key] = desk
        return desk

    def desk(self, key: Any) -> Desk:
        """Return the place of a page.

        Raises
        ------
        InputError
            If there is none: its page has closed.
        """
        if not isinstance(key, str) or key not in self.desks:
            raise InputError("this page is not connected: reload it")
        return self.desks[key]

    def clip(self, key: str) -> Clip | None:
        """Return a clip of any page, by its key that only its page knows."""
        return next((d.clips[key] for d in self.desks.values() if key in d.clips), None)

    def admit(self, desk: Desk, name: str, size: int = 0) -> Clip:
        """Return a new clip without content.

        Raises
        ------
        TooLargeError
            If there are too many, or `size` bytes [as announced] are too much.
        """
        most = self.allowance
        if len(desk.clips) >= most.desk_clips:
            raise TooLargeError(f"{most.desk_clips} files are open: remove one of them first")
        if sum(len(d.clips) for d in self.desks.values()) >= most.clips:
            raise TooLargeError(f"the server holds {most.clips} files: try again later")
        key = secrets.token_urlsafe(12)
        clip = Clip(key, self.folder / key, display_name(name))
        self.check_size(clip, size)
        clip.folder.mkdir()
        desk.clips[key] = clip
        return clip

    def check_size(self, clip: Clip, size: int) -> None:
        """Refuse a clip of `size` bytes if that is too much.

        Raises
        ------
        TooLargeError
            With the limit.
        """
        most = self.allowance
        if size > most.upload:
            raise TooLargeError(
                f"{clip.name} is larger than {most.upload / 1e6:g} MB, the limit for an upload: "
                "cut it, or start the application with --video-megabytes"
            )
        others = sum(f.size for d in self.desks.values() for f in d.clips.values() if f is not clip)
        if others + size > most.stored:
            raise TooLargeError("the server holds too many files: remove some, or try again later")


def display_name(text: str) -> str:
    """Return the name of an upload for messages: one line without folders or control characters.

    Examples
    --------
    >>> display_name("..%2F..%2Fetc%2Fswing%0A.mp4")
    'swing.mp4'
    """
    plain = unicodedata.normalize("NFC", unquote(text, errors="replace")).replace("\\", "/")
    name = "".join(c for c in plain.rpartition("/")[2] if c.isprintable()).strip(" .")
    return name[-_LONGEST_NAME:] or "video"
