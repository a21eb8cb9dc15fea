"""Who may talk to the server: host, origin and token of every request, headers of every answer."""

from __future__ import annotations

import hmac
import ipaddress

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

TOKEN = "token"
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

    ``Host`` must be one of the server's names or the address at which the connection arrived: a
    foreign page that points its own name at this address is refused. The request must not come from
    a page of another site, and must carry the token if there is one: in the address once, in a
    cookie from then on.

    Parameters
    ----------
    app : ASGI application
        What is guarded.
    names : frozenset of str
        Values of ``Host`` that name this server, in lower case.
    token : str, optional
        The secret that every request must carry.
    cookie : str
        Name of the cookie that keeps the token.
    """

    def __init__(
        self,
        app: ASGIApp,
        names: frozenset[str],
        token: str | None,
        cookie: str,
    ) -> None:
        self._app = app
        self._names = names
        self._token = token
        self._cookie = cookie

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or hand on, one request."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        request = HTTPConnection(scope)
        is_invited = self._is_token(*request.query_params.getlist(TOKEN))
        fault = self._fault(request, is_invited)
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
                if is_invited:
                    headers.append(
                        "Set-Cookie",
                        f"{self._cookie}={self._token}; HttpOnly; SameSite=Strict; Path=/",
                    )
            await send(message)

        await self._app(scope, receive, answer)

    def _fault(self, request: HTTPConnection, is_invited: bool) -> str | None:
        """Return why a request is refused, None if it is welcome."""
        hosts = [host.lower() for host in request.headers.getlist("host")]
        if len(hosts) != 1 or not (hosts[0] in self._names or hosts[0] in _addresses(request)):
            return (
                "this server does not know the name in the address of the page; use a link that it "
                "printed, or start it with --name HOST"
            )
        own = (f"http://{hosts[0]}", f"https://{hosts[0]}")
        origins = request.headers.getlist("origin")
        if any(origin not in own for origin in origins):
            return _FOREIGN
        if request.scope["type"] == "websocket" and not origins:
            return "a WebSocket must say which page opens it"
        if self._token is not None and not (
            is_invited or self._is_token(request.cookies.get(self._cookie, ""))
        ):
            return "the address lacks the access token that the server printed when it started"
        # Whoever follows a link with the token comes from the page where the link stands.
        is_own_site = request.headers.get("sec-fetch-site", "none") in ("none", "same-origin")
        return None if is_own_site or is_invited else _FOREIGN

    def _is_token(self, *texts: str) -> bool:
        """Return whether one of the texts is the server's token."""
        token = self._token
        if token is None:
            return False
        return any(hmac.compare_digest(text.encode(), token.encode()) for text in texts)


def _addresses(request: HTTPConnection) -> tuple[str, ...]:
    """Return the values of ``Host`` that stand for the socket at which a request arrived."""
    name, port = request.scope.get("server") or ("", None)
    try:
        address = ipaddress.ip_address(name.partition("%")[0])
    except ValueError:
        return ()
    if isinstance(address, ipaddress.IPv6Address):
        mapped = address.ipv4_mapped  # IPv4 on a socket for both
        text = f"[{address}]" if mapped is None else str(mapped)
    else:
        text = str(address)
    return (f"{text}:{port}", text) if port == 80 else (f"{text}:{port}",)


async def _refuse(fault: str, scope: Scope, receive: Receive, send: Send) -> None:
    """Answer a request that is not welcome."""
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": _POLICY_VIOLATION, "reason": fault})
        return
    response = PlainTextResponse(f"Refused: {fault}.\n", status_code=403, headers=HEADERS)
    await response(scope, receive, send)
