//! The mouse that the page shows: why it runs, why it must stop, and how its runs have ended.

use serde::Serialize;

/// The user's own mouse, which the program that serves the page can run again and again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct OwnMouse {
    /// The name of the mouse, usually the name of its file.
    pub name: String,
    /// True if the mouse has a reset button.
    pub has_reset_button: bool,
}

/// The reason why a run of the user's own mouse starts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StartReason {
    /// The first run of the program.
    First,
    /// The user has asked for another run.
    RunAgain,
    /// The file with this name has changed.
    FileChanged(String),
}

/// The reason why a mouse must stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The user has stopped the mouse.
    Stop,
    /// The user has loaded another maze.
    NewMaze,
    /// The user's own mouse is about to start.
    Restart,
    /// The mouse has reached its time limit.
    TimeLimit,
    /// The program that serves the page is about to exit.
    Exit,
}

impl StopReason {
    /// Returns a description such as `stopped: another maze was loaded`.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Stop => "stopped",
            Self::NewMaze => "stopped: another maze was loaded",
            Self::Restart => "stopped to run again",
            Self::TimeLimit => "stopped: exceeded the time limit",
            Self::Exit => "stopped by Ctrl-C",
        }
    }
}

/// The outcome of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Ending {
    /// The kind of outcome, which the page shows as a colour.
    pub kind: EndingKind,
    /// A description of the outcome, such as `exited with code 0; goal reached, 412 states`.
    pub text: String,
}

/// The kind of outcome of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EndingKind {
    /// The mouse has reached the goal.
    Goal,
    /// The mouse exited or gave up before it reached the goal.
    GaveUp,
    /// The mouse was stopped.
    Stopped,
    /// The mouse did not start, failed or was killed.
    Failed,
}

/// The status of the most recently started mouse.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct MouseStatus {
    pub(crate) name: String,
    /// True if this is the user's own mouse, false if it is a bundled one.
    #[serde(rename = "own")]
    pub(crate) is_own: bool,
    /// Why this run has started, or an empty string.
    pub(crate) reason: String,
    /// The outcome, or `None` while the mouse is running.
    pub(crate) ending: Option<Ending>,
}

impl MouseStatus {
    pub(crate) const fn is_running(&self) -> bool {
        self.ending.is_none()
    }
}
