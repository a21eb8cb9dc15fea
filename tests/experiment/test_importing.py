"""Tables of other programs become track tables, or are refused in one line."""

import numpy as np
import pytest

import latolato as ll
from latolato.experiment.importing import import_table
from latolato.experiment.track_table import write_table

TIME = np.arange(0.0, 2.0, 0.05)
ANGLE = 0.5 * np.cos(5.0 * TIME)


def lines(*columns, delimiter=",", decimal="."):
    rows = zip(*columns, strict=True)
    return "\n".join(delimiter.join(f"{v:.9f}".replace(".", decimal) for v in row) for row in rows)


def written(tmp_path, text, name="data.csv", encoding="utf-8"):
    path = tmp_path / name
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize(
    "head, delimiter, decimal",
    [
        ("mass A\nt,theta\n", ",", "."),
        ("#t;theta\n", ";", ","),
        ("# exported by Tracker\n\nt\ttheta\n", "\t", "."),
        ("t theta\n", " ", "."),
    ],
)
def test_exports_of_tracker_are_read_with_their_units(tmp_path, head, delimiter, decimal):
    body = lines(TIME, np.rad2deg(ANGLE), delimiter=delimiter, decimal=decimal)
    path = written(tmp_path, head + body, "track.txt")
    table = import_table(path, {"time": "t [s]", "angle_1": "theta [deg]"}, length=0.36)
    assert table.time.values == pytest.approx(TIME)
    assert table.angle_1.values == pytest.approx(ANGLE, abs=1e-9)
    assert table.attrs["length"] == 0.36
    assert table.attrs["source"] == "track.txt"
    assert len(table.attrs["source_sha256"]) == 64


def test_units_in_the_names_of_a_phones_columns_are_enough(tmp_path):
    text = '"Time (s)","Angle (°)"\n' + lines(TIME, np.rad2deg(ANGLE))
    for encoding in ("utf-8", "cp1252"):
        path = written(tmp_path, text, encoding=encoding)
        for columns in (None, {"time": "Time", "angle_1": "Angle"}):
            table = import_table(path, columns, angle_sigma=2e-3)
            assert table.angle_1.values == pytest.approx(ANGLE, abs=1e-9)
            assert np.all(table.angle_sigma_1 == 2e-3)


def test_rows_whose_angle_is_missing_are_rows_also_at_the_top(tmp_path):
    text = "# run 7\nt (s),theta (deg)\n0,\n0.1,\n0.2,10\n0.3,\n0.4,9\n"
    table = import_table(written(tmp_path, text))
    assert table.time.values.tolist() == [0.0, 0.1, 0.2, 0.3, 0.4]
    assert np.isfinite(table.angle_1.values).tolist() == [False, False, True, False, True]


@pytest.mark.parametrize(
    "names",
    [
        ("x ball", "y ball", "x pivot", "y pivot"),
        ("ball_x", "ball_y", "pivot_x", "pivot_y"),
        ("Ball 1 position x", "Ball 1 position y", "Pivot x", "Pivot y"),
        ("x bola", "y bola", "x poros", "y poros"),
        ("x1", "y1", "pivot_x", "pivot_y"),
    ],
)
def test_an_object_in_the_names_of_columns_is_a_track(tmp_path, names):
    still = np.full_like(TIME, 12.0)
    head = ",".join(["t (s)", *(f"{name} (cm)" for name in names)])
    x, y = 30.0 * np.sin(ANGLE) + 12.0, 12.0 - 30.0 * np.cos(ANGLE)
    table = import_table(written(tmp_path, f"{head}\n" + lines(TIME, x, y, still, still)))
    assert table.angle_1.values == pytest.approx(ANGLE, abs=1e-6)
    assert "angle_2" not in table


def test_sides_and_numbers_in_the_names_of_columns_are_two_balls(tmp_path):
    for names in (
        "left angle (rad),right angle (rad)",
        "theta2 [rad],theta1 [rad]",
        "Angle of pendulum 2 (rad),Angle of pendulum 1 (rad)",
    ):
        path = written(tmp_path, f"t [s],{names}\n" + lines(TIME, -ANGLE, ANGLE))
        assert import_table(path).angle_1.values == pytest.approx(ANGLE, abs=1e-6)
    path = written(tmp_path, "t [s],theta1 [rad],theta2 [rad],theta3 [rad]\n0,1,2,3\n1,1,2,3\n")
    with pytest.raises(ll.InputError, match=r"3 tracks: 1, 2, 3; .*as in angle_1 = 'theta1'"):
        import_table(path)
    # What no ball is called is nobody's place.
    path = written(tmp_path, "t [s],Gyroscope x,Acceleration x,Acceleration y\n0,1,2,3\n1,1,2,3\n")
    with pytest.raises(ll.InputError, match="not clear which column is angle_1"):
        import_table(path)


