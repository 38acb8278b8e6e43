//! Checks that annotations are stored exactly and take little space.

use std::fs;
use std::path::Path;

use mmsim_client::{Exchange, InMemory};
use mmsim_formats::Catalogue;
use mmsim_maze::{Cell, KnownMaze, Maze, MazeSize, Unknown};
use mmsim_protocol::{Annotation, Colour};
use mmsim_recording::{Block, History, Recording, RecordingWriter};
use mmsim_server::Simulation;
use mmsim_solvers::{BundledStrategy, Distances, Mouse, SearchDriver};

/// The maximum size of the annotations of a mouse like those of mms, in bytes per state.
const MAX_BYTES_PER_STATE: usize = 16;

/// Which annotations a mouse sends before each state.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Style {
    Nothing,
    Changes,
    Everything,
}

/// The texts and colours of all cells.
type Display = Vec<(Cell, String, Option<Colour>)>;

/// Searches the maze several times without a reset, like the template mouse of mms with flood fill:
/// the texts are the distances to the goal, and visited cells are green. Returns what the mouse
/// displays at each state, and the size of the history after it has compressed a block for the last
/// time.
fn search(
    simulation: &mut Simulation,
    writer: &mut RecordingWriter,
    style: Style,
) -> (Vec<Display>, Packed) {
    let maze = simulation.maze().clone();
    let mut packed = Packed { states: 0, bytes: 0 };
    let mut transport = InMemory::new(|request, reply| {
        simulation.handle(request, reply);
        if request.starts_with(b"S") {
            let update = simulation.history().newest_update();
            writer.write_with_update(update, request).unwrap();
            let (states, bytes) = (simulation.history().len(), simulation.history().bytes());
            if states % Block::STATES == 1 {
                packed = Packed { states, bytes };
            }
        }
    });
    let mut exchange = Exchange::new(&mut transport);
    let (mut displays, mut old): (Vec<Display>, Display) = Default::default();
    for strategy in [BundledStrategy::FloodFill, BundledStrategy::Swing, BundledStrategy::FloodFill]
    {
        let mut mouse = Mouse::new(strategy.strategy(), KnownMaze::unexplored(&maze), maze.start());
        let mut driver = SearchDriver::new(&mut mouse, 1000);
        while driver.advance(|pose| exchange.walls(pose)).is_ok_and(|goes_on| goes_on) {
            let mouse = driver.mouse();
            let distances = Distances::flood(mouse.map().walls(Unknown::Open), maze.goals());
            let display = |cell| {
                // The mouse counts eight units for each step.
                let text = distances.at(cell).map_or("-".into(), |steps| (8 * steps).to_string());
                (cell, text, mouse.map().visited().contains(cell).then_some(Colour::DarkGreen))
            };
            let new: Display = maze.size().cells().map(display).collect();
            let sends = |index: usize, is_changed: bool| match style {
                Style::Nothing => false,
                Style::Changes => is_changed || old.get(index).is_none(),
                Style::Everything => true,
            };
            let annotations = new.iter().enumerate().flat_map(|(index, (cell, text, colour))| {
                let (cell, colour) = (*cell, *colour);
                let text = Annotation::Text { cell, text };
                let text_changed = old.get(index).is_none_or(|old| old.1 != new[index].1);
                let colour_changed = old.get(index).is_none_or(|old| old.2 != colour);
                let text = sends(index, text_changed).then_some(text);
                let colour = Annotation::Colour { cell, colour };
                text.into_iter().chain(sends(index, colour_changed).then_some(colour))
            });
            exchange.annotate(annotations).unwrap();
            exchange
                .state(mouse.pose(), mouse.map(), |cell| mouse.weight(cell).unwrap_or(255))
                .unwrap();
            old.clone_from(&new);
            displays.push(new);
        }
    }
    (displays, packed)
}

/// The size of the first states of a history.
#[derive(Debug)]
struct Packed {
    states: usize,
    bytes: usize,
}

/// The size of a search in bytes.
#[derive(Debug)]
struct Size {
    states: usize,
    history: usize,
    packed: Packed,
    recording: usize,
}

/// Records a search, and checks what is stored.
fn record(path: &Path, maze: &Maze, style: Style) -> Size {
    let mut simulation = Simulation::new("maze", maze.clone());
    let mut writer = RecordingWriter::create(path, &simulation.info(), Some(maze)).unwrap();
    let (displays, packed) = search(&mut simulation, &mut writer, style);
    writer.close().unwrap();
    let recording = Recording::open(path).unwrap();
    if style != Style::Nothing {
        check(simulation.history(), &displays);
        check(recording.history(), &displays);
    }
    let history = simulation.history();
    Size {
        states: history.len(),
        history: history.bytes(),
        packed,
        recording: fs::metadata(path).unwrap().len().try_into().unwrap(),
    }
}

/// Checks that the notes at each state are what the mouse displayed.
fn check(history: &History, displays: &[Display]) {
    assert_eq!(history.len(), displays.len());
    for (block, displays) in displays.chunks(Block::STATES).enumerate() {
        let states = history.block(block).unwrap().unpack().unwrap();
        for (index, display) in (block * Block::STATES..).zip(displays) {
            let context = states.context(index).unwrap();
            let notes = context.notes();
            for (cell, text, colour) in display {
                assert_eq!((notes.text(*cell), notes.colour(*cell)), (&**text, *colour));
            }
        }
    }
}

#[test]
fn annotations_of_a_flood_fill_mouse_take_at_most_sixteen_bytes_per_state() {
    let folder = tempfile::tempdir().unwrap();
    let (mut states, mut history, mut recording) = (0, 0, 0);
    let mut largest = [0; 2];
    let catalogue = Catalogue::bundled();
    let mazes = catalogue.entries().iter().map(|entry| (entry.name(), entry.maze().unwrap()));
    let classic = mazes.filter(|(_, maze)| maze.size() == MazeSize::CLASSIC);
    for (name, maze) in classic {
        let sizes = [Style::Nothing, Style::Changes, Style::Everything].map(|style| {
            let path = folder.path().join(format!("{}-{}.mcap", name, style as u8));
            record(&path, &maze, style)
        });
        println!("{name}: {sizes:?}");
        let [nothing, changes, everything] = sizes;
        assert_eq!(changes.history, everything.history, "unchanged annotations take space");
        // The newest states of a history are not compressed yet.
        let added = [
            (changes.packed.bytes - nothing.packed.bytes, nothing.packed.states),
            (changes.recording - nothing.recording, nothing.states),
        ];
        for (largest, (bytes, states)) in largest.iter_mut().zip(added) {
            assert!(bytes <= MAX_BYTES_PER_STATE * states, "{name}: {bytes} for {states} states");
            *largest = (*largest).max(bytes.div_ceil(states));
        }
        states += nothing.states;
        history += changes.history - nothing.history;
        recording += changes.recording - nothing.recording;
    }
    println!("at most {largest:?} bytes per state of a maze in histories and recordings");
    println!("{states} states, history {history} bytes, recordings {recording} bytes");
    assert!(history <= MAX_BYTES_PER_STATE * states);
    assert!(recording <= MAX_BYTES_PER_STATE * states);
}
