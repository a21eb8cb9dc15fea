"""How to cite latolato and the paper it builds on."""

from __future__ import annotations

from latolato.core.versions import version_of

PAPER_TITLE = "Parametric resonance and nonlinear dynamics in a coupled double-pendulum system"
PAPER_AUTHORS = (
    "Yusheng Niu",
    "Yixian Liu",
    "Hongyan Fan",
    "Zhenqi Bai",
    "Yichi Zhang",
)
SOFTWARE_TITLE = "latolato: driven pendulums and colliding pairs of pendulums"
SOFTWARE_AUTHOR = "The latolato developers"


def cite() -> str:
    """Return how to cite latolato and the paper, followed by BibTeX entries.

    Examples
    --------
    >>> import latolato as ll
    >>> "@software{latolato" in ll.cite()
    True
    """
    release = version_of()
    authors = f"{', '.join(PAPER_AUTHORS[:-1])} and {PAPER_AUTHORS[-1]}"
    return f"""\
If you use latolato in a publication, please cite the software and the paper it builds on:

{SOFTWARE_AUTHOR}. {SOFTWARE_TITLE}, version {release}.

{authors}. {PAPER_TITLE}.

@software{{latolato,
  author  = {{{{{SOFTWARE_AUTHOR}}}}},
  title   = {{{SOFTWARE_TITLE}}},
  version = {{{release}}},
}}

@article{{niu-latolato,
  author = {{{" and ".join(PAPER_AUTHORS)}}},
  title  = {{{PAPER_TITLE}}},
}}"""
