"""The set-up of a tracking, kept beside its table as TOML: enough to make the same table again."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from latolato.core.errors import InputError
from latolato.core.registry import suggest
from latolato.core.versions import version_of
from latolato.experiment.calibration.lens import Optics
from latolato.experiment.video import Limits, digest_of
from latolato.physics.pendulum import GRAVITY

SUFFIX = ".track.toml"
Place = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Setup:
    """Everything beside the video that a track table depends on.

    Parameters
    ----------
    pivot : tuple of float or None
        Column and row of the pivot in the first frame as displayed [pixels]; None where it is not
        in the picture.
    balls : tuple of tuple of float
        The same of each ball's centre.
    length, radius : float or None
        From pivot to ball centre, and of a ball [m].
    gravity : float
        Gravitational acceleration [m/s^2].
    optics : Optics
        What is declared of the camera.
    slow_motion : float
        How many times slower than life the video plays.
    limits : Limits
        What a video may ask for.
    is_proposed : bool
        Whether nobody pointed at pivot or balls: they were found in the video.
    """

    pivot: Place | None
    balls: tuple[Place, ...]
    length: float | None = None
    radius: float | None = None
    gravity: float = GRAVITY
    optics: Optics = field(default_factory=Optics)
    slow_motion: float = 1.0
    limits: Limits = field(default_factory=Limits)
    is_proposed: bool = False


def sidecar_path(table: str | Path) -> Path:
    """Return where the set-up of a track table is kept: ``TABLE.track.toml`` beside it.

    Examples
    --------
    >>> sidecar_path("tables/swing.csv").as_posix()
    'tables/swing.csv.track.toml'
    """
    table = Path(table)
    return table.with_name(f"{table.name}{SUFFIX}")


def own_sidecar(table: str | Path, video: str | Path) -> Path | None:
    """Return the set-up of an earlier table of this name and video, None if there is none.

    Raises
    ------
    ValueError
        If the file beside the table is no set-up.
    """
    path = sidecar_path(table)
    if not path.is_file() or _parsed(path)["sha256"] != digest_of(video):
        return None
    return path


def write_sidecar(setup: Setup, video: str | Path, path: str | Path) -> Path:
    """Write a set-up as TOML, whole or not at all, and return the path.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    from latolato.core.atomic import atomic_path

    geometry = {
        "pivot": setup.pivot,
        "balls": setup.balls,
        "length": setup.length,
        "radius": setup.radius,
        "gravity": setup.gravity,
        "proposed": setup.is_proposed,
    }
    camera = {"slow_motion": setup.slow_motion, **asdict(setup.optics)}
    head = {
        "video": Path(video).name,
        "sha256": digest_of(video),
        "latolato": version_of(),
    }
    lines = [
        "# How this video was tracked: latolato track reads this file and makes the same table.",
        "# Places are columns and rows of the first frame as displayed; all else is in SI units.",
        *_lines(head),
        "",
        "[geometry]",
        *_lines(geometry),
        "",
        "[camera]",
        *_lines(camera),
        "",
        "[limits]",
        *_lines(asdict(setup.limits)),
        "",
    ]
    path = Path(path)
    with atomic_path(path) as unfinished:
        unfinished.write_text("\n".join(lines), encoding="utf-8")
    return path


def read_sidecar(path: str | Path, video: str | Path) -> Setup:
    """Return the set-up in a file that `write_sidecar` wrote for this very video.

    Raises
    ------
    InputError
        If it is no such file, has unknown or wrong values, or belongs to another video.
    OSError
        If it cannot be read.
    """
    path = Path(path)
    tables = _parsed(path)
    if tables["sha256"] != digest_of(video):
        raise InputError(
            f"'{path}' belongs to another video ('{tables.get('video', '?')}' with other content "
            f"than '{video}')",
            way_out="remove it, or point at pivot and balls",
        )
    try:
        return _setup(tables)
    except InputError as error:
        raise InputError(f"'{path}': {error}") from None


