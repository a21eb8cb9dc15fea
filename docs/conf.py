"""Sphinx configuration; also writes the pages that are made from the code itself.

The glossary, the tables of systems and drives, the list of public names and the command line
reference go to ``docs/_generated`` at every build, so they cannot drift from the code.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import importlib
import inspect
import os
import pkgutil
import re
import subprocess
import sys
from importlib.metadata import version as installed_version
from pathlib import Path
from types import ModuleType
from typing import Any

import latolato
from latolato.core.registry import types_of

sys.path.insert(0, str(Path(__file__).parent))
sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
from layers import drawing

import ratios

HERE = Path(__file__).parent
GENERATED = HERE / "_generated"
PARAMETER = ("parameter", "symbol", "unit", "range", "default", "meaning")
# Public names without an example, which fail the build.
NO_EXAMPLE: list[str] = []
# What pages use of `latolato.experiment`, by module; a page that imports more fails the build.
EXPERIMENT = {
    "track_table": ("track_table", "read_table", "write_table"),
    "importing": ("import_table",),
    "trial_table": ("trial_table", "read_trials", "write_trials"),
    "fits.result": ("Fit", "Estimate", "load_fit"),
    "fits.registry": ("FitKind",),
    "synthetic.scene": ("Scene", "Camera"),
    "synthetic.synthesise": ("synthesise_video",),
}
PYTHON = re.compile(r"```(?:python|{code-cell} ipython3)\n(.*?)```", re.DOTALL)
# The sentences of a docstring that say what a number can miss.
MISSES = re.compile(
    r"((?:What (?:it|this) can miss:|It can miss:?|Missed (?:is|are)) (?:.(?!\. [A-Z]))*.\."
    r"|(?:^|(?<=\. ))[A-Z](?:.(?!\. [A-Z]))* (?:is missed|can be missed)(?:[^.]|\.\S)*\.)"
)

project = "latolato"
author = "The latolato developers"
project_copyright = "2026, The latolato developers"
release = installed_version("latolato")
version = release


def digest_of_package() -> str:
    """Return a digest of all modules of the package."""
    modules = sorted(Path(latolato.__path__[0]).rglob("*.py"))
    return hashlib.sha256(b"".join(map(Path.read_bytes, modules))).hexdigest()[:16]


extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx-mathjax-offline",
    "sphinx_copybutton",
]
exclude_patterns = ["_build", "_generated"]
default_role = "literal"

myst_enable_extensions = ["amsmath", "deflist", "dollarmath"]
myst_heading_anchors = 3

# The tutorial and the gallery are run at build time, again only where page or package was edited.
nb_execution_mode = "cache"
nb_execution_cache_path = str(Path(__file__).parent / "_build" / "runs" / digest_of_package())
nb_execution_in_temp = True
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # units and shapes stand in the docstrings
numpydoc_show_class_members = False
# All of numpydoc's rules but these: related names and further explanation stand on the pages,
# examples are asked for above, attributes of a dataclass are its parameters, an analysis describes
# its own parameters before those that all share, types stand in signatures, and "Return ... [unit]"
# in the first line says what a short function returns.
numpydoc_validation_checks = {"all", "SA01", "EX01", "ES01", "PR01", "PR03", "PR04", "RT01"}

copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

html_theme = "furo"
html_favicon = "../src/latolato/app/static/icon.svg"
html_title = f"latolato {release}"
html_static_path = ["_static"]
html_css_files = ["latolato.css"]


def first_line(described: Any) -> str:
    """Return the first line of a docstring."""
    return (inspect.getdoc(described) or "").partition("\n")[0]


def spelled(unit: str) -> str:
    """Return a unit as it is written by hand, e.g. ``kg m/s²``."""
    return unit.replace("*", " ").replace("^2", "²").replace("^(3/2)", "³ᐟ²")


def symbol(quantity: Any) -> str:
    """Return a quantity's symbol as inline mathematics that survives a table."""
    return f"${quantity.symbol}$".replace("|", r"\vert ") if quantity.symbol else ""


