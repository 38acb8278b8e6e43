//! The JSON report of a run.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_4;

use mmsim_fastrun::{Arc, Segment, Shape};
use serde::Serialize;

use super::driven::{DrivenRun, RunResult};

/// A maze, a vehicle and a route, with the run or the reason why there is none. The field names are
/// JSON keys.
#[derive(Serialize)]
pub(super) struct FastRunReport<'a> {
    path: String,
    maze: &'a str,
    vehicle: &'a str,
    route: &'static str,
    #[serde(flatten)]
    run: Option<FastRunFigures>,
    error: Option<&'a str>,
}

#[derive(Serialize)]
struct FastRunFigures {
    /// The time from rest to rest.
    time_s: f64,
    gate_to_gate_s: f64,
    /// The slowdown against the fastest run, in percent.
    loss_percent: f64,
    length_mm: f64,
    top_speed_mm_s: f64,
    slalom_turns: usize,
    slalom_turns_by_kind: BTreeMap<&'static str, usize>,
    start: [u8; 2],
    moves: String,
    cells: Vec<[u8; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    segments: Option<Vec<SegmentReport>>,
}

/// A straight, a diagonal or the arc of a turn.
#[derive(Serialize)]
pub(super) struct SegmentReport {
    /// `straight`, `diagonal`, or a turn with its side such as `l90R`.
    pub(super) segment: String,
    /// The number of lattice steps of a straight.
    pub(super) steps: Option<u8>,
    pub(super) length_mm: f64,
    pub(super) entry_speed_mm_s: f64,
    pub(super) top_speed_mm_s: f64,
    pub(super) exit_speed_mm_s: f64,
    pub(super) duration_s: f64,
    /// The greatest centripetal acceleration. `None` on straights.
    pub(super) centripetal_acceleration_mm_s2: Option<f64>,
    /// The time at the end of the segment.
    pub(super) end_s: f64,
}

impl<'a> FastRunReport<'a> {
    pub(super) fn new(result: &'a RunResult, with_segments: bool) -> Self {
        let driven = result.driven.as_ref();
        Self {
            path: result.maze.path.display().to_string(),
            maze: &result.maze.name,
            vehicle: result.vehicle.name(),
            route: result.route.name(),
            run: driven.ok().map(|driven| FastRunFigures::new(driven, with_segments)),
            error: driven.err().map(String::as_str),
        }
    }
}

impl FastRunFigures {
    fn new(driven: &DrivenRun, with_segments: bool) -> Self {
        let DrivenRun { run, trajectory, gate_to_gate, .. } = driven;
        let start = run.start();
        let segments = trajectory.segments();
        Self {
            time_s: trajectory.duration(),
            gate_to_gate_s: *gate_to_gate,
            loss_percent: driven.loss,
            length_mm: trajectory.length(),
            top_speed_mm_s: trajectory.top_speed(),
            slalom_turns: run.turns().len(),
            slalom_turns_by_kind: (driven.turns_by_kind())
                .map(|(kind, count)| (kind.name(), count))
                .collect(),
            start: [start.x, start.y],
            moves: run.to_string(),
            cells: run.cells().iter().map(|cell| [cell.x, cell.y]).collect(),
            segments: with_segments.then(|| segments.iter().map(SegmentReport::new).collect()),
        }
    }
}

impl SegmentReport {
    pub(super) fn new(segment: &Segment) -> Self {
        let (name, steps, acceleration) = match segment.shape {
            Shape::Straight(steps) => {
                let is_diagonal = is_diagonal(segment.entry.heading);
                (if is_diagonal { "diagonal" } else { "straight" }.into(), Some(steps), None)
            }
            Shape::Turn(kind, side) => {
                let arc = Arc { length: segment.length, speed: segment.exit_speed };
                let acceleration = arc.centripetal_acceleration(kind);
                (format!("{kind}{}", side.letter()), None, Some(acceleration))
            }
        };
        Self {
            segment: name,
            steps,
            length_mm: segment.length,
            entry_speed_mm_s: segment.entry.speed,
            top_speed_mm_s: segment.top_speed(),
            exit_speed_mm_s: segment.exit_speed,
            duration_s: segment.duration,
            centripetal_acceleration_mm_s2: acceleration,
            end_s: segment.entry.time + segment.duration,
        }
    }
}

/// Returns true if a heading in radians is between the rows and the columns.
pub(super) fn is_diagonal(heading: f64) -> bool {
    (heading / FRAC_PI_4).round().rem_euclid(2.0) > 0.5
}
