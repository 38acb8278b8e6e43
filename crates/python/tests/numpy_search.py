"""The environment `mmsim/Search-v0` in plain NumPy, for many mice at once, without the proof.

It serves as an independent implementation for tests, and as a peer for the benchmark.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import micromouse_sim as mm

Observation = dict[str, NDArray[Any]]

EAST = np.array([0, 1, 0, -1])
NORTH = np.array([1, 0, -1, 0])
FRONT, RIGHT, BACK, LEFT = 0, 1, 2, 3
VISITED = 1
# Of walls and openings to the north, east, south and west.
FLAGS = np.array([16, 2, 4, 8], np.uint8)


class NumpySearch:
    """Searches of one maze each, which begin again in the same maze.

    `sides[i, x, y, side]` is true if the maze i has a wall on this side (north, east, south, west) of
    the cell (x, y), and `goals[i, x, y]` if the cell is a goal cell.
    """

    def __init__(self, sides: NDArray[np.bool_], goals: NDArray[np.bool_], max_steps: int) -> None:
        self.sides, self.goals, self.max_steps = sides, goals, max_steps
        self.count, self.width, self.height, _ = sides.shape
        self.every = np.arange(self.count)
        self.x, self.y, self.heading, self.steps = np.zeros((4, self.count), np.int64)
        self.walls = np.zeros(goals.shape, np.uint8)
        self.openings = np.zeros(goals.shape, np.uint8)
        self.over = np.zeros(self.count, np.bool_)
        self.reset()

    def reset(self) -> Observation:
        """Begins all searches again."""
        self._begin(self.every)
        return self._observation()

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[Observation, NDArray[Any], NDArray[Any], NDArray[Any]]:
        """Takes one action in each search, or begins those again that were over."""
        over = self.every[self.over]
        acting = self.every[~self.over]
        rewards = np.where(self.over, 0.0, -1.0)
        self.steps[acting] += 1
        self.heading[acting] = (self.heading[acting] + actions[acting]) % 4
        x, y, heading = self.x[acting], self.y[acting], self.heading[acting]
        moving = ~self.sides[acting, x, y, heading]
        self.x[acting] += EAST[heading] * moving
        self.y[acting] += NORTH[heading] * moving
        self._see(acting[moving], (LEFT, FRONT, RIGHT))
        terminated = self.goals[self.every, self.x, self.y] & ~self.over
        rewards[terminated] += self.width * self.height
        truncated = ~terminated & ~self.over & (self.steps >= self.max_steps)
        self.over = terminated | truncated
        if over.size:
            self._begin(over)
        return self._observation(), rewards, terminated, truncated

    def _begin(self, which: NDArray[Any]) -> None:
        for array in (self.x, self.y, self.heading, self.steps):
            array[which] = 0
        self.walls[which] = 0
        self.openings[which] = 0
        self.walls[which, :, -1] |= FLAGS[0]
        self.walls[which, -1, :] |= FLAGS[1]
        self.walls[which, :, 0] |= FLAGS[2]
        self.walls[which, 0, :] |= FLAGS[3]
        self.over[which] = False
        self._see(which, (LEFT, FRONT, RIGHT, BACK))

    def _see(self, which: NDArray[Any], turns: tuple[int, ...]) -> None:
        x, y = self.x[which], self.y[which]
        self.walls[which, x, y] |= VISITED
        for turn in turns:
            side = (self.heading[which] + turn) % 4
            beyond_x, beyond_y = x + EAST[side], y + NORTH[side]
            inside = (beyond_x >= 0) & (beyond_x < self.width)
            inside &= (beyond_y >= 0) & (beyond_y < self.height)
            is_wall = self.sides[which, x, y, side]
            for flags, seen in ((self.walls, is_wall), (self.openings, ~is_wall)):
                flags[which[seen], x[seen], y[seen]] |= FLAGS[side[seen]]
                both = seen & inside
                opposite = FLAGS[(side[both] + 2) % 4]
                flags[which[both], beyond_x[both], beyond_y[both]] |= opposite

    def _observation(self) -> Observation:
        return {
            "walls": self.walls.copy(),
            "openings": self.openings.copy(),
            "goals": self.goals.astype(np.uint8),
            "pose": np.stack([self.x, self.y, self.heading], axis=1),
        }


def from_mazes(mazes: list[mm.Maze]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Returns the sides and goals of mazes of the same size, as `NumpySearch` takes them."""
    size = (mazes[0].width, mazes[0].height)
    sides = np.zeros((len(mazes), *size, 4), np.bool_)
    goals = np.zeros((len(mazes), *size), np.bool_)
    for index, maze in enumerate(mazes):
        for side, flag in enumerate(FLAGS):
            sides[index, :, :, side] = maze.walls & flag != 0
        for cell in maze.goals:
            goals[index][cell] = True
    return sides, goals
