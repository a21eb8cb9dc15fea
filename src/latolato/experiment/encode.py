"""Writes frames with exact time stamps as H.264 in MP4, with rotation metadata."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import import_extra

# Ticks per second of the container: 24, 25, 30, 50, 60, 120, 240 and 29.97 Hz are whole numbers.
TICKS = 90_000
# ITU-T H.273: primaries, tone curve and matrix of BT.709; and the range 16 to 235.
_BT709, _LIMITED = 1, 1


def import_av() -> Any:
    """Return PyAV."""
    return import_extra("av", "video", "writing videos")


def _alike() -> dict[str, str]:
    """Return the options with which x264 encodes the same pictures in one way only.

    With AVX-512 there are several (seen with PyAV 18.1), with AVX2 there is one.
    """
    import llvmlite.binding as llvm

    try:
        has_avx512 = llvm.get_host_cpu_features().get("avx512f", False)
    except RuntimeError:  # a processor that LLVM does not know
        has_avx512 = False
    return {"x264-params": "asm=avx2"} if has_avx512 else {}


def write_video(
    path: Path,
    frames: Iterable[tuple[int, NDArray[np.uint8]]],
    *,
    fps: float,
    crf: int,
    rotation: int,
    key_every: int | None = None,
) -> None:
    """Write (time stamp [tick], YUV 4:2:0 planes) as an MP4 of H.264.

    Parameters
    ----------
    path : Path
        The file.
    frames : iterable
        Stamps increase; planes have the shape (3 height/2, width) of the stored picture.
    fps : float
        The mean rate, which the encoder plans with.
    crf : int
        Quality of H.264, 0 to 51.
    rotation : int
        How far a player turns the pictures clockwise [deg]: 0, 90, 180 or 270.
    key_every : int, optional
        Frames from one that stands for itself to the next: few of them make seeking fast.

    Raises
    ------
    InputError
        If the extra `video` is missing.
    """
    av = import_av()
    options = {"movflags": "+faststart", "video_track_timescale": str(TICKS)}
    with av.open(str(path), "w", options=options) as file:
        stream: Any = None
        for stamp, planes in frames:
            if stream is None:
                rate = Fraction(fps).limit_denominator(1001)
                stream = file.add_stream("libx264", rate=rate)
                stream.height, stream.width = planes.shape[0] * 2 // 3, planes.shape[1]
                stream.pix_fmt = "yuv420p"
                # One thread and two encode alike only with a fixed number of them.
                stream.options = {"preset": "veryfast", "crf": str(crf), "threads": "2", **_alike()}
                context = stream.codec_context
                if key_every is not None:
                    context.gop_size = key_every
                context.time_base = Fraction(1, TICKS)
                context.color_primaries = context.color_trc = context.colorspace = _BT709
                context.color_range = _LIMITED
                if rotation:
                    stream.set_display_rotation(-rotation)  # it counts counter-clockwise
            frame = av.VideoFrame.from_ndarray(planes, format="yuv420p")
            frame.pts, frame.time_base = stamp, Fraction(1, TICKS)
            frame.colorspace, frame.color_range = _BT709, _LIMITED
            file.mux(stream.encode(frame))
        if stream is not None:
            file.mux(stream.encode())
