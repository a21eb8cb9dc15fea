"""The web application: a local server that computes, and pages that draw."""

from pathlib import Path

STATIC = Path(__file__).parent / "static"
