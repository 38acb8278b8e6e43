//! What a mouse displays, as the simulator receives it.

use std::sync::mpsc::{self, Receiver};
use std::thread;

use mmsim_maze::Maze;
use mmsim_protocol::Annotation;
use mmsim_server::Simulation;
#[cfg(unix)]
use mmsim_tests::TIMEOUT;

use super::*;

/// A simulator that lists the annotations and states that it receives.
struct Listener {
    address: String,
    events: Receiver<String>,
}

impl Listener {
    /// Serves [`SMALL`]. Unless `has_annotations` is set, the simulator does not know annotations.
    fn start(has_annotations: bool) -> Self {
        let socket = zmq::Context::new().socket(zmq::REP).unwrap();
        socket.bind("tcp://127.0.0.1:*").unwrap();
        let address = socket.get_last_endpoint().unwrap().unwrap();
        let maze: Maze = SMALL.parse().unwrap();
        let size = maze.size();
        let mut simulation = Simulation::new("small", maze);
        let (sender, events) = mpsc::channel();
        thread::spawn(move || {
            while let Ok(request) = socket.recv_bytes(0) {
                let mut reply = Vec::new();
                match Request::decode(&request, size) {
                    Ok(Request::Annotations(_)) if has_annotations => reply.extend(b"ok"),
                    _ => drop(simulation.handle(&request, &mut reply)),
                }
                if request == b"info" && !has_annotations {
                    let info = String::from_utf8(reply).unwrap();
                    reply = info.replace("\"annotations\"", "").into_bytes();
                }
                for event in events_of(&request, size) {
                    let _ = sender.send(event);
                }
                socket.send(reply, 0).unwrap();
            }
        });
        Self { address, events }
    }

    /// Runs a Python mouse and returns its output and the [`stable`] events, one per line.
    fn run(&self, home: &Home, mouse: &str) -> Option<(Output, String)> {
        let python = python()?;
        home.write("mouse.py", PREAMBLE.to_string() + mouse);
        let ended = home.run(&arguments(&self.options(), &[python, "mouse.py"]));
        Some((ended, stable(self.events.try_iter()).join("\n")))
    }

    fn options(&self) -> [&str; 4] {
        ["--connect", &self.address, "--goal", "server"]
    }

    /// Waits until the simulator has received this event. Returns all events up to it.
    #[cfg(unix)]
    fn wait_for(&self, last: &str) -> Vec<String> {
        let mut events = Vec::new();
        while events.last().is_none_or(|event| event != last) {
            let event = self.events.recv_timeout(TIMEOUT);
            events.push(event.unwrap_or_else(|_| panic!("no {last:?} after {events:#?}")));
        }
        events
    }
}

/// Removes the states in which the mouse has not moved, except for the last state, and sorts the
/// annotations of each remaining state. If the machine is busy, changes of what the mouse displays
/// arrive in such states before its next movement.
fn stable(events: impl Iterator<Item = String>) -> Vec<String> {
    let (mut stable, mut annotations, mut pose) = (Vec::new(), Vec::new(), String::new());
    let mut events = events.peekable();
    while let Some(event) = events.next() {
        match event.strip_prefix("state ").and_then(|state| state.split_once(", weight")) {
            None => annotations.push(event),
            Some((same, _)) if same == pose && events.peek().is_some() => {}
            Some((new, _)) => {
                pose = new.to_string();
                annotations.sort();
                stable.append(&mut annotations);
                stable.push(event);
            }
        }
    }
    stable
}

fn events_of(request: &[u8], size: MazeSize) -> Vec<String> {
    let event = |annotation| match annotation {
        Annotation::Text { cell, text } => format!("{cell} {text:?}"),
        Annotation::Colour { cell, colour } => format!("{cell} {colour:?}"),
        Annotation::Wall { cell, heading, state } => format!("{cell} {heading} {state:?}"),
        other => format!("{other:?}"),
    };
    match Request::decode(request, size) {
        Ok(Request::Annotations(annotations)) => annotations.iter().map(event).collect(),
        Ok(Request::State(state)) => {
            let weight = state.weights().at(Cell::new(0, 0)).unwrap();
            vec![format!("state {}, weight {weight}", state.pose())]
        }
        _ => Vec::new(),
    }
}

/// The first question makes sure that the first state precedes all other commands.
const TALKATIVE: &str = r"
ask('mazeWidth')
def log(text):
    sys.stderr.buffer.write(text)
    sys.stderr.buffer.flush()

