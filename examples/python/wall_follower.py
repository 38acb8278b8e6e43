"""A whole mouse: follows the wall at its left hand through a 16x16 maze."""
import sys
import zmq

socket = zmq.Context().socket(zmq.REQ)
socket.connect(sys.argv[1] if len(sys.argv) > 1 else "tcp://127.0.0.1:6574")

def ask(request):
    socket.send(request)
    reply = socket.recv()
    if reply.startswith(b"error: "):
        sys.exit(reply.decode())
    return reply

ask(b"reset")
x, y, heading = 0, 0, 0  # headings 0 to 3: north, east, south, west
weights, walls = bytearray(256), bytearray(256)  # order F: cell (x, y) at x * 16 + y
for steps in range(1001):  # from 0 to 1000
    pose = bytes([x, y, b"NESW"[heading]])
    left, front, right = ask(b"W" + pose)
    weights[x * 16 + y] = min(weights[x * 16 + y] + 1, 255)  # how often it has been here
    walls[x * 16 + y] = 1  # visited; add 2, 4, 8, 16 for a wall east, south, west, north
    ask(b"S" + pose + b"F" + weights + b"F" + walls)
    if x in (7, 8) and y in (7, 8):
        print(f"goal reached after {steps} steps")
        sys.exit()
    turn = 3 if not left else 0 if not front else 1 if not right else 2
    heading = (heading + turn) % 4
    x, y = x + (0, 1, 0, -1)[heading], y + (1, 0, -1, 0)[heading]
sys.exit("goal not reached after 1000 steps")