@pytest.mark.parametrize("name", ["Pendulum angle", "Measured angle of the rod", "Winkel (Stab)"])
def test_the_one_column_of_an_angle_is_the_angle_whatever_it_is_called(tmp_path, name):
    for others, values in ("", []), (",Angular velocity (rad/s),Height (cm)", [TIME, TIME]):
        text = f"t (s),{name} (rad){others}\n" + lines(TIME, ANGLE, *values)
        table = import_table(written(tmp_path, text))
        assert table.angle_1.values == pytest.approx(ANGLE, abs=1e-6)
        assert "angle_2" not in table
    text = "t (s),Roll angle (rad),Yaw angle (rad)\n" + lines(TIME, ANGLE, ANGLE)
    with pytest.raises(ll.InputError, match="not clear which column is angle_1"):
        import_table(written(tmp_path, text))


def test_a_table_of_times_alone_is_refused(tmp_path):
    path = written(tmp_path, "t (s),x ball (cm),remark\n0,1,a\n1,2,b\n")
    for columns in (None, {"time": "t"}):
        with pytest.raises(
            ll.InputError, match="which column is angle_1; it has t, x ball, remark"
        ):
            import_table(path, columns)
    path = written(tmp_path, "t (s),theta (deg)\n0,\n1,\n")
    with pytest.raises(ll.InputError, match="column 'theta' holds no numbers"):
        import_table(path, {"time": "t", "angle_1": "theta"})


def test_degrees_below_radians_are_asked_for_and_stay_as_they_are(tmp_path):
    time = np.arange(0.0, 6.0, 1.0 / 30.0)
    degrees = 30.0 * np.exp(-0.05 * time) * np.cos(5.2 * time)
    path = written(tmp_path, "t (s),angle (rad)\n" + lines(time, degrees))
    questions = []
    table = import_table(path, questions=questions)
    assert questions == [
        "angle_1 swings to and fro by 29.6 rad, which is more than half a turn: is it in "
        "degrees, and its unit wrong?"
    ]
    assert questions[0] in table.attrs["assumed"]
    # Steps of more than half a turn are no jumps of a turn here.
    assert table.angle_1.values == pytest.approx(degrees, abs=1e-6)
    # Where they would hang tells nothing before that is answered.
    path = written(tmp_path, "t (s),angle (rad)\n" + lines(time, 179.0 + degrees))
    assert len(asked_of(path)) == 1
    # A ball that goes round, and one that swings, are in radians.
    for angle in (20.0 * time, 3.0 * np.cos(5.2 * time), 2.5 + 0.1 * degrees):
        path = written(tmp_path, "t (s),angle (rad)\n" + lines(time, angle))
        assert not any("degrees" in each for each in asked_of(path))


def asked_of(path):
    questions = []
    import_table(path, questions=questions)
    return questions


def test_positions_become_angles_about_the_pivot_and_full_turns_are_unwrapped(tmp_path):
    angle = 4.0 * TIME
    x, y = 1.0 + 0.3 * np.sin(angle), 2.0 - 0.3 * np.cos(angle)
    path = written(tmp_path, "t,x,y\n" + lines(1e3 * TIME, 100 * x, 100 * y))
    columns = {"time": "t [ms]", "ball_1_x": "x [cm]", "ball_1_y": "y [cm]"}
    table = import_table(path, columns, pivot=(1.0, 2.0))
    assert table.angle_1.values == pytest.approx(angle, abs=1e-6)
    assert table.ball_1_x.values == pytest.approx(x - 1.0, abs=1e-9)
    flipped = written(tmp_path, "t,x,y\n" + lines(1e3 * TIME, 100 * x, -100 * y), "flipped.csv")
    table = import_table(flipped, columns, pivot=(1.0, -2.0), y_axis="down")
    assert table.angle_1.values == pytest.approx(angle, abs=1e-6)


