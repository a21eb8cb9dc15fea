"""Where the files of the pages lie."""

from importlib.resources import files
from pathlib import Path

STATIC = Path(str(files("latolato.app") / "static"))
