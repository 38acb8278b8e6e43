"""The Gymnasium environment `mmsim/Search-v0`: a mouse that searches an unknown maze.

    import gymnasium
    import micromouse_sim.gym

    env = gymnasium.make("mmsim/Search-v0")
    envs = gymnasium.make_vec("mmsim/Search-v0", num_envs=256)

An action turns the mouse and moves it one cell: 0 straight on, 1 to the right, 2 back, 3 to the left.
If there is a wall, the mouse only turns. An observation is a dictionary of arrays:

- `walls`, shape (width, height), uint8: the flags of each cell, as in a state: 1 visited, 2 wall to the
  east, 4 south, 8 west, 16 north.
- `openings`, same shape: the sides that are known to be open, with the same flags. A side with neither
  flag is unknown.
- `goals`, same shape: 1 for each goal cell.
- `pose`, shape (3,), int64: x, y and the heading of the mouse (0 to 3: north, east, south, west).

The reward of each action is -1. Reaching the goal for the first time adds the number of cells of the
maze, and so does the proof that the best known path is the shortest one. An episode ends at the goal, or
with `until="proof"`, when the shortest path is proven and the mouse has been in the goal.

`info["action_mask"]` holds, for each action, 1 if there is no wall in that direction, else 0.
`info["goal_reached"]` says whether the mouse has been in the goal.
"""

from __future__ import annotations

from typing import Any, Iterable, Literal, Union

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from . import KnownMaze, Maze
from ._native import SearchBatch

__all__ = ["ENV_ID", "SearchEnv", "SearchVectorEnv"]

ENV_ID = "mmsim/Search-v0"

Observation = dict[str, NDArray[Any]]
Mazes = Union[Maze, Iterable[Maze], None]


class SearchEnv(gymnasium.Env[Observation, Union[int, np.integer[Any]]]):
    """One mouse that searches one maze after another. See the module for actions and observations.

    Each episode draws a maze from `mazes`, which have the same size. Without `mazes`, each episode
    generates a maze of this `size` and `style` ("contest", "perfect" or "open"). An episode is
    truncated after `max_steps` actions, by default four for each cell.
    """

    metadata = {"render_modes": ["ansi"], "render_fps": 10}

    def __init__(
        self,
        mazes: Mazes = None,
        *,
        size: tuple[int, int] = (16, 16),
        style: str = "contest",
        until: Literal["goal", "proof"] = "goal",
        max_steps: int | None = None,
        render_mode: Literal["ansi"] | None = None,
    ) -> None:
        if render_mode not in (None, "ansi"):
            raise ValueError(f"expected the render mode 'ansi' or None, found {render_mode!r}")
        self.render_mode = render_mode
        self._batch = _batch(mazes, size, style, until, max_steps, 1)
        self._is_seeded = False
        self.observation_space = _observation_space(self._batch)
        self.action_space = spaces.Discrete(4)

    @property
    def maze(self) -> Maze:
        """The true maze of the episode."""
        return self._batch.maze(0)

    @property
    def known(self) -> KnownMaze:
        """A copy of the map of the mouse. A notebook displays it as a picture."""
        return self._batch.known(0)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins a new episode. The seed determines the mazes of all later episodes."""
        super().reset(seed=seed)
        is_new = seed is not None or not self._is_seeded
        self._batch.reset(0, _batch_seed(self.np_random) if is_new else None)
        self._is_seeded = True
        return self._observation(), self._info()

    def step(
        self, action: int | np.integer[Any]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Turns the mouse and moves it one cell, unless there is a wall."""
        reward, terminated, truncated = self._batch.step_one(int(action))
        return self._observation(), reward, terminated, truncated, self._info()

    def render(self) -> str | None:  # type: ignore[override]
        """Returns the map of the mouse as text."""
        return str(self.known) if self.render_mode == "ansi" else None

    def _observation(self) -> Observation:
        walls, openings, goals, pose = self._batch.observation(0)
        return {"walls": walls, "openings": openings, "goals": goals, "pose": pose}

    def _info(self) -> dict[str, Any]:
        mask, goal_reached = self._batch.info(0)
        return {"action_mask": mask, "goal_reached": goal_reached}


