"""Videos that are made of others."""

from __future__ import annotations

import av
import numpy as np

from latolato.experiment.encode import TICKS, write_video


def rewritten(path, output, change, late=lambda k: 0.0):
    """Write a video whose pictures are changed by a function of all of them and their number.

    `change` receives pairs of a stamp and a picture (row, column, 3); `late` says by how much the
    stamp of a number is late [s].
    """
    with av.open(str(path)) as file:
        frames = [
            (round(f.time * TICKS), f.to_ndarray(format="rgb24")) for f in file.decode(video=0)
        ]
    planes = (
        (
            stamp + round(late(k) * TICKS),
            av.VideoFrame.from_ndarray(
                np.ascontiguousarray(change(frames, k)), format="rgb24"
            ).to_ndarray(format="yuv420p"),
        )
        for k, (stamp, _) in enumerate(frames)
    )
    write_video(output, planes, fps=60.0, crf=20, rotation=0)
    return output
