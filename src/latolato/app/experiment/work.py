"""The work on an uploaded video or table, in a separate process (see `jobs`)."""

from __future__ import annotations

import json
import math
import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app.blocks import pack
from latolato.app.experiment.code import command_lines, python_lines
from latolato.app.experiment.description import (
    EXPORTS,
    Description,
    apparatus_of,
    described,
    is_table,
    part_of,
)
from latolato.app.experiment.finding import answer_of, finding_of, questions_of
from latolato.app.experiment.fits import fit_of, fits_of, longest_step, trial_row
from latolato.app.experiment.store import COPY
from latolato.app.experiment.tables import import_of, look_at_table, track_table_of
from latolato.app.worker import Result
from latolato.core.errors import InputError, Sentence, reading
from latolato.experiment.calibration.lens import Optics
from latolato.experiment.encode import TICKS, write_video
from latolato.experiment.fits.samples import within
from latolato.experiment.importing import is_track_file
from latolato.experiment.quality import circle_distances, flag_shares, typical_sigma
from latolato.experiment.rules import said
from latolato.experiment.sidecar import write_sidecar
from latolato.experiment.task import check_count, prepare
from latolato.experiment.track import run
from latolato.experiment.track_table import FLAGS, balls_of, read_table, write_table
from latolato.experiment.video import Frame, Video, open_video

if TYPE_CHECKING:
    import xarray as xr

Job = Mapping[str, Any]
Tell = Callable[[str, float], None]
# Longer side of the copy that the page plays [pixels], its quality, and frames between key frames.
_LONGER, _CRF, _KEY_EVERY = 1280, 20, 12
# The table that later jobs read, and the times of all frames as the file has them.
TABLE, TIMES = "track.csv", "times.npy"
# What a page knows about a track table.
_SHOWN = ("geometry", "radius_pixels", "arm_pixels", "metres_per_pixel", "measured_radius",
          "gravity_source", "exposure", "circle_residual", "period", "period_sigma",
          "length")  # fmt: skip
# What a description tells tracking beside places, frames and the camera.
_DECLARED = ("length", "radius", "gravity", "slow_motion", "stick", "stick_length", "region",
             "shape", "patch", "click_frame", "corrections")  # fmt: skip
_OPTICS = ("row_time", "lens_k1", "lens_k2")
# Frames of an example, small enough to be painted in seconds.
_EXAMPLE_SIZE = {"width": 480, "height": 360}
_SEED = 1


def look(job: Job, tell: Tell) -> Result:
    """Return size and length of a video and where pivot and balls seem to be, or what a table is.

    A copy of a video that browsers play, with the same frames at the same times, is written beside
    it; the array is these times from the first frame on [s].
    """
    if is_table(job["name"]):
        tell("reading", 0.0)
        return look_at_table(job), {}
    # The copy plays as the file does.
    video = open_video(job["path"], slow_motion=1.0)
    times, damage = write_copy(
        video, Path(job["folder"]) / COPY, lambda share: tell("reading", share)
    )
    with reading(job["path"]):
        check_count(len(times))
    np.save(Path(job["folder"]) / TIMES, times)
    arrays = {"time": np.array(times) - times[0]}
    result: dict[str, Any] = {
        "width": video.width, "height": video.height, "frames": len(times),
        "duration": times[-1] - times[0], "proposal": None, "clock": video.clock._asdict(),
        "damage": damage,
    }  # fmt: skip
    whole = {"end": times[-1] / open_video(job["path"]).slow_motion} if damage else {}
    try:
        task = prepare(Path(job["path"]), None, None, whole, None,
                       lambda share: tell("finding", min(3.0 * share, 0.95)))  # fmt: skip
    except InputError:  # nothing was found: the page asks for it
        return result, arrays
    result["proposal"] = {
        "pivot": task.setup.pivot, "balls": task.setup.balls, "radius": task.radius,
        "click_frame": task.setup.click_frame,
    }  # fmt: skip
    return result, arrays


