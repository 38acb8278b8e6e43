//! The planner, which finds the fastest run, and the reasons why there is none.

// The operations on bit rows and the inner loop of the search must be inlined.
#![allow(clippy::inline_always)]

mod classes;
mod openings;
mod rows;
mod search;
mod tables;
mod targets;

use mmsim_maze::{Cell, CellSet, Direction, MazeSize, Walls};

use crate::run::{FastRun, Turn};
use crate::turn::{Side, TurnKind};
use crate::vehicle::Vehicle;
use rows::Line;
use search::{Finish, Memory, search};
use tables::Tables;
use targets::{Targets, place};

/// Finds the fastest runs of one vehicle. A planner keeps its tables and its memory, so it allocates
/// only when a plan needs more memory than those before.
///
/// ```
/// use mmsim_fastrun::{Planner, Vehicle};
/// use mmsim_maze::{Cell, Heading, MazeSize, Walls};
///
/// let mut planner = Planner::new(Vehicle::ares());
/// let (start, goals) = (Cell::new(0, 0), [Cell::new(0, 5)].into_iter().collect());
/// let mut walls = Walls::open(MazeSize::CLASSIC);
/// let straight = planner.plan(&walls, start, &goals)?.time(&Vehicle::ares())?;
/// walls.set(start, Heading::North, true);
/// let run = planner.plan(&walls, start, &goals)?;
/// assert!(run.time(&Vehicle::ares())? > straight);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Planner {
    vehicle: Vehicle,
    tables: Tables,
    /// For mazes of up to 16×16 cells, and for larger ones.
    targets: [Targets; 2],
    memory: Memory,
    run: FastRun,
}

/// Finds the fastest run from rest in the start cell to rest in a goal cell. If the start is a goal,
/// the run is empty. To plan several runs, use a [`Planner`].
///
/// ```
/// use mmsim_fastrun::{Vehicle, fastest};
/// use mmsim_maze::{Cell, MazeSize, Walls};
/// let walls = Walls::open(MazeSize::CLASSIC);
/// let goals = MazeSize::CLASSIC.central_cells();
/// let run = fastest(&walls, Cell::new(0, 0), &goals, &Vehicle::expert())?;
/// assert!(goals.contains(run.goal().unwrap()));
/// # Ok::<(), mmsim_fastrun::NoRun>(())
/// ```
///
/// # Errors
/// Returns an error if no goal can be reached.
pub fn fastest(
    walls: &Walls,
    start: Cell,
    goals: &CellSet,
    vehicle: &Vehicle,
) -> Result<FastRun, NoRun> {
    Planner::new(vehicle.clone()).plan(walls, start, goals).cloned()
}

/// The planners for mazes of all sizes.
///
/// ```
/// use mmsim_fastrun::{Planners, Vehicle};
/// use mmsim_maze::MazeSize;
/// let name = |planners: &Planners, size| planners.for_size(size).vehicle().name().to_string();
/// let (defaults, own) = (Planners::new(None), Planners::new(Some(Vehicle::ares())));
/// assert_eq!([&defaults, &own].map(|one| name(one, MazeSize::CLASSIC)), ["expert", "ares"]);
/// assert_eq!([&defaults, &own].map(|one| name(one, MazeSize::LARGEST)), ["kerise", "ares"]);
/// ```
#[derive(Clone, Debug)]
pub struct Planners {
    planner: Planner,
    /// The planner for mazes of more than 16 cells in a row or a column, if it is another one.
    for_large: Option<Planner>,
}

impl Planners {
    /// Creates the planner of a vehicle or, without one, those of [`Vehicle::default_for`] each size.
    pub fn new(vehicle: Option<Vehicle>) -> Self {
        let default = |size| Planner::new(Vehicle::default_for(size));
        let for_large = vehicle.is_none().then(|| default(MazeSize::LARGEST));
        let planner = vehicle.map_or_else(|| default(MazeSize::CLASSIC), Planner::new);
        Self { planner, for_large }
    }

    /// Returns the planner for mazes of this size.
    pub fn for_size(&self, size: MazeSize) -> &Planner {
        self.for_large.as_ref().filter(|_| is_large(size)).unwrap_or(&self.planner)
    }

    /// Returns the vehicles of all planners.
    pub fn vehicles(&self) -> impl Iterator<Item = &Vehicle> {
        [&self.planner].into_iter().chain(&self.for_large).map(Planner::vehicle)
    }
}

/// Returns true if a maze has more than 16 cells in a row or a column.
pub(crate) fn is_large(size: MazeSize) -> bool {
    size.width().max(size.height()) > 16
}

impl Planner {
    /// Creates a planner for a vehicle.
    pub fn new(vehicle: Vehicle) -> Self {
        let run = FastRun::new(Cell::new(0, 0), Direction::North, alloc::vec::Vec::new(), 0);
        let targets = [16, 32].map(Targets::new);
        Self { tables: Tables::new(&vehicle), targets, memory: Memory::default(), vehicle, run }
    }

    /// Returns the vehicle.
    pub const fn vehicle(&self) -> &Vehicle {
        &self.vehicle
    }

    /// Finds the fastest run from rest in the start cell to rest in a goal cell.
    ///
    /// # Errors
    /// Returns an error if no goal can be reached.
    pub fn plan(&mut self, walls: &Walls, start: Cell, goals: &CellSet) -> Result<&FastRun, NoRun> {
        let (size, goals) = (walls.size(), NoRun::check(walls.size(), start, goals)?);
        if goals.contains(start) {
            self.run.reset(start, 0);
            return Ok(&self.run);
        }
        let found = if is_large(size) {
            self.search::<u32, 32>(walls, start, &goals)
        } else {
            self.search::<u16, 16>(walls, start, &goals)
        };
        found.map(|()| &self.run).ok_or_else(|| NoRun::find(walls, start, &goals))
    }

