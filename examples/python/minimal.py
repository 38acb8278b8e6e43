import zmq

socket = zmq.Context().socket(zmq.REQ)
socket.connect("tcp://127.0.0.1:6574")

def ask(request):
    socket.send(request)
    return socket.recv()

ask(b"reset")
x, y, heading, walls, goal = 0, 0, 0, bytearray(256), False  # heading 0 to 3: N, E, S, W
while not goal:
    pose = bytes([x, y, b"NESW"[heading]])
    left, front, right = ask(b"W" + pose)
    walls[16 * x + y] = 1  # visited; add 2, 4, 8, 16 for a wall east, south, west, north
    ask(b"S" + pose + b"F" + bytes(256) + b"F" + walls)
    heading = (heading + (3 if not left else 0 if not front else 1 if not right else 2)) % 4
    goal = x in (7, 8) and y in (7, 8)
    x, y = x + (0, 1, 0, -1)[heading], y + (1, 0, -1, 0)[heading]
