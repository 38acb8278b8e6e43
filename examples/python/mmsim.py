"""A client for a micromouse maze simulator such as `mmsim`. Copy this file into your project.

It needs Python 3.9 and pyzmq (`python3 -m pip install pyzmq`).

    from mmsim import Heading, Pose, Simulator

    with Simulator() as simulator:
        simulator.reset()
        left, front, right = simulator.walls(Pose(0, 0, Heading.NORTH))

Cell (0, 0) is the south-west corner, x grows east, y grows north.
"""
from __future__ import annotations

import atexit
import json
import os
import weakref
from dataclasses import dataclass
from enum import Enum, IntFlag
from types import TracebackType
from typing import NamedTuple, Sequence

import zmq


# The letters of the colours of the simulator mms.
COLOURS = "kbacgorwyBCAGORVY"


class Heading(Enum):
    """A heading. The headings are in clockwise order, a quarter turn apart."""

    NORTH = "N"
    EAST = "E"
    SOUTH = "S"
    WEST = "W"

    def turned(self, quarters: int) -> Heading:
        """Returns the heading after quarter turns to the right; negative numbers turn left."""
        headings = list(Heading)
        return headings[(headings.index(self) + quarters) % 4]


@dataclass(frozen=True)
class Pose:
    """The cell and the heading of the mouse."""

    x: int
    y: int
    heading: Heading

    def after(self, quarters: int) -> Pose:
        """Returns the pose after quarter turns to the right and a step forward."""
        heading = self.heading.turned(quarters)
        east = {Heading.EAST: 1, Heading.WEST: -1}.get(heading, 0)
        north = {Heading.NORTH: 1, Heading.SOUTH: -1}.get(heading, 0)
        return Pose(self.x + east, self.y + north, heading)


class Walls(NamedTuple):
    """The walls around the mouse; a field is true if there is a wall."""

    left: bool
    front: bool
    right: bool


class Known(IntFlag):
    """Flags for what the mouse knows about a cell; combine them with `|`."""

    VISITED = 1
    EAST = 2
    SOUTH = 4
    WEST = 8
    NORTH = 16

    @classmethod
    def wall(cls, heading: Heading) -> Known:
        """Returns the flag for the wall on this side of a cell."""
        return cls[heading.name]


class SimulatorError(Exception):
    """The simulator is not reachable, or its reply is invalid."""


class NoReply(SimulatorError):
    """The simulator did not reply in time. The next request uses a new connection."""


class Refused(SimulatorError):
    """The simulator refused the request, which changed nothing. The message says why."""


