"""The steps of CONTRIBUTING.md for a new figure, followed word for word."""

import importlib
import sys

import pytest
from typer.testing import CliRunner

import latolato.paper
from latolato.cli.main import app
from latolato.cli.reproduce import reproduce
from latolato.core.errors import InputError
from latolato.figures import style
from latolato.paper import catalogue
from latolato.paper.claim import Verdict
from second_paper import CLAIM, CODE, write_second_paper


@pytest.fixture
def figure(tmp_path, monkeypatch):
    """The figure of CONTRIBUTING.md, in a folder beside the others, and its claim behind theirs."""
    (tmp_path / "fig14.py").write_text(CODE, encoding="utf-8")
    (tmp_path / "claims.toml").write_text(
        catalogue.claims_of(latolato.paper).read_text(encoding="utf-8") + CLAIM, encoding="utf-8"
    )
    monkeypatch.setattr(latolato.paper, "__path__", [*latolato.paper.__path__, str(tmp_path)])
    monkeypatch.setattr(catalogue, "claims_of", lambda paper: tmp_path / "claims.toml")
    importlib.invalidate_caches()
    yield catalogue.figures()["fig14"]
    del sys.modules["latolato.paper.fig14"], latolato.paper.fig14


def test_a_figure_in_one_file_and_its_claim_are_discovered_computed_drawn_and_judged(
    figure, tmp_path
):
    dataset = figure.data(quick=True)
    assert dataset.attrs["title"] == figure.title
    relative = dataset.energy_residual / dataset.largest_energy
    assert relative.max() <= 1e-9  # the project's bound
    path = style.save_figure(figure.draw(dataset), tmp_path / "fig14.png", dpi=60)
    assert path.stat().st_size > 1000
    (claim,) = figure.judge(dataset)
    assert claim.verdict is Verdict.REPRODUCED
    assert claim.finding == "The pendulum of Fig. 14 swings up to 0.100 rad."
    assert claim.criteria == (("largest angle: 0.1 rad (at most 0.1 rad)", True),)


def test_a_second_paper_is_a_package_of_its_own(tmp_path, monkeypatch):
    write_second_paper(tmp_path / "other_paper")
    monkeypatch.syspath_prepend(tmp_path)
    result = CliRunner().invoke(
        app, ["reproduce", "--quick", "--paper", "other_paper", "--output", str(tmp_path / "out")]
    )
    assert result.exit_code == 0, result.output
    page = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert "<title>Another paper, recalculated</title>" in page
    assert "never swings higher" in page
    assert "from other_paper import fig14" in page
    assert "Lato Lato" not in page.partition("<body>")[2].partition('id="cite"')[0]
    for name in [name for name in sys.modules if name.startswith("other_paper")]:
        monkeypatch.delitem(sys.modules, name)


def test_a_paper_that_does_not_exist_is_refused(tmp_path):
    with pytest.raises(InputError, match="paper must be the name of a package, got 'no_paper'"):
        reproduce(paper="no_paper", output=tmp_path / "out")
