"""What one page does with its toy: messages in, frames of numbers out."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from latolato.app.given import RunRequest
from latolato.core.errors import InputError

if TYPE_CHECKING:
    from latolato.app.recording import Recording
    from latolato.app.toy import Toy

# Numbers of a frame, in this order.
FRAME = (
    "number",  # of the frame
    "seq",  # of the last message that the frame knows
    "time",
    "angle_1",
    "angle_2",
    "velocity_1",
    "velocity_2",
    "pivot_height",
    "pivot_velocity",
    "pivot_acceleration",
    "drive_amplitude",  # as it is now; a change takes its time
    "drive_frequency",
    "phase",
    "kinetic_energy",
    "potential_energy",
    "contacts",  # since the start
    "clack",  # closing speed of the hardest contact since the last frame [rad/s]
    "recorded",  # seconds; -1 without a recording
    "flags",  # 1 paused, 2 a ball is held
)
_PACK = struct.Struct(f"<{len(FRAME)}d").pack
PAUSED, HELD = 1, 2
# Frames that a page has not seen yet; beyond that frames are left out, not queued.
MOST_UNSEEN = 60


class Session:
    """What one page does with its toy."""

    def __init__(self) -> None:
        self.toy: Toy | None = None
        self.request: RunRequest | None = None
        self.seq = 0.0
        self.acked = 0
        self.number = 0
        self.paused = False
        self.finished: list[Recording] = []

    def begin(self, hello: Any) -> dict[str, Any]:
        """Make the toy that a page asks for and return what the page must know of it.

        Raises
        ------
        InputError
            For bad input.
        """
        from latolato.app.toy import Toy

        request = RunRequest.from_json(hello)
        scenario = request.to_scenario()
        if scenario.varied:
            raise InputError(f"{scenario.name or 'this scenario'} is a map, not one run")
        toy = Toy(scenario, hello.get("state"))
        controls = hello.get("controls")
        if controls is not None:
            toy.set(checked_object("controls", controls))
            if hello.get("state") is None:
                toy.settle()
        toy.advance()  # whatever must be compiled or loaded is, before the clock runs
        self.toy, self.request = toy, request
        return ready(toy, scenario)

    def apply(self, message: Any) -> None:
        """Do what a message asks for.

        Raises
        ------
        InputError
            For bad input; nothing of the message is done then, but what stands before it.
        """
        assert self.toy is not None
        toy = self.toy
        given = checked_object("a message", message)
        known = ("seq", "ack", "set", "push", "drag", "pause", "record", "reset")
        for name in given:
            if name not in known:
                raise InputError(f"unknown message '{name}': known are {', '.join(known)}")
        if "ack" in given:
            self.acked = int(_count("ack", given["ack"]))
        if "set" in given:
            toy.set(checked_object("set", given["set"]))
        if "push" in given:
            toy.push(given["push"])
        if "drag" in given:
            if given["drag"] is None:
                toy.release()
            else:
                drag = checked_object("drag", given["drag"])
                toy.hold(drag.get("ball"), drag.get("angle"))
        if "pause" in given:
            self.paused = _switch("pause", given["pause"])
        if "record" in given:
            if _switch("record", given["record"]):
                toy.record()
            else:
                self.stop_recording()
        if given.get("reset"):
            self.restart()
        if "seq" in given:
            self.seq = _count("seq", given["seq"])

    def restart(self) -> None:
        """Begin again from the start, with the controls as they are."""
        from latolato.app.toy import Toy

        assert self.toy is not None
        assert self.request is not None
        self.stop_recording()
        fresh = Toy(self.request.to_scenario())
        fresh.set(self.toy.controls)
        fresh.settle()
        self.toy = fresh

    def stop_recording(self) -> None:
        """End a recording, if there is one, and put it aside."""
        assert self.toy is not None
        result = self.toy.finish()
        if result is not None:
            self.finished.append(result)

    def advance(self, ticks: int) -> str | None:
        """Move the toy on; return why it had to begin again, if it had."""
        assert self.toy is not None
        try:
            for _ in range(ticks):
                self.toy.advance()
        except InputError as error:
            self.restart()
            return str(error)
        if self.toy.recording is not None and self.toy.recording.is_full:
            self.stop_recording()
        return None

    def frame(self) -> bytes | None:
        """Return the present numbers, or None while the page is behind."""
        toy = self.toy
        assert toy is not None
        if self.number - self.acked >= MOST_UNSEEN:
            return None
        self.number += 1
        state = toy.state()
        angles, velocities = (*toy.angles, 0.0)[:2], (*toy.velocities, 0.0)[:2]
        flags = PAUSED * self.paused | HELD * toy.is_held
        recorded = toy.recording.duration if toy.recording else (0.0 if toy.is_recording else -1.0)
        clack, toy.clack = toy.clack, 0.0
        return _PACK(
            self.number, self.seq, toy.time, *angles, *velocities, *toy.pivot,
            state["drive_amplitude"], state["drive_frequency"], state["phase"],
            toy.kinetic, toy.potential, toy.contacts, clack, recorded, flags,
        )  # fmt: skip


def ready(toy: Toy, scenario: Any) -> dict[str, Any]:
    """Return what a page must know of a toy beside its motion."""
    from latolato.app.given import options_of
    from latolato.app.runs import balls_of
    from latolato.app.steering import is_by_cosine

    system = toy.system
    return {
        "balls": balls_of(scenario),
        "angles": system.angles,
        "natural_frequency": system.natural_frequency,
        "gravity": system.gravity,
        "controls": dict(toy.controls),
        "limits": {name: toy.limits[name] for name in toy.controls},
        "frame": FRAME,
        "title": scenario.title,
        "options": options_of(scenario),
        "by_cosine": is_by_cosine(scenario.drive),
    }


def checked_object(name: str, value: Any) -> Mapping[str, Any]:
    """Return a JSON object, or raise InputError."""
    if not isinstance(value, Mapping):
        raise InputError(f"must be an object, got {shown(value)}", parameter=name)
    return value


def _count(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"must be a number, got {shown(value)}", parameter=name)
    if not 0 <= value <= 2**53:
        raise InputError(f"must lie in [0, 2^53], got {shown(value)}", parameter=name)
    return float(value)


def _switch(name: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise InputError(f"must be true or false, got {shown(value)}", parameter=name)
    return value


def shown(value: Any) -> str:
    """Return a value for a message, cut short."""
    return repr(value)[:60]
