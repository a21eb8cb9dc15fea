"""Reads videos: frames in order with the container's time stamps, turned as they are displayed."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from fractions import Fraction
from itertools import chain
from numbers import Real
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from latolato.core.errors import InputError, Sentence, Word, import_extra, reading
from latolato.core.quantities import POSITIVE
from latolato.core.registry import checked_number
from latolato.core.rules import broken_rule
from latolato.experiment.container import (
    Clock,
    declared_clock,
    displayed_turn,
    missing_bytes,
    square_size,
)
from latolato.experiment.rules import broken, said

# Memory for a hundred frames and what is learned of them, per pixel of a frame [bytes]: 100 were
# measured at 3840 x 2160 with fifty frames.
_PER_PIXEL = 340
# Of the numbers in `Limits`.
_UNITS = {"duration": "s", "pixels": "pixels", "frames": "frames", "memory": "bytes"}
# Suffixes of pictures, which sometimes come by the folder.
_PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp")
# Kinds of files that hold a video themselves: a playlist names others, here or in a network.
_CONTAINERS = (
    "mov", "matroska", "avi", "mpeg", "mpegts", "asf", "flv", "ogg", "mxf", "nut", "ivf", "dv",
    "h264", "hevc", "m4v", "mpegvideo", "obu", "yuv4mpegpipe", "mjpeg", "gif", "apng", "wtv", "rm",
    "swf", "image2", "png_pipe", "jpeg_pipe", "mp3", "wav", "flac", "aac", "caf",
)  # fmt: skip
_OPTIONS = {"format_whitelist": ",".join(_CONTAINERS), "protocol_whitelist": "file"}
_AS_VIDEO = (
    "make a video of them, with the times at which they were taken, e.g. with ffmpeg -framerate"
)
# Error of a time stamp as a decimal number [s].
_ROUNDED = 1e-6
# Pixel formats whose planes are luma, then chroma at half resolution.
_PLANAR = ("yuv420p", "yuvj420p")
# ITU-T H.273: luma coefficients, and tone curves of high dynamic range.
_MATRICES = {1: "bt709", 5: "bt601", 6: "bt601", 9: "bt2020", 10: "bt2020"}
_TONES = {16: "pq", 18: "hlg"}


@dataclass(frozen=True, kw_only=True)
class Limits:
    """The largest videos that are read.

    Parameters
    ----------
    duration : float
        Length of the video in the scene's time [s].
    pixels : int
        Width times height of a frame.
    frames : int
        Number of frames.
    memory : float
        Most memory that learning from its frames may take [bytes].
    """

    duration: float = 3600.0
    pixels: int = 4096 * 2304
    frames: int = 250_000
    memory: float = 6e9

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if isinstance(value, bool) or not isinstance(value, Real):
                raise broken_rule("number", parameter=name, value=value)
            if not float(value) > 0.0:
                raise InputError("must be positive", parameter=name, value=value)

    def check(self, name: str, value: float, found: Sentence) -> None:
        """Raise if a value exceeds one of the limits; `found` describes the value."""
        limit, unit = getattr(self, name), Word(_UNITS[name])
        if value > limit:
            values = {"found": found, "limit": limit, "unit": unit, "name": name}
            raise broken("beyond_limit", values)


class Frame(NamedTuple):
    """One decoded frame as displayed: number, time [s] and its three planes (chroma halved).

    Numbers count from the first frame between `Video.start` and `Video.end` on.
    """

    number: int
    time: float
    luma: np.ndarray
    blue: np.ndarray
    red: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Video:
    """A readable video and what its container says about it.

    Attributes
    ----------
    path : Path
        The file.
    width, height : int
        Size as displayed, after its rotation and with square pixels.
    rotation : int
        Clockwise turn that the container asks for [degrees]: 0, 90, 180 or 270.
    is_mirrored : bool
        Whether it asks for left and right to be swapped before the turn.
    frame_rate : float
        Mean number of frames per second of the scene's time as declared; 0 if unknown.
    frame_count : int
        Number of frames that the container shows, without those that an edit list cuts away; 0 if
        unknown.
    matrix : str
        Which luma coefficients turn planes into colours: ``"bt601"``, ``"bt709"`` or ``"bt2020"``.
    tone : str
        The tone curve: ``"srgb"``, or ``"hlg"`` or ``"pq"`` of high dynamic range.
    is_full_range : bool
        Whether luma runs from 0 to 255 instead of 16 to 235.
    slow_motion : float
        Factor by which the container's clock is slower than the scene's.
    clock : Clock
        What the container declares about it.
    is_cut_off : bool
        Whether the end of the file is missing.
    start, end : float
        Times between which frames are decoded, both included [s].
    first_frame : int
        Number in the file of the first of these frames.
    region : tuple of float, optional
        Left, top, right and bottom of the part in which to look for balls [pixels].
    steadier : callable, optional
        Changes each frame to what a camera at rest would have taken.
    """

    path: Path
    width: int
    height: int
    rotation: int
    is_mirrored: bool
    frame_rate: float
    frame_count: int
    matrix: str
    tone: str
    is_full_range: bool
    slow_motion: float
    clock: Clock
    is_cut_off: bool
    limits: Limits
    start: float = -math.inf
    end: float = math.inf
    first_frame: int = 0
    region: tuple[float, float, float, float] | None = None
    steadier: Callable[[Frame], Frame] | None = None

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """First column and row in which balls are looked for, and the first ones beyond."""
        left, top, right, bottom = self.region or (0.0, 0.0, self.width - 1.0, self.height - 1.0)
        low, high = np.floor([left, top]).astype(int), np.ceil([right, bottom]).astype(int) + 1
        return np.maximum(low, 0), np.minimum(high, [self.width, self.height])

    def shows(self, place: Sequence[float] | np.ndarray) -> bool:
        """Return whether the pictures show a place (column, row) [pixels]."""
        return bool(0 <= place[0] <= self.width - 1 and 0 <= place[1] <= self.height - 1)

    @property
    def expected_count(self) -> int:
        """About how many frames lie between start and end, 0 if that is unknown."""
        last: float = self.frame_count
        if self.end < math.inf:
            last = min(last, self.end * self.frame_rate + 1.0)
        return max(math.ceil(last) - self.first_frame, 0)

    def frames(self) -> Iterator[Frame]:
        """Decode the frames between start and end in order.

        Raises
        ------
        InputError
            If a frame's time stamp is missing or does not increase, a limit is passed, or no frame
            lies between start and end.
        """
        last = first = since = -math.inf
        number = 0
        size = (0, 0)
        is_turned = self.rotation % 180 == 90
        shown = (self.height, self.width) if is_turned else (self.width, self.height)
        with reading(self.path), _opened(self.path) as container:
            stream = container.streams.video[0]
            stream.thread_count = 1  # each thread would hold frames of its own
            for picture in _pictures(self.path, container, stream):
                if picture.pts is None:
                    raise broken("no_time_stamp", {"number": number})
                time = float(picture.pts * stream.time_base) / self.slow_motion
                if number == 0:
                    first, size = time, (picture.width, picture.height)
                if (picture.width, picture.height) != size:
                    sizes = {"width": picture.width, "height": picture.height}
                    raise broken("other_size", {"number": number, **sizes})
                if not time > last:
                    stamps = {"time": time, "last": last}
                    raise broken("falling_stamp", {"number": number, **stamps})
                if time > self.end + _ROUNDED:
                    break
                if time >= self.start - _ROUNDED:
                    since = time if since == -math.inf else since
                    so_far = said("seconds_so_far", seconds=time - since)
                    self.limits.check("duration", time - since, so_far)
                    count = number - self.first_frame + 1
                    self.limits.check("frames", count, said("frames_so_far", count=count))
                    planes = _planes(_square(picture, shown), self.rotation, self.is_mirrored)
                    frame = Frame(count - 1, time, *planes)
                    yield self.steadier(frame) if self.steadier else frame
                    # What comes after the last frame that is wanted may be damaged.
                    if time >= self.end - _ROUNDED:
                        break
                last = time
                number += 1
            else:
                declared = _duration(container, stream) / self.slow_motion
                if self.frame_rate:  # the duration of an AVI without its end is that of the rest
                    declared = max(declared, self.frame_count / self.frame_rate)
                if self.is_cut_off and number and last - first < 0.97 * declared - 0.1:
                    lengths = {"seconds": f"{last - first:.2f}", "declared": f"{declared:.2f}"}
                    raise broken("missing_part", {"count": number, **lengths})
            if since == -math.inf:
                ends = {"start": f"{self.start:g}", "end": f"{self.end:g}"}
                raise broken("no_frame_between", ends)


def open_video(
    path: str | Path,
    *,
    slow_motion: float | None = None,
    limits: Limits | None = None,
    start: float = -math.inf,
    end: float = math.inf,
) -> Video:
    """Open a video file, decoding its frames up to the first at `start`.

    Parameters
    ----------
    path : str or Path
        The video.
    slow_motion : float
        How many times slower than life it plays: 8 for a 240 fps recording stored at 30 fps. By
        default the factor that the file declares unambiguously, otherwise 1.
    limits : Limits
        Refuse larger videos.
    start, end : float
        Times between which frames are decoded later, both included [s].

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    InputError
        If it is not a video, has no pictures, exceeds a limit or ends before `start`.
        If PyAV is missing.
    """
    path = Path(path)
    limits = limits or Limits()
    if slow_motion is not None:
        slow_motion = checked_number("slow_motion", slow_motion, POSITIVE, "1")
    with reading(path):
        _check_file(path)
        with _opened(path) as container:
            if not len(container.streams):
                raise _unreadable(path, "empty_container")
            if not container.streams.video:
                raise _unreadable(path, "no_stream")
            stream = container.streams.video[0]
            context = stream.codec_context
            width, height = square_size(context.width, context.height, stream.sample_aspect_ratio)
            if width * height == 0:
                raise _unreadable(path, "frames_without_size")
            clock = declared_clock(container, stream)
            if slow_motion is None:
                slow_motion = clock.slow_motion if clock.is_sure else 1.0
            count = _frame_count(container, stream)
            size = {"width": width, "height": height}
            limits.check("pixels", width * height, said("size_of_frames", **size))
            memory = width * height * _PER_PIXEL
            limits.check("memory", memory, said("memory_of_frames", **size, memory=memory))
            duration = _duration(container, stream) / slow_motion
            pictures = _pictures(path, container, stream)
            picture = next(pictures, None)
            if picture is None:
                raise _unreadable(path, "no_decoded_frame")
            if picture.interlaced_frame:
                raise broken("interlaced")
            first_frame = 0
            if start > -math.inf:
                slower = stream.time_base / Fraction(slow_motion)
                first_frame = _number_at(start, chain([picture], pictures), slower)
            rotation, is_mirrored = displayed_turn(picture)
            shown = _square(picture, (width, height))
            video = Video(
                path=path,
                width=(width, height)[rotation % 180 // 90],
                height=(height, width)[rotation % 180 // 90],
                rotation=rotation,
                is_mirrored=is_mirrored,
                frame_rate=float(stream.average_rate or 0.0) * slow_motion,
                frame_count=count,
                matrix=_matrix(shown),
                tone=_TONES.get(int(picture.color_trc), "srgb"),
                is_full_range=shown.color_range == 2 or shown.format.name.startswith("yuvj"),
                slow_motion=slow_motion,
                clock=clock,
                is_cut_off=missing_bytes(path) > 0,
                limits=limits,
                start=start,
                end=end,
                first_frame=first_frame,
            )
            part = min(end, duration) - max(start, 0.0)
            limits.check("duration", part, said("seconds_in_all", seconds=part))
            expected = video.expected_count
            limits.check("frames", expected, said("frames_in_all", count=expected))
            return video


def _number_at(start: float, pictures: Iterable[Any], tick: Fraction) -> int:
    """Return the number of the first picture at or after a time [s], in ticks of a length [s]."""
    time = -math.inf
    for number, picture in enumerate(pictures):
        time = time if picture.pts is None else float(picture.pts * tick)
        if time >= start - _ROUNDED:
            return number
    raise broken("start_after_end", {"time": time}, parameter="start", value=start)


def _check_file(path: Path) -> None:
    """Raise unless there is a file that may be a video."""
    if path.is_dir():
        pictures = _pictures_in(path)
        raise InputError(
            f"it is a folder{pictures and f' with {pictures}'}", way_out="name a video"
        )
    if not path.exists():
        if not (path.suffix.lower() in _PICTURES and set("%*?") & set(path.name)):
            raise FileNotFoundError(f"there is no video '{path}'")
        pictures = _pictures_in(path.parent) or "no numbered pictures"
        raise InputError(
            f"it names a sequence of pictures ({pictures} in '{path.parent}')", way_out=_AS_VIDEO
        )
    if path.suffix.lower() in _PICTURES:
        pictures = _pictures_in(path.parent)
        note = f" (its folder has {pictures})" if pictures else ""
        raise InputError(f"it is a picture{note}", way_out=_AS_VIDEO)
    if path.stat().st_size == 0:
        raise broken("empty_video")


def digest_of(path: str | Path) -> str:
    """Return the SHA-256 of a file."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _pictures_in(folder: Path) -> str:
    """Return which numbered pictures a folder has and which are missing, nothing without any."""
    if not folder.is_dir():
        return ""
    names = [one.stem for one in folder.iterdir() if one.suffix.lower() in _PICTURES]
    numbers = sorted({int(tail[0]) for name in names if (tail := re.findall(r"(\d+)$", name))})
    if len(numbers) < 2:
        return ""
    missing = (
        sorted(set(range(numbers[0], numbers[-1] + 1)) - set(numbers))
        if numbers[-1] < 10**7
        else []
    )
    gaps = f", {', '.join(map(str, missing[:5]))} missing" if missing else ""
    return f"pictures {numbers[0]} to {numbers[-1]}{gaps}"


