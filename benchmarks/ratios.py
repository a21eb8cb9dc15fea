"""The memory of the benchmarks: a file a day and device, README's table and the page's picture.

A benchmark times latolato and a peer in turns and calls `record`. Times depend on the machine and
on what else it does; the ratio of two times taken in turns depends on them much less, so only
ratios are compared between machines.

``python benchmarks/ratios.py`` writes the table of the newest file into README.
"""

from __future__ import annotations

import itertools
import json
import math
import platform
import re
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from datetime import date, timedelta
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from latolato.figures import style
from latolato.numerics.shipped import this_processor

ROOT = Path(__file__).resolve().parents[1]
HISTORY = Path(__file__).with_name("history")
# What may change a time: the package, and what is measured.
MEASURED = ("src", "benchmarks/*.py")
# Peers that are other programs, as README names them; the other peers are latolato itself.
PROGRAMS = ("heyoka", "SciPy")
# Vector instructions that a machine may have, in the words of LLVM.
VECTORS = ("avx2", "avx512f", "neon", "sve")
# Of the picture: panels in a row, and time before the first and after the last measurement.
COLUMNS, MARGIN = 3, timedelta(days=20)
MARKED = re.compile(
    r"(?<=<!-- speed: `make bench` writes what follows -->\n).*(?=<!-- speed ends -->)", re.DOTALL
)


def least_times(*actions: Callable[[], Any], turns: int = 5) -> list[float]:
    """Return the least CPU time of each action [s].

    Parameters
    ----------
    actions : callable
        They take turns, so that what slows the machine down slows all of them.
    turns : int
        Calls of each action, at least two: the first may compile.
    """
    least = [math.inf] * len(actions)
    for _ in range(turns):
        for k, action in enumerate(actions):
            begin = time.process_time()
            action()
            least[k] = min(least[k], time.process_time() - begin)
    return least


def time_at(error: float, runs: Sequence[tuple[float, float]]) -> float:
    """Return the time that reaches an error, between the logarithms of neighbouring runs [s].

    Parameters
    ----------
    error : float
        The error [rad]. A looser one than all runs have takes the time of the loosest run.
    runs : sequence of (float, float)
        Time [s] and error [rad] of runs at several tolerances.

    Raises
    ------
    ValueError
        No run reaches the error.
    """
    errors, times = np.log(sorted((error, time) for time, error in runs)).T
    if math.log(error) < errors[0]:
        raise ValueError(f"no run reaches the error {error:g} rad: give a smaller tolerance")
    return float(np.exp(np.interp(math.log(error), errors, times)))


def _commit() -> str:
    """Return the commit of what is measured, and whether it was edited since."""
    edited = " edited" if _git("status", "--porcelain") else ""
    return _git("log", "-1", "--format=%h").strip() + edited


def _git(*words: str) -> str:
    """Return what git prints about what is measured."""
    command = ["git", *words, "--", *MEASURED]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout


def _machine() -> dict[str, Any]:
    """Return the date, the machine, and what it runs."""
    known, processor = Path("/proc/cpuinfo"), this_processor()
    named = re.search(r"model name\s*: (.+)", known.read_text("utf-8")) if known.exists() else None
    name = named[1] if named else platform.processor() or platform.machine()
    return {
        "date": date.today().isoformat(),
        "device": f"{name} ({processor.name})",
        "vectors": [name for name in VECTORS if f"+{name}" in processor.features.split(",")],
        "python": platform.python_version(),
        "versions": {name: version(name) for name in ("NumPy", "numba", *PROGRAMS)},
    }


def record(work: str, meaning: str, own: float, peers: dict[str, float]) -> None:
    """Add a comparison to today's file of this device, and print it.

    Parameters
    ----------
    work : str
        Name of the work. It must stay the same: the history of a ratio is found by it.
    meaning : str
        What is computed and timed, in a phrase.
    own : float
        Time of latolato [s].
    peers : dict of float
        Times of the peers for the same work [s], by their names. A ratio is how many times as long
        the peer takes.

    Notes
    -----
    Measured again on the same day, a work replaces itself.
    """
    machine = _machine()
    slug = re.sub(r"[^a-z0-9]+", "-", machine["device"].lower()).strip("-")
    path = HISTORY / f"{machine['date']}-{slug}.json"
    ratios = json.loads(path.read_text("utf-8"))["ratios"] if path.exists() else {}
    ratios[work] = {
        "meaning": meaning,
        "commit": _commit(),
        "ms": _rounded(1e3 * own),
        "peers": {
            peer: {"ms": _rounded(1e3 * seconds), "ratio": _rounded(seconds / own)}
            for peer, seconds in peers.items()
        },
    }
    for peer, compared in ratios[work]["peers"].items():
        print(f"{work}: {1e3 * own:.3g} ms; {peer} takes {compared['ratio']:g} times as long")
    HISTORY.mkdir(exist_ok=True)
    text = json.dumps(machine | {"ratios": ratios}, indent=1, ensure_ascii=False)
    path.write_text(text + "\n", "utf-8")


