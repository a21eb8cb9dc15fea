"""`latolato site`: the pages as files that any web space can serve, without a server that computes.

Toy and Map compute in the page. What the server of `latolato app` answers once is written to
a file: what there is (``registry.json``). The report on the paper is a page of its own.
"""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from errno import ENOTDIR
from pathlib import Path

from latolato.app import STATIC, kernels_folder
from latolato.app.forms import registry
from latolato.app.stories import checked_contents, contents
from latolato.core.errors import InputError

# A browser keeps the pages at the first visit, the report and the documentation as they are read.
OFFLINE = "offline.js"
_LATER = ("report", "docs")
# Folders of the views that need Python beside the page: a site says so in their place.
_NEED_PROGRAM = ("measure", "analyse")
_DESCRIPTIONS = re.compile(r"/\*\*.*?\*/\n?|^ *//[^\n]*\n", re.DOTALL | re.MULTILINE)


def write_site(folder: Path, *, report: Path | None = None, docs: Path | None = None) -> list[Path]:
    """Write the pages into a folder; return the files.

    Parameters
    ----------
    folder : Path
        It may exist, also with an earlier site; other files in it stay.
    report : Path, optional
        Folder of a report that `latolato reproduce` wrote; without it pages say how to make one.
    docs : Path, optional
        Folder of the built documentation.

    Raises
    ------
    InputError
        If `report` holds no report, or `docs` no pages, or a story file is wrong.
    NotADirectoryError
        If `folder` is a file.
    FileNotFoundError
        If the code for pages has not been compiled.
    """
    check_site(folder, report=report, docs=docs)
    # Types of vendored libraries are for those who check the sources, and some views need Python.
    left_out = shutil.ignore_patterns("*.d.ts", *_NEED_PROGRAM)
    shutil.copytree(STATIC, folder, dirs_exist_ok=True, ignore=left_out, copy_function=_copy)
    # Those of a teacher, who has put files into the folder of an earlier site, are among them.
    (folder / "stories" / "contents.json").write_text(
        _compact(checked_contents(folder / "stories")), encoding="utf-8"
    )
    for name, source in (("report", report), ("docs", docs)):
        if source is not None and source.resolve() != (folder / name).resolve():
            shutil.copytree(source, folder / name, dirs_exist_ok=True)
    has_report = (folder / "report" / "index.html").is_file()
    about = registry() | {"server": False, "docs": docs is not None, "report": has_report}
    (folder / "registry.json").write_text(_compact(about), encoding="utf-8")
    _write_offline(folder)
    return sorted(path for path in folder.rglob("*") if path.is_file())


def check_site(folder: Path, *, report: Path | None = None, docs: Path | None = None) -> None:
    """Raise what `write_site` would raise; making a report first takes a minute."""
    if report is not None and not (report / "index.html").is_file():
        raise InputError(
            f"'{report}' contains no report",
            way_out=f"make one: latolato reproduce --output {report}",
        )
    if docs is not None and not (docs / "index.html").is_file():
        raise InputError(f"'{docs}' contains no documentation", way_out="make it: make docs")
    kernels_folder()
    if folder.is_file():
        raise NotADirectoryError(ENOTDIR, "a site needs a folder, but this is a file", str(folder))
    contents(folder / "stories")


def _copy(source: str, target: str) -> None:
    """Copy a file of the pages; a module goes without its descriptions, a quarter of its size.

    JSON goes without the blanks that make it readable.
    """
    path = Path(source)
    if path.is_relative_to(STATIC / "js"):
        text = without_descriptions(path.read_text(encoding="utf-8"))
        Path(target).write_text(text, encoding="utf-8")
    elif path.suffix == ".json":
        text = _compact(json.loads(path.read_text(encoding="utf-8")))
        Path(target).write_text(text, encoding="utf-8")
    else:
        shutil.copy2(source, target)


def without_descriptions(source: str) -> str:
    """Return a module without descriptions and lines of comments: browsers need neither."""
    return _DESCRIPTIONS.sub("", source)


def _compact(value: object) -> str:
    """Return a value as JSON without blanks."""
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


def _write_offline(folder: Path) -> None:
    """Write the list of files that a browser keeps, under a name that changes with them."""
    paths = [path.relative_to(folder) for path in folder.rglob("*") if path.is_file()]
    left_out = (OFFLINE, "files.js")
    kept = sorted(
        path.as_posix()
        for path in paths
        if path.parts[0] not in _LATER and path.as_posix() not in left_out
    )
    digest = hashlib.sha256()
    for name in kept:
        digest.update(name.encode() + (folder / name).read_bytes())
    about = {"version": digest.hexdigest()[:16], "paths": kept}
    (folder / "files.js").write_text(f"self.SITE = {json.dumps(about)};\n", encoding="utf-8")
