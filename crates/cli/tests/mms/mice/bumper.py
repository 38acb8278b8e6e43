# Never asks for a wall: it moves on, and turns where it bumps into one.
state = 1
for step in range(300):
    state = (state * 1103515245 + 12345) % 2147483648
    if ask('moveForward') == 'crash' or state // 65536 % 5 == 0:
        ask('turnRight' if state // 65536 % 3 else 'turnLeft')
