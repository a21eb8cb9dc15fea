"""The live view beside the numbers asked of it: messages a second, key to motion, many users.

Starts a server of its own. Key to motion is measured twice: from a message to the first frame that
shows it, by a client without a browser, and, where Chromium is found, from the key press in the
page to the next picture that shows it. Users are clients in one other process, each with its toy.
"""

from __future__ import annotations

import asyncio
import json
import os
import statistics
import struct
import time
from typing import Any

import websockets
from pages import browsing, serving

from latolato.app.live import MOST_BEHIND
from latolato.app.session import FRAME, TICKS_PER_SECOND

SECONDS = 12.0
USERS = (1, 20)
KEYS = 60
_SIZE = struct.Struct(f"<{len(FRAME)}d")
HELLO = {"hello": {"scenario": "fig12"}}


def frame_of(data: Any) -> dict[str, float]:
    """Return a frame by name."""
    return dict(zip(FRAME, _SIZE.unpack(data), strict=True))


async def user(address: str, seconds: float, keys: int = 0) -> dict[str, list[float]]:
    """Return arrivals and lateness of frames, and the delays of keys [s]."""
    url = address.replace("http", "ws") + "ws/live"
    found: dict[str, list[float]] = {"arrivals": [], "late": [], "keys": [], "skipped": []}
    async with websockets.connect(url, origin=address.rstrip("/"), compression=None) as socket:
        await socket.send(json.dumps(HELLO))
        assert "ready" in json.loads(await socket.recv())
        first, last, begun = None, 0.0, time.perf_counter()
        pressed, amplitude, seq, wait = 0.0, 0.03, 0, begun + 1.0
        before = amplitude
        offsets = []
        while time.perf_counter() - begun < seconds:
            data = await socket.recv()
            now = time.perf_counter()
            if isinstance(data, str):
                continue
            frame = frame_of(data)
            found["arrivals"].append(now)
            # How much later than the clock of the toy allows, against the earliest frame.
            offsets.append(now - frame["time"])
            if first is None:
                first = frame["time"]
            elif frame["time"] - last > 1.5 / TICKS_PER_SECOND:
                found["skipped"].append(frame["time"] - last)
            last = frame["time"]
            if frame["number"] % 6 == 0:
                await socket.send(json.dumps({"ack": frame["number"]}))
            if pressed and frame["seq"] >= seq and frame["drive_amplitude"] != before:
                found["keys"].append(now - pressed)
                pressed, wait = 0.0, now + 0.15 + 0.01 * (seq % 7)
            elif keys and not pressed and now > wait and len(found["keys"]) < keys:
                seq += 1
                before = frame["drive_amplitude"]
                amplitude = 0.03 if amplitude != 0.03 else 0.031
                message = {"seq": seq, "set": {"drive_amplitude": amplitude}}
                pressed = time.perf_counter()
                await socket.send(json.dumps(message))
        earliest = min(offsets)
        found["late"] = [offset - earliest for offset in offsets]
    return found


async def users(address: str, count: int) -> list[dict[str, list[float]]]:
    """Return what several users saw at once."""
    return await asyncio.gather(
        *(user(address, SECONDS, KEYS if i == 0 else 0) for i in range(count))
    )


def in_browser(address: str) -> list[float]:
    """Return the times from a key press to the picture that shows its motion [s]."""
    with browsing() as browser:
        page = browser.new_page(base_url=address)
        page.goto("/?view=live")
        page.wait_for_selector("[data-ready]")
        page.wait_for_timeout(1500)
        found = page.evaluate(
            """async keys => {
              const view = window.latolato.views.live;
              const picture = () => new Promise(requestAnimationFrame);
              const found = [];
              for (let k = 0; k < keys; k += 1) {
                await new Promise(done => setTimeout(done, 140 + 13 * (k % 7)));
                const before = view.motion.frame.drive_amplitude;
                const begun = performance.now();
                view.parts.canvas.dispatchEvent(new KeyboardEvent("keydown",
                  { key: k % 2 ? "ArrowDown" : "ArrowUp", bubbles: true, cancelable: true }));
                while (view.motion.frame.drive_amplitude === before) await picture();
                found.push((performance.now() - begun) / 1000);
              }
              return found;
            }""",
            KEYS,
        )
    return [float(value) for value in found]


def line(what: str, value: str, asked: str = "") -> None:
    """Print one result beside what is asked."""
    print(f"{what:58} {value:>22}   {asked}")


def main() -> None:
    """Measure and print."""
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n")
    with serving() as server:
        address = server.address
        asyncio.run(user(address, 2.0))
        for count in USERS:
            seen = asyncio.run(users(address, count))
            rates = [
                (len(u["arrivals"]) - 1) / (u["arrivals"][-1] - u["arrivals"][0]) for u in seen
            ]
            late = sorted(value for u in seen for value in u["late"])
            worst = [max(u["late"]) for u in seen]
            skipped = sum(len(u["skipped"]) for u in seen)
            keys = seen[0]["keys"]
            who = f"{count} user{'s' if count > 1 else ''}"
            line(f"{who}: messages a second, median user", f"{statistics.median(rates):.2f}", "60")
            line(f"{who}: message to changed motion, median",
                 f"{1e3 * statistics.median(keys):.1f} ms", "<= 50 ms")  # fmt: skip
            line(f"{who}: lateness of a frame, median | 99 % | worst",
                 f"{1e3 * statistics.median(late):.1f} | {1e3 * late[int(0.99 * len(late))]:.1f} | "
                 f"{1e3 * late[-1]:.1f} ms", "")  # fmt: skip
            line(f"{who}: worst lateness of the median user",
                 f"{1e3 * statistics.median(worst):.1f} ms", "<= 50 ms")  # fmt: skip
            line(f"{who}: frames left out of {len(late)}", str(skipped))
        pressed = in_browser(address)
        line("browser: key to the picture of changed motion, median",
             f"{1e3 * statistics.median(pressed):.1f} ms", "<= 50 ms")  # fmt: skip
        line("a server held up for longer goes on from where it is", f"{1e3 * MOST_BEHIND:.0f} ms")


if __name__ == "__main__":
    main()
