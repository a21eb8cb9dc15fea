"""How views answer: in one of few threads, with one line where there is no other answer."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from typing import Any

import anyio
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection, Request
from starlette.responses import JSONResponse, Response

from latolato.app.run_request import TooLargeError
from latolato.core.errors import InputError
from latolato.core.faults import line_of, refusal_of

# What a page asks about tables beside the options of laws.
_OF_TABLES = ("decimal",)
# A request for numbers is a few kilobytes; a list of pivot heights may be more.
MOST_BODY = 2_000_000  # bytes
# Runs that are computed at the same time; others wait.
_WORKERS = 2


async def answered(request: HTTPConnection, work: Callable[..., Response], *given: Any) -> Response:
    """The response of `work`, run in a thread; refusals become one line for the page.

    Bad input is 422, what is too large 413, a fault of the program 500; ``field`` names the option
    that a message is about.
    """
    try:
        response: Response = await in_thread(request, work, *given)
        return response
    except Exception as error:
        return refusal(status_of(error), error)


async def in_thread(request: HTTPConnection, work: Callable[..., Any], *given: Any) -> Any:
    """The result of `work`, run in one of the few threads that compute."""
    state = request.app.state
    if state.workers is None:
        state.workers = anyio.CapacityLimiter(_WORKERS)
    return await anyio.to_thread.run_sync(partial(work, *given), limiter=state.workers)


async def json_of(request: Request) -> Any:
    """Return the JSON of a request.

    Raises
    ------
    HTTPException
        If it is too long or no JSON.
    """
    body = bytearray()
    async for part in request.stream():
        body += part
        if len(body) > MOST_BODY:
            raise HTTPException(413, f"a request must not exceed {MOST_BODY} bytes")
    try:
        return json.loads(body)
    except (ValueError, RecursionError):
        raise HTTPException(400, "a request must be JSON") from None


def status_of(error: Exception) -> int:
    """Return the status of an answer that an error prevented."""
    if isinstance(error, TooLargeError):
        return 413
    return 500 if refusal_of(error) is None else 422


def refusal(status: int, error: Exception) -> JSONResponse:
    """Return one line that says why there is no other answer, and the option that it is about."""
    return JSONResponse(message_of(error), status_code=status)


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
