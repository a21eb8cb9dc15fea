"""Guided stories and challenges: their files, the numbers in them, and the scores of challenges.

A file is TOML in ``static/stories``; `docs/how-to/stories.md` describes it. ``schema.json`` beside
the files says which entries there are. Pages check files, compute numbers and scores themselves
(``js/story``): the tests compare both.
"""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.app import STATIC
from latolato.core.errors import InputError, reading
from latolato.core.registry import suggest
from latolato.physics.drives import PeriodicDrive
from latolato.scenario.options import law_options
from latolato.scenario.scenario import ALTERNATIVES, shipped
from latolato.scenario.units import to_si

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.responses import Response
    from starlette.routing import BaseRoute

    from latolato.scenario.scenario import Scenario

FOLDER = STATIC / "stories"
Tables = Mapping[str, Any]

# Samples from here on show how a motion has settled.
_LATE = 0.75
# Up to this angle a swing grows as the small-angle equation does [rad].
_SMALL = math.radians(20.0)


@cache
def schema() -> dict[str, Any]:
    """Return which entries files of stories have."""
    result: dict[str, Any] = json.loads((FOLDER / "schema.json").read_text(encoding="utf-8"))
    return result


def read(path: Path) -> dict[str, Any]:
    """Return the tables of a file, checked.

    Raises
    ------
    InputError
        If it is no TOML, or something in it is missing, unknown or of the wrong type.
    """
    with reading(path):
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError as error:
            raise InputError("this is not a text in UTF-8") from error
        tables = parse(text)
        check(tables)
    return tables


