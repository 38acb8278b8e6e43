//! `mmsim run` with mice for mms: a mouse in Rust, and with Python mice.

#[path = "../harness/mod.rs"]
mod harness;

#[cfg(not(all(windows, target_env = "gnu")))] // needs a server of libzmq
mod annotations;
mod ending;
mod known_walls;
mod slalom;
mod strangers;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use harness::{Home, Output, Serving};
use mmsim_maze::{Cell, CellSet, Heading, MazeSize};
use mmsim_protocol::{Request, State};
use mmsim_recording::Recording;
use mmsim_tests::{ask, connect_to, output, wait_for_exit};
use serde_json::json;

/// The first lines of the script of every Python mouse.
const PREAMBLE: &str = "\
import os, sys, time

def say(line):
    print(line, flush=True)

def ask(line):
    say(line)
    return sys.stdin.readline().rstrip('\\n')

";

/// Returns the name of the Python interpreter. If Python is missing, prints a message and returns
/// `None`, or panics if `MMSIM_CLIENTS=required` is set.
fn python() -> Option<&'static str> {
    let works = |name: &&str| {
        let quiet = || Stdio::null();
        let command = Command::new(name).arg("--version").stdout(quiet()).stderr(quiet()).spawn();
        command.is_ok_and(|mut child| wait_for_exit(&mut child).success())
    };
    let found = ["python3", "python"].into_iter().find(works);
    if found.is_none() {
        let wanted = std::env::var("MMSIM_CLIENTS");
        assert_ne!(wanted.as_deref(), Ok("required"), "there is no python3");
        let _ = writeln!(std::io::stderr(), "skipped, python3 is not there");
    }
    found
}

/// Returns the path of the mouse `examples/mms-mouse.rs`, which cargo builds with the tests.
fn rust_mouse() -> PathBuf {
    let name = format!("mms-mouse{}", std::env::consts::EXE_SUFFIX);
    let path = Path::new(env!("CARGO_BIN_EXE_mmsim")).with_file_name("examples").join(name);
    assert!(path.exists(), "first run `cargo build -p mmsim --examples`");
    path
}

