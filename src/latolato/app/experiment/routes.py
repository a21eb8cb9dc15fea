"""Videos of an experiment: upload, work on them with progress, results; gone with their page.

A page opens the WebSocket ``/ws/experiment/desk``, sends ``{"hello": true}`` and keeps it open. It
receives its key, uploads with ``POST /api/experiment?desk=KEY`` (the body is the file, its name
stands in the header ``X-Name``), and asks for work in JSON frames ``{"job": 1, "do": "track",
"clip": KEY, ...}``. It receives ``stage`` and ``progress``, and at last ``done`` or ``error``. When
the socket closes, running work is killed and every file of that page is removed.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, BinaryIO

import anyio
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from latolato.app.answers import answered, message_of, refusal, status_of
from latolato.app.experiment.jobs import clip_workers_of, work
from latolato.app.experiment.store import FILES, SHOWN, Clip, Desk, Store
from latolato.app.given import TooLargeError
from latolato.core.errors import InputError

_LONGEST_FRAME = 100_000
# The first frame of a page; its first job may come much later.
GREETING = {"hello": True}


def routes() -> list[BaseRoute]:
    """Return the addresses of the experiment view."""
    return [
        WebSocketRoute("/ws/experiment/desk", _desk),
        Route("/api/experiment", _upload, methods=["POST"]),
        Route("/api/experiment/{clip}/{file}", _file),
        Route("/api/experiment/trials", _trials_file),
    ]


def store_of(app: Any) -> Store:
    """Return the clips of a server."""
    store: Store = app.state.clips
    return store


async def _upload(request: Request) -> Response:
    """Receive one video; nothing is left of one that is refused or breaks off."""
    store = store_of(request.app)
    try:
        desk = store.desk(request.query_params.get("desk"))
        announced = request.headers.get("content-length", "0")
        size = int(announced) if announced.isdigit() else 0
        clip = store.admit(desk, request.headers.get("x-name", ""), size)
    except InputError as error:
        return refusal(status_of(error), error)
    try:
        with anyio.fail_after(store.allowance.upload_time), clip.upload.open("xb") as file:
            await _received(request, store, desk, clip, file)
        if clip.size == 0:
            raise InputError(f"{clip.name} is empty")
        clip.is_whole = True
    except InputError as error:
        return refusal(status_of(error), error)
    except TimeoutError:
        return refusal(408, InputError(f"the upload of {clip.name} stood still"))
    except (ClientDisconnect, OSError) as error:
        why = f"the upload of {clip.name} broke off: {type(error).__name__}"
        return refusal(400, InputError(why))
    finally:
        if not clip.is_whole:
            desk.remove(clip.key)
    return JSONResponse({"clip": clip.key, "name": clip.name, "size": clip.size})


async def _received(request: Request, store: Store, desk: Desk, clip: Clip, file: BinaryIO) -> None:
    """Write the body of a request to a file, as it comes."""
    parts = request.stream()
    while True:
        with anyio.fail_after(store.allowance.stall):
            part = await anext(parts, b"")
        if not part:
            return
        if clip.key not in desk.clips:
            raise InputError("the page has closed")
        store.check_size(clip, clip.size + len(part))
        clip.size += len(part)
        await anyio.to_thread.run_sync(file.write, part)


async def _file(request: Request) -> Response:
    """Send one of the files of a clip."""
    name = request.path_params["file"]
    clip = store_of(request.app).clip(request.path_params["clip"])
    path = clip.file(name) if clip else None
    if path is None:
        raise HTTPException(404, "there is no such file; a video is removed with its page")
    headers = {"Cache-Control": "no-store"}
    if name not in SHOWN:
        # The page that is downloaded is of another kind than those of this server.
        headers["Content-Disposition"] = "attachment"
    return FileResponse(path, media_type=FILES[name], headers=headers)


async def _trials_file(request: Request) -> Response:
    """Send the trial table of a page as CSV."""
    try:
        desk = store_of(request.app).desk(request.query_params.get("desk"))
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


def trial_rows(clips: list[Clip]) -> list[dict[str, Any]]:
    """Return the trials of clips with their sets, ordered by set and frequency."""
    import math

    from latolato.experiment.trial_table import sets_of

    def known(row: Mapping[str, Any]) -> dict[str, Any]:
        return {name: math.nan if value is None else value for name, value in row.items()}

    rows = [{**known(f.trial), "clip": f.key, "source": f.name} for f in clips if f.trial]
    if not rows:
        return []
    names = sets_of(
        [row["drive_amplitude"] for row in rows], [row["drive_amplitude_sigma"] for row in rows]
    )
    rows = [{**row, "set": s, "set_by": "amplitude"} for row, s in zip(rows, names, strict=True)]
    return sorted(rows, key=lambda row: (row["set"], row["drive_frequency"]))


async def _desk(websocket: WebSocket) -> None:
    """Serve one page: its jobs run until it closes, and then all its clips are removed."""
    store = store_of(websocket.app)
    await websocket.accept()
    try:
        desk = store.open_desk()
    except TooLargeError as error:
        with suppress(RuntimeError, WebSocketDisconnect):
            await websocket.send_json({"error": str(error)})
            await websocket.close(1013)
        return
    clerk = _Clerk(websocket, store, desk)
    try:
        await clerk.serve()
    finally:
        await asyncio.shield(clerk.close())


class _Clerk:
    """Takes the frames of one page and runs its jobs."""

    def __init__(self, websocket: WebSocket, store: Store, desk: Desk) -> None:
        self._socket = websocket
        self._store = store
        self._desk = desk
        self._jobs: dict[int, asyncio.Task[None]] = {}
        self._lock = asyncio.Lock()

    async def serve(self) -> None:
        """Answer frames until the page goes."""
        from latolato.app.experiment.description import EXAMPLES, fields, fit_kinds

        most = self._store.allowance
        await self.tell(
            {
                "desk": self._desk.key,
                "fields": await anyio.to_thread.run_sync(fields),
                "fits": await anyio.to_thread.run_sync(fit_kinds),
                "examples": EXAMPLES,
                "limits": {"upload": most.upload, "duration": most.duration,
                           "pixels": most.pixels},
            }
        )  # fmt: skip
        while True:
            frame = await self._socket.receive()
            if frame["type"] == "websocket.disconnect":
                return
            await self._take(frame.get("text"))

    async def close(self) -> None:
        """Kill what runs and remove the clips."""
        for task in self._jobs.values():
            task.cancel()
        await asyncio.gather(*self._jobs.values(), return_exceptions=True)
        self._desk.close()

    async def tell(self, message: Mapping[str, Any]) -> None:
        """Send one frame; a page that has gone hears nothing."""
        from latolato.simulation.summary import plain

        async with self._lock:
            try:
                await self._socket.send_text(json.dumps(plain(dict(message)), allow_nan=False))
            except (RuntimeError, WebSocketDisconnect):
                return

    async def _take(self, text: str | None) -> None:
        """Begin or end a job."""
        number = None
        try:
            if text is None or len(text) > _LONGEST_FRAME:
                raise InputError("a frame must be a short text")
            given = parsed(text)
            if not isinstance(given, dict):
                raise InputError("a frame must be an object")
            if given == GREETING:
                return
            number = given.get("job")
            if isinstance(number, bool) or not isinstance(number, int):
                number = None
                raise InputError("job must be a whole number")
            self._begin(number, given)
        except Exception as error:
            await self.refuse(number, error)

    async def refuse(self, number: int | None, error: Exception) -> None:
        """Tell why there is no answer."""
        await self.tell({"job": number, **message_of(error)})

    def _begin(self, number: int, given: dict[str, Any]) -> None:
        """Begin what a frame asks for."""
        do = given.get("do")
        if do == "cancel":
            task = self._jobs.get(number)
            if task is not None:
                task.cancel()
            return
        if number in self._jobs:
            raise InputError(f"job {number} runs already")
        if len(self._jobs) >= self._store.allowance.waiting:
            raise TooLargeError(f"{len(self._jobs)} jobs wait already")
        if do == "remove":
            self._desk.remove(self._desk.clip(given.get("clip")).key)
            self._run(number, self._rows())
            return
        clip, job = checked_job(self._store, self._desk, given)
        self._run(number, self._work(clip, job))

    def _run(self, number: int, doing: Any) -> None:
        """Run one job until its answer."""

        async def run() -> None:
            try:
                result = await doing(number)
                await self.tell({"job": number, "done": result})
            except asyncio.CancelledError:
                await self.tell({"job": number, "cancelled": True})
            except Exception as error:
                await self.refuse(number, error)
            finally:
                self._jobs.pop(number, None)

        self._jobs[number] = asyncio.create_task(run())

    def _rows(self) -> Any:
        """Return what answers with the trial table."""

        async def answer(_: int) -> dict[str, Any]:
            return {"trials": await self._trials()}

        return answer

    async def _trials(self) -> list[dict[str, Any]]:
        """Return the trial table of this page."""
        return await anyio.to_thread.run_sync(trial_rows, list(self._desk.clips.values()))

    def _work(self, clip: Clip, job: dict[str, Any]) -> Any:
        """Return what does a job on a clip, when it is its turn."""

        async def answer(number: int) -> dict[str, Any]:
            async def tell(stage: str, progress: float) -> None:
                await self.tell({"job": number, "stage": stage, "progress": progress})

            is_new = job["do"] == "example"
            try:
                await tell("waiting", 0.0)
                workers = clip_workers_of(self._socket.app.state)
                result = await work(workers, clip, job, self._store.allowance, tell)
            except BaseException:
                if is_new:
                    self._desk.remove(clip.key)
                raise
            finally:
                clip.weigh()
            if job["do"] in ("look", "example"):
                clip.about = {"width": result["width"], "height": result["height"]}
                clip.truth = result.pop("truth", {})
                result |= {"clip": clip.key, "name": clip.name, "truth": clip.truth}
            if job["do"] == "track":
                clip.trial = result["trial"]
                result["trials"] = await self._trials()
            return result

        return answer


def parsed(text: str) -> Any:
    """Return the JSON of a frame."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise InputError("a frame must be JSON") from None


