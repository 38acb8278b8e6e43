//! Where states come from: the simulation that is served, or a recording.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use axum::http::StatusCode;
use mmsim_maze::{KnownMaze, Maze, MazeSize};
use mmsim_protocol::{Info, Request, State};
use mmsim_server::{Block, Ending, Monitor, MonitorError, Recording, States, Status, Times};

use crate::api_error::ApiError;
use crate::costs::Costs;

/// Unpacked blocks that are kept of each source: two states and their trails lie in no more.
const KEPT_BLOCKS: usize = 8;

/// How often a run is described anew that is over meanwhile.
const TRIES: usize = 100;

/// The number of the run of every recording.
const RECORDED_RUN: u32 = 0;

/// A source of states, and what of it was looked at lately.
pub(crate) struct Source {
    origin: Origin,
    recent: Mutex<Recent>,
}

enum Origin {
    Live(Monitor),
    Recording { title: String, recording: Box<Recording> },
}

/// What was read of one run.
#[derive(Default)]
struct Recent {
    run: u32,
    described: Option<Arc<Described>>,
    /// The newest last.
    blocks: VecDeque<(usize, Arc<States>)>,
    costs: Costs,
}

/// What stays the same throughout a run.
pub(crate) struct Described {
    pub(crate) title: String,
    pub(crate) info: Info,
    pub(crate) size: MazeSize,
    /// What a mouse knows before the first state.
    pub(crate) unknown: KnownMaze,
    pub(crate) truth: Option<Maze>,
}

impl Described {
    fn new(title: String, info: Info, truth: Option<Maze>) -> Result<Self, ApiError> {
        let unknown = info.known_maze().ok_or_else(|| ApiError::failed("expected a maze"))?;
        Ok(Self { title, size: unknown.size(), info, unknown, truth })
    }

    /// The state in a message, and the map that it tells of.
    pub(crate) fn read<'m>(&self, message: &'m [u8]) -> Result<(State<'m>, KnownMaze), ApiError> {
        match Request::decode(message, self.size) {
            Ok(Request::State(state)) => {
                Ok((state, state.map(self.unknown.start(), *self.unknown.goals())))
            }
            _ => Err(ApiError::failed("expected a state")),
        }
    }
}

impl Source {
    pub(crate) fn live(monitor: Monitor) -> Self {
        Self { origin: Origin::Live(monitor), recent: Mutex::default() }
    }

    pub(crate) fn recording(title: &str, recording: Recording) -> Self {
        let recording = Box::new(recording);
        let origin = Origin::Recording { title: title.into(), recording };
        Self { origin, recent: Mutex::default() }
    }

    /// The run that is there now: its number, of what maze it is, and how many states it has.
    pub(crate) fn now(&self) -> Result<(u32, Arc<Described>, usize), ApiError> {
        let mut over = ApiError::failed("expected a run");
        // It may be over before it is described.
        for _ in 0..TRIES {
            let Status { run, .. } = self.status();
            match self.describe(run).and_then(|described| Ok((run, described, self.states(run)?))) {
                Err(refusal) if refusal.status == StatusCode::GONE => over = refusal,
                result => return result,
            }
        }
        Err(over)
    }

    fn status(&self) -> Status {
        match &self.origin {
            Origin::Live(monitor) => monitor.status(),
            Origin::Recording { recording, .. } => {
                Status { run: RECORDED_RUN, states: recording.history().len() }
            }
        }
    }

    /// How many states a run has by now.
    pub(crate) fn states(&self, run: u32) -> Result<usize, ApiError> {
        let now = self.status();
        if now.run == run {
            Ok(now.states)
        } else {
            Err(MonitorError::RunEnded { run }.into())
        }
    }

    /// Of what maze a run is.
    pub(crate) fn describe(&self, run: u32) -> Result<Arc<Described>, ApiError> {
        if let Some(described) = self.recent(run, |recent| recent.described.clone()) {
            return Ok(described);
        }
        let described = Arc::new(match &self.origin {
            Origin::Live(monitor) => {
                let served = monitor.served()?;
                if served.run != run {
                    return Err(MonitorError::RunEnded { run }.into());
                }
                Described::new(served.info.name.clone(), served.info, Some(served.maze))?
            }
            Origin::Recording { title, recording } => {
                self.states(run)?;
                let (info, truth) = (recording.info().clone(), recording.maze().cloned());
                Described::new(title.clone(), info, truth)?
            }
        });
        self.recent(run, |recent| recent.described = Some(Arc::clone(&described)));
        Ok(described)
    }

    /// How a recording ends.
    pub(crate) fn ending(&self) -> Option<&Ending> {
        match &self.origin {
            Origin::Live(_) => None,
            Origin::Recording { recording, .. } => Some(recording.ending()),
        }
    }

    /// When each state of a run came.
    pub(crate) fn times(&self, run: u32) -> Result<Times, ApiError> {
        match &self.origin {
            Origin::Live(monitor) => Ok(monitor.times(run)?),
            Origin::Recording { recording, .. } => Ok(recording.times().clone()),
        }
    }

    /// The states of a run that lie in one block with this one. Of those that follow it some may be
    /// missing, if the block has grown since it was read.
    pub(crate) fn around(&self, run: u32, index: usize) -> Result<Arc<States>, ApiError> {
        let number = index / Block::STATES;
        let kept = self.recent(run, |recent| {
            let kept = recent.blocks.iter().find(|(kept, _)| *kept == number);
            // The newest block may have grown.
            kept.filter(|(_, states)| states.get(index).is_some()).map(|(_, states)| states.clone())
        });
        if let Some(states) = kept {
            return Ok(states);
        }
        let states = Arc::new(self.read(run, index)?);
        self.recent(run, |recent| {
            recent.blocks.retain(|(kept, _)| *kept != number);
            recent.blocks.push_back((number, Arc::clone(&states)));
            if recent.blocks.len() > KEPT_BLOCKS {
                recent.blocks.pop_front();
            }
        });
        Ok(states)
    }

    /// As [`around`](Self::around), without keeping them.
    pub(crate) fn read(&self, run: u32, index: usize) -> Result<States, ApiError> {
        let number = index / Block::STATES;
        let block = match &self.origin {
            Origin::Live(monitor) => monitor.block(run, number)?,
            Origin::Recording { recording, .. } => recording.history().block(number),
        };
        let states = block.and_then(Block::unpack).filter(|states| states.get(index).is_some());
        states
            .ok_or_else(|| ApiError::not_found(format!("expected a state, found no state {index}")))
    }

    /// Costs over a run as far as they are known.
    pub(crate) fn costs(&self, run: u32) -> Costs {
        self.recent(run, |recent| recent.costs.clone())
    }

    pub(crate) fn keep_costs(&self, run: u32, costs: Costs) {
        self.recent(run, |recent| recent.costs = costs);
    }

    /// What is kept of this run, which is forgotten with the first look at another one.
    fn recent<T>(&self, run: u32, look: impl FnOnce(&mut Recent) -> T) -> T {
        let mut recent = self.recent.lock().unwrap_or_else(PoisonError::into_inner);
        if recent.run != run {
            *recent = Recent { run, ..Recent::default() };
        }
        look(&mut recent)
    }
}