fn arguments<'a>(options: &[&'a str], mouse: &[&'a str]) -> Vec<&'a str> {
    [&["run"], options, &["--"], mouse].concat()
}

const QUIET: [&str; 3] = ["--port", "0", "--no-viewer"];

/// Returns a command that runs a Python mouse, or `None` if there is no interpreter.
fn command(home: &Home, options: &[&str], mouse: &str) -> Option<Command> {
    let python = python()?;
    home.write("mouse.py", PREAMBLE.to_string() + mouse);
    Some(home.command(&arguments(options, &[python, "mouse.py"])))
}

/// Runs a Python mouse to completion with `mmsim run`, which also serves the maze.
fn run(home: &Home, options: &[&str], mouse: &str) -> Option<Output> {
    let python = python()?;
    home.write("mouse.py", PREAMBLE.to_string() + mouse);
    Some(home.run(&arguments(&[&QUIET[..], options].concat(), &[python, "mouse.py"])))
}

/// Returns the only recording in a folder.
fn recording(folder: &Path) -> Recording {
    let mut files: Vec<_> =
        fs::read_dir(folder).unwrap().map(|file| file.unwrap().path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    Recording::open(&files.remove(0)).unwrap()
}

fn states<R>(recording: &Recording, mut each: impl FnMut(State<'_>) -> R) -> Vec<R> {
    let (size, messages) = (recording.size(), recording.history().iter());
    let state = |message: Vec<u8>| match Request::decode(&message, size) {
        Ok(Request::State(state)) => each(state),
        other => panic!("{other:?}"),
    };
    messages.map(state).collect()
}

#[test]
fn a_mouse_in_rust_reaches_the_goal() {
    let home = Home::new();
    let mouse = rust_mouse();
    let options = [&QUIET[..], &["--maze", "hedgerow", "--score", "--record", "seen"]].concat();
    let ended = home.run(&arguments(&options, &[mouse.to_str().unwrap()]));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    // The mouse moves cell by cell, and each cell counts as two half steps.
    insta::assert_snapshot!(ended.stdout, @"
    score: 556.6
    best-run-distance: 382
    best-run-effective-distance: 382
    best-run-turns: 124
    total-distance: 382
    total-effective-distance: 382
    total-turns: 124
    ");
    let messages = ended.stderr.lines().last();
    assert_eq!(messages, Some("mouse exited with code 0; goal reached, score 556.6"));
    let recording = recording(&home.path().join("seen"));
    let mut poses = states(&recording, |state| state.pose());
    // Further states show the markers that the mouse sets while it does not move.
    poses.dedup();
    let size = MazeSize::CLASSIC;
    // There is a state at the start, after each step and after each turn.
    assert_eq!(poses.len(), 1 + 191 + 124);
    assert_eq!(poses[0].cell, Cell::new(0, 0));
    for (before, after) in poses.iter().zip(&poses[1..]) {
        let (x, y) = (before.cell.x.abs_diff(after.cell.x), before.cell.y.abs_diff(after.cell.y));
        assert!(x + y <= 1, "{before} {after}");
    }
    assert!(size.central_cells().contains(poses.last().unwrap().cell));
    let maze = recording.maze().unwrap();
    states(&recording, |state| {
        for cell in size.cells() {
            for heading in Heading::ALL {
                let is_believed = state.cell_walls(cell).unwrap().wall(heading);
                assert!(!is_believed || maze.walls().has(cell, heading), "{cell} {heading}");
            }
        }
    });
    // The weights are the distances that the mouse wrote into the cells.
    let last = states(&recording, |state| {
        let visited: CellSet =
            size.cells().filter(|&cell| state.cell_walls(cell).unwrap().visited()).collect();
        let goals = size.central_cells();
        let zeros = size.cells().filter(|&cell| state.weights().at(cell) == Some(0));
        (visited.len(), goals.iter().eq(zeros))
    });
    assert_eq!(last.last(), Some(&(126, true)));
}

const SMALL: &str = "\
o---o---o---o---o
|             G |
o   o   o---o---o
|   |   |       |
o   o---o   o   o
| S |       |   |
o---o---o---o---o
";

#[test]
fn a_python_mouse_can_use_every_command() {
    let home = Home::new();
    home.write("small.txt", SMALL);
    let mouse = r"
for line, reply in [
    ('mazeWidth', '4'), ('mazeHeight', '3'),
    ('wallFront', 'false'), ('wallRight', 'true'), ('wallLeft', 'true'), ('wallBack', 'true'),
    ('wallFrontRight', 'true'), ('wallFrontLeft', 'true'),
    ('wallBackRight', 'true'), ('wallBackLeft', 'true'),
    ('wallFront 4', 'false'), ('wallFront 5', 'true'),
    ('turnRight', 'ack'), ('turnLeft', 'ack'), ('turnRight90', 'ack'), ('turnLeft90', 'ack'),
    ('turnRight45', 'ack'), ('turnLeft45', 'ack'),
    ('moveForwardHalf', 'ack'), ('moveForwardHalf 3', 'ack'), ('moveForward', 'crash'),
    ('turnRight', 'ack'), ('moveForward', 'ack'), ('moveForward 2', 'ack'), ('moveForward 0', 'crash'),
    ('wasReset', 'false'), ('ackReset', 'ack'), ('moveForward 9', 'crash'),
    ('getStat total-distance', '28'), ('getStat total-turns', '7'),
    ('getStat total-effective-distance', '33.5'),
    ('getStat best-run-distance', '10'), ('getStat best-run-turns', '1'),
    ('getStat best-run-effective-distance', '8.5'),
    ('getStat current-run-distance', '18'), ('getStat current-run-turns', '0'),
    ('getStat current-run-effective-distance', '25'), ('getStat score', '13.55'),
]:
    assert ask(line) == reply, line
for line in [
    'setWall 0 0 e', 'setWall 3 0 w', 'clearWall 3 0 w', 'setColor 0 0 G', 'clearColor 0 0', 'setColor 1 1 k',
    'clearAllColor', 'setText 1 1 two words', 'setText 2 1 300', 'clearText 1 1', 'clearAllText',
    'setText 0 0 12', 'setText 1 0 99999',
]:
    say(line)
";
    let Some(ended) = run(&home, &["--maze", "small.txt", "--json", "--record", "seen"], mouse)
    else {
        return;
    };
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(!ended.stderr.contains("mms: line"), "{ended:?}");
    let by_mms = json!({
        "score": 13.55,
        "best_run_distance": 10.0,
        "best_run_effective_distance": 8.5,
        "best_run_turns": 1,
        "total_distance": 28.0,
        "total_effective_distance": 33.5,
        "total_turns": 7,
    });
    let in_cells = json!({
        "score": 8.9,
        "best_run_distance": 5.0,
        "best_run_effective_distance": 5.0,
        "best_run_turns": 1,
        "total_distance": 7.0,
        "total_effective_distance": 22.0,
        "total_turns": 7,
    });
    let mut report = json!({
        "maze": "small",
        "goal_reached": true,
        "scores": "mms-1.2",
        "scores_by": { "mms-1.2": by_mms.clone(), "cells": in_cells },
        "visited_cells": 6,
        "crashes": 3,
        "refused_requests": 0,
        "mouse": "mouse.py",
        "kind": "mms",
        "states": 16,
        "ending": "finished",
        "exit_code": 0,
        "moves": null,
        "fast_run_time_s": null,
        "signal": null,
        "error": null,
        "cause": null,
        "random": null,
    });
    report.as_object_mut().unwrap().extend(by_mms.as_object().unwrap().clone());
    let mut found = ended.json();
    let mut take = |key: &str| found.as_object_mut().unwrap().remove(key).unwrap();
    // 5 cells of 0.3 s and 5 turns of 0.2 s; 450 mm with 17 m/s² and at most 2.5 m/s.
    let phases = take("phases");
    let times = ["search_run", "fast_run", "total"].map(|run| phases[run]["time_s"].clone());
    assert_eq!(times, [2.5, 0.3271, 2.8271].map(|time| json!(time)));
    assert_eq!([take("vehicle"), take("fastest_run_proven")], [json!("expert"), json!(true)]);
    assert_eq!(take("known_run_time_s"), take("fastest_run_lower_bound_s"));
    assert_eq!(found, report);
    let recording = recording(&home.path().join("seen"));
    let last = states(&recording, |state| {
        let wall = |x, y, heading| state.cell_walls(Cell::new(x, y)).unwrap().wall(heading);
        let marked = (wall(1, 0, Heading::West), wall(3, 0, Heading::West));
        (
            state.pose().cell,
            state.weights().at(Cell::new(0, 0)),
            state.weights().at(Cell::new(1, 0)),
            marked,
        )
    });
    // The mouse cleared a wall that exists in the maze.
    assert_eq!(last.last(), Some(&(Cell::new(0, 2), Some(12), Some(255), (true, false))));
}

#[test]
fn unknown_commands_are_reported_immediately() {
    let home = Home::new();
    let mouse = "ask('moveForward')\nask('moveForwrad')";
    let Some(command) = command(&home, &QUIET, mouse) else { return };
    // The mouse waits for a reply that never comes.
    let mut hanging = Serving::start(command, "mms: line 2: ");
    assert!(hanging.messages.ends_with("mms: line 2: unknown command \"moveForwrad\"\n"));
    hanging.kill();
    hanging.wait();
}

#[test]
fn a_repeated_error_is_counted() {
    let home = Home::new();
    // In one piece, so that the mouse is never silent after an invalid line.
    let mouse = "ask('hello\\nsetText 99 0 1\\n' * 1000 + 'mazeWidth')";
    let Some(ended) = run(&home, &["--as", "mms", "--json"], mouse) else { return };
    assert_eq!(ended.json()["refused_requests"], json!(2000));
    let messages: Vec<_> = ended.stderr.lines().filter(|line| line.starts_with("mms: ")).collect();
    assert_eq!(messages.len(), 2 * (5 + 1), "{messages:#?}");
    let summary = ended.stderr.lines().last().unwrap();
    let end = "goal not reached, score 2000; 2000 invalid lines: never moved";
    assert!(summary.ends_with(end), "{summary}");
}

#[test]
fn a_counted_line_is_reported_when_the_mouse_waits() {
    let home = Home::new();
    // In one piece, so that the mouse is silent only at the end.
    let mouse = "ask('debug\\n' * 10 + 'moveForwrad')";
    let options = [&QUIET[..], &["--as", "mms"]].concat();
    let Some(command) = command(&home, &options, mouse) else { return };
    let mut hanging = Serving::start(command, "mms: line 11: ");
    assert!(hanging.messages.ends_with("mms: line 11: unknown command \"moveForwrad\"\n"));
    hanging.kill();
    hanging.wait();
}

#[test]
fn incomplete_lines_are_reported() {
    let home = Home::new();
    let mouse = "
say('turnLeft')
# The mouse thinks for longer than an incomplete line may last.
import time
time.sleep(1.5)
sys.stdout.write('mazeWidth')
sys.stdout.flush()
sys.stdin.readline(), sys.stdin.readline()
";
    let Some(command) = command(&home, &QUIET, mouse) else { return };
    let mut hanging = Serving::start(command, "mms: line 2: ");
    let expected = "mms: line 2: waiting for a newline after \"mazeWidth\"\n";
    assert!(hanging.messages.ends_with(expected), "{}", hanging.messages);
    hanging.kill();
    hanging.wait();
}

#[test]
fn arbitrary_lines_do_not_stop_the_command() {
    let home = Home::new();
    let mouse = r"
out = sys.stdout.buffer
out.write(b'\xff\xfe\n\n')
out.write(b'x' * 1000000 + b'\n')
out.write(b'setText 0 0 ' + b'y' * 4000 + b'\r\n')
out.write(b'setWall 99 0 n\n')
out.write(b'Starting up... \x1b[2J\n')
out.flush()
assert ask('total-turns') == '0'
out.write(b'moveFor')
out.flush()
os._exit(3)
";
    let Some(ended) = run(&home, &["--as", "mms", "--json"], mouse) else { return };
    assert_eq!(ended.code, Some(3), "{ended:?}");
    assert_eq!(ended.json()["refused_requests"], json!(5), "a blank line is none");
    let messages: Vec<_> = ended.stderr.lines().filter(|line| line.starts_with("mms: ")).collect();
    insta::assert_snapshot!(messages.join("\n"), @r#"
    mms: line 1: unknown command "\xff\xfe"
    mms: line 3: expected at most 4096 bytes, found a longer line that starts with "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx"
    mms: line 5: expected a cell in a maze of 16x16 cells, found "setWall 99 0 n"
    mms: line 6: unknown command "Starting up... \x1b[2J"
    mms: line 8: expected a newline, found the end of output after "moveFor"
    "#);
}

#[test]
fn a_mouse_may_write_before_it_reads() {
    let home = Home::new();
    let mouse = r"
out = sys.stdout
for i in range(100000):
    out.write('setColor %d %d r\n' % (i % 16, i // 16 % 16))
    if i % 5 == 0:
        out.write('wallFront\n')
out.flush()
for i in range(20000):
    assert sys.stdin.readline() == 'false\n'
";
    let Some(ended) = run(&home, &["--maze", "hedgerow"], mouse) else { return };
    assert_eq!(ended.code, Some(0), "{ended:?}");
}

#[test]
fn a_mouse_that_never_reads_is_stopped() {
    let home = Home::new();
    let some = "for i in range(20000): say('wallFront')";
    let Some(ended) = run(&home, &[], some) else { return };
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let for_ever = "while True: sys.stdout.write('wallFront\\n' * 1000)";
    let ended = run(&home, &[], for_ever).unwrap();
    assert_eq!(ended.code, Some(1), "{ended:?}");
    let expected = "mmsim: the mouse is not reading its replies (1048576 unread)\n";
    assert!(ended.stderr.contains(expected), "{ended:?}");
}

#[test]
fn a_line_on_stdin_presses_the_reset_button() {
    let home = Home::new();
    let mouse = r"
assert ask('wasReset') == 'false'
ask('moveForward')
print('ready', file=sys.stderr, flush=True)
while ask('wasReset') == 'false':
    time.sleep(0.01)
assert ask('ackReset') == 'ack'
assert ask('wasReset') == 'false'
assert ask('wallBack') == 'true'
";
    let Some(mut command) = command(&home, &QUIET, mouse) else { return };
    let pipes = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = pipes.spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let messages = harness::read_until(child.stderr.take().unwrap(), "ready").1;
    assert!(!messages.contains("press Enter"), "that is for terminals");
    stdin.write_all(b"\n").unwrap();
    assert_eq!(wait_for_exit(&mut child).code(), Some(0));
}

#[test]
fn a_mouse_searches_the_maze_of_another_simulator() {
    let home = Home::new();
    home.write("small.txt", SMALL);
    let server = home.serve(&["small.txt", "--port", "0"]);
    let mouse = r"
width = ask('mazeWidth')
ask('moveForward 2'), ask('turnRight'), ask('moveForward 3')
sys.exit(int(width))
";
    let connect = |more: &[&'static str]| {
        let python = python()?;
        home.write("mouse.py", PREAMBLE.to_string() + mouse);
        let options = [&["--connect", &server.address, "--score"], more].concat();
        Some(home.run(&arguments(&options, &[python, "mouse.py"])))
    };
    let Some(ended) = connect(&["--goal", "server"]) else { return };
    assert_eq!(ended.code, Some(4), "{ended:?}");
    assert!(ended.stdout.starts_with("score: 8.8\nbest-run-distance: 10\n"), "{ended:?}");
    let in_cells = connect(&["--goal", "server", "--scores", "cells"]).unwrap();
    assert!(in_cells.stdout.starts_with("score: 6.05\nbest-run-distance: 5\n"), "{in_cells:?}");
    let configured = connect(&["--size", "4x3", "--goal", "2,2", "3,2"]).unwrap();
    assert_eq!((configured.code, &configured.stdout), (Some(4), &ended.stdout));
    // There is a state for the start, for each of five steps, and for a turn.
    assert_eq!(states_of(&server.address), 7);
    let wrong = connect(&[]).unwrap();
    assert_eq!(wrong.code, Some(1));
    assert!(wrong.stderr.contains("mmsim: the simulator refused S: "), "{wrong:?}");
    assert!(wrong.stderr.contains("use --goal server"), "{wrong:?}");
}

#[test]
fn a_mouse_can_reset_another_simulator() {
    let home = Home::new();
    home.write("small.txt", SMALL);
    let server = home.serve(&["small.txt", "--port", "0"]);
    let mouse = r"
ask('moveForward 2'), ask('turnRight'), ask('ackReset')
ask('moveForward 2'), ask('turnRight'), ask('moveForward 3')
";
    let options = ["--connect", &server.address, "--goal", "server", "--json"];
    let Some(python) = python() else { return };
    home.write("mouse.py", PREAMBLE.to_string() + mouse);
    let ended = home.run(&arguments(&options, &[python, "mouse.py"]));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let report = ended.json();
    let verdict = (&report["goal_reached"], &report["ending"], &report["error"]);
    assert_eq!(verdict, (&json!(true), &json!("finished"), &json!(null)), "{report}");
}

#[cfg(unix)]
#[test]
fn another_client_cannot_change_the_run_of_the_mouse() {
    let home = Home::new();
    let mouse = "ask('mazeWidth')\nprint('ready', file=sys.stderr, flush=True)\ntime.sleep(600)";
    let Some(command) = command(&home, &QUIET, mouse) else { return };
    let mut serving = Serving::start(command, "ready");
    let client = connect_to(&serving.address, zmq::REQ);
    let refused = ask(&client, b"reset");
    assert!(refused.starts_with(b"error: the simulator is running a mouse, "), "{refused:?}");
    assert_eq!(states_of(&serving.address), 1);
    serving.signal("TERM");
    serving.wait();
}

fn states_of(address: &str) -> u64 {
    let reply = ask(&connect_to(address, zmq::REQ), b"info");
    let info: serde_json::Value = serde_json::from_slice(&reply).unwrap();
    info["states"].as_u64().unwrap()
}
