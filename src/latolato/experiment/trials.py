"""Trials of an experiment: from track tables and videos to the table of their classes."""

from __future__ import annotations

import math
import multiprocessing
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np

from latolato.core.atomic import checked_path
from latolato.core.errors import InputError, joined
from latolato.core.faults import line_of
from latolato.core.quantities import NON_NEGATIVE, POSITIVE
from latolato.core.registry import checked_choice, checked_count, checked_number
from latolato.experiment.fits.drive import fit_drive
from latolato.experiment.fits.result import size_questions
from latolato.experiment.fits.samples import filled, length_of, noise_of, within
from latolato.experiment.importing import is_track_file, read_measured
from latolato.experiment.rules import broken, said
from latolato.experiment.track_table import (
    MEASURED,
    SUFFIXES,
    balls_of,
    checked_table,
    read_table,
)
from latolato.experiment.trial_statistics import (
    class_of,
    is_borderline,
    largest_of,
    sets_of,
    turning_points,
)
from latolato.experiment.trial_table import (
    CLASSES,
    is_trial_table,
    trial_table,
)
from latolato.physics.pendulum import GRAVITY

if TYPE_CHECKING:
    import xarray as xr

    from latolato.experiment.fits.least_squares import Floats

VIDEOS = (".mp4", ".mov", ".m4v", ".avi", ".mkv", ".webm")
# Part of a record that is its last one where no transient is named.
_LAST = 1.0 / 3.0
# Halves of the last part whose largest angles differ by more than this have not settled.
_SETTLED = 0.05


def trial_of(
    table: xr.Dataset,
    *,
    length: float | None = None,
    gravity: float = GRAVITY,
    transient: float | None = None,
    start: float | None = None,
    end: float | None = None,
) -> dict[str, Any]:
    """Return the row of a trial table that a track table gives, in SI units.

    Parameters
    ----------
    table : xarray.Dataset
        A track table of one ball or two on a driven pivot.
    length : float, optional
        Pivot to ball centre [m], by default the table's; gives `frequency_ratio`.
    gravity : float
        Gravitational acceleration [m/s^2].
    transient : float, optional
        Time after `start` at which the last part begins [s]; by default two thirds of the record.
    start, end : float, optional
        Part of the table to use [s].

    Raises
    ------
    InputError
        For bad input, a pivot at rest, or unknown angles.
        If lmfit is missing.

    Notes
    -----
    As in `latolato.observables.MotionClass`, `largest_angle` is the largest abs(angle) of either
    ball at any time and `largest_angle_after_transient` the largest one of the last part, both at
    turning points between samples, by the parabola through the three samples about each. The
    largest of n noisy turning points is too large: with m the expected largest of n standard
    normal numbers, noise s and motion that varies by v itself, ``m (sqrt(v^2 + s^2) - v)`` is
    taken off. The standard deviation is that of the largest of n,
    ``sqrt(v^2 + s^2)/sqrt(1 + 0.8 ln n)``, and half of what was taken off; v counts only for the
    angle after the transient, which would differ in
    another record of the same motion. Angles that the tracker predicted do not count. If the
    frequency has steps, the drive is that of the last stage.
    """
    checked_table(table, "pivot_y", "angle_1")
    gravity = checked_number("gravity", gravity, POSITIVE, "m/s^2")
    length = length_of(table, length)
    if length is None:
        raise broken("unknown_length", parameter="length")
    inside = within(table["time"].values, start, end)
    table = table.isel(frame=np.flatnonzero(inside))
    time = table["time"].values
    first, last = float(time[0]), float(time[-1])
    late = first + (1.0 - _LAST) * (last - first)
    if transient is not None:
        late = first + checked_number("transient", transient, NON_NEGATIVE, "s")
        if late >= last:
            raise InputError(
                f"must be less than the record's {last - first:g} s",
                parameter="transient",
                value=float(transient),
            )
    drive = fit_drive(table, profile=False)
    if not drive.describes:
        raise broken("broken_trial", {"doubt": drive.doubt})
    frequency = drive["drive_frequency"]
    notes = []
    if "drive_frequency_final" in drive:
        frequency = drive["drive_frequency_final"]
        notes.append(said("note_step", time=drive["step_time"].value))
    notes += [
        said(f"note_{part}")
        for part in ("amplitude", "frequency")
        if size_questions({f"drive_{part}": drive[f"drive_{part}"].value})
    ]
    if "It is not steady" in drive.verdict:
        notes.append(said("note_unsteady"))
    _check_hanging(table)
    angles = [
        _largest(*_measured_samples(table, ball), late) for ball in range(1, balls_of(table) + 1)
    ]
    whole = max((each[0] for each in angles), key=lambda pair: pair[0])
    steady, swings, has_settled = max((each[1:] for each in angles), key=lambda each: each[0][0])
    if not has_settled:
        notes.append(said("note_settling"))
    return {
        "source": str(table.attrs.get("source", "")),
        "drive_amplitude": drive["drive_amplitude"].value,
        "drive_amplitude_sigma": drive["drive_amplitude"].sigma,
        "drive_frequency": frequency.value,
        "drive_frequency_sigma": frequency.sigma,
        "frequency_ratio": frequency.value * math.sqrt(length / gravity),
        "largest_angle": whole[0],
        "largest_angle_sigma": whole[1],
        "largest_angle_after_transient": steady[0],
        "largest_angle_after_transient_sigma": steady[1],
        "class": CLASSES[int(class_of(whole[0], steady[0]))],
        "borderline": bool(is_borderline(*whole, *steady)),
        "swings": swings,
        "balls": balls_of(table),
        "length": length,
        "note": joined(notes, "; "),
    }


