"""The system's Firefox, driven by WebDriver BiDi over its own WebSocket."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from typing import Any

from websockets.sync.client import connect

_BROWSERS = ("firefox-esr", "firefox")


@contextmanager
def firefox_page(address: str) -> Iterator[Callable[[str], Any]]:
    """Yield a function that returns the value of an expression in a page of this address."""
    path = next(filter(None, map(shutil.which, _BROWSERS)), None)
    assert path is not None, "this test needs Firefox: apt-get install firefox-esr"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [path, "--headless", "--no-remote", "--profile", profile]
        command += ["--remote-debugging-port", "0", "about:blank"]
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
            assert process.stderr is not None
            said = filter(None, (re.search(r"listening on (ws:\S+)", s) for s in process.stderr))
            with connect(f"{next(said)[1]}/session", max_size=None) as socket:
                numbers = count(1)

                def do(method: str, **params: Any) -> Any:
                    number = next(numbers)
                    socket.send(json.dumps({"id": number, "method": method, "params": params}))
                    while (answer := json.loads(socket.recv())).get("id") != number:
                        pass
                    assert "result" in answer, answer
                    return answer["result"]

                do("session.new", capabilities={})
                (tab,) = do("browsingContext.getTree")["contexts"]

                def evaluate(expression: str) -> Any:
                    target = {"context": tab["context"]}
                    answer = do(
                        "script.evaluate", expression=expression, target=target, awaitPromise=True
                    )
                    assert answer["type"] == "success", answer["exceptionDetails"]["text"]
                    return answer["result"].get("value")

                do(
                    "browsingContext.navigate", context=tab["context"], url=address,
                    wait="complete",
                )  # fmt: skip
                yield evaluate
                do("browser.close")
            process.stderr.read()
