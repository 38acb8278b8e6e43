"""Trains a small agent to search unknown mazes, and compares it with flood fill.

    pip install "crates/python[gymnasium]"
    python train_agent.py

The agent is a table: for each of the four directions it sees whether there is a wall, how often it has
been in the cell beyond (0, 1, 2, 3, 4 or more times), and whether that cell is nearer to the goal in
Manhattan distance. SARSA fills the table with the value of each action. The table has no map, so the agent cannot
plan: it learns to avoid cells that it knows and to head for the goal. Flood fill plans on its map, and
needs far fewer steps.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

import micromouse_sim as mm
import micromouse_sim.gym

EAST, NORTH = np.array([0, 1, 0, -1]), np.array([1, 0, -1, 0])
CODES = 11  # a wall, or one of 5 numbers of visits with the goal nearer or not
DISCOUNT = 0.98
MAX_STEPS = 1000


class Senses:
    """Counts the visits of each mouse and describes its surroundings as one number."""

    def __init__(self, observation: dict[str, NDArray[Any]]) -> None:
        self.every = np.arange(len(observation["pose"]))
        count, width, height = observation["walls"].shape
        # A margin around the maze, so that every cell has four neighbours.
        self.visits = np.zeros((count, width + 2, height + 2), np.int32)
        self.centre = np.array([(width - 1) / 2, (height - 1) / 2])

    def state(self, observation: dict[str, NDArray[Any]], mask: NDArray[Any]) -> NDArray[Any]:
        """Returns the row of the table for each mouse."""
        x, y, heading = observation["pose"].T
        self.visits[self.every, x + 1, y + 1] += 1
        here = np.abs(x - self.centre[0]) + np.abs(y - self.centre[1])
        rows = np.zeros(len(x), np.int64)
        for action in range(4):
            side = (heading + action) % 4
            next_x, next_y = x + EAST[side], y + NORTH[side]
            visits = np.minimum(self.visits[self.every, next_x + 1, next_y + 1], 4)
            there = np.abs(next_x - self.centre[0]) + np.abs(next_y - self.centre[1])
            code = np.where(mask[:, action] == 1, 1 + 2 * visits + (there < here), 0)
            rows = rows * CODES + code
        return rows

    def forget(self, which: NDArray[np.bool_]) -> None:
        """Clears the visits of mice that begin a new episode."""
        self.visits[which] = 0


def choose(
    table: NDArray[Any], rows: NDArray[Any], mask: NDArray[Any], greed: float, rng: np.random.Generator
) -> NDArray[Any]:
    """Returns the best action without a wall, or with the probability 1 - greed a random one."""
    is_random = rng.random(len(rows)) >= greed
    values = np.where(is_random[:, None], rng.random(mask.shape), table[rows])
    actions: NDArray[Any] = np.where(mask == 1, values, -np.inf).argmax(axis=1)
    return actions


def train(steps: int, num_envs: int, seed: int) -> NDArray[Any]:
    """Returns the table after `steps` actions of all mice together."""
    rng = np.random.default_rng(seed)
    envs = gymnasium.make_vec("mmsim/Search-v0", num_envs=num_envs, max_steps=MAX_STEPS)
    table = np.zeros((CODES**4, 4))
    observation, info = envs.reset(seed=seed)
    senses = Senses(observation)
    rows = senses.state(observation, info["action_mask"])
    actions = choose(table, rows, info["action_mask"], 0.0, rng)
    rounds = steps // num_envs
    begins = np.zeros(num_envs, np.bool_)
    for number in range(rounds):
        progress = number / rounds
        observation, rewards, terminated, truncated, info = envs.step(actions)
        senses.forget(begins)
        next_rows = senses.state(observation, info["action_mask"])
        next_actions = choose(table, next_rows, info["action_mask"], min(0.98, 0.5 + progress), rng)
        later = np.where(terminated, 0.0, table[next_rows, next_actions])
        errors = rewards + DISCOUNT * later - table[rows, actions]
        # Many mice may be in the same situation: the table moves by the mean of their errors.
        cells = (rows * 4 + actions)[~begins]
        total = np.bincount(cells, errors[~begins], table.size)
        count = np.bincount(cells, minlength=table.size)
        rate = 0.1 * (1 - progress) + 0.005
        table += (rate * total / np.maximum(count, 1)).reshape(table.shape)
        begins = terminated | truncated
        rows, actions = next_rows, next_actions
    envs.close()
    return table


def evaluate(table: NDArray[Any], mazes: list[mm.Maze], greed: float) -> list[int | None]:
    """Returns the steps to the goal in each maze, or None where the goal was not reached."""
    rng = np.random.default_rng(1)
    results: list[int | None] = []
    for maze in mazes:
        envs = micromouse_sim.gym.SearchVectorEnv(1, maze, max_steps=MAX_STEPS)
        observation, info = envs.reset(seed=0)
        senses = Senses(observation)
        for steps in range(1, MAX_STEPS + 1):
            rows = senses.state(observation, info["action_mask"])
            actions = choose(table, rows, info["action_mask"], greed, rng)
            observation, _, terminated, truncated, info = envs.step(actions)
            if terminated[0] or truncated[0]:
                break
        results.append(steps if terminated[0] else None)
    return results


def main() -> None:
    parser = argparse.ArgumentParser(description="Train a small agent to search mazes.")
    parser.add_argument("--steps", type=int, default=6_000_000, help="actions of all mice together")
    parser.add_argument("--envs", type=int, default=512, help="mice that learn at the same time")
    parser.add_argument("--mazes", type=int, default=200, help="new mazes for the comparison")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()

    start = time.perf_counter()
    table = train(options.steps, options.envs, options.seed)
    seconds = time.perf_counter() - start
    print(f"trained with {options.steps:,} steps in {seconds:.0f} s")

    mazes = [mm.Maze.generate(seed=1_000_000 + number) for number in range(options.mazes)]
    agent, random = evaluate(table, mazes, 1.0), evaluate(table, mazes, 0.0)
    flood_fill = [mm.search(maze, "flood-fill").steps for maze in mazes]
    print(f"{'':12} reached goal   mean steps   against flood fill in these mazes")
    for name, steps in (("flood fill", flood_fill), ("agent", agent), ("random", random)):
        solved = [(own, other) for own, other in zip(steps, flood_fill) if own is not None]
        reached = f"{len(solved) / len(mazes):>10.0%}"
        if solved:
            own, other = np.mean(solved, axis=0)
            print(f"{name:12} {reached}   {own:>10.1f}   x {own / other:.1f}")
        else:
            print(f"{name:12} {reached}")


if __name__ == "__main__":
    main()
