"""Who may talk to the server: host and origin of every request, headers of every answer."""

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
_POLICY_VIOLATION = 1008
_FOREIGN = "the request comes from a page of another site"


class Guard:
    """Middleware that lets in only what comes from this server's own pages.

    ``Host`` must be one of the server's names: a foreign page that points its own name at this
    address is refused. The request must not come from a page of another site.

    Parameters
    ----------
    app : ASGI application
        What is guarded.
    port : int
        Where the server listens.
    """

    def __init__(self, app: ASGIApp, port: int) -> None:
        self._app = app
        self._names = {f"127.0.0.1:{port}", f"localhost:{port}"}
        if port == 80:
            self._names |= {"127.0.0.1", "localhost"}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or hand on, one request."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        fault = self._fault(HTTPConnection(scope))
        if fault is not None:
            await _refuse(fault, scope, receive, send)
            return
        if scope["type"] == "websocket":
            await self._app(scope, receive, send)
            return

        async def answer(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        await self._app(scope, receive, answer)

    def _fault(self, request: HTTPConnection) -> str | None:
        """Return why a request is refused, None if it is welcome."""
        hosts = [host.lower() for host in request.headers.getlist("host")]
        if len(hosts) != 1 or hosts[0] not in self._names:
            return (
                "this server does not know the name in the address of the page; use the link that "
                "it printed"
            )
        origins = request.headers.getlist("origin")
        if any(origin != f"http://{hosts[0]}" for origin in origins):
            return _FOREIGN
        if request.scope["type"] == "websocket" and not origins:
            return "a WebSocket must say which page opens it"
        is_own_site = request.headers.get("sec-fetch-site", "none") in ("none", "same-origin")
        return None if is_own_site else _FOREIGN


async def _refuse(fault: str, scope: Scope, receive: Receive, send: Send) -> None:
    """Answer a request that is not welcome."""
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": _POLICY_VIOLATION, "reason": fault})
        return
    response = PlainTextResponse(f"Refused: {fault}.\n", status_code=403, headers=HEADERS)
    await response(scope, receive, send)
