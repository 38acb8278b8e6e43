//! Pictures of trials.

use std::error::Error;

use mmsim_drawing::{DrivenPath, PictureError, Scene};
use mmsim_maze::{Cell, KnownMaze};
use mmsim_trial::{BundledRobot, Settings, SwingAsPublished, SwingRobot};

use super::args::TrialArgs;
use super::contender::{Contender, Job, RobotKind};
use super::outcome::TrialResult;
use super::table::failure;
use crate::output::{counted, replace};
use crate::render::SIDE_PX;
use crate::render::args::{Picture, PictureFormat};
use crate::selection::Selected;
use crate::usage::UsageError;

/// The distance between a leg and the line through its key points, and between two such legs, in
/// cells.
const LEG_OFFSET: f64 = 0.15;

/// Returns a usage error unless the pictures show one robot in one maze.
pub(super) fn check(
    args: &TrialArgs,
    mazes: &[Selected],
    contenders: &[Contender],
) -> Result<(), UsageError> {
    let error = |message: String| Err(UsageError::new("trial", message));
    for (option, picture) in [("--output", &args.output), ("--tour", &args.tour)] {
        if picture.is_some() && mazes.len() > 1 {
            return error(format!("{option} takes one maze, found {}", mazes.len()));
        }
        if picture.is_some() && contenders.len() != 1 {
            return error(format!("{option} takes one robot, found {}", contenders.len()));
        }
    }
    if args.tour.is_some() && tour(&contenders[0], None).is_none() {
        return error("--tour requires --robot swing or --robot swing-timed".into());
    }
    Ok(())
}

/// Writes the pictures of the trial, if any are wanted.
pub(super) fn write(
    args: &TrialArgs,
    jobs: &[Job<'_>],
    outcomes: &[TrialResult],
) -> Result<(), Box<dyn Error>> {
    let ([(selected, contender)], [outcome]) = (jobs, outcomes) else { return Ok(()) };
    if let Some(picture) = &args.output {
        let [explore, race] = [&outcome.explore, &outcome.race_cells()]
            .map(|cells| cells.iter().map(|cell| centre(*cell)).collect::<Vec<_>>());
        let score = match outcome.score() {
            Some(score) => format!("score {score}"),
            None => failure(outcome).into(),
        };
        let steps = |count| counted(u64::from(count), "step");
        let race_label = format!("{}, {score}", steps(outcome.race_steps));
        let mut paths = vec![DrivenPath::line("run 1", &steps(outcome.explore_steps), &explore)];
        if !race.is_empty() {
            paths.insert(0, DrivenPath::line("run 2", &race_label, &race));
        }
        let scene = Scene::from_map(&outcome.explored).with_truth(Some(&selected.maze));
        save(picture, &scene.with_paths(&paths).with_theme(args.theme))?;
    }
    if let Some(picture) = &args.tour {
        let unexplored = KnownMaze::unexplored(&selected.maze);
        let tour = tour(contender, Some(&unexplored)).unwrap_or_default();
        let start = unexplored.start().cell;
        let paths = [DrivenPath::line(
            contender.name(),
            &counted(tour.len() as u64, "leg"),
            &legs(start, &tour),
        )];
        let visits = |cell| {
            let visits = (1..).zip(&tour).filter(|(_, other)| **other == cell);
            visits.map(|(number, _): (usize, _)| number.to_string()).collect::<Vec<_>>().join(" ")
        };
        let texts: Vec<(Cell, String)> = tour.iter().map(|&cell| (cell, visits(cell))).collect();
        let text = |cell| {
            let text = texts.iter().find(|(other, _)| *other == cell);
            text.map_or("", |(_, text)| text)
        };
        let scene = Scene::from_maze(&selected.maze).with_texts(text).with_paths(&paths);
        save(picture, &scene.with_theme(args.theme))?;
    }
    Ok(())
}

fn save(picture: &Picture, scene: &Scene<'_>) -> Result<(), Box<dyn Error>> {
    let Picture { path, format } = picture;
    let bytes: Result<Vec<u8>, PictureError> = match format {
        PictureFormat::Svg => Ok(scene.svg().into_bytes()),
        PictureFormat::Png | PictureFormat::Gif => scene.png(scene.width_within(SIDE_PX)),
    };
    Ok(replace(path, &bytes?)?)
}

/// Returns the key points of a robot in the order of its tour, or `None` if the robot has none. If
/// the maze is not known yet, the list is empty.
fn tour(contender: &Contender, unexplored: Option<&KnownMaze>) -> Option<Vec<Cell>> {
    let Settings { variant, key_points, .. } = contender.settings;
    let tour = match contender.kind {
        RobotKind::Bundled(BundledRobot::Swing | BundledRobot::SwingTimed) => SwingRobot::tour,
        RobotKind::Bundled(BundledRobot::SwingAsPublished) => SwingAsPublished::tour,
        _ => return None,
    };
    Some(unexplored.map(|map| tour(map, variant, key_points)).unwrap_or_default())
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
