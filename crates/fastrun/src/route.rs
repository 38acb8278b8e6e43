//! Routes chosen by their cells or turns, and the fastest run along a route.

use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use core::cmp::Reverse;

use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Pose, Walls};

use crate::planner::{NoRun, Planner};
use crate::run::FastRun;

/// A criterion by which a route from the start to a goal is chosen. A route is a list of neighbouring
/// cells without walls between them.
///
/// ```
/// use mmsim_fastrun::Route;
/// use mmsim_maze::Maze;
/// let maze: Maze = "\
/// o---o---o---o
/// |         G |
/// o   o   o---o
/// | S |       |
/// o---o---o---o
/// ".parse()?;
/// let cells = Route::FewestTurns.cells(maze.walls(), maze.start().cell, maze.goals())?;
/// let cells: Vec<_> = cells.iter().map(|cell| (cell.x, cell.y)).collect();
/// assert_eq!(cells, [(0, 0), (0, 1), (1, 1), (2, 1)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Route {
    /// The fewest cells and, among such routes, the fewest quarter turns.
    FewestCells,
    /// The fewest quarter turns and, among such routes, the fewest cells.
    FewestTurns,
}

impl Route {
    /// All criteria.
    pub const ALL: [Self; 2] = [Self::FewestCells, Self::FewestTurns];

    /// Returns the name: `fewest-cells` or `fewest-turns`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FewestCells => "fewest-cells",
            Self::FewestTurns => "fewest-turns",
        }
    }

    /// Returns the cells of the route, beginning with the start and ending with a goal. The mouse may
    /// begin in any direction. If the start is a goal, it is the only cell.
    ///
    /// # Errors
    /// Returns an error if no goal can be reached.
    pub fn cells(self, walls: &Walls, start: Cell, goals: &CellSet) -> Result<Vec<Cell>, NoRun> {
        let goals = NoRun::check(walls.size(), start, goals)?;
        self.dijkstra(walls, start, &goals).ok_or_else(|| NoRun::find(walls, start, &goals))
    }

    /// Finds the route by Dijkstra's algorithm. The states are the poses of the mouse.
    fn dijkstra(self, walls: &Walls, start: Cell, goals: &CellSet) -> Option<Vec<Cell>> {
        let size = walls.size();
        let index = |Pose { cell, heading }: Pose| Some(4 * size.index(cell)? + heading as usize);
        let poses_in = |cell| Heading::ALL.map(|heading| Pose::new(cell, heading));
        let poses: Vec<Pose> = size.cells().flat_map(poses_in).collect();
        let mut least: Vec<Cost> = alloc::vec![[u16::MAX; 2]; poses.len()];
        let mut parents: Vec<Option<usize>> = alloc::vec![None; poses.len()];
        let mut queue = BinaryHeap::new();
        for heading in Heading::ALL {
            let state = index(Pose::new(start, heading))?;
            least[state] = [0, 0];
            queue.push(Reverse((least[state], state)));
        }
        while let Some(Reverse((cost, state))) = queue.pop() {
            let from = poses[state];
            if goals.contains(from.cell) {
                let states = core::iter::successors(Some(state), |&state| parents[state]);
                let mut cells: Vec<Cell> = states.map(|state| poses[state].cell).collect();
                cells.reverse();
                return Some(cells);
            }
            if cost > least[state] {
                continue;
            }
            for heading in Heading::ALL.into_iter().filter(|&side| !walls.has(from.cell, side)) {
                let Some(cell) = from.cell.neighbour(heading) else { continue };
                let turns = quarter_turns(from.heading, heading);
                let next = index(Pose::new(cell, heading))?;
                let cost = match self {
                    Self::FewestCells => [cost[0] + 1, cost[1] + turns],
                    Self::FewestTurns => [cost[0] + turns, cost[1] + 1],
                };
                if cost < least[next] {
                    (least[next], parents[next]) = (cost, Some(state));
                    queue.push(Reverse((cost, next)));
                }
            }
        }
        None
    }
}

/// The number of cells and the number of quarter turns, the more important one first.
type Cost = [u16; 2];

fn quarter_turns(from: Heading, to: Heading) -> u16 {
    [0, 1, 2, 1][(from as usize).abs_diff(to as usize)]
}

