"""Measures environment steps a second: one environment and many in one call, beside plain NumPy.

    python env_steps.py [NUM_ENVS]

All variants take random actions in the same mazes, in rounds that alternate between the variants. The
observations and rewards of all first episodes are compared before anything is measured.
"""

from __future__ import annotations

import statistics
import sys
import time
from pathlib import Path
from typing import Any, Callable

import numpy as np
from numpy.typing import NDArray

import micromouse_sim as mm
from micromouse_sim.gym import SearchEnv, SearchVectorEnv

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests"))
from numpy_search import NumpySearch, from_mazes  # noqa: E402

ROUNDS, MAX_STEPS = 7, 200


def check(envs: SearchVectorEnv, peer: NumpySearch) -> None:
    """Compares both during the first episode of each environment."""
    rng, running = np.random.default_rng(0), np.ones(envs.num_envs, np.bool_)
    observation, expected = envs.reset(seed=0)[0], peer.reset()
    while running.any():
        for key, array in expected.items():
            assert np.array_equal(observation[key][running], array[running]), key
        actions = rng.integers(4, size=envs.num_envs)
        observation, *results, _ = envs.step(actions)
        expected, *others = peer.step(actions)
        for result, other in zip(results, others):
            assert np.array_equal(result[running], other[running])
        running &= ~(results[1] | results[2])


def rate(step: Callable[[NDArray[Any]], object], actions: NDArray[Any]) -> float:
    """Returns the number of environment steps a second."""
    start = time.perf_counter()
    for action in actions:
        step(action)
    return actions.size / (time.perf_counter() - start)


def main() -> None:
    num_envs = int(sys.argv[1]) if len(sys.argv) > 1 else 256
    pool = [mm.Maze.generate(seed=seed) for seed in range(num_envs)]
    envs = SearchVectorEnv(num_envs, pool, max_steps=MAX_STEPS)
    envs.reset(seed=0)
    mazes = [envs.maze(index) for index in range(num_envs)]
    peer = NumpySearch(*from_mazes(mazes), MAX_STEPS)
    check(envs, peer)

    env = SearchEnv(pool, max_steps=MAX_STEPS)
    env.reset(seed=0)
    one_peer = NumpySearch(*from_mazes(mazes[:1]), MAX_STEPS)

    def step_one(action: Any) -> None:
        _, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            env.reset()

    rng = np.random.default_rng(1)
    many = rng.integers(4, size=(200, num_envs))
    one = rng.integers(4, size=(2000, 1))
    variants: dict[str, tuple[Callable[[NDArray[Any]], object], NDArray[Any]]] = {
        "one": (step_one, one.ravel()),
        "one, plain NumPy": (one_peer.step, one),
        f"{num_envs} in one call": (envs.step, many),
        f"{num_envs} in one call, plain NumPy": (peer.step, many),
    }
    rates: dict[str, list[float]] = {name: [] for name in variants}
    for _ in range(ROUNDS):
        for name, (step, actions) in variants.items():
            rates[name].append(rate(step, actions))
    print(f"environment steps a second, median of {ROUNDS} rounds")
    for name, values in rates.items():
        print(f"{name:36} {statistics.median(values):>12,.0f}")


if __name__ == "__main__":
    main()
