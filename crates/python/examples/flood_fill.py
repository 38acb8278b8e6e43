"""A flood-fill mouse: always goes to the neighbour nearest to the goal, with unknown walls open.

`python flood_fill.py` searches a maze in this process. `mmsim run flood_fill.py` shows the
same search in a browser.
"""
from __future__ import annotations

import os

import micromouse_sim as mm

UNREACHABLE = 65535


def search(simulator: mm.Simulator | mm.Client) -> bool:
    """Drives to the goal. Returns false if it is unreachable."""
    simulator.reset()
    known, pose = simulator.unexplored(), simulator.start
    while True:
        known.observe(*pose, simulator.walls(*pose))
        distances = known.distances()
        simulator.state(*pose, distances, known)
        if known.is_goal(*pose.cell) or distances[pose.cell] == UNREACHABLE:
            return known.is_goal(*pose.cell)
        pose = min(known.open_poses(*pose), key=lambda pose: int(distances[pose.cell]))


if __name__ == "__main__":
    maze = mm.Maze.bundled("01-harbour")
    simulator = mm.Client() if "MMSIM_ENDPOINT" in os.environ else mm.Simulator(maze)
    print("goal reached" if search(simulator) else "goal unreachable")
