"""Pictures of analyses: each has one, and cases without an answer are drawn as such."""

import importlib
import math

import numpy as np
import pytest
import xarray as xr

import latolato as ll
from latolato.analysis import analyses
from latolato.analysis.registry import labelled, recorded
from latolato.core.quantities import QUANTITIES
from latolato.figures import style
from latolato.figures.analyses import drawings
from latolato.figures.plot import module_of
from latolato.scenario.analysis_options import options_of

TOY = ll.LatoLato(length=0.245, mass=0.1, radius=0.0196, damping=0.00274, restitution=0.9)
SHAKE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=12.0)


def made(name, variables, coordinates=None, settings=None, quantities=None):
    """A dataset as the analysis would label it."""
    home = importlib.import_module(f"latolato.analysis.{name}")
    found = labelled(
        variables, system=TOY, drive=SHAKE, coordinates=coordinates,
        quantities=home.QUANTITIES | (quantities or {}), settings=settings,
    )  # fmt: skip
    return recorded(name, found, {})


def multipliers(values, status, **changes):
    numbers = {
        "growth_rate": -0.1, "response_period": 1.0, "impacts": 2.0, "turns": 0.0,
        "slowest_impact": 1.0, "multiplier_error": 1e-12, "defect": 1e-14,
    }  # fmt: skip
    variables = {"multipliers": ("multiplier", np.array(values, dtype=complex)), "status": status}
    return made("floquet", variables | numbers | changes)


def branch(x, angle, stable, specials=(), status="end of range"):
    count = len(x)
    kinds = np.array([s[0] for s in specials], dtype="U20")
    return made(
        "continue_orbit",
        {
            "frequency_ratio": ("point", np.array(x, dtype=float)),
            "largest_angle": ("point", np.array(angle, dtype=float)),
            "is_stable": ("point", np.array(stable, dtype=np.int8)),
            "multipliers": (
                ("point", "multiplier"),
                np.linspace(0.5, 1.5, 2 * count).reshape(count, 2).astype(complex),
            ),
            "special_kind": ("special", kinds),
            "special_value": ("special", np.array([s[1] for s in specials], dtype=float)),
            "special_angle": ("special", np.array([s[2] for s in specials], dtype=float)),
            "status": status,
        },
        settings={"parameter": "frequency_ratio", "low": 1.0, "high": 3.0},
    )


def spectrum(values, status, residual=1e-15):
    variables = {"lyapunov_exponents": ("exponent", np.array(values)), "status": status}
    variables |= {"divergence": -1.0, "sum_rule_residual": residual}
    return made(
        "lyapunov_spectrum",
        variables,
        {"exponent": np.arange(1, len(values) + 1)},
        {"duration": 300.0, "transient": 100.0},
    )


def symmetry(rate, status, **axes):
    dims = tuple(axes)
    rate = np.array(rate, dtype=float)
    return made(
        "pair_symmetry",
        {
            "transverse_exponent": (dims, rate),
            "largest_angle_after_transient": (dims, np.ones_like(rate)),
            "status": (dims, np.array(status)),
        },
        axes,
        {"duration": 300.0, "transient": 50.0},
    )


CASES = {
    "stable": multipliers([0.5 + 0.5j, 0.5 - 0.5j], "stable"),
    "four": multipliers([-4.0, 1.0, 0.5, 0.0], "unstable", turns=1.0),
    "rest": multipliers([0.0, 0.0], "rest", growth_rate=-math.inf, slowest_impact=math.inf),
    "no orbit": multipliers(
        [math.nan] * 2, "not found", response_period=math.nan, defect=math.inf
    ),
    "branch": branch(
        [2.0, 1.5, 1.2, 1.6, 2.5], [0.2, 0.4, 1.0, 1.2, 0.9], [0, 0, 1, 1, 0],
        [("fold", 1.19, 0.9), ("period_doubling", 2.0, 1.1)],
    ),
    "hanging": branch(
        [1.8, 1.9, 2.0], [0.0, 1e-25, 0.0], [1, 1, 0], [("period_doubling", 1.95, 0.0)]
    ),
    "one point": branch([2.0], [0.3], [1], status="lost"),
    "no branch": branch([], [], [], status="not found"),
    "chaos": spectrum([0.5, -1.5], "chaotic"),
    "forgets": spectrum([-math.inf, -math.inf], "rest", 0.0),
    "one forgets": spectrum([-0.5, -math.inf], "rest", 0.0),
    "no spectrum": spectrum([math.nan, math.nan], "failed", math.nan),
    "one rate": symmetry(0.3, "broken"),
    "rests": symmetry(-math.inf, "valid"),
    "curve": symmetry(
        [0.3, -0.2, math.nan, -math.inf, 0.0],
        ["broken", "valid", "failed", "valid", "undecided"],
        frequency_ratio=[1.0, 2.0, 3.0, 4.0, 5.0],
    ),
    "few curves": symmetry(
        [[0.3, -0.2, math.nan], [-math.inf, 0.0, 0.1]],
        [["broken", "valid", "failed"], ["valid", "undecided", "undecided"]],
        drive_amplitude=[0.1, 0.2],
        frequency_ratio=[1.0, 2.0, 3.0],
    ),
    "map": symmetry(
        [[0.3, -0.2, math.nan, -math.inf, 0.1]] * 5,
        [["broken", "valid", "failed", "valid", "undecided"]] * 5,
        drive_amplitude=[0.1, 0.2, 0.3, 0.4, 0.5],
        frequency_ratio=[1.0, 2.0, 3.0, 4.0, 5.0],
    ),
    "narrow map": symmetry(
        [[0.3, -0.2]], [["broken", "valid"]], drive_amplitude=[0.1], frequency_ratio=[1.0, 2.0]
    ),
    "no answer at all": symmetry(
        [[math.nan] * 5] * 5, [["failed"] * 5] * 5,
        drive_amplitude=[0.1, 0.2, 0.3, 0.4, 0.5], frequency_ratio=[1.0, 2.0, 3.0, 4.0, 5.0],
    ),
}  # fmt: skip


