//! Mice of the user beside the bundled strategies.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use mmsim_tests::{output, wait_for_exit};
use serde_json::{Value, json};

use crate::harness::Home;

const MAZE: &str = "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n";

/// Returns true if a program works. If it does not, prints a message, or panics if
/// `MMSIM_CLIENTS=required` is set.
fn works(program: &str, arguments: &[&str]) -> bool {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let works = command.spawn().is_ok_and(|mut child| wait_for_exit(&mut child).success());
    if !works {
        let wanted = std::env::var("MMSIM_CLIENTS");
        assert_ne!(wanted.as_deref(), Ok("required"), "{program} {arguments:?} does not work");
        let _ = writeln!(std::io::stderr(), "skipped, {program} {arguments:?} does not work");
    }
    works
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Compiles the C++ mouse for mms, or returns `None` if there is no compiler.
fn cpp_mouse(home: &Home) -> Option<PathBuf> {
    let (source, mouse) = ("tests/compare/mice/flood.cpp", home.path().join("flood"));
    if !works("c++", &["--version"]) {
        return None;
    }
    let mut command = Command::new("c++");
    command.args(["-std=c++14", "-O2", source, "-o"]).arg(&mouse);
    let ended = output(command.current_dir(env!("CARGO_MANIFEST_DIR")));
    assert!(ended.status.success(), "{ended:?}");
    Some(mouse)
}

/// Returns the option value for a mouse whose program is a Python script with this text.
fn script(home: &Home, name: &str, text: &str) -> String {
    let path = home.write(&format!("{name}.py"), text);
    format!("{name}=python3 '{}'", path.display())
}

fn search<'r>(reports: &'r Value, mouse: &str, maze: usize) -> &'r Value {
    let reports = reports.as_array().unwrap().iter();
    let report = reports.clone().find(|report| report["strategy"] == mouse).expect("the mouse");
    &report["mazes"][maze]
}

#[test]
fn mice_in_any_language_run_beside_the_strategies() {
    let home = Home::new();
    let Some(cpp) = cpp_mouse(&home) else { return };
    if !works("python3", &["-c", "import zmq"]) {
        return;
    }
    let client = repository().join("examples/python/flood_fill.py");
    let mms = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mms/mice/flood-fill.py");
    let preamble = "import os, sys, time\n\ndef say(line): print(line, flush=True)\n\n\
        def ask(line):\n    say(line)\n    return sys.stdin.readline().rstrip('\\n')\n\n";
    let mms = script(&home, "python", &(preamble.to_string() + &fs::read_to_string(mms).unwrap()));
    let mice =
        [format!("cpp='{}'", cpp.display()), format!("client=python3 '{}'", client.display()), mms];
    // These mice assume the usual goal.
    let mut arguments = vec!["compare", "harbour", "hedgerow", "lighthouse", "galleries"];
    arguments.extend(["--json", "--strategies", "flood-fill", "--time-limit", "60"]);
    arguments.extend(mice.iter().flat_map(|mouse| ["--mouse", mouse]));
    let reports = home.run(&arguments).json();
    let names: Vec<_> = reports.as_array().unwrap().iter().map(|one| &one["strategy"]).collect();
    assert_eq!(names, ["cpp", "client", "python", "flood-fill"]);
    for report in reports.as_array().unwrap() {
        assert_eq!((&report["goal_reached"], report["reachable"].as_u64()), (&json!(4), Some(4)));
        let is_own = report["strategy"] != "flood-fill";
        assert_eq!(report["command"].is_string(), is_own);
        assert_eq!(report["time_us"].is_null(), is_own);
    }
    // The client makes the same decisions as the strategy.
    for maze in 0..4 {
        let (own, bundled) =
            (search(&reports, "client", maze), search(&reports, "flood-fill", maze));
        for key in ["steps_to_goal", "steps_until_proven", "steps_in_all", "turns", "path_found"] {
            assert_eq!(own[key], bundled[key], "{key}: {own}");
        }
    }
    let difference = &reports[1]["statistics"]["steps_to_goal"]["difference"];
    assert_eq!((&difference["mazes"], difference["mean"].is_f64()), (&json!(4), true));
}

#[test]
fn failures_are_counted_and_named_and_stop_nothing() {
    let home = Home::new();
    if !works("python3", &["--version"]) {
        return;
    }
    for maze in ["a", "b", "c", "d", "e"] {
        home.write(&format!("mazes/{maze}.txt"), MAZE);
    }
    let mice = [
        script(&home, "hangs", "import time\ntime.sleep(1000)"),
        script(&home, "crashes", "import sys\nsys.exit('a bad day')"),
        script(&home, "floods", "while True: print('hello ' * 100)"),
        script(&home, "stops", ""),
        "missing=./no-such-mouse".into(),
    ];
    let mut arguments =
        vec!["compare", "mazes", "--strategies", "flood-fill", "--time-limit", "0.3"];
    arguments.extend(mice.iter().flat_map(|mouse| ["--mouse", mouse]));
    let ended = home.run(&[&arguments[..], &["--json"]].concat());
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let reports = ended.json();
    let ending = |mouse, maze| {
        let search = search(&reports, mouse, maze);
        (search["ending"].as_str().unwrap(), search["error"].as_str().unwrap_or_default())
    };
    let hint = "(it has neither written mms commands nor connected to MMSIM_ENDPOINT)";
    for maze in 0..3 {
        assert_eq!(ending("hangs", maze), ("time_limit", &*format!("stopped after 0.3 s {hint}")));
    }
    let skipped = "skipped: stopped by the time limit in each of the first 3 mazes";
    for maze in 3..5 {
        assert_eq!(ending("hangs", maze), ("skipped", skipped));
    }
    for maze in 0..5 {
        // A slow machine may stop a mouse before it starts.
        let is_expected = |(kind, error): (&str, &str), expected: &str| {
            assert!(
                error.starts_with(expected) || kind == "time_limit" || kind == "skipped",
                "{error}"
            );
        };
        is_expected(ending("crashes", maze), "exited with code 1: a bad day");
        is_expected(ending("floods", maze), "wrote 4 MiB without a valid command; last line: ");
        is_expected(ending("stops", maze), "exited without reaching the goal");
        let (kind, error) = ending("missing", maze);
        assert_eq!(kind, "failed");
        assert!(error.starts_with("cannot start the mouse ./no-such-mouse: "), "{error}");
        assert_eq!(ending("flood-fill", maze), ("finished", ""));
    }
    assert_eq!(reports[0]["endings"]["skipped"], 2);
    let ended = home.run(&arguments);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    for mouse in ["hangs", "crashes", "floods", "stops", "missing"] {
        assert!(ended.stdout.contains(&format!("\n{mouse} failed in 5 mazes:\n")), "{ended:?}");
    }
    assert!(ended.stdout.contains("and 2 more"), "{}", ended.stdout);
    assert!(!ended.stdout.contains("flood-fill failed"), "{}", ended.stdout);
}

