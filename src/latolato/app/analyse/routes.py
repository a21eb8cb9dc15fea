"""The routes of the view Analyse: its forms, and an analysis as a job."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket

from latolato.app.analyse.forms import about_request, forms
from latolato.app.analyse.request import AnalysisRequest
from latolato.app.answers import answered, json_of
from latolato.app.blocks import pack_files
from latolato.app.jobs import Job, serve_job
from latolato.app.run_request import RunRequest


def routes() -> list[BaseRoute]:
    """Return the routes of the view Analyse."""
    return [
        Route("/api/analyses", _forms),
        Route("/api/analyses/about", _about, methods=["POST"]),
        WebSocketRoute("/ws/analyse", _analyse),
    ]


async def _forms(request: Request) -> Response:
    request.app.state.jobs.warm()
    return await answered(request, lambda: JSONResponse(forms()))


async def _about(request: Request) -> Response:
    body = await json_of(request)
    return await answered(request, lambda: JSONResponse(about_request(RunRequest.from_json(body))))


async def _analyse(websocket: WebSocket) -> None:
    await serve_job(websocket, websocket.app.state.jobs, prepare)


def prepare(body: Any) -> Job:
    """Return the job that runs the analysis of a page.

    Raises
    ------
    InputError
        For bad input.
    """
    asked = AnalysisRequest.from_json(body)
    arguments = asked.arguments()

    def finish(about: dict[str, Any], folder: Path) -> bytes:
        lines = {"python": asked.python(arguments), "command": asked.command()}
        return pack_files({**about, **lines}, {p.suffix[1:]: p for p in folder.iterdir()})

    request = asked.request
    sent: dict[str, Any] = {"scenario": request.scenario, "options": dict(request.options or {})}
    sent |= {"analysis": asked.name, "settings": asked.settings}
    return Job("analyse", sent, finish)
