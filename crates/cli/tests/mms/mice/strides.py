# Moves several cells at once, then looks far to both sides. It is put back at the start now and then.
for stride in range(160):
    ask('moveForward %d' % (1 + stride % 7))
    right, left = ask('wallRight 5') == 'true', ask('wallLeft 3') == 'true'
    if right and left:
        ask('turnRight' if ask('wallRight') == 'false' else 'turnLeft')
    else:
        ask('turnLeft' if right else 'turnRight')
    if stride % 80 == 79:
        ask('ackReset')