def parse(text: str) -> dict[str, Any]:
    """Return the tables of a text, unchecked."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        line = re.search(r"line (\d+)", str(error))
        number = line[1] if line else text.count("\n") + 1  # at the end of the file
        raise InputError(f"this is not TOML: look at line {number}") from error


def contents(folder: Path = FOLDER) -> list[dict[str, Any]]:
    """Return what a list of stories shows of each file in a folder: stories first, then challenges.

    A file that cannot be read has its ``error`` instead.
    """
    entries: list[dict[str, Any]] = []
    places: dict[str, tuple[int, float]] = {}
    kinds = schema()["kinds"]
    for path in sorted(folder.glob("*.toml")):
        try:
            tables = read(path)
        except InputError as error:
            error.where = ""
            entries.append({"name": path.stem, "kind": "broken", "error": str(error)})
            continue
        about = {each: tables[each] for each in ("title", "summary", "minutes")}
        kind, steps = tables.get("kind", "story"), len(tables.get("steps", []))
        order = tables.get("order", math.inf)
        entries.append({"name": path.stem, "kind": kind, "steps": steps, **about})
        places[path.stem] = (kinds.index(kind), order)
    return sorted(entries, key=lambda entry: places.get(entry["name"], (len(kinds), 0)))


def routes() -> list[BaseRoute]:
    """Return what the server answers about stories."""
    from starlette.routing import Route

    return [Route("/stories/contents.json", _contents)]


async def _contents(request: Request) -> Response:
    from starlette.responses import JSONResponse

    from latolato.app.answers import answered

    return await answered(request, lambda: JSONResponse(contents()))


def check(tables: Tables) -> None:
    """Raise InputError, with one sentence, if something is wrong with the tables of a file."""
    known = schema()
    number = tables.get("format", 1)
    if not (isinstance(number, int) and 1 <= number <= known["format"]):
        raise InputError(
            f"it has format {number}, and this version reads {known['format']} at most"
        )
    kind = tables.get("kind", "story")
    if kind not in known["kinds"]:
        raise InputError(f"there is no kind '{kind}': {suggest(kind, known['kinds'])}")
    _check_table(tables, kind, "")


def _check_table(table: Any, kind: str, where: str) -> None:
    """Check the entries of one table; `where` begins the sentences."""
    fields = schema()["tables"][kind]
    names = [name.rstrip("?") for name in fields]
    for name in table:
        if name not in names:
            raise InputError(f"{where}there is no entry '{name}': {suggest(name, names)}")
    for field, entry in fields.items():
        name = field.rstrip("?")
        if name in table:
            _check_value(table[name], entry, name, where)
        elif name == field:
            raise InputError(f"{where}{name} is missing")
    if kind in _CHECKS:
        _CHECKS[kind](table, where)


def _check_value(value: Any, entry: Any, name: str, where: str) -> None:
    """Check one value: `entry` is a type, a table of the schema, or such in a list."""
    known = schema()
    if isinstance(entry, list):
        kind, least, most = entry
        if not isinstance(value, list):
            raise InputError(f"{where}{name} must be a list")
        if not least <= len(value) <= most:
            raise InputError(f"{where}{name} must be {least} to {most}, got {len(value)}")
        for place, part in enumerate(value, start=1):
            _check_value(part, kind, f"{kind} {place}", where)
        return
    if entry in known["tables"]:
        if not isinstance(value, dict):
            raise InputError(f"{where}{name} must be a table")
        _check_table(value, entry, f"{where.removesuffix(': ')}{', ' if where else ''}{name}: ")
        return
    is_right, words = _TYPES[_BASIC.get(entry, entry)]
    if not is_right(value):
        raise InputError(f"{where}{name} must be {words}")
    if entry in _KNOWN:
        _known(str(value), _KNOWN[entry](), f"{where}there is no {entry} '{value}'")
    if entry == "angle":
        _within(where, to_si, name, value, "rad")


def _known(value: str, names: list[str], sentence: str) -> None:
    if value not in names:
        raise InputError(f"{sentence}: {suggest(value, names)}")


def _within(where: str, work: Callable[..., object], *arguments: Any) -> None:
    """Call a function; a refusal says where in the file it belongs."""
    try:
        work(*arguments)
    except InputError as error:
        raise InputError(f"{where}{error}") from error


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and value > 0


def _is_table_of(*kinds: type) -> Callable[[Any], bool]:
    return lambda value: (
        isinstance(value, dict) and all(isinstance(part, kinds) for part in value.values())
    )


_TYPES: dict[str, tuple[Callable[[Any], bool], str]] = {
    "text": (lambda value: isinstance(value, str) and bool(value.strip()), "a text"),
    "number": (_is_number, "a number above zero"),
    "whole": (lambda value: isinstance(value, int), "a whole number"),
    "switch": (lambda value: isinstance(value, bool), "true or false"),
    "options": (_is_table_of(str, int, float, list), "a table of options"),
    "extra": (
        lambda value: _is_table_of(str)(value) and all("." in name for name in value),
        'a table of texts with names such as "map.x"',
    ),
}
# What is written as a text.
_BASIC = dict.fromkeys(
    ("kind", "view", "preset", "parameter", "quantity", "angle", "limit", "rule"), "text"
)
_KNOWN: dict[str, Callable[[], list[str]]] = {
    "view": lambda: schema()["views"],
    "preset": lambda: list(shipped()),
    "parameter": lambda: list(law_options()),
    "quantity": lambda: list(schema()["quantities"]),
    "rule": lambda: list(schema()["rules"]),
}


def _check_look(look: Tables, where: str) -> None:
    from latolato.app.run_request import RunRequest

    request = RunRequest(look["preset"], look.get("options", {}))
    _within(where, request.to_scenario)


def _check_predict(predict: Tables, where: str) -> None:
    right = sum(choice.get("right", False) for choice in predict["choices"])
    if right != 1:
        raise InputError(f"{where}one choice must be right, got {right}")


def _check_condition(condition: Tables, where: str) -> None:
    subjects = [name for name in ("parameter", "quantity", "address") if name in condition]
    if len(subjects) != 1:
        raise InputError(f"{where}name one of parameter, quantity, address")
    for end in ("at_least", "at_most"):
        if end in condition and subjects != ["address"]:
            _within(where, _limit, condition, end)
    _check_angle(condition, where)


def _check_angle(table: Tables, where: str) -> None:
    """Raise InputError if a quantity or a rule is about an angle and none is given."""
    name = table.get("quantity") or table.get("rule")
    if name in schema()["need_angle"] and "angle" not in table:
        raise InputError(f"{where}angle is missing: {name} needs one")


def _check_task(task: Tables, where: str) -> None:
    _check_angle(task, where)
    if task["rule"] == "guess_tongue" and "ratios" not in task:
        raise InputError(f"{where}ratios is missing: guess_tongue needs them")
    _within(where, to_si, "par", task["par"], schema()["rules"][task["rule"]])


def _limit(condition: Tables, end: str) -> float:
    """Return a limit of a condition [SI]."""
    quantity = condition.get("quantity")
    unit = (
        schema()["quantities"][quantity] if quantity else law_options()[condition["parameter"]].unit
    )
    return float(to_si(end, condition[end], unit))


_CHECKS: dict[str, Callable[[Tables, str], None]] = {
    "look": _check_look,
    "predict": _check_predict,
    "condition": _check_condition,
    "number_shown": _check_angle,
    "task": _check_task,
}


class Run(NamedTuple):
    """What numbers are made of.

    Attributes
    ----------
    time : array (time,)
        Instants [s].
    angle : array (ball, time)
        Angles [rad].
    contact_time, contact_kind : array (contact,)
        Instants [s] and names of contacts.
    strobe : array (period,)
        Instants at which the drive begins a period [s].
    options : mapping
        All options [SI].
    scenario : Scenario
        What was run.
    """

    time: NDArray[np.float64]
    angle: NDArray[np.float64]
    contact_time: NDArray[np.float64]
    contact_kind: list[str]
    strobe: NDArray[np.float64]
    options: Mapping[str, Any]
    scenario: Scenario


def run_of(preset: str, options: Mapping[str, Any]) -> Run:
    """Return the run that a page shows for a preset and options."""
    from latolato.app.run_request import RunRequest, options_of
    from latolato.app.runs import USUAL_SAMPLES, arrays_of, sampled, scenario_of

    scenario: Scenario = scenario_of(RunRequest(preset, options))
    record = scenario.record(**sampled(scenario, USUAL_SAMPLES))
    arrays = arrays_of(scenario, record, ["angle"])
    return Run(
        time=arrays["time"],
        angle=arrays["angle"],
        contact_time=arrays["contact_time"],
        contact_kind=[str(kind) for kind in np.asarray(record["contact_kind"])],
        strobe=arrays["strobe"],
        options=options_of(scenario),
        scenario=scenario,
    )


def quantity(name: str, run: Run, angle: float = math.nan) -> float:
    """Return a quantity of a run [SI]: nan where the run has none, as for what never happens.

    Parameters
    ----------
    name : str
        One of the quantities in ``schema.json``.
    run : Run
        What moves.
    angle : float
        For `time_to_angle`, which angle [rad].

    Examples
    --------
    >>> run = run_of("fig02", {"drive_amplitude": "0 m", "duration": "20 s"})
    >>> round(quantity("swing_period", run), 3)
    2.007
    """
    return float(_QUANTITIES[name](run, angle))


def _largest_angle(run: Run, _: float) -> Any:
    return np.abs(run.angle).max()


def _late_angle(run: Run, _: float) -> Any:
    return np.abs(run.angle[:, run.time >= _LATE * run.time[-1]]).max()


def _time_to_angle(run: Run, angle: float) -> Any:
    """Return when the first ball first reaches an angle, linear between samples [s]."""
    size = np.abs(run.angle[0])
    after = int(np.argmax(size >= angle))
    if size[after] < angle or after == 0:
        return 0.0 if size[after] >= angle else math.nan
    share = (angle - size[after - 1]) / (size[after] - size[after - 1])
    return run.time[after - 1] + share * (run.time[after] - run.time[after - 1])


def _top_time(run: Run, _: float) -> Any:
    tops = (
        time for time, kind in zip(run.contact_time, run.contact_kind, strict=True) if kind == "top"
    )
    return next(tops, math.nan)


def _contacts(run: Run, _: float) -> Any:
    return sum(kind in ("bottom", "top") for kind in run.contact_kind)


def _swing_period(run: Run, _: float) -> Any:
    """Return the mean time between passages upwards through zero, in the second half [s]."""
    late = run.time >= 0.5 * run.time[-1]
    time, angle = run.time[late], run.angle[0, late]
    before = np.flatnonzero((angle[:-1] < 0.0) & (angle[1:] >= 0.0))
    if len(before) < 2:
        return math.nan
    i = before[[0, -1]]
    first, last = time[i] - angle[i] * (time[i + 1] - time[i]) / (angle[i + 1] - angle[i])
    return (last - first) / (len(before) - 1)


def _response_period(run: Run, _: float) -> Any:
    """Return what the observable of this name says of a map's point, of the right ball."""
    system, drive = run.scenario.system, run.scenario.drive
    if not isinstance(drive, PeriodicDrive):
        return math.nan
    point = {"axes": {"gravity": [system.gravity]}, "observables": ["response_period"]}
    return replace(run.scenario, varied=point).sweep()["response_period"].values.flat[0]