def _unreadable(path: Path, rule: str, fault: str = "") -> InputError:
    """Return the error for a file that cannot be read: that its end is missing, if it is."""
    missing = missing_bytes(path)
    if missing:
        return broken("missing_end", {"count": missing})
    return broken(rule, {"fault": fault})


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Open a container, with FFmpeg's reasons in one line."""
    av = import_extra("av", "video", "reading videos")
    # FFmpeg's own log, silent: a message to Python from a decoding thread stops a file's closing.
    av.logging.restore_default_callback()
    av.logging.set_libav_level(av.logging.PANIC)
    try:
        container = av.open(str(path), container_options=_OPTIONS)
    except av.error.FFmpegError as error:
        raise _unreadable(path, "not_video", error.strerror) from None
    with container:
        yield container


def _pictures(path: Path, container: Any, stream: Any) -> Iterator[Any]:
    """Decode one stream, with FFmpeg's reasons in one line.

    It ends where a file is cut off amid a frame; `Video.frames` judges how much is missing.
    """
    import av

    count = 0
    try:
        for picture in container.decode(stream):
            count += 1
            yield picture
    except av.error.FFmpegError as error:
        if count and not missing_bytes(path):
            fault = {"count": count, "fault": error.strerror}
            raise broken("damaged_video", fault) from None
        if not count:
            raise _unreadable(path, "decoding_fails", error.strerror) from None


