//! The fast runs that a mouse drives with slalom turns.

use mmsim_fastrun::{FastRun, Side, Turn, TurnKind};
use mmsim_maze::{Cell, Direction};

/// The maximum number of slalom turns of a run. A run with more turns does not count.
const MAX_TURNS: usize = 1000;

/// Follows a mouse that drives from the start cell without turning in place.
#[derive(Clone, Debug)]
pub(crate) struct DrivenRun {
    start: Cell,
    direction: Direction,
    turns: Vec<Turn>,
    /// The number of half steps since the latest turn.
    straight: u8,
    /// False if the mouse has turned in place, or run into a wall, outside the start cell.
    is_driving: bool,
    /// The run since the start, if it has ended in a goal cell.
    latest: Option<FastRun>,
}

impl DrivenRun {
    /// Creates the run of a mouse that has not moved.
    pub(crate) const fn new(start: Cell) -> Self {
        let turns = Vec::new();
        let direction = Direction::North;
        Self { start, direction, turns, straight: 0, is_driving: true, latest: None }
    }

    pub(crate) const fn latest(&self) -> Option<&FastRun> {
        self.latest.as_ref()
    }

    /// Notes that the mouse rests at the centre of the start cell in this direction.
    pub(crate) fn begin(&mut self, direction: Direction) {
        self.turns.clear();
        self.latest = None;
        (self.direction, self.straight, self.is_driving) = (direction, 0, true);
    }

    /// Notes that the mouse has turned in place, or run into a wall, outside the start cell.
    pub(crate) const fn stop(&mut self) {
        self.is_driving = false;
    }

    pub(crate) const fn add_straight(&mut self, half_steps: u8) {
        self.straight = self.straight.saturating_add(half_steps);
    }

    pub(crate) fn add_turn(&mut self, kind: TurnKind, side: Side) {
        self.is_driving &= self.turns.len() < MAX_TURNS;
        if self.is_driving {
            let straight = std::mem::take(&mut self.straight);
            self.turns.push(Turn { straight, kind, side, speed: 0.0 });
        }
    }

    /// Notes that a movement has ended at the centre of a goal cell, along a row or column.
    pub(crate) fn reach_goal(&mut self) {
        if self.is_driving {
            let turns = self.turns.clone();
            self.latest = Some(FastRun::new(self.start, self.direction, turns, self.straight));
        }
    }
}