def table(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Return a Markdown table."""
    lines = [header, tuple("---" for _ in header), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def glossary() -> str:
    """Return the table of all quantities."""
    from latolato.core.quantities import QUANTITIES
    from latolato.observables import observables

    known = dict(QUANTITIES)
    for observable in observables.values():
        known |= observable.variables
    rows = [(f"`{name}`", symbol(q), spelled(q.unit), q.long_name) for name, q in known.items()]
    return table(("name", "symbol", "unit", "meaning"), rows)


def analysis_glossary() -> str:
    """Return the table of what analyses answer beside the quantities known everywhere."""
    import latolato.analysis
    from latolato.core.quantities import QUANTITIES, Quantity
    from latolato.observables import observables

    known = set(QUANTITIES).union(*(o.variables for o in observables.values()))
    rows: dict[tuple[str, ...], list[str]] = {}
    for found in pkgutil.iter_modules(latolato.analysis.__path__, "latolato.analysis."):
        for given in vars(importlib.import_module(found.name)).values():
            if not isinstance(given, dict):
                continue
            for name, q in given.items():
                # Labels such as status need no entry.
                if not isinstance(q, Quantity) or name in known or not (q.symbol or q.unit != "1"):
                    continue
                row = (f"`{name}`", symbol(q), spelled(q.unit), q.long_name)
                rows.setdefault(row, []).append(f"`{found.name.rpartition('.')[2]}`")
    filled = [(*row, ", ".join(sorted(set(by)))) for row, by in sorted(rows.items())]
    return table(("name", "symbol", "unit", "meaning", "module"), filled)


def parameters(law: Any) -> list[tuple[str, ...]]:
    """Return a table row for each field of a law."""
    rows = []
    for field in dataclasses.fields(law):
        if not field.init or field.name.startswith("_"):
            continue
        about = field.metadata
        quantity = about.get("quantity")
        allowed = about.get("range") or ", ".join(f"`{c}`" for c in about.get("choices", ()))
        required = (
            field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        )
        rows.append(
            (
                f"`{field.name}`",
                symbol(quantity) if quantity else "",
                spelled(quantity.unit) if quantity else "",
                str(allowed),
                "required" if required else f"`{field.default}`",
                about.get("description", ""),
            )
        )
    return rows


def laws(registry: Any) -> str:
    """Return what every entry of a registry is and takes."""
    parts = []
    for name, law in registry.items():
        parts.append(f"**`{law.__name__}`** (`{name}` on the command line). {first_line(law)}\n\n")
        rows = parameters(law)
        if rows:
            parts.append(table(PARAMETER, rows) + "\n")
    return "".join(parts)


def fit_words() -> str:
    """Return a table of the fits of track tables."""
    from latolato.experiment.fits import fits
    from latolato.scenario.analysis_options import summary_of

    rows = [
        (f"`{name}`", f"`{kind.function.__name__}`", summary_of(kind.function))
        for name, kind in fits.items()
    ]
    return table(("name", "function", "result"), rows)


@functools.cache
def pages() -> dict[str, str]:
    """Return the pages, without what stands before their titles, by their paths."""
    found = sorted([*HERE.glob("*.md"), *HERE.glob("[a-z]*/*.md")])
    texts = {page.relative_to(HERE).as_posix(): page.read_text("utf-8") for page in found}
    return {path: text[text.index("# ") :] for path, text in texts.items()}


def example(law: Any) -> str:
    """Return a call that makes a law with what forms begin with; it has been tried."""
    given = {}
    for field in dataclasses.fields(law):
        kind = types_of(law)[field.name]
        if dataclasses.is_dataclass(kind):
            given[field.name] = example(kind)
        elif field.init and field.default is field.default_factory is dataclasses.MISSING:
            given[field.name] = repr(field.metadata["quantity"].usual)
    call = f"ll.{law.__name__}({', '.join(f'{k}={v}' for k, v in given.items())})"
    eval(call, {"ll": latolato})
    return call


def directive(owner: str, name: str, thing: Any) -> str:
    """Return the autodoc directive for one public name, with its parameters and an example."""
    if not callable(thing):
        return f"```{{eval-rst}}\n.. autodata:: {owner}.{name}\n```\n\n"
    kind = "autoclass" if inspect.isclass(thing) else "autofunction"
    text = f"```{{eval-rst}}\n.. {kind}:: {owner}.{name}\n```\n\n"
    described = inspect.getdoc(thing) or ""
    is_law = dataclasses.is_dataclass(thing) and "Parameters\n---" not in described
    rows = parameters(thing) if is_law else []
    if rows:
        text += table(PARAMETER, rows) + "\n"
    if inspect.isclass(thing):  # an example of a method is one
        described += "".join(filter(None, map(inspect.getdoc, vars(thing).values())))
    if ">>>" not in described:
        if is_law and owner == "latolato":
            text += f"```python\n{example(thing)}\n```\n\n"
        users = [
            f"[{page[2:].partition(chr(10))[0]}]({path})"
            for path, page in pages().items()
            if any(re.search(rf"\b{name}\b", block) for block in PYTHON.findall(page))
        ]
        if users:
            text += f"Examples: {', '.join(users[:3])}.\n\n"
        elif not is_law or owner != "latolato":
            NO_EXAMPLE.append(f"{owner}.{name}")
    return text


def public_names() -> str:
    """Return the names of ``latolato``, grouped by the module that defines them."""
    groups: dict[str, list[str]] = {}
    for name in latolato.__all__:
        if name.startswith("__"):
            continue
        thing = getattr(latolato, name)
        if isinstance(thing, ModuleType):
            continue
        groups.setdefault(getattr(thing, "__module__", "latolato"), []).append(
            directive("latolato", name, thing)
        )
    parts = []
    for module, directives in groups.items():
        parts.append(f"### {first_line(importlib.import_module(module)).rstrip('.') or module}\n\n")
        parts += directives
    return "".join(parts)


def analysis_names() -> str:
    """Return the public names of ``latolato.analysis``, by the module that defines them."""
    import latolato.analysis

    parts = []
    public = set(latolato.analysis.__all__)
    for found in pkgutil.iter_modules(latolato.analysis.__path__, "latolato.analysis."):
        module = importlib.import_module(found.name)
        names = [
            name
            for name, thing in vars(module).items()
            if name in public and getattr(thing, "__module__", "") == found.name
        ]
        if not names:
            continue
        parts.append(f"### {first_line(module).rstrip('.')}\n\n`{found.name}`\n\n")
        parts += [directive(found.name, name, getattr(module, name)) for name in names]
    return "".join(parts)


def experiment_names() -> str:
    """Return the names that `EXPERIMENT` lists, by module."""
    parts = []
    for name, names in EXPERIMENT.items():
        owner = f"latolato.experiment.{name}"
        module = importlib.import_module(owner)
        parts.append(f"### {first_line(module).rstrip('.')}\n\n`{owner}`\n\n")
        parts += [directive(owner, each, getattr(module, each)) for each in names]
    return "".join(parts)


def misses() -> str:
    """Return a table of what public functions and observables can miss, by their docstrings."""
    import latolato.analysis

    rows = []
    for owner in (latolato, latolato.analysis):
        for name in sorted(owner.__all__):
            thing = getattr(owner, name)
            if not callable(thing):
                continue
            for part in re.split(r"\n\s*\n", inspect.getdoc(thing) or ""):
                said = " ".join(MISSES.findall(" ".join(part.split())))
                if said:
                    rows.append((f"`{name}`", re.sub("`+", "`", said).replace("|", r"\vert")))
    return table(("number", "what its docstring says"), rows)


def check_reference(reference: str) -> None:
    """Fail if a public name is not in the reference, or has no example."""
    import latolato.analysis

    public = {f"latolato.{name}" for name in latolato.__all__ if name != "analysis"}
    public |= {f".{name}" for name in latolato.analysis.__all__}
    for text in pages().values():
        for module, names in re.findall(r"from (latolato\.experiment\S*) import (.+)", text):
            public |= {f"{module}.{name.strip()}" for name in names.split(",")}
    missing = [name for name in public if not re.search(re.escape(name) + r"\n", reference)]
    if missing or NO_EXAMPLE:
        raise ValueError(f"not in the reference: {missing}; without an example: {NO_EXAMPLE}")


def command_line() -> str:
    """Return the reference that typer writes about the installed command, with examples."""
    arguments = ["-m", "typer", "latolato.cli.main", "utils", "docs", "--name", "latolato"]
    # A wide terminal without colours gives the same text on every machine.
    environment = {**os.environ, "COLUMNS": "100", "NO_COLOR": "1", "TERM": "dumb"}
    done = subprocess.run(
        [sys.executable, *arguments],
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
        check=True,
    )
    body = re.sub(r"\A# .*\n", "", done.stdout)  # cli.md has a title of its own
    shown = "\n".join(
        block
        for text in pages().values()
        for block in re.findall(r"```console\n(.*?)```", text, re.DOTALL)
    )
    parts = []
    for part in re.split(r"(?=^##+ `)", body.replace("```console", "```text"), flags=re.MULTILINE):
        title = re.match(r"(##+) `(.+)`\n", part)
        if title and title[2].split()[1] in ("analyze", "synthesize"):
            continue  # other spellings
        parts.append(part)
        if title:
            typed = re.search(rf"^\$ ({title[2]}(?: .*?)?(?<!\\))$", shown, re.M | re.DOTALL)
            if typed:
                parts.append(f"**Example**:\n\n```text\n$ {typed[1]}\n```\n\n")
            elif title[1] == "##":
                raise ValueError(f"no page shows an example of {title[2]}")
    return "".join(parts)


def write_generated() -> None:
    """Write every page that is made from the code."""
    from latolato.observables import observables
    from latolato.physics.drives import drives
    from latolato.physics.pendulum import systems

    written = {
        "glossary": glossary(),
        "analysis_glossary": analysis_glossary(),
        "systems": laws(systems),
        "drives": laws(drives),
        "observables": laws(observables),
        "fits": fit_words(),
        "api": public_names(),
        "analysis": analysis_names(),
        "experiment": experiment_names(),
        "misses": misses(),
        "cli": command_line(),
        "speed": ratios.page_table(ratios.history()[-1]),
    }
    check_reference(written["api"] + written["analysis"] + written["experiment"])
    GENERATED.mkdir(exist_ok=True)
    for name, text in written.items():
        (GENERATED / f"{name}.md").write_text(text, encoding="utf-8")
    (GENERATED / "layers.svg").write_text(drawing(), encoding="utf-8")
    ratios.draw(GENERATED / "speed.svg")


write_generated()


def drop_unused_mathjax(app: Any, error: Exception | None) -> None:
    """Keep the one bundle of MathJax that the pages load: the others hold 14 MB."""
    used = Path(app.outdir, "_static", app.config.mathjax_path)
    for bundle in used.parent.glob("*.js"):
        if error is None and bundle != used:
            bundle.unlink()


def setup(app: Any) -> None:
    """Tidy up after `sphinx-mathjax-offline`, whose own listener has the priority 500."""
    app.connect("build-finished", drop_unused_mathjax, priority=600)
