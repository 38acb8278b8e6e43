//! The description of a run as text.

use mmsim_fastrun::{STANDARD_GRAVITY, Segment};
use mmsim_maze::{Escaped, counted};

use super::driven::{Driven, RunResult};
use super::report::SegmentReport;
use crate::grid::aligned;

/// Describes a run: its times, its length, its turns and its text form.
pub(super) fn describe(driven: &Driven, with_segments: bool) -> String {
    let Driven { maze, vehicle, route, run, trajectory, gate_to_gate, .. } = driven;
    let (time, length) = (trajectory.duration(), trajectory.length());
    let loss = match driven.loss {
        loss if loss > 0.0 => format!(", loss {loss:.2} %"),
        _ => String::new(),
    };
    let mean = if time > 0.0 { length / time } else { 0.0 };
    let cells = counted(run.cells().len().saturating_sub(1), "cell");
    let kinds: Vec<String> =
        driven.turns_by_kind().map(|(kind, count)| format!("{count} {kind}")).collect();
    let turns = match run.turns().len() {
        0 => "none".into(),
        count => format!("{count}: {}", kinds.join(", ")),
    };
    let mut text = format!(
        "{}: fastest run of {}{}\n\
         time      {time:.3} s from rest to rest, {gate_to_gate:.3} s from gate to gate{loss}\n\
         distance  {:.3} m, {cells}\n\
         speed     mean {:.3} m/s, top {:.3} m/s\n\
         turns     {turns}\n\
         run       {run}\n",
        maze.shown_path(),
        Escaped(vehicle.name()),
        route.restriction(),
        length / 1000.0,
        mean / 1000.0,
        trajectory.top_speed() / 1000.0,
    );
    if with_segments && !trajectory.segments().is_empty() {
        text.push('\n');
        text.push_str(&segments(trajectory.segments()));
    }
    text
}

/// Describes several runs with their straights and turns.
pub(super) fn describe_all(results: &[RunResult]) -> String {
    let text = |RunResult { maze, vehicle, driven, .. }: &RunResult| match driven {
        Ok(driven) => describe(driven, true),
        Err(error) => format!("{}: {}: {error}\n", maze.shown_path(), Escaped(vehicle.name())),
    };
    results.iter().map(text).collect::<Vec<_>>().join("\n")
}

fn segments(segments: &[Segment]) -> String {
    let head = ["", "steps", "mm", "entry mm/s", "top mm/s", "exit mm/s", "g", "s", "total s"];
    let mut rows = vec![head.map(String::from).to_vec()];
    rows.extend(segments.iter().map(SegmentReport::new).map(|segment| {
        let steps = segment.steps.map(|steps| steps.to_string());
        let acceleration = segment.centripetal_acceleration_mm_s2;
        vec![
            segment.segment,
            steps.unwrap_or_default(),
            format!("{:.1}", segment.length_mm),
            format!("{:.0}", segment.entry_speed_mm_s),
            format!("{:.0}", segment.top_speed_mm_s),
            format!("{:.0}", segment.exit_speed_mm_s),
            acceleration.map_or(String::new(), |mm_s2| format!("{:.2}", mm_s2 / STANDARD_GRAVITY)),
            format!("{:.4}", segment.duration_s),
            format!("{:.4}", segment.time_s),
        ]
    }));
    aligned(&rows)
}
