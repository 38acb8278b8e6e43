//! Searches in a run: the log lines around a state, and the state in which the mouse has made the same
//! progress as in a state of another run.

use axum::Json;
use axum::extract::Query;
use mmsim_recording::LogEnd;
use mmsim_run::{EndFacts, LegProgress, Phases};
use serde::{Deserialize, Serialize};

use crate::http::jobs::{ApiError, ApiResult, CancelToken, run_blocking};
use crate::http::requested_run::RequestedRun;
use crate::source::StateSource;

/// The maximum number of log lines up to a state, and of later log lines, in a response.
const MAX_LINES: usize = 500;

#[derive(Deserialize)]
pub(crate) struct LogQuery {
    /// The index of the state around which lines are returned.
    at: usize,
    /// The index of the first state whose lines are returned.
    #[serde(default)]
    from: usize,
    max: Option<usize>,
    /// Only lines that contain this text are returned, ignoring case.
    #[serde(default)]
    filter: String,
}

/// The matching log lines around a state.
#[derive(Debug, PartialEq, Eq, Serialize)]
pub(crate) struct LogView {
    /// The lines, each with the index of the state that follows the line, which is the number of states
    /// if there is none.
    lines: Vec<(usize, String)>,
    /// The range of states all of whose matching lines are in `lines`.
    first: usize,
    last: usize,
    /// True if there may be matching lines after `last`.
    has_later: bool,
}

pub(crate) async fn log_lines(
    run: RequestedRun,
    Query(query): Query<LogQuery>,
) -> ApiResult<Json<LogView>> {
    run.read(move |source, run, cancel| query.select(source, run, cancel)).await
}

impl LogQuery {
    fn select(&self, source: &StateSource, run: u32, cancel: &CancelToken) -> ApiResult<LogView> {
        let from = self.from;
        let max = self.max.unwrap_or(MAX_LINES).min(MAX_LINES);
        let filter = self.filter.to_lowercase();
        let matches = |text: &str| {
            let is_found = filter.is_empty() || text.to_lowercase().contains(&filter);
            is_found && !EndFacts::is_log_line(text)
        };
        let states = source.states(run)?;
        let at = self.at.min(states.saturating_sub(1));
        let mut lines = source.log(run, &(from..=at), LogEnd::Last, max, cancel, matches)?;
        // Earlier lines of the first state may be missing.
        let oldest = lines.first().filter(|_| lines.len() == max);
        let first = oldest.map_or(from, |line| (line.state + 1).min(at));
        // One more line shows whether there are more than `max`.
        let rest = at + 1..=states;
        let mut later = source.log(run, &rest, LogEnd::First, max + 1, cancel, matches)?;
        let has_later = later.len() > max;
        later.truncate(max);
        let last = match later.last() {
            _ if !has_later => states.saturating_sub(1),
            Some(line) => (line.state - 1).max(at),
            None => at,
        };
        lines.append(&mut later);
        let lines = lines.into_iter().map(|line| (line.state, line.text)).collect();
        Ok(LogView { lines, first, last, has_later })
    }
}

#[derive(Deserialize)]
pub(crate) struct FindQuery {
    /// The number of steps since the leg began or, without a leg, since the first state.
    steps: u64,
    /// The number of a leg. See [`LegProgress`].
    leg: Option<u32>,
}

#[derive(Debug, PartialEq, Eq, Serialize)]
pub(crate) struct FoundState {
    /// The index of the state.
    at: usize,
    /// False if the mouse has not made this progress yet, so `at` is the last state.
    #[serde(rename = "reached")]
    is_reached: bool,
}

/// The progress that the mouse must have made.
#[derive(Clone, Copy, Debug)]
enum StepTarget {
    /// The total number of steps.
    Steps(u64),
    Leg(LegProgress),
}

pub(crate) async fn find_state(
    requested: RequestedRun,
    Query(FindQuery { steps, leg }): Query<FindQuery>,
) -> ApiResult<Json<FoundState>> {
    let target = match leg {
        Some(leg) => {
            StepTarget::Leg(LegProgress { leg, steps: u32::try_from(steps).unwrap_or(u32::MAX) })
        }
        None => StepTarget::Steps(steps),
    };
    let states = requested.source.states(requested.run)?;
    if let Some(last) = states.checked_sub(1) {
        requested.index_to(last).await?;
    }
    let RequestedRun { source, run, .. } = requested;
    run_blocking(move || {
        let index = source.index(run)?;
        let phases = |state| index.phases(state, |state| source.peek_block(run, state));
        let found = find(target, states, phases)?;
        found.map(Json).ok_or_else(|| ApiError::not_found("the run has no states"))
    })
    .await
}

