"""Tests of the Gymnasium environments against Gymnasium's checker and a version in plain NumPy."""

from __future__ import annotations

from collections import deque
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from conftest import LIMIT
from numpy.typing import NDArray
from numpy_search import FLAGS, NumpySearch, from_mazes

import micromouse_sim as mm
from micromouse_sim._native import SearchBatch

gymnasium = pytest.importorskip("gymnasium", reason="needs the extra gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

from micromouse_sim.gym import ENV_ID, SearchEnv, SearchVectorEnv  # noqa: E402


def assert_equal(found: dict[str, NDArray[Any]], expected: dict[str, NDArray[Any]]) -> None:
    assert found.keys() == expected.keys()
    for key, array in found.items():
        assert array.dtype == expected[key].dtype, key
        assert np.array_equal(array, expected[key]), key


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("until", ["goal", "proof"])
@pytest.mark.parametrize("size", [(16, 16), (9, 7)])
def test_the_checker_of_gymnasium_accepts_the_environment(
    until: str, size: tuple[int, int]
) -> None:
    env = gymnasium.make(ENV_ID, until=until, size=size, render_mode="ansi", max_steps=50)
    check_env(env.unwrapped)


@pytest.mark.parametrize("size", [(16, 16), (5, 8), (32, 32)])
def test_many_environments_agree_with_plain_numpy(size: tuple[int, int]) -> None:
    pool = [mm.Maze.generate(seed=7, size=size, style="open")]
    envs, steps = SearchVectorEnv(20, pool, max_steps=60), 400
    expected = NumpySearch(*from_mazes(pool * 20), 60)
    rng = np.random.default_rng(1)
    assert_equal(envs.reset(seed=3)[0], expected.reset())
    terminated, truncated = 0, 0
    for _ in range(steps):
        actions = rng.integers(4, size=20)
        found, *results, _ = envs.step(actions)
        observation, *others = expected.step(actions)
        assert_equal(found, observation)
        for result, other in zip(results, others):
            assert np.array_equal(result, other)
        terminated += int(results[1].sum())
        truncated += int(results[2].sum())
    assert truncated > 0
    assert terminated > 0 or size != (5, 8)


def test_many_environments_behave_like_single_ones() -> None:
    pool = [mm.Maze.generate(seed=seed, size=(6, 6), style="open") for seed in range(9)]
    envs = gymnasium.make_vec(ENV_ID, num_envs=4, mazes=pool, until="proof", max_steps=80)
    singles = [gymnasium.make(ENV_ID, mazes=pool, until="proof", max_steps=80) for _ in range(4)]
    observation, infos = envs.reset(seed=11)
    over = [False] * 4
    for index, env in enumerate(singles):
        single, info = env.reset(seed=11 + index)
        assert_equal(single, {key: array[index] for key, array in observation.items()})
        assert np.array_equal(info["action_mask"], infos["action_mask"][index])
    rng, episodes = np.random.default_rng(5), 0
    for _ in range(600):
        actions = np.array([rng.choice(np.flatnonzero(mask)) for mask in infos["action_mask"]])
        observation, rewards, terminated, truncated, infos = envs.step(actions)
        for index, env in enumerate(singles):
            if over[index]:
                single, info = env.reset()
                result: tuple[Any, ...] = (0.0, False, False)
                episodes += 1
            else:
                single, *rest, info = env.step(actions[index])
                result = tuple(rest)
            assert_equal(single, {key: array[index] for key, array in observation.items()})
            assert result == (rewards[index], terminated[index], truncated[index])
            assert info["goal_reached"] == infos["goal_reached"][index]
            over[index] = bool(terminated[index] or truncated[index])
    assert episodes > 10


def shortest_known(env: SearchEnv, closed: bool) -> float:
    """Returns the distance from the start to the goal, with unknown walls closed or open."""
    observation = env._observation()
    best = {(0, 0): 0}
    cells = deque(best)
    while cells:
        x, y = cell = cells.popleft()
        if observation["goals"][cell]:
            return best[cell]
        for flag, (east, north) in zip(FLAGS, ((0, 1), (1, 0), (0, -1), (-1, 0))):
            open_side = observation["openings"][cell] & flag
            if open_side if closed else not observation["walls"][cell] & flag:
                beyond = (x + east, y + north)
                if beyond not in best:
                    best[beyond] = best[cell] + 1
                    cells.append(beyond)
    return float("inf")


def test_an_episode_until_the_proof_ends_when_both_distances_are_equal() -> None:
    env = SearchEnv(until="proof", size=(6, 6), max_steps=2000)
    rng, area, proofs = np.random.default_rng(2), 36, 0
    for seed in range(12):
        _, info = env.reset(seed=seed)
        total, terminated, steps, was_reached = 0.0, False, 0, False
        while not terminated:
            action = rng.choice(np.flatnonzero(info["action_mask"]))
            _, reward, terminated, truncated, info = env.step(action)
            assert not truncated
            is_proven = shortest_known(env, closed=True) == shortest_known(env, closed=False)
            assert terminated == (is_proven and info["goal_reached"])
            arrives = info["goal_reached"] and not was_reached
            assert reward == -1 + area * arrives + area * terminated
            was_reached = info["goal_reached"]
            total, steps = total + reward, steps + 1
        assert total == 2 * area - steps
        proofs += 1
    assert proofs == 12


def test_a_wall_stops_the_mouse_but_not_its_turn() -> None:
    maze = mm.Maze.parse("o---o---o\n|     G |\no   o---o\n| S |   |\no---o---o\n")
    env = SearchEnv(maze)
    observation, info = env.reset()
    assert list(info["action_mask"]) == [1, 0, 0, 0]
    observation, reward, *_ = env.step(1)
    assert list(observation["pose"]) == [0, 0, 1] and reward == -1
    observation, reward, *_ = env.step(3)
    assert list(observation["pose"]) == [0, 1, 0] and reward == -1
    observation, reward, terminated, *_ = env.step(1)
    assert list(observation["pose"]) == [1, 1, 1] and reward == 3 and terminated
    assert observation["goals"].tolist() == [[0, 0], [0, 1]]
    assert observation["walls"][0, 0] == 1 + 2 + 4 + 8
    assert observation["openings"][0, 1] == 2 + 4
    assert str(env.maze) == str(maze)


def test_the_calls_of_threads_wait_for_each_other() -> None:
    count, threads, steps = 500, 4, 100
    batch = SearchBatch([mm.Maze.bundled("01")], (16, 16), "perfect", True, threads * steps + 1, count)
    batch.step(np.full(count, 2, np.int64))

    def drive(_: int) -> int:
        truncated = 0
        for _ in range(steps):
            # All mice stand in front of a wall.
            truncated += int(batch.step(np.zeros(count, np.int64))[2].sum())
            assert not batch.infos()[1].any()
            assert batch.observation(0)[3].tolist() == batch.observations()[3][-1].tolist() == [0, 0, 2]
            assert batch.info(0)[1] is False
            assert batch.maze(0).width == batch.known(0).width == batch.size[0] == 16
        return truncated

    with ThreadPoolExecutor(threads) as pool:
        assert sum(pool.map(drive, range(threads), timeout=LIMIT)) == count
        resets = pool.map(lambda index: batch.reset(index, None), range(count), timeout=LIMIT)
        assert list(resets) == [None] * count
        results = pool.map(lambda _: batch.step_one(2), range(threads * steps), timeout=LIMIT)
        assert not any(truncated for _, _, truncated in results)


def test_invalid_arguments_are_refused() -> None:
    small, large = mm.Maze.generate(size=(4, 4)), mm.Maze.generate(size=(5, 4))
    for error, arguments in [
        (ValueError, {"until": "never"}),
        (ValueError, {"mazes": []}),
        (ValueError, {"mazes": [small, large]}),
        (ValueError, {"size": (0, 4)}),
        (ValueError, {"style": "round"}),
        (ValueError, {"render_mode": "human"}),
        (TypeError, {"mazes": ["harbour"]}),
        (ValueError, {"max_steps": -1}),
        (ValueError, {"max_steps": 0}),
    ]:
        with pytest.raises(error):
            SearchEnv(**arguments)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="at least one environment"):
        SearchVectorEnv(0)
    with pytest.raises(ValueError, match="at most 65536 environments"):
        SearchVectorEnv(2**62)
    env, envs = SearchEnv(), SearchVectorEnv(3)
    for action in (4, -1):
        with pytest.raises(ValueError, match="from 0 to 3"):
            env.step(action)
    envs.reset()
    for actions in (np.zeros(2), np.array([0, 1, 4])):
        with pytest.raises(ValueError):
            envs.step(actions)
    with pytest.raises(TypeError):
        envs.step(np.zeros((3, 2)))
    with pytest.raises(ValueError, match="3 seeds"):
        envs.reset(seed=[1, 2])
    with pytest.raises(IndexError):
        envs.maze(3)
    assert "o---o" in str(SearchEnv(render_mode="ansi").render())
    assert env.render() is None
