"""Real notebooks around the player: their servers, and what the player's pixels say."""

from __future__ import annotations

import json
import math
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np

# How long a server or a kernel may take [s].
PATIENCE = 120.0
# What a notebook simulates; tests do the same.
RUN = """
toy = ll.LatoLato(length=0.2, mass=0.05, radius=0.02, restitution=0.9)
drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.0)
run = ll.simulate(toy, drive, initial_angle=0.5, duration=3.0)
""".strip()
# The players of a page, through all shadow roots.
_PLAYERS = """
const players = [];
const walk = (root) => {
  for (const { shadowRoot } of root.querySelectorAll("*")) {
    if (!shadowRoot) continue;
    if (shadowRoot.querySelector(".inset")) players.push(shadowRoot);
    walk(shadowRoot);
  }
};
walk(document);
"""
_BALLS = (
    "(which) => {"
    + _PLAYERS
    + """
  const canvas = players[which].querySelector("canvas.scene");
  const { width, height } = canvas;
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
  const found = { width, height };
  for (const name of ["right", "left"]) {
    const hex = getComputedStyle(canvas).getPropertyValue(`--${name}`).trim();
    const wanted = [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
    let [n, x, y] = [0, 0, 0];
    for (let i = 0; i < data.length; i += 4)
      // Trails have the same colour and are not opaque.
      if (data[i + 3] === 255 && wanted.every((value, k) => Math.abs(value - data[i + k]) < 4)) {
        n += 1;
        x += (i / 4) % width + 0.5;
        y += Math.floor(i / 4 / width) + 0.5;
      }
    found[name] = n ? [x / n, y / n] : null;
  }
  return found;
}"""
)


@contextmanager
def serving(
    command: Sequence[str], folder: Path, answers: Any, settings: dict[str, str] | None = None
) -> Iterator[str]:
    """Run a server in a folder of its own and give what `answers` finds of it: its address."""
    with (folder / "server.log").open("w") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", *command],
            cwd=folder,
            stdout=log,
            stderr=subprocess.STDOUT,
            env={**os.environ, **(settings or {})},
        )
        try:
            end = time.monotonic() + PATIENCE
            while not (found := answers()):
                told = (folder / "server.log").read_text()
                assert process.poll() is None, told
                assert time.monotonic() < end, told
                time.sleep(0.05)
            yield found
        finally:
            process.terminate()
            process.wait(timeout=30)


