"""Tracks clips that others published, with good and bad clicks, and prints what came of them.

    python benchmarks/real_clips.py CLONES

`CLONES` holds clones of the repositories in ``real_clips.toml`` as ``owner+name``, ``owner/name``
or ``name``. Clips that are not there are left out. The exit code is 1 if a case ends otherwise
than expected.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import tomllib
import warnings
from pathlib import Path
from typing import Any

import latolato as ll
from latolato.core.errors import InputError

# Share of samples that may be ok where the ball is not followed, and that must be where it is.
_FEW, _MANY = 0.05, 0.6


def _content(clones: Path, clip: dict[str, Any]) -> bytes | None:
    """Return a clip's file at its commit; None if it is not there."""
    owner, name = clip["repository"].split("/")
    for folder in (clones / f"{owner}+{name}" / "repo", clones / owner / name, clones / name):
        if folder.is_dir():
            place = f"{clip['commit']}:{clip['file']}"
            shown = subprocess.run(
                ["git", "-C", str(folder), "show", place], capture_output=True, check=False
            )
            if shown.returncode == 0 and shown.stdout:
                return shown.stdout
    return None


def _outcome(path: Path, case: dict[str, Any]) -> tuple[float, str]:
    """Return the share of samples that are ok, and the reason or the warnings."""
    given = {name: case[name] for name in ("pivot", "balls", "length", "radius") if name in case}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            table = ll.track(path, **given)
    except InputError as error:
        return 0.0, f"refused: {error}".replace(f"{path}: ", "")
    return float((table.flag_1 == "ok").mean()), str(table.attrs.get("warnings", ""))


def main() -> int:
    """Track every case whose clip is there."""
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    clips = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))["clip"]
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for number, clip in enumerate(clips):
            content = _content(Path(sys.argv[1]), clip)
            print(f"{clip['repository']} {clip['file']}{'' if content else ': not there'}")
            if content is None:
                continue
            path = Path(folder) / f"{number}{Path(clip['file']).suffix}"
            path.write_bytes(content)
            for case in clip["case"]:
                share, text = _outcome(path, case)
                is_good = share > _MANY if case["expected"] == "followed" else share < _FEW
                failed += not is_good
                verdict = "as expected" if is_good else "WRONG"
                print(f"  {case['name']:38} {100 * share:4.0f} % ok  {verdict:12} {text}")
                sys.stdout.flush()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
