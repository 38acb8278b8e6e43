//! The description of a source.

use mmsim_recording::Integrity;
use mmsim_run::{shortest_path, trial_status};
use mmsim_solvers::MazeFacts;
use serde::Serialize;

use crate::http::api_error::ApiError;
use crate::source::Source;

/// The message that the page shows for a recording that was not closed.
const NOT_CLOSED: &str = "not closed: the recording was truncated or is still being written";

/// The properties of the current run of a source.
#[derive(Serialize)]
pub(crate) struct SourceInfo {
    id: String,
    run: u32,
    title: String,
    /// The name of the maze.
    maze: String,
    width: u8,
    height: u8,
    start: [u8; 2],
    goals: Vec<[u8; 2]>,
    states: usize,
    state_bytes: usize,
    /// Whether the true maze is known.
    truth: bool,
    shortest_path: Option<u16>,
    /// The cells of a shortest path of the true maze or, in a two-run trial, the cells in which the
    /// steps of a fastest race end, as y × width + x.
    route: Vec<usize>,
    /// The name of the robot, if the source is a two-run trial.
    robot: Option<String>,
    /// The minimum number of steps of a race in a two-run trial.
    race_optimum: Option<usize>,
    /// The integrity of a recording: `closed`, `cut` or `damaged`.
    integrity: Option<&'static str>,
    /// A description of the problem if the recording was not closed or is damaged.
    note: Option<String>,
}

impl SourceInfo {
    /// Describes a source. `robot` is the name of the robot if the source is known to be a two-run
    /// trial.
    pub(crate) fn new(
        id: String,
        source: &Source,
        robot: Option<String>,
    ) -> Result<Self, ApiError> {
        let (run, description, states) = source.current_run()?;
        let info = &description.info;
        let (integrity, note) = match source.integrity() {
            None => (None, None),
            Some(Integrity::Closed) => (Some("closed"), None),
            Some(Integrity::Truncated { .. }) => (Some("cut"), Some(NOT_CLOSED.to_string())),
            Some(Integrity::Damaged { intact, reason }) => {
                (Some("damaged"), Some(format!("damaged after byte {intact}: {reason}")))
            }
        };
        let truth = description.truth.as_ref();
        // The run may have ended in the meantime.
        let reported = states.checked_sub(1).and_then(|last| {
            let context = source.block(run, last).ok()?.context(last)?;
            trial_status(context.notes())?;
            Some(context.notes().mouse().unwrap_or_default().to_string())
        });
        let robot = robot.or(reported);
        let path = truth.map_or_else(Vec::new, |maze| shortest_path(maze, robot.is_some()));
        Ok(Self {
            id,
            run,
            title: description.title.clone(),
            maze: info.name.clone(),
            width: info.width,
            height: info.height,
            start: info.start,
            goals: info.goals.clone(),
            states,
            state_bytes: mmsim_protocol::state_bytes(description.size),
            truth: truth.is_some(),
            shortest_path: truth.and_then(|maze| MazeFacts::new(maze).shortest_path),
            // The path has a cell more than steps, and none if the goal is unreachable.
            race_optimum: robot.as_ref().and_then(|_| path.len().checked_sub(1)),
            route: path.into_iter().filter_map(|cell| description.size.index(cell)).collect(),
            robot,
            integrity,
            note,
        })
    }
}
