//! What a state says of the maze.

use crate::{Cell, CellSet, CellWalls, Heading, KnownMaze, State, WallState};

impl State<'_> {
    /// The maze as the client believes it to be. A wall is present if the cell on either side says
    /// so, else absent if either has been visited, else unknown: the protocol has no word for that.
    ///
    /// ```
    /// use mmsim_protocol::{Cell, CellSet, Heading, MazeSize, Request, WallState};
    /// let size = MazeSize::new(3, 1)?;
    /// let message = b"S\x00\x00NC\x02\x01\x00C\x1d\x00\x00";
    /// let Ok(Request::State(state)) = Request::decode(message, size) else { panic!() };
    /// let map = state.map(Cell::new(0, 0), CellSet::EMPTY);
    /// assert_eq!(map.wall(Cell::new(0, 0), Heading::East), WallState::Absent);
    /// assert_eq!(map.wall(Cell::new(1, 0), Heading::East), WallState::Unknown);
    /// # Ok::<(), mmsim_maze::SizeError>(())
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

/// The wall between two cells, of which the second lies towards `heading` from the first.
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

    use super::*;
    use crate::{MAX_STATE_BYTES, MazeSize, Order, Pose, Request, encode_state};

    proptest! {
        /// A mouse that has looked at all four sides of the cells it knows is understood.
        #[test]
        fn a_map_that_is_sent_comes_back(
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
            let length = encode_state(&mut buffer, start, &map, |_| 0, order).unwrap();
            let Ok(Request::State(state)) = Request::decode(&buffer[..length], size) else { panic!() };
            prop_assert_eq!(state.map(start.cell, goals), map);
        }
    }
}
