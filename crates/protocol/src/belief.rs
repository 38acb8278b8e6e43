//! Converts a state to a map of the maze.

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, WallState};

use crate::matrix::CellWalls;
use crate::state::State;

impl State<'_> {
    /// Returns the client's map of the maze.
    ///
    /// A wall is present if the flags of either adjacent cell report it. A wall that no
    /// flag reports is absent if either adjacent cell has been visited, and unknown otherwise.
    ///
    /// ```
    /// use mmsim_protocol::{Cell, CellSet, Heading, MazeSize, State, WallState};
    /// let size = MazeSize::new(3, 1)?;
    /// let message = b"S\x00\x00NC\x02\x01\x00C\x1d\x00\x00";
    /// let state = State::decode(message, size)?;
    /// let map = state.map(Cell::new(0, 0), CellSet::EMPTY);
    /// assert_eq!(map.wall(Cell::new(0, 0), Heading::East), WallState::Absent);
    /// assert_eq!(map.wall(Cell::new(1, 0), Heading::East), WallState::Unknown);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn map(&self, start: Cell, goals: CellSet) -> KnownMaze {
        let size = self.size();
        let mut map = KnownMaze::new(size, start, goals);
        for cell in size.cells() {
            let here = self.cell_walls(cell).unwrap_or_default();
            if here.visited() {
                map.visit(cell);
            }
            for heading in [Heading::North, Heading::East] {
                let Some(neighbour) = size.neighbour(cell, heading) else { continue };
                let there = self.cell_walls(neighbour).unwrap_or_default();
                map.set_wall(cell, heading, between(here, there, heading));
            }
        }
        map
    }
}

/// Returns the state of the wall on the `heading` side of `here`. The cell `there` is on the other
/// side of the wall.
const fn between(here: CellWalls, there: CellWalls, heading: Heading) -> WallState {
    if here.wall(heading) || there.wall(heading.back()) {
        WallState::Present
    } else if here.visited() || there.visited() {
        WallState::Absent
    } else {
        WallState::Unknown
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use mmsim_maze::{MazeSize, Pose};

    use super::*;
    use crate::layout::MAX_STATE_BYTES;
    use crate::matrix::Order;
    use crate::state::MapState;

    #[test]
    fn a_report_of_either_cell_decides_about_a_wall() {
        use WallState::{Absent, Present, Unknown};
        let (nothing, visited) = (CellWalls(0), CellWalls(1));
        let (west, east) = (CellWalls(8), CellWalls(2));
        for (here, there, expected) in [
            (nothing, nothing, Unknown),
            (visited, nothing, Absent),
            (nothing, visited, Absent),
            (east, nothing, Present),
            (nothing, west, Present),
            (east, visited, Present),
            (visited, west, Present),
            (west, nothing, Unknown),
            (nothing, east, Unknown),
        ] {
            let cells = [b'S', 0, 0, b'N', b'C', 0, 0, b'C', here.0, there.0];
            let size = MazeSize::new(2, 1).unwrap();
            let map = State::decode(&cells, size).unwrap().map(Cell::new(0, 0), CellSet::EMPTY);
            assert_eq!(map.wall(Cell::new(0, 0), Heading::East), expected, "{here:?}, {there:?}");
            let is_visited = [here, there].map(|flags| flags == visited);
            let cells = [0, 1].map(|x| Cell::new(x, 0));
            assert_eq!(cells.map(|cell| map.visited().contains(cell)), is_visited);
        }
        let (south, north) = (CellWalls(4), CellWalls(16));
        for (here, there, expected) in
            [(north, nothing, Present), (nothing, south, Present), (south, north, Unknown)]
        {
            let cells = [b'S', 0, 0, b'N', b'C', 0, 0, b'C', here.0, there.0];
            let size = MazeSize::new(1, 2).unwrap();
            let map = State::decode(&cells, size).unwrap().map(Cell::new(0, 0), CellSet::EMPTY);
            assert_eq!(map.wall(Cell::new(0, 0), Heading::North), expected, "{here:?}, {there:?}");
        }
    }

    proptest! {
        /// In this test, the mouse knows all four walls of each visited cell, because a state
        /// cannot represent an unknown wall of a visited cell.
        #[test]
        fn a_map_survives_a_round_trip(
            (width, height) in (1usize..=32, 1usize..=32),
            readings in prop::collection::vec((any::<u8>(), any::<u8>(), any::<[bool; 4]>()), 0..60),
            order in prop_oneof![Just(Order::C), Just(Order::F)],
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let (start, goals) = (Pose::new(Cell::new(0, 0), Heading::North), size.central_cells());
            let mut map = KnownMaze::new(size, start.cell, goals);
            for (x, y, walls) in readings {
                let cell = Cell::new(x % size.width(), y % size.height());
                for (heading, wall) in Heading::ALL.into_iter().zip(walls) {
                    if map.wall(cell, heading) == WallState::Unknown {
                        let wall = if wall { WallState::Present } else { WallState::Absent };
                        map.set_wall(cell, heading, wall);
                    }
                }
                map.visit(cell);
            }
            let mut buffer = [0; MAX_STATE_BYTES];
            let length = MapState::new(start, &map, |_| 0, order).encode(&mut buffer).unwrap();
            let state = State::decode(&buffer[..length], size).unwrap();
            prop_assert_eq!(state.map(start.cell, goals), map);
        }
    }
}
