"""The paper's figures, a module ``figNN`` each, its claims, and pictures of results."""
