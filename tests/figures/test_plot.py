"""The picture of a run shows its angles, contacts, energies and pivot, labelled from metadata."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex

import latolato as ll
from latolato.core.errors import InputError

BALL = ll.Ball(length=1.0, mass=0.8, radius=0.1, damping=0.02)
PENDULUM = ll.Pendulum(length=1.0, mass=0.8)
TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=0.6)


def toy(**options):
    return ll.simulate(TOY, initial_angle=1.0, duration=7.0, **options)


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def samples(run, line):
    """What a line shows at the samples of a run, which hit no contact."""
    return np.asarray(line.get_ydata())[np.searchsorted(line.get_xdata(), run.time.values)]


def test_both_mirrored_balls_of_the_toy_are_drawn():
    run = toy()
    drawn = lines(ll.plot(run).axes[0])
    np.testing.assert_array_equal(samples(run, drawn["right ball"]), run.angle)
    np.testing.assert_array_equal(samples(run, drawn["left ball"]), -run.angle)


def test_two_balls_are_drawn_by_their_own_angles():
    pair = ll.BallPair(right=BALL, left=BALL)
    run = ll.simulate(pair, initial_angle=(0.5, -0.4), duration=2.0)
    figure = ll.plot(run)
    drawn = lines(figure.axes[0])
    np.testing.assert_array_equal(samples(run, drawn["left ball"]), run.angle.sel(ball="left"))
    total = samples(run, lines(figure.axes[1])["total energy $E$"])
    np.testing.assert_array_equal(total, run.total_energy.values.sum(axis=0))


def test_contacts_are_marked_on_the_curves_and_counted_by_kind():
    run = toy()
    counts = dict(zip(*np.unique(run.contact_kind, return_counts=True), strict=True))
    marks = {c.get_label(): c for c in ll.plot(run).axes[0].collections}
    for kind in ("bottom", "rest"):
        points = marks[f"{kind} ({counts[kind]})"].get_offsets()
        np.testing.assert_allclose(points[:, 1], np.arcsin(0.1), rtol=1e-15)


def test_drawn_curves_reach_the_wall_at_contacts_and_stay_outside_it():
    run = toy()
    line = lines(ll.plot(run).axes[0])["right ball"]
    for instant in run.contact_time.values:
        at = np.asarray(line.get_ydata())[line.get_xdata() == instant]
        assert at.size >= 2  # just before and just after
        np.testing.assert_allclose(at, np.arcsin(0.1), rtol=1e-15)
    assert np.min(line.get_ydata()) >= np.arcsin(0.1) - 1e-15


def test_marks_of_two_balls_are_as_far_apart_as_the_balls_touch():
    pair = ll.BallPair(right=BALL, left=ll.Ball(length=0.95, mass=0.5, radius=0.12))
    run = ll.simulate(pair, initial_angle=(0.9, -0.4), duration=4.0)
    right, left = (c.get_offsets()[:, 1] for c in ll.plot(run).axes[0].collections)
    assert len(right) == run.sizes["contact"] > 2
    np.testing.assert_allclose(right - left, pair.contact_separation, rtol=1e-14)
    finer = ll.simulate(pair, initial_angle=(0.9, -0.4), duration=4.0, times=run.contact_time)
    # third order in 0.02 s, the time between samples, at some 10 rad/s^3
    np.testing.assert_allclose(right, finer.angle.sel(ball="right"), atol=1e-5)


def test_energies_jump_at_contacts_by_what_is_lost():
    run = toy()
    figure = ll.plot(run)
    line = lines(figure.axes[1])["total energy $E$"]
    time, energy = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    for i, instant in enumerate(run.contact_time.values):
        before, after = energy[time == instant]
        v = float(run.angular_velocity_before[i]), float(run.angular_velocity_after[i])
        lost = 0.5 * TOY.mass * TOY.length**2 * (v[0] ** 2 - v[1] ** 2)
        assert before - after == pytest.approx(lost, abs=1e-14)
    # nothing is lost between contacts: all steps are vertical
    between = np.diff(time) > 0.0
    assert np.abs(np.diff(energy)[between]).max() < 1e-9
    loss = lines(figure.axes[2])["impact loss $D_e$"].get_ydata()
    assert np.abs(np.diff(loss)[between]).max() < 1e-9


def test_drawing_does_not_change_the_run():
    run = toy()
    before = run.copy(deep=True)
    ll.plot(run)
    assert run.identical(before)


@pytest.mark.parametrize("times", [[0.0, 7.0], [3.0, 3.5, 4.0], [0.5], [6.9, 7.0]])
def test_few_samples_are_drawn_too(times):
    run = ll.simulate(TOY, initial_angle=1.0, duration=7.0, times=times)
    shown = (run.contact_time >= times[0]) & (run.contact_time <= times[-1])
    marks = ll.plot(run).axes[0].collections
    assert sum(len(c.get_offsets()) for c in marks) == 2 * int(shown.sum())


def test_the_drawn_ledger_closes():
    run = ll.simulate(
        TOY, ll.Harmonic(drive_amplitude=0.2, drive_frequency=6.26), initial_angle=1.0, duration=7.0
    )
    drawn = {name: line.get_ydata() for name, line in lines(ll.plot(run).axes[2]).items()}
    balance = drawn["drive work $W_{in}$"] - drawn["impact loss $D_e$"] - drawn["energy gained"]
    captured = drawn.get("capture loss $D_c$", 0.0)
    # losses below 1e-9 of the largest energy are not drawn
    assert np.abs(balance - captured).max() < 2e-9 * float(run.total_energy.max())


def test_what_is_zero_throughout_is_not_drawn():
    run = ll.simulate(PENDULUM, initial_angle=1.0, duration=2.0)
    assert set(lines(ll.plot(run).axes[2])) == {"energy gained"}


def test_labels_come_from_the_metadata():
    figure = ll.plot(toy())
    angles, energies, _, pivot = figure.axes[:4]
    assert angles.get_ylabel() == r"$\theta$ [°]"
    assert energies.get_ylabel() == "energy [J]"
    assert pivot.get_ylabel() == "$y_0$ [mm]"
    assert pivot.get_xlabel() == "time $t$ [s]"


def test_the_clamp_is_called_an_artefact():
    titles = [axes.get_title(loc="left") for axes in ll.plot(toy(contact=ll.ClampContact())).axes]
    assert "Angles (a fixed-step artefact)" in titles


def test_a_loaded_run_gives_the_same_picture(tmp_path):
    run = toy()
    again = ll.load(ll.save(run, tmp_path / "run.csv"))
    for ours, loaded in zip(ll.plot(run).axes, ll.plot(again).axes, strict=True):
        assert ours.get_title(loc="left") == loaded.get_title(loc="left")
        assert lines(ours).keys() == lines(loaded).keys()


def test_a_dataset_that_is_no_run_is_refused():
    with pytest.raises(ValueError, match="plot needs a run: a dataset with angle over time"):
        ll.plot(toy().drop_vars("angle"))


def test_what_is_no_dataset_is_refused():
    with pytest.raises(InputError, match=r"plot needs a run: .*, got 3"):
        ll.plot(3)


HUNG = ll.LatoLato(
    length=1.0, mass=0.8, radius=0.1, damping=0.05, restitution=0.9, suspension="string",
    string_restitution=0.3,
)  # fmt: skip
STRONG = ll.Harmonic(drive_amplitude=0.3, drive_frequency=9.0)


@pytest.fixture(scope="module")
def hung():
    return ll.simulate(HUNG, STRONG, initial_angle=0.5, duration=3.0)


def test_a_run_with_slack_strings_shows_distances_and_when_strings_go_slack_and_taut(hung):
    figure = ll.plot(hung)
    assert len(figure.axes) == 5
    distance = figure.axes[1].get_lines()[0]
    np.testing.assert_array_equal(samples(hung, distance), hung.distance)
    assert np.max(distance.get_ydata()) == 1.0
    counts = dict(zip(*np.unique(hung.contact_kind, return_counts=True), strict=True))
    marks = {c.get_label(): c for c in figure.axes[0].collections}
    for kind in ("slack", "taut", "bottom"):
        assert counts[kind] > 0
        assert len(marks[f"{kind} ({counts[kind]})"].get_offsets()) == counts[kind]
    assert "Distance" in figure.axes[1].get_title(loc="left") + str(
        [text.get_text() for text in figure.axes[1].texts]
    )


def test_marks_of_strings_have_the_colour_of_neither_ball(hung):
    axes = ll.plot(hung).axes[0]
    balls = {to_hex(line.get_color()) for line in axes.get_lines()}
    marks = {
        to_hex(marks.get_facecolor()[0])
        for marks in axes.collections
        if marks.get_label().startswith(("slack", "taut"))
    }
    assert len(balls) == len(marks) == 2
    assert not balls & marks


def test_strings_that_stay_taut_are_drawn_as_rods_are():
    taut = ll.simulate(replace(TOY, suspension="string"), initial_angle=1.0, duration=7.0)
    strings, rods = ll.plot(taut), ll.plot(toy())
    assert len(strings.axes) == len(rods.axes) == 4
    for one, other in zip(strings.axes, rods.axes, strict=True):
        for name, line in lines(one).items():
            # strings equal rods to rounding
            np.testing.assert_allclose(line.get_ydata(), lines(other)[name].get_ydata(), atol=1e-9)


def test_the_drawn_ledger_of_strings_closes_with_the_loss_of_tightening(hung):
    drawn = {name: line.get_ydata() for name, line in lines(ll.plot(hung).axes[3]).items()}
    losses = [values for name, values in drawn.items() if "loss" in name]
    assert "retension loss $D_s$" in drawn
    balance = drawn["drive work $W_{in}$"] - sum(losses) - drawn["energy gained"]
    # losses below 1e-9 of the largest energy are not drawn
    assert np.abs(balance).max() < 2e-9 * float(hung.total_energy.max())


def test_slack_balls_touch_at_the_drawn_hit(hung):
    from latolato.figures.curves import with_contacts

    curves = with_contacts(hung)
    at = np.flatnonzero(curves.contact_kind.values == "bottom")
    angle = curves.contact_angle.values[at]
    distance = np.interp(curves.contact_time.values[at], hung.time, hung.distance)
    assert (distance < 0.999).any()
    # Distances are third order between samples 0.007 s apart, straight here: second order.
    np.testing.assert_allclose(np.sin(angle) * distance, 0.1, atol=1e-4)


def test_one_variable_of_a_run_is_drawn_by_its_name(hung):
    axes = ll.plot(hung, "tension").axes[0]
    assert axes.get_title(loc="left") == "Tension of the string, per ball"
    assert np.min(axes.get_lines()[0].get_ydata()) >= 0.0
    pair = ll.simulate(ll.BallPair(right=BALL, left=BALL), initial_angle=(0.5, -0.4), duration=1.0)
    assert {"right ball", "left ball"} <= set(lines(ll.plot(pair, "angle").axes[0]))


def test_derivatives_of_a_run_have_a_panel_for_each_parameter():
    pair = ll.BallPair(right=BALL, left=BALL)
    asked = ["restitution", "right_length"]
    run = ll.simulate(pair, initial_angle=(0.5, -0.4), duration=2.0, sensitivity_to=asked)
    panels = ll.plot(run, "angle_sensitivity").axes
    titles = [axes.get_title(loc="left") for axes in panels]
    words = [name.replace("_", " ") for name in asked]
    assert titles == [f"Derivative of the angle with respect to {word}" for word in words]
    assert [axes.get_ylabel().split("[")[1] for axes in panels] == ["rad]", "rad per m]"]
    drawn = panels[1].get_lines()[1].get_ydata()
    np.testing.assert_array_equal(drawn, run.angle_sensitivity.sel(ball="left")[1])


def test_the_tension_of_a_rod_is_never_drawn_as_that_of_a_string():
    rod = ll.simulate(TOY, STRONG, initial_angle=0.5, duration=3.0)
    assert float(rod.tension.min()) < 0.0
    title = ll.plot(rod, "tension").axes[0].get_title(loc="left")
    assert title.startswith("Tension of the rod, per ball (negative: the rod is pushed")
    for name in ("slack", "distance", "radial_velocity", "retension_loss"):
        with pytest.raises(InputError, match="must be one of a run on rods, which never go slack"):
            ll.plot(rod, name)
    with pytest.raises(InputError, match="unknown variable 'tensoin' of a run: did you mean"):
        ll.plot(rod, "tensoin")


def test_a_pivot_that_moves_sideways_is_drawn_both_ways():
    drive = ll.PlanarHarmonic(
        vertical_amplitude=0.05, horizontal_amplitude=0.02, drive_frequency=6.0
    )
    run = ll.simulate(PENDULUM, drive, initial_angle=0.3, duration=2.0)
    drawn = lines(ll.plot(run).axes[-1])
    np.testing.assert_array_equal(drawn["to the right"].get_ydata(), run.pivot_across)
    np.testing.assert_array_equal(drawn["upwards"].get_ydata(), run.pivot_height)
