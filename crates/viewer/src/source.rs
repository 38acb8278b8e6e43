//! Sources of states: the live simulation and recordings.

pub(crate) mod fast_runs;
pub(crate) mod pictures;
pub(crate) mod recordings;
pub(crate) mod search;
pub(crate) mod views;

use std::collections::VecDeque;
use std::ops::RangeInclusive;
use std::sync::{Arc, Mutex, PoisonError};

use axum::http::StatusCode;
use mmsim_fastrun::{Planner, Vehicle};
use mmsim_maze::{KnownMaze, Maze, MazeSize};
use mmsim_protocol::{Info, State};
use mmsim_recording::{
    Block, Context, Integrity, LogEnd, LogLine, Recording, States, Times, TrailingAnnotations,
    read_log,
};
use mmsim_run::{
    BoundsHistory, Cause, END_FACTS, EndFacts, EventFinder, Judge, MovementRules, Phases,
    RunEvents, RunIndex, SearchFigures, SearchTimes, Trail, Verdict, bounds, trial_status,
};
use mmsim_server::{Monitor, MonitorError, Status};
use serde::Serialize;

use crate::http::jobs::{ApiError, ApiResult, CancelToken};

/// The maximum number of decompressed blocks that a source caches. Each page shows
/// a state of one block.
const CACHED_BLOCKS: usize = 8;

/// The maximum memory of the cached blocks, in bytes. Blocks are this large only if they contain
/// many log lines. The newest block is cached whatever its size.
const MAX_CACHED_BYTES: usize = 16 << 20;

/// The maximum number of attempts to describe the current run. An attempt fails if the run ends
/// before the attempt is complete.
const MAX_ATTEMPTS: usize = 100;

/// The maximum number of states from which a trail is computed in a few milliseconds.
const MAX_TRAIL_STATES: usize = 16 * Block::STATES;

/// The run number of the only run in a recording.
const RECORDED_RUN: u32 = 0;

/// What a mouse has achieved. The field names are JSON keys.
#[derive(Serialize)]
pub(crate) struct RunResult {
    #[serde(flatten)]
    figures: SearchFigures,
    repeated_steps: usize,
    /// The number of steps after which the fastest run was proven, or `None`.
    steps_until_fastest_run_proven: Option<u32>,
    /// The name of the vehicle of the times.
    vehicle: String,
    #[serde(flatten)]
    times: SearchTimes,
    cause: Option<Cause>,
}

/// A source of states with a cache of recently read data.
pub(crate) struct StateSource {
    kind: SourceKind,
    cache: Mutex<RunCache>,
}

enum SourceKind {
    Live(Monitor),
    Recording { title: String, recording: Box<Recording> },
}

/// The cached data of one run.
#[derive(Default)]
struct RunCache {
    run: u32,
    description: Option<Arc<RunDescription>>,
    /// The cached blocks, in the order in which they were read.
    blocks: VecDeque<Arc<States>>,
    bounds: BoundsHistory,
    events: Option<Arc<Mutex<EventFinder>>>,
    /// The times of the states, which may be older than the newest state.
    times: Times,
    /// The number of states whose log was searched for driven runs, and the states of their lines.
    driven: (usize, Vec<usize>),
    index: Option<Arc<RunIndex>>,
}

/// The constant properties of a run.
pub(crate) struct RunDescription {
    pub(crate) title: String,
    pub(crate) info: Info,
    pub(crate) size: MazeSize,
    /// The map that a mouse has before the first state.
    pub(crate) unexplored: KnownMaze,
    pub(crate) truth: Option<Maze>,
}

/// A decoded state message.
pub(crate) struct DecodedState<'a> {
    pub(crate) message: &'a [u8],
    pub(crate) state: State<'a>,
    /// The map that the client claims to know.
    pub(crate) map: KnownMaze,
    /// The walls that the client knows. See `Context::known_maze` in `mmsim-recording`.
    pub(crate) known: KnownMaze,
    /// The walls that the client has read, and what the mouse displays.
    pub(crate) context: Context,
    /// True if the state belongs to a two-run trial.
    pub(crate) is_trial: bool,
}

fn undecodable(index: usize) -> ApiError {
    ApiError::internal(format!("cannot decode state {index}"))
}

/// Removes the oldest blocks until the others are within the limits of the cache.
fn evict(blocks: &mut VecDeque<Arc<States>>) {
    let mut bytes: usize = blocks.iter().map(|states| states.memory()).sum();
    while blocks.len() > 1 && (blocks.len() > CACHED_BLOCKS || bytes > MAX_CACHED_BYTES) {
        bytes -= blocks.pop_front().map_or(0, |states| states.memory());
    }
}