def test_a_moving_pivot_is_taken_off_and_its_mean_is_the_origin(tmp_path):
    height = 0.02 * np.cos(12.0 * TIME)
    x, y = 0.3 * np.sin(ANGLE), height - 0.3 * np.cos(ANGLE)
    head = "t [s],x [m],y [m],px [m],py [m]\n"
    path = written(tmp_path, head + lines(TIME, x + 1.0, y + 2.0, 0.0 * x + 1.0, height + 2.0))
    names = {"time": "t", "ball_1_x": "x", "ball_1_y": "y", "pivot_x": "px", "pivot_y": "py"}
    table = import_table(path, names)
    assert table.angle_1.values == pytest.approx(ANGLE, abs=1e-7)
    assert float(table.pivot_y.mean()) == pytest.approx(0.0, abs=1e-12)
    assert table.pivot_y.values == pytest.approx(height - height.mean(), abs=1e-8)


def test_a_phone_that_swings_gives_its_angle_from_its_gyroscope(tmp_path):
    time = np.arange(0.0, 20.0, 0.01)
    envelope = 0.5 * np.exp(-0.03 * time)
    angle = envelope * np.cos(5.0 * time)
    rate = -0.03 * angle - 5.0 * envelope * np.sin(5.0 * time) + 0.02  # with a bias
    head = '"Time (s)","Gyroscope x (rad/s)"\n'
    path = written(tmp_path, head + lines(time, rate))
    table = import_table(path, {"time": "Time", "angular_velocity_1": "Gyroscope x"})
    assert table.angle_1.values == pytest.approx(angle, abs=2e-3)
    fit = ll.fit_decay(table, method="envelope", profile=False)
    assert fit["decay_rate_envelope"].value == pytest.approx(0.03, rel=0.02)
    short = written(tmp_path, head + lines(time[:50], rate[:50]), "short.csv")
    with pytest.raises(ValueError, match="at least 6 turning points"):
        import_table(short, {"time": "Time", "angular_velocity_1": "Gyroscope x"})


def test_angles_from_the_x_axis_and_gaps_are_understood(tmp_path):
    body = lines(TIME, ANGLE - np.pi / 2).splitlines()
    body[3] = body[3].split(",")[0] + ","
    path = written(tmp_path, "t,theta\n" + "\n".join(body))
    table = import_table(path, {"time": "t [s]", "angle_1": "theta [rad]"}, angle_from="right")
    assert table.flag_1.values.tolist().count("lost") == 1
    assert table.angle_1.values[:3] == pytest.approx(ANGLE[:3])
    assert np.isnan(table.angle_1.values[3])


def test_two_tracks_are_two_balls_and_a_pivot_without_naming_columns(tmp_path):
    left, right = 0.3 * np.sin(-ANGLE), 0.3 * np.sin(ANGLE)
    down = -0.3 * np.cos(ANGLE)
    still = np.zeros_like(TIME)
    head = "\tleft ball\t\tright ball\t\tpivot\t\t\nt\tx\ty\tx\ty\tx\ty\t\n"
    body = lines(TIME, left, down, right, down, still, still, delimiter="\t")
    table = import_table(written(tmp_path, head + body, "pair.txt"))
    assert table.angle_1.values == pytest.approx(ANGLE, abs=1e-7)
    assert table.angle_2.values == pytest.approx(-ANGLE, abs=1e-7)
    assert table.attrs["recognised"] == ("Tracker export, 3 tracks: left ball, right ball, pivot")
    assert "ball_1_x = right ball/x [m]" in table.attrs["imported"]
    assert "'t' is in [s], from the kind of file (Tracker export)" in table.attrs["assumed"]


def test_a_run_beside_others_is_chosen_by_its_name(tmp_path):
    head = '"Time (s) Run #1","Angle (rad) Run #1","Time (s) Run #2","Angle (rad) Run #2"\n'
    rows = [f"{t:.4f},{a:.6f},{t:.4f},{-a:.6f}" for t, a in zip(TIME, ANGLE, strict=True)]
    rows[30:] = [",," + row.split(",", 2)[2] for row in rows[30:]]  # the first run is shorter
    path = written(tmp_path, head + "\n".join(rows))
    first, second = (import_table(path, section=f"Run #{run}") for run in (1, 2))
    assert first.sizes["frame"] == 30
    assert "10 rows without numbers left out" in first.attrs["assumed"]
    assert second.angle_1.values == pytest.approx(-ANGLE, abs=1e-6)
    by_name = import_table(path, {"time": "Run #2/Time", "angle_1": "Run #2/Angle"})
    assert by_name.angle_1.equals(second.angle_1)
    with pytest.raises(
        ll.InputError, match=r"2 runs beside each other.*choose one with section, as in 'Run #1'"
    ):
        import_table(path)
    with pytest.raises(ll.InputError, match="no section 'Run #3'"):
        import_table(path, section="Run #3")


