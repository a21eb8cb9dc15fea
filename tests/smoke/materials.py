"""The files that the commands of the documentation work on, made when a command names them."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from unittest import mock

import numpy as np

import latolato as ll
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.track_table import track_table, write_table
from latolato.experiment.trial_table import write_trials
from latolato.paper import catalogue
from latolato.paper.report import reproduce
from second_paper import write_second_paper
from track_tables import decay_table, motion_table

BALL = ll.Pendulum(length=0.363, mass=0.10804, damping=0.00274)
TOY = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.02, restitution=0.9)
SHAKE = ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.09)
FAST_SHAKE = ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.1)
NOISE = 1e-3  # rad


def film(run, path, **camera):
    path.parent.mkdir(exist_ok=True)
    synthesise_video(run, path, Scene(ball_radius=0.02), Camera(**camera))


def swing_video(path):
    run = ll.simulate(BALL, initial_angle=0.6, duration=6.0)
    film(run, path, width=640, height=480, fps=30.0)


def toy_video(path):
    run = ll.simulate(TOY, FAST_SHAKE, initial_angle=0.9, duration=2.0)
    top = 2016.0 * FAST_SHAKE.drive_amplitude  # the drive begins there
    film(run, path, pivot_u=640.0, pivot_v=196.0 + top, pixels_per_metre=2016.0)


def tripod(path):
    run = ll.simulate(BALL, SHAKE, initial_angle=0.0, initial_angular_velocity=2.0, duration=6.0)
    film(run, path / "one.mp4", pivot_u=640.0, pivot_v=180.0, pixels_per_metre=1405.0)


def videos(path):
    for seed, angle in enumerate((0.5, 0.7)):
        run = ll.simulate(BALL, initial_angle=angle, duration=4.0)
        film(run, path / f"clip_{seed}.mp4", width=480, height=360, fps=30.0)


def decay(path):
    write_table(decay_table(length=0.363, mass=0.10804, damping=0.00274, size=NOISE), path)


def cut(path):
    """A swing whose clock misses 3.7 s from 10 s on."""
    times = np.arange(0.0, 30.0, 1.0 / 30.0)
    run = ll.simulate(BALL, initial_angle=0.4, times=np.where(times > 10.0, times + 3.7, times))
    noise = np.random.default_rng(3).normal(scale=NOISE, size=len(times))
    write_table(track_table({"time": times, "angle_1": run.angle.values + noise}), path)


def driven(path, drive=SHAKE, seed=0):
    path.parent.mkdir(exist_ok=True)
    table = motion_table(BALL, drive, duration=45.0, initial_angle=0.1, size=NOISE, seed=seed)
    table.attrs["length"] = BALL.length
    write_table(table, path)


def many_driven(path):
    for seed, frequency in enumerate((9.0, 10.09)):
        drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=frequency)
        driven(path / f"trial_{seed}.csv", drive, seed)


def pair(path):
    write_table(motion_table(TOY, FAST_SHAKE, fps=240.0, initial_angle=0.6, size=NOISE), path)


def toy_table(path):
    run = {"duration": 2.0, "initial_angle": 0.6, "size": NOISE}
    write_table(motion_table(TOY, FAST_SHAKE, **run), path)


def columns(path, header, *values, separator=","):
    rows = [separator.join(f"{x:.9g}" for x in row) for row in zip(*values, strict=True)]
    path.write_text("\n".join([separator.join(header), *rows]) + "\n", encoding="utf-8")


def swing():
    run = ll.simulate(BALL, initial_angle=0.5, times=np.arange(0.0, 15.0, 1 / 60))
    return run.time.values, run.angle.values


def tracker_export(path):
    time, angle = swing()
    columns(path, ("t", "theta"), time, np.degrees(angle), separator="\t")


def points_export(path):
    time, angle = swing()
    columns(path, ("t", "x", "y"), time, 36.3 * np.sin(angle), -36.3 * np.cos(angle))


def phone_export(path):
    time, angle = swing()
    columns(path, ("Time (s)", "Angle (°)"), time, np.degrees(angle))


def trials(path):
    folder = path.parent / "experiment"
    many_driven(folder)
    write_trials(ll.collect_trials(folder), path)


def pair_trials(path):
    path.write_text(
        "drive_amplitude,drive_frequency,largest_angle,largest_angle_after_transient,class\n"
        + "".join(
            f"0.02,{ratio * TOY.natural_frequency:.9g},{angle},{angle},{kind}\n"
            for ratio, angle, kind in (
                (1.6, 0.2, "none"), (2.0, 0.5, "none"), (2.3, 1.1, "weak"), (2.6, 0.8, "weak"),
                (3.0, 0.3, "none"),
            )
        ),
        encoding="utf-8",
    )  # fmt: skip


def small_map(path):
    axes = {
        "drive_amplitude": np.linspace(0.005, 0.04, 6),
        "frequency_ratio": np.linspace(1.6, 2.4, 7),
        "restitution": [0.8, 0.9],
    }
    names = ["mean_energy", "motion_class"]
    single = {"axes": axes, "observables": names, "duration": 20.0, "initial_offset": 0.1}
    if path.name != "maps.zarr":
        del axes["restitution"]
    if path.suffix == ".zarr":
        ll.sweep(TOY, store=path, **single)
        return
    del single["initial_offset"]
    ll.save(ll.sweep(BALL, initial_angle=0.17, **single), path)


def model_fit(path):
    table = motion_table(BALL, SHAKE, duration=15.0, initial_angle=0.1, size=NOISE)
    ll.fit_model(table, BALL).save(path)


def toy_scenario(path):
    page = Path(__file__).parents[2] / "docs/how-to/files-and-units.md"
    block = page.read_text(encoding="utf-8").split("```toml\n")[1].split("```")[0]
    path.write_text(block, encoding="utf-8")


def short_run(path):
    ll.save(ll.load_scenario("toy").simulate(duration=10.0), path)


def report(path):
    """A report of one figure."""
    only = {"fig01": catalogue.figures()["fig01"]}
    with (
        mock.patch.object(catalogue, "evidence", return_value=only),
        mock.patch.object(catalogue, "results", return_value={}),
    ):
        reproduce(path, quick=True)


MAKERS: dict[str, Callable[[Path], None]] = {
    "swing.mp4": swing_video,
    "toy.mp4": toy_video,
    "tripod": tripod,
    "videos": videos,
    "decay.csv": decay,
    "swing.csv": decay,
    "cut.csv": cut,
    "driven.csv": driven,
    "pair.csv": pair,
    "toy.csv": toy_table,
    "experiment": many_driven,
    "single": many_driven,
    "tracker.txt": tracker_export,
    "points.csv": points_export,
    "phone.csv": phone_export,
    "trials.csv": trials,
    "pair-trials.csv": pair_trials,
    "map.zarr": small_map,
    "maps.zarr": small_map,
    "map.nc": small_map,
    "other.nc": small_map,
    "model.nc": model_fit,
    "toy.toml": toy_scenario,
    "run.nc": short_run,
    "report": report,
    "other_paper": write_second_paper,
}


def provide(name: str, folder: Path, cache: Path) -> None:
    """Put what a command names into the folder in which it is run."""
    kept = cache / name
    if not kept.exists():
        MAKERS[name](kept)
    if kept.is_dir():
        shutil.copytree(kept, folder / name)
    else:
        shutil.copy(kept, folder / name)
