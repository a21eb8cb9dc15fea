"""Counts how often a decay fit notices that its model does not describe a record.

Records of random pendulums, cameras and noises, without a break (also with gaps, few samples and
absolute clocks) and with one that was planted. Of each kind: how many were doubted, and how many
numbers were given that are off by more than four of their deviations. Prints a table and writes the
figure of docs/how-to/fits.md. Run
``PYTHONPATH=tests/shared python benchmarks/fit_doubt.py [records of a kind] [first seed] [kinds]``.
"""

from __future__ import annotations

import math
import sys
import time
import warnings
from pathlib import Path

import latolato as ll
from broken_records import BROKEN, WHOLE, make_record

# Deviations beyond which a number is wrong, and shares of it that nobody minds.
WRONG, SMALL = 4.0, {"length": 3e-4, "decay_rate": 0.02}
# Deviations by which a break that must be noticed moves a number.
MOVED = 3.0


def judge(kind: str, seed: int) -> dict[str, object]:
    record = make_record(kind, seed)
    row: dict[str, object] = {"kind": record.kind, "name": kind, "seed": seed, "size": record.size}
    begin = time.perf_counter()
    try:
        fit = ll.fit_decay(record.table, mass=record.mass, compare=False, profile=False)
    except ValueError as error:
        row |= {"refused": str(error), "doubted": True, "wrong": False}
    else:
        row |= {"doubted": not fit.describes, "break": fit.dataset.attrs.get("break", "")}
        row["words"] = fit.verdict
        off = {}
        for name in SMALL:
            truth = getattr(record, name)
            if math.isfinite(truth):
                miss = abs(fit[name].value - truth)
                if miss > SMALL[name] * abs(truth):
                    off[name] = miss / fit[name].sigma
        row["off"] = off
        row["wrong"] = fit.describes and any(size > WRONG for size in off.values())
    row["seconds"] = time.perf_counter() - begin
    return row


def draw(rows: list[dict[str, object]]) -> None:
    """Write the shares of records of each kind that were doubted or refused."""
    from latolato.figures import style

    figure, axes = style.new_figure(1, 1, height=3.4)
    axis = axes[0, 0]
    names = list(dict.fromkeys(str(row["name"]) for row in rows))
    for place, name in enumerate(reversed(names)):
        own = [row for row in rows if row["name"] == name]
        share = 100.0 * sum(bool(row["doubted"]) for row in own) / len(own)
        colour = style.BLUE if name in WHOLE else style.RED
        axis.barh(place, share, color=colour, height=0.7)
        style.note(axis, f"{share:.0f} %", (share, float(place)), (4.0, 0.0))
    labels = [str(next(r["kind"] for r in rows if r["name"] == name)) for name in names]
    axis.set_yticks(range(len(names)), labels[::-1])
    axis.set_xlim(0.0, 112.0)
    axis.set_xlabel("records that were doubted [%]; blue: without a break, red: with one")
    figure.savefig(Path("docs/images/fit-doubt.png"))


def main(records: int = 19, first: int = 0, kinds: str = "") -> None:
    warnings.simplefilter("ignore")
    rows = []
    print(f"{'kind':18} {'records':>7} {'doubted':>8} {'wrong':>6} {'seconds':>8}  named")
    for kind in kinds.split(",") if kinds else (*WHOLE, *BROKEN):
        several = [judge(kind, first + k) for k in range(records)]
        rows += several
        names: dict[str, int] = {}
        for row in several:
            name = "refused" if "refused" in row else str(row["break"])
            names[name] = names.get(name, 0) + 1
        print(
            f"{several[0]['kind']:18} {records:7d} {sum(bool(r['doubted']) for r in several):8d} "
            f"{sum(bool(r['wrong']) for r in several):6d} "
            f"{sum(float(str(r['seconds'])) for r in several) / records:8.2f}  {names}",
            flush=True,
        )
    whole = [row for row in rows if row["name"] in WHOLE]
    broken = [row for row in rows if row["name"] in BROKEN]
    for words, part in (("without a break", whole), ("with a break", broken)):
        doubted, wrong = (sum(bool(row[key]) for row in part) for key in ("doubted", "wrong"))
        print(f"{len(part)} records {words}: {doubted} doubted, {wrong} wrong numbers given")
    moved = [row for row in broken if any(size > MOVED for size in row.get("off", {}).values())]
    noticed = sum(bool(row["doubted"]) for row in moved)
    print(f"{len(moved)} of them moved a number by over {MOVED:g} deviations: {noticed} noticed")
    draw(rows)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]), *sys.argv[3:])
