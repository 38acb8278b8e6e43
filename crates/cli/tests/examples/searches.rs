//! Checks the clients' searches against `mmsim solve flood-fill`, and their error messages.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};
use std::thread;

use mmsim_maze::{Cell, Heading, MazeSize, WallState};
use mmsim_protocol::{Annotation, Annotations, Colour};
use mmsim_tests::{output, wait_for};

use crate::client::{self, file};
use crate::harness::Home;
use crate::simulator::Simulator;

/// The output of a client and the requests that it sent.
struct ClientRun {
    output: Output,
    requests: Vec<Vec<u8>>,
}

impl ClientRun {
    /// Runs a client with the endpoint as its last argument.
    fn new(client: &mut Command, simulator: Simulator) -> Self {
        let output = output(client.arg(&simulator.endpoint));
        Self { output, requests: simulator.requests() }
    }

    fn states(&self) -> Vec<&[u8]> {
        self.requests.iter().map(Vec::as_slice).filter(|request| request[0] == b'S').collect()
    }

    /// Returns the exit code, stdout and stderr.
    fn exit(&self) -> (Option<i32>, String, String) {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_end().to_string();
        (self.output.status.code(), text(&self.output.stdout), text(&self.output.stderr))
    }
}

/// Mazes with a reachable goal. The last one has equally short paths on the left and on the right.
const MAZES: [&str; 4] = [
    mmsim_mazes::HARBOUR,
    mmsim_mazes::LIGHTHOUSE,
    mmsim_mazes::MIRAGE,
    include_str!("left-or-right.txt"),
];

/// Compares a client with `mmsim solve flood-fill` and checks the client's messages.
fn check(client: impl Fn() -> Command) {
    let stopping = Simulator::start(mmsim_mazes::HARBOUR, |number| number < 20);
    let expected =
        format!("no reply from {} within 5 s (start a simulator with `mmsim`)", stopping.endpoint);
    let mut waiting = client();
    let stopped = thread::spawn(move || ClientRun::new(&mut waiting, stopping));

    for maze in MAZES {
        let (steps, run) = same_states(client(), maze);
        let message = format!("goal reached after {steps} steps");
        assert_eq!(run.exit(), (Some(0), message, String::new()), "{maze}");
        assert_eq!(run.requests[..2], [b"ping".to_vec(), b"reset".to_vec()]);
    }
    let (steps, run) = same_states(client(), mmsim_mazes::CLOSED_GARDEN);
    let message = format!("goal unreachable after {steps} steps");
    assert_eq!(run.exit(), (Some(1), String::new(), message));

    let larger = Simulator::serve(mmsim_mazes::OLD_QUARTER);
    let message = "the simulator refused the request: expected a state of 2054 bytes for a maze of 32x32 cells, found 518 bytes";
    let exit = ClientRun::new(&mut client(), larger).exit();
    assert_eq!(exit, (Some(1), String::new(), message.into()));

    let output = output(client().arg("nowhere"));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr.starts_with("cannot reach nowhere: "), "{stderr}");
    assert!(stderr.ends_with("(expected tcp://HOST:PORT)\n"), "{stderr}");

    let run = stopped.join().unwrap();
    assert_eq!(run.exit(), (Some(1), String::new(), expected));
    assert_eq!(run.requests.len(), 20);
}

/// Asserts that a client sends the same states as `mmsim solve flood-fill`, byte for byte. Returns
/// the number of steps, and the client's output and requests.
fn same_states(mut client: Command, maze: &str) -> (usize, ClientRun) {
    let home = Home::new();
    let mut command = home.command(&["solve", "flood-fill", "--connect"]);
    let command_run = ClientRun::new(&mut command, Simulator::serve(maze));
    let run = ClientRun::new(&mut client, Simulator::serve(maze));
    assert!(run.states() == command_run.states(), "different states in\n{maze}");
    (command_run.states().len() - 1, run)
}

#[test]
fn the_client_in_rust() {
    check(client::rust);
}

