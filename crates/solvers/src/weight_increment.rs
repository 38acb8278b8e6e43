//! The weight-increment strategy, which goes to the least visited neighbour.

use mmsim_maze::{Cell, CellMap, Heading, KnownMaze, MazeSize, Pose};

use crate::strategy::{Move, SearchError, Strategy, step_to_least};

/// A strategy that counts the visits to each cell and goes to the least visited neighbour.
///
/// The weight of a cell is the number of visits to it. The weight of the start includes one extra
/// visit, as in the example client of the reference simulator (mmsim 0.1.7, written in Python). The
/// strategy always reaches a reachable goal, but takes detours.
#[derive(Clone, Debug)]
pub struct WeightIncrement {
    visits: CellMap<u16>,
    has_begun: bool,
}

impl WeightIncrement {
    /// Creates the strategy in its initial state.
    pub const fn new() -> Self {
        Self { visits: CellMap::new(0), has_begun: false }
    }
}

impl Default for WeightIncrement {
    fn default() -> Self {
        Self::new()
    }
}

impl Strategy for WeightIncrement {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        let more = if self.has_begun { 1 } else { 2 };
        self.has_begun = true;
        if MazeSize::LARGEST.contains(pose.cell) {
            self.visits[pose.cell] = self.visits[pose.cell].saturating_add(more);
        }
        if map.goals().contains(pose.cell) {
            return Ok(Move::Stop);
        }
        // `map` of arrays is not always inlined.
        let mut visits = [0; 4];
        for heading in Heading::ALL {
            let neighbour = pose.cell.neighbour(heading).and_then(|cell| self.weight(cell));
            visits[heading as usize] = neighbour.unwrap_or(0).into();
        }
        step_to_least(map, pose, visits)
            .map(|(step, _)| Move::Step(step))
            .ok_or(SearchError::BoxedIn { cell: pose.cell })
    }

    fn weight(&self, cell: Cell) -> Option<u16> {
        MazeSize::LARGEST.contains(cell).then(|| self.visits[cell])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::search;

    const MAZE: &str = "\
o---o---o---o
|   |     G |
o   o   o---o
|           |
o   o   o   o
| S |       |
o---o---o---o
";

    #[test]
    fn goes_to_the_neighbour_visited_least() {
        let outcome = search(WeightIncrement::new(), MAZE, 100);
        assert_eq!(outcome.result, Ok(Move::Stop));
        insta::assert_snapshot!(outcome.drawing, @"
        o---o---o---o
        | 1 | 1   > |
        o   o   o---o
        | 2   2   1 |
        o   o   o   o
        | 2 | 1   1 |
        o---o---o---o
        ");
    }

    #[test]
    fn reports_that_it_is_boxed_in() {
        let outcome = search(WeightIncrement::new(), "o---o---o\n| S | G |\no---o---o\n", 100);
        assert_eq!(outcome.result, Err(SearchError::BoxedIn { cell: Cell::new(0, 0) }));
        assert_eq!(outcome.steps, 0);
    }
}
