"""Who may talk to the server: host, origin and token of every request, headers of every answer."""

from __future__ import annotations

import hmac
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

TOKEN = "token"
_COOKIE = "latolato_token"
_POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' blob: data:",
        "media-src 'self' blob:",
        "connect-src 'self'",
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


class Guard:
    """Middleware that lets in what comes from this server's own pages only.

    A request must name this server in ``Host`` (a page elsewhere that points its own name at this
    address does not), must not come from a page of another site, and must carry the token if there
    is one: in the address once, in a cookie from then on.

    Parameters
    ----------
    app : ASGI application
        What is guarded.
    hosts : frozenset of str
        Names under which the server is known, each with its port.
    token : str, optional
        The secret that every request must know.
    """

    def __init__(self, app: ASGIApp, hosts: frozenset[str], token: str | None = None) -> None:
        self._app = app
        self._hosts = hosts
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or hand on, one request."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        fault = self._fault(scope, headers)
        if fault is not None:
            await self._refuse(fault, scope, receive, send)
            return
        query = parse_qs(scope["query_string"].decode("latin-1"))
        brought = query.get(TOKEN, [""])[0] if self._token else ""

        async def answer(message: Message) -> None:
            if message["type"] == "http.response.start":
                own = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    own.setdefault(name, value)
                if brought:
                    own.append(
                        "Set-Cookie", f"{_COOKIE}={brought}; HttpOnly; SameSite=Strict; Path=/"
                    )
            await send(message)

        await self._app(scope, receive, answer)

    def _fault(self, scope: Scope, headers: Headers) -> str | None:
        """Return why a request is refused, None if it is welcome."""
        if headers.get("host", "") not in self._hosts:
            return "this server does not know the name that you call it by"
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc not in self._hosts:
            return "a page of another site asks"
        if scope["type"] == "websocket" and origin is None:
            return "a WebSocket must say which page opens it"
        if headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
            return "a page of another site asks"
        if self._token is not None and not self._knows_token(scope, headers):
            return "the address lacks the access token that the server printed when it started"
        return None

    def _knows_token(self, scope: Scope, headers: Headers) -> bool:
        """Return whether a request carries the token, in its address or in a cookie."""
        assert self._token is not None
        given = parse_qs(scope["query_string"].decode("latin-1")).get(TOKEN, [])
        cookies: SimpleCookie = SimpleCookie()
        try:
            cookies.load(headers.get("cookie", ""))
        except CookieError:
            return False
        if _COOKIE in cookies:
            given.append(cookies[_COOKIE].value)
        return any(hmac.compare_digest(each.encode(), self._token.encode()) for each in given)

    async def _refuse(self, fault: str, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request that is not welcome."""
        if scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": fault})
            return
        response = PlainTextResponse(f"Refused: {fault}.\n", status_code=403, headers=HEADERS)
        await response(scope, receive, send)
