"""Goes where it has been least often, then races along the last exit that it took from each cell.

The robots in this folder import it, as robots of the two-run trial import the modules beside them. It
runs in Python 2.7 and 3.
"""
STEPS = {"up": (0, 1), "right": (1, 0), "down": (0, -1), "left": (-1, 0)}
HEADINGS = ["up", "right", "down", "left"]


class Walker(object):
    def __init__(self, maze_dim, turns=(0, -90, 90)):
        self.location, self.heading, self.racing = (0, 0), "up", False
        self.turns, self.visits, self.exits = turns, {}, {}
        self.goal = [maze_dim // 2 - 1, maze_dim // 2]

    def next_move(self, sensors):
        here = self.location
        if not self.racing and all(side in self.goal for side in here):
            self.location, self.heading, self.racing = (0, 0), "up", True
            return "Reset", "Reset"
        self.visits[here] = self.visits.get(here, 0) + 1
        choices = []
        for rotation, seen in zip((-90, 0, 90), sensors):
            heading = HEADINGS[(HEADINGS.index(self.heading) + rotation // 90) % 4]
            beyond = (here[0] + STEPS[heading][0], here[1] + STEPS[heading][1])
            if seen > 0 and (not self.racing or self.exits[here] == heading):
                order = self.turns.index(rotation)
                choices.append((self.visits.get(beyond, 0), order, rotation, heading, beyond))
        if not choices:
            self.heading = HEADINGS[(HEADINGS.index(self.heading) + 1) % 4]
            return 90, 0
        _, _, rotation, self.heading, self.location = min(choices)
        self.exits[here] = self.heading
        return rotation, 1.0
