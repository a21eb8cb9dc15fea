"""Pages know a drive of the package from its class alone: under a new name all goes on as before.

The compiled modules cannot get a new formula here, so each drive of the package is registered again
as a class with another name, and the modules' table calls it by that name. CONTRIBUTING.md explains
how a drive is added.
"""

import json
from pathlib import Path
from urllib.parse import urlencode

import numpy as np
import pytest

import latolato as ll
from latolato.app.site import write_site
from latolato.numerics.host_entry import WRITTEN
from latolato.physics.drives import drives
from site_in_node import answers_in_node

PROGRAM = Path(__file__).with_name("drives_in_node.mjs")
SYSTEM = {"length": 0.245, "mass": 0.1, "damping": 0.005}
SHAKEN = {"drive_amplitude": 0.02, "drive_frequency": 15.1, "drive_phase": 0.4}
STAGES = {"times": [0.0, 1.0], "drive_frequencies": [15.1, 12.0], "drive_phase": 0.4}
# Every drive that pages can write but the one at rest, which they need for a pivot without drive.
DRIVES = {
    "harmonic": SHAKEN,
    "crank_slider": {**SHAKEN, "connecting_rod_length": 0.1, "guide": "above"},
    "frequency_schedule": {**STAGES, "drive_amplitude": 0.02, "ramp": 0.3},
    "chirp": {**SHAKEN, "drive_frequency_final": 12.0, "sweep_time": 2.0},
    "staged_harmonic": {**STAGES, "drive_amplitudes": [0.02, 0.01], "ramps": [0.1, 0.3]},
    "planar_harmonic": {
        "vertical_amplitude": 0.02, "horizontal_amplitude": 0.01, "drive_frequency": 15.1,
        "vertical_phase": 0.4, "horizontal_phase": 1.0,
    },
}  # fmt: skip
# What a map varies beside the start: the second value jams the crank.
VARIED = {
    "crank_slider": ("drive_amplitude", [0.05, 0.2]),
    "planar_harmonic": ("horizontal_amplitude", [0.0, 0.01]),
}
ANGLES = [0.3, 0.6]
RUN = {"initial_angle": 0.3, "duration": 3.0}


def options_of(name, parameters):
    """Return the options of a run under a drive."""
    drive = {"drive_times" if key == "times" else key: each for key, each in parameters.items()}
    return {"system": "pendulum", **SYSTEM, "drive": name, **drive, **RUN}


def request_of(name):
    """Return what the page is asked about the drive that is called by another name."""
    options = options_of(f"own_{name}", DRIVES[name])
    texts = {
        key: ", ".join(map(str, value)) if isinstance(value, list) else str(value)
        for key, value in options.items()
    }
    x, values = VARIED.get(name, ("damping", [0.001, 0.01]))
    axes = {"x": {"name": x, "low": values[0], "high": values[1]},
            "y": {"name": "initial_angle", "low": ANGLES[0], "high": ANGLES[1]}}  # fmt: skip
    jams = name == "crank_slider"
    return {
        "link": f"?{urlencode({'view': 'toy', **texts})}",
        "map": {"scenario": None, "options": options, **axes, "observable": "final_angle",
                "width": 2, "height": 2, "duration": RUN["duration"], "transient": 0.0},
        "refused": options | {"drive_amplitude": 0.2} if jams else None,
    }  # fmt: skip


@pytest.fixture
def answers(monkeypatch, forget, tmp_path):
    monkeypatch.setattr(drives, "_entries", dict(drives._entries))
    for name in DRIVES:
        own = {"__doc__": WRITTEN[name].__doc__, "__module__": "latolato.physics.drives.own"}
        drives.register(f"own_{name}")(type(f"Own{WRITTEN[name].__name__}", (WRITTEN[name],), own))
    forget()
    site = tmp_path / "site"
    write_site(site)
    path = site / "kernels" / "layout.json"
    layout = json.loads(path.read_text())
    for drive in layout["drives"]:
        if drive["name"] in DRIVES:
            drive["name"] = f"own_{drive['name']}"
    path.write_text(json.dumps(layout))
    found = answers_in_node(PROGRAM, site, [request_of(name) for name in DRIVES], tmp_path)
    return dict(zip(DRIVES, found, strict=True))


@pytest.mark.filterwarnings("ignore:2 of 4 points have no answer:RuntimeWarning")
def test_a_page_runs_maps_and_links_every_drive_by_what_its_class_says(answers):
    assert DRIVES.keys() == WRITTEN.keys() - {"fixed_pivot"}
    pendulum = ll.Pendulum(**SYSTEM)
    for name, answer in answers.items():
        kind, parameters = WRITTEN[name], DRIVES[name]
        drive = kind(**parameters)
        assert answer["left"] == [], name
        assert f"drive=own_{name}" in answer["link"]
        assert f"Own{kind.__name__}(" in answer["python"]
        assert answer["is_sinusoidal"] == kind.is_sinusoidal
        begins = {"start": 0, "amplitude": 0.02, "frequency": 15.1, "phase": 0.4}
        assert answer["begins"] == begins, name
        run = ll.simulate(pendulum, drive, **RUN, times=answer["time"])
        # A smooth run at the default tolerance of 1e-10: the two differ by roundings.
        for column in ("angle", "pivot_height"):
            np.testing.assert_allclose(answer[column], run[column], rtol=0.0, atol=1e-9)
        x, values = VARIED.get(name, ("damping", [0.001, 0.01]))
        axes = {"initial_angle": ANGLES, x: values}
        grid = ll.sweep(
            pendulum, drive, axes=axes, duration=RUN["duration"], observables=["final_angle"]
        )
        own = np.array(answer["map"]["values"], dtype=np.float64)
        np.testing.assert_allclose(own, grid.final_angle.values.ravel(), rtol=0.0, atol=1e-9)
        assert answer["map"]["in_lanes"] == drive.is_cosine, name
        assert answer["map"]["module"].startswith("plane_") == drive.moves_across


def test_a_page_refuses_an_amplitude_in_the_words_of_the_class(answers):
    parameters = DRIVES["crank_slider"] | {"drive_amplitude": 0.2}
    with pytest.raises(ll.InputError, match="the crank would jam") as refused:
        ll.CrankSlider(**parameters)
    assert answers["crank_slider"]["error"] == str(refused.value)
    assert answers["crank_slider"]["map"]["problems"] == ["fine", "out of range"] * 2