impl RunDescription {
    pub(crate) fn new(title: String, info: Info, truth: Option<Maze>) -> ApiResult<Self> {
        let invalid = || ApiError::internal("the description of the maze is invalid");
        let unexplored = info.known_maze().ok_or_else(invalid)?;
        Ok(Self { title, size: unexplored.size(), info, unexplored, truth })
    }

    /// Decodes a state of this run, with the annotations after it if it is the last state.
    pub(crate) fn decode<'a>(
        &self,
        states: &'a States,
        index: usize,
        trailing: &TrailingAnnotations,
    ) -> ApiResult<DecodedState<'a>> {
        let failed = || undecodable(index);
        let message = states.get(index).unwrap_or_default();
        let state = State::decode(message, self.size).map_err(|_| failed())?;
        let mut context = states.context(index).ok_or_else(failed)?;
        context.annotate(trailing);
        let map = context.claimed_maze(&state, &self.unexplored);
        let known = context.known_maze(&state, &self.unexplored, self.truth.as_ref());
        let is_trial = trial_status(context.notes()).is_some();
        Ok(DecodedState { message, state, map, known, context, is_trial })
    }
}

impl StateSource {
    pub(crate) fn live(monitor: Monitor) -> Self {
        Self { kind: SourceKind::Live(monitor), cache: Mutex::default() }
    }

    pub(crate) fn recording(title: &str, recording: Recording) -> Self {
        let recording = Box::new(recording);
        let kind = SourceKind::Recording { title: title.into(), recording };
        Self { kind, cache: Mutex::default() }
    }

    /// Returns the run number, the description and the number of states of the current run.
    pub(crate) fn current_run(&self) -> ApiResult<(u32, Arc<RunDescription>, usize)> {
        let mut attempts = 1;
        loop {
            let Status { run, .. } = self.status();
            let current = self.describe(run).and_then(|it| Ok((run, it, self.states(run)?)));
            match current {
                // The run has ended in the meantime.
                Err(error) if error.status == StatusCode::GONE && attempts < MAX_ATTEMPTS => {
                    attempts += 1;
                }
                result => return result,
            }
        }
    }

    fn status(&self) -> Status {
        match &self.kind {
            SourceKind::Live(monitor) => monitor.status(),
            SourceKind::Recording { recording, .. } => {
                Status { run: RECORDED_RUN, states: recording.history().len() }
            }
        }
    }

    /// Returns the current number of states of a run.
    pub(crate) fn states(&self, run: u32) -> ApiResult<usize> {
        let status = self.status();
        if status.run == run {
            Ok(status.states)
        } else {
            Err(MonitorError::RunEnded { run }.into())
        }
    }

    pub(crate) fn describe(&self, run: u32) -> ApiResult<Arc<RunDescription>> {
        if let Some(description) = self.cache(run, |cache| cache.description.clone()) {
            return Ok(description);
        }
        let description = Arc::new(match &self.kind {
            SourceKind::Live(monitor) => {
                let served = monitor.served()?;
                if served.run != run {
                    return Err(MonitorError::RunEnded { run }.into());
                }
                RunDescription::new(served.info.maze.clone(), served.info, Some(served.maze))?
            }
            SourceKind::Recording { title, recording } => {
                self.states(run)?;
                let (info, truth) = (recording.info().clone(), recording.maze().cloned());
                RunDescription::new(title.clone(), info, truth)?
            }
        });
        self.cache(run, |cache| cache.description = Some(Arc::clone(&description)));
        Ok(description)
    }

    /// Returns the integrity of a recording, or `None` for the live simulation.
    pub(crate) fn integrity(&self) -> Option<&Integrity> {
        match &self.kind {
            SourceKind::Live(_) => None,
            SourceKind::Recording { recording, .. } => Some(recording.integrity()),
        }
    }

    /// Returns the time of each state of a run.
    pub(crate) fn times(&self, run: u32) -> ApiResult<Times> {
        match &self.kind {
            SourceKind::Live(monitor) => Ok(monitor.times(run)?),
            SourceKind::Recording { recording, .. } => Ok(recording.times().clone()),
        }
    }

    /// Returns the times of a run at least up to a state, from the cache if possible.
    pub(crate) fn times_to(&self, run: u32, index: usize) -> ApiResult<Times> {
        let cached =
            |cache: &mut RunCache| (cache.times.len() > index).then(|| cache.times.clone());
        if let Some(times) = self.cache(run, cached) {
            return Ok(times);
        }
        let times = self.times(run)?;
        self.cache(run, |cache| cache.times = times.clone());
        Ok(times)
    }

