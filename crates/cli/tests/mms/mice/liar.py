# Declares walls that it has not seen: all sides of each cell that it enters, and no walls anywhere else.
x, y, heading = 0, 0, 0
width, height = int(ask('mazeWidth')), int(ask('mazeHeight'))
for cell in range(width * height):
    for side in 'nesw':
        say('clearWall %d %d %s' % (cell % width, cell // width, side))
state = 1
for step in range(300):
    state = (state * 1103515245 + 12345) % 2147483648
    if ask('moveForward') == 'crash' or state // 65536 % 4 == 0:
        turn = 1 if state // 65536 % 3 else 3
        heading = (heading + turn) % 4
        ask('turnRight' if turn == 1 else 'turnLeft')
        continue
    x, y = x + [0, 1, 0, -1][heading], y + [1, 0, -1, 0][heading]
    for side in 'nesw':
        say('setWall %d %d %s' % (x, y, side))
    if step % 2 and ask('wallFront') == 'false':
        say('clearWall %d %d %s' % (x, y, 'nesw'[heading]))