def with_changes(setup: Setup, changes: Mapping[str, Any]) -> Setup:
    """Return a set-up with the values that are not None put in."""
    return replace(setup, **{name: value for name, value in changes.items() if value is not None})


def _parsed(path: Path) -> dict[str, Any]:
    """Return the tables of a set-up's file, which names its video."""
    if not path.is_file():
        raise FileNotFoundError(f"there is no file '{path}'")
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"'{path}' is no TOML file: {error}") from None
    except RecursionError:
        raise InputError(f"'{path}' is nested too deep for a set-up") from None
    if not isinstance(tables.get("sha256"), str):
        raise InputError(f"'{path}' does not name its video (sha256)", way_out="remove it")
    return tables


def _setup(tables: Mapping[str, Any]) -> Setup:
    """Return the set-up of parsed tables, checked."""
    known = ("video", "sha256", "latolato", "geometry", "camera", "limits")
    _check_names("", tables, known)
    geometry = dict(tables.get("geometry", {}))
    _check_names(
        "geometry", geometry, ("pivot", "balls", "length", "radius", "gravity", "proposed")
    )
    camera = dict(tables.get("camera", {}))
    optics = [one.name for one in fields(Optics)]
    _check_names("camera", camera, ("slow_motion", *optics))
    limits = dict(tables.get("limits", {}))
    _check_names("limits", limits, tuple(one.name for one in fields(Limits)))
    balls = geometry.get("balls", [])
    if not isinstance(balls, list) or len(balls) not in (1, 2):
        raise InputError("geometry.balls must hold one place or two")
    numbers = {name: _number(f"camera.{name}", value) for name, value in camera.items()}
    bounds = {name: _number(f"limits.{name}", value) for name, value in limits.items()}
    whole = {
        name: int(value) if name in ("pixels", "frames") else value
        for name, value in bounds.items()
    }
    return Setup(
        pivot=_place("geometry.pivot", geometry["pivot"]) if "pivot" in geometry else None,
        balls=tuple(_place("geometry.balls", ball) for ball in balls),
        length=_optional("length", geometry),
        radius=_optional("radius", geometry),
        gravity=_number("geometry.gravity", geometry.get("gravity", GRAVITY)),
        optics=Optics(**{name: value for name, value in numbers.items() if name != "slow_motion"}),
        slow_motion=numbers.get("slow_motion", 1.0),
        limits=Limits(**whole),  # type: ignore[arg-type]
        is_proposed=bool(geometry.get("proposed", False)),
    )


def _check_names(where: str, table: Any, known: tuple[str, ...]) -> None:
    """Raise InputError for a name that is not known."""
    if not isinstance(table, Mapping):
        raise InputError(f"{where} must be a table")
    for name in table:
        if name not in known:
            raise InputError(f"unknown '{where}{'.' if where else ''}{name}': "
                             f"{suggest(name, list(known))}")  # fmt: skip


def _number(name: str, value: Any) -> float:
    """Return a finite number."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InputError("must be a number", parameter=name, value=value)
    return float(value)


def _optional(name: str, table: Mapping[str, Any]) -> float | None:
    """Return a number that may be missing."""
    return _number(f"geometry.{name}", table[name]) if name in table else None


def _place(name: str, value: Any) -> Place:
    """Return a column and a row."""
    if not isinstance(value, list) or len(value) != 2:
        raise InputError("must be a column and a row", parameter=name, value=value)
    return _number(name, value[0]), _number(name, value[1])


def _lines(values: Mapping[str, Any]) -> list[str]:
    """Return lines of TOML; None is left out."""
    return [f"{name} = {_value(value)}" for name, value in values.items() if value is not None]


def _value(value: Any) -> str:
    """Return a value as TOML, whose texts and numbers are those of JSON."""
    if isinstance(value, (tuple, list)):
        return "[" + ", ".join(_value(part) for part in value) + "]"
    return json.dumps(value, ensure_ascii=False)
