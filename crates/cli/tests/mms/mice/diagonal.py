# Moves in half steps and diagonals, and asks for walls and posts in all eight directions afterwards.
SIDES = ['Front', 'FrontRight', 'Right', 'BackRight', 'Back', 'BackLeft', 'Left', 'FrontLeft']
TURNS = ['turnRight45', 'turnLeft45', 'turnRight', 'turnLeft90', 'turnRight45', 'turnRight90']
state = 1
for step in range(200):
    state = (state * 1103515245 + 12345) % 2147483648
    number = state // 65536
    while ask('moveForwardHalf %d' % (1 + number % 4)) == 'crash' and number % 11:
        number //= 2
        ask(TURNS[number % len(TURNS)])
    if step % 4 == 0:
        ask('wall%s %d' % (SIDES[number % len(SIDES)], 1 + number % 5))
