"""What a page asks for: an analysis, its system and drive, and the options typed for it."""

from __future__ import annotations

import inspect
import re
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from latolato.analysis.rules import broken_analysis
from latolato.app.lines import constructor, literal
from latolato.app.run_request import RunRequest, TooLargeError
from latolato.core.errors import InputError
from latolato.core.parameters import flag_of
from latolato.core.rules import broken_rule

if TYPE_CHECKING:
    from latolato.core.parameters import Parameter

# Numbers of one list.
MOST_LISTED = 10_000
_RANGE = re.compile(r"\s*[-+.\d][^:/\\]*:\s*[-+.\d][^:/\\]*:\s*(?P<count>\d{1,9})(?!\d)[^:/\\]*")


@dataclass(frozen=True)
class AnalysisRequest:
    """An analysis, what it is of, and the options that were typed for it."""

    name: str
    request: RunRequest
    settings: Mapping[str, str]

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> AnalysisRequest:
        """The request in a page's ``{"analysis", "scenario", "options", "settings": texts}``."""
        settings = {n: v.strip() for n, v in value.get("settings", {}).items() if v.strip()}
        return cls(value["analysis"], RunRequest.from_json(value), settings)

    @property
    def function(self) -> Callable[..., Any]:
        """The analysis."""
        from latolato.analysis import analyses

        return analyses[self.name]

    def arguments(self) -> dict[str, Any]:
        """The keyword arguments of the analysis, as `latolato analyse` would pass them.

        Raises
        ------
        InputError
            For wrong values and units, and for what the analysis needs and nobody gave.
        """
        from latolato.scenario.analysis_call import AnalysisCall
        from latolato.scenario.analysis_options import options_of

        own = options_of(self.function)
        typed = {name: _typed(own[name], text) for name, text in self.settings.items()}
        scenario = self.request.to_scenario()
        call = AnalysisCall(self.name, self.function, own)
        try:
            return call.arguments(None, typed, scenario.to_dict())
        except InputError as error:
            if scenario.varied:
                error.add_way_out(
                    f"{scenario.name or 'this scenario'} is a map: take a point of it"
                )
            raise

    def python(self, arguments: Mapping[str, Any]) -> str:
        """Return a Python program that runs the same."""
        parameters = inspect.signature(self.function).parameters
        lines = [
            "import latolato as ll",
            f"from latolato.analysis import {self.name}",
            "",
            f"system = {constructor(arguments['system'])}",
        ]
        texts = ["system"]
        if arguments.get("drive") is not None:
            lines.append(f"drive = {constructor(arguments['drive'])}")
            texts.append("drive=drive")
        for name, value in arguments.items():
            if name in ("system", "drive") or value == parameters[name].default:
                continue
            is_law = hasattr(value, "__dataclass_fields__")
            texts.append(f"{name}={constructor(value) if is_law else literal(value)}")
        call = f"result = {self.name}({', '.join(texts)})"
        return "\n".join([*lines, call, f'll.plot(result).savefig("{self.name}.png")'])

    def command(self) -> str:
        """Return the command that runs the same, quoted for a shell."""
        from latolato.scenario.analysis_call import unfit_options
        from latolato.scenario.analysis_options import options_of
        from latolato.scenario.options import law_options

        own = options_of(self.function)
        unfit = set(unfit_options(self.function, own))
        words = ["latolato", "analyse", self.name.replace("_", "-")]
        if self.request.scenario:
            words.append(self.request.scenario)
        laws = law_options()
        request = {n: v for n, v in (self.request.options or {}).items() if v is not None}
        run = {n: v for n, v in request.items() if n in own and own[n].owner == "run"}
        law = {n: v for n, v in request.items() if n not in unfit and n not in run}
        for name, value in {**law, **run, **self.settings}.items():
            is_switch = own[name].kind is bool if name in own else laws[name].kind is bool
            flag = flag_of(name)
            if is_switch:
                is_on = str(value).lower() == "true"
                if is_on or name in own:
                    words.append(flag if is_on else f"--no-{flag[2:]}")
                continue
            listed = isinstance(value, (list, tuple))
            text = ", ".join(map(str, value)) if listed else str(value)
            words += [f"{flag}={text}"] if text.startswith("-") else [flag, text]
        return shlex.join(words)


def _typed(option: Parameter, text: str) -> Any:
    """The value that an option's text stands for.

    Raises
    ------
    InputError
        If it is of another kind.
    """
    if option.several:
        if ":" in text:
            match = _RANGE.fullmatch(text)
            if match is None:
                raise broken_analysis("range_of_values", parameter=option.name, value=text)
            if int(match["count"]) > MOST_LISTED:
                raise _too_many(option)
            return text
        parts = [part.strip() for part in text.split(",") if part.strip()]
        if len(parts) > MOST_LISTED:
            raise _too_many(option)
        return parts[0] if option.or_one and len(parts) == 1 else parts
    if option.kind is bool:
        if text.lower() not in ("true", "false"):
            raise broken_analysis("true_or_false", parameter=option.name, value=text)
        return text.lower() == "true"
    if option.kind is int:
        if not re.fullmatch(r"[-+]?\d{1,18}", text):
            raise broken_rule("whole_number", parameter=option.name, value=text)
        return int(text)
    return text


def _too_many(option: Parameter) -> InputError:
    """Return the error of a list that is too long."""
    return broken_analysis(
        "most_values", {"limit": MOST_LISTED}, parameter=option.name, kind=TooLargeError
    )