    /// Returns the block that contains a state, from the cache if possible. Replaces a cached copy
    /// of the newest block if the copy does not contain the state yet.
    pub(crate) fn block(&self, run: u32, index: usize) -> ApiResult<Arc<States>> {
        if let Some(states) = self.cached_block(run, index) {
            return Ok(states);
        }
        let states = Arc::new(self.read_block(run, index)?);
        let first = index - index % Block::STATES;
        self.cache(run, |cache| {
            // Remove an older copy of the block, which may have grown since.
            cache.blocks.retain(|cached| cached.get(first).is_none());
            cache.blocks.push_back(Arc::clone(&states));
            evict(&mut cache.blocks);
        });
        Ok(states)
    }

    fn cached_block(&self, run: u32, index: usize) -> Option<Arc<States>> {
        let has_state = |states: &&Arc<States>| states.get(index).is_some();
        self.cache(run, |cache| cache.blocks.iter().find(has_state).cloned())
    }

    /// Returns the block that contains a state, from the cache if possible. Unlike with
    /// [`block`](Self::block), a block that is not cached does not replace cached blocks.
    pub(crate) fn peek_block(&self, run: u32, index: usize) -> ApiResult<Arc<States>> {
        match self.cached_block(run, index) {
            Some(states) => Ok(states),
            None => self.read_block(run, index).map(Arc::new),
        }
    }

    /// Returns the block that contains a state, bypassing the cache.
    pub(crate) fn read_block(&self, run: u32, index: usize) -> ApiResult<States> {
        let number = index / Block::STATES;
        let block = match &self.kind {
            SourceKind::Live(monitor) => monitor.block(run, number)?,
            SourceKind::Recording { recording, .. } => recording.history().block(number),
        };
        let states = block.and_then(Block::unpack).filter(|states| states.get(index).is_some());
        states.ok_or_else(|| ApiError::not_found(format!("state {index} does not exist")))
    }

    /// Returns the annotations after the last state if the state with this index is the last one, or
    /// else none.
    pub(crate) fn trailing(&self, run: u32, index: usize) -> ApiResult<TrailingAnnotations> {
        let states = index + 1;
        if self.status() != (Status { run, states }) {
            return Ok(TrailingAnnotations::default());
        }
        match &self.kind {
            SourceKind::Live(monitor) => Ok(monitor.trailing(run, states)?),
            SourceKind::Recording { recording, .. } => Ok(recording.trailing().clone()),
        }
    }

    /// Returns the number of requests with annotations that a live simulation has answered.
    pub(crate) fn annotations(&self) -> Option<u64> {
        match &self.kind {
            SourceKind::Live(monitor) => Some(monitor.annotations()),
            SourceKind::Recording { .. } => None,
        }
    }

    /// Returns the context after the last of `states` states, or `None` if there is none or the run has ended.
    pub(crate) fn last_context(&self, run: u32, states: usize) -> Option<Context> {
        let last = states.checked_sub(1)?;
        let mut context = self.block(run, last).ok()?.context(last)?;
        context.annotate(&self.trailing(run, last).ok()?);
        Some(context)
    }

    /// Returns the bounds at sampled states of a run, and caches them.
    pub(crate) fn bounds(&self, run: u32, cancel: &CancelToken) -> ApiResult<BoundsHistory> {
        let (description, states) = (self.describe(run)?, self.states(run)?);
        let mut history = self.cache(run, |cache| cache.bounds.clone());
        history.extend(states, |index| {
            cancel.check()?;
            let block = self.read_block(run, index)?;
            let decoded = description.decode(&block, index, &TrailingAnnotations::default())?;
            Ok::<_, ApiError>(bounds(&decoded.known, decoded.is_trial))
        })?;
        self.cache(run, |cache| cache.bounds = history.clone());
        Ok(history)
    }

    /// Returns the events of a run. Reads only the states that have not been read before.
    pub(crate) fn events(&self, run: u32, cancel: &CancelToken) -> ApiResult<RunEvents> {
        let (description, states) = (self.describe(run)?, self.states(run)?);
        let RunDescription { unexplored, truth, .. } = &*description;
        let new = || Arc::new(Mutex::new(EventFinder::new(unexplored, truth.as_ref())));
        let finder = self.cache(run, |cache| Arc::clone(cache.events.get_or_insert_with(new)));
        loop {
            cancel.check()?;
            // Several requests can read the blocks of a long run in turn.
            let mut finder = finder.lock().unwrap_or_else(PoisonError::into_inner);
            if finder.states() >= states {
                return Ok(finder.events());
            }
            let block = self.read_block(run, finder.states())?;
            finder.extend(&block).map_err(undecodable)?;
        }
    }

