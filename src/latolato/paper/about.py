"""What the report says about the paper as a whole.

A paper is a package with figures (see `latolato.paper.catalogue`), their claims in ``claims.toml``
and a module of this name with these texts. Figures that are made through a video, if there are any,
are in `FILMED`.
"""

from latolato.core.citation import PAPER_AUTHORS, PAPER_TITLE
from latolato.paper import chain_table

TITLE = "Parametric resonance of the Lato Lato 2.0, recalculated"
LEAD = (
    f"This report compares what {PAPER_AUTHORS[0]} and others, “{PAPER_TITLE}”, state about a "
    "driven pendulum and a colliding pair of pendulums with an accurate calculation. The program "
    "that wrote this page computed every number. Every verdict follows from the numbers and the "
    "limits shown with them."
)
CONVENTIONS = "SI units; angles from the downward vertical; g = 9.8 m/s² as in the paper."
METHOD = (
    "Runs use a symmetric splitting method of sixth order with fixed steps. Contacts are located "
    "on the solution itself, and a pair at rest stays at rest until the pivot falls faster than "
    "gravity. The residual is the largest error of E(t) - E(0) - work + losses, relative to the "
    "largest energy of the run; work and losses are separate integrals. Runs with the clamp "
    "artefact are left out, because it breaks the ledger. Growth rates, edges and thresholds of "
    "eq14 come from Hill's determinant and are checked by runs. Maps use the same method with "
    "longer steps; their tolerance is the target error of the angle for regular motion. Chaotic "
    "motion keeps its averages but not its digits."
)
FILMED = chain_table.FIGURES

# Claims that need more than single runs: where, the paper's words, and what decides them. A row
# leaves the list when a statement of its name exists.
DEFERRED = (
    (
        "fig7-fit",
        "Figs. 7, 10",
        "damping coefficients from measured decays",
        "the paper's videos (Figs. 7 and 10 here are made from synthetic ones)",
    ),
    ("fig8-measured", "Fig. 8a", "agreement with the measured curve", "the measured curve"),
    (
        "fig9-measured",
        "Fig. 9",
        "experimental boundaries match the numerical threshold",
        "the trials",
    ),
    (
        "fig11-measured",
        "Fig. 11",
        "the measured angles",
        "the trials",
    ),
    (
        "time-crystal",
        "Abstract, Conclusions",
        "a response like a discrete time crystal",
        "maps of the response period, and lifetimes under noise",
    ),
)

# Errors that change no number but confuse a reader.
ERRATA = (
    "“(eq11)” in the text on Fig. 2 and in the supplement's Nonlinear phenomena means eq14, the "
    "small-angle equation; eq11 is the impact law.",
    "The line before eq7 lacks factors of l; eq7 and eq10 are right. C has the unit kg m/s: the "
    "drag force is -Cθ', its torque -Clθ'.",
    "The excitation strength of eq15 is \N{GREEK SMALL LETTER GAMMA} = A0ω²/(2g). In the standard "
    "form above it a = (2ω0/ω)² and b = 2A0/l, which does not depend on the frequency. The signs "
    "of eq14 and eq15 agree.",
    "“Power law” in the captions of Figs. 7 and 10 means the exponential of eq13.",
    "Potential energy in Fig. 6 must be counted from the lowest point; eq2 counts it from the "
    "pivot.",
    "The conservation law of an impact is that of angular momentum about the pivot; it holds for "
    "every coefficient of restitution.",
    "Energies, works and losses of the mirror-symmetric pair are given per ball here; the pair "
    "has twice as much.",
)
