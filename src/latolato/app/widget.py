"""`latolato.play`: the player of the application in a notebook."""

from __future__ import annotations

import base64
import gzip
import hashlib
import io
import json
import posixpath
import re
from functools import lru_cache, partial
from graphlib import TopologicalSorter
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app import STATIC, kernels_folder
from latolato.app.blocks import pack
from latolato.app.forms import registry
from latolato.app.languages import text_of
from latolato.app.run_request import MOST_SAMPLES
from latolato.app.runs import about, arrays_of
from latolato.app.site import without_descriptions
from latolato.core.errors import InputError, import_extra
from latolato.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr

# What anywidget calls; the modules that it imports come along.
ENTRY = "js/notebook.js"
# The module that finds files, in whose place the program has one that holds them.
CONTENT = "js/kernels/content.js"
SHEETS = ("vendor/uPlot.css", "app.css", "toy.css", "inset.css")
PICTURE_DPI = 100
# What the player draws.
_COLUMNS = (
    "angle", "angular_velocity", "pivot_height", "kinetic_energy", "potential_energy",
    "total_energy", "drive_power", "damping_power", "tension", "pivot_velocity", "distance",
    "radial_velocity", "slack", "pivot_across", "pivot_across_velocity",
)  # fmt: skip
_ATTRIBUTES = ("natural_frequency", "contact_angle_low", "contact_angle_high")
# Every way in which a module of the pages names another one.
_NAMED = re.compile(
    r'(?P<before>from |import\(|new URL\()"(?P<path>\.[^"]+\.js)"(?P<url>, import\.meta\.url\))?'
)


def play(run: xr.Dataset, *, language: str = "en") -> Any:
    """Return a widget that plays a run: animation, curves, phase portrait, contacts, energies.

    Parameters
    ----------
    run : xarray.Dataset
        What `latolato.simulate` or `latolato.load` returned; of more than 200000 samples every
        second, third, ... is shown.
    language : str
        Code of the language of the player, such as ``id``; a notebook has one.

    Returns
    -------
    anywidget.AnyWidget
        For Jupyter, marimo, VS Code and others; works without a network. Its attribute `run` is
        the run; set it to show another one in the same place.

    Raises
    ------
    InputError
        If the dataset is no run, or pages do not have the language.
        Without the extra `notebook`.
    """
    return _widget_class()(run, language)


def block_of(run: xr.Dataset) -> bytes:
    """Return a run as the player reads it."""
    import xarray as xr

    if not isinstance(run, xr.Dataset):
        raise InputError("play needs a run: what simulate or load returned", value=run)
    if "scenario" not in run.attrs or "time" not in run or "angle" not in run:
        raise InputError("play needs a run: what simulate or load returned")
    thinned = run.isel(time=slice(None, None, -(-run.sizes["time"] // MOST_SAMPLES)))
    scenario = Scenario.from_dict(json.loads(run.attrs["scenario"]))
    description = about(scenario, thinned)
    attributes = description["attributes"]
    kept = {name: attributes[name] for name in _ATTRIBUTES if name in attributes}
    return pack(
        {**description, "attributes": kept}, arrays_of(scenario, thinned, _COLUMNS, np.float32)
    )


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
        # The code of another language than English, and its file.
        language = traitlets.Unicode().tag(sync=True)
        texts = traitlets.Unicode().tag(sync=True)

        def __init__(self, run: xr.Dataset, language: str) -> None:
            self._run = run
            texts = {"language": language, "texts": text_of(language)} if language != "en" else {}
            super().__init__(block=block_of(run), **texts)

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
    """Return the program of the player as one module, which is what widgets are made of.

    It holds the modules of the pages and their files, compressed: with the address of each module
    in the place of its name they are modules of the page, each loaded once however many cells bring
    them, and workers load them too.
    """
    text = json.dumps(modules(), ensure_ascii=False)
    packed = base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode()
    key = f"latolato {hashlib.sha256(text.encode()).hexdigest()[:16]}"
    return _PROGRAM.replace("KEY", key).replace("ENTRY", ENTRY).replace("PACKED", packed)


_PROGRAM = """
const load = async () => {
  const bytes = Uint8Array.from(atob("PACKED"), (letter) => letter.charCodeAt(0));
  const text = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const addresses = {};
  for (const [path, source] of await new Response(text).json()) {
    const whole = source.replace(/"latolato:(.+?)"/g, (_, name) => `"${addresses[name]}"`);
    addresses[path] = URL.createObjectURL(new Blob([whole], { type: "text/javascript" }));
  }
  return import(addresses["ENTRY"]);
};
export default {
  render: async (cell) => (await (globalThis[Symbol.for("KEY")] ??= load())).render(cell),
};
""".lstrip()


def modules() -> list[tuple[str, str]]:
    """Return path and source of each module of the player, after those that it names."""
    sources: dict[str, str] = {}
    names: dict[str, list[str]] = {}
    paths = [ENTRY]
    while paths:
        path = paths.pop()
        if path in sources:
            continue
        source = _content() if path == CONTENT else (STATIC / path).read_text(encoding="utf-8")
        folder = PurePosixPath(path).parent
        source = without_descriptions(source)
        names[path] = [_joined(folder, match["path"]) for match in _NAMED.finditer(source)]
        sources[path] = _NAMED.sub(partial(_placed, folder), source)
        paths += names[path]
    return [(path, sources[path]) for path in TopologicalSorter(names).static_order()]


def _joined(folder: PurePosixPath, path: str) -> str:
    """Return the path of a module that a module in a folder names."""
    return posixpath.normpath(folder / path)


def _placed(folder: PurePosixPath, match: re.Match[str]) -> str:
    """The matched import with a placeholder for its module, which has no address yet."""
    before = "" if match["url"] else match["before"]
    return f'{before}"latolato:{_joined(folder, match["path"])}"'


def _content() -> str:
    """Return the module that holds the files of the player.

    Bytes are letters of the same number. The compiled code is the one without vectors, which runs
    everywhere and is as fast for single runs. That for strings and other motions in the plane would
    add 140 kB, so a cell only plays these.
    """
    kernels = kernels_folder()
    files = {f"kernels/{name}.wasm": f"{name}-scalar.wasm" for name in ("one", "two")}
    held = {path: (kernels / name).read_bytes().decode("latin-1") for path, name in files.items()}
    held |= {path: _letters((STATIC / path).read_text("utf-8")) for path in SHEETS}
    held["kernels/layout.json"] = (kernels / "layout.json").read_text("utf-8")
    held["languages/en.json"] = _letters(text_of("en"))
    held["registry.json"] = _letters(json.dumps(_registry()))
    return f"""const FILES = {json.dumps(held, ensure_ascii=False)};
export async function contentOf(path) {{
  return new Response(Uint8Array.from(FILES[path], (letter) => letter.charCodeAt(0)));
}}
"""


def _letters(text: str) -> str:
    """Return a text with a letter for each byte."""
    return text.encode().decode("latin-1")


def _registry() -> dict[str, Any]:
    """The part of the registry for a cell's fields: laws that the modules have."""
    whole = registry()
    laws = {
        part: {name: law for name, law in whole[part].items() if law["compiled"]}
        for part in ("systems", "drives", "contact_laws")
    }
    names = ("version", "options", "ratios", "rules", "alternatives", "units", "prefixes")
    empty: dict[str, Any] = {"axes": {}, "observables": {}, "scenarios": {}}
    own = {"server": False, "upright": True}
    return {**{name: whole[name] for name in names}, **laws, **empty, **own}