    /// Returns the result of the search so far with the times of a vehicle, or `None` if the true maze is
    /// unknown.
    pub(crate) fn result(
        &self,
        run: u32,
        vehicle: Vehicle,
        cancel: &CancelToken,
    ) -> ApiResult<Option<RunResult>> {
        let (description, states) = (self.describe(run)?, self.states(run)?);
        let Some(maze) = &description.truth else { return Ok(None) };
        let mut failure = Ok(());
        let mut read = |first| {
            let read = cancel.check().and_then(|()| self.read_block(run, first));
            read.map_err(|error| failure = Err(error)).ok()
        };
        let blocks = (0..states).step_by(Block::STATES).map_while(&mut read);
        let mut judge = Judge::from_blocks(maze, blocks, &[], false);
        failure?;
        let is_facts = |line: &str| line.starts_with(END_FACTS);
        let line = self.log(run, &(states..=states), LogEnd::Last, 1, cancel, is_facts)?.pop();
        let facts = line.and_then(|line| EndFacts::from_log_line(&line.text));
        let cause = facts.and_then(|facts| judge.cause(&facts));
        let mut figures = judge.figures();
        if let Some(facts) = facts {
            let verdict = Verdict::new(judge.phases(), facts.ending, None, cause);
            figures = figures.with_verdict(verdict);
            // The goal was not reached, as the result says beside the cause.
            figures.error = cause.map(|cause| cause.to_string()).or(figures.error);
        }
        if figures.fast_run_steps.is_some() {
            let driven = fast_runs::driven(self, run, states.saturating_sub(1), cancel)?;
            figures.outcome.driven = driven.and_then(Result::ok);
        }
        let mut planner = Planner::new(vehicle);
        let [times] = SearchTimes::measure(&mut planner, maze, [&figures].into_iter())[..] else {
            return Ok(None);
        };
        Ok(Some(RunResult {
            repeated_steps: figures.repeated_steps(),
            steps_until_fastest_run_proven: judge.steps_until_fastest_run_proven(&mut planner),
            vehicle: planner.vehicle().name().into(),
            times,
            cause,
            figures,
        }))
    }

    /// Returns the index of a run.
    pub(crate) fn index(&self, run: u32) -> ApiResult<Arc<RunIndex>> {
        let description = self.describe(run)?;
        let RunDescription { size, unexplored, truth, .. } = &*description;
        let rules = || MovementRules::from_map(unexplored, truth.as_ref());
        let new = || Arc::new(RunIndex::new(*size, rules()));
        Ok(self.cache(run, |cache| Arc::clone(cache.index.get_or_insert_with(new))))
    }

    /// Returns true if the trail up to a state must be computed from many states.
    pub(crate) fn is_trail_long(&self, run: u32, index: usize) -> bool {
        self.index(run).is_ok_and(|run| run.missing_states(index) > MAX_TRAIL_STATES)
    }

    /// Returns the phases and the trail of the mouse up to a state.
    pub(crate) fn run_to(
        &self,
        run: u32,
        index: usize,
        cancel: &CancelToken,
    ) -> ApiResult<(Phases, Trail)> {
        self.index(run)?.at(index, |index| {
            cancel.check()?;
            self.peek_block(run, index)
        })
    }

    /// Returns the first or last `max` log lines that match a filter and belong to a range of
    /// states, in order. The lines after the last state belong to the number of states.
    pub(crate) fn log(
        &self,
        run: u32,
        states: &RangeInclusive<usize>,
        end: LogEnd,
        max: usize,
        cancel: &CancelToken,
        filter: impl Fn(&str) -> bool,
    ) -> ApiResult<Vec<LogLine>> {
        let count = self.states(run)?;
        let read = |blocks, end| {
            cancel.check()?;
            match &self.kind {
                SourceKind::Live(monitor) => {
                    Ok::<_, ApiError>(monitor.log_block(run, blocks, end)?)
                }
                SourceKind::Recording { recording, .. } => {
                    Ok(recording.history().log_block(blocks, end))
                }
            }
        };
        let mut lines = read_log(states, end, max, &filter, read)?;
        if let Some(last) = count.checked_sub(1)
            && states.contains(&count)
        {
            let trailing = self.trailing(run, last)?;
            lines.extend(trailing.log_lines(count).filter(|line| filter(&line.text)));
            match end {
                LogEnd::First => lines.truncate(max),
                LogEnd::Last => drop(lines.drain(..lines.len().saturating_sub(max))),
            }
        }
        Ok(lines)
    }

