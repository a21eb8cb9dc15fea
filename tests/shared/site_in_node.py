"""What the modules of a site answer in Node.js."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

from in_node import NODE


def answers_in_node(program: Path, site: Path, requests: Any, folder: Path) -> Any:
    """Return what a program answers to requests, asked together; `folder` takes its files."""
    asked, answers = folder / "requests.json", folder / "answers.json"
    asked.write_text(json.dumps(requests))
    command = [NODE, program, site, asked, answers]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return json.loads(answers.read_text())
