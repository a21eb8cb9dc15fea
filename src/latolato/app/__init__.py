"""The web application: a local server that computes, and pages that draw."""

from pathlib import Path

STATIC = Path(__file__).parent / "static"
# Bifurcation curves over the maps of scenarios: `tests/shared/shipped_curves.py` writes them.
CURVES = STATIC / "curves"


def kernels_folder() -> Path:
    """Return the folder of the pages' compiled code.

    Raises
    ------
    FileNotFoundError
        If the code has not been compiled.
    """
    folder = STATIC / "kernels"
    if not (folder / "layout.json").is_file():
        raise FileNotFoundError(
            "the pages' compiled code is missing; in a clone, run: make kernels"
        )
    return folder
