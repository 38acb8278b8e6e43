"""A flood-fill mouse: always goes to the neighbour nearest to the goal, with unknown walls open.

Start a simulator with `mmsim`, then run this program, optionally with an endpoint such as
tcp://127.0.0.1:6574.
"""
import sys
from collections import deque

from mmsim import Heading, Known, Pose, Simulator, SimulatorError

WIDTH, HEIGHT = 16, 16
GOALS = [(7, 7), (7, 8), (8, 7), (8, 8)]
FRONT, LEFT, RIGHT, BACK = 0, -1, 1, 2  # quarter turns to the right
UNREACHABLE = 0xFFFF


class Mouse:
    """The pose of the mouse, the walls it knows, and its distances to the goal."""

    def __init__(self) -> None:
        self.pose = Pose(0, 0, Heading.NORTH)
        self.walls = [[0] * HEIGHT for _ in range(WIDTH)]  # sums of Known
        self.distances = [[UNREACHABLE] * HEIGHT for _ in range(WIDTH)]
        for x in range(WIDTH):
            self.walls[x][0] |= Known.SOUTH
            self.walls[x][HEIGHT - 1] |= Known.NORTH
        for y in range(HEIGHT):
            self.walls[0][y] |= Known.WEST
            self.walls[WIDTH - 1][y] |= Known.EAST

    def read_walls(self, simulator: Simulator) -> None:
        """Records each wall around the mouse in the cells on both sides of the wall."""
        x, y = self.pose.x, self.pose.y
        self.walls[x][y] |= Known.VISITED
        for turn, wall in zip((LEFT, FRONT, RIGHT), simulator.walls(self.pose)):
            beyond = self.pose.after(turn)
            if wall:
                self.walls[x][y] |= Known.wall(beyond.heading)
                if beyond.x in range(WIDTH) and beyond.y in range(HEIGHT):
                    self.walls[beyond.x][beyond.y] |= Known.wall(beyond.heading.turned(BACK))

    def flood(self) -> None:
        """Computes the number of steps from each cell to the goal, with unknown walls open."""
        self.distances = [[UNREACHABLE] * HEIGHT for _ in range(WIDTH)]
        for x, y in GOALS:
            self.distances[x][y] = 0
        cells = deque(GOALS)
        while cells:
            x, y = cells.popleft()
            for heading in Heading:
                beyond = Pose(x, y, heading).after(FRONT)
                if self.walls[x][y] & Known.wall(heading):
                    continue
                if self.distances[beyond.x][beyond.y] == UNREACHABLE:
                    self.distances[beyond.x][beyond.y] = self.distances[x][y] + 1
                    cells.append((beyond.x, beyond.y))

    def step(self) -> bool:
        """Takes a step towards the goal. Returns whether there is a path."""
        walls = self.walls[self.pose.x][self.pose.y]
        ahead = [self.pose.after(turn) for turn in (FRONT, LEFT, RIGHT, BACK)]
        open_poses = [pose for pose in ahead if not walls & Known.wall(pose.heading)]
        # On a tie, min returns the first.
        self.pose = min(open_poses, key=self.distance, default=self.pose)
        return self.distance(self.pose) < UNREACHABLE

    def distance(self, pose: Pose) -> int:
        """Returns the number of steps from a pose to the goal."""
        return self.distances[pose.x][pose.y]


def search(simulator: Simulator) -> int:
    """Searches the maze and returns the number of steps to the goal."""
    simulator.ping()
    simulator.reset()
    mouse, steps = Mouse(), 0
    while True:
        mouse.read_walls(simulator)
        mouse.flood()
        simulator.state(mouse.pose, mouse.distances, mouse.walls)
        if (mouse.pose.x, mouse.pose.y) in GOALS:
            return steps
        if not mouse.step():
            sys.exit(f"goal unreachable after {steps} steps")
        steps += 1


if __name__ == "__main__":
    try:
        with Simulator(sys.argv[1]) if len(sys.argv) > 1 else Simulator() as simulator:
            print(f"goal reached after {search(simulator)} steps")
    except SimulatorError as error:
        sys.exit(str(error))
    except KeyboardInterrupt:
        sys.exit("interrupted")
