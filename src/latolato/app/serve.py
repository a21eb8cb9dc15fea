"""`latolato app`: starts the server and opens the browser."""

from __future__ import annotations

import ipaddress
import secrets
import socket
import threading
import webbrowser
from collections.abc import Mapping, Sequence
from pathlib import Path
from urllib.parse import urlencode

import uvicorn

from latolato.app.film_store import Allowance
from latolato.app.guard import TOKEN
from latolato.app.server import Settings, make_app
from latolato.errors import InputError

DEFAULT_PORT = 8765


def serve(
    host: str = "127.0.0.1",
    port: int | None = None,
    *,
    browser: bool = True,
    allow_others: bool = False,
    report: Path | None = None,
    stored: Sequence[Path] = (),
    video_megabytes: float | None = None,
    video_minutes: float | None = None,
) -> None:
    """Serve the application until it is stopped.

    Parameters
    ----------
    host : str
        The address to listen on.
    port : int, optional
        The port, 0 for any free one; by default 8765, or a free one if that is taken.
    browser : bool
        Whether to open the page.
    allow_others : bool
        Whether other machines may use the server; they need the token that is printed.
    report : Path, optional
        Folder that `latolato reproduce` wrote; its figures are shown in place of quick ones.
    stored : sequence of Path
        Maps that pages may open: Zarr stores and NetCDF files of sweeps.
    video_megabytes, video_minutes : float, optional
        Largest and longest video that a page may upload; by default as `Allowance` says.

    Raises
    ------
    InputError
        If `host` is an address that other machines reach and `allow_others` is false, if
        `report` holds no report, if a stored map is none, or a limit is not positive.
    OSError
        If the port is taken, or a stored map is not there.
    """
    others = not is_own(host)
    if others and not allow_others:
        raise InputError(
            f"host {host} can be reached from other machines; add --allow-others to let in those "
            "that know the access token"
        )
    if report is not None and not (report / "index.html").is_file():
        raise InputError(f"'{report}' holds no report; make one: latolato reproduce {report}")
    maps: Mapping[str, Path] = {}
    if stored:
        from latolato.app.map_stored import named

        maps = named(stored)
    films = Allowance.of(video_megabytes, video_minutes)
    listener = _listener(host, port)
    port = listener.getsockname()[1]
    token = secrets.token_urlsafe() if others else None
    settings = Settings(host=host, port=port, token=token, report=report, films=films, stored=maps)
    shown = f"[{host}]" if ":" in host else host
    address = f"http://{shown}:{port}/" + (f"?{TOKEN}={settings.token}" if others else "")
    told = f"latolato runs at {address}\n"
    if maps:
        query = urlencode({"view": "map", "map.stored": next(iter(maps))})
        address += f"{'&' if others else '?'}{query}"
        told += f"The map is at {address}\n"
    print(f"{told}Stop it with Ctrl-C.", flush=True)
    threading.Thread(target=_warm, daemon=True).start()
    if browser:
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
    config = uvicorn.Config(
        make_app(settings),
        log_level="warning",
        access_log=False,
        ws_max_size=1_000_000,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=1,
    )
    uvicorn.Server(config).run(sockets=[listener])


def is_own(host: str) -> bool:
    """Return whether an address is reached from this machine only."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _listener(host: str, port: int | None) -> socket.socket:
    """Return a socket that listens, on a free port if the usual one is taken and none was asked."""
    try:
        return socket.create_server((host, DEFAULT_PORT if port is None else port))
    except OSError:
        if port is not None:
            raise
    return socket.create_server((host, 0))


def _warm() -> None:
    """Load the kernel of a usual run, so that the first one on screen need not wait."""
    from latolato.app.forms import registry
    from latolato.app.given import Asked
    from latolato.app.runs import run_block

    registry()
    run_block(Asked("toy", {"duration": "1 s"}))
