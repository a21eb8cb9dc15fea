"""The local server: pages, numbers for them, and the guard around both."""

from __future__ import annotations

import json
import re
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import anyio
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import HTTPConnection, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route

from latolato.app.connections import ConnectionLimits
from latolato.app.files import page_file, static
from latolato.app.film_store import Allowance, Store
from latolato.app.given import Asked, TooLargeError
from latolato.app.guard import Guard
from latolato.core.errors import InputError, refusal_of, said_of
from latolato.io.progress import compiling

# A request for numbers is a few kilobytes; a list of pivot heights may be more.
MOST_BODY = 2_000_000  # bytes
# Addresses that stand for all of this machine's.
ANY_ADDRESS = ("0.0.0.0", "::")
# Runs that are computed at the same time; others wait.
_WORKERS = 2
# Names of options: those of one word are words of other sentences too, but not as "... must be".
_NAMES = re.compile(r"('?)\b([a-z]+(?:_[a-z]+)+)\b\1|^()([a-z]+)(?= must )")


@dataclass(frozen=True)
class Settings:
    """Where the server listens and who may use it.

    Attributes
    ----------
    host, port
        The address.
    token : str, optional
        The secret that every request must carry; needed for any address but this machine's own.
    names : sequence of str
        Further names by which browsers may call the server, with or without a port.
    report : Path, optional
        Folder of a reproduction report whose figures are shown.
    films : Allowance
        What uploaded videos may take.
    stored : mapping
        Stored maps that pages may open, by name.
    connections : ConnectionLimits
        What connections may take.
    """

    host: str = "127.0.0.1"
    port: int = 8000
    token: str | None = None
    names: Sequence[str] = ()
    report: Path | None = None
    films: Allowance = field(default_factory=Allowance)
    stored: Mapping[str, Path] = field(default_factory=dict)
    connections: ConnectionLimits = field(default_factory=ConnectionLimits)

    @property
    def known_hosts(self) -> frozenset[str]:
        """Values of ``Host`` that name this server, beside the address of the socket.

        A name without a port stands for this port and, for a proxy before this server, for none.
        """
        own = {"127.0.0.1", "localhost", "[::1]"}
        if self.host not in ANY_ADDRESS:
            own.add(f"[{self.host}]" if ":" in self.host else self.host)
        hosts = {f"{host}:{self.port}" for host in own} | (own if self.port == 80 else set())
        for name in self.names:
            hosts |= {name} if has_port(name) else {name, f"{name}:{self.port}"}
        return frozenset(host.lower() for host in hosts)


def has_port(name: str) -> bool:
    """Return whether a host is named with its port.

    Examples
    --------
    >>> has_port("lab.example:9000"), has_port("lab.example"), has_port("[fd00::1]")
    (True, False, False)
    """
    return ":" in name.rpartition("]")[2]


def make_app(settings: Settings) -> Starlette:
    """Return the application that serves the pages and computes for them."""
    app = Starlette(
        routes=[
            Route("/", _index),
            Route("/api/registry", _registry),
            Route("/api/compiling", _compiling),
            Route("/api/run", _run, methods=["POST"]),
            *_views(),
            Route("/static/{path:path}", static),
        ],
        middleware=[
            Middleware(
                Guard,
                names=settings.known_hosts,
                token=settings.token,
                # Browsers send a cookie to every port of a host.
                cookie=f"latolato_token_{settings.port}",
                first_frame_time=settings.connections.first_frame_time,
            )
        ],
        exception_handlers={HTTPException: _refused},
        lifespan=_lifespan,
    )
    app.state.workers = None
    app.state.jobs = None
    app.state.report = settings.report
    app.state.films = Store(settings.films)
    app.state.film_jobs = None
    app.state.maps = None
    app.state.map_cells = None
    app.state.stored = dict(settings.stored)
    app.state.is_compiling = False
    app.state.body_time = settings.connections.body_time
    return app


@asynccontextmanager
async def _lifespan(app: Starlette) -> AsyncIterator[None]:
    """Know when kernels compile; leave neither processes nor files behind in the end."""

    def note(is_compiling: bool) -> None:
        app.state.is_compiling = is_compiling

    with compiling(partial(note, True), partial(note, False)):
        yield
    for workers in (app.state.jobs, app.state.film_jobs):
        if workers is not None:
            workers.close()
    app.state.films.close()