def texts(figure):
    """Everything that is written in a figure."""
    from matplotlib.text import Text

    return " ".join(text.get_text() for text in figure.findobj(Text))


@pytest.mark.parametrize("name", analyses)
def test_every_analysis_has_a_picture_of_its_own_or_a_common_one_and_says_how_to_read_it(name):
    module = module_of("analysis", name)
    assert 40 < len(module.READING) < 260
    assert module.READING.endswith(".")
    assert "_" not in module.READING
    assert set(module.FIRST) <= set(options_of(analyses[name]))
    assert callable(getattr(module, "draw", drawings.draw))


def test_an_analysis_that_no_module_describes_is_refused():
    dataset = CASES["stable"].assign_attrs(analysis="nothing")
    with pytest.raises(ValueError, match="analysis 'nothing' has no picture"):
        ll.plot(dataset)


@pytest.mark.parametrize("case", CASES)
def test_all_answers_and_their_absence_are_drawn_within_the_page(case, tmp_path):
    dataset = CASES[case]
    ll.save(dataset, tmp_path / "stored.nc")
    figure = ll.plot(ll.load(tmp_path / "stored.nc"))
    width, height = figure.get_size_inches() * figure.dpi
    for axes in figure.axes:
        box = axes.get_tightbbox()
        if box is not None:
            assert box.x0 >= -1
            assert box.y0 >= -1
            assert box.x1 <= width + 1
            assert box.y1 <= height + 1
    status = dataset["status"].values
    if status.ndim == 0 and case not in ("branch", "hanging", "one point"):
        assert status.item() in texts(figure)


def test_the_unit_circle_is_seen_and_an_arrow_points_at_a_multiplier_far_outside():
    plane = ll.plot(multipliers([-71.25, 0.01], "unstable")).axes[0]
    assert plane.get_xlim() == plane.get_ylim() == (-2.7, 2.7)
    (arrow,) = [text for text in plane.texts if text.arrow_patch]
    assert arrow.xy == pytest.approx((-2.7, 0.0))


def test_stable_and_unstable_pieces_of_a_branch_meet_in_the_special_points():
    figure = ll.plot(CASES["branch"])
    lines = [line for line in figure.axes[0].lines if len(line.get_xdata()) > 1]
    assert [line.get_linestyle() for line in lines[:3]] == ["--", "-", "--"]
    assert lines[0].get_xydata()[-1] == pytest.approx([1.19, 0.9])
    assert lines[1].get_xydata()[0] == pytest.approx([1.19, 0.9])
    assert lines[1].get_xydata()[-1] == pytest.approx([2.0, 1.1])


def test_colours_of_rates_change_at_zero():
    figure = ll.plot(CASES["map"])
    cells = figure.axes[0].collections[0]
    assert cells.norm(0.0) == 0.5
    assert cells.norm.vmin < 0.0 < cells.norm.vmax
    # Minus infinity is beyond the scale, and only what has no value is empty.
    assert np.ma.getmaskarray(cells.get_array())[0].tolist() == [False, False, True, False, False]


def test_a_map_outlines_all_statuses_but_the_most_frequent_and_counts_what_has_no_value():
    (legend,) = ll.plot(CASES["map"]).legends
    assert {text.get_text() for text in legend.get_texts()} == {
        "broken (20 % of the cells)",
        "undecided (20 % of the cells)",
        "no answer (5 failed)",
    }


