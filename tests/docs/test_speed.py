"""The history of the benchmarks: files keep ratios, and README's table is the newest file's."""

import json
from pathlib import Path

import pytest

import ratios

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def commits(monkeypatch, tmp_path):
    """An empty history, and what git says about commit and edits."""
    said = {"log": "abc123\n", "status": ""}
    monkeypatch.setattr(ratios, "HISTORY", tmp_path)
    monkeypatch.setattr(ratios, "_git", lambda *words: said[words[0]])
    return said


def test_readme_shows_the_newest_measurement():
    (table,) = ratios.MARKED.findall((ROOT / "README.md").read_text("utf-8"))
    assert table == ratios.readme_table(ratios.history()[-1])


def test_every_measurement_is_of_a_commit_without_edits():
    known = [about["commit"] for each in ratios.history() for about in each["ratios"].values()]
    assert known
    assert [commit for commit in known if "edited" in commit] == []


def test_a_ratio_is_how_many_times_as_long_the_peer_takes(commits):
    ratios.record("a run", "with impacts", 0.002, {"heyoka": 0.001, "SciPy": 0.5})
    (measured,) = ratios.history()
    peers = {"heyoka": {"ms": 1.0, "ratio": 0.5}, "SciPy": {"ms": 500.0, "ratio": 250.0}}
    about = {"meaning": "with impacts", "commit": "abc123", "ms": 2.0, "peers": peers}
    assert measured["ratios"] == {"a run": about}
    assert "| a run | 2 ms | 1 ms (0.5) | 500 ms (250) |\n" in ratios.readme_table(measured)


def test_benchmarks_of_a_day_share_a_file_and_each_states_its_commit(commits):
    ratios.record("a run", "", 1.0, {"heyoka": 1.0})
    ratios.record("a map", "", 1.0, {"heyoka": 1.0})
    commits["status"] = " M src/latolato/numerics/prepare.py\n"
    ratios.record("a map", "", 1.0, {"heyoka": 2.0})
    (measured,) = ratios.history()
    known = {work: about["commit"] for work, about in measured["ratios"].items()}
    assert known == {"a run": "abc123", "a map": "abc123 edited"}
    assert measured["ratios"]["a map"]["peers"]["heyoka"]["ratio"] == 2.0


def test_readme_leaves_out_what_has_no_other_program_beside_it(commits):
    ratios.record("a run", "", 1.0, {"the run with four derivatives": 2.0})
    assert "a run" not in ratios.readme_table(ratios.history()[0])


def test_the_time_at_an_error_lies_between_the_runs_around_it():
    runs = [(1.0, 1e-4), (4.0, 1e-8)]
    assert ratios.time_at(1e-6, runs) == pytest.approx(2.0)
    assert ratios.time_at(1e-2, runs) == 1.0
    with pytest.raises(ValueError, match="no run reaches the error 1e-09 rad"):
        ratios.time_at(1e-9, runs)


def test_the_picture_has_a_panel_for_each_ratio(commits, tmp_path):
    ratios.record("a run", "", 1.0, {"heyoka": 1.0, "SciPy": 2.0})
    older = json.loads(next(tmp_path.glob("*.json")).read_text("utf-8"))
    older |= {"date": "2020-01-01", "device": "another", "ratios": {}}
    (tmp_path / "2020-01-01-another.json").write_text(json.dumps(older), "utf-8")
    ratios.draw(tmp_path / "speed.svg")
    drawn = (tmp_path / "speed.svg").read_text("utf-8")
    assert drawn.count("beside heyoka") == drawn.count("beside SciPy") == 1
