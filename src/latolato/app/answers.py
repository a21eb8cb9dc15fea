"""Requests in JSON, and one line for the page where the server has no other answer."""

from __future__ import annotations

import json
from typing import Any

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from latolato.app.run_request import TooLargeError
from latolato.core.errors import InputError
from latolato.core.faults import line_of, refusal_of

# A request for numbers is a few kilobytes; a list of pivot heights may be more.
MOST_BODY = 2_000_000  # bytes
# `Exception` stands for faults of the program.
REFUSED = (HTTPException, InputError, OSError, MemoryError, Exception)


class MalformedError(InputError):
    """A request that is no JSON object, or lacks a part."""


class Body(dict[str, Any]):
    """A JSON object of a request; what it lacks is the fault of who sent it."""

    def __missing__(self, name: str) -> Any:
        raise MalformedError(f"a request like this needs '{name}'")


async def json_of(request: Request) -> Body:
    """Return the JSON of a request.

    Raises
    ------
    HTTPException
        If it is too long.
    MalformedError
        If it is not what pages send.
    """
    if int(request.headers.get("content-length", MOST_BODY + 1)) > MOST_BODY:
        raise HTTPException(413, f"a request must not exceed {MOST_BODY} bytes")
    return body_of(await request.body())


def body_of(text: str | bytes) -> Body:
    """Return the request that a page sends as JSON.

    Raises
    ------
    MalformedError
        If it is not what pages send.
    """
    try:
        body = json.loads(text, object_hook=Body)
    except (ValueError, RecursionError):
        raise MalformedError("a request must be JSON") from None
    if not isinstance(body, Body):
        raise MalformedError("a request must be a JSON object")
    return body


def refused(request: Request, error: Exception) -> Response:
    """Return one line that says why there is no other answer, and the option that it is about.

    A malformed request is 400, bad input 422, what is too large 413, a fault of the program 500.
    """
    if isinstance(error, HTTPException):
        return JSONResponse(message_of(InputError(error.detail)), error.status_code)
    is_fault = refusal_of(error) is None
    status = 500 if is_fault else 422
    for kind, code in ((MalformedError, 400), (TooLargeError, 413)):
        status = code if isinstance(error, kind) else status
    return JSONResponse(message_of(error), status)


def message_of(error: Exception) -> dict[str, Any]:
    """Return one line on an error, the parameter that it is about, and the parts of refused input.

    From the parts, `InputError.parts`, a page writes the line in its own words.

    Examples
    --------
    >>> message = message_of(InputError("must be in m", parameter="initial_angle[1]", value="x"))
    >>> message["error"], message["field"]
    ("initial_angle[1] must be in m, got 'x'", 'initial_angle')
    """
    message: dict[str, Any] = {"error": line_of(error), "field": None, "parts": None}
    if isinstance(error, InputError):
        message["parts"] = error.parts()
        if error.parameter is not None:
            message["field"] = error.parameter.partition("[")[0]
    return message
