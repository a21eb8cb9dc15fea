"""The routes of the view Analyse: its forms, and an analysis as a job."""

from __future__ import annotations

from functools import partial

from anyio import to_process
from starlette.background import BackgroundTask
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute

from latolato.app.analyse.answer import compute
from latolato.app.analyse.forms import about_request, forms
from latolato.app.answers import answered, json_of
from latolato.app.jobs import Job, serve_job
from latolato.app.run_request import RunRequest
from latolato.app.worker import import_heavy


def routes() -> list[BaseRoute]:
    """Return the routes of the view Analyse."""
    return [
        Route("/api/analyses", _forms),
        Route("/api/analyses/about", _about, methods=["POST"]),
        WebSocketRoute("/ws/analyse", partial(serve_job, prepare=partial(Job, compute))),
    ]


async def _forms(request: Request) -> Response:
    # Who looks at a form soon asks for its analysis.
    ahead = BackgroundTask(to_process.run_sync, import_heavy)
    return await answered(request, lambda: JSONResponse(forms(), background=ahead))


async def _about(request: Request) -> Response:
    body = await json_of(request)
    return await answered(request, lambda: JSONResponse(about_request(RunRequest.from_json(body))))
