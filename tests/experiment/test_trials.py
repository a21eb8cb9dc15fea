"""Trials: angles, classes and sets of track tables, in a table that survives bad files."""

import json
import math
import warnings

import numpy as np
import pytest

import latolato as ll
from latolato.cli.main import main
from latolato.core.errors import InputError
from latolato.experiment.track_table import track_table, write_table
from latolato.experiment.trial_statistics import class_of, is_borderline, sets_of
from latolato.experiment.trial_table import (
    COLUMNS,
    read_trials,
    trial_table,
    write_trials,
)
from latolato.experiment.trials import collect_trials, files_of, trial_of
from latolato.observables import MotionClass
from latolato.paper.grids import PENDULUM_OBSERVABLES
from track_tables import motion_table
from trial_texts import parse_trials

SINGLE = ll.Pendulum(length=0.363, mass=0.10804, damping=0.00274)


def driven(amplitude=0.025, ratio=1.93, *, duration=40.0, seed=0, **start):
    drive = ll.Harmonic(drive_amplitude=amplitude, drive_frequency=ratio * SINGLE.natural_frequency)
    start = start or {"initial_angle": math.radians(20.0)}
    table = motion_table(SINGLE, drive, duration=duration, fps=30.0, seed=seed, **start)
    table.attrs |= {"length": 0.363, "source": f"{1e3 * amplitude:g}-{ratio:g}.mp4"}
    return table


@pytest.fixture(scope="module")
def tables():
    return [driven(a, r) for a in (0.02, 0.03) for r in (1.8, 1.93, 2.3)]


@pytest.fixture(scope="module")
def folder(tables, tmp_path_factory):
    """Two folders of tables, one with a file that is none."""
    home = tmp_path_factory.mktemp("trials")
    for i, table in enumerate(tables):
        place = home / ("low" if i < 3 else "high")
        place.mkdir(exist_ok=True)
        write_table(table, place / f"{i}.csv")
    (home / "high" / "zz.mp4").write_text("no video")
    return home


@pytest.mark.parametrize("ratio", [1.8, 1.93, 2.1])
def test_angles_and_class_are_those_of_a_sweep_of_the_same_motion(ratio):
    row = trial_of(driven(ratio=ratio))
    grid = ll.sweep(
        SINGLE,
        axes={
            "drive_amplitude": [0.025],
            "drive_frequency": [ratio * SINGLE.natural_frequency],
        },
        duration=40.0,
        transient=40.0 * 2.0 / 3.0,
        initial_angle=math.radians(20.0),
        # Those of Fig. 9, whose kernel is used again.
        observables=PENDULUM_OBSERVABLES,
    )
    sigmas = row["largest_angle_sigma"], row["largest_angle_after_transient_sigma"]
    # Tracks carry 1 mrad of noise.
    assert row["largest_angle"] == pytest.approx(grid.largest_angle.item(), abs=4e-3)
    late = grid.largest_angle_after_transient.item()
    assert row["largest_angle_after_transient"] == pytest.approx(late, abs=3.0 * sigmas[1])
    assert row["class"] == ("none", "weak", "strong")[int(grid.motion_class.item())]
    assert row["frequency_ratio"] == pytest.approx(ratio, abs=1e-4)
    assert row["drive_amplitude"] == pytest.approx(0.025, abs=4.0 * row["drive_amplitude_sigma"])


def test_noise_does_not_raise_the_lasting_angle_of_a_steady_swing():
    time = np.arange(0.0, 60.0, 1.0 / 30.0)
    generator = np.random.default_rng(2)
    away = []
    for _ in range(20):
        angle = 0.8 * np.cos(5.1 * time) + 0.01 * generator.normal(size=len(time))
        columns = {
            "time": time,
            "pivot_y": 0.02 * np.cos(10.2 * time) + 1e-4 * generator.normal(size=len(time)),
            "angle_1": angle,
            "angle_sigma_1": np.full(len(time), 0.01),
        }
        row = trial_of(track_table(columns, {"length": 0.363}))
        away.append(
            (row["largest_angle_after_transient"] - 0.8)
            / row["largest_angle_after_transient_sigma"]
        )
    # The largest of 33 turning points alone would be 2 deviations of a sample too large.
    assert abs(np.mean(away)) < 1.0
    assert np.max(np.abs(away)) < 3.0


def test_classes_are_those_of_the_sweeps():
    law = MotionClass()
    angles = np.array([0.1, law.weak_angle, law.strong_angle])
    assert class_of(angles, angles).tolist() == [0, 1, 2]
    assert class_of(law.strong_angle, 0.0) == 2
    assert class_of(law.strong_angle - 1e-9, law.weak_angle - 1e-9) == 0


def test_an_angle_within_three_deviations_of_a_limit_is_borderline():
    weak, strong = np.pi / 4.0, np.pi / 2.0
    assert is_borderline(strong - 0.029, 0.01, 0.3, 0.01)
    assert not is_borderline(strong - 0.031, 0.01, 0.3, 0.01)
    assert is_borderline(1.0, 0.01, weak + 0.02, 0.01)
    # Strong anyhow: what lasts does not matter.
    assert not is_borderline(strong + 0.1, 0.01, weak, 0.01)
    assert not is_borderline(1.0, np.nan, 0.7, np.nan)


