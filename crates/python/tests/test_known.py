import copy
from typing import Any

import pytest

import micromouse_sim as mm


def test_headings_poses_and_walls_are_values() -> None:
    assert [mm.Heading.NORTH.turned(turn) for turn in (-1, 0, 1, 2, 5)] == list("WNESE")
    assert mm.Pose(3, 4, mm.Heading.NORTH).after(1) == mm.Pose(4, 4, mm.Heading.EAST)
    assert mm.Pose(3, 4, "S").after(0).cell == (3, 3)  # type: ignore[arg-type]
    left, front, right = mm.Simulator(mm.Maze.bundled("01")).walls(0, 0, "N")
    assert (left, front, right) == (True, False, True)


def test_observed_walls_are_known_from_both_sides() -> None:
    known = mm.KnownMaze((3, 3))
    assert known.goals == ((1, 1),) and known.start == (0, 0, "N")
    assert (known.optimistic_distance, known.pessimistic_distance) == (2, None)
    known.observe(1, 1, "E", mm.Walls(left=True, front=False, right=False))
    assert known.wall(1, 1, mm.Heading.NORTH) is True and known.wall(1, 2, "S") is True
    assert known.wall(1, 1, "E") is False and known.wall(1, 1, "W") is None
    assert known.is_visited(1, 1) and known.visited == ((1, 1),) and known.is_goal(1, 1)
    assert known.walls[1, 1] == 17 and known.walls[0, 0] == 12
    with pytest.raises(mm.Contradiction, match="north side of .1, 1. is known to have a wall"):
        known.observe(1, 1, "N", (False, False, False))


def test_open_poses_are_in_the_order_of_preference() -> None:
    known = mm.KnownMaze((3, 3))
    known.observe(1, 1, "E", (False, False, False))
    known.observe(1, 1, "W", (False, False, False))
    assert [pose.heading for pose in known.open_poses(1, 1, "E")] == list("ENSW")
    assert known.open_poses(0, 0, "N") == []


def test_unknown_walls_count_as_open_or_closed() -> None:
    known = mm.KnownMaze((2, 1), goals=[(1, 0)])
    assert known.distances().tolist() == [[1], [0]] == known.distances("open").tolist()
    assert known.distances("closed").tolist() == [[65535], [0]]
    assert mm.flood(known, [(0, 0)], "closed").tolist() == [[0], [65535]]
    assert not known.proven
    known.observe(0, 0, "E", (True, False, True))
    assert known.proven and known.pessimistic_distance == 1


def test_copies_are_independent() -> None:
    known = mm.KnownMaze.unexplored(mm.Maze.bundled("01"))
    copies = [known.copy(), copy.copy(known), copy.deepcopy(known)]
    known.observe(0, 0, "N", (True, False, True))
    assert all(one == copies[0] != known for one in copies)
    assert "<svg" in known._repr_svg_() and str(known).startswith("o---o")


@pytest.mark.parametrize("name", mm.STRATEGIES)
def test_strategies_move_as_in_a_search(name: str) -> None:
    maze = mm.Maze.bundled("03")
    simulator, strategy = mm.Simulator(maze), mm.Strategy(name)
    known, pose = simulator.unexplored(), simulator.start
    expected = mm.search(maze, name)
    for state in expected.states:
        known.observe(*pose, simulator.walls(*pose))
        following = strategy.next_move(known, *pose)
        simulator.state(*pose, strategy.weights(), known)
        assert simulator.history[-1] == state
        if following is None:
            break
        pose = following
    assert len(simulator.history) == len(expected.states)


def test_strategies_report_why_they_cannot_continue() -> None:
    known = mm.KnownMaze((2, 1), goals=[(1, 0)])
    known.observe(0, 0, "N", (True, True, True))
    with pytest.raises(mm.SearchError, match=r"goal unreachable from \(0, 0\)"):
        mm.Strategy("flood-fill").next_move(known, 0, 0, "N")
    strategy = mm.Strategy("flood-fill")
    strategy.next_move(mm.KnownMaze(), 7, 7, "N")
    with pytest.raises(ValueError, match="a strategy searches one maze"):
        strategy.next_move(known, 0, 0, "N")
    with pytest.raises(ValueError, match="expected one of flood-fill, "):
        mm.Strategy("luck")


def test_faulty_maps_are_refused() -> None:
    faults: list[dict[str, Any]] = [
        {"goals": [(9, 9)]}, {"start": (9, 0)}, {"goals": []}, {"size": (0, 1)}, {"size": (-3, 3)}
    ]
    for arguments in faults:
        with pytest.raises(ValueError):
            mm.KnownMaze(**{"size": (3, 3), **arguments})
    with pytest.raises(TypeError, match="expected a cell"):
        mm.KnownMaze((3, 3), goals=[3])  # type: ignore[list-item]
    with pytest.raises(ValueError, match="expected open or closed"):
        mm.KnownMaze().distances("perhaps")  # type: ignore[arg-type]
