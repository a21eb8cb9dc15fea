"""`latolato app`: starts the server and opens the browser."""

from __future__ import annotations

import ipaddress
import re
import secrets
import socket
import threading
import webbrowser
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from urllib.parse import urlencode

import uvicorn

from latolato.app import kernels_folder
from latolato.app.experiment.store import Allowance
from latolato.app.guard import TOKEN
from latolato.app.scratch import scratch_folder
from latolato.app.server import ANY_ADDRESS, Settings, has_port, make_app
from latolato.core.errors import InputError

DEFAULT_PORT = 8765
_NAME = re.compile(r"([A-Za-z0-9._-]+|\[[0-9A-Fa-f:.]+\])(:[0-9]{1,5})?")
# Nothing is sent there: the system only chooses the way, and with it our own address. Both are
# reserved for documentation (RFC 5737, RFC 3849), so that the usual way out is chosen.
_ELSEWHERE = {socket.AF_INET: "192.0.2.1", socket.AF_INET6: "2001:db8::1"}


def serve(
    host: str = "127.0.0.1",
    port: int | None = None,
    *,
    browser: bool = True,
    allow_others: bool = False,
    names: Sequence[str] = (),
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
        The port; 0 for any free one. Default: 8765, or a free one if that is taken.
    browser : bool
        Whether to open the page.
    allow_others : bool
        Whether other machines may use the server; they need the token that is printed.
    names : sequence of str
        Further names of this server, ``HOST`` or ``HOST:PORT``, as others type them.
    report : Path, optional
        Folder that `latolato reproduce` wrote, to which the page's entry *Report* leads.
    stored : sequence of Path
        Maps that pages may open: Zarr stores and NetCDF files of sweeps.
    video_megabytes, video_minutes : float, optional
        Largest and longest video that a page may upload; by default as `Allowance` says.

    Raises
    ------
    InputError
        If others can reach the server and `allow_others` is false, if a name is none, if `report`
        holds no report, if a stored map is none, or a limit is not positive.
    OSError
        If the port is taken, a stored map is not there, or the code for pages has not been
        compiled.
    """
    kernels_folder()
    others = not is_own(host) or bool(names)
    if others and not allow_others:
        rule = f"{{parameter}} {host} can be reached from other machines"
        if names:
            rule = f"{{parameter}} {names[0]} lets in other machines"
        raise InputError(
            rule,
            parameter="name" if names else "host",
            way_out="add --allow-others to let in those that know the access token",
        )
    for name in names:
        if _NAME.fullmatch(name) is None:
            raise InputError("must be HOST or HOST:PORT", parameter="name", value=name)
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
            token=secrets.token_urlsafe() if others else None,
            names=(*names, *_own_names()) if others else (),
            report=report,
            clips=clips,
            stored=maps,
        )
        address = link(_for_this_machine(host, port), settings.token)
        text = f"latolato runs at {address}\n"
        if others and (host in ANY_ADDRESS or names):
            text += f"Others reach it at {link(_for_others(host, port, names), settings.token)}\n"
        if maps:
            query = urlencode({"view": "map", "map.stored": next(iter(maps))})
            address += f"{'&' if others else '?'}{query}"
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


def is_own(host: str) -> bool:
    """Return whether an address is reached from this machine only."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def link(server: str, token: str | None) -> str:
    """Return the address of the page on a server.

    Examples
    --------
    >>> link("http://127.0.0.1:8765", "secret")
    'http://127.0.0.1:8765/?token=secret'
    """
    return f"{server}/" + ("" if token is None else f"?{urlencode({TOKEN: token})}")


def _for_this_machine(host: str, port: int) -> str:
    """Return how browsers of this machine reach the server."""
    own = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
    return f"http://{_bracketed(own)}:{port}"


def _for_others(host: str, port: int, names: Sequence[str]) -> str:
    """Return how browsers of other machines reach the server."""
    if names and is_own(host):  # something before this server hands requests on, with TLS
        return f"https://{names[0]}"
    if names:
        return f"http://{names[0]}" if has_port(names[0]) else f"http://{names[0]}:{port}"
    return f"http://{_bracketed(_outer_address(host) or _own_names()[0])}:{port}"


def _bracketed(host: str) -> str:
    """Return a host as it stands in an address."""
    return f"[{host}]" if ":" in host else host


def _outer_address(host: str) -> str | None:
    """Return the address of this machine in its network, None if there is no network."""
    families = [socket.AF_INET, socket.AF_INET6]
    if host == "0.0.0.0":
        families.remove(socket.AF_INET6)
    elif not socket.has_dualstack_ipv6():
        families.remove(socket.AF_INET)
    for family in families:
        with suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.connect((_ELSEWHERE[family], 9))
            address: str = probe.getsockname()[0]
            return address
    return None


def _own_names() -> tuple[str, ...]:
    """Return the names that this machine gives itself.

    What a name server calls it is not among them: others may rule that, and `--name` adds it.
    """
    name = socket.gethostname()
    # How machines of a local network without a name server find each other (RFC 6762).
    return (name,) if "." in name else (name, f"{name}.local")


def _listener(host: str, port: int | None) -> socket.socket:
    """Return a socket that listens, by default on the usual port, or a free one if it is taken."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    is_dual = host == "::" and socket.has_dualstack_ipv6()

    def listen(port: int) -> socket.socket:
        return socket.create_server((host, port), family=family, dualstack_ipv6=is_dual)

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
