"""Fixtures that run a test for every registered drive, system and damping law.

Examples are built from the fields' own metadata, so that a new law is covered by the generic
tests without an edit here. Compiled kernels stay in the user's cache between sessions.

Each package of `src/latolato` has a folder of tests. Beside these, `extensions` adds laws of its
own as CONTRIBUTING says, `gpu` needs a device, `docs` and `smoke` run what the documentation shows,
`reference` holds numbers of other programs and `shared` what several tests import.
"""

import dataclasses
import functools
import itertools
import json
import math
import os
import signal
import tempfile
from pathlib import Path
from unittest import mock

import hypothesis
import numpy as np
import pytest
import typer.main
import typer.testing

from latolato.core.cache import cache_directory
from latolato.physics.drives import drives
from latolato.physics.pendulum import Ball, systems

# For type checkers only, which `make lint` runs on it.
collect_ignore = ["typed_use.py"]

# Subprocesses share the compiled kernels whatever their HOME is.
os.environ.setdefault("LATOLATO_CACHE_DIR", str(cache_directory()))

# A shell starts its background jobs with Ctrl-C ignored, and children inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# The gate tries the same examples every time; HYPOTHESIS_PROFILE=explore looks for new ones.
hypothesis.settings.register_profile("gate", derandomize=True)
hypothesis.settings.register_profile("explore", derandomize=False)
hypothesis.settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "gate"))

# Long enough for every run of a generic test.
SAMPLED = np.linspace(0.0, 12.0, 121)
# Values of the fields that hold a sequence.
ARRAYS = {
    # A change that begins before the last one has ended, too.
    ("times", "ramps"): lambda: (0.0, 1.5, 1.8, 4.0),
    ("drive_frequencies", "ramps"): lambda: (7.0, 4.0, 5.5, 6.0),
    ("times", "drive_frequencies"): lambda: (0.0, 1.5, 4.0),
    ("drive_frequencies", "times"): lambda: (7.0, 4.0, 5.5),
    ("drive_amplitudes", "ramps"): lambda: (0.03, 0.05, 0.01, 0.02),
    ("ramps", "drive_amplitudes"): lambda: (0.1, 0.5, 0.3, 0.2),
    ("times", "pivot_heights"): lambda: tuple(SAMPLED),
    ("pivot_heights", "times"): lambda: tuple(
        0.03 * np.cos(5.0 * SAMPLED) + 0.01 * np.sin(2.0 * SAMPLED)
    ),
    ("pivot_across", "times"): lambda: tuple(0.02 * np.sin(4.0 * SAMPLED)),
}


def pytest_configure(config):
    """Give all workers a folder in which they share what takes long to compute."""
    if not hasattr(config, "workerinput"):
        folder = tempfile.TemporaryDirectory(prefix="latolato-tests-")
        os.environ["LATOLATO_TEST_FOLDER"] = folder.name
        config.add_cleanup(folder.cleanup)


def pytest_collection_modifyitems(items):
    """Begin with the paper: its figures take longest, and each worker draws what it needs once."""
    items.sort(key=lambda item: item.path.parent.name != "paper")


@pytest.fixture(scope="session", autouse=True)
def _one_tree_of_commands():
    """Build the command line's commands once in a process; Typer does so in every call."""
    build = functools.cache(typer.main.get_command)
    with (
        mock.patch.object(typer.main, "get_command", build),
        mock.patch.object(typer.testing, "_get_command", build),
    ):
        yield


def field_value(kind, field, share):
    """A value for a field: `share` of its suggested interval, a ball, or an example array."""
    names = {f.name for f in dataclasses.fields(kind)}
    if field.metadata.get("array"):
        for (name, partner), make in ARRAYS.items():
            if name == field.name and partner in names:
                return make()
        raise LookupError(f"give an example of {kind.__name__}.{field.name} in ARRAYS")
    if field.type in ("Ball", Ball):
        # The right ball is the longer one, by less than the radii reach.
        length = 0.9 if field.name == "right" else 0.85
        return Ball(length=length, mass=0.5 if field.name == "right" else 0.3, radius=0.09)
    low, high = field.metadata["suggested"]
    return low + share * (high - low)


