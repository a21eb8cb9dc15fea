"""`latolato app`: starts the server and opens the browser."""

from __future__ import annotations

import socket
import threading
import webbrowser
from collections.abc import Mapping, Sequence
from pathlib import Path
from urllib.parse import urlencode

import uvicorn

from latolato.app import kernels_folder
from latolato.app.server import Settings, make_app
from latolato.core.errors import InputError

HOST = "127.0.0.1"
DEFAULT_PORT = 8765


def serve(
    port: int | None = None,
    *,
    browser: bool = True,
    report: Path | None = None,
    stored: Sequence[Path] = (),
) -> None:
    """Serve the application to this machine until it is stopped.

    For a class, put the static site (`latolato.app.site.write_site`) on any web server.

    Parameters
    ----------
    port : int, optional
        The port; 0 for any free one. Default: 8765, or a free one if that is taken.
    browser : bool
        Whether to open the page.
    report : Path, optional
        Folder that `latolato reproduce` wrote, to which the page's entry *Report* leads.
    stored : sequence of Path
        Maps that pages may open: Zarr stores and NetCDF files of sweeps.

    Raises
    ------
    InputError
        If `report` holds no report, or a stored map is none.
    OSError
        If the port is taken, a stored map is not there, or the code for pages has not been
        compiled.
    """
    kernels_folder()
    if report is not None and not (report / "index.html").is_file():
        raise InputError(
            f"'{report}' contains no report",
            way_out=f"make one: latolato reproduce --output {report}",
        )
    maps: Mapping[str, Path] = {}
    if stored:
        from latolato.app.map.stored import named

        maps = named(stored)
    with _listener(port) as listener:
        settings = Settings(report=report, stored=maps)
        address = f"http://{HOST}:{listener.getsockname()[1]}/"
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


def _listener(port: int | None) -> socket.socket:
    """Return a socket that listens, by default on the usual port, or a free one if it is taken."""
    try:
        return socket.create_server((HOST, DEFAULT_PORT if port is None else port))
    except OSError:
        if port is not None:
            raise
    return socket.create_server((HOST, 0))


def _warm() -> None:
    """Make what every page asks for first."""
    from latolato.app.forms import registry

    registry()
