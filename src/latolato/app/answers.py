"""Requests in JSON, and one line for the page where the server has no other answer."""

from __future__ import annotations

from typing import Any

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from latolato.app.run_request import TooLargeError
from latolato.core.errors import InputError
from latolato.core.faults import line_of, refusal_of

# What a page asks about tables beside the options of laws.
_OF_TABLES = ("decimal",)
# A request for numbers is a few kilobytes; a list of pivot heights may be more.
MOST_BODY = 2_000_000  # bytes
# `Exception` stands for faults of the program.
REFUSED = (HTTPException, InputError, OSError, MemoryError, Exception)


async def json_of(request: Request) -> Any:
    """Return the JSON of a request.

    Raises
    ------
    HTTPException
        If it is too long or no JSON.
    """
    if int(request.headers.get("content-length", MOST_BODY + 1)) > MOST_BODY:
        raise HTTPException(413, f"a request must not exceed {MOST_BODY} bytes")
    try:
        return await request.json()
    except (ValueError, RecursionError):
        raise HTTPException(400, "a request must be JSON") from None


def refused(request: Request, error: Exception) -> Response:
    """Return one line that says why there is no other answer, and the option that it is about.

    Bad input is 422, what is too large 413, a fault of the program 500.
    """
    if isinstance(error, HTTPException):
        return JSONResponse(message_of(InputError(error.detail)), error.status_code)
    is_fault = refusal_of(error) is None
    status = 413 if isinstance(error, TooLargeError) else 500 if is_fault else 422
    return JSONResponse(message_of(error), status)


def message_of(error: Exception) -> dict[str, Any]:
    """Return the message of an error for a page, the option that it is about, and its parts.

    The message calls the option what the page calls it. Of its parts, `InputError.parts`, a page
    makes it in another language; they are None for a fault of the program.

    Examples
    --------
    >>> message = message_of(InputError("must be in m", parameter="drive_amplitude", value="x"))
    >>> message["error"], message["field"]
    ("“driving amplitude” must be in m, got 'x'", 'drive_amplitude')
    """
    from latolato.app.forms import label_of

    field = field_of(error)
    if not isinstance(error, InputError) or field is None:
        return {"error": line_of(error), "field": None, "parts": parts_of(error)}
    text = error.worded(f"“{label_of(field)}”")
    return {"error": text, "field": field, "parts": parts_of(error)}


def parts_of(error: Exception) -> dict[str, Any] | None:
    """Return the parts of refused input, None of another fault."""
    return error.parts() if isinstance(error, InputError) else None


def field_of(error: Exception) -> str | None:
    """Return the option of a run or a table that an error is about."""
    from latolato.scenario.options import law_options

    name = parameter_of(error)
    return name if name in law_options() or name in _OF_TABLES else None


def parameter_of(error: Exception) -> str | None:
    """Return the name of the parameter that an error is about, without the number of its value."""
    if not isinstance(error, InputError) or error.parameter is None:
        return None
    return error.parameter.partition("[")[0]  # of initial_angle[1]
