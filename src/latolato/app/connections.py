"""What a connection may take of the server before it has asked for anything."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any, ClassVar

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol


@dataclass(frozen=True, kw_only=True)
class ConnectionLimits:
    """What connections may take.

    Attributes
    ----------
    header_time : float
        Longest time from the beginning of a connection, or the end of the last answer, to the end
        of a request's header [s].
    header_size : int
        Longest header [bytes].
    body_time : float
        Longest time for the JSON of a request [s].
    first_frame_time : float
        Longest wait for the first frame of a WebSocket [s].
    per_address : int
        Most connections from one address.
    """

    header_time: float = 10.0
    header_size: int = 65_536
    body_time: float = 30.0
    first_frame_time: float = 10.0
    per_address: int = 100


class Connection(HttpToolsProtocol):
    """One connection, until it ends, exceeds the limits or becomes a WebSocket.

    Where an address has all the connections it may have, a new one takes the place of the one that
    has waited longest without a request. If all of them are busy the new one is refused.
    """

    limits: ClassVar[ConnectionLimits]
    _deadline: asyncio.TimerHandle | None = None
    # Bytes since the last that belonged to a body, or ended a header or a request.
    _pending = 0

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Admit the connection, or refuse it."""
        super().connection_made(transport)
        if self._is_admitted():
            self._expect_header()
        else:
            self._refuse(
                HTTPStatus.SERVICE_UNAVAILABLE,
                f"your address has {self.limits.per_address} connections; close some of them",
            )

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop the clock."""
        self._expect_nothing()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Read bytes, but no header that is too long."""
        self._pending += len(data)
        super().data_received(data)
        if self._pending > self.limits.header_size and not self.transport.is_closing():
            self._refuse(
                HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE,
                f"the header exceeds {self.limits.header_size} bytes",
            )

    def on_headers_complete(self) -> None:
        """Stop the clock: the request is here."""
        self._pending = 0
        self._expect_nothing()
        super().on_headers_complete()

    def on_body(self, body: bytes) -> None:
        """Count no bytes of a body."""
        self._pending = 0
        super().on_body(body)

    def on_message_complete(self) -> None:
        """Count the bytes of the next request from here."""
        self._pending = 0
        super().on_message_complete()

    def on_response_complete(self) -> None:
        """Start the clock for the next request."""
        super().on_response_complete()
        # A further request may have come before this answer was complete.
        if self.cycle.response_complete:
            self._expect_header()

    def _is_admitted(self) -> bool:
        """Return whether there is room, after closing an idle connection if necessary."""
        if self.client is None:
            return True
        everyone: set[Any] = self.connections  # WebSockets too
        same = [each for each in everyone if each.client and each.client[0] == self.client[0]]
        if len(same) <= self.limits.per_address:
            return True
        waiting = [
            (each._deadline.when(), number)
            for number, each in enumerate(same)
            if isinstance(each, Connection)
            and each._deadline is not None
            and not each.transport.is_closing()
            and not each.transport.get_write_buffer_size()
        ]
        if not waiting:
            return False
        same[min(waiting)[1]].transport.close()
        return True

    def _expect_header(self) -> None:
        """Give the next request its time."""
        self._expect_nothing()
        self._deadline = self.loop.call_later(self.limits.header_time, self._give_up)

    def _expect_nothing(self) -> None:
        """Stop the clock of the current request."""
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _give_up(self) -> None:
        """End a connection whose request did not come in time."""
        self._deadline = None
        if self.transport.is_closing():
            return
        if self._pending:
            self._refuse(
                HTTPStatus.REQUEST_TIMEOUT,
                f"the header was not complete within {self.limits.header_time:g} s",
            )
        else:  # browsers keep such connections in reserve, and would take a text for an answer
            self.transport.close()

    def _refuse(self, status: HTTPStatus, fault: str) -> None:
        """Say why the connection ends, and end it."""
        self._expect_nothing()
        text = f"Refused: {fault}.\n"
        self.transport.write(
            f"HTTP/1.1 {status.value} {status.phrase}\r\n"
            "Content-Type: text/plain; charset=utf-8\r\n"
            f"Content-Length: {len(text)}\r\n"
            "Connection: close\r\n"
            f"\r\n{text}".encode("ascii")
        )
        self.transport.close()


def make_protocol(limits: ConnectionLimits) -> type[Connection]:
    """Return the protocol of a server that ends connections beyond the limits."""
    return type("LimitedConnection", (Connection,), {"limits": limits})
