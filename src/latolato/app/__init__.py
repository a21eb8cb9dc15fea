"""The web application: a local server that computes, and pages that draw."""