def _rounded(value: float) -> float:
    """Return a number with three digits."""
    return float(f"{value:.3g}")


def history() -> list[dict[str, Any]]:
    """Return what was measured, oldest first."""
    return [json.loads(path.read_text("utf-8")) for path in sorted(HISTORY.glob("*.json"))]


def machine_of(measured: dict[str, Any]) -> str:
    """Return the device of a file, with its vector instructions."""
    vectors = (name.upper() for name in measured["vectors"])
    return f"{measured['device']}, {' and '.join(vectors)}"


def readme_table(measured: dict[str, Any]) -> str:
    """Return README's table: times of latolato and of other programs, and their ratios."""
    lines = [
        f"*{machine_of(measured)}, {measured['date']}; in brackets, how many times as long the "
        "program takes:*\n\n",
        f"| | latolato | {' | '.join(PROGRAMS)} |\n|---|---|{'---|' * len(PROGRAMS)}\n",
    ]
    for work, compared in measured["ratios"].items():
        cells = [
            f"{peer['ms']:g} ms ({peer['ratio']:g})" if peer else ""
            for peer in map(compared["peers"].get, PROGRAMS)
        ]
        if any(cells):
            lines.append(f"| {work} | {compared['ms']:g} ms | {' | '.join(cells)} |\n")
    return "".join(lines)


def page_table(measured: dict[str, Any]) -> str:
    """Return the page's table: every ratio and what it compares."""
    programs = ", ".join(f"{name} {number}" for name, number in measured["versions"].items())
    lines = [
        f"{machine_of(measured)}, {measured['date']}, Python {measured['python']}, {programs}:\n\n",
        "| work | latolato | peer | takes | ratio | commit |\n|---|---|---|---|---|---|\n",
    ]
    for work, peer, compared in _each(measured):
        about = measured["ratios"][work]
        lines.append(
            f"| **{work}**: {about['meaning']} | {about['ms']:g} ms | {peer} "
            f"| {compared['ms']:g} ms | {compared['ratio']:g} | {about['commit']} |\n"
        )
    return "".join(lines)


def _each(measured: dict[str, Any]) -> Iterator[tuple[str, str, dict[str, float]]]:
    """Yield work, peer and times of each comparison."""
    for work, about in measured["ratios"].items():
        for peer, compared in about["peers"].items():
            yield work, peer, compared


def draw(path: Path) -> None:
    """Draw the history of each ratio, one panel a ratio and one colour a machine."""
    from matplotlib.dates import AutoDateLocator, ConciseDateFormatter

    kept = history()
    colours = dict(zip(map(machine_of, kept), itertools.cycle(style.COLOURS), strict=False))
    days = [date.fromisoformat(each["date"]) for each in kept]
    # By work and peer, then by machine.
    lines: dict[tuple[str, str], dict[str, list[tuple[date, float]]]] = {}
    for day, each in zip(days, kept, strict=True):
        for work, peer, compared in _each(each):
            by_machine = lines.setdefault((work, peer), {})
            by_machine.setdefault(machine_of(each), []).append((day, compared["ratio"]))
    with style.use_style():
        figure, panels = style.new_figure(math.ceil(len(lines) / COLUMNS), COLUMNS, sharex=True)
        for panel in panels.flat[len(lines) :]:
            panel.set_visible(False)
        for panel, ((work, peer), by_machine) in zip(panels.flat, lines.items(), strict=False):
            panel.set_title(f"{work}\nbeside {peer}", fontsize=style.SMALL)
            for machine, points in by_machine.items():
                panel.plot(*zip(*points, strict=True), "o-", color=colours[machine])
            panel.set_ylim(0.0, 1.2 * panel.dataLim.y1)
            dates = AutoDateLocator(minticks=2, maxticks=4)
            panel.xaxis.set_major_locator(dates)
            panel.xaxis.set_major_formatter(ConciseDateFormatter(dates))
        panels[0, 0].set_xlim(days[0] - MARGIN, days[-1] + MARGIN)
        swatches = [style.swatch(colour, machine) for machine, colour in colours.items()]
        figure.legend(handles=swatches, loc="outside upper right")
    style.save_figure(figure, path)


def main() -> None:
    """Write README's table."""
    path = ROOT / "README.md"
    text, places = MARKED.subn(lambda _: readme_table(history()[-1]), path.read_text("utf-8"))
    if places != 1:
        raise ValueError(f"README.md has {places} places for the table of speeds instead of one")
    path.write_text(text, "utf-8")


if __name__ == "__main__":
    main()