@contextmanager
def jupyter(folder: Path, cells: Sequence[str]) -> Iterator[str]:
    """Give the address of JupyterLab that shows a notebook of these cells."""
    node = {
        "cells": [
            {
                "cell_type": "code",
                "id": f"cell{i}",
                "metadata": {},
                "execution_count": None,
                "outputs": [],
                "source": source,
            }
            for i, source in enumerate(cells)
        ],
        "metadata": {"kernelspec": {"name": "python3", "display_name": "Python 3"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    (folder / "play.ipynb").write_text(json.dumps(node))
    runtime = folder / "runtime"
    settings = {
        name: str(folder / name.lower())
        for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "IPYTHONDIR")
    }
    quiet = folder / "settings" / "@jupyterlab" / "apputils-extension"
    quiet.mkdir(parents=True)
    (quiet / "notification.jupyterlab-settings").write_text('{"fetchNews": "false"}')
    command = [
        "jupyterlab",
        "--no-browser",
        "--allow-root",
        "--ip=127.0.0.1",
        f"--port={_free_port()}",
        "--IdentityProvider.token=",
        f"--ServerApp.root_dir={folder}",
        f"--LabApp.user_settings_dir={folder / 'settings'}",
        "--LabApp.expose_app_in_browser=True",
    ]

    def answers() -> str | None:
        # The server may have taken another port than the one it was given.
        for path in runtime.glob("jpserver-*.json"):
            try:
                port = json.loads(path.read_text())["port"]
            except json.JSONDecodeError:  # not yet whole
                return None
            if _listens(port):
                return f"http://127.0.0.1:{port}/lab/tree/play.ipynb"
        return None

    with serving(
        command, folder, answers, settings | {"JUPYTER_RUNTIME_DIR": str(runtime)}
    ) as address:
        yield address


def write_marimo(folder: Path, cells: Sequence[str]) -> None:
    """Write a notebook of these cells, and how marimo shows it."""
    bodies = ["\n".join(f"    {line}" for line in cell.splitlines()) for cell in cells]
    code = "".join(f"@app.cell\ndef _(ll, mo, run):\n{body}\n    return\n\n" for body in bodies)
    first = "\n".join(f"    {line}" for line in RUN.splitlines())
    (folder / "play.py").write_text(
        "import marimo\n\napp = marimo.App()\n\n"
        "@app.cell\ndef _():\n    import marimo as mo\n    import latolato as ll\n"
        f"{first}\n    return ll, mo, run\n\n{code}"
    )
    (folder / "pyproject.toml").write_text(
        '[tool.marimo.display]\ntheme = "system"\n[tool.marimo.runtime]\nauto_instantiate = true\n'
    )


@contextmanager
def marimo(folder: Path, mode: str, cells: Sequence[str]) -> Iterator[str]:
    """Give the address of marimo that runs or edits a notebook of these cells."""
    write_marimo(folder, cells)
    port = _free_port()
    command = ["marimo", "-q", mode, "play.py", "--headless", "--no-token"]
    command += ["--host", "127.0.0.1", "--port", str(port)]
    settings = {name: str(folder / name.lower()) for name in ("XDG_CONFIG_HOME", "XDG_STATE_HOME")}
    if mode == "edit":
        command.append("--skip-update-check")
    with serving(
        command,
        folder,
        lambda: f"http://127.0.0.1:{port}/" if _listens(port) else None,
        settings,
    ) as address:
        yield address


def marimo_export(folder: Path, cells: Sequence[str]) -> Path:
    """Return the page that marimo exports of a notebook of these cells."""
    write_marimo(folder, cells)
    command = [sys.executable, "-m", "marimo", "-q", "export", "html", "play.py", "-o", "play.html"]
    subprocess.run(command, cwd=folder, check=True, timeout=PATIENCE)
    return folder / "play.html"


def jupyter_export(folder: Path, source: str) -> Path:
    """Return the page that nbconvert exports of a notebook that ran, with the state of widgets."""
    import nbconvert
    import nbformat
    from nbconvert.preprocessors import ExecutePreprocessor

    node = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(source)])
    run = ExecutePreprocessor(timeout=PATIENCE, kernel_name="python3")
    run.preprocess(node, {"metadata": {"path": str(folder)}})
    html, _ = nbconvert.HTMLExporter().from_notebook_node(node)
    (folder / "play.html").write_text(html, encoding="utf-8")
    return folder / "play.html"


# What scripts of the network do for a page of nbconvert: they show widgets in their places.
_MANAGER = """
const { state } = JSON.parse(document.querySelector(
  'script[type="application/vnd.jupyter.widget-state+json"]').textContent);
for (const place of document.querySelectorAll(
  'script[type="application/vnd.jupyter.widget-view+json"]')) {
  const { state: values, buffers } = state[JSON.parse(place.textContent).model_id];
  for (const { path, data } of buffers)
    values[path[0]] = new DataView(Uint8Array.from(atob(data), (c) => c.charCodeAt(0)).buffer);
  const source = new Blob([values._esm], { type: "text/javascript" });
  import(URL.createObjectURL(source)).then(({ default: widget }) => {
    const cell = document.createElement("div");
    place.after(cell);
    widget.render({ model: { get: (name) => values[name], on() {}, off() {} }, el: cell });
  });
}
"""


def from_network(address: str) -> str | Path | None:
    """Return what stands for a script that an exported page fetches from the network."""
    if "@marimo-team/frontend" in address:
        folder = Path(str(find_spec("marimo").origin)).parent / "_static"
        return folder / urlsplit(address).path.partition("/dist/")[2]
    if address.endswith("embed-amd.js"):
        return _MANAGER
    return "" if urlsplit(address).hostname == "cdnjs.cloudflare.com" else None


def _free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def _listens(port: int) -> bool:
    with socket.socket() as found:
        return found.connect_ex(("127.0.0.1", port)) == 0


