"""WebAssembly in a browser: the modules that Node.js runs in `tests/numerics/test_wasm.py`."""

from __future__ import annotations

import mimetypes
from urllib.parse import urlsplit

import numpy as np
import pytest

import latolato as ll
from in_node import described_array, read_layout, record_run
from latolato.app.pages import STATIC
from latolato.sweeps.statuses import codes_of

RUN = """
async ({ arrays, how }) => {
  const { Kernels } = await import("/js/kernels/memory.js");
  const { integrate } = await import("/js/kernels/run.js");
  const layout = await (await fetch("/kernels/layout.json")).json();
  const started = {};
  for (const name of Object.keys(layout.modules)) {
    const module = await WebAssembly.compileStreaming(fetch(`/kernels/${name}.wasm`));
    started[name] = await Kernels.start(module, name, layout);
  }
  const { one } = started;
  const memory = {};
  for (const { name, type, shape, bytes } of arrays) {
    memory[name] = one.take(type, ...shape);
    one.bytes(memory[name]).set(bytes);
  }
  const { status, samples, contacts } = integrate(one, memory, how);
  const [, size] = samples.shape;
  return {
    status, angles: [...one.numbers(samples).subarray(0, size)], times: [...contacts.times],
    kernels: Object.fromEntries(Object.entries(started).map(([name, each]) =>
      [name, Object.keys(each.addresses)])),
  };
}
"""

MAP = """
async (plan) => {
  const { Pool } = await import("/js/map/pool.js");
  const pool = new Pool(2);
  const rows = { status: [], angles: [] };
  await pool.compute(plan, await pool.estimate(plan), {
    onCells: ({ cell, status, values }) => cell.forEach((at, k) => {
      rows.status[at] = status[k];
      rows.angles[at] = values[0][k];
    }),
  });
  pool.close();
  return rows;
}
"""


@pytest.fixture
def empty_page(browser):
    """An empty page whose server has the pages' modules and the compiled ones."""

    def answer(route):
        place = urlsplit(route.request.url).path
        path = STATIC / place[1:]
        kind = mimetypes.guess_type(place)[0]
        if place == "/":
            route.fulfill(body="<!doctype html>", content_type="text/html")
        else:
            route.fulfill(body=path.read_bytes(), content_type=kind)

    context = browser.new_context()
    context.route("**/*", answer)
    page = context.new_page()
    page.goto("http://kernels.localhost/")
    yield page
    context.close()


def test_a_page_computes_what_python_computes(empty_page):
    modules = read_layout()["modules"]
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.6)
    drive = ll.Harmonic(drive_amplitude=0.2, drive_frequency=6.26)
    case = record_run(toy, drive, initial_angle=0.5, times=np.linspace(0.0, 10.0, 201))
    arrays = [
        {"name": name, **described_array(array), "bytes": list(array.tobytes())}
        for name, array in case.arrays.items()
    ]
    result = empty_page.evaluate(RUN, {"arrays": arrays, "how": case.options["how"]})
    assert result["kernels"] == modules
    assert result["status"] == case.expected["status"] == "complete"
    assert len(result["times"]) > 10
    # The motion is regular: see `tests/numerics/test_wasm.py`.
    np.testing.assert_allclose(result["times"], case.expected["contact_times"], rtol=0, atol=1e-10)
    np.testing.assert_allclose(result["angles"], case.expected["samples"][0], rtol=0, atol=1e-12)


def test_workers_of_a_page_compute_a_map(empty_page):
    ball = {"length": 1.0, "mass": 0.8, "radius": 0.1, "damping": 0.02}
    axes = {"restitution": [0.5, 0.7, 0.9], "drive_amplitude": [0.0, 0.01, 0.02, 0.03]}
    system, drive = ll.LatoLato(**ball), ll.Harmonic(drive_amplitude=0.1, drive_frequency=3.0)
    native = ll.sweep(
        system, drive, axes=axes, observables=["largest_angle"], initial_angle=0.5, duration=5.0
    )
    y, x = ({"name": name, "values": values} for name, values in axes.items())
    usual = {"gravity": 9.8, "collides": 1, "rest_speed": 1e-6, "tolerance": 1e-6}
    plan = {
        "drive": "harmonic", "x": x, "y": y, "duration": 5.0,
        "parameters": {**ball, **usual, "drive_frequency": 3.0, "initial_angle": 0.5},
        "observables": [{"name": "largest_angle"}],
    }  # fmt: skip
    page = empty_page.evaluate(MAP, plan)
    assert page["status"] == codes_of(native["status"]).ravel().tolist()
    np.testing.assert_allclose(
        page["angles"], native["largest_angle"].values.ravel(), rtol=0, atol=1e-10
    )