#[test]
fn the_short_client_in_rust() {
    let home = Home::new();
    let serving = home.serve(&["--port", "0", "lighthouse"]);
    let output = output(client::rust_example("short-client").arg(&serving.address));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_client_in_python() {
    if client::python().is_none() {
        return;
    }
    check(|| {
        let mut python = client::python().unwrap();
        python.arg("flood_fill.py");
        python
    });
}

#[test]
fn the_client_in_c() {
    let home = Home::new();
    if let Some(built) = client::c(&home) {
        check(|| Command::new(built.get_program()));
    }
}

#[test]
fn clients_run_under_mmsim_run() {
    let home = Home::new();
    let check = |client: &Command, script: Option<&str>, states: usize| {
        let options = ["run", "--maze", "hedgerow", "--port", "0", "--no-viewer", "--"];
        let mut command = home.command(&options);
        let ended = output(command.arg(client.get_program()).args(script.map(file)));
        let stderr = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(0), "{client:?}: {stderr}");
        let expected = format!("mouse exited with code 0; goal reached, {states} states\n");
        assert!(stderr.ends_with(&expected), "{client:?}: {stderr}");
    };
    if let Some(python) = client::python() {
        check(&python, Some("examples/python/minimal.py"), 302);
        check(&python, Some("examples/python/flood_fill.py"), 192);
    }
    if let Some(built) = client::c(&home) {
        check(&built, None, 192);
    }
}

/// Starts a simulator that holds its reply to the request with this index until a file exists.
/// Returns the path of the file.
fn simulator_without_reply(home: &Home, index: usize) -> (Simulator, PathBuf) {
    let file = home.path().join("no reply");
    let path = file.clone();
    let simulator = Simulator::start(mmsim_mazes::HARBOUR, move |number| {
        if number == index {
            wait_for("the file", || path.exists().then_some(()));
        }
        true
    });
    (simulator, file)
}

/// A Python script that tests the parts of the `Simulator` class that a successful search does not
/// use. It creates a file after a request without a reply.
const CLASS: &str = r#"
import sys
from mmsim import Heading, NoReply, Pose, Refused, Simulator

pose = Pose(0, 0, Heading.NORTH)
with Simulator(sys.argv[-1], timeout=0.3) as simulator:
    try:
        simulator.ping()
    except NoReply:
        print("no reply")
    open(sys.argv[1], "w").close()
    simulator._timeout = 300
    simulator.ping()
    for weights, walls in [([[0]], [[0]]), ([[0, 0]], [[0], [0]])]:
        try:
            simulator.state(pose, weights, walls)
        except (Refused, ValueError) as error:
            print(type(error).__name__, error, sep=": ")
    simulator.state(Pose(1, 2, Heading.WEST), [range(250, 266)] * 16, [range(16)] * 16)
"#;

