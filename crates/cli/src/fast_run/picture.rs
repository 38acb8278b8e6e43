//! Pictures of fast runs.

use std::error::Error;

use clap::Args;
use mmsim_drawing::{Animation, DrivenPath, MAX_PATHS, PictureError, Scene, Theme, frame_times};
use mmsim_maze::Maze;

use super::driven::{DrivenRun, RunResult};
use crate::args::UsageError;
use crate::output::replace;
use crate::picture::{
    PictureFile, PictureFormat, SIDE_PX, draw_still, parse_picture, themes, width_range,
};

#[derive(Debug, Args)]
pub(crate) struct PictureArgs {
    /// Draw the runs through one maze: .svg or .png, or .gif to animate them in real time. An
    /// existing file is replaced
    #[arg(short, long, value_name = "FILE", group = "picture", value_parser = parse_picture)]
    pub(crate) output: Option<PictureFile>,
    /// Colour theme of the picture
    #[arg(long, default_value = "light", requires = "picture", value_parser = themes())]
    theme: Theme,
    /// Width of a .png or .gif in pixels [default: chosen so that the longer side is 640 pixels]
    #[arg(
        long,
        value_name = "PX",
        requires = "picture",
        value_parser = clap::value_parser!(u32).range(width_range())
    )]
    width: Option<u32>,
}

impl PictureArgs {
    /// Returns an error if the runs do not fit into one picture, or if an SVG has a width.
    pub(crate) fn check(&self, mazes: usize, runs: usize) -> Result<(), UsageError> {
        let message = match &self.output {
            Some(_) if mazes != 1 => format!("--output takes one maze, found {mazes}"),
            Some(_) if runs > MAX_PATHS => {
                format!("--output takes at most {MAX_PATHS} runs, found {runs}")
            }
            Some(output) => match output.check_width(self.width) {
                Err(message) => message,
                Ok(()) => return Ok(()),
            },
            None => return Ok(()),
        };
        Err(UsageError::new("fast-run", message))
    }

    /// Writes a picture of the runs, if one is wanted. Nothing is written if there is no run.
    pub(crate) fn write(&self, results: &[RunResult<'_>]) -> Result<(), Box<dyn Error>> {
        let runs: Vec<_> = results.iter().filter_map(|run| run.driven.as_ref().ok()).collect();
        if let (Some(PictureFile { path, format }), [first, ..]) = (&self.output, &runs[..]) {
            replace(path, &self.draw(&first.maze.maze, &runs, *format)?)?;
        }
        Ok(())
    }

    /// Draws runs through a maze.
    fn draw(
        &self,
        maze: &Maze,
        runs: &[&DrivenRun<'_>],
        format: PictureFormat,
    ) -> Result<Vec<u8>, PictureError> {
        let paths: Vec<DrivenPath> = runs
            .iter()
            .map(|run| DrivenPath::from_trajectory(&name(run, runs), &run.trajectory))
            .collect();
        let scene = Scene::from_maze(maze).with_paths(&paths).with_theme(self.theme);
        match format {
            PictureFormat::Svg | PictureFormat::Png => draw_still(&scene, format, self.width),
            PictureFormat::Gif => {
                animate(&scene, self.width.unwrap_or_else(|| scene.width_within(SIDE_PX)))
            }
        }
    }
}

/// Animates the mice in real time.
fn animate(scene: &Scene<'_>, width_px: u32) -> Result<Vec<u8>, PictureError> {
    let mut animation = Animation::new(width_px);
    let (times, frame_ms) = frame_times(scene.duration());
    for time in times {
        animation.push(&scene.clone().at_time(time), frame_ms)?;
    }
    animation.finish()
}

/// Returns the name of a run: what distinguishes it from the other runs. A long name of a vehicle is
/// shortened, so that the route is legible.
fn name(run: &DrivenRun<'_>, runs: &[&DrivenRun<'_>]) -> String {
    let (vehicle, route) = (run.vehicle.name(), run.route.name());
    let has_one_vehicle = runs.iter().all(|other| other.vehicle.name() == vehicle);
    let has_one_route = runs.iter().all(|other| other.route == run.route);
    match (has_one_vehicle, has_one_route) {
        (_, true) => vehicle.into(),
        (true, false) => route.into(),
        (false, false) => {
            let max = DrivenPath::MAX_NAME_CHARS - " ".len() - route.len();
            format!("{} {route}", shortened(vehicle, max))
        }
    }
}

/// Shortens a text to at most `max` characters. The font of pictures has no ellipsis.
fn shortened(text: &str, max: usize) -> String {
    match text.char_indices().nth(max) {
        None => text.into(),
        Some(_) => text.chars().take(max - 2).chain("..".chars()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_of_vehicles_leave_room_for_the_route() {
        assert_eq!(shortened("my-mouse", 8), "my-mouse");
        assert_eq!(shortened("my-mouse-2", 8), "my-mou..");
    }
}
