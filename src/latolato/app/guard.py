"""Who may talk to the server: pages of its own, which may do what headers of every answer say."""

from __future__ import annotations

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self' 'wasm-unsafe-eval'",
        "worker-src 'self'",
        "style-src 'self'",
        "img-src 'self' blob: data:",
        "media-src 'self' blob:",
        "connect-src 'self'",
        "manifest-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
HEADERS = {
    "Content-Security-Policy": _POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}
# A foreign page that points its own name at this address is refused.
HOSTS = ("127.0.0.1", "localhost")


class Guard:
    """Middleware that refuses requests of other sites' pages, and adds `HEADERS` to answers.

    Parameters
    ----------
    app : ASGI application
        What is guarded.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or hand on, one request."""

        async def answer(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        app = self._app
        if scope["type"] != "lifespan" and _is_foreign(HTTPConnection(scope)):
            app = PlainTextResponse("Refused: a page of another site asked for this.\n", 403)
        await app(scope, receive, answer)


def _is_foreign(request: HTTPConnection) -> bool:
    """Return whether a browser says that a page of another site makes a request."""
    own = f"http://{request.headers.get('host')}"
    if any(origin != own for origin in request.headers.getlist("origin")):
        return True
    return request.headers.get("sec-fetch-site", "none") not in ("none", "same-origin")