def test_frame_numbers_need_a_frame_rate_and_gaps_stay(tmp_path):
    path = written(tmp_path, "frame,theta [deg]\n10,5\n11,6.5\n14,7\n")
    table = import_table(path, frame_rate=240.0)
    assert table.time.values == pytest.approx(np.array([10, 11, 14]) / 240.0, rel=1e-15)
    assert table.frame.values.tolist() == [10, 11, 14]
    assert "divided by 240 per second" in table.attrs["assumed"]
    for columns in (None, {"time": "frame [s]", "angle_1": "theta"}):
        with pytest.raises(ll.InputError, match=r"frame numbers.*give frame_rate"):
            import_table(path, columns)
    seconds = written(tmp_path, "t [s],theta [deg]\n0.5,5\n0.6,6.5\n", "seconds.csv")
    with pytest.raises(ll.InputError, match="no frame numbers, which a frame rate needs"):
        import_table(seconds, {"time": "t", "angle_1": "theta"}, frame_rate=240.0)


def test_without_times_and_frame_numbers_each_row_is_a_frame(tmp_path):
    text = "theta [deg],n\n5,1\n,2\n7,3\n"
    table = import_table(written(tmp_path, text), frame_rate=50.0)
    assert table.time.values == pytest.approx([0.0, 0.02, 0.04])
    assert np.isnan(table.angle_1.values[1])
    for gap in ("\n", ",lost\n", "# lost\n"):
        path = written(tmp_path, f"theta [deg],n\n5,1\n{gap}7,3\n")
        with pytest.raises(ll.InputError, match="counted as frames, since line 3 is no row"):
            import_table(path, frame_rate=50.0)
    assert "each row is a frame" in table.attrs["assumed"]
    with pytest.raises(ll.InputError, match="if each row is a frame, give frame_rate"):
        import_table(written(tmp_path, text))
    # Frame numbers are used where there are any, and times need no rate.
    path = written(tmp_path, "frame,theta [deg]\n10,5\n12,7\n")
    table = import_table(path, {"angle_1": "theta"}, frame_rate=50.0)
    assert table.frame.values.tolist() == [10, 12]
    with pytest.raises(ll.InputError, match="'t' holds times, which need no frame rate"):
        import_table(written(tmp_path, "t [s],theta [deg]\n1,5\n2,7\n"), frame_rate=50.0)


@pytest.mark.parametrize(
    "cells, rate, times",
    [
        (["00:00:03.250", "00:00:03.300"], None, [3.25, 3.3]),
        (["0:59,5", "1:00,5"], None, [59.5, 60.5]),
        (["2026-10-05 23:59:59.5", "2026-10-06 00:00:00.5"], None, [0.0, 1.0]),
        (["09:13:29:506", "09:13:29:516"], None, [0.0, 0.01]),
        (["0:00:00:29", "0:00:01:00", "0:00:01:01"], 30.0, [29 / 30, 1.0, 31 / 30]),
        (["0:00:00:96", "0:00:01:00", "0:00:01:03"], 30.0, [29 / 30, 1.0, 31 / 30]),
        (["0:00:00:03", "0:00:00:06"], None, "give frame_rate"),
        (["0:00:00:00", "0:00:00:05"], 120.0, "may count frames or hundredths"),
        (["12:30", "12:31"], None, "line 2 holds '12:30', which is no time such as"),
        (["0:00:59.5", "0:00:60.5"], None, "line 3 holds '0:00:60.5'"),
    ],
)
def test_times_on_a_clock_are_read_in_seconds(tmp_path, cells, rate, times):
    rows = "".join(f"{cell};{i}\n" for i, cell in enumerate(cells))
    path = written(tmp_path, "time;theta [deg]\n" + rows)
    if isinstance(times, str):
        with pytest.raises(ll.InputError, match=times):
            import_table(path, frame_rate=rate)
    else:
        assert import_table(path, frame_rate=rate).time.values == pytest.approx(times, abs=1e-9)


