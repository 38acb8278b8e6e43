//! Mice that move first and ask later: their known walls bound the shortest path in every state.

use mmsim_maze::{KnownMaze, Maze};
use mmsim_protocol::{Colour, WallState};
use mmsim_recording::{Block, History};
use mmsim_solvers::{PathBounds, steps_between};

use super::*;

const MICE: [(&str, &str); 6] = [
    ("bumper", include_str!("mice/bumper.py")),
    ("wall-follower", include_str!("mice/wall-follower.py")),
    ("strides", include_str!("mice/strides.py")),
    ("diagonal", include_str!("mice/diagonal.py")),
    ("liar", include_str!("mice/liar.py")),
    ("flood-fill", include_str!("mice/flood-fill.py")),
];

/// The maximum memory of the history for the update of a state, on average, in bytes. Includes log
/// lines, although their length depends on the author of the mouse.
const MAX_UPDATE_BYTES: usize = 16;

/// How well the states of a recording describe what the mouse knows.
#[derive(Debug, Default)]
struct Report {
    states: usize,
    /// The number of states whose flags alone claim a path that is too short or a maze that has no
    /// path.
    misleading: usize,
    /// The number of walls that are known in the last state.
    known: usize,
    /// The memory of the history for updates, in bytes: the readings, everything that the mouse
    /// displays, its name and its log.
    update_bytes: usize,
}

/// Checks the bounds in every state of a recording. The recording contains the true maze.
fn check(name: &str, recording: &Recording) -> Report {
    let maze: &Maze = recording.maze().unwrap();
    let unexplored = KnownMaze::unexplored(maze);
    let shortest = steps_between(maze.walls(), maze.start().cell, maze.goals()).unwrap();
    let encloses = |bounds: PathBounds| {
        bounds.optimistic.is_some_and(|steps| steps <= shortest)
            && bounds.pessimistic.is_none_or(|steps| shortest <= steps)
    };
    let mut report = Report::default();
    let history = recording.history();
    let mut plain = History::new(maze.size());
    for block in 0..history.len().div_ceil(Block::STATES) {
        let states = history.block(block).unwrap().unpack().unwrap();
        for index in (block * Block::STATES..).take(states.len()) {
            plain.push(states.get(index).unwrap()).unwrap();
            let state = State::decode(states.get(index).unwrap(), maze.size()).unwrap();
            let context = states.context(index).unwrap();
            // An honest mouse claims exactly the walls that it has read, so the bounds hold without
            // the true maze.
            let is_honest = name != "liar";
            let known = context.known_maze(&state, &unexplored, (!is_honest).then_some(maze));
            if is_honest {
                let claimed = context.claimed_maze(&state, &unexplored);
                assert_eq!(claimed, known, "{name}, state {index}");
            }
            let bounds = PathBounds::new(&known);
            assert!(encloses(bounds), "{name}, state {index}: {bounds:?}, shortest {shortest}");
            let flags = PathBounds::new(&state.map(maze.start().cell, *maze.goals()));
            report.misleading += usize::from(!encloses(flags));
            report.states += 1;
            report.known = known_walls(&known);
        }
    }
    report.update_bytes = history.bytes() - plain.bytes();
    report
}

fn known_walls(map: &KnownMaze) -> usize {
    let sides = map.size().cells().flat_map(|cell| Heading::ALL.map(|heading| (cell, heading)));
    sides.filter(|&(cell, heading)| map.wall(cell, heading) != WallState::Unknown).count()
}

