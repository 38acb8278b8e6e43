//! `mmsim run` with clients of the `ZeroMQ` protocol.

mod harness;

use harness::{Home, Output, recorded, while_default_port_is_in_use};
#[cfg(unix)]
use harness::{Serving, read_on};
use mmsim_recording::Recording;
#[cfg(unix)]
use mmsim_tests::{ask, connect_to, wait_for};

const SMALL: &str = "o---o---o---o\n|           |\no   o---o   o\n| S |     G |\no---o---o---o\n";
#[cfg(unix)]
const STATE: &[u8] = b"S\x00\x00NC\x01\x01\x01\x01\x01\x01C\x0d\x0d\x0d\x0d\x0d\x0d";
const MMSIM: &str = env!("CARGO_BIN_EXE_mmsim");
const QUIET: [&str; 3] = ["--port", "0", "--no-viewer"];

fn arguments<'a>(options: &[&'a str], mouse: &[&'a str]) -> Vec<&'a str> {
    [&["run", "--maze", "small.txt"], &QUIET[..], options, &["--"], mouse].concat()
}

/// Returns a command line that searches the maze.
fn search(connect: &str) -> Vec<&str> {
    vec![MMSIM, "solve", "flood-fill", "--goal", "server", "--connect", connect]
}

fn home() -> Home {
    let home = Home::new();
    home.write("small.txt", SMALL);
    home
}

fn run(home: &Home, options: &[&str], mouse: &[&str]) -> Output {
    home.run(&arguments(options, mouse))
}

#[test]
fn the_mouse_is_given_the_address_as_an_argument() {
    let home = home();
    let ended = run(&home, &["--record", "runs"], &search("{endpoint}"));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(ended.stdout.contains("flood-fill: goal reached after 4 steps"), "{ended:?}");
    let last = ended.stderr.lines().last().unwrap();
    assert_eq!(last, "mouse exited with code 0; goal reached, 5 states");
    let recording = Recording::open(&recorded(&home.path().join("runs"))).unwrap();
    assert_eq!(recording.history().len(), 5);
}

#[cfg(unix)]
#[test]
fn the_mouse_is_given_the_address_in_the_environment() {
    let home = home();
    let ended = run(&home, &[], &[MMSIM, "solve", "flood-fill", "--goal", "server"]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(ended.stderr.ends_with("goal reached, 5 states\n"), "{ended:?}");
    let shown = run(&home, &[], &["sh", "-c", "echo $MMSIM_ENDPOINT = {endpoint}"]);
    let (variable, argument) = shown.stdout.trim().split_once(" = ").unwrap();
    assert_eq!(variable, argument);
    assert!(variable.starts_with("tcp://127.0.0.1:"), "{variable}");
    let is_public = shown.stderr.contains(&format!("at {variable};"));
    assert!(!is_public, "the address belongs to this run alone: {shown:?}");
}

#[test]
fn the_exit_code_is_that_of_the_mouse() {
    let home = home();
    let crashed = run(&home, &[], &[MMSIM, "solve", "no-such-strategy"]);
    assert_eq!(crashed.code, Some(2), "{crashed:?}");
    let expected = "mouse exited with code 2; goal not reached, no command of mms and no request\n";
    assert!(crashed.stderr.ends_with(expected), "{crashed:?}");

    let missing = run(&home, &["--stay"], &["no-such-mouse"]);
    assert_eq!(missing.code, Some(1));
    let message = missing.stderr.lines().last().unwrap();
    assert!(message.starts_with("mmsim: cannot start the mouse no-such-mouse: "), "{message}");
    assert!(message.ends_with("give its path, such as ./my-mouse)"), "{message}");

    for wrong in [&["run"][..], &["run", "--"], &["run", "--watch", "--", "java"]] {
        assert_eq!(home.run(wrong).code, Some(2), "{wrong:?}");
    }
    let missing = home.run(&["run", "--watch", "--", "./my-mouse"]);
    assert_eq!(missing.code, Some(2));
    assert!(missing.stderr.contains("--watch: ./my-mouse does not exist "), "{missing:?}");
}

#[cfg(unix)]
#[test]
fn signals_end_the_mouse_or_set_the_exit_code() {
    let home = home();
    let killed = run(&home, &[], &["sh", "-c", "kill -KILL $$"]);
    assert_eq!(killed.code, Some(137));
    assert!(killed.stderr.contains("mouse killed by signal 9; "), "{killed:?}");

    // The child process of the mouse is killed too; otherwise it would keep stderr open.
    let script = "sleep 600 & echo started >&2; wait";
    let command = home.command(&arguments(&[], &["sh", "-c", script]));
    let mut serving = Serving::start(command, "started");
    serving.signal("INT");
    let (status, messages) = serving.wait();
    assert_eq!(status.code(), Some(130), "{messages}");
    assert!(messages.contains("mouse stopped by Ctrl-C; "), "{messages}");
}

#[cfg(unix)]
#[test]
fn stay_keeps_the_address_for_other_clients() {
    let home = home();
    let command = home.command(&arguments(&["--stay"], &search("{endpoint}")));
    let mut serving = Serving::start(command, "still serving");
    assert!(ask(&connect_to(&serving.address, zmq::REQ), b"info").starts_with(b"{"));
    let again = home.run(&search(&serving.address)[1..]);
    assert_eq!(again.code, Some(0), "{again:?}");
    serving.signal("TERM");
    assert_eq!(serving.wait().0.code(), Some(0));
}

#[test]
fn a_free_port_is_used_if_the_default_port_is_in_use() {
    let home = home();
    let search = search("{endpoint}");
    let free = [&["run", "--maze", "small.txt", "--no-viewer", "--"], &search[..]].concat();
    let ended = while_default_port_is_in_use(|| home.run(&free));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let expected = "port 6574 on 127.0.0.1 is already in use; using a free port instead\n";
    assert!(ended.stderr.contains(expected), "{ended:?}");
    let given = ["run", "--maze", "small.txt", "--no-viewer", "--port", "6574", "--"];
    let given = [&given, &search[..]].concat();
    let ended = while_default_port_is_in_use(|| home.run(&given));
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.ends_with("is already in use (try --port 0)\n"), "{ended:?}");
}

/// A changed file must not delete the states of a client that is searching the maze.
#[cfg(unix)]
#[test]
fn a_changed_file_waits_for_another_client() {
    let home = home();
    home.write("mouse.sh", "exit 0");
    let command = home.command(&arguments(&["--watch"], &["sh", "mouse.sh"]));
    let (serving, stderr) = Serving::start_reading(command, "still serving");
    let client = connect_to(&serving.address, zmq::REQ);
    assert_eq!(ask(&client, b"reset"), b"ok");
    home.write("mouse.sh", "exit 0 # changed");
    let (stderr, _) = read_on(stderr, "mouse.sh has changed; waiting for another client");
    assert_eq!(ask(&client, b"W\0\0N").len(), 3, "the client can still search");
    drop(client);
    read_on(stderr, "running mouse.sh again because mouse.sh has changed");
}

/// While the reply to a state is held, a mouse must neither give up nor report a missing reply. A
/// client reports a missing reply after one second.
#[test]
fn a_mouse_waits_for_held_replies() {
    let home = Home::new();
    home.write("small.txt", "o---o---o\n| S   G |\no---o---o\n");
    let ended = run(&home, &["--pace", "1200"], &search("{endpoint}"));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    // On a busy machine, the first reply may be late.
    let is_report = |line: &&str| line.ends_with("s, still waiting; press Ctrl-C to give up");
    assert_eq!(ended.stderr.lines().filter(is_report).count(), 0, "{ended:?}");
}

#[cfg(unix)]
#[test]
fn the_pace_holds_the_mouse_after_each_state() {
    let home = home();
    let options = ["--pace", "3600000", "--record", "runs"];
    let command = home.command(&arguments(&options, &search("{endpoint}")));
    let mut serving = Serving::start(command, "tcp://");
    let runs = home.path().join("runs");
    let has_file = || runs.read_dir().is_ok_and(|mut files| files.next().is_some());
    // The file is created shortly before the state is written.
    let recorded_states = || Some(Recording::open(&recorded(&runs)).ok()?.history().len());
    wait_for("the first state", || (has_file() && recorded_states() == Some(1)).then_some(()));
    // The reply to the first state is due in an hour.
    serving.signal("TERM");
    let (status, messages) = serving.wait();
    assert_eq!(status.code(), Some(130), "{messages}");
    let end = "mouse stopped by Ctrl-C; goal not reached, 1 state: never moved\n";
    assert!(messages.ends_with(end), "{messages}");
    assert_eq!(Recording::open(&recorded(&runs)).unwrap().history().len(), 1);
}

/// Starts a run of a mouse that has sent a state and must wait for an hour after it.
#[cfg(unix)]
fn held_mouse(home: &Home) -> (Serving, zmq::Socket) {
    let options = ["--pace", "3600000"];
    let command = home.command(&arguments(&options, &search("{endpoint}")));
    let mut serving = Serving::start(command, "tcp://");
    serving.has_mouse = true;
    let other = connect_to(&serving.address, zmq::REQ);
    wait_for("the first state", || has_states(&other, 1).then_some(()));
    (serving, other)
}

#[cfg(unix)]
fn has_states(client: &zmq::Socket, states: u32) -> bool {
    let info = String::from_utf8(ask(client, b"info")).unwrap();
    info.contains(&format!("\"states\":{states}}}"))
        || info.contains(&format!("\"states\":{states},"))
}

#[cfg(unix)]
#[test]
fn another_client_cannot_disturb_a_run() {
    let home = home();
    let (mut serving, other) = held_mouse(&home);
    for request in [b"reset", STATE, b"AL\x05\0other"] {
        let reply = String::from_utf8(ask(&other, request)).unwrap();
        assert!(
            reply.starts_with(
                "error: the simulator is running a mouse, and only the connection of "
            ),
            "{reply}"
        );
    }
    assert_eq!(ask(&other, b"W\0\0N").len(), 3);
    assert!(has_states(&other, 1));
    serving.signal("TERM");
    let (_, messages) = serving.wait();
    assert!(
        messages.ends_with("mouse stopped by Ctrl-C; goal not reached, 1 state: never moved\n"),
        "{messages}"
    );
}