    fn search<L: Line, const N: usize>(
        &mut self,
        walls: &Walls,
        start: Cell,
        goals: &CellSet,
    ) -> Option<()> {
        let Finish { mut state, steps, .. } = search::<L, N>(
            &self.tables,
            &self.targets[usize::from(N > 16)],
            &mut self.memory,
            walls,
            start,
            goals,
        )?;
        let state_at = |index: u32| &self.memory.states[index as usize];
        let turns = self.run.reset(start, steps);
        let direction = loop {
            let after = state_at(state);
            let class = &self.tables.classes[usize::from(after.class)];
            let (direction, cell) = place(after.node.into(), N);
            let Some(kind) = class.kind else { break direction };
            let (before, before_cell) = place(state_at(after.parent).node.into(), N);
            let side = if kind == TurnKind::L180 {
                // The line of the second cell lies on the side of the turn.
                let (east, north) = before.turned(2).vector();
                let grows = if east == 0 { cell.1 > before_cell.1 } else { cell.0 > before_cell.0 };
                if grows == (east + north > 0) { Side::Right } else { Side::Left }
            } else if kind.turned(before, Side::Left) == direction {
                Side::Left
            } else {
                Side::Right
            };
            turns.push(Turn { straight: after.steps, kind, side, speed: class.speed });
            state = after.parent;
        };
        turns.reverse();
        self.run.set_direction(direction);
        Some(())
    }
}

/// The reason why there is no run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoRun {
    /// The start is outside the maze.
    #[error("the start at {start} is outside the maze of {size} cells")]
    StartOutside {
        /// The start cell.
        start: Cell,
        /// The size of the maze.
        size: MazeSize,
    },
    /// No goal cell is inside the maze.
    #[error("no goal cell is inside the maze of {size} cells")]
    NoGoal {
        /// The size of the maze.
        size: MazeSize,
    },
    /// The start has walls on all sides.
    #[error("goal unreachable: the start at {start} has walls on all sides")]
    StartEnclosed {
        /// The start cell.
        start: Cell,
    },
    /// The goal has walls on all sides.
    #[error("goal unreachable: walls enclose every goal cell")]
    GoalEnclosed,
    /// Walls separate the goal from the start.
    #[error("goal unreachable from {start}: walls cut off every goal cell")]
    GoalCutOff {
        /// The start cell.
        start: Cell,
    },
}

impl NoRun {
    /// Returns the goals that are inside the maze.
    ///
    /// # Errors
    /// Returns an error if the start or all goals are outside.
    pub(crate) fn check(size: MazeSize, start: Cell, goals: &CellSet) -> Result<CellSet, Self> {
        if !size.contains(start) {
            return Err(Self::StartOutside { start, size });
        }
        let goals: CellSet = goals.iter().filter(|&goal| size.contains(goal)).collect();
        if goals.is_empty() { Err(Self::NoGoal { size }) } else { Ok(goals) }
    }

    /// Returns the reason why no goal can be reached from a start that is no goal.
    pub(crate) fn find(walls: &Walls, start: Cell, goals: &CellSet) -> Self {
        let mut exits = goals.iter().flat_map(|goal| walls.open_neighbours(goal));
        if walls.open_neighbours(start).next().is_none() {
            Self::StartEnclosed { start }
        } else if exits.all(|cell| goals.contains(cell)) {
            Self::GoalEnclosed
        } else {
            Self::GoalCutOff { start }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_planner_can_be_used_for_mazes_of_all_sizes() {
        let mut planner = Planner::new(Vehicle::kerise());
        for side in [32, 5, 16, 17, 1, 32] {
            let size = MazeSize::new(side, side).unwrap();
            let (walls, start) = (Walls::open(size), Cell::new(0, 0));
            let run = planner.plan(&walls, start, &size.central_cells()).unwrap().clone();
            assert_eq!(
                run,
                fastest(&walls, start, &size.central_cells(), &Vehicle::kerise()).unwrap()
            );
            assert_eq!(run.is_empty(), side == 1);
        }
    }

    #[test]
    fn reasons_name_what_is_wrong() {
        let size = MazeSize::new(3, 2).unwrap();
        let (open, closed) = (Walls::open(size), Walls::closed(size));
        let mut planner = Planner::new(Vehicle::ukmars());
        let goals = |x, y| [Cell::new(x, y)].into_iter().collect::<CellSet>();
        let mut reason = |walls: &Walls, start, goals| {
            planner.plan(walls, start, &goals).unwrap_err().to_string()
        };
        let start = Cell::new(0, 0);
        insta::assert_snapshot!(reason(&open, Cell::new(3, 0), goals(0, 1)), @"the start at (3, 0) is outside the maze of 3x2 cells");
        insta::assert_snapshot!(reason(&open, start, goals(0, 2)), @"no goal cell is inside the maze of 3x2 cells");
        insta::assert_snapshot!(reason(&closed, start, goals(2, 1)), @"goal unreachable: the start at (0, 0) has walls on all sides");
        let mut halves = open.clone();
        for (x, y) in [(1, 0), (1, 1)] {
            halves.set(Cell::new(x, y), mmsim_maze::Heading::East, true);
        }
        insta::assert_snapshot!(reason(&halves, start, goals(2, 1)), @"goal unreachable from (0, 0): walls cut off every goal cell");
        halves.set(Cell::new(2, 1), mmsim_maze::Heading::South, true);
        insta::assert_snapshot!(reason(&halves, start, goals(2, 1)), @"goal unreachable: walls enclose every goal cell");
    }
}
