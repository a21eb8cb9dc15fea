"""Pictures of sweeps: cells, scales, what has no answer, theory and trials drawn over."""

import math

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgba

import latolato as ll
from hanging import tongue_edges
from latolato.figures import style
from latolato.figures.map import NO_ANSWER
from latolato.figures.overlays import Context, tongue

PENDULUM = ll.Pendulum(length=0.5, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
AXES = {"drive_amplitude": [0.0, 0.05, 0.1], "frequency_ratio": [1.6, 1.8, 2.0, 2.2]}


def sweep(system=PENDULUM, axes=AXES, observables=("mean_energy",), **options):
    options = {"initial_angle": 0.2, "duration": 2.0} | options
    return ll.sweep(system, axes=axes, observables=list(observables), **options)


@pytest.fixture(scope="module")
def grid():
    return sweep(observables=("mean_energy", "largest_angle", "motion_class", "crossings"))


@pytest.fixture
def holed(grid):
    """The map with one point that met its limit of events and one that was never computed."""
    copy = grid.copy(deep=True)
    for place, status in (((1, 2), "event_limit"), ((2, 0), "missing")):
        copy.mean_energy[place] = np.nan
        copy.status[place] = status
    return copy


def cells(figure):
    return figure.axes[0].collections[0]


def legend(figure):
    return [t.get_text() for each in figure.legends for t in each.get_texts()]


def test_cells_lie_around_their_point_with_the_frequency_to_the_right(grid):
    for turned in (grid, grid.transpose(), grid.isel(frequency_ratio=[2, 0, 3, 1])):
        figure = ll.plot(turned, "mean_energy")
        values = cells(figure).get_array()
        np.testing.assert_array_equal(values, grid.mean_energy)
        corners = cells(figure).get_coordinates()
        np.testing.assert_allclose(corners[0, :, 0], [1.5, 1.7, 1.9, 2.1, 2.3])
        np.testing.assert_allclose(corners[:, 0, 1], [0.0, 0.025, 0.075, 0.125])  # none below 0


def test_labels_carry_names_symbols_and_units(grid):
    axes, bar = ll.plot(grid, "mean_energy").axes
    assert axes.get_xlabel() == r"driving over natural frequency $\omega/\omega_0$"
    assert axes.get_ylabel() == "driving amplitude $A_0$ [mm]"
    assert bar.get_ylabel() == r"time mean of the total energy $\langle E\rangle$ [J]"
    title = axes.get_title(loc="left")
    assert "$l$ = 50 cm" in title
    assert r"$\omega$" not in title  # it varies


def test_titles_have_the_units_of_the_screen(grid):
    title = ll.plot(grid, "motion_class").axes[0].get_title(loc="left")
    assert "strong angle = 90°" in title
    axes = {"drive_amplitude": [0.03], "frequency_ratio": [2.0, 2.2]}
    title = (
        ll.plot(sweep(TOY, axes), select={"drive_amplitude": 0.03}).axes[0].get_title(loc="left")
    )
    for part in ("$A_0$ = 30 mm", "$l$ = 100 cm", "$m$ = 800 g", "$r$ = 100 mm"):
        assert part in title
    assert r"$\theta_0$ = 11.46°" in title


def test_points_without_an_answer_are_grey_and_counted_by_status(holed):
    figure = ll.plot(holed)
    assert np.ma.getmaskarray(cells(figure).get_array())[1, 2]
    assert legend(figure) == ["no answer (1 event limit)", "not computed yet (1)"]
    grey = figure.axes[0].collections[1]
    visible = ~np.ma.getmaskarray(grey.get_array())
    assert np.argwhere(visible).tolist() == [[1, 2]]
    from matplotlib.colors import to_rgba

    figure.canvas.draw()
    np.testing.assert_allclose(grey.cmap(0.5), to_rgba(NO_ANSWER))


def test_a_value_that_stands_with_a_failed_status_is_not_drawn(grid):
    wrong = grid.copy(deep=True)
    wrong.status[0, 0] = "failed"
    assert np.ma.getmaskarray(cells(ll.plot(wrong)).get_array())[0, 0]


def test_equal_values_do_not_get_the_colours_of_both_signs(grid):
    for value in (0.0, 0.1):
        flat = grid.assign(mean_energy=xr.full_like(grid.mean_energy, value))
        assert cells(ll.plot(flat, "mean_energy")).cmap.name == "viridis"


def test_zeros_have_a_colour_of_their_own_on_a_log_scale(grid):
    figure = ll.plot(grid, "crossings", log=True)
    assert legend(figure) == ["zero"]
    assert np.ma.getmaskarray(cells(figure).get_array()).all()


def test_negative_values_have_no_log_scale(grid):
    turned = grid.assign(largest_angle=grid.largest_angle.copy(data=-grid.largest_angle.values))
    with pytest.raises(ValueError, match="must not be negative on a log scale, got -"):
        ll.plot(turned, "largest_angle", log=True)


def test_classes_have_a_legend_and_no_colour_bar(grid):
    figure = ll.plot(grid, "motion_class")
    assert len(figure.axes) == 1
    assert legend(figure) == ["none", "weak", "strong"]


# Codes of B, BB, BBB, BBBB, T, TT, BT, no contact and no word, and a cell without any.
WORDS = np.array([[4, 16, 64, 256], [5, 16, 64, 21], [17, 0, 1, math.nan]])


def test_the_commonest_words_have_colours_of_their_own_and_the_legend_their_share(grid):
    words = grid.assign(contact_word=grid.mean_energy.copy(data=WORDS))
    figure = ll.plot(words, "contact_word")
    assert legend(figure) == [
        "no contact (8.3 %)", "B (8.3 %)", "BT (8.3 %)", "no word (8.3 %)", "BB (16.7 %)",
        "BBB (16.7 %)", "T (8.3 %)", "TT (8.3 %)", "other words (8.3 %)",
        "no answer (1 without value)",
    ]  # fmt: skip
    shown = cells(figure)
    painted = shown.cmap(shown.norm(shown.get_array()))
    assert (painted[0, 1] == painted[1, 1]).all()
    assert (painted[0, 3] == to_rgba(style.FAINT)).all()
    alone = cells(ll.plot(words.isel(drive_amplitude=[0, 2]), "contact_word"))
    assert alone.cmap(alone.norm(0.0)) == to_rgba(style.PALE_GREY)


def test_one_dimension_gives_a_curve_and_few_curves_are_named(grid):
    single = ll.plot(grid.isel(drive_amplitude=2), "mean_energy").axes[0].get_lines()
    assert len(single) == 1
    several = ll.plot(grid, "mean_energy", curves=True).axes[0].get_lines()
    names = [line.get_label() for line in several]
    assert names == ["$A_0$ = 0 mm", "$A_0$ = 50 mm", "$A_0$ = 100 mm"]
    np.testing.assert_array_equal(several[2].get_ydata(), grid.mean_energy[2])


def test_further_dimensions_are_asked_for_and_selected_by_the_nearest_value():
    axes = {**AXES, "damping": [0.0, 0.1]}
    full = sweep(axes=axes)
    way_out = "select a value of all but two: `select` in Python, `--select NAME=VALUE` on"
    with pytest.raises(ValueError, match=rf"varies over .*damping \(2\).* {way_out}"):
        ll.plot(full)
    np.testing.assert_array_equal(
        cells(ll.plot(full.isel(damping=[1]))).get_array(), full.mean_energy[..., 1]
    )
    figure = ll.plot(full, select={"damping": 0.09})
    np.testing.assert_array_equal(cells(figure).get_array(), full.mean_energy[..., 1])
    assert "$C$ = 0.1 kg m/s" in figure.axes[0].get_title(loc="left")
    with pytest.raises(ValueError, match=r"damping runs from 0 to 0\.1 here, got 3"):
        ll.plot(full, select={"damping": 3.0})


def test_parameters_that_vary_together_are_labelled_by_the_first():
    axes = {"case": {"length": [0.4, 0.6], "mass": [1.0, 2.0]}, "initial_angle": [0.1, 0.2, 0.3]}
    figure = ll.plot(sweep(axes=axes, initial_angle=None))
    assert "(and mass)" in figure.axes[0].get_ylabel()


def test_the_tongue_is_that_of_the_sweeps_own_damping(grid):
    context = Context.of(grid, "frequency_ratio", "drive_amplitude")
    amplitudes, low, high = tongue(context, 0.1)
    expected = tongue_edges(drive_amplitude=0.1, length=0.5, mass=0.8, damping=0.05)
    drawn = np.array([low[-1], high[-1]]) / math.sqrt(9.8 / 0.5)
    np.testing.assert_allclose(drawn, expected, rtol=1e-12)
    # the first amplitude is the tip: gamma/(2 w0) lengths, to first order (Landau & Lifshitz)
    assert amplitudes[0] == pytest.approx(0.5 * 0.125 / (2.0 * math.sqrt(9.8 / 0.5)), rel=1e-3)
    assert low[0] == pytest.approx(high[0], rel=1e-6)
    figure = ll.plot(grid, overlays=["tongue"])
    (line,) = figure.axes[0].get_lines()
    (x, *_), (y, *_) = line.get_data()
    assert y == figure.axes[0].get_ylim()[1]  # the upper border of the last cells
    expected = tongue_edges(drive_amplitude=y, length=0.5, mass=0.8, damping=0.05)
    assert x == pytest.approx(expected[0])
    assert legend(figure) == ["Mathieu tongue (theory)"]


@pytest.mark.parametrize(
    "x, y",
    [
        ("frequency_ratio", "amplitude_ratio"),
        ("drive_frequency", "drive_amplitude"),
        ("frequency_ratio", "drive_acceleration_ratio"),
    ],
)
def test_lift_off_is_where_the_pivot_reaches_gravity_on_every_pair_of_axes(x, y):
    axes = {y: [0.1, 0.5, 1.0, 1.5], x: [1.5, 2.0, 3.0, 4.0]}
    figure = ll.plot(sweep(TOY, axes), overlays=["lift_off", "tongue"])
    across, up = figure.axes[0].get_lines()[0].get_data()
    frequency = across * (math.sqrt(9.8) if x == "frequency_ratio" else 1.0)
    amplitude = up * (9.8 / frequency**2 if y == "drive_acceleration_ratio" else 1.0)
    np.testing.assert_allclose(amplitude * frequency**2, 9.8)


def test_trials_are_placed_on_the_map_and_those_outside_are_counted(grid, tmp_path):
    trials = tmp_path / "trials.csv"
    trials.write_text(
        "# from the laboratory\n"
        "set, drive_amplitude, drive_frequency, class\n"
        f"1, 50 mm, {2.0 * math.sqrt(9.8 / 0.5)}, strong\n"
        "1, 0.02, 1 Hz, none\n"
    )
    headed = tmp_path / "headed.csv"
    headed.write_text("drive_amplitude [mm],frequency_ratio [1],class\n50,2,strong\n20,9,none\n")
    assert legend(ll.plot(grid, points=headed)) == legend(ll.plot(grid, points=trials))
    figure = ll.plot(grid, points=trials)
    assert legend(figure) == ["trial, none (1 of 1 outside)", "trial, strong"]
    strong = figure.axes[0].collections[-1].get_offsets()
    np.testing.assert_allclose(strong, [[2.0, 0.05]])


@pytest.mark.parametrize(
    "text, message",
    [
        ("drive_amplitude,class\n1,weak\n", "needs the columns"),
        (
            "drive_amplitude,frequency_ratio,class\n1,2,wild\n",
            "line 2: class .*, got 'wild'",
        ),
        ("drive_amplitude,frequency_ratio,class\nx,2,weak\n", "trial 1 in line 2: drive_amp"),
    ],
)
def test_a_bad_table_of_trials_is_refused_by_row(grid, tmp_path, text, message):
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(ValueError, match=message):
        ll.plot(grid, points=tmp_path / "t.csv")


def test_overlays_need_their_axes_and_walls(grid):
    with pytest.raises(ValueError, match="unknown overlay 'tonge': did you mean 'tongue'"):
        ll.plot(grid, overlays=["tonge"])
    with pytest.raises(ValueError, match="lift_off needs a system with contact"):
        ll.plot(grid, overlays=["lift_off"])
    other = sweep(axes={"initial_angle": [0.1, 0.2], "mass": [1.0, 2.0]}, initial_angle=None)
    with pytest.raises(ValueError, match="overlays and points need a map of amplitude"):
        ll.plot(other, overlays=["tongue"])


def test_a_run_takes_no_arguments_of_maps(grid):
    run = ll.simulate(PENDULUM, initial_angle=0.1, duration=1.0)
    with pytest.raises(ValueError, match="belong to sweeps"):
        ll.plot(run, log=True)
    with pytest.raises(ValueError, match="unknown variable 'mean_enrgy': did you mean"):
        ll.plot(grid, "mean_enrgy")


def test_pictures_are_the_same_files_each_time(holed, tmp_path):
    figures = [ll.plot(holed) for _ in range(2)]
    for suffix in (".png", ".svg", ".pdf"):
        names = [tmp_path / f"{i}{suffix}" for i in range(2)]
        for figure, name in zip(figures, names, strict=True):
            style.save_figure(figure, name)
        assert names[0].read_bytes() == names[1].read_bytes()


def test_maps_of_strings_name_them_their_units_and_what_tangled():
    strings = ll.LatoLato(
        length=1.0, mass=0.8, radius=0.1, suspension="string", string_restitution=0.5
    )
    wanted = ("slack_fraction", "largest_string_impulse")
    grid = sweep(strings, observables=wanted, initial_angle=0.3)
    grid.slack_fraction[0, 0] = np.nan
    grid.status[0, 0] = "outside_model"
    figure = ll.plot(grid, "slack_fraction")
    assert "latolato on strings" in figure.axes[0].get_title(loc="left")
    assert "$e_s$ = 0.5" in figure.axes[0].get_title(loc="left")
    (legend,) = figure.legends
    assert "no answer (1 outside model)" in [text.get_text() for text in legend.get_texts()]
    bar = ll.plot(grid, "largest_string_impulse").axes[-1]
    assert bar.get_ylabel() == "largest impulse of a string $J_{max}$ [N s]"
    assert len(ll.plot(grid, "status").axes[0].collections) > 0


def test_overlays_over_drag_relative_to_the_room_are_refused():
    room = ll.Pendulum(length=0.5, mass=0.8, damping=0.05, drag_frame="lab")
    grid = sweep(room)
    assert "air at rest in the room" in ll.plot(grid).axes[0].get_title(loc="left")
    with pytest.raises(ValueError, match="drag_frame must be 'pivot' here: overlays"):
        ll.plot(grid, overlays=["tongue"])