@pytest.mark.parametrize("mark", ["-999", "9999", "999.99", "1e30", "-999.0"])
def test_numbers_that_stand_for_missing_ones_are_no_measurements(tmp_path, mark):
    cells = [f"{each:.5f}" for each in ANGLE]
    cells[4] = cells[5] = cells[30] = mark
    body = "\n".join(f"{t:.2f},{cell}" for t, cell in zip(TIME, cells, strict=True))
    for head, columns in (
        ("t [s],theta [rad]", None),
        ("t [s],y [mm]", {"time": "t", "pivot_y": "y"}),
    ):
        path = written(tmp_path, f"{head}\n{body}")
        with pytest.raises(ll.InputError, match=r"line 6 of column .* far from the other numbers"):
            import_table(path, columns)


@pytest.mark.parametrize("mark", ["-1,-1", "0,0"])
def test_places_that_stand_for_a_lost_ball_are_no_measurements(tmp_path, mark):
    u, v = 320.0 + 400.0 * np.sin(ANGLE), 75.0 + 400.0 * np.cos(ANGLE)
    rows = lines(TIME, u, v).split("\n")
    rows[6] = rows[6].split(",")[0] + "," + mark
    path = written(tmp_path, "t [s],x [px],y [px]\n" + "\n".join(rows))
    with pytest.raises(ll.InputError, match=r"line 8 of column 'x' holds .?\d, which is far"):
        import_table(path, pivot=(320.0, 75.0), y_axis="down")
    # The middle of a swing may be there.
    path = written(tmp_path, "t [s],x [m],y [m]\n0,-0.1,0.01\n1,0,0\n2,0.1,0.01\n3,0.2,0.04\n")
    assert import_table(path, pivot=(0.0, 0.4)).angle_1.values[1] == 0.0


def test_columns_of_the_same_kind_are_not_chosen_by_their_order(tmp_path):
    path = written(tmp_path, "t [s],angle [deg],theta [rad]\n0,1,2\n1,2,3\n")
    with pytest.raises(ll.InputError, match=r"2 columns may be angle_1: 2 \(angle \[deg\]\), 3"):
        import_table(path)
    path = written(tmp_path, "time,t [s],t [s],theta [rad]\n9:13:00,0,5,2\n9:13:01,1,6,3\n")
    with pytest.raises(ll.InputError, match=r"2 columns may be time: 2 .*, 3"):
        import_table(path)
    table = import_table(path, {"time": "3", "angle_1": "theta"})
    assert table.time.values.tolist() == [5.0, 6.0]
    # A recording has a clock of its own beside that of the phone.
    path = written(tmp_path, "time,seconds_elapsed,angle [rad]\n1718030736872695300,0.5,2\n")
    assert import_table(path).time.values.tolist() == [0.5]


def test_mega_is_not_milli(tmp_path):
    path = written(tmp_path, "t (Ms),theta (rad)\n1,1\n2,1\n")
    with pytest.raises(ll.InputError, match=r"in \[Ms\], which may mean \[ms\]"):
        import_table(path)
    assert import_table(path, {"time": "t [ms]", "angle_1": "theta"}).time.values[1] == 0.002


def test_a_track_table_needs_no_import(tmp_path):
    table = import_table(written(tmp_path, "t [s],theta [rad]\n0,1\n1,1\n"))
    path = write_table(table, tmp_path / "own.csv")
    with pytest.raises(ll.InputError, match="it is a track table already"):
        import_table(path)


@pytest.mark.parametrize(
    "head",
    [
        "Waktu (detik);Sudut (derajat)",
        "Temps (s);Angle (degrés)",
        "Zeit (s) Lauf #2;Winkel (°) Lauf #2",
        "Time (s);Angle, Ch P1 (deg)",
    ],
)
def test_usual_names_of_other_languages_and_programs_are_known(tmp_path, head):
    path = written(tmp_path, head + "\n" + lines(TIME, np.rad2deg(ANGLE), delimiter=";"))
    assert import_table(path).angle_1.values == pytest.approx(ANGLE, abs=1e-9)


