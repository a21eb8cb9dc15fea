"""Toys that a hand holds, moved in Node.js."""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import xarray as xr

import latolato as ll
from in_node import NODE, read_layout
from latolato.app.forms import registry

TICKS_PER_SECOND = 60


@dataclass(frozen=True)
class Job:
    """A toy that moves on by sixtieths of a second; before some of these something is done to it.

    An action is the tick before which it is done, a method of the toy and its argument;
    "keep" says from when on the motion is kept.
    """

    scenario: str
    ticks: int
    actions: list[tuple[int, str, Any]] = field(default_factory=list)
    options: dict[str, str] = field(default_factory=dict)


def move_toys(folder: Path, *jobs: Job) -> list[dict[str, Any]]:
    """Return what became of toys; those of which something is kept have a ``dataset``."""
    read_layout()
    toys = [
        {"request": {"scenario": job.scenario, "options": job.options}, "ticks": job.ticks,
         "actions": job.actions}
        for job in jobs
    ]  # fmt: skip
    (folder / "toys.json").write_text(json.dumps({"registry": registry(), "toys": toys}))
    program = Path(__file__).with_suffix(".mjs")
    run = subprocess.run([NODE, program, folder], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stdout + run.stderr
    results: list[dict[str, Any]] = json.loads((folder / "done.json").read_text())
    for number, result in enumerate(results):
        if result["kept"]:
            result["dataset"] = dataset_of(folder / f"{number}.csv")
    return results


def dataset_of(path: Path) -> xr.Dataset:
    """Return what was kept from its file."""
    result: xr.Dataset = ll.load(path)
    return result
