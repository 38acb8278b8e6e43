"""Strategies in mazes that contradict themselves. `test_hostile.py` calls everything else."""
import random

import pytest

import micromouse_sim as mm


@pytest.mark.parametrize("name", mm.STRATEGIES)
def test_strategies_survive_impossible_searches(name: str) -> None:
    rng = random.Random(name)
    for _ in range(60):
        width, height = rng.randrange(1, 20), rng.randrange(1, 20)
        cells = [(rng.randrange(width), rng.randrange(height)) for _ in range(3)]
        known, strategy = mm.KnownMaze((width, height), cells[:2], cells[2]), mm.Strategy(name)
        for _ in range(12):
            pose = rng.randrange(width), rng.randrange(height), rng.choice(list(mm.Heading))
            try:
                known.observe(*pose, [rng.random() < 0.5 for _ in range(3)])
                strategy.next_move(known, *pose)
                strategy.weights()
            except (mm.Contradiction, mm.SearchError):
                pass
