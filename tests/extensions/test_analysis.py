"""An analysis that a user brings: a file with the function and a file with its words."""

import json
import math
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import latolato as ll
from latolato.analysis import analyses
from latolato.app.analyse.answer import compute
from latolato.app.analyse.forms import about_request, forms
from latolato.app.run_request import RunRequest
from latolato.cli.main import app as command_line
from latolato.core.errors import InputError
from latolato.figures import analyses as pictures

HERE = Path(__file__).parent
PENDULUM = {"system": "pendulum", "length": "1 m", "mass": "0.8 kg"}
ASKED = {"options": {**PENDULUM, "initial_angle": "0.1", "duration": "1 s"}}


@pytest.fixture(autouse=True)
def two_files(monkeypatch, forget):
    """The packages find the files as if they lay among their own, in these tests only."""
    monkeypatch.setattr(analyses, "_entries", dict(analyses))
    packages = {ll.analysis: HERE / "analysis", pictures: HERE / "figures"}
    for package, folder in packages.items():
        monkeypatch.setattr(package, "__path__", [*package.__path__, str(folder)])
    ll.analysis.__loader__.exec_module(ll.analysis)  # it looks again for what it holds
    forget()
    yield
    for package, names in {
        ll.analysis: ("swings", "swing_time"),
        pictures: ("swing_time",),
    }.items():
        for name in names:
            sys.modules.pop(f"{package.__name__}.{name}", None)
            vars(package).pop(name, None)


def test_python_finds_and_draws_it():
    found = ll.analysis.swing_time(ll.Pendulum(length=1.0, mass=0.8), largest_angle=2.0, swings=3)
    # T = T0 (1 + a^2/16 + 11 a^4/3072 + ...), Lagrange (1788).
    slow = math.tau / math.sqrt(9.8)
    for a, time in zip(found.largest_angle.values, found.swing_time.values, strict=True):
        assert time == pytest.approx(slow * (1.0 + a**2 / 16.0 + 11.0 * a**4 / 3072.0), rel=2e-2)
    assert ll.plot(found).axes[0].get_ylabel().startswith("time of a swing")


@pytest.mark.parametrize(
    "options, message",
    [
        ({"largest_angle": -1.0}, r"largest_angle must lie in \(0, inf\) rad, got -1"),
        ({"swings": 0}, "swings must lie in"),
        ({"swings": 2.5}, "swings must be a whole number"),
        ({"swings": None}, "swings must be a whole number"),
    ],
)
def test_its_arguments_are_checked_by_their_annotations(options, message):
    with pytest.raises(InputError, match=message):
        ll.analysis.swing_time(ll.Pendulum(length=1.0, mass=0.8), **options)


def test_the_command_line_asks_it(tmp_path):
    options = [word for name, text in PENDULUM.items() for word in (f"--{name}", text)]
    words = ["analyse", "swing_time", *options, "--largest-angle", "90 deg", "--swings", "2"]
    result = CliRunner().invoke(command_line, [*words, "--plot", str(tmp_path / "a.png"), "--json"])
    assert result.exit_code == 0, result.output
    times = json.loads(result.stdout)["variables"]["swing_time"]["values"]
    # 2 K(sin 45 degrees)/pi, to six digits
    assert times[1] == pytest.approx(1.180341 * math.tau / math.sqrt(9.8), rel=1e-6)
    assert (tmp_path / "a.png").exists()


def test_the_app_has_its_form_and_its_result(tmp_path):
    form = forms()["swing_time"]
    assert form["title"] == "Swing time"
    assert form["options"]["swings"]["label"] == "Swings"
    assert form["first"] == ["largest_angle", "swings"]
    about = about_request(RunRequest.from_json(ASKED))
    request = {**ASKED, "analysis": "swing_time", "settings": about["first"]["swing_time"]}
    assert compute(request, tmp_path, print)[0]["lines"]
    assert (tmp_path / "result.png").exists()
