"""A mouse for the simulator mms that follows the left wall to the centre. It needs no library."""


def ask(command: str) -> str:
    print(command, flush=True)
    return input()


width, height = int(ask("mazeWidth")), int(ask("mazeHeight"))
goals = {((width - i) // 2, (height - j) // 2) for i in (0, 1) for j in (0, 1)}
x, y, heading = 0, 0, 0  # heading 0 to 3: north, east, south, west
while (x, y) not in goals:
    if ask("wallLeft") == "false":
        ask("turnLeft")
        heading = (heading + 3) % 4
    while ask("wallFront") == "true":
        ask("turnRight")
        heading = (heading + 1) % 4
    ask("moveForward")
    x, y = x + (0, 1, 0, -1)[heading], y + (1, 0, -1, 0)[heading]
