"""Every command that README and documentation show, typed as it stands there."""

import itertools
import os
import re
import shlex
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest

from materials import MAKERS, provide

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")),
         *sorted((ROOT / "docs").glob("*/*.md"))]  # fmt: skip
# Options whose file is written; one that is there already may belong to something else.
WRITTEN = ("--output", "--store", "--plot", "--truth", "--report", "--animate")
READ_TOO = ("--from", "--status", "--verify")


def short(words):
    """Return a command; a report is of another paper, since tests/paper computes all of the one."""
    if words[1] == "reproduce":
        return [*words[:2], "--quick", "--paper", "other_paper", "--output", "report"]
    if words[1] == "site":  # else it makes the same report again
        return [*words, "--report", "report"]
    return words


def commands():
    """Yield each command of the documentation once, with the first page that shows it."""
    seen = set()
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for block in re.findall(r"```console\n(.*?)```", text, re.S):
            for line in block.replace("\\\n", " ").splitlines():
                if line.startswith("$ latolato"):
                    words = short(shlex.split(line.removeprefix("$ "), comments=True))
                    if tuple(words) not in seen:
                        seen.add(tuple(words))
                        yield pytest.param(words, id=f"{page.stem}: {' '.join(words)[:60]}")


COMMANDS = list(commands())


@pytest.fixture(scope="session")
def cache(tmp_path_factory):
    """Where files that commands work on are kept."""
    return tmp_path_factory.mktemp("materials")


def named(words):
    """Return which materials a command reads."""
    kept = {re.split(r"[:/]", word)[0] for word in words if not word.startswith("--")}
    kept |= {word.split("=", 1)[1].split(":")[0] for word in words if "=" in word}
    flags = dict(itertools.pairwise(words))
    read = {flags[flag] for flag in READ_TOO if flag in flags}
    written = {flags[flag] for flag in WRITTEN if flag in flags}
    if words[1] in ("app", "site"):  # they read what others write
        written = set()
    return [name for name in MAKERS if name in kept and (name not in written or name in read)]


def serve(words, folder):
    """Start the application, ask for its page, and stop it."""
    command = [*words, "--no-browser", "--port", "0"]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as server:
        try:
            line = server.stdout.readline()
            page = urllib.request.urlopen(line.split(" at ")[1].strip()).read()
        finally:
            server.send_signal(signal.SIGINT)
    assert b"latolato" in page
    return line


@pytest.mark.parametrize("words", COMMANDS)
def test_command(words, tmp_path, cache, answer):
    for name in named(words):
        provide(name, tmp_path, cache)
    # Patterns are expanded by a shell.
    words = [path for word in words[1:]
             for path in (sorted(str(p.relative_to(tmp_path)) for p in tmp_path.glob(word))
                          if "*" in word and "=" not in word else [word])]  # fmt: skip
    command = [sys.executable, "-m", "latolato", *words]
    if words[0] == "app":
        answer(serve(command, tmp_path))
        return
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, encoding="utf-8", check=False,
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
    )  # fmt: skip
    assert "Traceback" not in done.stderr, done.stderr
    assert done.returncode == 0, done.stderr
    answer(done.stdout)
    flags = dict(itertools.pairwise(words))
    for flag in WRITTEN:
        if flag in flags and "{" not in flags[flag]:
            assert (tmp_path / flags[flag]).exists(), f"{flag} {flags[flag]} was not written"


def test_make_measure(tmp_path, answer):
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    recipe = re.search(r"^measure:.*\n((?:\t.*\n)+)", makefile, re.M)[1].replace("\\\n", " ")
    (tmp_path / "measured").mkdir()
    for line in re.findall(r"\$\(BIN\)/latolato (.*)", recipe):
        done = subprocess.run([sys.executable, "-m", "latolato", *shlex.split(line)], cwd=tmp_path,
                              capture_output=True, text=True, encoding="utf-8", check=False,
                              env={**os.environ, "PYTHONIOENCODING": "utf-8"})  # fmt: skip
        assert done.returncode == 0, done.stderr
    filmed = float(re.search(r"--damping (\S+)", recipe)[1])
    damping, sigma = map(float, re.search(r"^damping +(\S+) ± (\S+)", done.stdout, re.M).groups())
    answer(f"C = {damping} ± {sigma} kg m/s, filmed with {filmed}")
    assert abs(damping - filmed) < 3.0 * sigma
    written = {path.name for path in (tmp_path / "measured").iterdir()}
    assert {"swing.mp4", "swing.csv", "swing.html", "fit.png"} <= written


def test_the_documentation_shows_commands():
    assert len(COMMANDS) >= 40
