//! Pictures of mazes and recordings.

use std::error::Error;
use std::path::Path;
use std::rc::Rc;

use clap::Args;
use mmsim_drawing::{Animation, FRAME_MS, Layers, MAX_FRAMES, Scene, Theme, frame_indices};
use mmsim_maze::{KnownMaze, Maze};
use mmsim_protocol::State;
use mmsim_recording::{Block, Recording, States};
use mmsim_run::{MovementRules, RunIndex, Trail};
use mmsim_solvers::Distances;

use super::given;
use crate::output::note;
use crate::picture::{PictureFile, PictureFormat, SIDE_PX, draw_still, themes, width_range};
use crate::recordings::no_state;

/// The group of the options for pictures.
pub(super) const DRAWING: &str = "drawing";

/// Options for pictures.
#[derive(Debug, Args)]
#[group(id = DRAWING, multiple = true)]
pub(super) struct DrawingArgs {
    /// Draw state N of a recording; a .gif ends with state N [default: the last state]
    #[arg(long, value_name = "N")]
    at: Option<usize>,
    /// Label each cell of a maze with its distance to the goal in steps
    #[arg(long, conflicts_with_all = ["at", "no_numbers", "no_trail", "no_texts", "no_colours"])]
    distances: bool,
    /// Colour the cells: in a maze by the distance to the goal, in a recording by the mouse's
    /// weights
    #[arg(long)]
    heat: bool,
    /// Omit the mouse's weights in a recording
    #[arg(long)]
    no_numbers: bool,
    /// Omit the mouse's trail in a recording
    #[arg(long)]
    no_trail: bool,
    /// Omit the texts that the mouse displays in a recording
    #[arg(long)]
    no_texts: bool,
    /// Omit the colours that the mouse displays in a recording
    #[arg(long)]
    no_colours: bool,
    /// Colour theme of a picture [default: light]
    #[arg(long, value_parser = themes())]
    theme: Option<Theme>,
    /// Width of a .png or .gif in pixels [default: chosen so that the longer side is 640 pixels]
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(width_range()))]
    pub(super) width: Option<u32>,
}

/// The bytes of a picture, or an error.
type PictureResult = Result<Vec<u8>, Box<dyn Error>>;

impl DrawingArgs {
    /// Returns the first option that was given.
    pub(super) fn given(&self) -> Option<&'static str> {
        let options = [
            ("--distances", self.distances),
            ("--heat", self.heat),
            ("--theme", self.theme.is_some()),
            ("--width", self.width.is_some()),
        ];
        self.given_for_recording().or_else(|| given(&options))
    }

    /// Returns the first option that was given and applies only to recordings.
    pub(super) fn given_for_recording(&self) -> Option<&'static str> {
        given(&[
            ("--at", self.at.is_some()),
            ("--no-numbers", self.no_numbers),
            ("--no-trail", self.no_trail),
            ("--no-texts", self.no_texts),
            ("--no-colours", self.no_colours),
        ])
    }

    /// Draws a maze as SVG or PNG.
    pub(super) fn draw_maze(&self, format: PictureFormat, maze: &Maze) -> PictureResult {
        let distances = Distances::flood(maze.walls(), maze.goals());
        let layers =
            Layers { numbers: self.distances, heat: self.heat, trail: false, ..Layers::default() };
        let scene = Scene::from_maze(maze).with_numbers(|cell| distances.at(cell));
        self.still(format, scene.with_layers(layers))
    }

    /// Draws a state of a recording, or the states up to it as an animated GIF.
    pub(super) fn draw_recording(
        &self,
        PictureFile { path, format }: &PictureFile,
        file: &Path,
        recording: &Recording,
    ) -> PictureResult {
        let search = RecordedSearch::new(self, file, recording)?;
        match format {
            PictureFormat::Gif => self.animation(path, &search, recording),
            _ => self.draw_state(*format, &search, recording),
        }
    }

    /// Draws the selected state, or only the maze if the recording has no states.
    fn draw_state(
        &self,
        format: PictureFormat,
        search: &RecordedSearch<'_>,
        recording: &Recording,
    ) -> PictureResult {
        let Some(last) = search.last else {
            let scene = Scene::from_map(&search.initial).with_truth(recording.maze());
            return self.still(format, scene.with_layers(search.layers));
        };
        let mut reader = StateReader::new(recording, &search.initial);
        search.show(&mut reader, last, |scene| self.still(format, scene))?
    }

    fn animation(
        &self,
        picture: &Path,
        search: &RecordedSearch<'_>,
        recording: &Recording,
    ) -> PictureResult {
        let Some(last) = search.last else {
            let file = search.file.display();
            return Err(format!("{file}: cannot animate a recording without states").into());
        };
        let states = last + 1;
        let indices = frame_indices(states, MAX_FRAMES);
        if indices.len() < states {
            let (frames, picture) = (indices.len(), picture.display());
            note(format_args!("{picture}: drawing {frames} of {states} states, evenly spaced"));
        }
        let mut reader = StateReader::new(recording, &search.initial);
        let mut animation = None;
        for index in indices {
            search.show(&mut reader, index, |scene| {
                let scene = scene.with_theme(self.theme());
                let width_px = self.width.unwrap_or_else(|| scene.width_within(SIDE_PX));
                animation.get_or_insert_with(|| Animation::new(width_px)).push(&scene, FRAME_MS)
            })??;
        }
        Ok(animation.unwrap_or_else(|| Animation::new(SIDE_PX)).finish()?)
    }

    /// Draws a scene as SVG or PNG.
    fn still(&self, format: PictureFormat, scene: Scene<'_>) -> PictureResult {
        Ok(draw_still(&scene.with_theme(self.theme()), format, self.width)?)
    }

    fn theme(&self) -> Theme {
        self.theme.unwrap_or(Theme::Light)
    }
}

