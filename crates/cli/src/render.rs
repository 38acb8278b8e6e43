//! `mmsim render`: draw mazes and recordings.

use std::error::Error;
use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::rc::Rc;

use clap::Args;
use mmsim_compare::NamedMaze;
use mmsim_drawing::{Animation, FRAME_MS, Layers, MAX_FRAMES, Scene, Theme, frame_indices};
use mmsim_maze::{KnownMaze, Maze};
use mmsim_protocol::State;
use mmsim_recording::{Block, OpenError, ReadError, Recording, States};
use mmsim_run::{MovementRules, RunIndex, Trail};
use mmsim_solvers::Distances;

use crate::args::{CommandResult, ReadingArgs, UsageError};
use crate::output::{note, replace};
use crate::picture::{
    PictureFile, PictureFormat, SIDE_PX, draw_still, parse_picture, themes, width_range,
};
use crate::recordings::{is_undamaged, no_state, recording_budget};
use crate::selection::{MAZE_HELP, Selection, join};

#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    #[arg(
        required = true,
        value_name = "MAZE|RECORDING",
        help = format!("Recording, or maze: {}", MAZE_HELP)
    )]
    source: Vec<OsString>,
    /// File to write: .svg or .png, or .gif to animate a recording. An existing file is replaced
    #[arg(short, long, value_name = "FILE", value_parser = parse_picture)]
    output: PictureFile,
    /// Draw state N of a recording; a .gif ends with state N [default: the last state]
    #[arg(long, value_name = "N")]
    at: Option<usize>,
    /// Label each cell of a maze with its distance to the goal in steps
    #[arg(long)]
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
    /// Colour theme
    #[arg(long, default_value = "light", value_parser = themes())]
    theme: Theme,
    /// Width of a .png or .gif in pixels [default: chosen so that the longer side is 640 pixels]
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(width_range()))]
    width: Option<u32>,
    #[command(flatten)]
    reading: ReadingArgs,
}

/// The bytes of a picture, or an error.
type PictureResult = Result<Vec<u8>, Box<dyn Error>>;

pub(crate) fn run(args: &RenderArgs) -> CommandResult {
    args.output.check_width(args.width).map_err(|error| UsageError::new("render", error))?;
    let source = join(&args.source);
    let (picture, is_intact) = match recording(args, Path::new(&source))? {
        Some(recording) => {
            let file = Path::new(&source);
            let is_gif = args.output.format == PictureFormat::Gif;
            let draw = if is_gif { animation } else { draw_state };
            (draw(args, file, &recording)?, is_undamaged(file, &recording))
        }
        None => (maze(args, &source)?, true),
    };
    replace(&args.output.path, &picture)?;
    Ok(is_intact)
}

/// Opens a recording. If `file` cannot be read or is not an MCAP file, returns `None`, because the
/// argument may select a maze. If the name of the file ends in .mcap, returns an error instead of
/// `None`.
fn recording(args: &RenderArgs, file: &Path) -> Result<Option<Recording>, OpenError> {
    let is_named_mcap = file.extension().is_some_and(|extension| extension == "mcap");
    match Recording::open_within(file, &recording_budget(&args.reading)) {
        Ok(recording) => Ok(Some(recording)),
        Err(OpenError { source: ReadError::Io(_) | ReadError::NotMcap, .. }) if !is_named_mcap => {
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

fn maze(args: &RenderArgs, name: &OsStr) -> PictureResult {
    let NamedMaze { path, maze, .. } = Selection::read(name)?.first()?;
    let path = path.display();
    if args.output.format == PictureFormat::Gif {
        return Err(format!("{path}: cannot animate a maze (a .gif needs a recording)").into());
    }
    let options = [
        ("--at", args.at.is_some()),
        ("--no-numbers", args.no_numbers),
        ("--no-trail", args.no_trail),
        ("--no-texts", args.no_texts),
        ("--no-colours", args.no_colours),
        ("--history-limit", args.reading.history_limit.is_some()),
    ];
    if let Some(option) = given(&options) {
        return Err(format!("{path}: {option} needs a recording, not a maze").into());
    }
    let distances = Distances::flood(maze.walls(), maze.goals());
    let layers =
        Layers { numbers: args.distances, heat: args.heat, trail: false, ..Layers::default() };
    let scene = Scene::from_maze(&maze).with_numbers(|cell| distances.at(cell)).with_layers(layers);
    still(args, scene)
}

/// Returns the name of the first option that was given.
fn given<'o>(options: &[(&'o str, bool)]) -> Option<&'o str> {
    options.iter().find(|(_, is_given)| *is_given).map(|(name, _)| *name)
}

/// Draws the selected state, or only the maze if the recording has no states.
fn draw_state(args: &RenderArgs, file: &Path, recording: &Recording) -> PictureResult {
    let search = RecordedSearch::new(args, file, recording)?;
    let Some(last) = search.last else {
        let scene = Scene::from_map(&search.initial).with_truth(recording.maze());
        return still(args, scene.with_layers(search.layers));
    };
    search
        .show(&mut StateReader::new(recording, &search.initial), last, |scene| still(args, scene))?
}

fn animation(args: &RenderArgs, file: &Path, recording: &Recording) -> PictureResult {
    let search = RecordedSearch::new(args, file, recording)?;
    let Some(last) = search.last else {
        let file = file.display();
        return Err(format!("{file}: cannot animate a recording without states").into());
    };
    let states = last + 1;
    let indices = frame_indices(states, MAX_FRAMES);
    if indices.len() < states {
        let (frames, picture) = (indices.len(), args.output.path.display());
        note(format_args!("{picture}: drawing {frames} of {states} states, evenly spaced"));
    }
    let mut reader = StateReader::new(recording, &search.initial);
    let mut animation = None;
    for index in indices {
        search.show(&mut reader, index, |scene| {
            let scene = scene.with_theme(args.theme);
            let width_px = args.width.unwrap_or_else(|| scene.width_within(SIDE_PX));
            animation.get_or_insert_with(|| Animation::new(width_px)).push(&scene, FRAME_MS)
        })??;
    }
    Ok(animation.unwrap_or_else(|| Animation::new(SIDE_PX)).finish()?)
}

/// Draws a scene as SVG or PNG.
fn still(args: &RenderArgs, scene: Scene<'_>) -> PictureResult {
    Ok(draw_still(&scene.with_theme(args.theme), args.output.format, args.width)?)
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
    fn new(args: &RenderArgs, file: &'a Path, recording: &'a Recording) -> Result<Self, String> {
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