def test_any_variable_of_an_analysis_can_be_drawn_and_a_part_of_it_selected():
    name, select = "largest_angle_after_transient", {"drive_amplitude": 0.3}
    (axes,) = ll.plot(CASES["map"], name, select=select).axes
    assert axes.get_ylabel().endswith("[°]")
    assert "$A_0$ = 300 mm" in axes.get_title(loc="left")


def test_points_of_a_curve_have_the_colours_of_their_statuses():
    (axes,) = ll.plot(CASES["curve"]).axes
    colours = {line.get_label(): line.get_color() for line in axes.lines}
    assert (colours["broken"], colours["valid"]) == (style.RED, style.BLUE)


def test_samples_are_drawn_in_a_colour_for_each_kind_however_many():
    kinds = xr.DataArray([f"kind {k}" for k in range(9)], dims="sample")
    angle = xr.DataArray(np.arange(9.0), dims="sample", name="angle", attrs={"units": "rad"})
    figure, panels = style.new_figure()
    drawings.draw_points(panels[0, 0], angle, angle, kinds)
    assert [line.get_label() for line in panels[0, 0].lines] == kinds.values.tolist()
    assert figure.axes[0].get_xlabel() == "[°]"


def test_numbers_are_written_with_their_names_and_units_but_not_what_is_missing():
    text = texts(ll.plot(CASES["no orbit"]))
    assert "exponential growth rate" in text
    assert "1/s" in text
    assert "drive periods" not in text  # NaN


def curve_of(x, y, edges, kind="fold", specials=()):
    """A curve as `bifurcation_curve` would return it."""
    count = len(x)
    names = ("drive_amplitude", "frequency_ratio")
    known = {f"special_{name}": QUANTITIES[name] for name in names}
    return made(
        "bifurcation_curve",
        {
            "drive_amplitude": ("point", np.array(y, dtype=float)),
            "frequency_ratio": ("point", np.array(x, dtype=float)),
            "is_edge": ("point", np.array(edges, dtype=np.int8)),
            "special_drive_amplitude": ("special", np.array([s[1] for s in specials], dtype=float)),
            "special_frequency_ratio": ("special", np.array([s[2] for s in specials], dtype=float)),
            "special_kind": ("special", np.array([s[0] for s in specials], dtype="U20")),
            "status": "complete" if count else "not found",
        },
        settings={"bifurcation": kind, "parameters": list(names), "contact": "exact"},
        quantities=known,
    )


def test_a_curve_of_bifurcations_is_solid_where_stable_motions_end():
    x, y = np.linspace(1.0, 2.0, 11), np.linspace(0.05, 0.01, 11)
    edges = [1] * 5 + [0] * 6
    figure = ll.plot(curve_of(x, y, edges, specials=[("cusp", 0.034, 1.4)]))
    solid, dashed, mark = figure.axes[0].get_lines()
    assert solid.get_xdata()[-1] == dashed.get_xdata()[0] == pytest.approx(1.5)
    assert (solid.get_linestyle(), dashed.get_linestyle()) == ("-", "--")
    assert mark.get_xdata()[0] == pytest.approx(1.4)
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == ["fold", "fold, of an unstable motion", "cusp"]
    assert "no curve" in ll.plot(curve_of([], [], [])).axes[0].texts[0].get_text()


def test_a_curve_is_drawn_over_a_map_in_the_units_of_its_axes():
    curve = curve_of([1.0, 2.0, 3.0], [0.01, 0.02, 0.03], [1, 1, 1])
    axes = {"drive_frequency": [6.0, 12.0, 18.0], "amplitude_ratio": [0.05, 0.1]}
    grid = ll.sweep(TOY, axes=axes, initial_angle=0.3, duration=1.0, observables=["largest_angle"])
    figure = ll.plot(grid, overlays=[curve, "lift_off", curve])
    line = next(each for each in figure.axes[0].get_lines() if each.get_label() == "fold")
    np.testing.assert_allclose(line.get_xdata(), TOY.natural_frequency * np.array([1.0, 2.0, 3.0]))
    np.testing.assert_allclose(line.get_ydata(), np.array([0.01, 0.02, 0.03]) / TOY.length)
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts.count("fold") == 1
    other = curve.assign_attrs(restitution=0.5)
    with pytest.raises(ll.InputError, match=r"its restitution is 0\.5, that of the map 0\.9"):
        ll.plot(grid, overlays=[other])
    crank = curve.assign_attrs(drive="crank_slider", connecting_rod_length=1.0)
    with pytest.raises(ll.InputError, match="is of another system than the map"):
        ll.plot(grid, overlays=[crank])
    for wrong in (grid, 3):
        with pytest.raises(ll.InputError, match="must be 'tongue', 'lift_off' or a result"):
            ll.plot(grid, overlays=[wrong])
