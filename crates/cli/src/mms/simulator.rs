//! The environment of a mouse: a simulator that reports walls and receives the mouse's states.

use std::time::Duration;

use mmsim_client::{Exchange, RunError, Transport};
use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Pose, WallState};
use mmsim_mms::{Environment, SimulatedMouse};

use super::exit::ExitCause;
use super::stop::Stop;

/// A connection to a simulator. Each wall is requested only once.
pub(crate) struct Simulator<'a, T> {
    exchange: Exchange<T>,
    /// The walls that the simulator has reported.
    reported: KnownMaze,
    stop: &'a Stop<'a>,
    pace: Duration,
    /// A copy of the mouse, made when its state was last sent.
    last: Option<SimulatedMouse>,
}

impl<'a, T: Transport> Simulator<'a, T> {
    /// Resets the simulator, whose maze must have the given size.
    pub(crate) fn new(
        transport: T,
        size: MazeSize,
        stop: &'a Stop<'a>,
        pace: Duration,
    ) -> Result<Self, RunError> {
        let mut exchange = Exchange::new(transport);
        exchange.reset()?;
        let reported = KnownMaze::new(size, Cell::new(0, 0), CellSet::EMPTY);
        Ok(Self { exchange, reported, stop, pace, last: None })
    }

    /// Sends the mouse's state if it has changed.
    pub(crate) fn update(&mut self, mouse: &SimulatedMouse) -> Result<(), ExitCause> {
        let is_sent = self.last.as_ref().is_some_and(|last| is_same_state(last, mouse));
        if is_sent { Ok(()) } else { self.send(mouse) }
    }

    fn send(&mut self, mouse: &SimulatedMouse) -> Result<(), ExitCause> {
        let number = |cell| mouse.number(cell);
        self.exchange.state(mouse.pose(), mouse.map(), number).map_err(ExitCause::LostSimulator)?;
        self.last = Some(mouse.clone());
        Ok(())
    }
}

impl<T: Transport> Environment for Simulator<'_, T> {
    type Error = ExitCause;

    fn has_wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, ExitCause> {
        match self.reported.wall(cell, heading) {
            WallState::Present => Ok(true),
            WallState::Absent => Ok(false),
            WallState::Unknown => {
                let pose = Pose::new(cell, heading);
                let around = self.exchange.walls(pose).map_err(ExitCause::LostSimulator)?;
                let size = self.reported.size();
                self.reported.observe(pose, around).map_err(|error| {
                    ExitCause::LostSimulator(RunError::from_contradiction(error, size))
                })?;
                Ok(around.front)
            }
        }
    }

    fn on_pose_change(&mut self, mouse: &SimulatedMouse) -> Result<(), ExitCause> {
        self.send(mouse)?;
        self.stop.wait(self.pace)
    }
}

fn is_same_state(one: &SimulatedMouse, other: &SimulatedMouse) -> bool {
    let mut cells = one.map().size().cells();
    one.pose() == other.pose()
        && one.map() == other.map()
        && cells.all(|cell| one.number(cell) == other.number(cell))
}