@contextmanager
def offline_page(browser: Any, **options: Any) -> Iterator[Any]:
    """Give a page without a network; nothing may be asked from elsewhere and nothing may fail.

    Exported pages fetch the scripts of notebooks, which `from_network` has.
    """
    faults: list[str] = []

    def route(found: Any) -> None:
        parts = urlsplit(found.request.url)
        kept = from_network(found.request.url)
        if parts.scheme in ("data", "blob", "file") or parts.hostname in ("127.0.0.1", "localhost"):
            found.continue_()
        elif isinstance(kept, Path):
            found.fulfill(path=kept, headers={"access-control-allow-origin": "*"})
        elif kept is not None:
            found.fulfill(body=kept, content_type="text/javascript")
        else:
            faults.append(f"request to elsewhere: {found.request.url}")
            found.abort()

    context = browser.new_context(viewport={"width": 1300, "height": 1000}, **options)
    # Frames that are asked for and listeners that stay are counted.
    context.add_init_script(_COUNT)
    context.route("**/*", route)
    page = context.new_page()
    page.on("pageerror", lambda error: faults.append(f"page error: {error.stack or error}"))
    page.on("console", lambda m: faults.append(m.text) if m.type == "error" else None)
    page.set_default_timeout(1000 * PATIENCE)
    yield page
    context.close()
    assert not faults, "\n".join(faults)


_COUNT = """
window.counted = { frames: 0, listeners: 0 };
const request = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (call) => {
  window.counted.frames += 1;
  return request(call);
};
const own = ["keydown", "resize", "scroll", "themechange", "dppxchange"];
for (const [name, by] of [["addEventListener", 1], ["removeEventListener", -1]]) {
  const change = window[name].bind(window);
  window[name] = (event, ...rest) => {
    if (own.includes(event)) window.counted.listeners += by;
    return change(event, ...rest);
  };
}
"""


def in_player(page: Any, which: int, expression: str) -> Any:
    """Return what an expression says of a player's shadow root, `root`."""
    return page.evaluate(
        f"(which) => {{ {_PLAYERS} const root = players[which]; return root && ({expression}); }}",
        which,
    )


def shown_time(page: Any, which: int = 0) -> float:
    """Return the instant that a player tells [s]."""
    text = in_player(page, which, 'root.querySelector("output.time").textContent')
    return float(text.split()[2])


def balls(page: Any, which: int = 0) -> dict[str, Any]:
    """Return the size of a player's picture and the centres of its balls, in its pixels."""
    return page.evaluate(_BALLS, which)


def expected_balls(run: Any, at: float, width: int, height: int) -> dict[str, tuple[float, float]]:
    """Return where the balls of a run of the toy belong in a picture of this size.

    The picture holds all of the motion and the hand, a tenth larger, about the line of the pivot.
    """
    import latolato as ll
    from latolato.scenario.scenario import Scenario

    scenario = Scenario.from_dict(json.loads(run.attrs["scenario"]))
    toy = scenario.system
    assert isinstance(toy, ll.LatoLato)
    angle, pivot = run["angle"].values, run["pivot_height"].values
    x, y = toy.length * np.sin(angle), pivot - toy.length * np.cos(angle)
    reach = float(np.abs(x).max() + toy.radius)
    # Of the fist half the width; the hand reaches 0.9 of it down and 1.6 up (js/player/pivot.js).
    fist = min(0.095 * toy.length, 0.6 * (toy.length - toy.radius))
    low = float(min(y.min() - toy.radius, pivot.min() - 0.9 * fist))
    high = float(max(y.max() + toy.radius, pivot.max() + 1.6 * fist))
    size = min(width / (2 * reach * 1.1), height / ((high - low) * 1.1))
    # The instant itself, not a value between samples.
    instant = scenario.simulate(times=[0.0, at]) if at else run.isel(time=[0])
    theta = float(instant["angle"].values[-1])
    middle = float(instant["pivot_height"].values[-1]) - toy.length * math.cos(theta)
    down = 0.5 * height + (0.5 * (low + high) - middle) * size
    across = toy.length * math.sin(theta) * size
    return {"right": (0.5 * width + across, down), "left": (0.5 * width - across, down)}