def test_pixels_without_a_scale_give_angles_only(tmp_path):
    u, v = 320.0 + 400.0 * np.sin(ANGLE), 75.0 + 400.0 * np.cos(ANGLE)
    path = written(tmp_path, "t [s],x [px],y [px]\n" + lines(TIME, u, v))
    table = import_table(path, pivot=(320.0, 75.0), y_axis="down")
    assert table.angle_1.values == pytest.approx(ANGLE, abs=1e-9)
    assert np.isnan(table.ball_1_x.values).all()
    assert "only angles are kept" in table.attrs["assumed"]
    path = written(tmp_path, "t [s],x [px],y [px],z [m]\n" + lines(TIME, u, v, v))
    mixed = {"time": "t", "ball_1_x": "x", "ball_1_y": "y", "pivot_x": "z", "pivot_y": "z"}
    with pytest.raises(ll.InputError, match="ball_1_x is in pixels, but pivot_x is not"):
        import_table(path, mixed)


def test_jumps_and_whole_turns_are_taken_off_stated_angles(tmp_path):
    hanging = np.rad2deg(ANGLE) + 270.0  # from the x axis, as an angle of 0 to 360 degrees
    path = written(tmp_path, "t [s],theta [deg]\n" + lines(TIME, hanging))
    table = import_table(path, angle_from="right")
    assert table.angle_1.values == pytest.approx(ANGLE, abs=1e-9)
    assert "angle_1 is shifted by a whole turn" in table.attrs["assumed"]
    wrapped = np.rad2deg((ANGLE + 2.8 + np.pi) % (2.0 * np.pi) - np.pi)
    path = written(tmp_path, "t [s],theta [deg]\n" + lines(TIME, wrapped), "wrapped.csv")
    table = import_table(path)
    assert np.ptp(table.angle_1.values) == pytest.approx(np.ptp(ANGLE), abs=1e-8)
    assert "jumps of a whole turn removed" in table.attrs["assumed"]


def test_a_ball_above_its_pivot_raises_a_question(tmp_path):
    x, y = 0.3 * np.sin(ANGLE), 0.3 * np.cos(ANGLE)
    path = written(tmp_path, "t [s],x [m],y [m]\n" + lines(TIME, x, y))
    table = import_table(path, pivot=(0.0, 0.0))
    assert "does y point down (y_axis='down')?" in table.attrs["assumed"]
    assert "assumed" not in import_table(path, pivot=(0.0, 0.0), y_axis="down").attrs
    path = written(tmp_path, "t [s],theta [deg]\n" + lines(TIME, np.rad2deg(ANGLE) - 180.0))
    assert "the x axis (angle_from='right')?" in import_table(path).attrs["assumed"]


def test_the_command_line_asks_in_the_words_of_its_options(tmp_path, capsys):
    from latolato.cli.main import main

    # What the command has no option for is called as in the table.
    question = (
        "question angle_1 is above the pivot in most rows: is it counted from the x axis "
        "(--angle-from right)? recognised "
    )
    shifts = {-180.0: "a whole turn", 360.0: "a whole turn", -720.0: "2 whole turns"}
    for turned, by in shifts.items():
        path = written(tmp_path, "t [s],theta [deg]\n" + lines(TIME, np.rad2deg(ANGLE) + turned))
        assert main(["import", str(path)]) == 0
        shown = " ".join(capsys.readouterr().out.split())
        assert f" note angle_1 is shifted by {by} written " in shown
        assert shown.startswith(question) == (turned == -180.0)
    path = written(tmp_path, "sec,theta [deg]\n" + lines(TIME, np.rad2deg(ANGLE)), "b.csv")
    assert main(["import", str(path), "--column", "angle_1=theta"]) == 2
    assert (
        "name it with --column, as in time = 't [s]', or give --frame-rate"
        in capsys.readouterr().err
    )


def test_columns_are_named_by_position_where_the_file_has_no_names(tmp_path):
    path = written(tmp_path, "0.0;12.5\n0.1;11.5\n")
    table = import_table(path, {"time": "1 [s]", "angle_1": "2 [Deg]"})
    assert table.angle_1.values == pytest.approx(np.deg2rad([12.5, 11.5]))


def test_what_the_unit_of_a_column_may_be_is_listed(tmp_path):
    path = written(tmp_path, "t (S);theta (gon);x (km/h)\n0.0;100;1.5\n0.1;90;1.5\n")
    table = import_table(path, {"time": "t", "angle_1": "theta"})
    assert table.angle_1.values == pytest.approx([0.5 * np.pi, 0.45 * np.pi])
    with pytest.raises(ll.InputError, match=r"\[km/h\].*it may be rad, mrad, deg, arcmin, gon"):
        import_table(path, {"time": "t", "angle_1": "x"})
    with pytest.raises(ll.InputError, match=r"is in \[gon\].*it may be m, cm, mm.*px"):
        import_table(path, {"time": "t", "pivot_y": "theta"})


