//! The simulator as what is around a mouse: it tells walls, and is told where the mouse is.

use std::time::Duration;

use mmsim_client::{Exchange, RunError, Transport};
use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Pose, WallState};
use mmsim_mms::{Environment, SimulatedMouse};

use crate::interrupt::Interrupt;

/// Why a mouse is stopped.
#[derive(Debug)]
pub(crate) enum Stop {
    Interrupted,
    Failed(RunError),
}

/// A simulator, asked for each wall once.
pub(crate) struct Simulator<'a, T> {
    exchange: Exchange<T>,
    /// The walls that it has told.
    told: KnownMaze,
    interrupt: &'a Interrupt,
    pace: Duration,
    /// The mouse as it was told last.
    last: Option<SimulatedMouse>,
}

impl<'a, T: Transport> Simulator<'a, T> {
    /// A simulator of a maze of this size, which forgets all states.
    pub(crate) fn begin(
        transport: T,
        size: MazeSize,
        interrupt: &'a Interrupt,
        pace: Duration,
    ) -> Result<Self, RunError> {
        let mut exchange = Exchange::new(transport);
        exchange.reset()?;
        let told = KnownMaze::new(size, Cell::new(0, 0), CellSet::EMPTY);
        Ok(Self { exchange, told, interrupt, pace, last: None })
    }

    /// Tells where the mouse is and what it shows, if that was not told last.
    pub(crate) fn tell(&mut self, mouse: &SimulatedMouse) -> Result<(), Stop> {
        let is_told = self.last.as_ref().is_some_and(|last| shows_the_same(last, mouse));
        if is_told { Ok(()) } else { self.tell_again(mouse) }
    }

    fn tell_again(&mut self, mouse: &SimulatedMouse) -> Result<(), Stop> {
        let number = |cell| mouse.number(cell);
        self.exchange.state(mouse.pose(), mouse.map(), number).map_err(Stop::Failed)?;
        self.last = Some(mouse.clone());
        Ok(())
    }
}

impl<T: Transport> Environment for Simulator<'_, T> {
    type Error = Stop;

    fn has_wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, Stop> {
        match self.told.wall(cell, heading) {
            WallState::Present => Ok(true),
            WallState::Absent => Ok(false),
            WallState::Unknown => {
                let pose = Pose::new(cell, heading);
                let around = self.exchange.walls(pose).map_err(Stop::Failed)?;
                let size = self.told.size();
                self.told
                    .observe(pose, around)
                    .map_err(|error| Stop::Failed(RunError::from_contradiction(error, size)))?;
                Ok(around.front)
            }
        }
    }

    fn on_pose_change(&mut self, mouse: &SimulatedMouse) -> Result<(), Stop> {
        self.tell_again(mouse)?;
        if self.interrupt.wait_for(self.pace) { Err(Stop::Interrupted) } else { Ok(()) }
    }
}

fn shows_the_same(one: &SimulatedMouse, other: &SimulatedMouse) -> bool {
    let mut cells = one.map().size().cells();
    one.pose() == other.pose()
        && one.map() == other.map()
        && cells.all(|cell| one.number(cell) == other.number(cell))
}
