"""Tests whether a server follows the protocol: sends each request and checks the reply.

Start a server with `mmsim`, then run this program, optionally with an endpoint such as
tcp://127.0.0.1:6574. It sends only requests that the reference server answers, too. One of them is
`reset`, which deletes the states that the server has stored.
"""
from __future__ import annotations

import os
import sys
from itertools import cycle, product

import zmq

WIDTH, HEIGHT = 16, 16
TIMEOUT = 5.0  # seconds
HEADINGS = b"NESW"
LEFT, FRONT, RIGHT = -1, 0, 1  # quarter turns to the right
STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0))  # x and y of a step in each heading


class Tester:
    """A connection to a server, and the results of the checks."""

    def __init__(self, endpoint: str) -> None:
        self.context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self.socket = self.context.socket(zmq.REQ)
        self.socket.linger = 0
        self.socket.connect(endpoint)
        self.checks = 0
        self.faults = 0
        # The walls that were read, by their position: whether there is a wall, and in which reply.
        self.walls: dict[tuple[float, float], tuple[int, str]] = {}

    def ask(self, name: str, request: bytes) -> list[bytes]:
        """Sends a request and returns the frames of the reply."""
        self.socket.send(request)
        if not self.socket.poll(round(1000 * TIMEOUT)):
            self.report(name, f"no reply within {TIMEOUT:g} s")
            sys.exit("stopped, because the server does not reply (start one with `mmsim`)")
        return self.socket.recv_multipart()

    def report(self, name: str, fault: str | None, reply: str = "") -> None:
        """Counts and prints a check."""
        self.checks += 1
        self.faults += fault is not None
        print(f"ok     {name}: {reply}" if fault is None else f"wrong  {name}: {fault}")

    def expect(self, name: str, request: bytes, expected: bytes) -> None:
        """Sends a request that has only one right reply."""
        reply = self.ask(name, request)
        fault = None if reply == [expected] else f"expected {[expected]}, found {reply}"
        self.report(name, fault, str(reply[0]))

    def read_walls(self, x: int, y: int, heading: int) -> None:
        """Sends `W` and compares the walls with those of earlier replies."""
        letter = HEADINGS[heading : heading + 1]
        name = f"W at ({x}, {y}) heading {letter.decode()}"
        reply = self.ask(name, b"W" + bytes([x, y]) + letter)
        if len(reply) != 1 or len(reply[0]) != 3 or max(reply[0]) > 1:
            self.report(name, f"expected 3 bytes, each 0 or 1, found {reply}")
            return
        sides = zip((LEFT, FRONT, RIGHT), reply[0])
        faults = [self.contradiction(name, x, y, heading + turn, wall) for turn, wall in sides]
        self.report(name, next(filter(None, faults), None), str(list(reply[0])))

    def contradiction(self, name: str, x: int, y: int, heading: int, wall: int) -> str | None:
        """Returns how a wall contradicts the outer walls or an earlier reply, or None."""
        dx, dy = STEPS[heading % 4]
        if x + dx not in range(WIDTH) or y + dy not in range(HEIGHT):
            expected, reason = 1, "for the outer wall"
        else:
            middle = (x + dx / 2, y + dy / 2)
            expected, reason = self.walls.setdefault(middle, (wall, f"as in the reply to {name}"))
        if wall == expected:
            return None
        side = ("north", "east", "south", "west")[heading % 4]
        return f"expected {expected} {reason} on the {side} side, found {wall}"


def cells() -> list[tuple[int, int]]:
    """Returns the cells in the corners and in the centre, and neighbours of some of them."""
    middle = [(WIDTH // 2 + dx, HEIGHT // 2 + dy) for dx, dy in product((-1, 0), (-1, 0))]
    corners = [(x, y) for x, y in product((0, 1, WIDTH - 1), (0, 1, HEIGHT - 1))]
    inside = [(x, y) for x, y in middle + corners if x in range(WIDTH) and y in range(HEIGHT)]
    return sorted(set(inside))


def main(endpoint: str) -> int:
    """Tests a server and returns the exit code: 0 if all replies are right, and otherwise 1."""
    tester = Tester(endpoint)
    tester.expect("ping", b"ping", b"pong")
    tester.expect("reset", b"reset", b"ok")
    for (x, y), heading in product(cells(), range(4)):
        tester.read_walls(x, y, heading)
    area = WIDTH * HEIGHT
    ramp = bytes(index % 256 for index in range(area))
    poses = zip(cycle(cells()), cycle("NESW"))
    for weights, first, second in product((bytes(area), ramp, b"\xff" * area), "CF", "CF"):
        (x, y), letter = next(poses)
        name = f"S at ({x}, {y}) heading {letter}, orders {first} and {second}"
        walls = bytes(weight % 32 for weight in weights)
        pose = bytes([x, y]) + letter.encode()
        tester.expect(name, b"S" + pose + first.encode() + weights + second.encode() + walls, b"ok")
    tester.expect("reset", b"reset", b"ok")
    print(f"{tester.checks} checks, {tester.faults} wrong")
    tester.context.destroy(linger=0)
    return 1 if tester.faults else 0


if __name__ == "__main__":
    default = os.environ.get("MMSIM_ENDPOINT") or "tcp://127.0.0.1:6574"
    try:
        sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else default))
    except zmq.ZMQError as error:
        sys.exit(f"cannot reach the server: {error} (expected tcp://HOST:PORT)")
    except KeyboardInterrupt:
        sys.exit("interrupted")
