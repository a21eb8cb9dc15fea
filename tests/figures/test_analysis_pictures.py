"""The pictures of periods, sections, basins and pushes: each draws what its analysis returns."""

import importlib

import numpy as np
import pytest

import latolato as ll
from latolato.analysis.registry import analyses
from latolato.figures.map import WAYS

TOY = ll.LatoLato(length=0.245, mass=0.10644, radius=0.0196, restitution=0.9, damping=0.00506)
DRIVE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.0)
SMALL = {
    "response_period": {"initial_offset": 0.2},
    "response_period_map": {
        "drive_amplitude": [0.02, 0.03],
        "frequency_ratio": [2.4, 3.0],
        "initial_offset": 0.2,
    },
    "poincare_section": {"initial_offset": 0.2, "periods": 5},
    "impact_map": {"initial_offset": 0.2, "periods": 5},
    "bifurcation_diagram": {
        "parameter": "frequency_ratio",
        "low": 2.4,
        "high": 3.2,
        "points": 5,
        "initial_offset": 0.0,
    },
    "basins": {"angle_points": 6, "velocity_points": 6},
    "first_push": {"frequency_ratio": [2.4, 3.2], "scan_points": 5, "refinements": 1},
}


@pytest.mark.parametrize("name", SMALL)
def test_the_picture_of_an_analysis_names_its_axes_and_fits_on_its_page(name):
    dataset = analyses[name](TOY, DRIVE, **SMALL[name])
    figure = importlib.import_module(f"latolato.figures.analyses.{name}").draw(dataset)
    width, height = figure.get_size_inches()
    for axes in figure.axes:
        assert (
            axes.get_xlabel()
            or axes.get_ylabel()
            or axes.get_shared_x_axes().joined(axes, figure.axes[-1])
        )
        box = axes.get_window_extent()
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= width * figure.dpi
        assert box.y1 <= height * figure.dpi


def test_the_first_push_with_many_phases_is_a_map():
    dataset = analyses["first_push"](
        TOY,
        DRIVE,
        frequency_ratio=[2.2, 2.4, 2.8, 3.0, 3.2],
        drive_phase=np.arange(6),
        scan_points=5,
        refinements=0,
    )
    figure = importlib.import_module("latolato.figures.analyses.first_push").draw(dataset)
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert any("phase" in text for text in labels)
    assert any("first push" in text for text in labels)


@pytest.mark.parametrize("name", ["response_period", "poincare_section"])
def test_rounding_errors_of_a_periodic_motion_do_not_fill_a_picture(name):
    dataset = analyses[name](TOY, DRIVE, initial_offset=0.7)
    angle = dataset["section_angle" if name == "response_period" else "angle"].values
    assert np.ptp(angle) < 1e-9
    figure = importlib.import_module(f"latolato.figures.analyses.{name}").draw(dataset)
    for axes in figure.axes:
        assert np.ptp(axes.get_ylim()) >= 1e-3


@pytest.fixture(scope="module")
def diagram():
    return analyses["bifurcation_diagram"](TOY, DRIVE, **SMALL["bifurcation_diagram"])


@pytest.fixture(scope="module")
def loop():
    """A toy that starts on the way up, at one amplitude."""
    return analyses["hysteresis"](
        TOY, DRIVE, frequency_ratio=[2.0, 2.4, 2.8, 3.2], duration=30.0, drive_amplitude=[0.03]
    )


def words_of(texts):
    return [text.get_text() for text in texts]


def test_the_statuses_of_an_analysis_are_drawn_in_its_own_words(diagram):
    figure = ll.plot(diagram, "status")
    words = words_of(figure.legends[0].get_texts())
    assert {"rest", "periodic"} <= set(words)
    drawn = figure.axes[0].collections[0].get_array().astype(int)
    np.testing.assert_array_equal(np.array(words)[drawn], diagram.status)
    curve = ll.plot(diagram.sel(direction="up"), "status").axes[0]
    ticks = np.array(words_of(curve.get_yticklabels()))
    drawn = curve.get_lines()[-1].get_ydata().astype(int)
    np.testing.assert_array_equal(ticks[drawn], diagram.status.sel(direction="up"))


def test_directions_are_drawn_as_words(diagram, loop):
    figure = ll.plot(diagram, "response_period")
    axes = figure.axes[0]
    assert dict(zip(axes.get_yticks(), words_of(axes.get_yticklabels()), strict=True)) == {
        0.0: "up",
        1.0: "down",
    }
    assert axes.get_ylim() == (-0.5, 1.5)
    assert not figure.legends  # no outline of a status between two directions
    lines = ll.plot(diagram, "response_period", curves=True).axes[0].get_lines()
    assert [line.get_label() for line in lines] == ["up", "down"]
    jumps = ll.plot(loop, "jump_ratio").axes[0]
    assert words_of(jumps.get_xticklabels()) == ["up", "down"]


def test_dimensions_of_one_value_need_no_selection(loop):
    figure = ll.plot(loop, "largest_angle")
    drawn = figure.axes[0].collections[0].get_array()
    np.testing.assert_array_equal(drawn, loop.largest_angle.isel(drive_amplitude=0))
    assert "$A_0$ = 30 mm" in figure.axes[0].get_title(loc="left")


def test_up_and_down_have_one_colour_in_all_pictures(diagram, loop):
    down = analyses["bifurcation_diagram"](
        TOY, DRIVE, **SMALL["bifurcation_diagram"], direction="down"
    )
    pictures = [ll.plot(each) for each in (diagram, loop, down)]
    pictures.append(ll.plot(loop, "largest_angle", curves=True))
    for figure in pictures:
        lines = [line for axes in figure.axes for line in axes.get_lines()]
        for line in lines:
            way = str(line.get_label()).split()[-1]
            assert line.get_color() == WAYS[way]
        assert lines
