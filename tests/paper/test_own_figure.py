"""The steps of CONTRIBUTING.md for a new figure, followed word for word."""

import importlib
import re
import sys
from pathlib import Path

import pytest

import latolato.paper
from latolato.figures import style
from latolato.paper import catalogue
from latolato.paper.claim import Verdict

TEXT = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text(encoding="utf-8")


@pytest.fixture
def figure(tmp_path, monkeypatch):
    """The figure of CONTRIBUTING.md, in a folder beside the others, and its claim behind theirs."""
    blocks = re.findall(r"```\w+\n(.*?)```", TEXT, re.DOTALL)
    code, claim = (block for block in blocks if "Fig. 14" in block)
    (tmp_path / "fig14.py").write_text(code, encoding="utf-8")
    (tmp_path / "claims.toml").write_text(
        catalogue.FILE.read_text(encoding="utf-8") + claim, encoding="utf-8"
    )
    monkeypatch.setattr(latolato.paper, "__path__", [*latolato.paper.__path__, str(tmp_path)])
    monkeypatch.setattr(catalogue, "FILE", tmp_path / "claims.toml")
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
