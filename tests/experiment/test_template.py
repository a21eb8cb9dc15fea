"""Bobs that are no discs, by a template: their true angles lie within the errors."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import bobs
import latolato as ll
from latolato.cli.main import main
from latolato.core.errors import InputError
from latolato.experiment.track_table import read_table
from latolato.experiment.tracking.appearance import Colours
from latolato.experiment.tracking.body import learn_body
from latolato.experiment.tracking.kernels.layers import colour_coefficients, linear_light
from latolato.experiment.tracking.positions import Positions
from latolato.experiment.tracking.teach import Sighting
from latolato.experiment.video import Frame

CLIPS = {
    "square": {},
    "ring": {"texture": 12.0, "label": True},
    "bottle": {"hand": True, "seconds": 1.6},
}


@pytest.fixture(scope="session")
def filmed(tmp_path_factory):
    """Return a function that films a bob once: the file and the true angles."""
    folder = tmp_path_factory.mktemp("bobs")

    @cache
    def get(name):
        path = folder / f"{name}.mp4"
        return path, bobs.write_clip(path, bobs.SHAPES[name], **{"seconds": 1.2, **CLIPS[name]})

    return get


@pytest.fixture(scope="session")
def tracked(filmed):
    """Return a function that tracks a bob once: the true angles and the table."""

    @cache
    def get(name):
        path, true = filmed(name)
        pivot, bob = bobs.places(true[0])
        return true, ll.track(
            path, pivot=pivot, balls=[bob], length=0.3, shape="template", patch=64
        )

    return get


@pytest.mark.parametrize("name", CLIPS)
def test_angles_of_a_bob_that_is_no_disc_lie_within_their_errors(tracked, name):
    true, table = tracked(name)
    ok = table.flag_1.values == "ok"
    assert ok.mean() > (0.85 if CLIPS[name].get("hand") else 0.98)
    error = table.angle_1.values[ok] - true[ok]
    assert np.sqrt(np.mean(error**2)) < 0.15 / bobs.ARM  # pixels
    assert np.mean(np.abs(error) < 2.0 * table.angle_sigma_1.values[ok]) > 0.9
    assert np.nanmedian(table.angle_sigma_1) < 0.4 / bobs.ARM
    half_width = {"square": 12.0, "ring": 15.0, "bottle": 9.0}[name]
    assert table.attrs["radius_pixels"] == pytest.approx(half_width, abs=1.0)
    assert table.attrs["shape"] == "template"
    assert "exposure" not in table.attrs


def test_a_hand_before_the_bob_is_no_part_of_it(tracked):
    true, table = tracked("bottle")
    flags = table.flag_1.values
    assert set(flags[40:60]) - {"ok"}
    measured = np.isin(flags, ["ok", "occluded"])
    error = np.abs(table.angle_1.values - true)[measured]
    assert (error < 3.0 * table.angle_sigma_1.values[measured]).all()


def test_the_same_table_is_made_again_without_clicks(filmed, tmp_path, capsys):
    path, true = filmed("square")
    output = tmp_path / "square.csv"
    pivot, bob = bobs.places(true[0])
    clicks = ["--pivot", "{},{}".format(*pivot), "--ball", "{},{}".format(*bob)]
    look = ["--shape", "template", "--radius", "28 mm", "--length", "30 cm"]
    assert main(["track", str(path), *clicks, *look, "--output", str(output)]) == 0
    first = output.read_text()
    assert main(["track", str(path), "--output", str(output)]) == 0
    assert "set-up read from" in capsys.readouterr().out
    assert output.read_text() == first
    table = read_table(output)
    error = (table.angle_1.values - true)[table.flag_1.values == "ok"]
    assert np.sqrt(np.mean(error**2)) < 0.15 / bobs.ARM


@pytest.mark.parametrize(
    "click, settings, match",
    [
        ((60.0, 60.0), {}, "it rests; point at the ball that swings"),
        # The rod alone: what is beside it is the wall.
        (
            None,
            {"patch": 10},
            "found in|followed|nothing like|moves|looks like|so it does not swing",
        ),
        (None, {"patch": 4}, r"patch must lie in \[8, 1000\]"),
        (None, {"shape": "ball"}, "shape must be"),
    ],
)
def test_what_is_no_bob_is_refused(filmed, click, settings, match):
    path, true = filmed("square")
    pivot, bob = bobs.places(true[0])
    if settings.get("patch") == 10:
        click = tuple(np.array(pivot) + 0.4 * (np.array(bob) - pivot))
    arguments = {"shape": "template", **settings}
    with pytest.raises(InputError, match=match):
        ll.track(path, pivot=pivot, balls=[click or bob], length=0.3, **arguments)


def learned(contrast):
    """Return what is learned from a square of 11 pixels, so much brighter than the wall."""
    colours = Colours(linear_light("srgb"), colour_coefficients("bt709", True))
    wall = np.random.default_rng(1).integers(90, 110, (80, 80)).astype(np.uint8)
    chroma = np.full((40, 40), 128, np.uint8)
    luma = wall.copy()
    luma[35:46, 35:46] += np.uint8(contrast)
    look = SimpleNamespace(
        paint=np.zeros((1, 57, 57, 3), np.float32),
        colours=colours,
        body=None,
        whitened=lambda: None,
    )
    bob, pivot = np.array([40.0, 40.0]), np.array([40.0, 5.0])
    click = Sighting(0, bob, pivot, 0.0, 0.0, 1.0, np.zeros(2))
    learn_body(look, [Frame(0, 0.0, luma, chroma, chroma)], [click], (wall, chroma, chroma))
    return look


def test_a_patch_that_looks_like_the_wall_behind_it_is_refused():
    assert learned(40).radius == pytest.approx(5.5, abs=1.0)  # half of the square
    with pytest.raises(InputError, match="the patch around the middle of the bob looks like its"):
        learned(0)


def test_a_body_covers_what_it_is_turned_to():
    track = Positions.unknown(np.zeros(1), 1, radius=5.0)
    assert track.reach == 5.0
    assert track.covers(np.array([[4.0, 0.0], [0.0, 4.8]]), 0.0, 0.5).tolist() == [True, False]
    track.body = np.zeros((41, 41), bool)
    track.body[2:39, 16:25] = True  # a bar of 9 x 37 pixels that hangs down
    assert track.reach == pytest.approx(np.hypot(18.0, 4.0))
    down, aside = np.array([0.0, 16.0]), np.array([16.0, 0.0])
    assert track.covers(np.array([down, aside]), 0.0, 0.0).tolist() == [True, False]
    assert track.covers(np.array([down, aside]), np.pi / 2, 0.0).tolist() == [False, True]
