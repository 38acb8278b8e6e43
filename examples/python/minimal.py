import os
import zmq

socket = zmq.Context().socket(zmq.REQ)
socket.connect(os.environ.get("MMSIM_ENDPOINT", "tcp://127.0.0.1:6574"))

def ask(request, timeout=None):
    socket.send(request)
    assert socket.poll(timeout), "no reply within 5 s"
    reply = socket.recv()
    assert not reply.startswith(b"error: "), reply
    return reply

ask(b"reset", timeout=5000)  # later replies may take longer: the mouse can be paused
x, y, heading, walls, steps = 0, 0, 0, bytearray(256), 0  # heading 0 to 3: N, E, S, W
while True:
    pose = bytes([x, y, b"NESW"[heading]])
    left, front, right = ask(b"W" + pose)
    walls[16 * x + y] = 1  # visited; add 2, 4, 8, 16 for a wall east, south, west, north
    ask(b"S" + pose + b"F" + bytes(256) + b"F" + walls)
    if x in (7, 8) and y in (7, 8):
        break
    heading = (heading + (3 if not left else 0 if not front else 1 if not right else 2)) % 4
    x, y, steps = x + (0, 1, 0, -1)[heading], y + (1, 0, -1, 0)[heading], steps + 1
print(f"goal reached after {steps} steps")
