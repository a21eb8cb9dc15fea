"""Draws the packages of latolato and what they import, as the sources have it when this runs.

``python docs/layers.py FILE.svg``; the order is that of the layers in ``pyproject.toml``.
"""

from __future__ import annotations

import ast
import sys
import tomllib
from collections.abc import Iterator
from html import escape
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src" / "latolato"
_WIDTH, _ROW, _BOX, _HIGH = 860, 62, 520, 44
_LEFT = (_WIDTH - _BOX) / 2
_PAPER, _INK, _LINE, _FAINT = "#ffffff", "#1c2733", "#5b7083", "#e8eef4"


def layers() -> list[list[str]]:
    """Return the packages of each layer, from the top down."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    rows = next(each["layers"] for each in contracts if each["id"] == "layers")
    return [row.replace("|", ":").replace(" ", "").split(":") for row in rows]


def imports_of(tree: ast.AST) -> Iterator[str]:
    """Yield the packages that a module imports, but those for its types only."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        names = []
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        yield from (name.split(".")[1] for name in names if name.startswith("latolato."))
        yield from imports_of(node)


def arrows(packages: list[str]) -> dict[str, set[str]]:
    """Return what each package imports, without what follows from the rest."""
    direct: dict[str, set[str]] = {}
    for package in packages:
        files = (SOURCE / package).rglob("*.py")
        found = {name for f in files for name in imports_of(ast.parse(f.read_text("utf-8")))}
        direct[package] = (found & set(packages)) - {package}

    def below(package: str) -> set[str]:
        return direct[package].union(*(below(each) for each in direct[package]))

    return {
        package: {name for name in uses if not any(name in below(other) for other in uses - {name})}
        for package, uses in direct.items()
    }


def box(package: str, x: float, y: float, width: float) -> str:
    """Return a package as a box with its name, its size and the first line about it."""
    folder = SOURCE / package
    files = [f for kind in ("py", "js", "css") for f in folder.rglob(f"*.{kind}")]
    own = [f for f in files if "vendor" not in f.parts]
    lines = sum(len(f.read_text("utf-8").splitlines()) for f in own)
    about = ast.get_docstring(ast.parse((folder / "__init__.py").read_text("utf-8"))) or ""
    first = about.partition("\n")[0].rstrip(".")
    room = int(width / 6.4)
    first = first if len(first) <= room else f"{first[: room - 1].rstrip(' ,')}…"
    return (
        f'<rect x="{x}" y="{y}" width="{width}" height="{_HIGH}" rx="5" fill="{_FAINT}" '
        f'stroke="{_LINE}"/><text x="{x + 12}" y="{y + 18}" font-weight="bold">{package}</text>'
        f'<text x="{x + width - 12}" y="{y + 18}" text-anchor="end" fill="{_LINE}">'
        f'{lines:,} lines</text><text x="{x + 12}" y="{y + 35}" font-size="11.5">'
        f"{escape(first)}</text>"
    )


def drawing() -> str:
    """Return the picture as SVG."""
    rows = layers()
    places, boxes = {}, []
    for number, row in enumerate(rows):
        width = (_BOX - 12 * (len(row) - 1)) / len(row)
        for i, package in enumerate(row):
            x, y = _LEFT + i * (width + 12), 10 + number * _ROW
            places[package] = number, x + width / 2, y
            boxes.append(box(package, x, y, width))
    lines = []
    for package, uses in arrows([name for row in rows for name in row]).items():
        row, x, y = places[package]
        for name in uses:
            other, there, top = places[name]
            if other == row + 1:
                path = f"M{x},{y + _HIGH} L{there},{top - 3}"
            else:  # around the boxes in between
                side, sign = (_LEFT + _BOX, 1) if there > _WIDTH / 2 else (_LEFT, -1)
                out = side + sign * (18 + 9 * (other - row))
                begin, end = y + _HIGH / 2, top + _HIGH / 2
                path = f"M{side},{begin} C{out},{begin} {out},{end} {side + 3 * sign},{end}"
            lines.append(f'<path d="{path}" marker-end="url(#end)"/>')
    height = 10 + _ROW * len(rows)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" '
        f'font-family="sans-serif" font-size="13" fill="{_INK}">'
        f'<defs><marker id="end" markerWidth="7" markerHeight="7" refX="5" refY="3" orient="auto">'
        f'<path d="M0,0 L6,3 L0,6 z" fill="{_LINE}"/></marker></defs>'
        f'<rect width="{_WIDTH}" height="{height}" fill="{_PAPER}"/>'
        f'<g fill="none" stroke="{_LINE}" stroke-width="1.3">{"".join(lines)}</g>'
        f"{''.join(boxes)}</svg>"
    )


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(drawing(), encoding="utf-8")