impl StepTarget {
    fn is_reached(self, phases: &Phases) -> bool {
        match self {
            Self::Steps(steps) => phases.total.steps >= steps,
            Self::Leg(progress) => phases.leg() >= progress,
        }
    }

    /// Returns true if the mouse has passed the end of the leg.
    fn is_passed(self, phases: &Phases) -> bool {
        matches!(self, Self::Leg(progress) if phases.leg().leg > progress.leg)
    }
}

/// Finds the first state in which the target is reached. If the run has no such leg or a shorter
/// one, finds the last state before a later leg. Returns `None` if there are no states. `phases`
/// returns the phases up to a state.
fn find<E>(
    target: StepTarget,
    states: usize,
    mut phases: impl FnMut(usize) -> Result<Phases, E>,
) -> Result<Option<FoundState>, E> {
    let Some(last) = states.checked_sub(1) else { return Ok(None) };
    if !target.is_reached(&phases(last)?) {
        return Ok(Some(FoundState { at: last, is_reached: false }));
    }
    // The target is reached in the state `end` but not before the state `start`.
    let (mut start, mut end) = (0, last);
    while start < end {
        let middle = usize::midpoint(start, end);
        if target.is_reached(&phases(middle)?) {
            end = middle;
        } else {
            start = middle + 1;
        }
    }
    let at = if target.is_passed(&phases(end)?) { end.saturating_sub(1) } else { end };
    Ok(Some(FoundState { at, is_reached: true }))
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, MazeSize, Pose};
    use mmsim_protocol::state_bytes;
    use mmsim_recording::{Block, History};
    use mmsim_run::{MovementRules, RunIndex};
    use proptest::prelude::*;

    use super::*;

    /// Finds a state by looking at each state.
    fn find_naively(target: StepTarget, all: &[Phases]) -> Option<FoundState> {
        let last = all.len().checked_sub(1)?;
        let Some(first) = all.iter().position(|phases| target.is_reached(phases)) else {
            return Some(FoundState { at: last, is_reached: false });
        };
        let at = match target {
            StepTarget::Leg(LegProgress { leg, .. }) if all[first].leg().leg != leg => {
                all.iter().rposition(|phases| phases.leg().leg < all[first].leg().leg)?
            }
            _ => first,
        };
        Some(FoundState { at, is_reached: true })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(30))]
        #[test]
        fn the_found_state_is_the_first(
            moves in prop::collection::vec((0u8..3, 0u8..2, 0usize..4, 1usize..40), 0..60),
            targets in prop::collection::vec((0u32..40, 0u32..60), 20),
        ) {
            // The start is cell (0, 0), and the whole rest of a 3x2 maze is open. The mouse rests in
            // a pose for some states, so a run has several blocks.
            let size = MazeSize::new(3, 2).unwrap();
            let mut history = History::new(size);
            for &(x, y, heading, count) in &moves {
                let mut state = vec![b'S', x, y, b"NESW"[heading]];
                state.resize(state_bytes(size), b'C');
                for _ in 0..count {
                    history.push(&state).unwrap();
                }
            }
            let start = Pose::new(Cell::new(0, 0), Heading::North);
            let rules = MovementRules::new(start, size.central_cells(), None);
            let index = RunIndex::new(size, rules);
            let phases = |state: usize| {
                index.phases(state, |state| {
                    history.block(state / Block::STATES).and_then(Block::unpack).ok_or(state)
                })
            };
            let count = history.len();
            let all: Vec<_> = (0..count).map(|state| phases(state).unwrap()).collect();
            for (leg, steps) in targets {
                let targets =
                    [StepTarget::Leg(LegProgress { leg, steps }), StepTarget::Steps((leg * steps).into())];
                for target in targets {
                    let found = find(target, count, phases).unwrap();
                    prop_assert_eq!(found, find_naively(target, &all), "{:?}", target);
                }
            }
        }
    }

    #[test]
    fn few_states_of_a_long_run_are_read() {
        let mut reads = 0;
        let found = find(StepTarget::Steps(0), 256_000, |_| {
            reads += 1;
            Ok::<_, ()>(Phases::default())
        });
        assert_eq!(found, Ok(Some(FoundState { at: 0, is_reached: true })));
        assert!(reads <= 20, "{reads}");
    }
}
