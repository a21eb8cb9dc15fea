"""The files of the pages: where they lie, and how they are served."""

from __future__ import annotations

import mimetypes
from functools import cache, lru_cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from latolato.app import STATIC

# Not asked of the system, whose registry may say otherwise.
_TYPES = {
    ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml",
    ".wasm": "application/wasm",
}  # fmt: skip


# A report has its styles and pictures in its page, and needs nothing else.
_REPORT_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)


class Report(StaticFiles):
    """The files of a reproduction report."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Return a file, under a policy that allows what stands in the page of the report."""
        response = await super().get_response(path, scope)
        response.headers["Content-Security-Policy"] = _REPORT_POLICY
        return response


class PageFile(NamedTuple):
    """A file of the pages: its content, media type and entity tag."""

    content: bytes
    media_type: str
    tag: str


async def static(request: Request) -> Response:
    """Return the file of the pages that an address names."""
    return page_file(request.path_params["path"], request)


def page_file(name: str, request: Request) -> Response:
    """Return a file of the pages, or that it has not changed.

    They are a few hundred kilobytes and kept in memory: Starlette's own `StaticFiles` takes a
    thread for every step with a file, and while kernels are loaded each waits for its turn.

    Raises
    ------
    HTTPException
        If there is no such file.
    """
    result = _read(name)
    headers = {"ETag": result.tag, "Cache-Control": "no-cache"}
    if result.tag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    return Response(result.content, media_type=result.media_type, headers=headers)


@lru_cache
def _names() -> frozenset[str]:
    """Return the paths of the files; no other path leads to a file."""
    return frozenset(p.relative_to(STATIC).as_posix() for p in STATIC.rglob("*") if p.is_file())


@cache
def _read(name: str) -> PageFile:
    if name not in _names():
        raise HTTPException(404, "there is no such page")
    content = (STATIC / name).read_bytes()
    kind = _TYPES.get(Path(name).suffix) or mimetypes.guess_type(name)[0] or "text/plain"
    return PageFile(content, kind, f'"{sha256(content).hexdigest()[:24]}"')