def _views() -> list[BaseRoute]:
    """Return the routes that belong to single views."""
    from latolato.app import analyses, downloads, films, live, maps, paper

    views = (maps, live, downloads, paper, analyses, films)
    return [route for view in views for route in view.routes()]


async def answered(request: HTTPConnection, work: Callable[..., Response], *given: Any) -> Response:
    """Return what `work` answers in a thread; refusals become one line for the page.

    Bad input is 422, what is too large 413, a fault of the program 500; ``field`` names the option
    that a message is about.
    """
    try:
        response: Response = await in_thread(request, work, *given)
        return response
    except Exception as error:
        return refusal(status_of(error), error)


async def in_thread(request: HTTPConnection, work: Callable[..., Any], *given: Any) -> Any:
    """Return what `work` returns, in one of the few threads that compute."""
    state = request.app.state
    if state.workers is None:
        state.workers = anyio.CapacityLimiter(_WORKERS)
    return await anyio.to_thread.run_sync(partial(work, *given), limiter=state.workers)


async def json_of(request: Request) -> Any:
    """Return the JSON of a request.

    Raises
    ------
    HTTPException
        If it is too long, too slow or no JSON.
    """
    body = bytearray()
    seconds = request.app.state.body_time
    try:
        with anyio.fail_after(seconds):
            async for part in request.stream():
                body += part
                if len(body) > MOST_BODY:
                    raise HTTPException(413, f"a request must not exceed {MOST_BODY} bytes")
    except TimeoutError:
        raise HTTPException(408, f"a request must arrive within {seconds:g} s") from None
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
    return JSONResponse(told_of(error), status_code=status)


def told_of(error: Exception) -> dict[str, Any]:
    """Return what a page is told of an error: one line, and the option that it is about."""
    return {"error": in_words(said_of(error)), "field": field_of(error)}


def in_words(text: str) -> str:
    """Return a line for a page: what the page calls them stands for the names of options.

    Examples
    --------
    >>> in_words("drive_amplitude must be given in m, got 'x'")
    "“driving amplitude” must be given in m, got 'x'"
    >>> in_words("Harmonic needs 'drive_amplitude' [m]")
    'Harmonic needs “driving amplitude” [m]'
    """
    from latolato.app.forms import label_of
    from latolato.scenario.options import law_options

    def label(found: re.Match[str]) -> str:
        name = found[2] or found[4]
        return f"“{label_of(name)}”" if name in law_options() else found[0]

    return _NAMES.sub(label, text)


def field_of(error: Exception) -> str | None:
    """Return the option that an error is about: its parameter, or what its text names first."""
    from latolato.scenario.options import law_options

    if not isinstance(error, InputError):
        return None
    known = law_options()
    if error.parameter is not None:
        name = error.parameter.partition("[")[0]  # of initial_angle[1]
        return name if name in known else None
    words = str(error).replace("'", " ").replace("[", " ").replace(":", " ").split()
    return next((word for word in words if word in known), None)


async def _refused(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    return refusal(error.status_code, InputError(str(error.detail)))


async def _index(request: Request) -> Response:
    return page_file("index.html", request)


async def _registry(request: Request) -> Response:
    from latolato.app.forms import registry

    return await answered(request, lambda: JSONResponse(registry()))


async def _compiling(request: Request) -> Response:
    """Say whether a kernel is being compiled: then answers take long, once."""
    return JSONResponse({"compiling": request.app.state.is_compiling})


async def _run(request: Request) -> Response:
    given = await json_of(request)
    return await answered(request, _run_response, given)


def _run_response(given: Any) -> Response:
    from latolato.app.runs import USUAL_COLUMNS, run_block

    asked = Asked.from_json(given)
    columns, samples = given.get("columns", USUAL_COLUMNS), given.get("samples")
    if not isinstance(columns, (list, tuple)) or not all(isinstance(c, str) for c in columns):
        raise InputError("columns must be a list of names")
    return Response(run_block(asked, columns, samples), media_type="application/octet-stream")
