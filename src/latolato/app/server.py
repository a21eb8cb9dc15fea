"""The local server: pages, numbers for them, and the guard around both."""

from __future__ import annotations

import tempfile
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from anyio import to_process
from starlette.applications import Starlette
from starlette.background import BackgroundTask
from starlette.concurrency import run_in_threadpool
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute

from latolato.app import downloads, stories
from latolato.app.analyse import answer
from latolato.app.analyse.forms import about_request, forms
from latolato.app.answers import REFUSED, json_of, refused
from latolato.app.experiment import routes as clips
from latolato.app.experiment.store import MOST_BYTES, Store
from latolato.app.guard import HOSTS, Guard
from latolato.app.jobs import Job, serve_job
from latolato.app.map import files, stored
from latolato.app.pages import Report, page_file, static
from latolato.app.run_request import RunRequest
from latolato.app.worker import import_heavy


@dataclass(frozen=True)
class Settings:
    """What the server serves.

    Attributes
    ----------
    report : Path, optional
        Folder of a reproduction report, which is served beside the pages.
    most_bytes : int
        Size of the largest file that a page may upload.
    stored : mapping
        Stored maps that pages may open, by name.
    """

    report: Path | None = None
    most_bytes: int = MOST_BYTES
    stored: Mapping[str, Path] = field(default_factory=dict)


def make_app(settings: Settings) -> Starlette:
    """Return the application that serves the pages and computes for them."""
    known = settings.stored
    app = Starlette(
        routes=[
            Route("/", _index),
            Route("/registry.json", _registry),
            Route("/stories/contents.json", _stories),
            Route("/api/run", _run, methods=["POST"]),
            Route("/api/analyses", _analyses),
            Route("/api/analyses/about", _about, methods=["POST"]),
            Route("/api/map/stored", _stored),
            *clips.routes(),
            _job("run/file", partial(Job, downloads.compute)),
            _job("analyse", partial(Job, answer.compute)),
            _job("map/stored", partial(stored.prepare, known)),
            _job("map/file", partial(files.prepare, known)),
            *([Mount("/report", Report(directory=settings.report))] if settings.report else []),
            Route("/{path:path}", static),
        ],
        middleware=[
            Middleware(TrustedHostMiddleware, allowed_hosts=HOSTS, www_redirect=False),
            Middleware(Guard),
        ],
        exception_handlers=dict.fromkeys(REFUSED, refused),
        lifespan=_lifespan,
    )
    app.state.settings = settings
    return app


@asynccontextmanager
async def _lifespan(app: Starlette) -> AsyncIterator[None]:
    """Leave no files behind in the end."""
    prefix = "latolato-clips-"
    with tempfile.TemporaryDirectory(prefix=prefix, ignore_cleanup_errors=True) as folder:
        app.state.clips = Store(Path(folder))
        yield


def _job(name: str, prepare: Callable[[Any], Job]) -> BaseRoute:
    """Return the socket of a kind of job."""
    return WebSocketRoute(f"/ws/{name}", partial(serve_job, prepare=prepare))


async def _index(request: Request) -> Response:
    return page_file("index.html", request)


def _registry(request: Request) -> Response:
    from latolato.app.forms import registry

    has_report = request.app.state.settings.report is not None
    return JSONResponse(registry() | {"server": True, "report": has_report})


def _stories(request: Request) -> Response:
    return JSONResponse(stories.contents())


async def _run(request: Request) -> Response:
    return await run_in_threadpool(_run_response, await json_of(request))


def _run_response(body: Any) -> Response:
    from latolato.app.runs import USUAL_SAMPLES, compute

    block = compute(RunRequest.from_json(body), body.get("most_samples", USUAL_SAMPLES))
    return Response(block, media_type="application/octet-stream")


def _analyses(request: Request) -> Response:
    # Who looks at the forms soon asks for an analysis.
    return JSONResponse(forms(), background=BackgroundTask(to_process.run_sync, import_heavy))


async def _about(request: Request) -> Response:
    wanted = RunRequest.from_json(await json_of(request))
    return JSONResponse(await run_in_threadpool(about_request, wanted))


def _stored(request: Request) -> Response:
    return JSONResponse(list(request.app.state.settings.stored))
