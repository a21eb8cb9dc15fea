"""The set-up of a track, kept next to its table as TOML: enough to make the same table again."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Callable, Collection, Mapping, Sized
from dataclasses import asdict, dataclass, field, fields, replace
from functools import partial
from numbers import Real
from pathlib import Path
from types import NoneType
from typing import Any, Final, Literal, get_args

from latolato.core.atomic import atomic_path
from latolato.core.errors import InputError, reading
from latolato.core.quantities import NON_NEGATIVE, Range
from latolato.core.registry import checked_count, suggest, types_of
from latolato.core.versions import version_of
from latolato.experiment.calibration.lens import Optics
from latolato.experiment.parameters import CLIP, LOOK, SHAPES, VIDEO_PARAMETERS
from latolato.experiment.rules import broken
from latolato.experiment.video import Limits, digest_of
from latolato.physics.pendulum import GRAVITY

SUFFIX = ".track.toml"
# Shortest stick whose ends are told apart well enough for a scale [pixels].
_SHORTEST = 8.0
# What a file holds before its tables, and the tables.
_HEAD = ("video", "sha256", "latolato")
_TABLES = {
    "clip": (*(one.name for one in CLIP), "region"),
    "look": tuple(one.name for one in LOOK),
    "geometry": (
        "pivot", "pivot_2", "own_pivots", "balls", "corrections", "length", "radius", "stick",
        "stick_length", "gravity", "proposed", "pivot_found",
    ),
    "camera": ("slow_motion", *(one.name for one in fields(Optics))),
    "limits": tuple(one.name for one in fields(Limits)),
}  # fmt: skip
Place = tuple[float, float]
Correction = tuple[int, int, float, float]
# What is given for a pivot that the picture does not show, and whose place is not known.
OUTSIDE: Final = "outside"
Pivot = Place | Literal["outside"]


@dataclass(frozen=True, kw_only=True)
class Setup:
    """Everything besides the video that a track table depends on.

    Parameters
    ----------
    pivot : tuple of float or None
        Column and row of the pivot in the clicked frame as displayed [pixels]; None if it is not in
        the picture.
    balls : tuple of tuple of float
        The same of each ball's centre.
    pivot_2 : tuple of float or None
        The same of the second ball's own pivot.
    has_own_pivots : bool
        Whether the second of two balls has a pivot of its own.
    start, end : float or None
        First and last instant used [s].
    click_frame : int
        Number in the file of the frame in which pivot and balls are pointed at.
    region : tuple of float or None
        Left, top, right and bottom of the part in which to look for balls [pixels].
    shape : str
        How balls are recognised: ``"disc"`` or ``"template"``.
    patch : float or None
        Side of the square about the click that the template is made of [pixels].
    length, radius : float or None
        From pivot to ball centre, and of a ball [m].
    stick : tuple of tuple of float or None
        Column and row of both ends of a stick of known length [pixels].
    stick_length : float or None
        Its length [m].
    gravity : float
        Gravitational acceleration [m/s^2].
    optics : Optics
        What the user declares about the camera.
    slow_motion : float
        How many times slower than life the video plays.
    limits : Limits
        The largest videos that are read.
    corrections : tuple of tuple
        Number in the file of a frame, ball from 1 on, column and row of the ball's centre there
        [pixels], as set by hand.
    is_proposed : bool
        Whether anything of pivot and balls was found in the video instead of pointed at.
    is_pivot_found : bool
        Whether the pivot was.

    Raises
    ------
    InputError
        For a place that is none, and a number that is out of its range.
    """

    pivot: Place | None
    balls: tuple[Place, ...]
    start: float | None = None
    end: float | None = None
    click_frame: int = 0
    region: tuple[float, float, float, float] | None = None
    shape: str = SHAPES[0]
    patch: float | None = None
    length: float | None = None
    radius: float | None = None
    stick: tuple[Place, Place] | None = None
    stick_length: float | None = None
    gravity: float = GRAVITY
    optics: Optics = field(default_factory=Optics)
    slow_motion: float = 1.0
    limits: Limits = field(default_factory=Limits)
    corrections: tuple[Correction, ...] = ()
    is_proposed: bool = False
    is_pivot_found: bool = False
    pivot_2: Place | None = None
    has_own_pivots: bool = False

    def __post_init__(self) -> None:
        for name, check in _CHECKS.items():
            value = getattr(self, name)
            if value is not None or name not in _OPTIONAL:
                object.__setattr__(self, name, check(value))

    @property
    def pivots(self) -> tuple[Place | None, ...]:
        """The pivot that each ball swings about, None for one that is not in the picture."""
        second = self.pivot_2 if self.has_own_pivots else self.pivot
        return (self.pivot, second)[: len(self.balls)]


def sidecar_path(table: str | Path) -> Path:
    """The path of a track table's set-up: ``TABLE.track.toml`` beside it.

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
    values = {
        **vars(setup),
        **asdict(setup.optics),
        **asdict(setup.limits),
        "own_pivots": setup.has_own_pivots or None,
        "corrections": setup.corrections or None,
        "proposed": setup.is_proposed,
        "pivot_found": setup.is_pivot_found or None,
    }
    head = {"video": Path(video).name, "sha256": digest_of(video), "latolato": version_of()}
    lines = [
        "# How this video was tracked: latolato track VIDEO --sidecar FILE makes the same table.",
        "# Places are columns and rows of the clicked frame as displayed; all else is in SI units.",
        *_lines(head),
    ]
    for table, names in _TABLES.items():
        lines += ["", f"[{table}]", *_lines({name: values[name] for name in names})]
    lines.append("")
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
    with reading(path, gives_values=True):
        tables = _parsed(path)
        if tables["sha256"] != digest_of(video):
            raise InputError(
                f"it belongs to another video ('{tables.get('video', '?')}' with other content "
                f"than '{video}')",
                way_out="remove it, or point at pivot and balls",
            )
        return _setup(tables)


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
        raise InputError(f"it is not a TOML file: {error}") from None
    except RecursionError:
        raise InputError("it is nested too deeply for a set-up") from None
    if not isinstance(tables.get("sha256"), str):
        raise InputError("it does not name its video (sha256)", way_out="remove it")
    return tables


