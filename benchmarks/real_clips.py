"""Tracks clips published by others, with good and bad clicks, and prints the results.

    python benchmarks/real_clips.py CLONES [TABLE]

`CLONES` holds clones of the repositories in ``real_clips.toml`` as ``owner+name``, ``owner/name``
or ``name``. Missing clips are left out. For each case it prints the share of ok samples, whether
this is as expected, and the processor time. The exit code is 1 if a case does not end as expected,
as by a crash. The last line counts the clips in which a ball can be followed, and those of them in
which it is without a click, about the pivot that others click.

`TABLE` is a Markdown file to write. For each track it lists the period, or the arm if there is no
period, from the whole clip and from its halves, which should agree. If the pivot is known, this is
the period of small swings; otherwise it is that of the actual swings, which falls with the
amplitude. The arm's error is that of its mean alone.
"""

from __future__ import annotations

import math
import subprocess
import sys
import tempfile
import time
import tomllib
import traceback
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import latolato as ll
from latolato.core.errors import InputError
from latolato.experiment.period import period_of
from latolato.experiment.quality import circle_distances

# Share of samples that may be ok where the ball is not followed, and that must be where it is.
_FEW, _MANY = 0.05, 0.6
# How far what is found may be from what others click, as a share of the arm.
_OFF = 0.06
_HEAD = "clip|pointed at|ok|geometry|whole clip|first half|second half|halves differ by"


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


def _outcome(path: Path, case: dict[str, Any]) -> tuple[float, str, Any]:
    """Return the share of samples that are ok, the reason or the warnings, and the track table.

    The share is NaN after a crash, which is neither as expected nor a reason to stop.
    """
    given = {name: value for name, value in case.items() if name not in ("name", "expected")}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            table = ll.track(path, **given)
    except InputError as error:
        return 0.0, f"refused: {error}".replace(f"{path}: ", ""), None
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(where.filename).name}:{where.lineno}"
        return math.nan, f"crashed at {place}: {type(error).__name__}: {error}", None
    return float((table.flag_1 == "ok").mean()), str(table.attrs.get("warnings", "")), table


def _off(table: Any, clip: dict[str, Any]) -> float:
    """Return how far pivot and balls that were found are from those clicked in a clip.

    1 is as far as they may be. Balls count only if they are clicked in the same frame. NaN if
    there is no pivot although others click one.
    """
    cases = [case for case in clip["case"] if case["expected"] != "refused"]
    pivots = [case["pivot"] for case in cases if case.get("pivot", "outside") != "outside"]
    pivots = [place for each in pivots for place in (each if isinstance(each[0], list) else [each])]
    number = table.attrs["click_frame"]
    balls = [case.get("balls", []) for case in cases if case.get("click_frame", 0) == number]
    balls = [place for each in balls for place in each]
    off = [0.0]
    sizes = _OFF * table.attrs.get("arm_pixels", math.nan), table.attrs["radius_pixels"]
    for name, places, size in zip(("pivot", "ball_1"), (pivots, balls), sizes, strict=True):
        for own in (name, name.replace("_1", "") + "_2"):
            at = [table.attrs.get(f"{own}_pixel_{axis}", math.nan) for axis in "uv"]
            if places and (own == name or math.isfinite(at[0])):
                off.append(min(math.dist(at, place) for place in places) / size)
    return float(np.max(off))


def _period(table: Any) -> tuple[float, float]:
    """Return the period and its standard deviation [s], NaN for none."""
    if table.attrs["geometry"] == "unknown":
        places = np.column_stack([table.ball_1_u, table.ball_1_v])
        places[table.flag_1.values != "ok"] = math.nan
        return period_of(table.time.values, places)
    try:
        fit = ll.fit_decay(table, method="equation", compare=False, profile=False)
    except InputError:
        return math.nan, math.nan
    frequency = fit.estimates["natural_frequency"]
    return math.tau / frequency.value, math.tau * frequency.sigma / frequency.value**2


def _arm(table: Any) -> tuple[float, float]:
    """Return the arm and the standard error of its mean [pixels], NaN without a pivot."""
    ok = table.flag_1.values == "ok"
    if table.attrs["geometry"] == "unknown" or not ok.any():
        return math.nan, math.nan
    distances = circle_distances(table, 1)[ok] / table.attrs.get("metres_per_pixel", 1.0)
    arm = table.attrs["arm_pixels"] + float(np.mean(distances))
    return arm, float(np.std(distances)) / math.sqrt(ok.sum())


def _halves(table: Any) -> list[str]:
    """Return period or arm of the whole clip and of its halves, and by how much these differ."""
    is_late = (table.time > 0.5 * (table.time[0] + table.time[-1])).values
    parts = [table, table.isel(frame=~is_late), table.isel(frame=is_late)]
    measures = (_period, "s"), (_arm, "pixels")
    measured = [([measure(part) for part in parts], unit) for measure, unit in measures]
    pairs, unit = max(measured, key=lambda each: int(np.isfinite(each[0]).sum()))
    texts = [f"{value:.5g} ± {sigma:.2g} {unit}" for value, sigma in pairs]
    apart = abs(pairs[1][0] - pairs[2][0]) / math.hypot(pairs[1][1], pairs[2][1])
    return ["-" if "nan" in text else text for text in (*texts, f"{apart:.1f} sigma")]


def main() -> int:
    """Track every case whose clip is there."""
    if len(sys.argv) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 2
    clips = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))["clip"]
    followed: dict[str, bool] = {}
    failed, rows = 0, [_HEAD, "|".join("-" * len(_HEAD.split("|")))]
    with tempfile.TemporaryDirectory() as folder:
        for number, clip in enumerate(clips):
            content = _content(Path(sys.argv[1]), clip)
            print(f"{clip['repository']} {clip['file']}{'' if content else ': not there'}")
            if content is None:
                continue
            path = Path(folder) / f"{number}{Path(clip['file']).suffix}"
            path.write_bytes(content)
            for case in clip["case"]:
                began = time.process_time()
                share, text, table = _outcome(path, case)
                spent = time.process_time() - began
                outcomes = {"followed": share > _MANY, "refused": share < _FEW}
                is_good = outcomes.get(case["expected"], any(outcomes.values()))
                if "nothing clicked" in case["name"]:
                    off = math.nan if table is None else _off(table, clip)
                    is_good &= not (outcomes["followed"] and off > 1.0)
                    if any(one["expected"] != "refused" for one in clip["case"]):
                        followed[path.name] = outcomes["followed"] and off <= 1.0
                failed += not is_good
                verdict = "as expected" if is_good else "WRONG"
                print(f"  {case['name']:38} {100 * share:4.0f} % ok  {verdict:12} "
                      f"{spent:4.0f} s  {text}")  # fmt: skip
                sys.stdout.flush()
                if table is not None and len(sys.argv) == 3:
                    clicks = [str(case[name]) for name in ("pivot", "balls") if name in case]
                    about = f"{100 * share:.0f} %", table.attrs["geometry"]
                    cells = " ".join([case["name"], *clicks]), *about, *_halves(table)
                    rows.append("|".join([f"{clip['repository']} {clip['file']}", *cells]))
    if len(sys.argv) == 3:
        Path(sys.argv[2]).write_text("".join(f"|{row}|\n" for row in rows), "utf-8")
    print(f"followed without a click: {sum(followed.values())} of {len(followed)} clips")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
