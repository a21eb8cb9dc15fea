"""Little videos for tests, with time stamps of choice."""

import os
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction

import numpy as np


def encoded(path, pictures, stamps=None, codec="libx264", rate=30, layout="yuv420p", **options):
    """Write pictures (row, column[, colour]) as a video with given time stamps [1/90000 s].

    `options` are attributes of the encoder's context, its own options, and `metadata` of the file.
    """
    import av

    with (
        _ordinary_priority(),
        av.open(str(path), "w", options={"movflags": "use_metadata_tags"}) as file,
    ):
        file.metadata.update(options.pop("metadata", {}))
        stream = file.add_stream(codec, rate=rate)
        context = stream.codec_context
        # An AVI has a frame for every tick.
        context.time_base = Fraction(1, rate if path.suffix == ".avi" else 90_000)
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = layout
        for name in [name for name in options if hasattr(context, name)]:
            setattr(context, name, options.pop(name))
        stream.options = options
        for k, picture in enumerate(pictures):
            colours = picture if picture.ndim == 3 else np.repeat(picture[..., None], 3, axis=2)
            frame = av.VideoFrame.from_ndarray(colours.astype(np.uint8), format="rgb24")
            frame = frame.reformat(format=layout)
            frame.pts = 3000 * k if stamps is None else stamps[k]
            frame.time_base = Fraction(1, 90_000)
            file.mux(stream.encode(frame))
        file.mux(stream.encode())
    return path


@contextmanager
def _ordinary_priority() -> Iterator[None]:
    """Give this process its priority back: run by root, SVT-AV1 takes the highest there is.

    Nothing else gets the processor then, neither other tests nor the browser of this one.
    """
    if not hasattr(os, "sched_getscheduler"):
        yield
        return
    policy, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        yield
    finally:
        os.sched_setscheduler(0, policy, parameters)


def pictures_of(path):
    """Return all pictures of a video, shape (row, column, colour)."""
    import av

    with av.open(str(path)) as file:
        return [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]


def slowed(source, path, factor, capture_rate=None):
    """Copy all packets of a video with times that are longer by a factor."""
    import av

    options = {"movflags": "use_metadata_tags"}
    with av.open(str(source)) as old, av.open(str(path), "w", options=options) as new:
        if capture_rate is not None:
            new.metadata["com.android.capture.fps"] = f"{capture_rate:f}"
        stream = old.streams.video[0]
        copy = new.add_stream_from_template(stream)
        for packet in old.demux(stream):
            if packet.dts is not None:
                packet.pts, packet.dts = packet.pts * factor, packet.dts * factor
                packet.duration *= factor
                packet.stream = copy
                new.mux(packet)
    return path


def turned(source, path, matrix):
    """Copy an MP4 so that it is shown by (x, y) -> (a x + c y, b x + d y); `matrix` is a b c d."""
    whole = bytearray(source.read_bytes())
    # ISO/IEC 14496-12: the matrix stands 36 bytes after version and flags of a track header.
    place = whole.index(b"tkhd") + 8 + 36
    a, b, c, d = (number << 16 for number in matrix)
    struct.pack_into(">9i", whole, place, a, b, 0, c, d, 0, 0, 0, 1 << 30)
    path.write_bytes(whole)
    return path


def sound_alone(path):
    """Write a file that holds a sound track and no picture."""
    import av

    with av.open(str(path), "w") as file:
        stream = file.add_stream("aac", rate=8000)
        for k in range(8):
            frame = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), "fltp", "mono")
            frame.sample_rate, frame.pts = 8000, 1024 * k
            file.mux(stream.encode(frame))
        file.mux(stream.encode())
    return path


def trimmed(source, path, begin, end=None):
    """Copy all packets of an MP4, with an edit list that shows those from `begin` to `end` [s]."""
    import av

    options = {"movflags": "+faststart"}
    with av.open(str(source)) as old, av.open(str(path), "w", options=options) as new:
        stream = old.streams.video[0]
        copy = new.add_stream_from_template(stream)
        for packet in old.demux(stream):
            if packet.dts is not None:
                packet.pts -= round(begin / stream.time_base)
                packet.dts -= round(begin / stream.time_base)
                packet.stream = copy
                new.mux(packet)
    if end is not None:
        # ISO/IEC 14496-12: version and flags, number of edits, then each one's duration, in ticks
        # of the movie, whose header has version and flags, two dates, and the ticks in a second.
        whole = bytearray(path.read_bytes())
        version, _, _, ticks = struct.unpack_from(">4I", whole, whole.index(b"mvhd") + 4)
        place = whole.index(b"elst") + 8
        assert (version, *struct.unpack_from(">I", whole, place)) == (0, 1)
        struct.pack_into(">I", whole, place + 4, round(ticks * (end - begin)))
        path.write_bytes(whole)
    return path
