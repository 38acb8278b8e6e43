"""A client that reports poses and ends in a given way: client.py POSES ENDING.

POSES are separated by spaces, such as `00N 01N`. Among them, `reset` resets the simulation, and
`restart` reports that the mouse was put back. A pose that a wall blocks is skipped. With `+E`, the mouse
believes in a wall on the east side of its cell. Other words are requests. It needs no ZeroMQ library.
"""
import json
import os
import signal
import socket
import sys
import time

poses, ending = sys.argv[1:]
host, port = os.environ["MMSIM_ENDPOINT"].removeprefix("tcp://").split(":")
peer = socket.create_connection((host, int(port)))


def frame(flags: int, body: bytes) -> bytes:
    return bytes([flags, len(body)]) + body


def read(count: int) -> bytes:
    data = b""
    while len(data) < count:
        data += peer.recv(count - len(data)) or sys.exit("the simulator has closed the connection")
    return data


def read_frame() -> tuple[int, bytes]:
    [flags] = read(1)
    [length] = read(1)
    return flags, read(length)


def ask(request: bytes) -> bytes:
    peer.sendall(frame(1, b"") + frame(0, request))
    read_frame()
    return read_frame()[1]


peer.sendall(b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(48))
read(64)
peer.sendall(frame(4, b"\x05READY\x0bSocket-Type\x00\x00\x00\x03REQ"))
read_frame()
info = json.loads(ask(b"info"))
cells = info["width"] * info["height"]
ask(b"reset")
for pose in poses.split():
    if pose in ("reset", "restart"):
        ask(b"reset" if pose == "reset" else b"AR")
        continue
    if not pose[0].isdigit():
        ask(pose.encode())
        continue
    x, y, heading = int(pose[0]), int(pose[1]), pose[2].encode()
    if ask(b"W" + bytes([x, y]) + heading).startswith(b"error: crash: "):
        continue
    walls = bytearray(cells)
    # In the order C, the cells of a row follow each other. The bit of an eastern wall is 2.
    walls[y * info["width"] + x] = 2 if pose.endswith("+E") else 0
    ask(b"S" + bytes([x, y]) + heading + b"C" + bytes(cells) + b"C" + walls)
if ending in ("hangs", "waits-for-a-refused-reply"):
    time.sleep(1000)
if ending == "crashes":
    sys.exit("a bad day")
if ending == "killed":
    os.kill(os.getpid(), signal.SIGKILL)