def checked_job(store: Store, desk: Desk, given: Mapping[str, Any]) -> tuple[Clip, dict[str, Any]]:
    """Return the clip that a frame is about and the job for its process.

    Raises
    ------
    InputError
        For anything that is not known, before a process begins.
    """
    from latolato.app.experiment.description import EXAMPLES, EXPORTS, Description

    do = given.get("do")
    if do == "example":
        kind = _one_of("kind", given.get("kind"), EXAMPLES)
        clip = store.admit(desk, f"{kind}.mp4")
        return clip, {"do": do, "kind": kind}
    if do not in ("look", "track", "fit", "export"):
        raise InputError(f"do must be look, track, fit, export, example or remove, got {do!r}")
    clip = desk.clip(given.get("clip"))
    if not clip.is_whole and not clip.about:
        raise InputError(f"{clip.name} is still on its way")
    if do == "look":
        return clip, {"do": do}
    if not clip.about:
        raise InputError(f"{clip.name} could not be read")
    if do == "export":
        return clip, {"do": do, "file": _one_of("file", given.get("file"), EXPORTS)}
    description = given.get("description")
    Description.from_json(description)
    job = {"do": do, "description": description, **clip.about}
    if do == "fit":
        from latolato.experiment.fits import fits

        job["kind"] = _one_of("kind", given.get("kind"), tuple(fits))
    return clip, job


def _one_of(name: str, value: Any, known: tuple[str, ...]) -> str:
    """Return a word that is one of those known."""
    if not isinstance(value, str) or value not in known:
        raise InputError(f"must be one of {', '.join(known)}", parameter=name, value=value)
    return value
