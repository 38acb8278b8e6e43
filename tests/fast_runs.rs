//! Compares the fastest runs of real mazes with those in `fast-run-facts.json`, and drives each of
//! them through the walls.

use std::collections::BTreeMap;
use std::fs;

use mmsim_fastrun::{FastRun, Planner, Trajectory, Vehicle};
use mmsim_maze::{Cell, Maze};
use mmsim_tests::shared;
use serde::Deserialize;

#[derive(Deserialize)]
struct Facts {
    mazes: BTreeMap<String, BTreeMap<String, Option<RecordedRun>>>,
}

#[derive(Deserialize)]
struct RecordedRun {
    time_ms: f64,
    turns: usize,
    cells: usize,
    length_mm: f64,
    path: String,
}

/// Drives along a trajectory in steps of 1 mm, and asserts that it passes no wall.
fn assert_passes(trajectory: &Trajectory, maze: &Maze, name: &str) {
    let mut mm = 0.0;
    let mut before = trajectory.at(0.0);
    let (mut cell, mut time) = (maze.start().cell, 0.0);
    while mm < trajectory.length() {
        mm = trajectory.length().min(mm + 1.0);
        let moment = trajectory.at_distance(mm);
        let distance = (moment.x - before.x).hypot(moment.y - before.y);
        assert!(distance < 1.0 + 1e-6, "{name}: the mouse jumps by {distance} mm at {mm} mm");
        // The time that the step takes at the mean of the speeds.
        time += 2.0 * 1_f64.min(moment.distance - before.distance) / (moment.speed + before.speed);
        let next = trajectory.cell(&moment).unwrap();
        if next != cell {
            let is_open = maze.walls().open_neighbours(cell).any(|open| open == next);
            assert!(is_open, "{name}: {cell} to {next} at {mm} mm");
            cell = next;
        }
        before = moment;
    }
    assert!(maze.goals().contains(cell), "{name}: ends in {cell}");
    // The formula is exact where the acceleration does not change within the step.
    let difference = (time - trajectory.duration()).abs();
    assert!(difference < 5e-5 * trajectory.duration(), "{name}: {time} s");
}

#[test]
fn fastest_runs_match_their_recorded_facts() {
    let Some(folder) = shared("mazes") else { return };
    let facts = fs::read(folder.join("fast-run-facts.json")).unwrap();
    let facts: Facts = serde_json::from_slice(&facts).unwrap();
    let mut planners = Vehicle::PRESETS.map(|name| Planner::new(Vehicle::preset(name).unwrap()));
    let mut rows = 0;
    for (name, runs) in facts.mazes {
        let maze = mmsim_formats::read_maze(&folder.join(&name)).unwrap();
        for planner in &mut planners {
            let vehicle = planner.vehicle().clone();
            let name = format!("{name}, {}", vehicle.name());
            let found = planner.plan(maze.walls(), maze.start().cell, maze.goals());
            rows += 1;
            let Some(recorded) = &runs[vehicle.name()] else {
                assert!(found.is_err(), "{name}: {found:?}");
                continue;
            };
            let found = found.unwrap();
            let time = found.time(&vehicle).unwrap();
            let off = time * 1000.0 - recorded.time_ms;
            assert!(off.abs() <= 0.1, "{name}: {off} ms slower, {found}");
            assert!(found.is_possible(maze.walls(), maze.goals()), "{name}: {found}");
            let trajectory = found.drive(&vehicle).unwrap();
            assert!((trajectory.duration() - time).abs() < 1e-9, "{name}");
            assert_passes(&trajectory, &maze, &name);

            let run = FastRun::parse(Cell::new(0, 0), &recorded.path).unwrap();
            assert_eq!(run.to_string(), recorded.path);
            assert!(run.is_possible(maze.walls(), maze.goals()), "{name}");
            assert_eq!(
                (run.turns().len(), run.cells().len() - 1),
                (recorded.turns, recorded.cells),
                "{name}"
            );
            let trajectory = run.drive(&vehicle).unwrap();
            // The recorded lengths are those from centre to centre.
            let length = trajectory.length() - vehicle.half_cell();
            assert!(
                (length - recorded.length_mm).abs() < 1.0,
                "{name}: {length}, {}",
                recorded.length_mm
            );
            assert!((trajectory.duration() * 1000.0 - recorded.time_ms).abs() <= 0.051, "{name}");
        }
    }
    assert_eq!(rows, 1124);
}