impl Planner {
    /// Finds the fastest run along the route that a criterion chooses.
    ///
    /// # Errors
    /// Returns an error if no goal can be reached.
    pub fn plan_route(
        &mut self,
        route: Route,
        walls: &Walls,
        start: Cell,
        goals: &CellSet,
    ) -> Result<&FastRun, NoRun> {
        let cells = route.cells(walls, start, goals)?;
        self.plan_along(walls.size(), &cells)
    }

    /// Finds the fastest run along a route: in a maze in which only the sides between consecutive
    /// cells of the route are open, from the first cell to the last one. If the route enters a cell
    /// several times, the run may skip the cells between.
    ///
    /// ```
    /// use mmsim_fastrun::{Planner, Route, Vehicle};
    /// use mmsim_maze::{Cell, MazeSize, Walls};
    /// let walls = Walls::open(MazeSize::CLASSIC);
    /// let goals = [Cell::new(3, 3)].into_iter().collect();
    /// let route = Route::FewestTurns.cells(&walls, Cell::new(0, 0), &goals)?;
    /// let mut planner = Planner::new(Vehicle::expert());
    /// let run = planner.plan_along(walls.size(), &route)?;
    /// assert_eq!(run.turns().len(), 1);
    /// # Ok::<(), mmsim_fastrun::NoRun>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error if the route is empty, leaves the maze, or contains consecutive cells that are
    /// not neighbours and that no other part of the route connects.
    pub fn plan_along(&mut self, size: MazeSize, route: &[Cell]) -> Result<&FastRun, NoRun> {
        let [start, .., goal] = *route else {
            let goals = route.iter().copied().collect();
            let start = route.first().copied().unwrap_or(Cell::new(0, 0));
            return self.plan(&Walls::closed(size), start, &goals);
        };
        let mut walls = Walls::closed(size);
        for pair in route.windows(2) {
            let is_next = |&heading: &Heading| pair[0].neighbour(heading) == Some(pair[1]);
            if let Some(heading) = Heading::ALL.into_iter().find(is_next) {
                walls.set(pair[0], heading, false);
            }
        }
        self.plan(&walls, start, &[goal].into_iter().collect())
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;
    use proptest::prelude::*;

    use super::*;
    use crate::vehicle::Vehicle;

    /// Returns the numbers of cells and quarter turns of a route without U-turns at its start.
    fn cost(route: &[Cell]) -> (usize, u16) {
        let heading = |pair: &[Cell]| {
            let mut headings = Heading::ALL.into_iter();
            headings.find(|&heading| pair[0].neighbour(heading) == Some(pair[1])).unwrap()
        };
        let headings: Vec<Heading> = route.windows(2).map(heading).collect();
        (route.len(), headings.windows(2).map(|pair| quarter_turns(pair[0], pair[1])).sum())
    }

    /// Adds the costs of all routes that enter no cell twice and begin with `route`.
    fn enumerate(
        walls: &Walls,
        goals: &CellSet,
        route: &mut Vec<Cell>,
        costs: &mut Vec<(usize, u16)>,
    ) {
        let last = route[route.len() - 1];
        if goals.contains(last) {
            return costs.push(cost(route));
        }
        for next in walls.open_neighbours(last) {
            if !route.contains(&next) {
                route.push(next);
                enumerate(walls, goals, route, costs);
                route.pop();
            }
        }
    }

    fn maze(drawing: &str) -> Maze {
        drawing.parse().unwrap()
    }

    fn cells(route: Route, maze: &Maze) -> Vec<(u8, u8)> {
        let cells = route.cells(maze.walls(), maze.start().cell, maze.goals()).unwrap();
        cells.iter().map(|cell| (cell.x, cell.y)).collect()
    }

    #[test]
    fn fewer_turns_may_need_more_cells() {
        let maze = maze(
            "\
o---o---o---o
|           |
o   o---o   o
|       |   |
o   o   o   o
| S |     G |
o---o---o---o
",
        );
        let fewest = [(0, 0), (0, 1), (1, 1), (1, 0), (2, 0)];
        assert_eq!(cells(Route::FewestCells, &maze), fewest);
        let turns = [(0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (2, 1), (2, 0)];
        assert_eq!(cells(Route::FewestTurns, &maze), turns);
    }

    #[test]
    fn a_route_may_begin_in_any_direction() {
        let south = maze("o---o\n| S |\no   o\n|   |\no   o\n| G |\no---o\n");
        for route in Route::ALL {
            assert_eq!(cells(route, &south), [(0, 2), (0, 1), (0, 0)], "{}", route.name());
        }
        let there = maze("o---o\n|SG |\no---o\n");
        assert_eq!(cells(Route::FewestCells, &there), [(0, 0)]);
        let mut planner = Planner::new(Vehicle::ukmars());
        let run = planner.plan_along(there.size(), &[there.start().cell]).unwrap();
        assert!(run.is_empty());
    }

    #[test]
    fn errors_say_why_there_is_no_route() {
        let goals: CellSet = [Cell::new(1, 1)].into_iter().collect();
        let size = MazeSize::new(2, 2).unwrap();
        let mut walls = Walls::closed(size);
        let start = Cell::new(0, 0);
        let route = |walls: &Walls, start, goals: &CellSet| {
            Route::FewestTurns.cells(walls, start, goals).unwrap_err()
        };
        assert_eq!(route(&walls, start, &goals), NoRun::StartEnclosed { start });
        walls.set(start, Heading::East, false);
        assert_eq!(route(&walls, start, &goals), NoRun::GoalEnclosed);
        assert_eq!(route(&walls, start, &CellSet::EMPTY), NoRun::NoGoal { size });
        let outside = Cell::new(2, 0);
        let expected = NoRun::StartOutside { start: outside, size };
        assert_eq!(route(&walls, outside, &goals), expected);
        let mut planner = Planner::new(Vehicle::ukmars());
        assert_eq!(planner.plan_along(size, &[]), Err(NoRun::NoGoal { size }));
        assert_eq!(planner.plan_along(size, &[outside, start]), Err(expected));
        let apart = planner.plan_along(size, &[start, Cell::new(1, 1)]);
        assert_eq!(apart, Err(NoRun::StartEnclosed { start }));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

        #[test]
        fn routes_are_the_least_of_all_and_none_is_faster_than_the_fastest_run(
            (width, height) in (1_usize..=4, 1_usize..=4),
            density in 0.0..0.6,
            rolls in prop::collection::vec(0.0..1.0, 32),
            start in (0_u8..4, 0_u8..4),
            goals in prop::collection::vec((0_u8..4, 0_u8..4), 1..4),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let mut walls = Walls::open(size);
            for (wall, roll) in size.walls().zip(rolls) {
                walls.set(wall.cell, wall.heading, roll < density);
            }
            let inside = |(x, y): (u8, u8)| Cell::new(x % size.width(), y % size.height());
            let (start, goals) = (inside(start), goals.into_iter().map(inside).collect());
            let mut costs = Vec::new();
            enumerate(&walls, &goals, &mut [start].to_vec(), &mut costs);
            let mut planner = Planner::new(Vehicle::ares());
            let fastest = planner.plan(&walls, start, &goals).cloned();
            for route in Route::ALL {
                let found = route.cells(&walls, start, &goals);
                let Ok(found) = found else {
                    prop_assert_eq!(found.err(), fastest.as_ref().err().copied());
                    prop_assert!(costs.is_empty());
                    continue;
                };
                let key = |&(cells, turns): &(usize, u16)| match route {
                    Route::FewestCells => (cells, usize::from(turns)),
                    Route::FewestTurns => (turns.into(), cells),
                };
                prop_assert_eq!(Some(key(&cost(&found))), costs.iter().map(key).min());
                prop_assert!(found[0] == start && goals.contains(found[found.len() - 1]));
                for pair in found.windows(2) {
                    prop_assert!(walls.open_neighbours(pair[0]).any(|next| next == pair[1]));
                }
                let along = planner.plan_route(route, &walls, start, &goals).unwrap();
                prop_assert_eq!(along.cells(), found);
                prop_assert!(along.is_possible(&walls, &goals));
                let time = |run: &FastRun| run.time(&Vehicle::ares()).unwrap();
                prop_assert!(time(along) >= time(fastest.as_ref().unwrap()) - 1e-9);
            }
        }
    }
}
