"""`latolato.play`: the player of the application in a notebook."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import re
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app import STATIC
from latolato.app.blocks import pack
from latolato.app.given import MOST_SAMPLES
from latolato.app.runs import about, arrays_of
from latolato.core.errors import InputError, import_extra
from latolato.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr

# Modules of the player, each after those that it imports.
MODULES = (
    "vendor/uPlot.esm.js",
    "js/strings.js",
    "js/shared/dom.js",
    "js/shared/units.js",
    "js/shared/block.js",
    "js/shared/motion.js",
    "js/shared/clock.js",
    "js/shared/clack.js",
    "js/shared/keys.js",
    "js/shared/later.js",
    "js/shared/band.js",
    "js/shared/scene.js",
    "js/shared/shades.js",
    "js/shared/axis.js",
    "js/shared/plane.js",
    "js/shared/curves.js",
    "js/shared/player.js",
    "js/notebook.js",
)
SHEETS = ("vendor/uPlot.css", "app.css", "notebook.css")
PICTURE_DPI = 100
# What the player draws.
_COLUMNS = (
    "angle", "angular_velocity", "pivot_height", "kinetic_energy", "potential_energy",
    "total_energy", "drive_power", "damping_power", "tension",
)  # fmt: skip
_ATTRIBUTES = ("natural_frequency", "contact_angle_low", "contact_angle_high")
_IMPORT = re.compile(
    r'^import (?:\{(?P<names>[^}]*)\}|(?P<default>\w+)) from "(?P<path>[^"]+)";$', re.M
)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:function|class|const|let) (?P<name>\w+))", re.M)
_DEFAULT = re.compile(r"^export \{ (?P<name>\w+) as default \};$", re.M)


def play(run: xr.Dataset) -> Any:
    """Return a widget that plays a run: animation, curves, phase portrait, contacts, energies.

    Parameters
    ----------
    run : xarray.Dataset
        What `latolato.simulate` or `latolato.load` returned; of more than 200000 samples every
        second, third, ... is shown.

    Returns
    -------
    anywidget.AnyWidget
        For Jupyter, marimo, VS Code and others; works without a network. Its attribute `run` is
        the run; set it to show another one in the same place.

    Raises
    ------
    InputError
        If the dataset is no run.
        Without the extra `notebook`.
    """
    return _widget_class()(run)


def block_of(run: xr.Dataset) -> bytes:
    """Return a run as the player reads it."""
    import xarray as xr

    if not isinstance(run, xr.Dataset):
        raise InputError("play needs a run: what simulate or load returned", value=run)
    if "scenario" not in run.attrs or "time" not in run or "angle" not in run:
        raise InputError("play needs a run: what simulate or load returned")
    thinned = run.isel(time=slice(None, None, -(-run.sizes["time"] // MOST_SAMPLES)))
    scenario = Scenario.from_dict(json.loads(run.attrs["scenario"]))
    said = about(scenario, thinned)
    kept = {name: said["attributes"][name] for name in _ATTRIBUTES if name in said["attributes"]}
    return pack({**said, "attributes": kept}, arrays_of(scenario, thinned, _COLUMNS, np.float32))


def picture_of(run: xr.Dataset) -> str:
    """Return the angles of a run as PNG in base64, for places that show no widgets."""
    from latolato.figures.run import draw_angle_strip

    stream = io.BytesIO()
    draw_angle_strip(run).savefig(stream, format="png", dpi=PICTURE_DPI)
    return base64.b64encode(stream.getvalue()).decode()


@lru_cache(maxsize=1)
def _widget_class() -> Any:
    """Return the class of the widget; anywidget is imported here."""
    for module in ("anywidget", "traitlets"):
        import_extra(module, "notebook", "the player in a notebook")
    import anywidget
    import traitlets

    class PlayerWidget(anywidget.AnyWidget):
        """The player of one run."""

        _esm = bundle()
        block = traitlets.Bytes().tag(sync=True)
        # Not `style`, which widgets of Jupyter have already.
        sheet = traitlets.Unicode().tag(sync=True)

        def __init__(self, run: xr.Dataset) -> None:
            self._run = run
            super().__init__(block=block_of(run), sheet=style_sheet())

        @property
        def run(self) -> xr.Dataset:
            """The run on show."""
            return self._run

        @run.setter
        def run(self, run: xr.Dataset) -> None:
            self.block = block_of(run)
            self._run = run

        def _repr_mimebundle_(self, **options: Any) -> Any:
            """Return the widget, and a picture for places that show none."""
            result = super()._repr_mimebundle_(**options)
            if result is not None:
                result[0]["image/png"] = picture_of(self._run)
                result[0]["text/plain"] = "A run of latolato in its player"
            return result

    return PlayerWidget


@lru_cache(maxsize=1)
def bundle() -> str:
    """Return the modules of the player as one, which is what widgets are made of.

    Each module becomes a function of those before it, so that names do not meet. Every widget
    brings the whole text along, which runs once in a page.
    """
    parts = ["const modules = {};"]
    for path in MODULES:
        source = (STATIC / path).read_text(encoding="utf-8")
        names = {name: name for name in _EXPORT.findall(source)}
        if whole := _DEFAULT.search(source):
            names = {"default": whole["name"]}
        body = _DEFAULT.sub("", _EXPORT.sub("", _IMPORT.sub(_lookup, source)))
        exports = ", ".join(f'"{name}": {own}' for name, own in names.items())
        name = path.rpartition("/")[2]
        parts.append(f'modules["{name}"] = (() => {{\n{body}\nreturn {{ {exports} }};\n}})();')
    body = "\n".join(parts)
    key = f"latolato {hashlib.sha256(body.encode()).hexdigest()[:16]}"
    return (
        f'const shared = (globalThis[Symbol.for("{key}")] ??= (() => {{\n{body}\n'
        "return modules;\n})());\n"
        'export default { render: shared["notebook.js"].render };\n'
    )


def _lookup(match: re.Match[str]) -> str:
    """Return the line that stands for an import: names of a module that came before."""
    module = f'modules["{match["path"].rpartition("/")[2]}"]'
    if match["default"]:
        return f"const {match['default']} = {module}.default;"
    return f"const {{ {match['names'].replace(' as ', ': ').strip()} }} = {module};"


@lru_cache(maxsize=1)
def style_sheet() -> str:
    """Return the style sheet for the inside of a widget, which has a root of its own."""
    sheets = [(STATIC / name).read_text("utf-8") for name in SHEETS]
    text = re.sub(r":root((?:\[[^\]]*\]|:not\([^)]*\))+)", r":host(\1)", "\n".join(sheets))
    return text.replace(":root", ":host")
