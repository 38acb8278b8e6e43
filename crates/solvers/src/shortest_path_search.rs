//! Shortest-path search: explores until a shortest way is proven, and no longer.

use mmsim_maze::{Cell, CellSet, KnownMaze, MazeSize, Pose, Unknown};

use crate::flood::Distances;
use crate::flood::{ToSee, UNREACHABLE, cell_to_see};
use crate::strategy::{Move, Phase, SearchError, Strategy, step_to_least};

/// Shortest-path search: goes to the goal, explores until it is proven that no unknown wall can
/// hide a shorter way than the known one, returns to the start, and runs fast.
///
/// - To the goal it goes by flood fill, unknown walls taken as open; of neighbours equally near the
///   one that is least far off as the crow flies, so that it keeps most ways open.
/// - Then it looks at the shortest ways from the start to the goal, unknown walls open, layer by
///   layer: all cells at the same distance from the start. Each way crosses each layer, so where it
///   has seen nothing of a layer yet, a few walls may close all of them at once. It goes to the
///   nearest cell of the narrowest such layers.
/// - It stops exploring as soon as one of those ways is known to be open all along: then the cost
///   with unknown walls open equals the one with unknown walls closed. (Where it knows that one step
///   before the goal, it takes that step.)
/// - It comes home over unknown walls where that may be shorter.
///
/// Its weights are distances to where it goes, in steps. It proves a shortest way wherever there is
/// one; where there is none it comes back to the start and says so there.
#[derive(Clone, Debug)]
pub struct ShortestPathSearch {
    leg: Leg,
    /// Where it has been. A cell that it comes back to tells nothing new.
    been: CellSet,
    /// Where it goes to see what, while it explores.
    to_see: Option<ToSee>,
    distances: Distances,
    /// The south-western and the north-eastern corner of the box around the goal cells, kept from the
    /// first step on, since each step asks.
    goal_corners: Option<[Cell; 2]>,
}

/// What the mouse is about.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Leg {
    ToGoal,
    Explore,
    Return,
    /// No goal can be reached: it returns to say so.
    GiveUp,
    FastRun,
}

impl ShortestPathSearch {
    /// A search that has not begun yet.
    pub const fn new() -> Self {
        Self {
            leg: Leg::ToGoal,
            been: CellSet::EMPTY,
            to_see: None,
            distances: Distances::unreachable(MazeSize::CLASSIC),
            goal_corners: None,
        }
    }

    /// Plans the way on, and starts the next leg where one is over.
    fn plan(&mut self, map: &KnownMaze, cell: Cell) {
        let (open, closed) = (map.walls(Unknown::Open), map.walls(Unknown::Closed));
        if self.leg == Leg::ToGoal {
            if !self.distances.lead_on(open, cell) {
                self.distances.refill(open, map.goals());
            }
            if map.goals().contains(cell) {
                self.leg = Leg::Explore;
            } else if self.distances.at(cell).is_none() {
                self.leg = Leg::GiveUp;
            }
        }
        // Away from the shortest ways nothing that it sees changes them, and new walls make only ways
        // longer, if not its own.
        if self.leg == Leg::Explore {
            let leads_on = self.to_see.is_some() && self.distances.lead_on(open, cell);
            if !leads_on || self.to_see.is_some_and(|to_see| to_see.ways.contains(cell)) {
                let before = self.to_see.map(|to_see| to_see.cell);
                self.to_see = cell_to_see(map, cell);
                match self.to_see {
                    Some(to_see) if leads_on && before == Some(to_see.cell) => {}
                    Some(to_see) => self.distances.refill(open, &only(to_see.cell)),
                    None => self.leg = Leg::Return,
                }
            }
        }
        if matches!(self.leg, Leg::Return | Leg::GiveUp) {
            let known = Distances::flood(closed, &only(map.start().cell));
            self.distances.refill(open, &only(map.start().cell));
            if self.distances.at(cell) >= known.at(cell) {
                self.distances = known;
            }
        }
        if self.leg == Leg::Return && cell == map.start().cell {
            self.leg = Leg::FastRun;
            self.distances.refill(closed, map.goals());
        }
    }

    /// Whether the mouse is where this leg ends.
    fn has_arrived(&self, map: &KnownMaze, cell: Cell) -> bool {
        match self.leg {
            Leg::ToGoal => map.goals().contains(cell),
            Leg::Return => cell == map.start().cell,
            Leg::Explore | Leg::GiveUp | Leg::FastRun => false,
        }
    }
}

impl Default for ShortestPathSearch {
    fn default() -> Self {
        Self::new()
    }
}

impl Strategy for ShortestPathSearch {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        let cell = pose.cell;
        let is_new = self.been.insert(cell) || cell == map.start().cell;
        if self.leg != Leg::FastRun && (is_new || self.has_arrived(map, cell)) {
            self.plan(map, cell);
        }
        match self.leg {
            Leg::FastRun if map.goals().contains(cell) => return Ok(Move::Stop),
            Leg::GiveUp if map.start().cell == cell => {
                return Err(SearchError::GoalUnreachable { cell });
            }
            _ => {}
        }
        let corners = *self.goal_corners.get_or_insert_with(|| corners(map.goals()));
        let crow_flies =
            if self.leg == Leg::ToGoal { crow_flies_around(cell, corners) } else { [0; 4] };
        let mut numbers = self.distances.raw_around(cell).map(u32::from);
        for (number, crow_flies) in numbers.iter_mut().zip(crow_flies) {
            *number = *number << 8 | u32::from(crow_flies);
        }
        step_to_least(map, pose, numbers)
            .filter(|&(_, number)| number >> 8 < UNREACHABLE.into())
            .map(|(step, _)| Move::Step(step))
            .ok_or(SearchError::BoxedIn { cell })
    }

    fn weight(&self, cell: Cell) -> u16 {
        self.distances.raw(cell)
    }

    fn phase(&self) -> Phase {
        match self.leg {
            Leg::ToGoal | Leg::Explore => Phase::SearchRun,
            Leg::Return | Leg::GiveUp => Phase::ReturnRun,
            Leg::FastRun => Phase::FastRun,
        }
    }
}

