"""A micromouse maze simulator such as `mmsim`, as a Python class. Copy this file to your mouse.

It needs Python 3.9 and pyzmq (`python3 -m pip install pyzmq`).

    from mmsim import Heading, Pose, Simulator

    with Simulator() as simulator:
        simulator.reset()
        left, front, right = simulator.walls(Pose(0, 0, Heading.NORTH))

Cell (0, 0) is the south-west corner, x grows east, y grows north.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntFlag
from types import TracebackType
from typing import NamedTuple, Sequence

import zmq


class Heading(Enum):
    """Where the mouse looks; each is a quarter turn right of the one before it."""

    NORTH = "N"
    EAST = "E"
    SOUTH = "S"
    WEST = "W"

    def turned(self, quarters: int) -> Heading:
        """After so many quarter turns to the right; negative ones are to the left."""
        headings = list(Heading)
        return headings[(headings.index(self) + quarters) % 4]


@dataclass(frozen=True)
class Pose:
    """The cell in which the mouse stands, and where it looks."""

    x: int
    y: int
    heading: Heading

    def after(self, quarters: int) -> Pose:
        """After so many quarter turns to the right and a step into the next cell."""
        heading = self.heading.turned(quarters)
        east = {Heading.EAST: 1, Heading.WEST: -1}.get(heading, 0)
        north = {Heading.NORTH: 1, Heading.SOUTH: -1}.get(heading, 0)
        return Pose(self.x + east, self.y + north, heading)


class Walls(NamedTuple):
    """Whether the mouse sees a wall to its left, in front of it, to its right."""

    left: bool
    front: bool
    right: bool


class Known(IntFlag):
    """What the mouse knows of a cell; a cell is a sum of these."""

    VISITED = 1
    EAST = 2
    SOUTH = 4
    WEST = 8
    NORTH = 16

    @classmethod
    def wall(cls, heading: Heading) -> Known:
        """The wall at this side of the cell."""
        return cls[heading.name]


class SimulatorError(Exception):
    """The simulator cannot be asked, or its reply is none of the protocol."""


class NoReply(SimulatorError):
    """The simulator has not answered in time. The next request begins anew."""


class Refused(SimulatorError):
    """The simulator cannot serve the request, and says why. Nothing has changed."""


class Simulator:
    """A simulator at an endpoint. It may start later; a reply may take `timeout` seconds."""

    def __init__(self, endpoint: str = "tcp://127.0.0.1:6574", timeout: float = 5.0) -> None:
        self._endpoint = endpoint
        self._timeout = timeout
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._connect()

    def ping(self) -> None:
        """Makes sure that there is a simulator."""
        self._expect(b"pong", b"ping")

    def reset(self) -> None:
        """Lets the simulator forget all states: a new search begins."""
        self._expect(b"ok", b"reset")

    def walls(self, pose: Pose) -> Walls:
        """The walls that a mouse in this pose sees."""
        reply = self._ask(b"W" + _pose_bytes(pose))
        if len(reply) != 3 or max(reply) > 1:
            raise SimulatorError(f"expected three bytes of walls, each 0 or 1, found {reply!r}")
        return Walls(*map(bool, reply))

    def state(
        self, pose: Pose, weights: Sequence[Sequence[int]], walls: Sequence[Sequence[int]]
    ) -> None:
        """Tells what the mouse believes. A viewer shows it, a recording keeps it.

        Both grids are read as `grid[x][y]`. `weights` has any number you like for each cell, such
        as its distance to the goal: whole and not negative; what is greater than 255 is sent as
        255. `walls` has the sum of the cell's `Known`.
        """
        if [len(column) for column in weights] != [len(column) for column in walls]:
            raise ValueError("expected weights and walls of the same cells")
        message = bytearray(b"S" + _pose_bytes(pose))
        for grid in (weights, walls):
            message += b"F"  # column by column from the west
            message += bytes(min(cell, 255) for column in grid for cell in column)
        self._expect(b"ok", bytes(message))

    def close(self) -> None:
        """Ends the connection."""
        self._context.destroy(linger=0)

    def __enter__(self) -> Simulator:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def _connect(self) -> None:
        self._socket = self._context.socket(zmq.REQ)
        self._socket.linger = 0
        try:
            self._socket.connect(self._endpoint)
        except zmq.ZMQError as error:
            self.close()
            raise SimulatorError(
                f"cannot reach {self._endpoint}, expected tcp://HOST:PORT: {error}"
            ) from error

    def _expect(self, expected: bytes, request: bytes) -> None:
        reply = self._ask(request)
        if reply != expected:
            raise SimulatorError(f"expected {expected!r}, found {reply!r}")

    def _ask(self, request: bytes) -> bytes:
        self._socket.send(request)
        if not self._socket.poll(round(1000 * self._timeout)):
            # This socket would wait on for the reply that did not come.
            self._socket.close()
            self._connect()
            raise NoReply(
                f"no reply from {self._endpoint} within {self._timeout:g} s;"
                " `mmsim` starts a simulator"
            )
        reply = self._socket.recv()
        if reply.startswith(b"error: "):
            raise Refused("the simulator refuses that: " + reply[7:].decode(errors="replace"))
        return reply


def _pose_bytes(pose: Pose) -> bytes:
    return bytes([pose.x, pose.y]) + pose.heading.value.encode()
