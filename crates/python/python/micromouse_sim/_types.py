"""The types that describe a mouse and what it sees."""
from __future__ import annotations

from enum import Enum
from typing import NamedTuple


class Heading(str, Enum):
    """A heading. The headings are in clockwise order, a quarter turn apart.

    Each heading is also its letter, so `"N"` and `Heading.NORTH` are equal.
    """

    NORTH = "N"
    EAST = "E"
    SOUTH = "S"
    WEST = "W"

    def __new__(cls, value: str) -> Heading:
        heading = str.__new__(cls, value)
        heading._value_ = value
        return heading

    def turned(self, quarters: int) -> Heading:
        """Returns the heading after quarter turns to the right; negative numbers turn left."""
        return _CLOCKWISE[(_CLOCKWISE.index(self) + quarters) % 4]


_CLOCKWISE = tuple(Heading)
_OFFSETS = {"N": (0, 1), "E": (1, 0), "S": (0, -1), "W": (-1, 0)}


class Pose(NamedTuple):
    """The cell and the heading of a mouse. `walls(*pose)` passes all three fields."""

    x: int
    y: int
    heading: Heading

    @property
    def cell(self) -> tuple[int, int]:
        """The cell as `(x, y)`."""
        return self.x, self.y

    def after(self, quarters: int) -> Pose:
        """Returns the pose after quarter turns to the right and a step of one cell."""
        heading = Heading(self.heading).turned(quarters)
        east, north = _OFFSETS[heading.value]
        return Pose(self.x + east, self.y + north, heading)


class Walls(NamedTuple):
    """The walls around a mouse; a field is true if there is a wall."""

    left: bool
    front: bool
    right: bool
