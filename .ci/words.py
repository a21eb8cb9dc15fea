"""Refuse phrases that sound translated, in every tracked text but tests and vendored code.

`words.py` checks the repository, `words.py FILE...` these files.
"""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
SUFFIXES = {".md", ".py", ".js", ".html", ".json", ".toml", ".cff"}
SKIPPED = re.compile(r"^(tests/|\.ci/words\.py)|/vendor/")
# A pattern, where an underscore is a space or the end of a line, and what to write instead.
PHRASES = {
    r"(?:is|are|was|were)_told(?!_apart|_from)": "shows, reports, says",
    r"(?:says?|said)_of": "says about",
    r"tells?_of": "reports, mentions",
    r"(?:says?|said)_beside": "explains next to",
    r"parts_from": "diverges from",
    r"anew": "again",
    r"what_is_left(?!_out)": "what remains, the rest",
    r"stands?_in_the_way": "prevents",
    r"knows?_of": "knows about",
    r"asks?_it": "asks the question, waits for",
    r"(?:that|why|what)(?:_\w+)?(?:_\w+)?_cannot_be(?=[.,:;)])": "invalid values",
    r"of_what_(?:takes|comes)": "the subject first: slower questions show an estimate",
    r"\d+%(?=[.:]|[,)]?\s+[a-z])": "a space before the sign: 51 %",
}
# The end of a line, with what begins or ends lines of comments, strings and quotations.
GAP = r"(?:\s|#|\*|//|[\"'`>+])+"
_EACH = {
    re.compile(rf"(?<![\w.]){words.replace('_', GAP)}(?!\w)", re.IGNORECASE): better
    for words, better in PHRASES.items()
}


def faults(path: Path) -> list[str]:
    """Return file, line, phrase and a better one for each fault of a file."""
    text = path.read_text("utf-8")
    found = [(match, better) for each, better in _EACH.items() for match in each.finditer(text)]
    return [
        f"{path}:{text.count(chr(10), 0, match.start()) + 1}: "
        f"'{re.sub(GAP, ' ', match[0])}'; better: {better}"
        for match, better in sorted(found, key=lambda each: each[0].start())
    ]


def main(names: list[str]) -> str | None:
    """Return the faults of these files, or of the repository."""
    if not names:
        listed = subprocess.run(
            ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True
        ).stdout.split("\0")
        names = [name for name in listed if not SKIPPED.search(name)]
    paths = [ROOT / name for name in names if Path(name).suffix in SUFFIXES]
    return "\n".join(fault for path in paths if path.exists() for fault in faults(path)) or None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
