"""Videos and tables of an experiment: upload, work with progress, results; gone with their page.

A page opens the WebSocket ``/ws/experiment/desk`` and keeps it open. It receives its key,
uploads with ``POST /api/experiment?desk=KEY`` (the body is the file, its name stands in the header
``X-Name``), and asks for work at ``/ws/experiment`` (see `latolato.app.jobs`) by ``{"desk": KEY,
"do": "track", "clip": KEY, ...}``. When the desk's socket closes, running work is killed and every
file of that page is removed.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any, BinaryIO

import anyio
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket

from latolato.app.answers import answered, json_of, refusal, status_of
from latolato.app.experiment.jobs import prepare, trial_rows
from latolato.app.experiment.store import COPY, FILES, Clip, Desk, Store
from latolato.app.jobs import GONE, serve_job
from latolato.core.errors import InputError


def routes() -> list[BaseRoute]:
    """Return the addresses of the experiment view."""
    return [
        WebSocketRoute("/ws/experiment", _job),
        WebSocketRoute("/ws/experiment/desk", _desk),
        Route("/api/experiment", _upload, methods=["POST"]),
        Route("/api/experiment/remove", _remove, methods=["POST"]),
        Route("/api/experiment/trials", _trials_file),
        Route("/api/experiment/{clip}/{file}", _file),
    ]


async def _upload(request: Request) -> Response:
    """Receive one file; one that is refused or interrupted leaves nothing behind."""
    store: Store = request.app.state.clips
    try:
        desk = store.desk(request.query_params.get("desk"))
        announced = request.headers.get("content-length", "0")
        size = int(announced) if announced.isdigit() else 0
        clip = store.admit(desk, request.headers.get("x-name", ""), size)
    except InputError as error:
        return refusal(status_of(error), error)
    try:
        with clip.upload.open("xb") as file:
            await _received(request, store, desk, clip, file)
        if clip.size == 0:
            raise InputError(f"{clip.name} is empty")
        clip.is_whole = True
    except InputError as error:
        return refusal(status_of(error), error)
    except (ClientDisconnect, OSError) as error:
        why = f"the upload of {clip.name} was interrupted: {type(error).__name__}"
        return refusal(400, InputError(why))
    finally:
        if not clip.is_whole:
            desk.remove(clip)
    return JSONResponse({"clip": clip.key, "name": clip.name, "size": clip.size})


async def _received(request: Request, store: Store, desk: Desk, clip: Clip, file: BinaryIO) -> None:
    """Write the body of a request to a file, as it comes."""
    async for part in request.stream():
        if clip.key not in desk.clips:
            raise InputError("the page has closed")
        store.check_size(clip, clip.size + len(part))
        clip.size += len(part)
        await anyio.to_thread.run_sync(file.write, part)


async def _remove(request: Request) -> Response:
    """Remove a clip: ``{"desk", "clip"}``; answer with the trials that are left."""
    body = await json_of(request)
    try:
        if not isinstance(body, dict):
            raise InputError("a request must be an object")
        desk: Desk = request.app.state.clips.desk(body.get("desk"))
        desk.remove(desk.clip(body.get("clip")))
    except InputError as error:
        return refusal(status_of(error), error)
    return await answered(request, _trials, list(desk.clips.values()))


def _trials(clips: list[Clip]) -> Response:
    from latolato.simulation.summary import plain

    return JSONResponse({"trials": plain(trial_rows(clips))})


async def _file(request: Request) -> Response:
    """Send one of the files of a clip."""
    name = request.path_params["file"]
    clip = request.app.state.clips.clip(request.path_params["clip"])
    path = clip.file(name) if clip else None
    if path is None:
        raise HTTPException(404, "there is no such file; a video is removed with its page")
    headers = {"Cache-Control": "no-store"}
    if name != COPY:
        # The page that is downloaded is of another kind than those of this server.
        headers["Content-Disposition"] = "attachment"
    return FileResponse(path, media_type=FILES[name], headers=headers)


async def _trials_file(request: Request) -> Response:
    """Send the trial table of a page as CSV."""
    try:
        desk = request.app.state.clips.desk(request.query_params.get("desk"))
    except InputError as error:
        raise HTTPException(404, str(error)) from None
    return await answered(request, _trials_csv, list(desk.clips.values()))


def _trials_csv(clips: list[Clip]) -> Response:
    """Return the trial table as CSV."""
    import tempfile
    from pathlib import Path

    from latolato.experiment.trial_table import trial_table, write_trials

    rows = trial_rows(clips)
    if not rows:
        raise InputError("none of the videos is a trial: each needs a driven pivot")
    rows = [{k: v for k, v in row.items() if k != "clip"} for row in rows]
    table = trial_table({name: [row[name] for row in rows] for name in rows[0]})
    with tempfile.TemporaryDirectory() as folder:
        path = write_trials(table, Path(folder) / "trials.csv")
        content = path.read_bytes()
    headers = {"Content-Disposition": "attachment", "Cache-Control": "no-store"}
    return Response(content, media_type="text/csv; charset=utf-8", headers=headers)


async def _job(websocket: WebSocket) -> None:
    state = websocket.app.state
    await serve_job(websocket, lambda request: prepare(request, state.clips))


async def _desk(websocket: WebSocket) -> None:
    """Keep a place for the clips of a page until it closes."""
    store: Store = websocket.app.state.clips
    await websocket.accept()
    with suppress(*GONE):
        desk = store.open_desk()
        try:
            await websocket.send_json(await anyio.to_thread.run_sync(_hello, store, desk))
            while (await websocket.receive())["type"] != "websocket.disconnect":
                pass
        finally:
            desk.close()


def _hello(store: Store, desk: Desk) -> Any:
    """Fields, fits, examples and limits that a page needs to request work."""
    from latolato.app.experiment.description import EXAMPLES, TABLE_ENDINGS, fields, fit_kinds
    from latolato.app.experiment.tables import roles
    from latolato.experiment.tracking.learn_template import ROUND, SHARE
    from latolato.experiment.video import Limits
    from latolato.simulation.summary import plain

    return plain(
        {
            "desk": desk.key,
            "fields": fields(),
            "fits": fit_kinds(),
            "examples": EXAMPLES,
            "limits": {
                "upload": store.most_bytes,
                "duration": Limits.duration,
                "pixels": Limits.pixels,
            },
            "template": {"round": ROUND, "share": SHARE},
            "tables": {"endings": TABLE_ENDINGS, "roles": roles()},
        }
    )