def _setup(tables: Mapping[str, Any]) -> Setup:
    """Return the set-up of parsed tables, checked."""
    _check_names("", tables, (*_HEAD, *_TABLES))
    values: dict[str, Any] = {}
    for name, known in _TABLES.items():
        table = tables.get(name, {})
        if not isinstance(table, Mapping):
            raise InputError("must be a table", parameter=name)
        _check_names(f"{name}.", table, known)
        values |= table

    def popped(kind: type) -> Any:
        """Return the optics or the limits."""
        return kind(**{f.name: values.pop(f.name) for f in fields(kind) if f.name in values})

    setup = Setup(
        pivot=values.pop("pivot", None),
        balls=values.pop("balls", ()),
        has_own_pivots=bool(values.pop("own_pivots", False)),
        is_proposed=bool(values.pop("proposed", False)),
        is_pivot_found=bool(values.pop("pivot_found", False)),
        optics=popped(Optics),
        limits=popped(Limits),
        **values,
    )
    if len(setup.balls) not in (1, 2):
        raise InputError("geometry.balls must hold one place or two")
    if setup.has_own_pivots and len(setup.balls) != 2:
        raise InputError("geometry.own_pivots needs two balls")
    return setup


def _check_names(where: str, table: Mapping[str, Any], known: tuple[str, ...]) -> None:
    """Raise InputError for a name that is not known."""
    for name in table:
        if name not in known:
            raise InputError(f"unknown '{where}{name}': {suggest(name, list(known))}")


def checked_place(name: str, value: Any) -> Place:
    """Return column and row of a place [pixels], or raise if it is none."""
    is_pair = not isinstance(value, (str, Mapping)) and isinstance(value, Sized) and len(value) == 2
    if not is_pair or not all(isinstance(one, Real) and math.isfinite(one) for one in value):
        raise InputError("must be a column and a row in pixels", parameter=name, value=value)
    return float(value[0]), float(value[1])


def checked_stick(value: Any) -> tuple[Place, Place]:
    """Return both ends of a stick [pixels], or raise if they are none or hardly apart."""
    if isinstance(value, str) or not isinstance(value, Collection) or len(value) != 2:
        raise InputError("must be two places in pixels", parameter="stick", value=value)
    one, other = (checked_place("stick", end) for end in value)
    apart = math.dist(one, other)
    if apart < _SHORTEST:
        raise broken("short_stick", {"least": _SHORTEST, "apart": apart})
    return one, other


def checked_correction(value: Any) -> Correction:
    """Return frame, ball, column and row of a place set by hand, or raise if it is none."""
    try:
        frame, ball, u, v = value
    except (TypeError, ValueError):
        raise InputError(
            "must be frame, ball, column and row", parameter="corrections", value=value
        ) from None
    place = checked_place("corrections", (u, v))
    return (
        checked_count("frame of a correction", frame, NON_NEGATIVE),
        checked_count("ball of a correction", ball, Range(1, 2)),
        *place,
    )


def checked_region(value: Any) -> tuple[float, float, float, float]:
    """Return left, top, right and bottom of a part of the picture [pixels], or raise."""
    try:
        left, top, right, bottom = (float(one) for one in value)
    except (TypeError, ValueError):
        left, top, right, bottom = 4 * (math.nan,)
    if not (left < right and top < bottom and math.isfinite(right - left + bottom - top)):
        raise InputError(
            "must be left, top, right and bottom in pixels", parameter="region", value=value
        )
    return left, top, right, bottom


def _checked_list(check: Callable[[Any], Any], name: str, values: Any) -> tuple[Any, ...]:
    """Return several places or corrections, each checked."""
    if isinstance(values, str) or not isinstance(values, Collection):
        raise InputError("must be a list", parameter=name, value=values)
    return tuple(check(value) for value in values)


# What a set-up may lack.
_OPTIONAL = {name for name, kind in types_of(Setup).items() if NoneType in get_args(kind)}
# Checks of the values of a set-up.
_CHECKS: dict[str, Callable[[Any], Any]] = {
    **{
        name: parameter.checked
        for name, parameter in VIDEO_PARAMETERS.items()
        if name in Setup.__dataclass_fields__
    },
    "pivot": partial(checked_place, "pivot"),
    "pivot_2": partial(checked_place, "pivot_2"),
    "balls": partial(_checked_list, partial(checked_place, "ball"), "balls"),
    "region": checked_region,
    "stick": checked_stick,
    "corrections": partial(_checked_list, checked_correction, "corrections"),
}


def _lines(values: Mapping[str, Any]) -> list[str]:
    """Return lines of TOML; None is left out."""
    return [f"{name} = {_value(value)}" for name, value in values.items() if value is not None]


def _value(value: Any) -> str:
    """Return a value as TOML, whose texts and numbers are those of JSON."""
    if isinstance(value, (tuple, list)):
        return "[" + ", ".join(_value(part) for part in value) + "]"
    return json.dumps(value, ensure_ascii=False)
