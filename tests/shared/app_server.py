"""The application's server in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit


@dataclass
class Server:
    """A server of its own in another process."""

    process: subprocess.Popen[str]
    address: str

    @property
    def port(self) -> int:
        """The port on which it listens."""
        port = urlsplit(self.address).port
        assert port is not None
        return port


def start_server(*options: str) -> Server:
    """Return a server that answers."""
    command = [sys.executable, "-m", "latolato", "app", "--no-browser", *options]
    if "--port" not in options:
        command += ["--port", "0"]
    # Not where `make demo` may have left a report, which the server would show.
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, env={**os.environ}, cwd=Path(__file__).parent
    )
    assert process.stdout is not None
    line = process.stdout.readline()
    assert " at http" in line, f"the server said {line!r} instead of its address"
    return Server(process, line.split(" at ")[1].strip())


def stop_server(server: Server) -> None:
    """End a server and its pipe."""
    server.process.terminate()
    server.process.wait(timeout=20)
    assert server.process.stdout is not None
    server.process.stdout.close()


def frames_of(client: Any, path: str, request: Any) -> list[Any]:
    """Return all frames of a job's socket, from the test client, to its end."""
    with client.websocket_connect(path) as socket:
        socket.send_text(request if isinstance(request, str) else json.dumps(request))
        frames = [socket.receive()]
        while frames[-1]["type"] != "websocket.close":
            frames.append(socket.receive())
    return frames
