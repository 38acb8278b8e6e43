"""A robot for `mmsim trial MAZE -- python3 trial_robot.py`: goes where it has been least often, then
races along the last direction in which it left each cell."""
import sys
from collections import Counter

STEPS = [(0, 1), (1, 0), (0, -1), (-1, 0)]  # north, east, south, west
words = sys.stdin.readline().split()  # maze 12 12 start 0 0 N goals 5 5 6 5 5 6 6 6
goals = set(zip(map(int, words[8::2]), map(int, words[9::2])))
start = (int(words[4]), int(words[5]))
cell, heading, racing, visits, exits = start, 0, False, Counter([start]), {start: 0}
for line in sys.stdin:
    choices = []
    for turn, seen in zip((-1, 0, 1), map(int, line.split())):
        to = (heading + turn) % 4
        beyond = (cell[0] + STEPS[to][0], cell[1] + STEPS[to][1])
        if seen > 0 and (not racing or exits[cell] == to):
            choices.append((visits[beyond], abs(turn), turn, beyond))
    if cell in goals and not racing:
        cell, heading, racing, answer = start, 0, True, "reset"
    elif choices:
        turn, beyond = min(choices)[2:]
        heading = (heading + turn) % 4
        exits[cell], cell, answer = heading, beyond, f"{90 * turn} 1"
        visits[cell] += 1
    else:  # a dead end
        heading, answer = (heading + 1) % 4, "90 0"
    print(answer, flush=True)
