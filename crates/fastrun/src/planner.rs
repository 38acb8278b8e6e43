//! The planner, which finds the fastest run.

mod openings;
mod rows;
mod search;
mod tables;
mod targets;

use mmsim_maze::{Cell, CellSet, MazeSize, Walls};

use crate::lattice::Direction;
use crate::run::{FastRun, Turn};
use crate::turn::{Side, TurnKind};
use crate::vehicle::Vehicle;
use rows::Line;
use search::{Finish, Memory, search};
use tables::Tables;
use targets::Targets;

/// Finds the fastest runs of one vehicle. A planner keeps its tables and its memory, so further
/// plans allocate nothing.
#[derive(Clone, Debug)]
pub struct Planner {
    vehicle: Vehicle,
    tables: Tables,
    /// For mazes of up to 16×16 cells, and for larger ones.
    targets: [Targets; 2],
    memory: Memory,
    run: FastRun,
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
    /// Walls separate the goal from the start.
    #[error("goal unreachable from {start}: walls cut off every goal cell")]
    GoalCutOff {
        /// The start cell.
        start: Cell,
    },
}

/// Finds the fastest run from rest in the start cell to rest in a goal cell. If the start is a goal,
/// the run is empty. To plan several runs, use a [`Planner`].
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

impl Planner {
    /// Creates a planner for a vehicle.
    pub fn new(vehicle: Vehicle) -> Self {
        let run = FastRun::new(Cell::new(0, 0), Direction::North, alloc::vec::Vec::new(), 0);
        let targets = [16, 32].map(Targets::new);
        Self { tables: Tables::new(&vehicle), targets, memory: Memory::default(), vehicle, run }
    }

    /// DEBUG
    pub fn debug(&self) -> [usize; 5] {
        self.memory.debug(&self.tables)
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
        let size = walls.size();
        if !size.contains(start) {
            return Err(NoRun::StartOutside { start, size });
        }
        let goals = *goals & size.cells().collect();
        if goals.is_empty() {
            return Err(NoRun::NoGoal { size });
        }
        if goals.contains(start) {
            self.run.reset(start, 0);
            return Ok(&self.run);
        }
        let is_small = size.width().max(size.height()) <= 16;
        let found = if is_small {
            self.search::<u16, 16>(walls, start, &goals)
        } else {
            self.search::<u32, 32>(walls, start, &goals)
        };
        found.map(|()| &self.run).ok_or_else(|| no_run(walls, start))
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
            let (direction, cell) = after.place::<N>();
            let Some(kind) = class.kind else { break direction };
            let (before, before_cell) = state_at(after.parent).place::<N>();
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

fn no_run(walls: &Walls, start: Cell) -> NoRun {
    if walls.open_neighbours(start).next().is_none() {
        NoRun::StartEnclosed { start }
    } else {
        NoRun::GoalCutOff { start }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::naive::dijkstra;

    /// Generates walls of a maze of any size with some density, a start and goals.
    fn any_maze() -> impl Strategy<Value = (Walls, Cell, CellSet)> {
        let size = prop_oneof![
            (1usize..=8, 1usize..=8),
            (1usize..=16, 1usize..=16),
            (1usize..=32, 1usize..=32)
        ];
        let bits = || prop::collection::vec(any::<[u32; 3]>(), 32);
        (
            size,
            bits(),
            bits(),
            0..4,
            any::<(u8, u8)>(),
            prop::collection::vec(any::<(u8, u8)>(), 1..5),
        )
            .prop_map(|((width, height), north, east, density, start, goals)| {
                let size = MazeSize::new(width, height).unwrap();
                let rows = |rows: Vec<[u32; 3]>| {
                    let row = |[a, b, c]: &[u32; 3]| match density {
                        0 => a & b & c,
                        1 => a & b,
                        2 => a & (b | c),
                        _ => *a,
                    };
                    core::array::from_fn(|y| row(&rows[y]))
                };
                let cell = |(x, y): (u8, u8)| Cell::new(x % size.width(), y % size.height());
                let walls = Walls::from_rows(size, rows(north), rows(east));
                (walls, cell(start), goals.into_iter().map(cell).collect())
            })
    }

    proptest! {
        #[test]
        fn plans_are_as_fast_as_those_of_the_naive_twin((walls, start, goals) in any_maze()) {
            for name in Vehicle::PRESETS {
                let vehicle = Vehicle::preset(name).unwrap();
                let expected = dijkstra(&walls, start, &goals, &vehicle);
                let found = fastest(&walls, start, &goals, &vehicle);
                prop_assert_eq!(found.is_ok(), expected.is_some());
                let (Ok(found), Some((twin, expected))) = (found, expected) else { continue };
                prop_assert!(found.is_possible(&walls, &goals), "{}", found);
                let time = found.time(&vehicle).unwrap();
                prop_assert!((twin.time(&vehicle).unwrap() - expected).abs() < 1e-9);
                prop_assert!((time - expected).abs() < 1e-5, "{}: {} {}, {} {}", name, time, found, expected, twin);
            }
        }
    }
}
