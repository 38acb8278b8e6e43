# A mouse for mms that searches for the centre by flood fill, and displays its distances and its path.
import sys

def ask(command):
    print(command, flush=True)
    return sys.stdin.readline().strip()

def say(command):
    print(command, flush=True)

def log(text):
    print(text, file=sys.stderr, flush=True)

STEPS = [(0, 1), (1, 0), (0, -1), (-1, 0)]
WALLS = [(0, 'wallFront'), (1, 'wallRight'), (3, 'wallLeft')]
width, height = int(ask('mazeWidth')), int(ask('mazeHeight'))
centre = [(x, y) for x in ((width - 1) // 2, width // 2) for y in ((height - 1) // 2, height // 2)]
cells = [(x, y) for x in range(width) for y in range(height)]
walls, shown, visited = set(), {}, set()
(x, y), heading = (0, 0), 0

def beyond(cell, side):
    return cell[0] + STEPS[side][0], cell[1] + STEPS[side][1]

def flood():
    distances, queue = {cell: 0 for cell in centre}, list(centre)
    for cell in queue:
        for side in range(4):
            other = beyond(cell, side)
            if other in cells and other not in distances and (cell, side) not in walls:
                distances[other] = distances[cell] + 1
                queue.append(other)
    return distances

say('setText 0 0 start')
say('setColor 0 0 G')
# The mouse looks around before its first flood.
for cell in cells[1:]:
    shown[cell] = 2000
    say('setText %d %d 2000' % cell)
ask('turnRight')
ask('turnLeft')
while (x, y) not in centre:
    for turn, question in WALLS:
        side = (heading + turn) % 4
        if ask(question) == 'true':
            walls.update([((x, y), side), (beyond((x, y), side), (side + 2) % 4)])
            say('setWall %d %d %s' % (x, y, 'nesw'[side]))
    distances = flood()
    for cell in cells[1:]:
        distance = distances.get(cell, 2000)
        if shown.get(cell) != distance:
            shown[cell] = distance
            say('setText %d %d %d' % (*cell, distance))
    visited.add((x, y))
    open_sides = [side for side in range(4) if ((x, y), side) not in walls]
    best = min(open_sides, key=lambda side: distances.get(beyond((x, y), side), 2000))
    for _ in range((best - heading) % 4):
        ask('turnRight')
    heading = best
    ask('moveForward')
    x, y = beyond((x, y), heading)
    say('setColor %d %d %s' % (x, y, 'y' if (x, y) in visited else 'g'))
    log('at %d %d, distance %d' % (x, y, distances[(x, y)]))
say('clearAllText')
say('setText %d %d goal' % (x, y))
ask('turnLeft')