#[test]
fn a_mouse_that_stays_in_the_goal_has_finished() {
    let home = Home::new();
    if !works("python3", &["--version"]) {
        return;
    }
    home.write("a.txt", MAZE);
    let mouse = script(
        &home,
        "waits",
        "for line in ['moveForward', 'turnRight', 'moveForward']:\n    print(line, flush=True)\n    input()\n\
         while True:\n    print('wasReset', flush=True)\n    input()",
    );
    let reports = home
        .run(&[
            "compare",
            "a.txt",
            "--mouse",
            &mouse,
            "--strategies",
            "none",
            "--time-limit",
            "60",
            "--json",
        ])
        .json();
    let found = search(&reports, "waits", 0);
    assert_eq!((&found["ending"], &found["error"]), (&json!("finished"), &Value::Null));
    assert_eq!(
        (&found["steps_to_goal"], &found["turns"], &found["crashes"]),
        (&json!(2), &json!(1), &json!(0))
    );
}

#[test]
fn a_client_that_passes_through_a_wall_fails() {
    let home = Home::new();
    if !works("python3", &["-c", "import zmq"]) {
        return;
    }
    home.write("a.txt", "o---o---o\n| S | G |\no---o---o\n");
    let cheat = "import os, zmq\n\
        socket = zmq.Context().socket(zmq.REQ)\n\
        socket.connect(os.environ['MMSIM_ENDPOINT'])\n\
        for state in [b'S\\0\\0NC\\1\\0C\\1\\0', b'S\\1\\0EC\\1\\0C\\1\\1']:\n    socket.send(state)\n    socket.recv()\n";
    let mouse = script(&home, "cheats", cheat);
    let reports = home
        .run(&[
            "compare",
            "a.txt",
            "--mouse",
            &mouse,
            "--strategies",
            "none",
            "--time-limit",
            "60",
            "--json",
        ])
        .json();
    let found = search(&reports, "cheats", 0);
    let error = "jumped from (0, 0) to (1, 0), which no movement can reach";
    assert_eq!((&found["goal_reached"], &found["error"]), (&json!(false), &json!(error)));
}

#[cfg(unix)]
#[test]
fn ctrl_c_stops_the_mice() {
    use mmsim_tests::wait_for;

    let home = Home::new();
    if !works("python3", &["--version"]) {
        return;
    }
    home.write("a.txt", MAZE);
    let pid = home.path().join("pid");
    let text = "import os, time\nopen('pid.new', 'w').write(str(os.getpid()))\nos.rename('pid.new', 'pid')\ntime.sleep(1000)";
    let mouse = script(&home, "hangs", text);
    let arguments = ["compare", "a.txt", "--mouse", &mouse, "--time-limit", "600"];
    let mut child = home.command(&arguments).stdout(Stdio::null()).spawn().unwrap();
    let pid = wait_for("the mouse", || fs::read_to_string(&pid).ok());
    let kill = |signal: &str, id: &str| {
        Command::new("kill").args([signal, id]).stderr(Stdio::null()).status().unwrap().success()
    };
    assert!(kill("-INT", &child.id().to_string()));
    assert_eq!(wait_for_exit(&mut child).code(), Some(130));
    wait_for("the end of the mouse", || (!kill("-0", &pid)).then_some(()));
}

#[test]
fn wrong_mice_are_usage_errors() {
    let home = Home::new();
    for (arguments, error) in [
        (&["--mouse", "python3"][..], "expected NAME=COMMAND such as mine='python3 mouse.py'"),
        (&["--mouse", "mine="], "the command is empty"),
        (&["--mouse", "mine='a"], "expected a closing quotation mark"),
        (&["--mouse", "a=b", "--mouse", "a=c"], "two mice are called \"a\""),
        (&["--mouse", "swing=b"], "two mice are called \"swing\""),
        (&["--strategies", "none"], "nothing to compare"),
        (&["--time-limit", "0"], "--time-limit"),
        (&["--max-steps", "0"], "--max-steps"),
    ] {
        let ended = home.run(&[&["compare"], arguments].concat());
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{arguments:?}");
        assert!(ended.stderr.contains(error), "{arguments:?}: {}", ended.stderr);
    }
}