def _frame_count(container: Any, stream: Any) -> int:
    """Return how many frames a container says that it shows, 0 if it does not say.

    The edit list of a trimmed MP4 leaves frames out of the index, or marks those that are decoded
    only because later ones build on them.
    """
    declared = int(stream.frames)
    if "mp4" not in container.format.name or not len(stream.index_entries):
        return declared
    return min(declared, sum(not entry.is_discard for entry in stream.index_entries))


def _duration(container: Any, stream: Any) -> float:
    """Return the length that the container declares [s], 0 if it does not."""
    if stream.duration is not None and stream.time_base is not None:
        return float(stream.duration * stream.time_base)
    return float(container.duration or 0) / 1e6


def _matrix(picture: Any) -> str:
    """Return which luma coefficients the frames carry; untagged ones go by their height."""
    named = _MATRICES.get(int(picture.colorspace))
    return named or ("bt709" if min(picture.height, picture.width) >= 720 else "bt601")


def _square(picture: Any, size: tuple[int, int]) -> Any:
    """Return a decoded picture in 8-bit planes, with square pixels."""
    if picture.format.name in _PLANAR and (picture.width, picture.height) == size:
        return picture
    return picture.reformat(*size, format="yuv420p")


def _planes(picture: Any, rotation: int, is_mirrored: bool) -> tuple[np.ndarray, ...]:
    """Return luma and chroma planes, turned as displayed."""
    planes = []
    for plane in picture.planes:
        rows = np.frombuffer(plane, np.uint8).reshape(plane.height, plane.line_size)
        rows = rows[:, : plane.width]
        planes.append(np.rot90(rows[:, ::-1] if is_mirrored else rows, -rotation // 90))
    return tuple(planes)
