"""Uploaded videos and tables on the server: of limited size, removed with their page."""

from __future__ import annotations

import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

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
    desk : str
        The key of its page.
    folder : Path
        Where all of it lies; its name is the key of the clip in addresses.
    name : str
        What the user calls it, for people only.
    trial : dict, optional
        Its row of the trial table.
    """

    desk: str
    folder: Path
    name: str
    trial: dict[str, Any] | None = None

    @property
    def key(self) -> str:
        """Its name in addresses."""
        return self.folder.name

    @property
    def upload(self) -> Path:
        """Where the upload lies."""
        return self.folder / UPLOAD


class Store:
    """The clips of all open pages of a server, below one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.desks: set[str] = set()
        self.clips: dict[str, Clip] = {}

    @contextmanager
    def open_desk(self) -> Iterator[str]:
        """Lend a page a key for its clips, which are removed when it closes."""
        key = secrets.token_urlsafe(12)
        self.desks.add(key)
        try:
            yield key
        finally:
            for clip in self.of_desk(key):
                self.remove(clip)
            self.desks.remove(key)

    def of_desk(self, key: str) -> list[Clip]:
        """Return the clips of a page."""
        return [clip for clip in self.clips.values() if clip.desk == key]

    def clip(self, key: str) -> Clip:
        """Return a clip by its key, which only its page knows.

        Raises
        ------
        InputError
            If there is none of that key.
        """
        if key not in self.clips:
            raise InputError("this file is no longer on the server: upload it again")
        return self.clips[key]

    def admit(self, desk: str | None, name: str) -> Clip:
        """Return a new clip without content.

        Raises
        ------
        InputError
            If its page has closed.
        """
        if desk not in self.desks:
            raise InputError("this page is not connected: reload it")
        clip = Clip(desk, self.folder / secrets.token_urlsafe(12), display_name(name))
        clip.folder.mkdir()
        self.clips[clip.key] = clip
        return clip

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
            if clip.key not in self.clips or not clip.upload.is_file():
                self.remove(clip)


def display_name(text: str) -> str:
    """Return the name of an upload for messages, from a header that pages write it to.

    Examples
    --------
    >>> display_name("swing%201.mp4")
    'swing 1.mp4'
    """
    return "".join(c for c in unquote(text) if c.isprintable()) or "video"