def _check_hanging(table: xr.Dataset) -> None:
    """Raise InputError if a ball swings about an angle beyond a quarter of a turn."""
    for ball in range(1, balls_of(table) + 1):
        middle = float(np.nanmedian(table[f"angle_{ball}"].values))
        if abs(middle) > 0.5 * math.pi:
            raise broken("angles_elsewhere", {"ball": ball, "angle": math.degrees(middle)})


def collect_trials(
    sources: str | Path | xr.Dataset | Iterable[Any],
    *,
    length: float | None = None,
    radius: float | None = None,
    gravity: float = GRAVITY,
    transient: Annotated[float | None, "s"] = None,
    start: Annotated[float | None, "s"] = None,
    end: Annotated[float | None, "s"] = None,
    pivot: Sequence[float] | None = None,
    balls: int | Sequence[Sequence[float]] | None = None,
    sets: Literal["auto", "folder", "amplitude"] = "auto",
    workers: int = 1,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Return a trial table from track tables and videos; a bad file does not stop the others.

    Parameters
    ----------
    sources : path, track table, or several
        Folders (with their folders), track tables and videos. A video is tracked first; one whose
        table lies in the same folder is not tracked again.
    length : float, optional
        Pivot to ball centre [m], by default each table's.
    radius : float, optional
        Radius of a ball [m] in all videos.
    gravity : float
        Gravitational acceleration [m/s^2].
    transient : float, optional
        Time after the start at which the last part begins, whose largest angle is the settled one
        [s]; by default two thirds of the record.
    start : float, optional
        First instant used [s].
    end : float, optional
        Last instant used [s].
    pivot : sequence of float, optional
        Column and row of the pivot in the first frame of all videos [pixels].
    balls : int or sequence of sequence of float, optional
        How many balls swing, or column and row of each in the first frame of all videos [pixels].
        What is not pointed at is found in each video.
    sets : {"auto", "folder", "amplitude"}
        What defines a set: its folder, or amplitudes close to each other; by default folders if
        there are several.
    workers : int
        Number of processes.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    xarray.Dataset
        A trial table (`latolato.experiment.trial_table`) ordered by set and frequency. Its
        attribute ``failed`` lists each file that gave no trial and the reason, separated by ``|``.

    Raises
    ------
    InputError
        For bad input, if there is no file, or if no file gives a trial.

    Warns
    -----
    RuntimeWarning
        For each file that gave no trial.
    """
    checked_choice("sets", sets, ("auto", "folder", "amplitude"))
    workers = checked_count("workers", workers)
    gravity = checked_number("gravity", gravity, POSITIVE, "m/s^2")
    for parameter, value, allowed, unit in (
        ("length", length, POSITIVE, "m"),
        ("radius", radius, POSITIVE, "m"),
        ("transient", transient, NON_NEGATIVE, "s"),
    ):
        if value is not None:
            checked_number(parameter, value, allowed, unit)
    import xarray as xr

    alone = not isinstance(sources, Iterable) or isinstance(sources, (str, xr.Dataset))
    files = files_of([sources] if alone else list(sources))  # type: ignore[arg-type]
    of_trial = {"length": length, "gravity": gravity, "transient": transient, "start": start,
                "end": end}  # fmt: skip
    of_video = {"length": length, "radius": radius, "pivot": pivot, "balls": balls}
    rows: list[dict[str, Any]] = []
    folders: list[str] = []
    failed: list[str] = []
    for done, (file, row) in enumerate(_rows(files, of_trial, of_video, workers), start=1):
        if isinstance(row, str):
            # Most messages name the file themselves.
            name = file if isinstance(file, Path) else file.attrs.get("source", "a table")
            failed.append(row if str(file) in row else f"{name}: {row}")
            warnings.warn(failed[-1], RuntimeWarning, stacklevel=2)
        else:
            rows.append(row)
            folders.append("" if isinstance(file, xr.Dataset) else file.resolve().parent.name)
        if progress is not None:
            progress(done / len(files))
    if not rows:
        inside = f"{len(files)} file{'s' * (len(files) != 1)}"
        raise InputError(f"no trial was found in {inside}: {' | '.join(failed)}")
    by_folder = sets == "folder" or (sets == "auto" and len(set(folders)) > 1 and all(folders))
    amplitudes = [[row[f"drive_amplitude{end}"] for row in rows] for end in ("", "_sigma")]
    for row, name in zip(rows, folders if by_folder else sets_of(*amplitudes), strict=True):
        row |= {"set": name, "set_by": "folder" if by_folder else "amplitude"}
    rows.sort(key=lambda row: (row["set"], row["drive_frequency"]))
    columns = {name: [row[name] for row in rows] for name in rows[0]}
    return trial_table(columns, {"gravity": gravity, "failed": " | ".join(failed)})


def files_of(sources: Sequence[Any]) -> list[Any]:
    """Return track tables and videos in the given order; those of a folder are sorted by name.

    Raises
    ------
    FileNotFoundError, InputError
        If there is no such file, or a folder contains none.
    """
    import xarray as xr

    files: list[Any] = []
    for source in sources:
        if isinstance(source, xr.Dataset):
            files.append(source)
            continue
        path = checked_path("source", source)
        if path.is_dir():
            every = sorted(p for p in path.rglob("*") if p.suffix.lower() in (*SUFFIXES, *VIDEOS))
            # A track table beside a video of its name takes the video's place.
            known = {_stem(p) for p in every if p.suffix.lower() in SUFFIXES and _is_track(p)}
            inside = [
                p
                for p in every
                if not (_stem(p) in known if p.suffix.lower() in VIDEOS else is_trial_table(p))
            ]
            files += inside
            if not inside:
                raise InputError(f"'{path}' holds neither track tables nor videos")
        elif path.is_file():
            files.append(path)
        else:
            raise FileNotFoundError(f"there is no file '{path}'")
    if not files:
        raise InputError("name track tables, videos or folders of them")
    return files


def _stem(path: Path) -> tuple[Path, str]:
    """Return folder and name up to the first dot."""
    return path.parent, path.name.split(".")[0]


def _is_track(path: Path) -> bool:
    """Return whether a file says that it is a track table."""
    if path.suffix.lower() == ".csv":
        return is_track_file(path)
    try:
        read_table(path)
    except (InputError, OSError):
        return False
    return True


def _rows(
    files: Sequence[Any], of_trial: Mapping[str, Any], of_video: Mapping[str, Any], workers: int
) -> Iterable[tuple[Any, dict[str, Any] | str]]:
    """Yield each file with its row, or with the reason why there is none."""
    if workers == 1 or len(files) == 1:
        for file in files:
            yield file, _row(file, of_trial, of_video)
        return
    pool: Executor
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        waiting = [pool.submit(_row, file, of_trial, of_video) for file in files]
        for file, each in zip(files, waiting, strict=True):
            try:
                yield file, each.result()
            except BrokenExecutor as error:  # a process that ended
                yield file, str(error)


def _row(
    file: Any, of_trial: Mapping[str, Any], of_video: Mapping[str, Any]
) -> dict[str, Any] | str:
    """Return the row of one file, or the reason why there is none."""
    try:
        table = file
        if isinstance(file, Path):
            is_video = file.suffix.lower() in VIDEOS
            table = _tracked(file, of_video) if is_video else read_measured(file)
        row = trial_of(table, **of_trial)
    except Exception as error:
        return line_of(error).removeprefix(f"{file}: ")
    row["source"] = row["source"] or (file.name if isinstance(file, Path) else "")
    return row


def _tracked(video: Path, settings: Mapping[str, Any]) -> xr.Dataset:
    """Return the track table of a video; its warnings are its report's, not the batch's."""
    from latolato.experiment import track

    options = {name: value for name, value in settings.items() if value is not None}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return track.track(video, **options)


def _measured_samples(table: xr.Dataset, ball: int) -> tuple[Floats, Floats, Floats, Any]:
    """Return time, angle, standard deviation and flag of the samples of a ball that were seen."""
    time, angle = table["time"].values, table[f"angle_{ball}"].values
    flag = table[f"flag_{ball}"].values.astype(str)
    good = np.isfinite(angle) & np.isin(flag, MEASURED)
    if good.sum() < 8:
        raise broken("few_frames", {"ball": ball, "count": good.sum()})
    sigma = filled(table[f"angle_sigma_{ball}"].values[good], noise_of(angle[good]))
    return time[good], angle[good], sigma, flag[good]


def _largest(
    time: Floats, angle: Floats, sigma: Floats, flag: Any, late: float
) -> tuple[tuple[float, float], tuple[float, float], int, bool]:
    """Return largest and settled angle with their deviations, swings, and if it settled."""
    when, sizes, errors = turning_points(time, angle, sigma, flag)
    # What the record reached is a fact of the record: only the tracker's noise is in doubt.
    whole = largest_of(sizes, errors, np.abs(angle), sigma, varies=0.0)
    last, inside = when >= late, time >= late
    if inside.sum() < 4:
        raise broken("few_late_frames", {"count": inside.sum()})
    steady = largest_of(sizes[last], errors[last], np.abs(angle[inside]), sigma[inside])
    middle = 0.5 * (late + float(time[-1]))
    halves = [
        float(np.max(np.abs(angle[part]), initial=0.0))
        for part in (inside & (time < middle), time >= middle)
    ]
    gap = abs(halves[1] - halves[0])
    return whole, steady, int(last.sum()), gap <= _SETTLED * max(halves) + 3.0 * steady[1]
