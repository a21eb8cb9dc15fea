"""The paper's figures, one module ``figNN`` each, found by name."""
