//! The environment of a mouse: a simulator that reports walls and receives the mouse's states.

use std::mem;
use std::time::{Duration, Instant};

use mmsim_client::{Exchange, RunError, Transport};
use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Pose, WallState};
use mmsim_mms::{Environment, SimulatedMouse};
use mmsim_protocol::Annotation;
use mmsim_viewer::MouseControl;

use super::annotations::changes;
use super::exit::ExitCause;
use super::log::MouseLog;

/// The interval between two checks whether a mouse that does not move displays something new. A
/// viewer does not notice a delay of up to two intervals.
const CHECK_INTERVAL: Duration = Duration::from_millis(100);

/// A connection to a simulator. Each wall is requested only once.
pub(crate) struct Simulator<'a, T> {
    exchange: Exchange<T>,
    /// The walls that the simulator has reported.
    reported: KnownMaze,
    control: &'a MouseControl,
    /// A copy of the mouse, made when its state was last sent.
    last: Option<SimulatedMouse>,
    annotator: Option<Annotator>,
    /// True if the mouse was put back at the start after its state was last sent.
    is_restart: bool,
    /// The time of the latest check for changes.
    checked: Instant,
    /// True if the latest check has found changes that have not been sent.
    has_changes: bool,
}

/// The annotations that a simulator has not received yet.
pub(crate) struct Annotator {
    /// The name of the mouse.
    pub(crate) name: String,
    pub(crate) log: MouseLog,
}

impl<'a, T: Transport> Simulator<'a, T> {
    /// Resets the simulator, whose maze must have the given size. A simulator that does not accept
    /// annotations must have no annotator.
    pub(crate) fn new(
        transport: T,
        size: MazeSize,
        control: &'a MouseControl,
        annotator: Option<Annotator>,
    ) -> Result<Self, RunError> {
        let mut exchange = Exchange::new(transport);
        exchange.reset()?;
        let reported = KnownMaze::new(size, Cell::new(0, 0), CellSet::EMPTY);
        Ok(Self {
            exchange,
            reported,
            control,
            last: None,
            annotator,
            is_restart: false,
            checked: Instant::now(),
            has_changes: false,
        })
    }

    /// Waits for the last lines of the log of a mouse that has exited.
    pub(crate) fn end_log(&self) {
        if let Some(annotator) = &self.annotator {
            annotator.log.wait_for_end();
        }
    }

    /// Sends the mouse's state if the state or its annotations have changed.
    pub(crate) fn update(&mut self, mouse: &SimulatedMouse) -> Result<(), ExitCause> {
        let lines = self.take_lines();
        if self.is_sent(mouse) && lines.is_empty() { Ok(()) } else { self.send(mouse, &lines) }
    }

    /// Sends the state of a mouse that does not move, if the mouse or its log has changed. Must be
    /// called repeatedly. A change is sent only if it was found at the previous check too, so a mouse
    /// that is about to move has time to finish what it displays.
    pub(crate) fn show_changes(&mut self, mouse: &SimulatedMouse) -> Result<(), ExitCause> {
        if self.checked.elapsed() < CHECK_INTERVAL {
            return Ok(());
        }
        self.checked = Instant::now();
        let has_lines = self.annotator.as_ref().is_some_and(|annotator| !annotator.log.is_empty());
        let has_changes = has_lines || !self.is_sent(mouse);
        let is_second_time = mem::replace(&mut self.has_changes, has_changes);
        if has_changes && is_second_time { self.update(mouse) } else { Ok(()) }
    }

    fn is_sent(&self, mouse: &SimulatedMouse) -> bool {
        self.last.as_ref().is_some_and(|last| is_same_state(last, mouse))
    }

    /// Adds a message of this process to the log of the mouse.
    pub(crate) fn add_to_log(&self, message: &str) {
        if let Some(annotator) = &self.annotator {
            annotator.log.add(message);
        }
    }

    /// Takes the lines that the mouse has written to its log.
    fn take_lines(&self) -> Vec<String> {
        self.annotator.as_ref().map(|annotator| annotator.log.take()).unwrap_or_default()
    }

    fn send(&mut self, mouse: &SimulatedMouse, lines: &[String]) -> Result<(), ExitCause> {
        self.try_send(mouse, lines).map_err(ExitCause::LostSimulator)?;
        self.last = Some(mouse.clone());
        self.has_changes = false;
        Ok(())
    }

    fn try_send(&mut self, mouse: &SimulatedMouse, lines: &[String]) -> Result<(), RunError> {
        if let Some(annotator) = &self.annotator {
            let name = self.last.is_none().then_some(Annotation::Mouse(&annotator.name));
            let restart = mem::take(&mut self.is_restart).then_some(Annotation::Restart);
            let changes = changes(self.last.as_ref(), mouse);
            let lines = lines.iter().map(|line| Annotation::Log(line));
            self.exchange.annotate(name.into_iter().chain(restart).chain(changes).chain(lines))?;
        }
        let number = |cell| mouse.display().text(cell).number();
        self.exchange.state(mouse.pose(), mouse.map(), number)
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
        let lines = self.take_lines();
        self.send(mouse, &lines)?;
        if self.control.throttle().wait() { ExitCause::check(self.control) } else { Ok(()) }
    }

    fn on_restart(&mut self, mouse: &SimulatedMouse) -> Result<(), ExitCause> {
        self.is_restart = true;
        self.on_pose_change(mouse)
    }
}

fn is_same_state(one: &SimulatedMouse, other: &SimulatedMouse) -> bool {
    one.pose() == other.pose() && one.map() == other.map() && one.display() == other.display()
}
