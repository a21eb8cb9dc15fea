"""Vendored files are the ones that are listed."""

import hashlib
import re

from latolato.app import STATIC

EXPORT = b"export default uPlot;\n"
LISTED = re.compile(r"\| `(?P<file>[\w./-]+)` .*`(?P<sum>[0-9a-f]{64})` \|")


def test_every_vendored_script_is_listed_with_its_checksum():
    folder = STATIC / "vendor"
    listed = dict(LISTED.findall((folder / "README.md").read_text(encoding="utf-8")))
    scripts = (p for p in folder.rglob("*") if p.suffix in (".js", ".css", ".ts"))
    present = {p.relative_to(folder).as_posix() for p in scripts}
    assert present == set(listed)
    for name, known in listed.items():
        copy = (folder / name).read_bytes().removesuffix(EXPORT)
        assert hashlib.sha256(copy).hexdigest() == known
