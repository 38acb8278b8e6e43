# Searches for the centre and returns, twice, by flood fill. It asks only for the wall ahead, when it is
# about to move. It displays its distances and its path, and it writes a log.
width, height = int(ask('mazeWidth')), int(ask('mazeHeight'))
goals = [(x, y) for x in range((width - 1) // 2, width // 2 + 1) for y in range((height - 1) // 2, height // 2 + 1)]
STEPS = [(0, 1), (1, 0), (0, -1), (-1, 0)]
walls, shown = set(), {}
(x, y), heading = (0, 0), 0

def distances(targets):
    found, queue = {target: 0 for target in targets}, list(targets)
    for cell in queue:
        for side, (east, north) in enumerate(STEPS):
            next = (cell[0] + east, cell[1] + north)
            inside = 0 <= next[0] < width and 0 <= next[1] < height
            if inside and next not in found and (cell, side) not in walls:
                found[next] = found[cell] + 1
                queue.append(next)
    return found

def neighbour(side):
    return x + STEPS[side][0], y + STEPS[side][1]

def face(side):
    global heading
    turn = (side - heading) % 4
    for _ in range(2 if turn == 2 else turn % 2):
        ask('turnLeft' if turn == 3 else 'turnRight')
    heading = side

def is_open_ahead():
    if ask('wallFront') == 'false':
        return True
    walls.update([((x, y), heading), (neighbour(heading), (heading + 2) % 4)])
    say('setWall %d %d %s' % (x, y, 'nesw'[heading]))
    return False

for run, targets in enumerate([goals, [(0, 0)], goals, [(0, 0)]]):
    print('run %d to %s' % (run, targets[0]), file=sys.stderr, flush=True)
    say('clearAllColor')
    while (x, y) not in targets:
        distance = distances(targets)
        for cell, steps in distance.items():
            if shown.get(cell) != steps:
                shown[cell] = steps
                say('setText %d %d %d' % (*cell, steps))
        sides = [side for side in range(4) if ((x, y), side) not in walls and neighbour(side) in distance]
        face(min(sides, key=lambda side: (distance[neighbour(side)], side != heading)))
        if is_open_ahead():
            ask('moveForward')
            x, y = neighbour(heading)
            say('setColor %d %d %s' % (x, y, 'gbyr'[run]))
