"""Little videos for tests, with time stamps as asked for."""

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
