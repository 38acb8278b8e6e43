"""Follows the left wall to the goal.

The mice in this folder import it, as mice for mms import the module API.py of its template. It runs in
Python 2.7 and 3.
"""
import sys

STEPS = [(0, 1), (1, 0), (0, -1), (-1, 0)]  # north, east, south, west


def ask(line, end="\n"):
    sys.stdout.write(line + end)
    sys.stdout.flush()
    return sys.stdin.readline().strip()


def follow(goals=None, end="\n"):
    width, height = int(ask("mazeWidth", end)), int(ask("mazeHeight", end))
    cell, heading = (0, 0), 0
    while cell not in (goals or [(width // 2, height // 2)]):
        if ask("wallLeft", end) == "false":
            ask("turnLeft", end)
            heading = (heading + 3) % 4
        while ask("wallFront", end) == "true":
            ask("turnRight", end)
            heading = (heading + 1) % 4
        ask("moveForward", end)
        cell = (cell[0] + STEPS[heading][0], cell[1] + STEPS[heading][1])