#[test]
fn known_walls_of_mice_that_move_first_bound_the_shortest_path() {
    let Some(python) = python() else { return };
    let home = Home::new();
    for (name, mouse) in MICE {
        let mut misleading = 0;
        for maze in ["harbour", "hedgerow"] {
            let (script, folder) = (format!("{name}.py"), format!("{name}-{maze}"));
            home.write(&script, PREAMBLE.to_string() + mouse);
            let options = [&QUIET[..], &["--maze", maze, "--record", &folder]].concat();
            let ended = home.run(&arguments(&options, &[python, &script]));
            assert_eq!(ended.code, Some(0), "{name} in {maze}: {ended:?}");
            let recording = recording(&home.path().join(&folder));
            let context = recording.history().newest_context();
            assert_eq!(context.notes().mouse(), Some(script.as_str()));
            let report = check(name, &recording);
            println!("{name} in {maze}: {report:?}");
            let outer = known_walls(&KnownMaze::unexplored(recording.maze().unwrap()));
            assert!(report.states > 200 && report.known > outer, "{name} in {maze}: {report:?}");
            let max_bytes = MAX_UPDATE_BYTES * report.states;
            assert!(report.update_bytes <= max_bytes, "{name} in {maze}: {report:?}");
            misleading += report.misleading;
        }
        // The other mice do not come near the goal.
        let explores = matches!(name, "wall-follower" | "strides" | "liar" | "flood-fill");
        assert!(misleading > 0 || !explores, "the flags of {name} are never misleading");
    }
}

/// In an open maze, the flood-fill mouse knows the distances from the beginning.
#[test]
fn a_recording_contains_texts_colours_and_the_log() {
    let home = Home::new();
    home.write("open.txt", "o---o---o---o---o---o\n| S                 |\no---o---o---o---o---o\n");
    let mouse = include_str!("mice/flood-fill.py");
    let Some(ended) = run(&home, &["--maze", "open.txt", "--record", "seen"], mouse) else {
        return;
    };
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let recording = recording(&home.path().join("seen"));
    let history = recording.history();
    let poses = states(&recording, |state| state.pose());
    let (mut seen, mut lines) = (Vec::new(), Vec::new());
    for index in 0..history.len() {
        let log = history.log(index, usize::MAX, |_| true).into_iter();
        lines.extend(log.filter(|line| line.state == index).map(|line| line.text));
        // If the machine is busy, a change arrives in a further state before the next movement.
        if index > 0 && index + 1 < history.len() && poses[index] == poses[index - 1] {
            continue;
        }
        let context = history.context(index).unwrap();
        let cells = [0, 1, 2, 3, 4].map(|x| Cell::new(x, 0)).map(|cell| {
            let colour = context.notes().colour(cell).map_or('-', Colour::letter);
            format!("{}{colour}", context.notes().text(cell))
        });
        let line = format!("{} {}", cells.join(" "), lines.join("; "));
        lines.clear();
        seen.push(line.trim_end().to_string());
    }
    insta::assert_snapshot!(seen.join("\n"), @"
    - - - - -
    2- 1- 0- 1- 2- run 0 to (2, 0)
    2- 1- 0- 1- 2-
    2- 1g 0- 1- 2-
    0- 1- 2- 3- 4- run 1 to (0, 0)
    0- 1- 2- 3- 4-
    0- 1- 2- 3- 4-
    0- 1b 2- 3- 4-
    2- 1- 0- 1- 2- run 2 to (2, 0)
    2- 1- 0- 1- 2-
    2- 1- 0- 1- 2-
    2- 1y 0- 1- 2-
    0- 1- 2- 3- 4- run 3 to (0, 0)
    0- 1- 2- 3- 4-
    0- 1- 2- 3- 4-
    0- 1r 2- 3- 4-
    0r 1r 2- 3- 4-
    ");
}

#[test]
fn all_colours_of_mms_are_recorded() {
    let Some(mouse) = mmsim_tests::shared("strangers/mice/mms_colours.py") else { return };
    let (home, Some(python)) = (Home::new(), python()) else { return };
    let mouse = mouse.to_str().unwrap();
    let ended =
        home.run(&arguments(&[&QUIET[..], &["--record", "seen"]].concat(), &[python, mouse]));
    assert!(ended.stderr.contains("exited with code 0"), "{ended:?}");
    assert!(!ended.stderr.contains("mms: line"), "{ended:?}");
    let recording = recording(&home.path().join("seen"));
    let context = recording.last_context();
    let colours = [0, 1].map(|y| context.notes().colour(Cell::new(0, y)));
    assert_eq!(colours, [Some(Colour::DarkViolet), Some(Colour::DarkOrange)]);
}
