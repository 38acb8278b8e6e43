//! `mmsim run` recognizes what the program of the user is, starts it once, and says what to do after a
//! mistake.

mod harness;

use std::fs;

use harness::mice::works;
use harness::{Home, Output};
#[cfg(unix)]
use harness::{Serving, read_on};
#[cfg(unix)]
use mmsim_tests::{ask, connect_to};

const MMSIM: &str = env!("CARGO_BIN_EXE_mmsim");
const SMALL: &str = "o---o---o---o\n|           |\no   o---o   o\n| S |     G |\no---o---o---o\n";

const SQUARE: &str = "o---o---o\n|       |\no   o   o\n| S | G |\no---o---o\n";

/// A robot of the two-run trial that reaches the goal of no maze.
const ROBOT: &str = "\
class Robot (object) :
    def __init__(self, maze_dim):
        open('started', 'a').write('x')

    def next_move(self, sensors):
        return 0, 0
";

/// The start of a mouse in Python.
const STARTED: &str = "import sys\nopen('started', 'a').write('x')\n";

fn home() -> Home {
    let home = Home::new();
    home.write("small.txt", SMALL);
    home.write("square.txt", SQUARE);
    home
}

/// Runs a program as a mouse in a small maze.
fn run(home: &Home, options: &[&str], mouse: &[&str]) -> Output {
    let quiet = ["run", "--port", "0", "--no-viewer"];
    let maze = if options.contains(&"--maze") { &[][..] } else { &["--maze", "small.txt"] };
    home.run(&[&quiet[..], maze, options, mouse].concat())
}

/// A command line that searches the maze as a client.
const CLIENT: [&str; 7] =
    [MMSIM, "solve", "flood-fill", "--goal", "server", "--connect", "{endpoint}"];

fn has_python() -> bool {
    works("python3", &["--version"])
}

