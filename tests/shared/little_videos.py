"""Little videos for tests, with time stamps of choice."""

import struct
from fractions import Fraction

import numpy as np


def encoded(path, pictures, stamps=None, codec="libx264", rate=30):
    """Write grey pictures (row, column) as a video with given time stamps [1/90000 s]."""
    import av

    with av.open(str(path), "w") as file:
        stream = file.add_stream(codec, rate=rate)
        stream.codec_context.time_base = Fraction(1, 90_000)
        stream.height, stream.width = pictures[0].shape
        stream.pix_fmt = "yuv420p"
        for k, picture in enumerate(pictures):
            frame = av.VideoFrame.from_ndarray(
                np.repeat(picture[..., None], 3, axis=2).astype(np.uint8), format="rgb24"
            )
            frame.pts = 3000 * k if stamps is None else stamps[k]
            frame.time_base = Fraction(1, 90_000)
            file.mux(stream.encode(frame))
        file.mux(stream.encode())
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
        # ISO/IEC 14496-12: version and flags, number of edits, then each one's duration [ms here].
        whole = bytearray(path.read_bytes())
        place = whole.index(b"elst") + 8
        assert struct.unpack_from(">I", whole, place) == (1,)
        struct.pack_into(">I", whole, place + 4, round(1000 * (end - begin)))
        path.write_bytes(whole)
    return path