def test_times_that_fall_are_named_with_their_line_in_the_file(tmp_path):
    path = written(tmp_path, "# a comment\nt [s],theta [deg]\n0.0,1\n0.1,2\n0.1,3\n")
    with pytest.raises(ll.InputError, match=r"increase strictly, above 0\.1 in line 5"):
        import_table(path)
    path = written(tmp_path, "t [s],theta [deg]\n0.0,1\n,2.5\n0.1,3\n")
    with pytest.raises(ll.InputError, match="time is missing in line 3"):
        import_table(path)


@pytest.mark.parametrize(
    "text, columns, said",
    [
        ("", None, "is empty"),
        ("t,theta\n", None, "no rows of numbers"),
        ("0,1.5\n1,2\n", None, "no names above"),
        ("t,theta\n0,1\n1,2\n", None, "the unit of column 't' is missing"),
        ("t,theta\n0,1\n1,2\n", {"angle_1": "theta [rad]"}, "which column is the time"),
        ("t,theta\n0,1\n1,2\n", {"time": "t [s]", "angle_1": "phi [rad]"}, "no column 'phi'; it"),
        ("t,theta\n0,1\n1,2\n", {"time": "t [kg]"}, r"is in \[kg\], which is not a unit of time"),
        ("t,theta\n0,1\n1,2\n", {"time": "t [s]", "angle": "theta [rad]"}, "no column 'angle'"),
        ("t [ms],theta\n0,1\n1,2\n", {"time": "t [s]"}, r"is in \[ms\] itself"),
        ("t,t\n0,1\n1,2\n", {"time": "t [s]"}, "2 columns 't'"),
        ("t,theta\n0,1\n1,2\nx,3\n", {"time": "t [s]"}, "line 4 of column"),
        ("t,theta\n0,1\n1\n", {"time": "t [s]"}, "line 3 has 1 cell"),
        ("t,theta\n0,1\n0,2\n", {"time": "t [s]"}, "time must increase strictly"),
        ("t,x\n0,1\n1,2\n", {"time": "t [s]", "ball_1_x": "x [m]"}, "its other coordinate"),
        (
            "t,x,y\n0,1,1\n1,2,2\n",
            {"time": "t [s]", "ball_1_x": "x [m]", "ball_1_y": "y [m]"},
            "need the pivot",
        ),
        ("a,b\n0,1\n1,2\n", None, "name it with columns, as in time = 'a"),
        ("t [s],b [kg]\n0,1\n1,2\n", None, r"name it with columns, as in angle_1 = 'NAME \[rad\]'"),
        ("t [s],theta [rad]\n0,(1)\n1,(2)\n", None, r"'theta' holds texts such as '\(1\)' in line"),
        ("t [s],theta [rad],x\n0,,1\n1,,2\n", None, "'theta' holds no numbers; save the file with"),
    ],
)  # fmt: skip
def test_what_is_missing_is_named_in_one_line(tmp_path, text, columns, said):
    with pytest.raises(ValueError, match=said) as caught:
        import_table(written(tmp_path, text), columns)
    assert "\n" not in str(caught.value)


def test_files_that_are_no_text_or_not_there_are_refused(tmp_path):
    (tmp_path / "a.csv").write_bytes(bytes(range(256)) * 4)
    with pytest.raises(ValueError, match=r"is not a text file|no rows"):
        import_table(tmp_path / "a.csv")
    with pytest.raises(FileNotFoundError, match="there is no file"):
        import_table(tmp_path / "b.csv")


def test_a_folder_or_the_measurement_itself_is_not_replaced(tmp_path):
    from typer.testing import CliRunner

    from latolato.cli.main import app

    path = written(tmp_path, "t [s],theta [rad]\n0,1\n1,1\n", "a.csv")
    answer = CliRunner().invoke(app, ["import", str(path), "--output", str(path)])
    assert "is the measurement itself" in str(answer.exception or answer.output)
    (tmp_path / "a.track.csv").mkdir()
    answer = CliRunner().invoke(app, ["import", str(path)])
    assert "is a folder; name a file" in str(answer.exception or answer.output)
    assert path.read_text().startswith("t [s]")