def test_sets_are_folders_or_amplitudes_that_lie_together(folder, tables):
    with pytest.warns(RuntimeWarning, match="zz.mp4"):
        by_folder = collect_trials(folder)
    assert by_folder["set"].values.tolist() == ["high"] * 3 + ["low"] * 3
    assert set(by_folder.set_by.values.tolist()) == {"folder"}
    assert np.all(np.diff(by_folder.frequency_ratio.values[:3]) > 0.0)
    by_amplitude = collect_trials(tables)
    assert by_amplitude["set"].values.tolist() == ["set 1"] * 3 + ["set 2"] * 3
    assert set(by_amplitude.set_by.values.tolist()) == {"amplitude"}
    assert sets_of([0.02, 0.0206, 0.0215], [1e-3, 1e-3, 1e-3]) == ["set 1"] * 3


def test_a_bad_file_is_named_and_the_others_go_on(folder):
    with pytest.warns(RuntimeWarning) as caught:
        trials = collect_trials(folder)
    assert len(caught) == 1
    assert trials.sizes["trial"] == 6
    assert "zz.mp4" in trials.attrs["failed"]
    bad = track_table({"time": [0.0, 0.1], "angle_1": [0.1, 0.2], "pivot_y": [0.0, 0.0]})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        with pytest.raises(ValueError, match="no trial was found in 1 file: "):
            collect_trials(bad)


@pytest.mark.parametrize(
    "name, value",
    [("gravity", math.nan), ("length", 0.0), ("radius", 0.0), ("transient", -1.0)],
)
def test_a_bad_number_is_refused_before_any_file_is_read(folder, name, value):
    with pytest.raises(InputError, match=f"^{name} must"):
        collect_trials(folder, **{name: value})


def test_a_table_beside_its_video_takes_its_place(folder):
    (folder / "low" / "0.mp4").write_text("never opened")
    try:
        names = [path.name for path in files_of([folder / "low"])]
    finally:
        (folder / "low" / "0.mp4").unlink()
    assert names == ["0.csv", "1.csv", "2.csv"]


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
def test_a_trial_table_survives_a_file(tables, tmp_path, suffix):
    trials = collect_trials(tables)
    again = read_trials(write_trials(trials, tmp_path / f"trials{suffix}"))
    for name in COLUMNS:
        np.testing.assert_array_equal(again[name].values, trials[name].values, err_msg=name)
    assert again.attrs["gravity"] == trials.attrs["gravity"]


