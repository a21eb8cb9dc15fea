"""Uploaded videos and tables on the server: of limited size, removed with their page."""

from __future__ import annotations

import math
import secrets
import shutil
import tempfile
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import anyio

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
    """Limits of uploads.

    Attributes
    ----------
    upload : int
        Size of one file [bytes].
    duration : float
        Longest clip [s].
    pixels, frames : int
        Largest frame, and most frames.
    """

    upload: int = 500_000_000
    duration: float = 600.0
    pixels: int = 3840 * 2160
    frames: int = 40_000

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
        longer = max(1.0, length / usual.duration)
        return replace(usual, upload=int(size), duration=length, frames=int(usual.frames * longer))

    @property
    def limits(self) -> Limits:
        """What the reader refuses by itself."""
        return Limits(duration=self.duration, pixels=self.pixels, frames=self.frames)


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
        Bytes received.
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
                if not clip.is_whole or clip.key not in self.clips:
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
        """Return a place for the clips of a page."""
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
            If `size` bytes [as announced] are too much.
        """
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