/// A recorded search and the options for drawing it.
struct RecordedSearch<'a> {
    truth: Option<&'a Maze>,
    /// The mouse's map before the first state.
    initial: KnownMaze,
    /// The index of the last state to draw.
    last: Option<usize>,
    layers: Layers,
    file: &'a Path,
}

impl<'a> RecordedSearch<'a> {
    fn new(args: &DrawingArgs, file: &'a Path, recording: &'a Recording) -> Result<Self, String> {
        let (info, states) = (recording.info(), recording.history().len());
        if args.distances {
            let file = file.display();
            return Err(format!("{file}: --distances needs a maze, not a recording"));
        }
        if let Some(index) = args.at.filter(|&index| index >= states) {
            return Err(no_state(file, recording, index));
        }
        let last = args.at.or(states.checked_sub(1));
        Ok(Self {
            truth: recording.maze(),
            initial: info.known_maze().ok_or_else(|| unreadable(file))?,
            last,
            layers: Layers {
                numbers: !args.no_numbers,
                heat: args.heat,
                trail: !args.no_trail,
                texts: !args.no_texts,
                colours: !args.no_colours,
            },
            file,
        })
    }

    /// Calls `draw` with a [`Scene`] that shows state `index`, which must not be before the state
    /// that was read last.
    fn show<T>(
        &self,
        reader: &mut StateReader<'_>,
        index: usize,
        draw: impl FnOnce(Scene<'_>) -> T,
    ) -> Result<T, String> {
        let unreadable = || unreadable(self.file);
        let (states, trail) = reader.read(index).ok_or_else(unreadable)?;
        let (size, passages) = (reader.recording.size(), trail.passages());
        let message = states.get(index).ok_or_else(unreadable)?;
        let state = State::decode(message, size).map_err(|_| unreadable())?;
        let context = reader.recording.context(&states, index).ok_or_else(unreadable)?;
        let (map, notes) = (context.claimed_maze(&state, &self.initial), context.notes());
        let scene = Scene::from_map(&map)
            .with_truth(self.truth)
            .with_mouse(state.pose())
            .with_weights(|cell| state.weights().at(cell).unwrap_or(0))
            .with_texts(|cell| notes.text(cell))
            .with_colours(|cell| notes.colour(cell))
            .with_trail(&passages)
            .with_layers(self.layers);
        Ok(draw(scene))
    }
}

/// Reads states, and keeps the block that was read last.
struct StateReader<'a> {
    recording: &'a Recording,
    run: RunIndex,
    block: Option<Rc<States>>,
}

impl<'a> StateReader<'a> {
    fn new(recording: &'a Recording, unexplored: &KnownMaze) -> Self {
        let rules = MovementRules::from_map(unexplored, recording.maze());
        Self { recording, run: RunIndex::new(recording.size(), rules), block: None }
    }

    /// Returns the block that contains a state, and the trail up to the state.
    fn read(&mut self, index: usize) -> Option<(Rc<States>, Trail)> {
        let Self { recording, run, block: recent } = self;
        let mut block = |index: usize| {
            let found = recent.take().filter(|block| block.get(index).is_some());
            let read = || recording.history().block(index / Block::STATES)?.unpack().map(Rc::new);
            *recent = found.or_else(read);
            recent.clone().ok_or(())
        };
        let (_, trail) = run.at(index, &mut block).ok()?;
        Some((block(index).ok()?, trail))
    }
}

fn unreadable(file: &Path) -> String {
    format!("{}: cannot decode a state", file.display())
}