/// The south-western and the north-eastern corner of the box around some cells.
fn corners(cells: &CellSet) -> [Cell; 2] {
    let mut cells = cells.iter();
    let first = cells.next().unwrap_or(Cell::new(0, 0));
    cells.fold([first; 2], |[south_west, north_east], Cell { x, y }| {
        [
            Cell::new(south_west.x.min(x), south_west.y.min(y)),
            Cell::new(north_east.x.max(x), north_east.y.max(y)),
        ]
    })
}

/// How far a cell's neighbours are off a box, walls or not: the larger of columns and rows. In the
/// order of [`Heading::ALL`](mmsim_maze::Heading::ALL).
fn crow_flies_around(cell: Cell, [south_west, north_east]: [Cell; 2]) -> [u8; 4] {
    let off = |from: u8, at: u8, to: u8| from.saturating_sub(at).max(at.saturating_sub(to));
    let columns = |x| off(south_west.x, x, north_east.x);
    let rows = |y| off(south_west.y, y, north_east.y);
    let Cell { x, y } = cell;
    [
        columns(x).max(rows(y.saturating_add(1))),
        columns(x.saturating_add(1)).max(rows(y)),
        columns(x).max(rows(y.saturating_sub(1))),
        columns(x.saturating_sub(1)).max(rows(y)),
    ]
}

fn only(cell: Cell) -> CellSet {
    [cell].into_iter().collect()
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Heading, Maze, Walls};
    use proptest::prelude::*;

    use super::*;
    use crate::driver::SearchDriver;
    use crate::mouse::Mouse;
    use crate::testing::{Outcome, search};

    fn steps(maze: &str) -> (Result<Move, SearchError>, u32) {
        let Outcome { result, steps, .. } = search(ShortestPathSearch::new(), maze, 1000);
        (result, steps)
    }

    #[test]
    fn it_proves_the_shortest_way_and_runs_it() {
        let maze = "\
o---o---o---o---o
|               |
o   o---o   o   o
|   | G     |   |
o   o---o---o   o
|               |
o   o---o---o---o
| S |           |
o---o---o---o---o
";
        let outcome = search(ShortestPathSearch::new(), maze, 1000);
        assert_eq!((outcome.result, outcome.steps), (Ok(Move::Stop), 21));
        insta::assert_snapshot!(outcome.drawing, @"
        o---o---o---o---o
        | 4   3   2   3 |
        o   o---o   o . o
        | 5 | <   1 |   |
        o   o---o---o . o
        | 6   7 .   .   |
        o   o . o . o . o
        | 7 |   .   .   |
        o---o---o---o---o
        ");
    }

    #[test]
    fn a_goal_without_a_way_is_reported_at_the_start() {
        let unreachable = Err(SearchError::GoalUnreachable { cell: Cell::new(0, 0) });
        let maze = "o---o---o\n|   | G |\no   o---o\n| S     |\no---o---o\n";
        assert_eq!(steps(maze), (unreachable, 4));
        assert_eq!(steps("o---o---o\n| S | G |\no---o---o\n"), (unreachable, 0));
    }

    #[test]
    fn a_start_in_the_goal_is_no_trap() {
        for maze in ["o---o\n|SG |\no---o\n", "o---o---o\n| G |SG |\no---o---o\n"] {
            assert_eq!(steps(maze), (Ok(Move::Stop), 0));
        }
    }

    proptest! {
        #[test]
        fn it_proves_a_shortest_way_or_says_that_there_is_none(
            (width, height) in (1usize..=32, 1usize..=32),
            density in 0.0..0.7,
            rolls in prop::collection::vec(0.0..1.0, 2 * MazeSize::MAX_AREA),
            start in (0u8..32, 0u8..32),
            goals in prop::collection::vec((0u8..32, 0u8..32), 0..5),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let mut walls = Walls::open(size);
            for (cell, rolls) in size.cells().zip(rolls.chunks(2)) {
                walls.set(cell, Heading::North, rolls[0] < density);
                walls.set(cell, Heading::East, rolls[1] < density);
            }
            let inside = |(x, y): (u8, u8)| Cell::new(x % size.width(), y % size.height());
            let goals = goals.into_iter().map(inside).collect();
            let maze = Maze::new(walls, inside(start), goals).unwrap();
            let mut mouse =
                Mouse::new(ShortestPathSearch::new(), KnownMaze::unexplored(&maze), maze.start());
            // It plans anew only in cells that it has not seen yet.
            let max_states = u32::try_from((size.area() + 3) * size.area()).unwrap();
            let mut driver = SearchDriver::new(&mut mouse, max_states);
            while driver.advance_in(&maze) == Ok(true) {}
            let (result, stats) = (driver.decision().unwrap(), *driver.stats());
            prop_assert!(stats.steps() + 1 < max_states);
            let cell = maze.start().cell;
            if let Some(shortest) = Distances::flood(maze.walls(), maze.goals()).at(cell) {
                prop_assert_eq!((result, stats.fast_run.steps), (Ok(Move::Stop), shortest.into()));
            } else {
                prop_assert_eq!(mouse.pose().cell, cell);
                prop_assert_eq!(result, Err(SearchError::GoalUnreachable { cell }));
            }
        }
    }
}