class Simulator:
    """A connection to a simulator. The simulator may be started later.

    The default endpoint is the environment variable MMSIM_ENDPOINT, which `mmsim run` sets, or
    tcp://127.0.0.1:6574. A request fails if there is no reply within `timeout` seconds, by default
    5 s. There is no limit by default with `mmsim run`, which holds replies while the mouse is paused.

    `text`, `colour`, `wall`, `log`, `name`, `restart`, `clear_texts`, `clear_colours` and
    `clear_walls` annotate the next state. `annotations` says whether they are sent: the default is
    True with `mmsim run` and otherwise False, because the reference simulator never replies to a
    request that it does not know. Annotations that are not sent have no effect.

    The next call of `state` sends the annotations before the state. If it raises `Refused`, the
    annotations that the simulator has not accepted are dropped, so the next state is not refused
    for the same reason. If it raises `NoReply`, they are sent again with the next state, so a line
    may be logged twice. The annotations after the last state are sent by `close`, when the
    object is deleted, and when the program ends.
    """

    def __init__(
        self,
        endpoint: str | None = None,
        timeout: float | None = None,
        annotations: bool | None = None,
    ) -> None:
        variable = os.environ.get("MMSIM_ENDPOINT")
        self._endpoint = endpoint or variable or "tcp://127.0.0.1:6574"
        # A mouse of `mmsim run` may also connect to another simulator.
        is_run = bool(variable) and self._endpoint == variable
        self._timeout = 5.0 if timeout is None and not is_run else timeout
        # None until `info` is asked whether the simulator knows annotations.
        self._annotates = None if annotations or (annotations is None and is_run) else False
        self._entries: list[bytes] = []
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._connect()
        atexit.register(_close, weakref.ref(self))

    def ping(self) -> None:
        """Checks that the simulator replies."""
        self._expect(b"pong", b"ping")

    def reset(self) -> None:
        """Deletes all states in the simulator and begins a new search."""
        self._entries.clear()
        self._expect(b"ok", b"reset")

    def walls(self, pose: Pose) -> Walls:
        """Returns the walls around a mouse in this pose."""
        reply = self._ask(b"W" + _pose_bytes(pose))
        if len(reply) != 3 or max(reply) > 1:
            raise SimulatorError(f"expected three bytes of walls, each 0 or 1, found {reply!r}")
        return Walls(*map(bool, reply))

    def state(
        self, pose: Pose, weights: Sequence[Sequence[int]], walls: Sequence[Sequence[int]]
    ) -> None:
        """Reports the state of the mouse, for the viewer and recordings.

        Both grids are indexed as `grid[x][y]`. `weights` holds any non-negative integer per cell,
        such as the distance to the goal; numbers above 255 are sent as 255. `walls` holds the
        `Known` flags of each cell.
        """
        if [len(column) for column in weights] != [len(column) for column in walls]:
            raise ValueError("weights and walls must have the same shape")
        self._send_annotations()
        message = bytearray(b"S" + _pose_bytes(pose))
        for grid in (weights, walls):
            message += b"F"  # column by column from the west
            message += bytes(min(cell, 255) for column in grid for cell in column)
        self._expect(b"ok", bytes(message))

    def text(self, x: int, y: int, text: object) -> None:
        """Sets the text of a cell, at most 10 characters. An empty text clears it."""
        text = _printable(str(text))
        if len(text) > 10:
            raise ValueError(f"a text has at most 10 characters, found {text!r}")
        self._annotate(b"T" + bytes([x, y]) + _with_length(text))

    def colour(self, x: int, y: int, letter: str | None) -> None:
        """Sets the colour of a cell, one of the letters `COLOURS` of mms, or clears it."""
        if letter is not None and (len(letter) != 1 or letter not in COLOURS):
            raise ValueError(f"a colour is one of {COLOURS}, found {letter!r}")
        self._annotate(b"C" + bytes([x, y]) + (letter or "-").encode())

    def wall(self, x: int, y: int, heading: Heading, state: str) -> None:
        """Declares a wall of a cell, whatever the flags of the states say.

        `state` is "1" for present, "0" for absent, "?" for unknown, or "-" as in the states.
        """
        if state not in ("1", "0", "?", "-"):
            raise ValueError(f"a declared wall is 1, 0, ? or -, found {state!r}")
        self._annotate(b"D" + bytes([x, y]) + (heading.value + state).encode())

    def clear_texts(self) -> None:
        """Clears all texts."""
        self._annotate(b"t")

    def clear_colours(self) -> None:
        """Clears all colours."""
        self._annotate(b"c")

    def clear_walls(self) -> None:
        """Withdraws all declared walls."""
        self._annotate(b"d")

    def log(self, text: object) -> None:
        """Logs one or more lines. Lines are cut after 1000 bytes."""
        for line in str(text).splitlines() or [""]:
            cut = _printable(line).encode()[:1000].decode(errors="ignore").encode()
            self._annotate(b"L" + len(cut).to_bytes(2, "little") + cut)

    def name(self, mouse: str, strategy: str = "") -> None:
        """Names the mouse and its strategy, in at most 100 bytes each."""
        for kind, name in ((b"M", mouse), (b"S", strategy)):
            if len(name.encode()) > 100:
                raise ValueError(f"a name has at most 100 bytes, found {name!r}")
            self._annotate(kind + _with_length(_printable(name)))

    def restart(self) -> None:
        """Says that the mouse was put back at its start, and did not drive there."""
        self._annotate(b"R")

    def close(self) -> None:
        """Sends the annotations after the last state, and closes the connection."""
        try:
            if not self._context.closed:
                self._send_annotations()
        finally:
            self._context.destroy(linger=0)

    def __del__(self) -> None:
        context = getattr(self, "_context", None)
        if context and not context.closed:
            self.close()

    def __enter__(self) -> Simulator:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if isinstance(error, SimulatorError):
            self._entries.clear()
        self.close()

    def _connect(self) -> None:
        self._socket = self._context.socket(zmq.REQ)
        self._socket.linger = 0
        try:
            self._socket.connect(self._endpoint)
        except zmq.ZMQError as error:
            self._context.destroy(linger=0)
            raise SimulatorError(
                f"cannot reach {self._endpoint}: {error} (expected tcp://HOST:PORT)"
            ) from error

    def _annotate(self, entry: bytes) -> None:
        if self._annotates is not False:
            self._entries.append(entry)

    def _send_annotations(self) -> None:
        if self._entries and self._annotates is None:
            extensions = json.loads(self._ask(b"info")).get("extensions", [])
            self._annotates = "annotations" in extensions
        if not self._annotates:
            self._entries.clear()
        while self._entries:
            # A request has at most 4096 bytes.
            request, count = b"A", 0
            for entry in self._entries:
                if len(request) + len(entry) > 4096:
                    break
                request, count = request + entry, count + 1
            try:
                self._expect(b"ok", request)
            except Refused:
                self._entries.clear()
                raise
            del self._entries[:count]

    def _expect(self, expected: bytes, request: bytes) -> None:
        reply = self._ask(request)
        if reply != expected:
            raise SimulatorError(f"expected {expected!r}, found {reply!r}")

    def _ask(self, request: bytes) -> bytes:
        self._socket.send(request)
        if not self._socket.poll(None if self._timeout is None else round(1000 * self._timeout)):
            # A REQ socket cannot send again before it has received the missing reply.
            self._socket.close()
            self._connect()
            raise NoReply(
                f"no reply from {self._endpoint} within {self._timeout:g} s"
                " (start a simulator with `mmsim`)"
            )
        reply = self._socket.recv()
        if reply.startswith(b"error: "):
            reason = _printable(reply[7:].decode(errors="replace"))
            raise Refused(f"the simulator refused the request: {reason[:500]}")
        return reply


def _close(reference: weakref.ref[Simulator]) -> None:
    simulator = reference()
    if simulator:
        simulator.close()


def _pose_bytes(pose: Pose) -> bytes:
    return bytes([pose.x, pose.y]) + pose.heading.value.encode()


def _with_length(text: str) -> bytes:
    encoded = text.encode()
    return bytes([len(encoded)]) + encoded


def _printable(text: str) -> str:
    """Replaces characters that annotations cannot contain, such as tabs, with spaces."""
    return "".join(c if c.isprintable() else " " for c in text)
