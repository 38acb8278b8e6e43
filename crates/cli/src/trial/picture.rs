//! Pictures of trials.

use std::collections::HashMap;
use std::error::Error;

use mmsim_compare::{NamedMaze, RobotKind, TrialJob, TrialResult, TrialRobot};
use mmsim_drawing::{DrivenPath, MAX_PATHS, Scene};
use mmsim_maze::{Cell, KnownMaze, counted};
use mmsim_trial::{BundledRobot, Settings, SwingAsPublished, SwingRobot};

use super::args::TrialArgs;
use crate::args::UsageError;
use crate::output::replace;
use crate::picture::{PictureFile, draw_still};

/// The distance between a leg and the line through its key points, and between two such legs, in
/// cells.
const LEG_OFFSET: f64 = 0.15;

/// Returns a usage error unless the robots fit into the pictures of one maze.
pub(super) fn check(
    args: &TrialArgs,
    mazes: &[NamedMaze],
    robots: &[TrialRobot],
) -> Result<(), UsageError> {
    let error = |message: String| Err(UsageError::new("trial", message));
    for (option, picture) in [("--output", &args.output), ("--tour", &args.tour)] {
        if picture.is_some() && mazes.len() > 1 {
            return Err(UsageError::not_one("trial", option, "maze", mazes.len()));
        }
    }
    if args.output.is_some() && robots.len() > MAX_PATHS {
        return error(format!("--output takes at most {MAX_PATHS} robots, found {}", robots.len()));
    }
    if args.tour.is_some() && (robots.len() != 1 || tour(&robots[0], None).is_none()) {
        return error("--tour requires one robot: swing, swing-as-published or swing-timed".into());
    }
    Ok(())
}

/// Writes the pictures of the trials in one maze, if any are wanted.
pub(super) fn write(
    args: &TrialArgs,
    jobs: &[TrialJob<'_>],
    outcomes: &[TrialResult],
) -> Result<(), Box<dyn Error>> {
    let Some(&(selected, robot)) = jobs.first() else { return Ok(()) };
    if let Some(picture) = &args.output {
        let (scene, paths) = if let [outcome] = outcomes {
            let scene = Scene::from_map(&outcome.explored).with_truth(Some(&selected.maze));
            (scene, both_runs(outcome))
        } else {
            let races = jobs.iter().zip(outcomes);
            let races = races.map(|((_, one), outcome)| race(one.name(), outcome));
            (Scene::from_maze(&selected.maze), races.collect())
        };
        save(picture, &scene.with_paths(&paths).with_theme(args.theme))?;
    }
    if let Some(picture) = &args.tour {
        let unexplored = KnownMaze::unexplored(&selected.maze);
        let tour = tour(robot, Some(&unexplored)).unwrap_or_default();
        let label = counted(tour.len(), "leg").to_string();
        let legs = legs(unexplored.start().cell, &tour);
        let paths = [DrivenPath::line(robot.name(), &label, &legs)];
        let visits = |cell| {
            let visits = (1..).zip(&tour).filter(|(_, other)| **other == cell);
            visits.map(|(number, _): (usize, _)| number.to_string()).collect::<Vec<_>>().join(" ")
        };
        let texts: HashMap<Cell, String> = tour.iter().map(|&cell| (cell, visits(cell))).collect();
        let scene = Scene::from_maze(&selected.maze)
            .with_texts(|cell| texts.get(&cell).map_or("", String::as_str))
            .with_paths(&paths);
        save(picture, &scene.with_theme(args.theme))?;
    }
    Ok(())
}

/// Returns the path of the race, which is on top, and the path of the first run.
fn both_runs(outcome: &TrialResult) -> Vec<DrivenPath> {
    let label = counted(outcome.explore_steps, "step").to_string();
    vec![race("run 2", outcome), DrivenPath::line("run 1", &label, &centres(&outcome.explore))]
}

/// Returns the path of a race, with its steps and the score.
fn race(name: &str, outcome: &TrialResult) -> DrivenPath {
    let score = match outcome.score() {
        Some(score) => format!("score {score}"),
        None => outcome.reason().into(),
    };
    let label = format!("{}, {score}", counted(outcome.race_steps, "step"));
    DrivenPath::line(name, &label, &centres(&outcome.race_cells()))
}

fn save(picture: &PictureFile, scene: &Scene<'_>) -> Result<(), Box<dyn Error>> {
    Ok(replace(&picture.path, &draw_still(scene, picture.format, None)?)?)
}

/// Returns the key points of a robot in the order of its tour, or `None` if the robot has none. If
/// the maze is not known yet, the list is empty.
fn tour(robot: &TrialRobot, unexplored: Option<&KnownMaze>) -> Option<Vec<Cell>> {
    let Settings { variant, key_points, .. } = robot.settings;
    let tour = match robot.kind {
        RobotKind::Bundled(BundledRobot::Swing | BundledRobot::SwingTimed) => SwingRobot::tour,
        RobotKind::Bundled(BundledRobot::SwingAsPublished) => SwingAsPublished::tour,
        _ => return None,
    };
    Some(unexplored.map(|map| tour(map, variant, key_points)).unwrap_or_default())
}

fn centres(cells: &[Cell]) -> Vec<(f64, f64)> {
    cells.iter().copied().map(centre).collect()
}

fn centre(cell: Cell) -> (f64, f64) {
    (f64::from(cell.x) + 0.5, f64::from(cell.y) + 0.5)
}

/// Returns straight lines from the start through the key points. Each leg is drawn to the right of
/// the line through its ends, and repeated legs farther to the right, so that all of them are visible.
fn legs(start: Cell, tour: &[Cell]) -> Vec<(f64, f64)> {
    let ends = || std::iter::once(&start).chain(tour).zip(tour);
    let mut corners = vec![centre(start)];
    for (index, leg) in ends().enumerate() {
        let repeated = ends().take(index + 1).filter(|other| *other == leg).count();
        let ((from_x, from_y), (to_x, to_y)) = (centre(*leg.0), centre(*leg.1));
        let (east, north) = (to_x - from_x, to_y - from_y);
        let length = east.hypot(north).max(1.0);
        #[expect(clippy::cast_precision_loss, reason = "few legs")]
        let offset = LEG_OFFSET * repeated as f64 / length;
        let beside = |x: f64, y: f64| (x + offset * north, y - offset * east);
        corners.extend([beside(from_x, from_y), beside(to_x, to_y)]);
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_legs_are_drawn_side_by_side() {
        let (start, end) = (Cell::new(0, 0), Cell::new(4, 0));
        let corners = legs(start, &[end, start, end]);
        let rounded: Vec<String> = corners.iter().map(|(x, y)| format!("{x:.2} {y:.2}")).collect();
        let expected = [
            "0.50 0.50", // the start
            "0.50 0.35",
            "4.50 0.35", // to the east
            "4.50 0.65",
            "0.50 0.65", // back
            "0.50 0.20",
            "4.50 0.20", // to the east again
        ];
        assert_eq!(rounded, expected);
    }
}