#[test]
fn a_mouse_for_mms_a_client_and_a_robot_are_recognized_from_one_start() {
    if !has_python() {
        return;
    }
    let home = home();
    let ask = "print('hello')\nprint('moveForward', flush=True)\nassert input() == 'ack'\n";
    home.write("mms.py", [STARTED, ask].concat());
    home.write("robot.py", ROBOT);
    home.write("silent.py", STARTED);
    let words = format!("{CLIENT:?}").replace(r#""{endpoint}""#, "os.environ['MMSIM_ENDPOINT']");
    let client = format!("{STARTED}import os, subprocess\nsys.exit(subprocess.call({words}))\n");
    home.write("client.py", client);
    let mms = "mms.py is a mouse for mms (if not, use --as client)\n";
    let robot = "robot.py is a robot of the two-run trial (if not, use --as mms or --as client)\n";
    let client = "client.py is a client of the ZeroMQ protocol (if not, use --as mms)\n";
    for (mouse, said) in [
        (&["python3", "mms.py"][..], mms),
        (&["mms.py"], mms),
        (&["./mms.py"], mms),
        (&["--", "python3", "mms.py"], mms),
        (&["client.py", "--open"], client),
        (&["robot.py"], robot),
        (&["python3", "robot.py"], robot),
        (&["silent.py"], "no command of mms and no request"),
    ] {
        let ended = run(&home, &["--maze", "square.txt", "--time-limit", "300"], mouse);
        assert!(ended.stderr.contains(said), "{mouse:?}: {ended:?}");
        assert_eq!(ended.code, Some(i32::from(said == robot)), "{mouse:?}: {ended:?}");
        let started = home.path().join("started");
        assert_eq!(
            fs::read_to_string(&started).unwrap_or_default(),
            "x",
            "{mouse:?} is started once"
        );
        fs::remove_file(started).unwrap();
        let is_passed = "--open is passed to client.py (options of mmsim run come before it)\n";
        assert_eq!(ended.stderr.contains(is_passed), mouse.contains(&"--open"), "{mouse:?}");
    }
}

#[test]
fn the_kind_is_in_the_report() {
    if !has_python() {
        return;
    }
    let home = home();
    home.write("mms.py", "print('mazeWidth')");
    home.write("silent.py", "");
    for (kind, mouse) in
        [(Some("mms"), &["mms.py"][..]), (Some("client"), &CLIENT), (None, &["silent.py"])]
    {
        let ended = run(&home, &["--json"], mouse);
        let report = ended.json();
        assert_eq!(report["kind"].as_str(), kind, "{report}");
        assert_eq!((&report["maze"], &report["exit_code"]), (&"small".into(), &0.into()));
        // The drawing of the client must not mix with the report.
        assert_eq!(ended.stderr.contains("o---o"), kind == Some("client"), "{ended:?}");
    }
}

#[test]
fn the_output_of_a_client_is_copied() {
    if !has_python() {
        return;
    }
    let home = home();
    let bytes = "import os\nos.write(1, bytes(range(256)) * 100 + b'mazeWidth')\n";
    home.write("client.py", bytes);
    let ended = home.command(&["run", "--port", "0", "--no-viewer", "client.py"]).output().unwrap();
    assert_eq!(
        ended.stdout,
        [&(0..=255).collect::<Vec<u8>>().repeat(100), &b"mazeWidth"[..]].concat()
    );
}

#[test]
fn a_choice_overrides_what_would_be_recognized() {
    if !has_python() {
        return;
    }
    let home = home();
    home.write("robot.py", [ROBOT, "print('mazeWidth')\n"].concat());
    home.write("mms.py", "print('mazeWidth')");
    let ended = run(&home, &["--as", "mms", "--json"], &["robot.py"]);
    assert_eq!(ended.json()["kind"], "mms", "{ended:?}");
    let ended = run(&home, &["--as", "client"], &["mms.py"]);
    let hint = "no request (does it connect to MMSIM_ENDPOINT? if it is a mouse for mms, leave out \
                --as client)\n";
    assert!(ended.stdout == "mazeWidth\n" && ended.stderr.ends_with(hint), "{ended:?}");
    let ended = run(&home, &["--as", "mms"], &CLIENT);
    assert!(ended.stderr.contains("(with --as client, it may write anything)"), "{ended:?}");
    let ended = run(&home, &["--as", "robot"], &["mms.py"]);
    assert!(ended.stdout.contains("expected a rotation and a movement"), "{ended:?}");
}

#[test]
fn a_mistake_is_explained() {
    let home = home();
    fs::create_dir(home.path().join("folder")).unwrap();
    home.write("program", "no program");
    let not_program = |what: &str| {
        format!("(not a program; if it is a maze, put --maze {what} before the command)\n")
    };
    home.write("broken.py", "def f(\n");
    if has_python() {
        let ended = run(&home, &[], &["broken.py"]);
        assert!(ended.stderr.contains("SyntaxError"), "Python says what is wrong: {ended:?}");
    }
    for (mouse, hint) in [
        (&["folder"][..], not_program("folder")),
        (&["./folder"], not_program("./folder")),
        (&["missing/"], not_program("missing/")),
        (&["no-such-mouse"], "give its path, such as ./my-mouse)\n".into()),
    ] {
        let ended = run(&home, &[], mouse);
        assert!(ended.code == Some(1) && ended.stderr.ends_with(&hint), "{ended:?}");
    }
    let ended = home.run(&["run", "--open"]);
    assert_eq!(ended.code, Some(2));
    let message = "error: no mouse to run (example: mmsim run --open ./my-mouse)\n";
    assert!(ended.stderr.starts_with(message), "{ended:?}");
    let ended = home.run(&["run", "--oepn", "./my-mouse"]);
    assert_eq!(ended.code, Some(2));
    assert!(ended.stderr.contains("a similar argument exists: '--open'"), "{ended:?}");
    let ended = home.run(&["run", "harbour", "--", "./my-mouse"]);
    assert_eq!(ended.code, Some(2));
    let message = "error: harbour before -- is no option (for a maze, use --maze harbour)\n";
    assert!(ended.stderr.starts_with(message), "{ended:?}");
    let ended = home.run(&["run", "flood-fill"]);
    let message = "error: flood-fill is a bundled strategy (to run it, use mmsim run mmsim solve \
                   flood-fill)\n";
    assert!(ended.code == Some(2) && ended.stderr.starts_with(message), "{ended:?}");
    let ended = home.run(&["run", "--maze", "harbuor", "--no-viewer", "--port", "0", "true"]);
    assert!(ended.stderr.contains("(did you mean harbour?)"), "{ended:?}");
}

#[cfg(unix)]
#[test]
fn a_file_that_is_no_program_is_explained() {
    use std::os::unix::fs::PermissionsExt;

    let home = home();
    let ended = run(&home, &[], &["small.txt"]);
    let hint = "(not executable: chmod +x small.txt; if it is a maze, put --maze small.txt before the \
                command)\n";
    assert!(ended.stderr.ends_with(hint), "{ended:?}");
    let script = home.write("my-script", "echo hello\n");
    fs::set_permissions(&script, fs::Permissions::from_mode(0o755)).unwrap();
    let ended = run(&home, &[], &["my-script"]);
    assert!(ended.stderr.ends_with("(give its path: ./my-script)\n"), "{ended:?}");
    let ended = run(&home, &[], &["./my-script"]);
    let hint = "(a script needs a first line such as #!/usr/bin/env python3)\n";
    assert!(ended.stderr.ends_with(hint), "{ended:?}");
}

/// The output before the first command belongs to the commands, and a client may close its output.
#[test]
fn nothing_that_a_mouse_writes_is_lost() {
    if !has_python() {
        return;
    }
    let home = home();
    home.write("banner.py", "print('hello\\nmazeWidth')");
    let ended = run(&home, &["--score"], &["banner.py"]);
    assert!(ended.stdout.starts_with("score: "), "{ended:?}");
    assert!(ended.stderr.contains("mms: line 1: unknown command \"hello\"\n"), "{ended:?}");
    let words = format!("{CLIENT:?}").replace(r#""{endpoint}""#, "os.environ['MMSIM_ENDPOINT']");
    let client = format!(
        "import os, subprocess, sys\nos.close(1)\nnull = open(os.devnull, 'w')\n\
        sys.exit(subprocess.call({words}, stdout=null))\n"
    );
    home.write("client.py", client);
    let ended = run(&home, &["--json"], &["client.py"]);
    assert_eq!(ended.json()["kind"], "client", "{ended:?}");
    assert!(ended.stderr.contains("client.py is a client of the ZeroMQ protocol"), "{ended:?}");
}

/// Between two runs, any client can use the public port, whatever the mouse is.
#[cfg(unix)]
#[test]
fn another_client_can_search_after_a_mouse_for_mms() {
    if !has_python() {
        return;
    }
    let home = home();
    home.write("mms.py", "print('mazeWidth')");
    let options = ["run", "--maze", "small.txt", "--port", "0", "--no-viewer", "--watch", "mms.py"];
    let (serving, stderr) = Serving::start_reading(home.command(&options), "still serving");
    let client = connect_to(&serving.address, zmq::REQ);
    assert_eq!(ask(&client, b"reset"), b"ok");
    home.write("mms.py", "print('mazeWidth') # changed");
    let (stderr, _) = read_on(stderr, "mms.py has changed; waiting for another client");
    drop(client);
    read_on(stderr, "running mms.py again because mms.py has changed");
}

#[test]
fn options_without_effect_are_refused() {
    let home = home();
    home.write("robot.py", ROBOT);
    for (options, option) in [
        (&["--score", "robot.py"][..], "--score"),
        (&["--limit", "5", "robot.py"], "--limit"),
        (&["--scores", "cells", "--as", "client", "true"], "--scores"),
        (&["--misread", "1%", "robot.py"], "--misread"),
        (&["--stop-at-goal", "--as", "robot", "true"], "--stop-at-goal"),
        (&["--connect", "tcp://127.0.0.1:1", "--as", "client", "true"], "--connect"),
        (&["--connect", "tcp://127.0.0.1:1", "robot.py"], "--connect"),
        (&["--size", "8x8", "true"], "--size"),
    ] {
        let ended = home.run(&[&["run"], options].concat());
        assert_eq!(ended.code, Some(2), "{options:?}: {ended:?}");
        assert!(ended.stderr.starts_with(&format!("error: {option} ")), "{ended:?}");
    }
    let ended = run(&home, &["--score"], &CLIENT);
    assert!(ended.stderr.contains("--score has no effect: "), "{ended:?}");
}

#[cfg(unix)]
#[test]
fn a_mouse_that_says_nothing_is_reported() {
    if !has_python() {
        return;
    }
    let home = home();
    for (mouse, report) in [
        ("print('moveforward', flush=True)", r#"; its last line "moveforward" is not a command"#),
        ("print('turnL', end='', flush=True)", r#"; waiting for a newline after "turnL""#),
    ] {
        home.write("typo.py", format!("{mouse}\ninput()\n"));
        let command = home.command(&["run", "--port", "0", "--no-viewer", "typo.py"]);
        let report = format!("no command of mms and no request after 3 s{report}");
        let mut serving = Serving::start(command, &report);
        serving.signal("INT");
        assert_eq!(serving.wait().0.code(), Some(130));
    }
}