log(b'hello\n\x1b[31mred\x1b[0m')
say('setText 0 0 12')
say('setColor 3 2 G')
ask('moveForward')
log(b' caf\xc3\xa9\r\n')
say('clearWall 2 0 n')
ask('turnRight')
ask('turnLeft')
ask('ackReset')
say('clearAllColor')
say('setText 0 0 1000')
log(b'bye')
";

/// On Windows, a log line may arrive after the next state.
#[cfg(unix)]
#[test]
fn what_a_mouse_displays_belongs_to_its_next_state() {
    let home = Home::new();
    let listener = Listener::start(true);
    let Some((ended, events)) = listener.run(&home, TALKATIVE) else { return };
    assert_eq!(ended.code, Some(0), "{ended:?}");
    insta::assert_snapshot!(events, @r#"
    (0, 0) east Some(Unknown)
    (0, 0) north Some(Unknown)
    Mouse("mouse.py")
    state (0, 0) heading north, weight 0
    (0, 0) "12"
    (0, 0) north None
    (0, 1) east Some(Unknown)
    (0, 1) north Some(Unknown)
    (3, 2) Some(DarkGreen)
    Log("hello")
    state (0, 1) heading north, weight 12
    (2, 0) north Some(Absent)
    Log("red café")
    state (0, 1) heading east, weight 12
    state (0, 1) heading north, weight 12
    Restart
    state (0, 0) heading north, weight 12
    (0, 0) "1000"
    (3, 2) None
    Log("bye")
    state (0, 0) heading north, weight 255
    "#);
    assert!(ended.stderr.starts_with("hello\n\u{1b}[31mred\u{1b}[0m caf\u{e9}\nbye"), "{ended:?}");
}

#[test]
fn a_simulator_without_annotations_receives_none() {
    let home = Home::new();
    let listener = Listener::start(false);
    let Some((ended, events)) = listener.run(&home, TALKATIVE) else { return };
    assert_eq!(ended.code, Some(0), "{ended:?}");
    insta::assert_snapshot!(events, @"
    state (0, 0) heading north, weight 0
    state (0, 1) heading north, weight 12
    state (0, 1) heading east, weight 12
    state (0, 1) heading north, weight 12
    state (0, 0) heading north, weight 12
    state (0, 0) heading north, weight 255
    ");
    assert!(ended.stderr.starts_with("hello\n"), "{ended:?}");
}

/// A mouse that stands still: it repeats a question until there is a file, and then hangs.
#[cfg(unix)]
const STANDING: &str = r"
print('ready', file=sys.stderr, flush=True)
say('setText 0 0 12')
say('setColor 1 2 r')
while not os.path.exists('go'): ask('wasReset')
print('stuck\nunfinished', end='', file=sys.stderr, flush=True)
time.sleep(600)
";

#[cfg(unix)]
#[test]
fn what_a_mouse_displays_is_sent_while_it_stands_still() {
    let home = Home::new();
    let listener = Listener::start(true);
    let Some(command) = command(&home, &listener.options(), STANDING) else { return };
    let mut serving = Serving::start(command, "ready");
    let state = "state (0, 0) heading north, weight 12";
    let mut events = listener.wait_for("(1, 2) Some(Red)");
    events.extend(listener.wait_for(state));
    home.write("go", "");
    events.extend(listener.wait_for("Log(\"stuck\")"));
    events.extend(listener.wait_for(state));
    for pair in events.windows(2) {
        assert_ne!(pair, [state, state], "a state without a change: {events:#?}");
    }
    // The end of the log completes the last line. After Ctrl-C, nothing more is sent, because the
    // simulator may not reply.
    serving.signal("INT");
    let (status, messages) = serving.wait();
    assert_eq!(status.code(), Some(130), "{messages}");
    assert_eq!(listener.events.try_iter().collect::<Vec<_>>(), [""; 0]);
}

#[test]
fn reports_of_invalid_lines_are_in_the_log() {
    let listener = Listener::start(true);
    let mouse = "say('moveForwrad')\nask('turnLeft')\n";
    let Some((ended, events)) = listener.run(&Home::new(), mouse) else { return };
    let report = r#"mms: line 1: unknown command "moveForwrad""#;
    assert!(ended.stderr.contains(report), "{ended:?}");
    assert!(events.contains(&report.escape_debug().to_string()), "{events}");
}
