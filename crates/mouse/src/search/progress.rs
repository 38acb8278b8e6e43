//! The progress of a search, which its threads share.

use std::process::ExitStatus;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use mmsim_maze::Pose;
use mmsim_run::Judge;

/// How a mouse communicates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MouseKind {
    /// It writes the commands of mms to its stdout.
    Mms,
    /// It sends requests over ZeroMQ.
    Client,
}

/// Why a search has ended.
#[derive(Clone, Debug)]
pub enum SearchEnd {
    /// The mouse has exited. The text is the last line of its stderr if it has failed.
    Exited(ExitStatus, String),
    /// The mouse does not move after it has reached the goal.
    Idle,
    /// The mouse has reached the time limit.
    TimeLimit,
    /// The mouse has reached the limit of poses.
    StepLimit,
    /// The mouse has written [`MAX_INVALID_BYTES`](crate::MAX_INVALID_BYTES) without a command.
    Flood,
    /// The caller has interrupted the search.
    Interrupted,
    /// The mouse could not start or could not go on.
    Failed(String),
}

/// The progress of a search.
pub(super) struct SearchProgress {
    /// `None` once the search is over.
    pub(super) judge: Option<Judge>,
    /// `None` until the mouse has sent a command or a request.
    pub(super) kind: Option<MouseKind>,
    /// The latest invalid line or refused request.
    pub(super) fault: Option<String>,
    /// The number of poses.
    pub(super) states: u32,
    max_states: u32,
    /// The number of commands and requests.
    pub(super) messages: u64,
    pub(super) moved: Instant,
    pub(super) has_output_ended: bool,
    /// The reason why the search must end.
    pub(super) end: Option<SearchEnd>,
    /// Wakes the thread that waits for the end of the search.
    wake: Sender<()>,
}

/// The progress of a search, shared by its threads.
pub(super) type SharedProgress = Arc<Mutex<SearchProgress>>;

impl SearchProgress {
    /// Returns the progress of a search that begins. `wake` is notified when the output or the search
    /// ends.
    pub(super) fn new(judge: Judge, max_states: u32, wake: Sender<()>) -> Self {
        Self {
            judge: Some(judge),
            kind: None,
            fault: None,
            states: 0,
            max_states,
            messages: 0,
            moved: Instant::now(),
            has_output_ended: false,
            end: None,
            wake,
        }
    }

    /// Notes a command or a request. Returns `None` if it must be ignored, because the search is over
    /// or because the mouse uses the other protocol.
    pub(super) fn accept(&mut self, kind: MouseKind) -> Option<&mut Judge> {
        self.messages += 1;
        let is_accepted = self.end.is_none() && *self.kind.get_or_insert(kind) == kind;
        self.judge.as_mut().filter(|_| is_accepted)
    }

    /// Adds a pose. Returns false if the search is over.
    pub(super) fn add(&mut self, pose: Pose, is_restart: bool) -> bool {
        match &mut self.judge {
            Some(judge) if self.states < self.max_states => judge.add(pose, is_restart),
            _ => {
                self.end(SearchEnd::StepLimit);
                return false;
            }
        }
        self.states += 1;
        self.moved = Instant::now();
        true
    }

    /// Ends the search, unless it must already end for another reason.
    pub(super) fn end(&mut self, reason: SearchEnd) {
        self.end.get_or_insert(reason);
        self.wake();
    }

    pub(super) fn end_output(&mut self) {
        self.has_output_ended = true;
        self.wake();
    }

    fn wake(&self) {
        // The receiver exists as long as the search.
        let _ = self.wake.send(());
    }
}