#[test]
fn the_python_class_survives_errors() {
    let Some(mut python) = client::python() else { return };
    let home = Home::new();
    let (simulator, file) = simulator_without_reply(&home, 0);
    let run = ClientRun::new(python.args(["-c", CLASS]).arg(file), simulator);
    let (code, stdout, stderr) = run.exit();
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    insta::assert_snapshot!(stdout, @"
    no reply
    Refused: the simulator refused the request: expected a state of 518 bytes for a maze of 16x16 cells, found 8 bytes
    ValueError: weights and walls must have the same shape
    ");
    let state = run.states().pop().unwrap();
    assert_eq!(state[..11], *b"S\x01\x02WF\xfa\xfb\xfc\xfd\xfe\xff");
    assert_eq!(state[11..22], [[255; 10].as_slice(), &[250]].concat());
    assert_eq!(
        state[261..280],
        *b"F\0\x01\x02\x03\x04\x05\x06\x07\x08\x09\x0a\x0b\x0c\x0d\x0e\x0f\0\x01"
    );
}

/// A Python script that annotates a state. Its arguments are the value of the parameter
/// `annotations` and the endpoint.
const ANNOTATIONS: &str = r#"
import sys
from mmsim import Heading, Pose, Simulator

weights, walls = [[0] * 16] * 16, [[0] * 16] * 16
with Simulator(sys.argv[-1], annotations={"auto": None, "on": True}[sys.argv[1]]) as simulator:
    simulator.text(0, 0, "lost")  # by the reset
    simulator.reset()
    simulator.name("Theseus", "thread")
    simulator.text(3, 4, 1024)
    simulator.text(3, 5, "")
    simulator.colour(3, 4, "G")
    simulator.colour(3, 5, None)
    simulator.restart()
    simulator.wall(0, 0, Heading.EAST, "?")
    simulator.log("two\tlines\x1b[0m\n" + "\u20ac" * 400)
    for action in (
        lambda: simulator.text(0, 0, "12345678901"),
        lambda: simulator.colour(0, 0, "x"),
        lambda: simulator.wall(0, 0, Heading.EAST, "2"),
        lambda: simulator.name("n" * 101),
    ):
        try:
            action()
        except ValueError as error:
            print(error)
    simulator.state(Pose(0, 0, Heading.NORTH), weights, walls)
    simulator.state(Pose(0, 1, Heading.NORTH), weights, walls)
    simulator.clear_texts()
    simulator.clear_colours()
    simulator.clear_walls()
    for x in range(16):
        for y in range(16):
            simulator.text(x, y, "\u221e" * 10)
    simulator.state(Pose(0, 2, Heading.NORTH), weights, walls)
"#;

#[test]
fn the_python_class_sends_annotations() {
    let Some(mut python) = client::python() else { return };
    let simulator = Simulator::serve(mmsim_mazes::HARBOUR);
    let run = ClientRun::new(python.args(["-c", ANNOTATIONS, "on"]), simulator);
    let (code, stdout, stderr) = run.exit();
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    insta::assert_snapshot!(stdout, @"
    a text has at most 10 characters, found '12345678901'
    a colour is one of kbacgorwyBCAGORVY, found 'x'
    a declared wall is 1, 0, ? or -, found '2'
    a name has at most 100 bytes, found 'nnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnn'
    ");
    let (cell, above) = (Cell::new(3, 4), Cell::new(3, 5));
    let euros = "\u{20ac}".repeat(333);
    let expected = [
        Annotation::Mouse("Theseus"),
        Annotation::Strategy("thread"),
        Annotation::Text { cell, text: "1024" },
        Annotation::Text { cell: above, text: "" },
        Annotation::Colour { cell, colour: Some(Colour::DarkGreen) },
        Annotation::Colour { cell: above, colour: None },
        Annotation::Restart,
        Annotation::Wall {
            cell: Cell::new(0, 0),
            heading: Heading::East,
            state: Some(WallState::Unknown),
        },
        Annotation::Log("two lines [0m"),
        Annotation::Log(&euros),
    ];
    let letters: Vec<_> = run.requests.iter().map(|request| char::from(request[0])).collect();
    assert_eq!(letters[..5], ['r', 'i', 'A', 'S', 'S']);
    let annotations =
        |request: &[u8]| Annotations::decode(request, MazeSize::CLASSIC).unwrap().iter().count();
    let first = Annotations::decode(&run.requests[2], MazeSize::CLASSIC).unwrap();
    assert!(first.iter().eq(expected), "{first:?}");
    let (last, texts) = run.requests[5..].split_last().unwrap();
    assert_eq!(last[0], b'S');
    assert_eq!(texts.iter().map(|request| annotations(request)).sum::<usize>(), 3 + 256);
    let first = Annotations::decode(&texts[0], MazeSize::CLASSIC).unwrap();
    let cleared = [Annotation::ClearTexts, Annotation::ClearColours, Annotation::ClearWalls];
    assert!(first.iter().take(3).eq(cleared), "{first:?}");
}

/// A Python function that logs its result after its last state.
const SEARCH: &str = r#"
import sys
from mmsim import Heading, Pose, Simulator

def search(simulator):
    grid = [[0] * 16] * 16
    simulator.state(Pose(0, 0, Heading.NORTH), grid, grid)
    simulator.log("RESULT")
"#;

#[test]
fn the_python_class_sends_the_last_annotations() {
    let new = "Simulator(sys.argv[-1], annotations=True)";
    for call in [format!("simulator = {new}; search(simulator)"), format!("search({new})")] {
        let Some(mut python) = client::python() else { return };
        let simulator = Simulator::serve(mmsim_mazes::HARBOUR);
        let script = format!("{SEARCH}{call}");
        let run = ClientRun::new(python.args(["-c", &script]), simulator);
        let (code, _, stderr) = run.exit();
        assert_eq!((code, stderr.as_str()), (Some(0), ""));
        let letters: String = run.requests.iter().map(|request| char::from(request[0])).collect();
        assert_eq!((&*letters, &*run.requests[2]), ("SiA", &b"AL\x06\0RESULT"[..]), "{call}");
    }
}

/// A Python script whose first annotations are refused, and whose next ones have no reply in time.
const REFUSED: &str = r#"
import sys
from mmsim import Heading, NoReply, Pose, Refused, Simulator

pose, grid = Pose(0, 0, Heading.NORTH), [[0] * 16] * 16
with Simulator(sys.argv[-1], annotations=True) as simulator:
    simulator.log("x" * 1000)
    simulator.text(16, 0, "outside")
    for _ in range(5):
        simulator.log("x" * 1000)
    try:
        simulator.state(pose, grid, grid)
    except Refused as error:
        print(error)
    simulator.state(pose, grid, grid)
    simulator.log("again")
    simulator._timeout = 0.3
    try:
        simulator.state(pose, grid, grid)
    except NoReply:
        print("no reply")
    open(sys.argv[1], "w").close()
    simulator._timeout = 300
    simulator.state(pose, grid, grid)
"#;

#[test]
fn the_python_class_sends_annotations_after_errors() {
    let Some(mut python) = client::python() else { return };
    // The requests: info, refused annotations, a state, annotations without a reply in time.
    let home = Home::new();
    let (simulator, file) = simulator_without_reply(&home, 3);
    let run = ClientRun::new(python.args(["-c", REFUSED]).arg(file), simulator);
    let (code, stdout, stderr) = run.exit();
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    assert_eq!(
        stdout,
        "the simulator refused the request: expected a cell in a maze of 16x16 cells, found (16, 0)\n\
         no reply"
    );
    let letters: String = run.requests.iter().map(|request| char::from(request[0])).collect();
    assert!(letters.starts_with("iASA") && letters.ends_with("AS"), "{letters}");
    assert!(
        run.requests[3..].iter().all(|request| request[0] == b'S' || request == b"AL\x05\0again")
    );
}

/// The reference simulator replies neither to `info` nor to annotations.
#[test]
fn the_python_class_sends_annotations_only_to_mmsim() {
    let letters = |variable: fn(&str) -> Option<&str>| {
        let mut python = client::python()?;
        let simulator = Simulator::serve(mmsim_mazes::HARBOUR);
        python.env_remove("MMSIM_ENDPOINT");
        python.envs(variable(&simulator.endpoint).map(|value| ("MMSIM_ENDPOINT", value)));
        let run = ClientRun::new(python.args(["-c", ANNOTATIONS, "auto"]), simulator);
        assert_eq!(run.output.status.code(), Some(0), "{:?}", run.exit());
        Some(run.requests.iter().map(|request| char::from(request[0])).collect::<String>())
    };
    let Some(plain) = letters(|_| None) else { return };
    assert_eq!(plain, "rSSS");
    let run = letters(|endpoint| Some(endpoint)).unwrap();
    assert!(run.starts_with("riASSA"), "{run}");
    // A client of `mmsim run` that connects to another simulator.
    assert_eq!(letters(|_| Some("tcp://127.0.0.1:1")).unwrap(), "rSSS");
}

#[test]
fn clients_and_docs_list_the_letters_of_all_colours() {
    for path in [
        "crates/mms/src/command.rs",
        "crates/protocol/src/annotations.rs",
        "crates/python/python/micromouse_sim/_native.pyi",
        "crates/python/src/connection.rs",
        "docs/clients.md",
        "docs/mms.md",
        "examples/c/mmsim.h",
        "examples/python/mmsim.py",
    ] {
        let text = fs::read_to_string(file(path)).unwrap();
        assert!(text.contains(Colour::LETTERS), "{path}");
    }
}