def _growth_rate(run: Run, _: float) -> Any:
    """Return the slope of the logarithm of the peaks up to the first that is not small [1/s].

    Of these peaks the later half counts: what dies away has gone by then.
    """
    size = np.abs(run.angle[0])
    peaks = 1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:]))
    large = np.flatnonzero(size[peaks] > _SMALL)
    peaks = peaks[: large[0]] if len(large) else peaks
    peaks = peaks[len(peaks) // 2 :]
    if len(peaks) < 2:
        return math.nan
    return np.polyfit(run.time[peaks], np.log(size[peaks]), 1)[0]


def _fastest_drive(run: Run) -> float:
    """Return the largest angular frequency of the drive [rad/s]."""
    options = run.options
    return float(np.max(options.get("drive_frequencies", options.get("drive_frequency", math.nan))))


def _drive_speed(run: Run, _: float) -> Any:
    return run.options.get("drive_amplitude", math.nan) * _fastest_drive(run)


def _drive_acceleration_ratio(run: Run, _: float) -> Any:
    return _drive_speed(run, _) * _fastest_drive(run) / run.options["gravity"]


_QUANTITIES: dict[str, Callable[[Run, float], Any]] = {
    "largest_angle": _largest_angle,
    "late_angle": _late_angle,
    "final_angle": lambda run, _: run.angle[0, -1],
    "farthest_from_top": lambda run, _: np.abs(math.pi - np.abs(run.angle)).max(),
    "time_to_angle": _time_to_angle,
    "top_time": _top_time,
    "contacts": _contacts,
    "top_contacts": lambda run, _: run.contact_kind.count("top"),
    "swing_period": _swing_period,
    "shakes_per_swing": lambda run, _: _swing_period(run, _) * _fastest_drive(run) / math.tau,
    "response_period": _response_period,
    "growth_rate": _growth_rate,
    "drive_speed": _drive_speed,
    "drive_acceleration_ratio": _drive_acceleration_ratio,
}


class Score(NamedTuple):
    """What somebody reached in a challenge; less is better.

    Attributes
    ----------
    value : float
        The score [SI], nan if the goal was not reached.
    unit : str
        Its unit.
    beats_par : bool
        Whether it is at least as good as the challenge asks for.
    """

    value: float
    unit: str
    beats_par: bool


def score(challenge: Tables, options: Mapping[str, Any]) -> Score:
    """Return the score of a challenge.

    Parameters
    ----------
    challenge : mapping
        The tables of its file.
    options : mapping
        The options that the player chose, as texts; what the challenge does not leave free counts
        not. For ``guess_tongue`` the entry ``guess`` holds one amplitude for each ratio, such as
        ``"30 mm, 12 mm"``.

    Examples
    --------
    >>> challenge = read(FOLDER / "least_amplitude.toml")
    >>> score(challenge, {"drive_amplitude": "60 mm"})
    Score(value=0.06, unit='m', beats_par=False)
    """
    task, look = challenge["task"], challenge["look"]
    free = {name: options[name] for name in task["free"] if name in options}
    given = {**_without(look.get("options", {}), free), **free}
    unit = schema()["rules"][task["rule"]]
    value = float(_RULES[task["rule"]](task, look["preset"], given, options))
    return Score(value, unit, value <= to_si("par", task["par"], unit))


def _without(options: Tables, replaced: Tables) -> dict[str, Any]:
    """Return the options that are not said in another way by those that replace them."""
    gone = {name for group in ALTERNATIVES for name in group if group & replaced.keys()}
    return {name: value for name, value in options.items() if name not in gone}


def _least_amplitude(_: Tables, preset: str, options: Tables, __: Tables) -> float:
    run = run_of(preset, options)
    reached = "top" in run.contact_kind
    return float(run.options["drive_amplitude"]) if reached else math.nan


def _shortest_time(task: Tables, preset: str, options: Tables, _: Tables) -> float:
    return quantity("time_to_angle", run_of(preset, options), to_si("angle", task["angle"], "rad"))


def _guess_tongue(task: Tables, preset: str, options: Tables, given: Tables) -> float:
    from latolato.analysis.mathieu import mathieu_threshold_amplitude
    from latolato.app.run_request import RunRequest

    if "guess" not in given:
        example = ", ".join(["10 mm"] * len(task["ratios"]))
        raise InputError("is missing", parameter="guess", way_out=f'give "{example}"')
    guesses = [to_si("guess", part.strip(), "m") for part in str(given["guess"]).split(",")]
    if len(guesses) != len(task["ratios"]):
        raise InputError(f"guess must hold {len(task['ratios'])} amplitudes, got {len(guesses)}")
    system = RunRequest(preset, options).to_scenario().system
    [ball] = system.balls
    edges = [
        mathieu_threshold_amplitude(
            frequency_ratio=ratio,
            length=ball.length,
            mass=ball.mass,
            damping=ball.damping,
            gravity=system.gravity,
        )
        for ratio in task["ratios"]
    ]
    return float(np.mean(np.abs(np.subtract(guesses, edges))))


_RULES: dict[str, Callable[[Tables, str, Tables, Tables], float]] = {
    "least_amplitude": _least_amplitude,
    "shortest_time": _shortest_time,
    "guess_tongue": _guess_tongue,
}