def examples(kind):
    """Yield (name, instance): required fields only, then every field with each choice."""
    fields = [f for f in dataclasses.fields(kind) if f.init]
    required = [f for f in fields if f.default is dataclasses.MISSING]
    yield "required", kind(**{f.name: field_value(kind, f, 0.25) for f in required})
    optional = [f for f in fields if f not in required]
    if not optional:
        return
    choices = [
        f.metadata.get("choices", (True,))
        if isinstance(f.default, (str, bool))
        else (field_value(kind, f, 0.4),)
        if f.metadata.get("suggested") or f.metadata.get("array")
        else (f.default,)
        for f in optional
    ]
    for chosen in itertools.product(*choices):
        arguments = {f.name: field_value(kind, f, 0.15) for f in required}
        arguments.update({f.name: value for f, value in zip(optional, chosen, strict=True)})
        words = [str(c) for c in chosen if isinstance(c, str)]
        yield "-".join(["full", *words]), kind(**arguments)


def all_examples(registry):
    """Instances of every entry of a registry as pytest parameters."""
    return [
        pytest.param(instance, id=f"{name}-{how}")
        for name, kind in registry.items()
        for how, instance in examples(kind)
    ]


DAMPING_FIELDS = [f.name for f in dataclasses.fields(Ball) if f.name.endswith("damping")]
STRENGTHS = dict(zip(DAMPING_FIELDS, (0.06, 0.05, 0.08), strict=True))
DAMPING_LAWS = [
    pytest.param({name: STRENGTHS[name] for name in names}, id="+".join(names) or "undamped")
    for count in range(len(DAMPING_FIELDS) + 1)
    for names in itertools.combinations(DAMPING_FIELDS, count)
]


@pytest.fixture(params=all_examples(drives))
def drive(request):
    """Every registered drive, in several forms, defined on [0, 12] s at least."""
    return request.param


@pytest.fixture(params=DAMPING_LAWS)
def damping_law(request):
    """Every sum of damping laws, as keyword arguments of a ball."""
    return request.param


def system_of(kind, **law):
    """A registered system whose balls have these damping coefficients, perhaps on strings."""
    names = {f.name for f in dataclasses.fields(kind)}
    hung = {name: law.pop(name) for name in ("suspension",) if name in law}
    if "right" in names:
        return kind(
            right=Ball(length=0.9, mass=0.5, radius=0.09, **law),
            # Balls that differ more push each other's strings slack and rest there: not described.
            left=Ball(length=0.89 if hung else 0.85, mass=0.3, radius=0.09, **law),
            restitution=0.85,
            **hung,
        )
    own = {"length": 0.9, "mass": 0.5, "radius": 0.09, "restitution": 0.85}
    return kind(**{k: v for k, v in own.items() if k in names}, **hung, **law)


@pytest.fixture(params=list(systems))
def make_system(request):
    """For every registered system: a function of a damping law that returns it."""
    return functools.partial(system_of, systems[request.param])


def pairs_of_laws():
    """Yield (system, drive, damping law) as parameters; every two of them occur together.

    Every system hangs on a rod and, if it can, on strings. Where the pivot moves sideways, there
    are no mirror images, and no linearised pendulum.
    """
    hung = {(name, "rod"): {} for name in systems} | {
        (name, "string"): {"suspension": "string"}
        for name, kind in systems.items()
        if "suspension" in kind.__dataclass_fields__
    }
    for (i, drive), (j, law) in itertools.product(
        enumerate(all_examples(drives)), enumerate(DAMPING_LAWS)
    ):
        sideways = drive.values[0].moves_across
        able = [one for one in hung if not (sideways and one[0] in ("latolato", "mathieu"))]
        name, suspension = able[(i + j) % len(able)]
        system = system_of(systems[name], **hung[name, suspension], **law.values[0])
        yield pytest.param(
            (system, *drive.values, *law.values), id=f"{name}-{suspension}-{drive.id}-{law.id}"
        )


@pytest.fixture(params=pairs_of_laws())
def laws(request):
    """A system, a drive and the system's damping law, as keyword arguments of a ball."""
    return request.param


@pytest.fixture(scope="session")
def reference_cases():
    """High-precision cases by name: the shared ones and those of make_cases.py."""
    folder = Path(__file__).parent / "reference"
    cases = {}
    for file in sorted(folder.glob("*.json")):
        cases.update(json.loads(file.read_text()))
    return {name: case for name, case in cases.items() if not name.startswith("_")}


@pytest.fixture(scope="session")
def toy_angle():
    """The contact angle of a ball of radius 0.1 at length 1 [rad]."""
    return math.asin(0.1)
