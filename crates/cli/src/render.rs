//! `mmsim render`: pictures of mazes and recordings.

mod args;

pub(crate) use args::RenderArgs;

use std::path::Path;

use args::{PictureFormat, ThemeArg};
use mmsim_drawing::{
    Animation, FRAME_MS, Layers, MAX_FRAMES, Scene, TRAIL_CELLS, Theme, frame_indices,
};
use mmsim_maze::{KnownMaze, Maze};
use mmsim_protocol::State;
use mmsim_recording::{HistoryReader, OpenError, ReadError, Recording};
use mmsim_solvers::Distances;

use crate::Outcome;
use crate::keep;
use crate::output::{replace, say};
use crate::replay::{is_whole, no_state};
use crate::selection::{Collection, Selected};

/// How many pixels the longer side of a picture has unless its width is given.
const SIDE_PX: u32 = 640;

pub(crate) fn run(args: &RenderArgs) -> Outcome {
    let source = args.source.join(" ");
    let (picture, is_good) = match recording(args, Path::new(&source))? {
        Some(recording) => {
            let file = Path::new(&source);
            let picture = if args.output.format == PictureFormat::Gif {
                animation(args, file, &recording)?
            } else {
                moment(args, file, &recording)?
            };
            (picture, is_whole(file, &recording))
        }
        None => (maze(args, &source)?, true),
    };
    replace(&args.output.path, &picture)?;
    Ok(is_good)
}

/// The recording in this file. A file that is none and is not called one is taken for a maze.
fn recording(
    args: &RenderArgs,
    file: &Path,
) -> Result<Option<Recording>, Box<dyn std::error::Error>> {
    let is_called_one = file.extension().is_some_and(|extension| extension == "mcap");
    match Recording::open_within(file, &keep::budget(&args.reading)) {
        Ok(recording) => Ok(Some(recording)),
        Err(OpenError::Io { .. } | OpenError::Content { source: ReadError::NotMcap, .. })
            if !is_called_one =>
        {
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}

fn maze(args: &RenderArgs, name: &str) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let Selected { path, maze, .. } =
        Collection::with(name, args.mazes.as_deref())?.select(name)?;
    let path = path.display();
    if args.output.format == PictureFormat::Gif {
        return Err(format!("{path}: expected a recording to make a .gif of, found a maze").into());
    }
    if args.at.is_some() {
        return Err(format!("{path}: expected a recording for --at, found a maze").into());
    }
    let distances = Distances::flood(maze.walls(), maze.goals());
    let layers = Layers { numbers: args.distances, heat: args.heat, trail: false };
    let scene = Scene::from_maze(&maze).with_numbers(|cell| distances.at(cell)).with_layers(layers);
    still(args, scene)
}

/// The picture of one state, or of the maze if there is none.
fn moment(
    args: &RenderArgs,
    file: &Path,
    recording: &Recording,
) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let search = Search::of(args, file, recording)?;
    let Some(last) = search.last else {
        let scene = Scene::from_map(&search.before).with_truth(recording.maze());
        return still(args, scene.with_layers(search.layers));
    };
    search.show(&mut recording.history().reader(), last, |scene| still(args, scene))?
}

fn animation(
    args: &RenderArgs,
    file: &Path,
    recording: &Recording,
) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let search = Search::of(args, file, recording)?;
    let Some(last) = search.last else {
        let file = file.display();
        return Err(format!("{file}: expected a state to make a .gif of, found none").into());
    };
    let states = last + 1;
    let indices = frame_indices(states, MAX_FRAMES);
    if indices.len() < states {
        let (frames, picture) = (indices.len(), args.output.path.display());
        say(format_args!("{picture}: {frames} frames, evenly spaced, of {states} states"));
    }
    let mut reader = recording.history().reader();
    let mut animation = None;
    for index in indices {
        search.show(&mut reader, index, |scene| {
            let scene = scene.with_theme(theme(args));
            let width_px = args.width.unwrap_or_else(|| scene.width_within(SIDE_PX));
            animation.get_or_insert_with(|| Animation::new(width_px)).push(&scene, FRAME_MS)
        })??;
    }
    Ok(animation.unwrap_or_else(|| Animation::new(SIDE_PX)).finish()?)
}

/// A scene as a file that does not move.
fn still(args: &RenderArgs, scene: Scene<'_>) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let scene = scene.with_theme(theme(args));
    if args.output.format == PictureFormat::Svg {
        return Ok(scene.svg().into_bytes());
    }
    Ok(scene.png(args.width.unwrap_or_else(|| scene.width_within(SIDE_PX)))?)
}

fn theme(args: &RenderArgs) -> Theme {
    match args.theme {
        ThemeArg::Light => Theme::Light,
        ThemeArg::Dark => Theme::Dark,
    }
}

/// The states of a recording, to be drawn one by one.
struct Search<'a> {
    truth: Option<&'a Maze>,
    /// What a client knows before its first state, with the start and the goals.
    before: KnownMaze,
    /// The last state to be drawn.
    last: Option<usize>,
    layers: Layers,
    file: &'a Path,
}

impl<'a> Search<'a> {
    fn of(args: &RenderArgs, file: &'a Path, recording: &'a Recording) -> Result<Self, String> {
        let (info, states) = (recording.info(), recording.history().len());
        if args.distances {
            let file = file.display();
            return Err(format!("{file}: expected a maze for --distances, found a recording"));
        }
        if let Some(index) = args.at.filter(|&index| index >= states) {
            return Err(no_state(file, recording, index));
        }
        let last = args.at.or(states.checked_sub(1));
        Ok(Self {
            truth: recording.maze(),
            before: info.known_maze().ok_or_else(|| unreadable(file))?,
            last,
            layers: Layers { numbers: !args.no_numbers, heat: args.heat, trail: !args.no_trail },
            file,
        })
    }

    /// Shows a state to `draw`.
    fn show<T>(
        &self,
        reader: &mut HistoryReader<'_>,
        index: usize,
        draw: impl FnOnce(Scene<'_>) -> T,
    ) -> Result<T, String> {
        let mut trail = Vec::new();
        for index in index.saturating_sub(TRAIL_CELLS - 1)..=index {
            let state = reader
                .get(index)
                .and_then(|message| State::decode(message, self.before.size()).ok());
            trail.push(state.ok_or_else(|| unreadable(self.file))?.pose().cell);
        }
        let message = reader.get(index).ok_or_else(|| unreadable(self.file))?;
        let state: State<'_> =
            State::decode(message, self.before.size()).map_err(|_| unreadable(self.file))?;
        let map = state.map(self.before.start(), *self.before.goals());
        let scene = Scene::from_map(&map)
            .with_truth(self.truth)
            .with_mouse(state.pose())
            .with_weights(|cell| state.weights().at(cell).unwrap_or(0))
            .with_trail(&trail)
            .with_layers(self.layers);
        Ok(draw(scene))
    }
}

fn unreadable(file: &Path) -> String {
    format!("{}: expected a state, found something else", file.display())
}