def write_copy(
    video: Video, path: Path, progress: Callable[[float], None]
) -> tuple[list[float], Sentence | None]:
    """Write a video that browsers play; return the times of its frames [s].

    H.264 in MP4 as displayed, at most 1280 pixels on the longer side, each frame at its time after
    the first. It ends before a frame that is damaged, which is then said.
    """
    import cv2

    scale = min(1.0, _LONGER / max(video.width, video.height))
    width, height = (max(2, round(side * scale / 2.0) * 2) for side in (video.width, video.height))
    times: list[float] = []
    damage: list[Sentence] = []
    expected = video.frame_count or 1

    def planes(frame: Frame) -> Any:
        sizes = ((width, height), (width // 2, height // 2), (width // 2, height // 2))
        parts = [
            cv2.resize(np.ascontiguousarray(plane), size, interpolation=cv2.INTER_AREA)
            for plane, size in zip(frame[2:], sizes, strict=True)
        ]
        if video.is_full_range:
            parts[0] = np.uint8(np.rint(16.0 + parts[0] * (219.0 / 255.0)))
            for k in (1, 2):
                parts[k] = np.uint8(np.rint(128.0 + (parts[k] - 128.0) * (224.0 / 255.0)))
        return np.concatenate([part.ravel() for part in parts]).reshape(height * 3 // 2, width)

    def frames() -> Iterator[tuple[int, Any]]:
        stamp = -1
        for frame in _undamaged(video, damage):
            times.append(frame.time)
            stamp = max(round((frame.time - times[0]) * TICKS), stamp + 1)
            yield stamp, planes(frame)
            if frame.number % 32 == 0:
                progress(min(frame.number / expected, 1.0))

    rate = video.frame_rate if 1.0 <= video.frame_rate <= 1000.0 else 30.0
    write_video(path, frames(), fps=rate, crf=_CRF, rotation=0, key_every=_KEY_EVERY)
    return times, damage[0] if damage else None


def _undamaged(video: Video, damage: list[Sentence]) -> Iterator[Frame]:
    """Decode the frames of a video up to a damaged one, and append what is wrong with that."""
    try:
        yield from video.frames()
    except InputError as error:
        if not (isinstance(error.rule, Sentence) and error.rule.named.name == "damaged_video"):
            raise
        damage.append(said("part_before_damage", **error.rule.named.values))


def track(job: Job, tell: Tell) -> Result:
    """Track a video, write its table, and return what the table and the usual fits say."""
    tell("tracking", 0.0)
    description = described(job["description"])
    if not description.get("balls"):
        raise InputError("point at one ball or two")
    path = Path(job["path"])
    known: dict[str, Any] = {name: description[name] for name in _DECLARED if name in description}
    optics = {name: description[name] for name in _OPTICS if name in description}
    times = np.load(Path(job["folder"]) / TIMES)
    ends = {"start": description.get("first_frame"), "end": description.get("last_frame")}
    if any(number is not None for number in ends.values()):
        slower = description.get("slow_motion") or open_video(path).slow_motion
        for name, number in ends.items():
            if number is not None:
                known[name] = times[min(number, len(times) - 1)] / slower
    settings = {**known, "optics": Optics(**optics)}
    task = prepare(path, description.get("pivot"), description["balls"], settings)
    task.warnings.clear()
    found = {name: description.get(name, False) for name in ("is_proposed", "is_pivot_found")}
    task.setup = replace(task.setup, **found)
    table = run(task, lambda share: tell("tracking", share))
    table.attrs["source"] = job["name"]
    folder = Path(job["folder"])
    setup = write_sidecar(task.setup, job["path"], folder / "setup.toml")
    named = f"video = {json.dumps(job['name'], ensure_ascii=False)}"
    text = re.sub(r"^video = .*$", lambda _: named, setup.read_text("utf-8"), count=1, flags=re.M)
    setup.write_text(text, encoding="utf-8")
    points = points_block(table, task.video, times - times[0])
    size = (task.video.width, task.video.height)
    result, models = _results(table, description, folder, size, tell)
    return {**result, "warnings": task.warnings}, {"points": _bytes(points), **models}


def import_(job: Job, tell: Tell) -> Result:
    """Import a table, write its track table, and return what that and the usual fits say."""
    description = described(job["description"])
    tell("reading", 0.0)
    path, folder = Path(job["path"]), Path(job["folder"])
    choices = None if is_track_file(path) else import_of(path, description)
    table, notes, questions = track_table_of(job, choices)
    result, models = _results(table, description, folder, None, tell, questions)
    kinds = [name for name, card in result["fits"].items() if "values" in card]
    apparatus = apparatus_of(description, table)
    about = (job["name"], choices, kinds, apparatus, part_of(description))
    code = [python_lines(*about), command_lines(*about)]
    points = _bytes(pack(*_motion(table)))
    return {**result, "code": code, "warnings": notes}, {"points": points, **models}


def _bytes(block: bytes) -> Any:
    """Return a block as an array of another one."""
    return np.frombuffer(block, np.uint8)


def _results(
    table: xr.Dataset,
    description: Description,
    folder: Path,
    size: tuple[int, int] | None,
    tell: Tell,
    questions: Sequence[str] = (),
) -> Result:
    """Write a track table in place of an older one; return what it and the usual fits say.

    `questions` are those that its import leaves. What is said is about the part that fits use.

    Raises
    ------
    InputError
        If that part is none of the table.
    """
    said_of = table.isel(frame=within(table["time"].values, **part_of(description)))
    for old in EXPORTS:
        (folder / old).unlink(missing_ok=True)
    write_table(table, folder / TABLE)
    tell("fitting", 0.0)
    trial, why = trial_row(table, description)
    cards, models = fits_of(table, description, size)
    asked = [*questions, *questions_of(said_of, cards)]
    result = {
        "finding": finding_of(said_of, cards, trial, asked),
        "answer": answer_of(said_of, cards, trial, apparatus_of(description, table), asked),
        "fits": cards,
        "trial": trial,
        "no_trial": why,
    }
    return result, models


def _motion(table: xr.Dataset) -> tuple[dict[str, Any], dict[str, Any]]:
    """Header and arrays of a track table for a page: angles [rad], their flags, the pivot.

    ``after_gaps`` are the samples before which others are missing.
    """
    balls = range(1, balls_of(table) + 1)

    def rows(name: str) -> Any:
        return np.stack([table[f"{name}_{b}"].values for b in balls]).astype(np.float32)

    time = table["time"].values.astype(np.float64)
    flags = [[FLAGS.index(str(f)) for f in table[f"flag_{b}"].values] for b in balls]
    about = {
        "flags": FLAGS,
        "balls": len(balls),
        "first_frame": int(table["frame"][0]),
        "after_gaps": (np.flatnonzero(np.diff(time) > longest_step(time)) + 1).tolist(),
        "attributes": {name: table.attrs[name] for name in _SHOWN if name in table.attrs},
        "shares": flag_shares(table),
        "typical_sigma": typical_sigma(table),
    }
    return about, {
        "time": time,
        "angle": rows("angle"),
        "angle_sigma": rows("angle_sigma"),
        "flag": np.array(flags, np.uint8),
        "pivot_height": table["pivot_y"].values[None].astype(np.float32),
    }


def points_block(table: xr.Dataset, video: Video, times: np.ndarray) -> bytes:
    """Return a track table as the page draws it: angles, and places in pixels of the picture.

    Places are those of a camera at rest; where it moved, ``motion`` says where frames show them.

    `times` are those of all frames in the copy that the page plays [s].
    """
    from latolato.experiment.overlay import places_of
    from latolato.experiment.tracking.steady import Steadier

    balls = range(1, balls_of(table) + 1)
    pivots, centres = places_of(table, (video.width, video.height))
    motion = {}
    if isinstance(video.steadier, Steadier):
        moved = video.steadier.motions(table.sizes["frame"]).reshape(-1, 6)
        motion["motion"] = np.ascontiguousarray(moved.T, np.float32)
    about, arrays = _motion(table)
    return pack(
        {**about, "width": video.width, "height": video.height},
        {
            **arrays,
            "media_time": times[table["frame"].values].astype(np.float64),
            "pivot": pivots.T.astype(np.float32),
            "centre": centres.transpose(1, 2, 0).reshape(2 * len(balls), -1).astype(np.float32),
            **motion,
            "distance": np.stack([circle_distances(table, b) for b in balls]).astype(np.float32),
        },
    )


def fit(job: Job, tell: Tell) -> Result:
    """Return one fit of a table that was tracked before, with the motion of its model."""
    tell("fitting", 0.0)
    table = read_table(Path(job["folder"]) / TABLE)
    video = None if is_table(job["name"]) else open_video(job["path"])
    size = (video.width, video.height) if video else None
    return fit_of(job["kind"], table, described(job["description"]), size)


def export(job: Job, tell: Tell) -> Result:
    """Write the table as NetCDF, the video with the overlay, or the page on its quality."""
    if job["file"] not in EXPORTS:  # any other name might lead out of the folder
        raise InputError(
            "must be one of " + ", ".join(EXPORTS), parameter="file", value=job["file"]
        )
    folder = Path(job["folder"])
    table = read_table(folder / TABLE)
    if job["file"] == "track.nc":
        write_table(table, folder / job["file"])
        return {"file": job["file"]}, {}
    attrs = table.attrs
    video = open_video(
        job["path"], slow_motion=float(attrs.get("slow_motion", 1.0)),
        start=float(attrs.get("start", -math.inf)),
        end=float(attrs.get("end", math.inf)),
    )  # fmt: skip
    if job["file"] == "overlay.mp4":
        from latolato.experiment.overlay import write_overlay

        write_overlay(table, video, folder / job["file"], progress=lambda s: tell("drawing", s))
    else:
        from latolato.report.track_page import write_track_report

        tell("drawing", 0.3)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            write_track_report(table, video, folder / job["file"])
    return {"file": job["file"]}, {}


def example(job: Job, tell: Tell) -> Result:
    """Render a short video with known truth, and look at it."""
    tell("painting", 0.0)
    import latolato as ll
    from latolato.experiment.synthetic.scene import Camera, Scene
    from latolato.experiment.synthetic.synthesise import synthesise_video

    centre, mass, radius, rate = 0.363, 0.108, 0.02, 30.0
    if job["kind"] == "toy":
        centre, mass, rate = 0.245, 0.106, 120.0
        system: Any = ll.LatoLato(
            length=centre, mass=mass, damping=0.005, radius=radius, restitution=0.9
        )
        drive: Any = ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.1)
        begun = ll.simulate(system, drive, initial_angle=0.6, duration=4.0)
    else:
        # A solid ball swings as a point farther down does.
        length, weight = ll.equivalent_pendulum(centre, mass, radius=radius)
        system = ll.Pendulum(length=length, mass=weight, damping=0.00274)
        drive = ll.FixedPivot()
        if job["kind"] == "driven":
            rate = 60.0
            drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.09)
            begun = ll.simulate(system, drive, initial_angle=math.radians(10.0), duration=9.0)
        else:
            begun = ll.simulate(system, drive, initial_angle=0.6, duration=9.0)
    path = Path(job["folder"]) / "example.mp4"
    table = synthesise_video(
        begun,
        path,
        Scene(ball_radius=radius, centre_length=centre, background="gradient", shadow_darkness=0.2),
        Camera(fps=rate, **_EXAMPLE_SIZE),
        seed=_SEED,
        progress=lambda share: tell("painting", share),
    )
    path.replace(job["path"])
    names = ("damping", "restitution", "gravity", "drive_amplitude", "drive_frequency")
    truth = {name: float(table.attrs[name]) for name in names if name in table.attrs}
    truth |= {"length": system.length, "centre_length": centre, "radius": radius, "mass": mass}
    truth["decay_rate"] = 0.5 * system.damping / (system.mass * system.length)
    seen, arrays = look(job, tell)
    return {**seen, "truth": truth}, arrays


WORK: dict[str, Callable[[Job, Tell], Result]] = {
    "look": look,
    "track": track,
    "import": import_,
    "fit": fit,
    "export": export,
    "example": example,
}
