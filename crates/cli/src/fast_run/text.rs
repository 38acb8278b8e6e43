//! The description of a run as text.

use std::f64::consts::FRAC_PI_4;

use mmsim_fastrun::{Arc, STANDARD_GRAVITY, Segment, Shape};
use mmsim_maze::Escaped;

use super::driven::{Driven, RunResult};
use crate::grid::aligned;
use crate::output::counted;

/// Describes a run: its times, its length, its turns and its text form.
pub(super) fn describe(driven: &Driven, with_segments: bool) -> String {
    let Driven { maze, vehicle, route, run, trajectory, gate_to_gate, .. } = driven;
    let (time, length) = (trajectory.duration(), trajectory.length());
    let loss = match driven.loss {
        loss if loss > 0.0 => format!(", loss {loss:.2} %"),
        _ => String::new(),
    };
    let mean = if time > 0.0 { length / time } else { 0.0 };
    let cells = counted(run.cells().len().saturating_sub(1) as u64, "cell");
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
    let texts: Vec<String> = results
        .iter()
        .map(|RunResult { maze, vehicle, driven, .. }| match driven {
            Ok(driven) => describe(driven, true),
            Err(error) => {
                format!("{}: {}: {error}\n", maze.shown_path(), Escaped(vehicle.name()))
            }
        })
        .collect();
    texts.join("\n")
}

fn segments(segments: &[Segment]) -> String {
    let head = ["", "steps", "mm", "entry mm/s", "top mm/s", "exit mm/s", "g", "s", "total s"];
    let mut rows = vec![head.map(String::from).to_vec()];
    rows.extend(segments.iter().map(|segment| {
        let steps = match segment.shape {
            Shape::Straight(steps) => steps.to_string(),
            Shape::Turn(..) => String::new(),
        };
        vec![
            segment_name(segment),
            steps,
            format!("{:.1}", segment.length),
            format!("{:.0}", segment.entry.speed),
            format!("{:.0}", segment.top_speed()),
            format!("{:.0}", segment.exit_speed),
            centripetal_acceleration(segment)
                .map_or(String::new(), |mm_s2| format!("{:.2}", mm_s2 / STANDARD_GRAVITY)),
            format!("{:.4}", segment.duration),
            format!("{:.4}", segment.entry.time + segment.duration),
        ]
    }));
    aligned(&rows)
}

/// Returns the greatest centripetal acceleration in a turn, in mm/s².
pub(super) fn centripetal_acceleration(segment: &Segment) -> Option<f64> {
    match segment.shape {
        Shape::Turn(kind, _) => {
            let arc = Arc { length: segment.length, speed: segment.exit_speed };
            Some(arc.centripetal_acceleration(kind))
        }
        Shape::Straight(_) => None,
    }
}

/// Returns `straight`, `diagonal`, or a turn with its side such as `l90R`.
pub(super) fn segment_name(segment: &Segment) -> String {
    match segment.shape {
        Shape::Turn(kind, side) => format!("{kind}{}", side.letter()),
        Shape::Straight(_) if is_diagonal(segment.entry.heading) => "diagonal".into(),
        Shape::Straight(_) => "straight".into(),
    }
}

/// Returns true if a heading in radians is between the rows and the columns.
pub(super) fn is_diagonal(heading: f64) -> bool {
    (heading / FRAC_PI_4).round().rem_euclid(2.0) > 0.5
}