    /// Returns the latest log line of a driven run until the state with the index `at` and, if this is
    /// the last one, after it. Reads only states that were not searched before.
    pub(crate) fn driven_run(
        &self,
        run: u32,
        at: usize,
        cancel: &CancelToken,
        is_run: impl Fn(&str) -> bool,
    ) -> ApiResult<Option<LogLine>> {
        // The lines after the last state belong to the number of states.
        let last = at + usize::from(at.saturating_add(1) == self.states(run)?);
        if last > at
            && let Some(line) =
                self.log(run, &(last..=last), LogEnd::Last, 1, cancel, &is_run)?.pop()
        {
            return Ok(Some(line));
        }
        let searched = self.cache(run, |cache| cache.driven.0);
        if searched <= at {
            let lines =
                self.log(run, &(searched..=at), LogEnd::First, usize::MAX, cancel, &is_run)?;
            self.cache(run, |cache| {
                if cache.driven.0 == searched {
                    cache.driven.1.extend(lines.iter().map(|line| line.state));
                    cache.driven.0 = at + 1;
                }
            });
        }
        let latest = self.cache(run, |cache| {
            let states = &cache.driven.1;
            states[..states.partition_point(|&state| state <= at)].last().copied()
        });
        let Some(state) = latest else { return Ok(None) };
        Ok(self.log(run, &(state..=state), LogEnd::Last, 1, cancel, is_run)?.pop())
    }

    /// Clears the cache if it belongs to a run other than `run`, then calls `access` with the
    /// cache.
    fn cache<T>(&self, run: u32, access: impl FnOnce(&mut RunCache) -> T) -> T {
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        if cache.run != run {
            *cache = RunCache { run, ..RunCache::default() };
        }
        access(&mut cache)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use mmsim_maze::MazeSize;
    use mmsim_protocol::Annotations;
    use mmsim_recording::{History, UpdateTracker};

    use super::*;

    #[test]
    fn the_log_of_a_state_is_searched_once_for_driven_runs() {
        let source = StateSource::recording("run", crate::export::tests::recording());
        let cancel = CancelToken::default();
        let lines = |state: usize| state / 100 + 1;
        let read = Cell::new(0);
        let find = |at, is_run: bool| {
            let filter = |_: &str| {
                read.set(read.get() + 1);
                is_run
            };
            let line = source.driven_run(RECORDED_RUN, at, &cancel, filter).unwrap();
            (line.map(|line| line.state), read.take())
        };
        assert_eq!(find(250, false), (None, lines(250)));
        assert_eq!(find(250, false), (None, 0));
        assert_eq!(find(120, true), (None, 0));
        assert_eq!(find(420, false), (None, lines(420) - lines(250)));
        // The line itself is read again.
        assert_eq!(find(520, true), (Some(500), 2));
        assert_eq!(find(530, true), (Some(500), 1));
        assert_eq!(find(499, true), (None, 0));
        assert_eq!(find(650, true), (Some(600), 2));
        assert_eq!(find(550, true), (Some(500), 1));
    }

    #[test]
    fn the_cache_is_limited_in_blocks_and_bytes() {
        let size = MazeSize::new(1, 1).unwrap();
        let block = |requests: usize| {
            let (mut history, mut updates) = (History::new(size), UpdateTracker::default());
            let request = [&b"A"[..], &b"L\0\0".repeat(1365)].concat();
            for _ in 0..Block::STATES {
                for _ in 0..requests {
                    updates.annotate(Annotations::decode(&request, size).unwrap()).unwrap();
                }
                history.push_with_update(updates.update(), b"S\0\0NC\0C\0").unwrap();
                updates.report();
            }
            Arc::new(history.block(0).unwrap().unpack().unwrap())
        };
        let (small, medium, large) = (block(0), block(4), block(15));
        for (each, count) in [(&small, CACHED_BLOCKS), (&medium, 4), (&large, 2)] {
            let mut blocks = VecDeque::from(vec![Arc::clone(each); CACHED_BLOCKS]);
            blocks.push_back(Arc::clone(&small));
            evict(&mut blocks);
            let bytes: usize = blocks.iter().map(|states| states.memory()).sum();
            assert_eq!(blocks.len(), count);
            assert!(bytes <= MAX_CACHED_BYTES && Arc::ptr_eq(blocks.back().unwrap(), &small));
        }
        let mut blocks = VecDeque::from(vec![Arc::clone(&large); 3]);
        evict(&mut blocks);
        assert_eq!(blocks.len(), 1);
    }
}
