"""Bifurcation curves over maps: those that are shipped, those of files, and the motions on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import latolato as ll
from app_pages import open_view
from latolato.analysis import floquet
from latolato.app import CURVES
from latolato.app.forms import registry
from latolato.app.map import files, stored
from latolato.core.errors import InputError
from latolato.figures.analyses.stored_system import drive_of, system_of
from latolato.io.analysis_tables import read_curves
from shipped_curves import SHIPPED as MAKERS
from shipped_curves import write_shipped

FIG11 = "&map.scenario=fig11&map.size=16&map.duration=10&map.transient=5"
SHIPPED = (CURVES / "fig11.csv").read_text(encoding="utf-8")


def wait_for_curves(page, count):
    page.wait_for_function(
        "(n) => window.latolato.views.map.over.shownCurves().length === n", arg=count
    )


# The motions of fig05 take a hundred shakes of each point: a minute for each curve.
MADE = [pytest.param("fig05", marks=pytest.mark.slow), "fig09", "fig11"]


@pytest.mark.parametrize("name", MADE)
def test_shipped_curves_are_what_their_makers_give(name, tmp_path):
    assert {path.stem for path in CURVES.glob("*")} == set(MAKERS)
    for path in write_shipped([name], tmp_path):
        pairs = [
            read_curves((folder / path.name).read_text(encoding="utf-8"))
            for folder in (CURVES, tmp_path)
        ]
        for kept, made in zip(*pairs, strict=True):
            versions = ("latolato_version", "numpy_version")
            labels = [{k: v for k, v in c.attrs.items() if k not in versions} for c in (kept, made)]
            assert labels[0] == labels[1]
            assert kept.sizes == made.sizes
            kept, made = pair_of_multipliers(kept), pair_of_multipliers(made)
            for name, variable in made.data_vars.items():
                if variable.dtype.kind != "f":
                    np.testing.assert_array_equal(kept[name], variable)
                else:  # places are solved to 1e-10
                    np.testing.assert_allclose(kept[name], variable, rtol=1e-5, atol=1e-7)


def pair_of_multipliers(curve):
    """Return a curve with the sum and product of the multipliers in place of them.

    Where two of them meet they have the root of the error of a place, which these have not.
    """
    parts = ["multipliers_real", "multipliers_imag"]
    real, imaginary = (curve[name] for name in parts)
    values = (real + 1j * imaginary).values
    both = {"sum": values.sum(axis=1), "product": values.prod(axis=1)}
    assert all(np.abs(each.imag).max() < 1e-12 for each in both.values())
    return curve.drop_vars(parts).assign({k: ("point", v.real) for k, v in both.items()})


@pytest.mark.parametrize("name", MAKERS)
def test_motions_on_shipped_curves_are_at_their_bifurcations(name):
    text = (CURVES / f"{name}.csv").read_text(encoding="utf-8")
    critical = {"fold": 1.0, "period_doubling": -1.0}
    for curve in read_curves(text):
        system, drive = system_of(curve), drive_of(curve)
        kind, period = str(curve.attrs["bifurcation"]), int(curve.attrs["period"])
        for k in np.linspace(0, curve.sizes["point"] - 1, 4).astype(int):
            point = curve.isel(point=k)
            ratio, amplitude = float(point.frequency_ratio), float(point.drive_amplitude)
            frequency = ratio * system.natural_frequency
            if kind == "lift_off":
                assert amplitude * frequency**2 == pytest.approx(system.gravity)
                continue
            orbit = floquet(
                system,
                replace(drive, drive_amplitude=amplitude, drive_frequency=frequency),
                initial_angle=float(point.initial_angle),
                initial_angular_velocity=float(point.initial_angular_velocity),
                period=period,
            )
            # Multipliers have the root of the errors of a place where two of them meet.
            assert np.abs(orbit.multipliers - critical[kind]).min() < 1e-3


def test_scenarios_of_maps_name_the_files_of_their_curves():
    named = {name: each["curves"] for name, each in registry()["scenarios"].items()}
    assert named["fig11"] == "curves/fig11.csv"
    assert {f"curves/{name}.csv" for name in MAKERS} == {*named.values()} - {None}


@pytest.mark.parametrize(
    "text, words",
    [
        ("", "it has no labels"),
        ("# analysis: tongues\n", "it is a result of tongues"),
        ("# analysis: bifurcation_curve\n", "it has no 'parameters'"),
    ],
)
def test_what_holds_no_curve_is_refused(text, words):
    with pytest.raises(InputError, match=f"curves holds no bifurcation curve: {words}"):
        read_curves(text)


def test_a_picture_of_a_map_has_its_bifurcation_curves(tmp_path):
    options = registry()["scenarios"]["fig11"]["options"]
    request = {
        "kind": "svg", "observable": "largest_angle", "curves": [SHIPPED],
        "options": {k: v for k, v in options.items() if v is not None} | {"duration": 2.0,
                    "drive": "harmonic", "drive_amplitude": 0.02, "drive_frequency": 12.0},
        "sweep": {"axes": {"amplitude_ratio": [0.05, 0.1], "frequency_ratio": [1.6, 3.6]},
                  "observables": [{"kind": "largest_angle"}]},
    }  # fmt: skip
    _, arrays = files.compute(files.prepare({}, request).request, tmp_path, lambda share: None)
    text = arrays["file"].tobytes().decode()
    for words in ("fold", "lift off"):
        assert f">{words}</text>" in text


def test_curves_are_walked_along_switched_off_and_opened_in_toy(page):
    open_view(page, FIG11, view="map")
    wait_for_curves(page, 2)
    field = page.get_by_role("application")
    field.focus()
    crosses = []
    for key in ("c", "c", "Shift+C"):
        field.press(key)
        crosses.append(page.evaluate("() => window.latolato.views.map.chart.cross"))
    on_curve = page.evaluate(
        """() => window.latolato.views.map.over.shownCurves().map(({ xs, ys }) =>
          xs.map((x, i) => [x, ys[i]])).flat()"""
    )
    assert crosses[0] in on_curve
    assert crosses[1] in on_curve
    assert crosses[1] != crosses[0] == crosses[2]
    assert "map.at" not in page.url
    # A cell opens as before.
    field.press("ArrowLeft")
    field.press("Enter")
    page.wait_for_function("() => location.search.includes('map.at=')")
    assert "largest angle after the transient" in page.locator(".map-readout").inner_text()
    # The address keeps which lines are switched off.
    page.get_by_text("Curves and trials").click()
    page.get_by_label("Fold (").uncheck()
    page.get_by_label("Mathieu tongue").uncheck()
    wait_for_curves(page, 1)
    assert "map.off=fold%2Ctongue" in page.url
    page.reload()
    page.wait_for_selector("[data-done]")
    wait_for_curves(page, 1)
    page.get_by_text("Curves and trials").click()
    for label in ("Fold (", "Mathieu tongue"):
        assert not page.get_by_label(label).is_checked()
        page.get_by_label(label).check()
    wait_for_curves(page, 2)
    assert "map.off" not in page.url
    # A point of the fold, clicked a few pixels beside it.
    page.evaluate("() => scrollTo(0, 0)")
    spot = page.evaluate(
        """() => {
          const { chart, over } = window.latolato.views.map;
          const fold = over.shownCurves().find(({ name }) => name === "fold");
          const i = fold.xs.findIndex((x) => x > 1.7);
          const [x, y] = chart.place(fold.xs[i], fold.ys[i]);
          const box = chart.canvas.getBoundingClientRect();
          const zoom = chart.canvas.width / box.width;
          return { left: box.left + x / zoom + 3, top: box.top + y / zoom,
            ratio: fold.xs[i], angle: fold.largest[i] };
        }"""
    )
    page.mouse.move(spot["left"], spot["top"])
    page.get_by_text("Fold · ω/ω₀ = ").first.wait_for()
    page.mouse.click(spot["left"], spot["top"])
    said = page.locator(".map-readout").inner_text()
    assert f"{spot['ratio']:.4g}" in said
    assert said.endswith(f"contact word: B · largest angle: {np.degrees(spot['angle']):.4g}°")
    page.locator(".point").get_by_text("Fold · ").wait_for()
    page.get_by_role("button", name="Open in Toy").click()
    page.wait_for_function(
        "() => window.latolato.views.toy?.player.motion?.about.options.drive_amplitude > 0"
    )
    found = page.evaluate(
        """() => {
          const { motion } = window.latolato.views.toy.player;
          const { options, duration } = motion.about;
          const period = 2 * Math.PI / options.drive_frequency;
          const at = (k) => motion.balls.map((ball) => motion.angle(ball, k * period));
          const angles = Array.from({ length: 13 }, (_, k) => at(k + 0.37));
          return { options, shakes: duration / period, angles };
        }"""
    )
    assert found["options"]["drive_frequency"] == pytest.approx(
        spot["ratio"] * (9.8 / 0.245) ** 0.5, rel=1e-9
    )
    assert found["shakes"] == pytest.approx(20.0)
    angles = np.array(found["angles"])
    assert np.ptp(angles, axis=0).max() < 1e-4


def test_files_of_curves_and_trials_are_told_apart_and_others_are_refused(page, tmp_path):
    (tmp_path / "curve.csv").write_text(SHIPPED)
    (tmp_path / "other.csv").write_text(SHIPPED.replace("restitution: 0.9", "restitution: 0.8"))
    (tmp_path / "trials.csv").write_text(
        "drive_amplitude,frequency_ratio,class\n20 mm,2.0,none\n200 mm,2.0,weak\n"
    )
    query = (
        FIG11.replace("scenario=fig11", "scenario=page")
        + "&length=24.5 cm&mass=106.44 g&radius=19.6 mm&damping=5.06 g m/s&system=latolato"
        "&restitution=0.9&initial_offset=0.2&map.x=drive_frequency&map.y=amplitude_ratio"
    )
    open_view(page, query, view="map")
    page.get_by_text("Curves and trials").click()
    field = page.get_by_label("Trial table or curves")
    field.set_input_files([tmp_path / "curve.csv", tmp_path / "trials.csv"])
    page.get_by_text("2 trials, 1 of them outside the map.").wait_for()
    wait_for_curves(page, 2)
    field.set_input_files([tmp_path / "curve.csv", tmp_path / "other.csv"])
    page.get_by_text(
        "other.csv: this curve is of another system than the map: its restitution is 0.8"
    ).wait_for()
    wait_for_curves(page, 2)
    (tmp_path / "bad.csv").write_text("drive_amplitude,frequency_ratio,class\n0.02,2.0,0\n")
    field.set_input_files([tmp_path / "bad.csv"])
    page.get_by_text(
        "bad.csv: trial 1: class must be 'none', 'weak' or 'strong', got '0'"
    ).wait_for()
    field.set_input_files([])
    wait_for_curves(page, 0)


def test_a_curve_of_analyse_opens_over_a_map_of_the_same_system(page):
    page.goto(
        "/?view=analyse&scenario=toy&drive_amplitude=27.6 mm&analyse.what=bifurcation_curve"
        "&analyse.kind=lift_off&analyse.initial_angle=0.0901219&analyse.low=0.005, 1.5"
        "&analyse.high=0.05, 4&analyse.points=30&analyse.ask=1"
        "&analyse.parameters=drive_amplitude, frequency_ratio"
    )
    page.get_by_role("button", name="Show over a map").click()
    page.wait_for_selector("[data-done]")
    wait_for_curves(page, 1)
    found = page.evaluate(
        """() => {
          const { grid, over, question } = window.latolato.views.map;
          const about = ({ name, values }) => [name, values[0], values.at(-1)];
          return { x: about(grid.x), y: about(grid.y), kind: over.shownCurves()[0].kind,
            angle: question.options.initial_angle, length: question.options.length };
        }"""
    )
    options = registry()["scenarios"]["toy"]["options"]
    assert found["x"] == ["frequency_ratio", 1.5, 4.0]
    assert found["y"] == ["drive_amplitude", 0.005, 0.05]
    assert found["kind"] == "lift_off"
    assert (found["angle"], found["length"]) == (options["initial_angle"], options["length"])
    # The page forgets it when it is loaded again, and shows the map alone.
    page.reload()
    page.wait_for_selector("[data-done]")
    wait_for_curves(page, 0)


def test_a_stored_map_tells_the_laws_that_curves_must_share(tmp_path):
    axes = {"drive_amplitude": [0.02, 0.03], "frequency_ratio": [2.0, 3.0]}
    grid = ll.load_scenario("fig11").sweep(duration=1.0, transient=0.0, axes=axes)
    about, _ = stored.compute({"path": ll.save(grid, tmp_path / "map.nc")}, tmp_path, print)
    fold, _ = read_curves(SHIPPED)
    assert {"system", "drive", "contact", "restitution", "drive_phase"} <= about["laws"].keys()
    assert about["laws"] == {name: fold.attrs[name] for name in about["laws"]}


def test_a_site_keeps_shipped_curves_for_reading_without_a_network(site):
    assert (site / "curves/fig11.csv").read_text(encoding="utf-8") == SHIPPED
    assert '"curves/fig11.csv"' in (site / "files.js").read_text(encoding="utf-8")
