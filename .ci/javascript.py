"""Check that pages import no module in a circle, and only what lies below a module.

Kernels lie below the model, which lies below what views share: `page` (fields, links, messages)
below `player` (stage, curves, sound). Views import no other views.

Imports of types, which stand in comments, are not followed.
"""

import re
import sys
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[1] / "src" / "latolato" / "app" / "static" / "js"
SHARED = {"", "kernels", "model", "page", "player"}
BELOW = {"kernels": set(), "model": {"kernels"}, "page": SHARED - {"player"}}
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_IMPORT = re.compile(r'(?:\bfrom |\bimport\()"(\.[^"]+)"')


def main() -> str | None:
    """Return what is wrong."""
    imports = {
        path: {
            (path.parent / target).resolve()
            for target in _IMPORT.findall(_COMMENT.sub("", path.read_text("utf-8")))
        }
        for path in ROOT.resolve().rglob("*.js")
    }
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        return "a circle of imports: " + " <- ".join(map(_name, error.args[1]))
    upward = [
        f"{_name(path)} imports {_name(target)}"
        for path, targets in imports.items()
        for target in targets & imports.keys()
        if _folder(path)
        and _folder(target) not in BELOW.get(_folder(path), SHARED) | {_folder(path)}
    ]
    return "\n".join(sorted(upward)) or None


def _name(path: Path) -> str:
    return path.relative_to(ROOT.resolve()).as_posix()


def _folder(path: Path) -> str:
    return _name(path).rpartition("/")[0]


if __name__ == "__main__":
    sys.exit(main())
