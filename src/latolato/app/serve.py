"""`latolato app`: starts the server and opens the browser."""

from __future__ import annotations

import ipaddress
import socket
import threading
import webbrowser
from collections.abc import Mapping, Sequence
from pathlib import Path
from urllib.parse import urlencode

import uvicorn

from latolato.app import kernels_folder
from latolato.app.experiment.store import Allowance
from latolato.app.scratch import scratch_folder
from latolato.app.server import Settings, bracketed, make_app
from latolato.core.errors import InputError

DEFAULT_PORT = 8765


def serve(
    host: str = "127.0.0.1",
    port: int | None = None,
    *,
    browser: bool = True,
    report: Path | None = None,
    stored: Sequence[Path] = (),
    video_megabytes: float | None = None,
    video_minutes: float | None = None,
) -> None:
    """Serve the application until it is stopped.

    Parameters
    ----------
    host : str
        The address of this machine to listen on.
    port : int, optional
        The port; 0 for any free one. Default: 8765, or a free one if that is taken.
    browser : bool
        Whether to open the page.
    report : Path, optional
        Folder that `latolato reproduce` wrote, to which the page's entry *Report* leads.
    stored : sequence of Path
        Maps that pages may open: Zarr stores and NetCDF files of sweeps.
    video_megabytes, video_minutes : float, optional
        Largest and longest video that a page may upload; by default as `Allowance` says.

    Raises
    ------
    InputError
        If other machines could reach `host`, if `report` holds no report, if a stored map is none,
        or a limit is not positive.
    OSError
        If the port is taken, a stored map is not there, or the code for pages has not been
        compiled.
    """
    kernels_folder()
    if not _is_own(host):
        raise InputError(
            "must be an address of this machine alone, such as 127.0.0.1",
            parameter="host",
            value=host,
            way_out="latolato app is a local program; for a class, put the static site "
            "(`latolato site`) on any web server",
        )
    if report is not None and not (report / "index.html").is_file():
        raise InputError(
            f"'{report}' contains no report",
            way_out=f"make one: latolato reproduce --output {report}",
        )
    maps: Mapping[str, Path] = {}
    if stored:
        from latolato.app.map.stored import named

        maps = named(stored)
    clips = Allowance.of(video_megabytes, video_minutes)
    with _listener(host, port) as listener, scratch_folder():
        port = listener.getsockname()[1]
        settings = Settings(
            host=host,
            port=port,
            report=report,
            clips=clips,
            stored=maps,
        )
        address = f"http://{bracketed(host)}:{port}/"
        text = f"latolato runs at {address}\n"
        if maps:
            address += f"?{urlencode({'view': 'map', 'map.stored': next(iter(maps))})}"
            text += f"The map is at {address}\n"
        print(f"{text}Stop it with Ctrl-C.", flush=True)
        threading.Thread(target=_warm, daemon=True).start()
        if browser:
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
        make_server(settings).run(sockets=[listener])


def make_server(settings: Settings) -> uvicorn.Server:
    """Return the server of the application, which runs on a socket that listens."""
    config = uvicorn.Config(
        make_app(settings),
        log_level="warning",
        access_log=False,
        ws_max_size=1_000_000,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=1,
    )
    return uvicorn.Server(config)


def _is_own(host: str) -> bool:
    """Return whether an address is reached from this machine only."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _listener(host: str, port: int | None) -> socket.socket:
    """Return a socket that listens, by default on the usual port, or a free one if it is taken."""

    def listen(port: int) -> socket.socket:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        return socket.create_server((host, port), family=family)

    try:
        return listen(DEFAULT_PORT if port is None else port)
    except OSError:
        if port is not None:
            raise
    return listen(0)


def _warm() -> None:
    """Make what every page asks for first."""
    from latolato.app.forms import registry

    registry()
