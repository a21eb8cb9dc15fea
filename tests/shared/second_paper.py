"""The second paper of CONTRIBUTING.md, word for word: a package with one figure and its claim."""

import re
from pathlib import Path

TEXT = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text(encoding="utf-8")
_BLOCKS = re.findall(r"```\w+\n(.*?)```", TEXT, re.DOTALL)
CODE, CLAIM = (block for block in _BLOCKS if "Fig. 14" in block)
_ABOUT = next(block for block in _BLOCKS if "CONVENTIONS" in block)


def write_second_paper(folder):
    """Write the package into a new folder, whose name is its own."""
    folder.mkdir()
    files = {"__init__.py": "", "about.py": _ABOUT, "fig14.py": CODE, "claims.toml": CLAIM}
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
