"""The boundary of a map: its contour, the edges of the main region and how wide they are."""

import numpy as np
import pytest
import xarray as xr

import latolato as ll
from hanging import tongue_edges

RATIOS = np.linspace(1.0, 3.0, 401)  # spacing 0.005
AMPLITUDES = np.array([0.1, 0.2, 0.3])


def trapezium(foot_left, top_left, top_right, foot_right, height=1.0):
    """A profile that rises, stays and falls on straight lines."""
    return np.interp(RATIOS, [foot_left, top_left, top_right, foot_right], [0, height, height, 0])


def grid(rows, **dims):
    axes = dims or {"drive_amplitude": AMPLITUDES, "frequency_ratio": RATIOS}
    return xr.Dataset({"mean_energy": (tuple(axes), np.array(rows))}, axes)


def test_edges_and_widths_of_straight_flanks_are_exact():
    result = ll.map_boundary(grid([trapezium(1.88, 1.9, 2.4, 2.46)] * 3), "mean_energy", 0.5)
    # straight lines are interpolated without error
    np.testing.assert_allclose(result.left_edge, 1.89, rtol=1e-12)
    np.testing.assert_allclose(result.right_edge, 2.43, rtol=1e-12)
    np.testing.assert_allclose(result.left_width, 0.016, rtol=1e-9)
    np.testing.assert_allclose(result.right_width, 0.048, rtol=1e-9)
    np.testing.assert_allclose(result.left_plateau, 1.0)


def test_a_sloping_plateau_does_not_blur_a_sharp_edge():
    # the energy of unstable motion rises with the frequency by a factor of three
    row = trapezium(1.88, 1.9, 2.7, 2.72) * (1.0 + 2.0 * (RATIOS - 1.9) / 0.8)
    result = ll.map_boundary(grid([row] * 3), "mean_energy", 0.3)
    assert (result.left_width < 0.03).all()
    assert (result.right_width < 0.03).all()


def test_a_soft_edge_is_wider_than_a_sharp_one():
    result = ll.map_boundary(grid([trapezium(1.88, 1.9, 2.2, 2.7)] * 3), "mean_energy", 0.5)
    assert (result.left_width < 0.1 * result.right_width).all()


@pytest.mark.parametrize("level", [0.02, 0.5, 0.97])
def test_widths_do_not_depend_on_the_level_where_the_plateau_is_flat(level):
    result = ll.map_boundary(grid([trapezium(1.8, 1.85, 2.4, 2.45)] * 3), "mean_energy", level)
    np.testing.assert_allclose(result.left_width, 0.04, rtol=1e-9)
    np.testing.assert_allclose(result.right_width, 0.04, rtol=1e-9)


def test_a_jump_between_neighbours_shows_as_less_than_a_spacing():
    rows = [np.where((RATIOS > 1.9) & (RATIOS < 2.5), 3.0, 0.0)] * 3
    result = ll.map_boundary(grid(rows), "mean_energy", 1.0)
    np.testing.assert_allclose(result.left_width, 0.8 * result.attrs["spacing"], rtol=1e-9)


def test_the_main_region_is_the_one_with_the_largest_integral_not_a_narrow_band():
    band = trapezium(0.99, 1.0, 1.02, 1.03, height=2.0)
    result = ll.map_boundary(grid([trapezium(1.8, 1.9, 2.2, 2.7) + band] * 3), "mean_energy", 0.5)
    np.testing.assert_allclose(result.left_edge, 1.85, rtol=1e-12)


def test_an_undetermined_boundary_is_nan():
    low = trapezium(1.8, 1.9, 2.2, 2.7, height=0.1)  # below the level
    cut = np.where(RATIOS < 2.3, trapezium(1.8, 1.9, 2.4, 2.7), np.nan)
    lifted = 0.3 + trapezium(1.8, 1.9, 2.2, 2.7)  # never below a tenth of the plateau
    result = ll.map_boundary(grid([low, cut, lifted]), "mean_energy", 0.5)
    assert np.isnan(result.left_edge.values).tolist() == [True, False, False]
    assert np.isnan(result.right_edge.values).tolist() == [True, True, False]
    assert np.isnan(result.left_width.values).tolist() == [True, False, True]
    assert np.isnan(result.right_width.values).tolist() == [True, True, True]


def test_the_contour_of_a_cone_is_a_circle_in_the_units_of_the_axes():
    x, y = np.linspace(1.0, 3.0, 201), np.linspace(0.0, 2.0, 201)
    cone = np.hypot(y[:, None] - 1.0, x[None] - 2.0)
    result = ll.map_boundary(grid(cone, drive_amplitude=y, frequency_ratio=x), "mean_energy", 0.5)
    radius = np.hypot(result.boundary_x - 2.0, result.boundary_y - 1.0)
    # the bilinear surface is off by spacing^2 / (8 radius)
    np.testing.assert_allclose(radius, 0.5, atol=3e-5)
    assert set(result.part.values) == {0}


def test_the_order_of_dimensions_and_values_does_not_matter():
    expected = ll.map_boundary(grid([trapezium(1.8, 1.9, 2.2, 2.7)] * 3), "mean_energy", 0.5)
    turned = (
        grid([trapezium(1.8, 1.9, 2.2, 2.7)] * 3)
        .transpose()
        .isel(frequency_ratio=slice(None, None, -1))
    )
    xr.testing.assert_identical(ll.map_boundary(turned, "mean_energy", 0.5), expected)


def test_a_damped_pendulum_from_a_small_angle_grows_between_the_edges_of_the_tongue():
    pendulum = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    axes = {"drive_amplitude": [0.05, 0.06], "frequency_ratio": np.linspace(1.88, 2.16, 29)}
    swept = ll.sweep(
        pendulum, axes=axes, initial_angle=1e-6, duration=150.0, observables=["largest_angle"]
    )
    result = ll.map_boundary(swept, "largest_angle", 1e-5)
    low, high = tongue_edges(drive_amplitude=0.05, length=1.0, mass=0.8, damping=0.05)
    # 150 s of growth by a factor of ten need a rate of 0.015 1/s: one spacing inside the edge
    assert float(result.left_edge[0]) == pytest.approx(low, abs=0.01)
    assert float(result.right_edge[0]) == pytest.approx(high, abs=0.01)
    assert result.boundary_y.attrs["units"] == "m"


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda g: (g, "mean_enrgy", 0.5), "did you mean 'mean_energy'"),
        (lambda g: (g.isel(drive_amplitude=0), "mean_energy", 0.5), "a map over two parameters"),
        (lambda g: (g.isel(drive_amplitude=[0]), "mean_energy", 0.5), "at least 2 values each"),
        (lambda g: (g, "mean_energy", float("nan")), "level must be a number"),
    ],
)
def test_bad_input_says_the_rule_and_the_way_out(make, message):
    with pytest.raises(ValueError, match=message):
        ll.map_boundary(*make(grid([trapezium(1.8, 1.9, 2.2, 2.7)] * 3)))
