"""Synthetic videos: what is painted lies where the truth says, and the file says when."""

import dataclasses
import math

import numpy as np
import pytest

import latolato as ll
from latolato.experiment.scene import Camera, Scene
from latolato.experiment.synthetic import prepare, synthesise_video
from latolato.experiment.table import read_table

# A ball alone, drawn flat, so that its centroid is its centre.
ALONE = Scene(
    ambient=1.0, gloss=0.0, rod_width=0.0, block_width=0.0, block_height=0.0, bolt_radius=0.0,
    rail_width=0.0,
)  # fmt: skip
SMALL = Camera(width=320, height=240, vignetting=0.0)
SWING = ll.Pendulum(length=0.363, mass=0.1, damping=0.003)
DRIVE = ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.0)
# An edge is a ramp of one pixel whatever its direction, which moves a ball of 10 pixels by 0.011.
NEAR = 0.02  # pixel


@pytest.fixture(scope="module")
def run():
    return ll.simulate(SWING, DRIVE, initial_angle=0.6, duration=0.8)


@pytest.fixture(scope="module")
def pair():
    toy = ll.LatoLato(length=0.245, mass=0.1, damping=0.005, radius=0.02, restitution=0.9)
    return ll.simulate(toy, initial_angle=0.5, duration=0.8)


def centroid(take, number, columns=slice(None)):
    """Return u and v of what differs from the wall."""
    light = np.abs(take.picture(number) - take.studio.empty()).sum(axis=2)
    v, u = np.mgrid[0 : light.shape[0], 0 : light.shape[1]]
    mask = np.zeros_like(light)
    mask[:, columns] = light[:, columns]
    return (mask * u).sum() / mask.sum(), (mask * v).sum() / mask.sum()


def true_pixel(take, number, ball=1):
    """Return u and v of a ball's centre by the truth."""
    truth = take.truth()
    x, y = (float(truth[f"ball_{ball}_{axis}"][number]) for axis in "xy")
    u, v = take.studio.view.shown(x, y)
    return float(u), float(v)


@pytest.mark.parametrize("roll", [0.0, 0.2, math.pi])
def test_the_ball_is_painted_where_the_truth_says(run, roll):
    take = prepare(run, ALONE, dataclasses.replace(SMALL, roll=roll, exposure=0.02))
    for number in (0, 17, 30):
        assert centroid(take, number) == pytest.approx(true_pixel(take, number), abs=NEAR)


def test_truth_is_the_projection_of_the_run(run):
    camera = dataclasses.replace(SMALL, pixels_per_metre=500.0, pivot_u=160.0, pivot_v=40.0)
    take = prepare(run, ALONE, camera)
    truth = take.truth()
    again = ll.simulate(SWING, DRIVE, initial_angle=0.6, times=take.begin + take.times)
    # The truth is interpolated from samples 0.1 ms apart.
    np.testing.assert_allclose(truth.angle_1, again.angle, atol=2e-7)
    height = again.pivot_height - again.pivot_height.mean()
    np.testing.assert_allclose(truth.pivot_y, height, atol=1e-8)
    angle = np.arctan2(truth.ball_1_x - truth.pivot_x, truth.pivot_y - truth.ball_1_y)
    np.testing.assert_allclose(truth.angle_1, angle, atol=1e-12)
    first = truth.isel(frame=0)
    assert truth.attrs["pivot_pixel_v"] == pytest.approx(40.0 - 500.0 * float(first.pivot_y))
    assert truth.attrs["ball_1_pixel_u"] == pytest.approx(160.0 + 500.0 * float(first.ball_1_x))


def test_a_smear_is_centred_on_the_middle_of_the_exposure(run):
    camera = dataclasses.replace(SMALL, fps=30.0, exposure=0.9)
    take = prepare(run, ALONE, camera)
    for number in (5, 11):
        moments = take.states(number)
        length = math.dist(moments[0, 0, 2:4], moments[-1, 0, 2:4])
        assert length > 5.0  # pixel, or the test would say little
        # A smear is bent: its mean lies off the middle by acceleration x exposure^2/24.
        bend = 20.0 * take.studio.view.scale * 0.03**2 / 24.0
        assert centroid(take, number) == pytest.approx(true_pixel(take, number), abs=bend)


def test_frames_are_stamped_exactly(run, tmp_path):
    av = pytest.importorskip("av", reason="needs the extra video")
    camera = dataclasses.replace(SMALL, fps=29.97, jitter=0.2, drop=0.2)
    truth = synthesise_video(run, tmp_path / "clip.mp4", camera=camera, seed=3)
    with av.open(str(tmp_path / "clip.mp4")) as file:
        times = [float(frame.pts * frame.time_base) for frame in file.decode(video=0)]
    assert times == truth.time.values.tolist()
    assert len(set(np.round(np.diff(times), 4))) > 5


def test_the_truth_is_written_as_a_track_table(run, tmp_path):
    path = tmp_path / "truth.csv"
    truth = synthesise_video(run, tmp_path / "clip.mp4", camera=SMALL, truth=path)
    again = read_table(path)
    np.testing.assert_array_equal(again.angle_1, truth.angle_1)
    assert again.attrs["ball_1_pixel_u"] == truth.attrs["ball_1_pixel_u"]