def test_a_table_of_ones_own_needs_few_columns_and_may_have_units(tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text(
        "drive_amplitude,frequency_ratio,largest_angle,largest_angle_after_transient,remark\n"
        "20 mm,1.95,95 deg,60 deg,loud\n0.0201,2.1,50 deg,46 deg,\n"
    )
    trials = read_trials(path)
    assert trials["class"].values.tolist() == ["strong", "weak"]
    assert trials["set"].values.tolist() == ["set 1", "set 1"]
    assert trials.drive_amplitude.values[0] == 0.02


def test_the_names_of_columns_may_carry_their_units():
    text = "drive_amplitude [mm],drive_frequency [Hz],length [cm],class\n12,1.6,,weak\n"
    plain = "drive_amplitude,drive_frequency,length,class\n12 mm,1.6 Hz,,weak\n"
    assert parse_trials(text).equals(parse_trials(plain))
    with pytest.raises(ValueError, match=r"trial 1: .*got '12 mm cm'"):
        parse_trials(text.replace("[mm]", "[cm]").replace("\n12,", "\n12 mm,"))


@pytest.mark.parametrize(
    "text, encoding",
    [
        ("drive_amplitude [mm];frequency_ratio;class\n12,5;1,95;weak\n20;2;strong\n;;\n", "utf-8"),
        ("drive_amplitude;frequency_ratio;class\n12,5 mm;1,95;weak\n20 mm;2;strong\n", "utf-16"),
        ("Drive amplitude (mm)\tFrequency_ratio\tCLASS\n12.5\t1.95\tweak\n20\t2\tStrong", "ascii"),
    ],
)  # fmt: skip
def test_trial_tables_are_read_like_other_tables(tmp_path, text, encoding):
    path = tmp_path / "mine.txt"
    path.write_bytes(text.encode(encoding))
    trials = read_trials(path)
    assert trials.drive_amplitude.values.tolist() == [0.0125, 0.02]
    assert trials.frequency_ratio.values.tolist() == [1.95, 2.0]
    assert trials["class"].values.tolist() == ["weak", "strong"]


def test_bare_millimetres_and_hertz_are_asked_about(tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text("drive_amplitude,drive_frequency,class\n12.5,10.4,strong\n")
    with pytest.raises(ll.InputError, match=r"would be 12.5 m in line 2.*\[mm\]"):
        read_trials(path)
    text = "drive_amplitude [mm],drive_frequency{},length [cm],class\n12.5,1.654,36.3,strong\n"
    path.write_text(text.format(""))
    with pytest.raises(ll.InputError, match=r"slower than half.*\[Hz\]"):
        read_trials(path)
    path.write_text(text.format(" [Hz]"))
    assert read_trials(path).frequency_ratio.values == pytest.approx([2.0], abs=2e-3)


HEAD = "drive_amplitude [mm],drive_frequency [Hz],"


@pytest.mark.parametrize(
    "text, said",
    [
        ("drive_amplitude,frequency_ratio,class\n12.5 mm,2,weak\n20,2,none\n", "20 m in line 3"),
        (HEAD + "length,class\n10,2,24.5,weak\n", r"would be 24.5 m in line 2.*\[cm\]"),
        (
            HEAD + "largest_angle,largest_angle_after_transient\n10,2,5,1\n10,2,95,1\n",
            r"would be 95 rad in line 3.*\[deg\]",
        ),
        (
            HEAD + "drive_amplitude [m],class\n10,2,0.2,weak\n",
            "2 columns 'drive_amplitude': 1 and 3",
        ),
        (
            HEAD + "length [m],frequency_ratio,class\n10,2,0.245,9,weak\n",
            "in line 2 contradicts drive_frequency and length, which give 1.98",
        ),
    ],
)
def test_trial_tables_that_contradict_themselves_are_refused(tmp_path, text, said):
    path = tmp_path / "mine.csv"
    path.write_text(text)
    with pytest.raises(ll.InputError, match=said):
        read_trials(path)


@pytest.mark.parametrize(
    "text, words",
    [
        ("", "is empty"),
        ("a,b\n1,2\n", "needs the columns drive_amplitude"),
        ("drive_amplitude,frequency_ratio,class\n", "has no rows of numbers"),
        (
            "drive_amplitude,frequency_ratio,class\n0.02,2,loud\n",
            "trial 1 in line 2: class must be 'none'",
        ),
        ("drive_amplitude,frequency_ratio,class\n0.02 s,2,weak\n", "trial 1 in line 2"),
        ("drive_amplitude,frequency_ratio,class\n-0.02,2,weak\n", "must be positive"),
        ("drive_amplitude,frequency_ratio,class\n0.02,2\n", "line 2 has 2 cells below 3 names"),
        ("drive_amplitude,frequency_ratio\n0.02,2\n", "without class"),
    ],
)
def test_a_bad_trial_table_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=words) as caught:
        read_trials(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_bad_options_of_trials_are_refused():
    table = driven(duration=10.0)
    with pytest.raises(ValueError, match="transient must be less than the record"):
        trial_of(table, transient=20.0)
    with pytest.raises(ValueError, match="sets must be"):
        collect_trials(table, sets="colour")
    with pytest.raises(FileNotFoundError, match="no file 'nowhere'"):
        collect_trials("nowhere")
    with pytest.raises(ValueError, match="no column 'colour'"):
        trial_table({"colour": [1.0]})
    still = track_table({"time": np.arange(0, 9, 0.1), "angle_1": np.sin(np.arange(0, 9, 0.1)),
                         "pivot_y": np.zeros(90)})  # fmt: skip
    with pytest.raises(ValueError, match="pivot is at rest"):
        trial_of(still, length=0.363)
    with pytest.raises(ValueError, match="length is not in the table; give it"):
        trial_of(still)


def test_the_command_writes_the_table_and_tells_of_bad_files(folder, tmp_path, capsys):
    target = tmp_path / "trials.csv"
    assert main(["trials", str(folder), "--output", str(target), "--json"]) == 1
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert len(told["trials"]) == 6
    assert told["sets"] == ["high", "low"]
    assert "zz.mp4" in err
    assert err.count("\n") == 1
    assert read_trials(target).sizes["trial"] == 6
    assert main(["trials", str(folder / "low"), "--output", str(target)]) == 0
    assert "3 trials in 1 set:" in capsys.readouterr().out
    assert main(["trials", str(folder), "--output", str(tmp_path / "t.txt")]) == 2
    assert main(["trials", str(folder), "--pivot", "here"]) == 2
    assert main(["trials", str(folder), "--balls", "2", "--ball", "1,2"]) == 2


def test_the_deviation_of_the_settled_angle_makes_a_trial_borderline():
    header = "drive_amplitude,frequency_ratio,largest_angle,largest_angle_sigma,"
    header += "largest_angle_after_transient,largest_angle_after_transient_sigma\n"
    # 0.78 rad lies 0.005 below the limit of weak motion.
    sure, unsure = (f"0.02,2.0,1.0,0.01,0.78,{sigma}\n" for sigma in (0.001, 0.05))
    assert parse_trials(header + sure + unsure).borderline.values.tolist() == [0, 1]
    with pytest.raises(ll.InputError, match="is now called largest_angle_after_transient"):
        parse_trials((header + sure).replace("largest_angle_after_transient", "stabilised_angle"))


def test_a_count_that_is_left_empty_is_zero():
    text = "drive_amplitude,frequency_ratio,class,swings\n0.1,2,weak,7\n0.1,2,weak,\n"
    assert parse_trials(text).swings.values.tolist() == [7, 0]
