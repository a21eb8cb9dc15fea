"""Check that names of pages mean one thing, and that modules import only what lies below them.

Kernels lie below the model, which lies below what views share: `page` (fields, links, messages)
below `player` (stage, curves, sound). Views import no other views.

Imports of types, which stand in comments, are not followed. A function, class or type has a name
that no other module gives to something of its own, and so has a file, apart from the view of each
folder.
"""

import re
import sys
from collections import Counter
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[1] / "src" / "latolato" / "app" / "static" / "js"
SHARED = {"", "kernels", "model", "page", "player"}
BELOW = {"kernels": set(), "model": {"kernels"}, "page": SHARED - {"player"}}
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_NAMED = re.compile(r"^(?:export )?(?:async )?(?:function|class) (\w+)", re.MULTILINE)
_IMPORT = re.compile(r'(?:\bfrom |\bimport\()"(\.[^"]+)"')


def main() -> str | None:
    """Return what is wrong."""
    texts = {path: path.read_text("utf-8") for path in ROOT.resolve().rglob("*.js")}
    named = [name for text in texts.values() for name in {*_NAMED.findall(text), *_types(text)}]
    named += [path.name for path in texts if path.name != "view.js"]
    if repeated := [name for name, count in Counter(named).items() if count > 1]:
        return "more than one meaning: " + ", ".join(sorted(repeated))
    imports = {
        path: {
            (path.parent / target).resolve() for target in _IMPORT.findall(_COMMENT.sub("", text))
        }
        for path, text in texts.items()
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


def _types(text: str) -> list[str]:
    """Return the names of the types that a module makes, not of those that it imports."""
    made = []
    for match in re.finditer(r"@typedef (?=\{)", text):
        depth = 0
        for end in range(match.end(), len(text)):
            depth += {"{": 1, "}": -1}.get(text[end], 0)
            if depth == 0:
                break
        is_imported = re.fullmatch(r"\{import\([^)]*\)\.\w+", text[match.end() : end])
        if name := re.match(r"\} (\w+)", text[end:]):
            made += [] if is_imported else [name[1]]
    return made


def _name(path: Path) -> str:
    return path.relative_to(ROOT.resolve()).as_posix()


def _folder(path: Path) -> str:
    return _name(path).rpartition("/")[0]


if __name__ == "__main__":
    sys.exit(main())