class SearchVectorEnv(VectorEnv[Observation, NDArray[Any], NDArray[Any]]):
    """Many mice that search one maze each, and take their steps in one call.

    The arguments are those of `SearchEnv`. In the step after the end of its episode, an environment
    ignores its action and begins the next episode, with a reward of 0. Environment i behaves like a
    `SearchEnv` that was reset with the seed `seed + i`.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        mazes: Mazes = None,
        *,
        size: tuple[int, int] = (16, 16),
        style: str = "contest",
        until: Literal["goal", "proof"] = "goal",
        max_steps: int | None = None,
        render_mode: None = None,
    ) -> None:
        if render_mode is not None:
            raise ValueError("a batch of environments has no render mode")
        self.num_envs = num_envs
        self.render_mode = None
        self._batch = _batch(mazes, size, style, until, max_steps, num_envs)
        self._is_seeded = False
        self.single_observation_space = _observation_space(self._batch)
        self.single_action_space = spaces.Discrete(4)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def maze(self, index: int) -> Maze:
        """Returns the true maze of an environment."""
        return self._batch.maze(index)

    def known(self, index: int) -> KnownMaze:
        """Returns a copy of the map that the mouse of an environment has made."""
        return self._batch.known(index)

    def reset(  # type: ignore[override]
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins a new episode in each environment, with the seeds `seed`, `seed + 1`, ..."""
        seeds: list[int | None]
        if isinstance(seed, list):
            if len(seed) != self.num_envs:
                raise ValueError(f"expected {self.num_envs} seeds, found {len(seed)}")
            seeds = seed
        else:
            seeds = [None if seed is None else seed + i for i in range(self.num_envs)]
            super().reset(seed=seed)
        for index, own in enumerate(seeds):
            if own is not None:
                self._batch.reset(index, _batch_seed(seeding.np_random(own)[0]))
            else:
                self._batch.reset(index, None if self._is_seeded else _batch_seed(self.np_random))
        self._is_seeded = True
        return self._observation(), self._info()

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[Observation, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Takes one action in each environment. `actions` has the shape (num_envs,)."""
        results = self._batch.step(np.require(actions, np.int64, ["C", "A"]))
        return self._observation(), *results, self._info()

    def _observation(self) -> Observation:
        walls, openings, goals, poses = self._batch.observations()
        return {"walls": walls, "openings": openings, "goals": goals, "pose": poses}

    def _info(self) -> dict[str, Any]:
        masks, goal_reached = self._batch.infos()
        every = np.ones(self.num_envs, dtype=np.bool_)
        return {
            "action_mask": masks,
            "_action_mask": every,
            "goal_reached": goal_reached,
            "_goal_reached": every,
        }


def _batch(
    mazes: Mazes,
    size: tuple[int, int],
    style: str,
    until: str,
    max_steps: int | None,
    count: int,
) -> SearchBatch:
    if until not in ("goal", "proof"):
        raise ValueError(f"expected until='goal' or until='proof', found {until!r}")
    if count < 1:
        raise ValueError(f"expected at least one environment, found {count}")
    pool = [mazes] if isinstance(mazes, Maze) else None if mazes is None else list(mazes)
    return SearchBatch(pool, size, style, until == "proof", max_steps, count)


def _batch_seed(rng: np.random.Generator) -> int:
    return int(rng.integers(2**63))


def _observation_space(batch: SearchBatch) -> spaces.Space[Any]:
    width, height = batch.size
    return spaces.Dict(
        {
            "walls": spaces.Box(0, 31, (width, height), np.uint8),
            "openings": spaces.Box(0, 30, (width, height), np.uint8),
            "goals": spaces.Box(0, 1, (width, height), np.uint8),
            "pose": spaces.MultiDiscrete([width, height, 4]),
        }
    )


gymnasium.register(
    id=ENV_ID, entry_point=SearchEnv, vector_entry_point=SearchVectorEnv  # type: ignore[arg-type]
)
