"""The scale of a picture: by the length, by a stick of known length, by the radius of a ball."""

import json

import numpy as np
import pytest

import latolato as ll
from latolato.cli.main import main
from latolato.core.errors import InputError
from latolato.experiment.calibration.lens import Optics, distorted
from latolato.experiment.calibration.scale import scale_of
from latolato.experiment.sidecar import Setup
from latolato.experiment.track_table import read_table

# A stick of 200 pixels beside the swing.
STICK = ((20.0, 30.0), (20.0, 230.0))


def _assert_metric(table, clip):
    """Check that sizes are true within their deviations, and places up to the scale."""
    attrs, truth = table.attrs, clip.truth.attrs
    assert attrs["geometry"] == "metric"
    assert abs(attrs["length"] - clip.length) < 2.5 * attrs["length_sigma"]
    error = abs(attrs["metres_per_pixel"] - truth["metres_per_pixel"])
    assert error < 2.5 * attrs["metres_per_pixel_sigma"]
    share = attrs["metres_per_pixel"] / truth["metres_per_pixel"]
    swing = (table.ball_1_x - table.ball_1_x.mean()).values
    true = (clip.truth.ball_1_x - clip.truth.ball_1_x.mean()).values
    np.testing.assert_allclose(swing, share * true, atol=1e-3)


def test_a_stick_of_known_length_is_the_scale(swing, tmp_path, capsys):
    output = tmp_path / "stick.csv"
    known = swing.options[: swing.options.index("--length")]
    metres = 200.0 * swing.truth.attrs["metres_per_pixel"]
    stick = ["--stick", "20.4,29.6,19.7,230.5", "--stick-length", f"{1e3 * metres} mm"]
    assert main(["track", str(swing.path), *known, *stick, "--output", str(output)]) == 0
    assert "by the scale of the stick" in capsys.readouterr().out
    table = read_table(output)
    _assert_metric(table, swing)
    assert table.attrs["scale_source"] == "stick"
    expected = np.sqrt(2.0) / 200.9
    assert table.attrs["metres_per_pixel_sigma"] / table.attrs["metres_per_pixel"] == (
        pytest.approx(expected, rel=1e-3)
    )
    first = output.read_text()
    assert main(["track", str(swing.path), "--output", str(output), "--json"]) == 0
    assert output.read_text() == first
    summary = json.loads(capsys.readouterr().out)
    assert summary["length_sigma"] == pytest.approx(table.attrs["length_sigma"])


def test_the_radius_alone_is_the_scale(swing):
    table = ll.track(swing.path, pivot=swing.pivot, balls=swing.balls, radius=0.02)
    _assert_metric(table, swing)
    assert table.attrs["scale_source"] == "radius"
    assert table.attrs["measured_radius"] == pytest.approx(0.02)


def test_the_length_is_the_scale_before_the_stick_which_is_checked(swing):
    with pytest.warns(RuntimeWarning, match="the stick is 49.* mm by the scale of the length"):
        table = ll.track(
            swing.path,
            pivot=swing.pivot,
            balls=swing.balls,
            length=swing.length,
            stick=STICK,
            stick_length=0.6,
        )
    assert table.attrs["length"] == swing.length
    assert table.attrs["scale_source"] == "length"
    assert "length_sigma" not in table.attrs


def test_a_stick_is_measured_without_the_lens():
    size, optics = (640, 480), Optics(lens_k1=-0.1)
    ends = np.array([[40.0, 60.0], [600.0, 60.0]])
    seen = tuple(map(tuple, distorted(ends, size, optics)))
    setup = Setup(pivot=None, balls=(), stick=seen, stick_length=1.0, optics=optics)
    assert scale_of(setup, size, (100.0, 0.0)).metres == pytest.approx(1.0 / 560.0, rel=1e-6)


@pytest.mark.parametrize(
    "settings, match",
    [
        ({"stick": STICK}, "stick_length is missing"),
        ({"stick_length": 1.0}, "stick is missing"),
        ({"stick": STICK, "stick_length": 0.0}, r"stick_length must lie in \(0, inf\) m"),
        (
            {"stick": ((1, 2), (4, 6)), "stick_length": 1.0},
            "at least 8 pixels apart in the picture, but are 5; point at both ends again",
        ),
        ({"stick": np.array([[1, 2], [3, 4]]), "stick_length": 1.0}, "at least 8 pixels apart"),
        ({"stick": (1, 2, 3, 4), "stick_length": 1.0}, "stick must be two places in pixels"),
        ({"stick": ((1, 2), (400, 4)), "stick_length": 1.0}, "end of the stick at .* outside"),
    ],
)
def test_a_stick_that_is_none_is_refused(swing, settings, match):
    with pytest.raises(InputError, match=match):
        ll.track(swing.path, pivot=swing.pivot, balls=swing.balls, **settings)
