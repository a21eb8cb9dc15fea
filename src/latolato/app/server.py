"""The local server: pages, numbers for them, and the guard around both."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Mount, Route

from latolato.app.answers import answered, json_of, refusal
from latolato.app.experiment.store import MOST_BYTES, Store
from latolato.app.guard import Guard
from latolato.app.pages import Report, page_file, static
from latolato.app.run_request import RunRequest
from latolato.core.errors import InputError


@dataclass(frozen=True)
class Settings:
    """What the server serves.

    Attributes
    ----------
    port
        Where it listens, on 127.0.0.1.
    report : Path, optional
        Folder of a reproduction report, which is served beside the pages.
    most_bytes : int
        Size of the largest file that a page may upload.
    stored : mapping
        Stored maps that pages may open, by name.
    """

    port: int = 8000
    report: Path | None = None
    most_bytes: int = MOST_BYTES
    stored: Mapping[str, Path] = field(default_factory=dict)


def make_app(settings: Settings) -> Starlette:
    """Return the application that serves the pages and computes for them."""
    app = Starlette(
        routes=[
            Route("/", _index),
            Route("/registry.json", _registry),
            Route("/api/run", _run, methods=["POST"]),
            *_views(),
            *([Mount("/report", Report(directory=settings.report))] if settings.report else []),
            Route("/{path:path}", static),
        ],
        middleware=[Middleware(Guard, port=settings.port)],
        exception_handlers={HTTPException: _refused},
        lifespan=_lifespan,
    )
    app.state.workers = None
    app.state.has_report = settings.report is not None
    app.state.clips = Store(settings.most_bytes)
    app.state.stored = dict(settings.stored)
    return app


@asynccontextmanager
async def _lifespan(app: Starlette) -> AsyncIterator[None]:
    """Leave neither processes nor files behind in the end."""
    yield
    app.state.clips.close()


def _views() -> list[BaseRoute]:
    """Return the routes that belong to single views."""
    from latolato.app import downloads, stories
    from latolato.app.analyse import routes as analyses
    from latolato.app.experiment import routes as clips
    from latolato.app.map import routes as maps

    views = (maps, downloads, analyses, clips, stories)
    return [route for view in views for route in view.routes()]


async def _refused(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    return refusal(error.status_code, InputError(str(error.detail)))


async def _index(request: Request) -> Response:
    return page_file("index.html", request)


async def _registry(request: Request) -> Response:
    from latolato.app.forms import registry

    about = {"server": True, "report": request.app.state.has_report}
    return await answered(request, lambda: JSONResponse(registry() | about))


async def _run(request: Request) -> Response:
    body = await json_of(request)
    return await answered(request, _run_response, body)


def _run_response(body: Any) -> Response:
    from latolato.app.runs import USUAL_SAMPLES, compute

    block = compute(RunRequest.from_json(body), body.get("most_samples", USUAL_SAMPLES))
    return Response(block, media_type="application/octet-stream")
