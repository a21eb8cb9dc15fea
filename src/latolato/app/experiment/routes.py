"""Videos and tables of an experiment: upload, work with progress, results; gone with their page.

A page opens the WebSocket ``/ws/experiment/desk`` and keeps it open. It receives its key,
uploads with ``POST /api/experiment?desk=KEY`` (the body is the file, its name stands in the header
``X-Name``), and asks for work at ``/ws/experiment`` (see `latolato.app.jobs`) by ``{"do": "track",
"clip": KEY, ...}`` or ``{"do": "example", "desk": KEY, ...}``. When the desk's socket closes, every
file of that page is removed.
"""

from __future__ import annotations

import tempfile
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket

from latolato.app.answers import json_of
from latolato.app.experiment.jobs import prepare, trial_rows
from latolato.app.experiment.store import COPY, FILES, Store
from latolato.app.jobs import GONE, serve_job
from latolato.app.run_request import TooLargeError
from latolato.core.errors import InputError, in_parts, reading
from latolato.experiment.rules import broken
from latolato.simulation.summary import plain


def routes() -> list[BaseRoute]:
    """Return the addresses of the experiment view."""
    return [
        WebSocketRoute("/ws/experiment", _job),
        WebSocketRoute("/ws/experiment/desk", _desk),
        Route("/api/experiment", _upload, methods=["POST"]),
        Route("/api/experiment/remove", _remove, methods=["POST"]),
        Route("/api/experiment/trials", _trials),
        Route("/api/experiment/{clip}/{file}", _file),
    ]


async def _upload(request: Request) -> Response:
    """Receive one file; one that is refused or interrupted leaves nothing behind."""
    store: Store = request.app.state.clips
    most = request.app.state.settings.most_bytes
    clip = store.admit(request.query_params.get("desk"), request.headers.get("x-name", ""))
    size = 0
    try:
        with clip.upload.open("xb") as file:
            async for part in request.stream():
                size += len(part)
                if size > most:
                    raise TooLargeError(
                        f"{clip.name} is larger than {most / 1e6:g} MB, the limit for an upload",
                        way_out="cut it, or use `latolato track`",
                    )
                await run_in_threadpool(file.write, part)
        if not size:
            with reading(clip.name):
                raise broken("empty_video")
    except BaseException as error:
        store.remove(clip)
        if isinstance(error, ClientDisconnect):
            return Response(status_code=400)  # to nobody
        raise
    return JSONResponse({"clip": clip.key, "name": clip.name, "size": size})


async def _remove(request: Request) -> Response:
    """Remove a clip: ``{"clip"}``; answer with the trials that are left."""
    store: Store = request.app.state.clips
    clip = store.clip((await json_of(request))["clip"])
    store.remove(clip)
    trials = await run_in_threadpool(trial_rows, store.of_desk(clip.desk))
    return JSONResponse(plain(in_parts({"trials": trials})))


def _file(request: Request) -> Response:
    """Send one of the files of a clip."""
    name = request.path_params["file"]
    path = request.app.state.clips.clip(request.path_params["clip"]).folder / name
    if name not in FILES or not path.is_file():
        raise HTTPException(404, "there is no such file")
    headers = {"Cache-Control": "no-store"}
    if name != COPY:
        # The page that is downloaded is of another kind than those of this server.
        headers["Content-Disposition"] = "attachment"
    return FileResponse(path, media_type=FILES[name], headers=headers)


def _trials(request: Request) -> Response:
    """Send the trial table of a page as CSV."""
    from latolato.experiment.trial_table import trial_table, write_trials

    rows = trial_rows(request.app.state.clips.of_desk(request.query_params.get("desk")))
    if not rows:
        raise InputError("none of the videos is a trial: each needs a driven pivot")
    rows = [{k: v for k, v in row.items() if k != "clip"} for row in rows]
    table = trial_table({name: [row[name] for row in rows] for name in rows[0]})
    with tempfile.TemporaryDirectory() as folder:
        content = write_trials(table, Path(folder) / "trials.csv").read_bytes()
    headers = {"Content-Disposition": "attachment", "Cache-Control": "no-store"}
    return Response(content, media_type="text/csv; charset=utf-8", headers=headers)


async def _job(websocket: WebSocket) -> None:
    await serve_job(websocket, partial(prepare, websocket.app.state.clips))


async def _desk(websocket: WebSocket) -> None:
    """Keep a place for the clips of a page until it closes."""
    state = websocket.app.state
    await websocket.accept()
    with suppress(*GONE), state.clips.open_desk() as key:
        hello = await run_in_threadpool(_hello, key, state.settings.most_bytes)
        await websocket.send_json(hello)
        while (await websocket.receive())["type"] != "websocket.disconnect":
            pass


def _hello(desk: str, most_bytes: int) -> Any:
    """Fields, fits, examples and limits that a page needs to request work."""
    from latolato.app.experiment.description import EXAMPLES, TABLE_ENDINGS, fields, fit_kinds
    from latolato.app.experiment.tables import roles
    from latolato.experiment.tracking.body import ROUND, SHARE
    from latolato.experiment.video import Limits

    return plain(
        {
            "desk": desk,
            "fields": fields(),
            "fits": fit_kinds(),
            "examples": EXAMPLES,
            "limits": {
                "upload": most_bytes,
                "duration": Limits.duration,
                "pixels": Limits.pixels,
            },
            "template": {"round": ROUND, "share": SHARE},
            "tables": {"endings": TABLE_ENDINGS, "roles": roles()},
        }
    )
