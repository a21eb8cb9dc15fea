"""Uploaded videos and tables on the server: of limited size, removed with their page."""

from __future__ import annotations

import secrets
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from latolato.app.run_request import TooLargeError
from latolato.core.errors import InputError

# Size of the largest upload.
MOST_BYTES = 4_000_000_000
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
    trial : dict, optional
        Its row of the trial table.
    """

    key: str
    folder: Path
    name: str
    size: int = 0
    is_whole: bool = False
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
    """The clips of one open page, removed when it closes."""

    def __init__(self, store: Store, key: str) -> None:
        self.key = key
        self.clips: dict[str, Clip] = {}
        self._store = store

    def close(self) -> None:
        """Remove everything that is this page's own; its jobs end with their sockets."""
        for clip in list(self.clips.values()):
            self.remove(clip)
        self._store.desks.pop(self.key, None)

    def remove(self, clip: Clip) -> None:
        """Remove a clip, or what work wrote after that."""
        self.clips.pop(clip.key, None)
        shutil.rmtree(clip.folder, ignore_errors=True)

    @contextmanager
    def work_on(self, clip: Clip) -> Iterator[Path]:
        """Give the folder of a clip to work; nothing of it stays if the clip does not."""
        try:
            yield clip.folder
        finally:
            if not clip.is_whole or clip.key not in self.clips:
                self.remove(clip)

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
    """All clips of a server, below one temporary folder, each of at most `most_bytes`."""

    def __init__(self, most_bytes: int) -> None:
        self.most_bytes = most_bytes
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
        if size > self.most_bytes:
            raise TooLargeError(
                f"{clip.name} is larger than {self.most_bytes / 1e6:g} MB, the limit for an upload",
                way_out="cut it, or use `latolato track`",
            )


def display_name(text: str) -> str:
    """Return the name of an upload for messages, from a header that pages write it to.

    Examples
    --------
    >>> display_name("swing%201.mp4")
    'swing 1.mp4'
    """
    return "".join(c for c in unquote(text) if c.isprintable()) or "video"
