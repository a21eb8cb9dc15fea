"""The one error of refused input."""

from __future__ import annotations

from typing import Any

_NOT_GIVEN: Any = object()


class InputError(ValueError):
    """Input that breaks a rule; everything else that is raised is a fault of the program.

    Its text is one line, made of its parts: ``radius must lie in [0, length), got 0.5; give less
    than 0.4``. Programs read the parts, never the text.

    Parameters
    ----------
    rule : str
        What must hold, as the rest of a sentence that begins with the parameter's name; a whole
        sentence if no single parameter is at fault.
    parameter : str, optional
        Name of the parameter at fault.
    value : object, optional
        What was given for it.
    way_out : str, optional
        What to give or do instead.

    Examples
    --------
    >>> error = InputError("must lie in [0, 1]", parameter="restitution", value=2, way_out="give 1")
    >>> print(error)
    restitution must lie in [0, 1], got 2; give 1
    >>> error.parameter
    'restitution'
    """

    def __init__(
        self,
        rule: str,
        *,
        parameter: str | None = None,
        value: Any = _NOT_GIVEN,
        way_out: str | None = None,
    ) -> None:
        super().__init__(rule)
        self.rule = rule
        self.parameter = parameter
        self.value = None if value is _NOT_GIVEN else value
        self.has_value = value is not _NOT_GIVEN
        self.way_out = way_out

    def __str__(self) -> str:
        text = self.rule if self.parameter is None else f"{self.parameter} {self.rule}"
        if self.has_value:
            shown = f"{self.value:.9g}" if isinstance(self.value, float) else repr(self.value)
            text += f", got {shown}"
        return text if self.way_out is None else f"{text}; {self.way_out}"

    def __reduce__(self) -> tuple[Any, ...]:
        # Exceptions are rebuilt from `args` alone; one that comes from a worker keeps its parts.
        return _rebuilt, (self.rule, self.parameter, self.value, self.has_value, self.way_out)


def _rebuilt(
    rule: str, parameter: str | None, value: Any, has_value: bool, way_out: str | None
) -> InputError:
    given = value if has_value else _NOT_GIVEN
    return InputError(rule, parameter=parameter, value=given, way_out=way_out)
