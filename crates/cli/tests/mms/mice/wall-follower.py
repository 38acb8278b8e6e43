# Follows the left wall. It asks only for the wall to its left, after it has entered a cell.
for step in range(250):
    if ask('wallLeft') == 'false':
        ask('turnLeft')
        ask('moveForward')
    else:
        while ask('moveForward') == 'crash':
            ask('turnRight')
