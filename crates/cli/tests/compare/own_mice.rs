//! The user's own mice, compared with the bundled strategies.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use mmsim_tests::{output, wait_for_exit};
use serde_json::{Value, json};

use crate::harness::Home;
use crate::harness::mice::{script, works};

const MAZE: &str = "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n";

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

fn search<'r>(reports: &'r Value, mouse: &str, maze: usize) -> &'r Value {
    let reports = reports.as_array().unwrap().iter();
    let report = reports.clone().find(|report| report["mouse"] == mouse).expect("the mouse");
    &report["mazes"][maze]
}

/// Runs a mouse in the maze `a.txt`, and returns the report on this search.
fn search_alone(home: &Home, mouse: &str) -> Value {
    let arguments = ["compare", "a.txt", "--strategies", "none", "--mouse", mouse];
    let mut reports =
        home.run(&[&arguments[..], &["--time-limit", "600", "--json"]].concat()).json();
    reports[0]["mazes"][0].take()
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
    arguments.extend(["--json", "--strategies", "flood-fill", "--time-limit", "600"]);
    arguments.extend(mice.iter().flat_map(|mouse| ["--mouse", mouse]));
    let reports = home.run(&arguments).json();
    let names: Vec<_> = reports.as_array().unwrap().iter().map(|one| &one["mouse"]).collect();
    assert_eq!(names, ["cpp", "client", "python", "flood-fill"]);
    for report in reports.as_array().unwrap() {
        assert_eq!((&report["goal_reached"], report["reachable"].as_u64()), (&json!(4), Some(4)));
        let is_own = report["mouse"] != "flood-fill";
        assert_eq!(report["command"].is_string(), is_own);
        assert_eq!(report["statistics"]["processor_time_us"]["distribution"].is_null(), is_own);
    }
    // The client makes the same decisions as the strategy.
    for maze in 0..4 {
        let (own, bundled) =
            (search(&reports, "client", maze), search(&reports, "flood-fill", maze));
        for key in
            ["steps_to_goal", "steps_until_proven", "search_steps", "search_turns", "path_found"]
        {
            assert_eq!(own[key], bundled[key], "{key}: {own}");
        }
    }
    let difference = &reports[1]["statistics"]["steps_to_goal"]["difference"];
    assert_eq!((&difference["maze_count"], difference["mean"].is_f64()), (&json!(4), true));
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
    let hangs = script(&home, "hangs", "import time\ntime.sleep(1000)");
    let arguments =
        ["compare", "mazes", "--strategies", "none", "--mouse", &hangs, "--time-limit", "0.3"];
    let ended = home.run(&[&arguments[..], &["--json"]].concat());
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let reports = ended.json();
    let hint = "(it has neither written mms commands nor connected to MMSIM_ENDPOINT)";
    let stopped = format!("stopped after 0.3 s {hint}");
    let skipped = "skipped: stopped by the time limit in each of the first 3 mazes";
    for maze in 0..5 {
        let found = search(&reports, "hangs", maze);
        let (ending, error) =
            if maze < 3 { ("time_limit", &*stopped) } else { ("skipped", skipped) };
        assert_eq!((&found["ending"], &found["error"]), (&json!(ending), &json!(error)));
    }
    assert_eq!(reports[0]["endings"]["skipped"], 2);

    let command = "print('mazeWidth', flush=True)\ninput()\n";
    let mice = [
        script(&home, "crashes", "import sys\nsys.exit('a bad day')"),
        script(&home, "floods", "while True: print('hello ' * 100)"),
        script(&home, "endless", "import sys\nwhile True: sys.stdout.write('hello' * 1000)"),
        script(&home, "stops", ""),
        script(&home, "misspells", &format!("{command}print('moveforward', flush=True)")),
        "missing=no-such-mouse".into(),
    ];
    let mut arguments =
        vec!["compare", "mazes", "--strategies", "flood-fill", "--time-limit", "600"];
    arguments.extend(mice.iter().flat_map(|mouse| ["--mouse", mouse]));
    let ended = home.run(&[&arguments[..], &["--json"]].concat());
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let reports = ended.json();
    for maze in 0..5 {
        for (mouse, ending, error) in [
            ("crashes", "failed", "exited with code 1: a bad day"),
            ("floods", "failed", "wrote 4 MiB without a valid command (it has neither "),
            ("endless", "failed", "wrote 4 MiB without a valid command (it has neither "),
            ("stops", "gave_up", "exited without reaching the goal (it has neither written "),
            (
                "misspells",
                "gave_up",
                "exited without reaching the goal: never moved; last invalid line: unknown command \"moveforward\"",
            ),
            ("missing", "failed", "cannot start the mouse no-such-mouse: "),
            ("flood-fill", "finished", ""),
        ] {
            let found = search(&reports, mouse, maze);
            assert_eq!(found["ending"], ending, "{found}");
            let found = found["error"].as_str().unwrap_or_default();
            assert!(found.starts_with(error), "{mouse}: {found}");
        }
    }
    let ended = home.run(&arguments);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    for mouse in ["crashes", "floods", "endless", "stops", "misspells", "missing"] {
        assert!(ended.stdout.contains(&format!("\n{mouse}: 5 mazes not solved\n")), "{ended:?}");
    }
    let line = "\n  not solved: a, b, c, d and 1 more: exited with code 1: a bad day\n";
    assert!(ended.stdout.contains(line), "{}", ended.stdout);
    assert!(ended.stdout.contains("\nflood-fill: nothing lost\n"), "{}", ended.stdout);
}

/// A mouse that writes all commands at once, and exits without reading the replies.
#[test]
fn everything_that_a_mouse_has_written_is_executed() {
    let home = Home::new();
    if !works("python3", &["--version"]) {
        return;
    }
    for maze in 0..20 {
        home.write(&format!("mazes/{maze}.txt"), MAZE);
    }
    let text = "import sys\nsys.stdout.write('turnRight\\n' * 3000)";
    let mouse = script(&home, "talks", text);
    let arguments = ["compare", "mazes", "--strategies", "none", "--mouse", &mouse];
    let reports = home.run(&[&arguments[..], &["--time-limit", "600", "--json"]].concat()).json();
    for maze in 0..20 {
        assert_eq!(search(&reports, "talks", maze)["search_turns"], 3000);
    }
}

/// The child process keeps the output open and writes commands until it is killed.
#[cfg(unix)]
#[test]
fn a_child_process_of_a_mouse_cannot_prolong_its_search() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    home.write("forks.sh", "while :; do echo setText 0 0 a; sleep 0.01; done &");
    let mouse = "forks=sh forks.sh";
    let arguments = ["compare", "a.txt", "--strategies", "none", "--mouse", mouse];
    let reports = home.run(&[&arguments[..], &["--time-limit", "2", "--json"]].concat()).json();
    assert_eq!(search(&reports, "forks", 0)["ending"], "gave_up");
}

#[test]
fn a_failure_after_the_goal_is_named() {
    let home = Home::new();
    if !works("python3", &["--version"]) {
        return;
    }
    home.write("a.txt", MAZE);
    let drive = "for line in ['moveForward', 'turnRight', 'moveForward', 'turnRight']:\n    \
        print(line, flush=True)\n    input()\n";
    let mice = [
        script(&home, "crashes", &format!("{drive}raise SystemExit('too happy')")),
        script(
            &home,
            "turns",
            &format!("{drive}while True:\n    print('turnRight', flush=True)\n    input()"),
        ),
    ];
    let mut arguments =
        vec!["compare", "a.txt", "--strategies", "flood-fill", "--time-limit", "600"];
    arguments.extend(mice.iter().flat_map(|mouse| ["--mouse", mouse]));
    let ended = home.run(&arguments);
    for line in [
        "crashes: 1 maze not solved\n  not solved: a: exited with code 1: too happy\n",
        "turns: 1 maze not solved\n  not solved: a: stopped after 10000 states\n",
    ] {
        assert!(ended.stdout.contains(line), "{}", ended.stdout);
    }
    // The numbers of the whole search are not known.
    let reports = home.run(&[&arguments[..], &["--json"]].concat()).json();
    for mouse in 0..2 {
        let statistics = &reports[mouse]["statistics"];
        assert_eq!(statistics["steps_to_goal"]["maze_count"], 1);
        assert_eq!(statistics["search_turns"]["maze_count"], 0);
    }
    // A mouse that is stopped at the goal has finished.
    let reports = home.run(&[&arguments[..], &["--json", "--stop-at-goal"]].concat()).json();
    for mouse in 0..2 {
        let (report, search) = (&reports[mouse], &reports[mouse]["mazes"][0]);
        assert_eq!((&search["ending"], &search["error"]), (&"finished".into(), &Value::Null));
        assert_eq!((&search["states"], &report["goal_reached"]), (&4.into(), &1.into()));
    }
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
    let found = search_alone(&home, &mouse);
    assert_eq!((&found["ending"], &found["error"]), (&json!("finished"), &Value::Null));
    assert_eq!(
        (&found["steps_to_goal"], &found["search_turns"], &found["crashes"]),
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
    let found = search_alone(&home, &mouse);
    let error = "jumped from (0, 0) to (1, 0), which no movement can reach";
    assert_eq!((&found["goal_reached"], &found["error"]), (&json!(false), &json!(error)));
}

#[cfg(unix)]
#[test]
fn ctrl_c_stops_the_mice() {
    check_interrupt(&[]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_while_recording_leaves_no_folder() {
    check_interrupt(&["--open"]);
}

/// Checks that Ctrl-C ends a mouse that hangs, and that no temporary files remain.
#[cfg(unix)]
fn check_interrupt(options: &[&str]) {
    use mmsim_tests::wait_for;

    let home = Home::new();
    if !works("python3", &["--version"]) {
        return;
    }
    home.write("a.txt", MAZE);
    let (pid, temporary) = (home.path().join("pid"), home.path().join("tmp"));
    fs::create_dir(&temporary).unwrap();
    let text = "import os, time\nopen('pid.new', 'w').write(str(os.getpid()))\nos.rename('pid.new', 'pid')\ntime.sleep(1000)";
    let mouse = script(&home, "hangs", text);
    let arguments =
        ["compare", "a.txt", "--mouse", &mouse, "--strategies", "none", "--time-limit", "600"];
    let mut command = home.command(&[&arguments[..], options].concat());
    command.env("TMPDIR", &temporary).stdout(Stdio::null());
    let mut child = command.spawn().unwrap();
    let pid = wait_for("the mouse", || fs::read_to_string(&pid).ok());
    let kill = |signal: &str, id: &str| {
        Command::new("kill").args([signal, id]).stderr(Stdio::null()).status().unwrap().success()
    };
    assert!(kill("-INT", &child.id().to_string()));
    assert_eq!(wait_for_exit(&mut child).code(), Some(130));
    wait_for("the end of the mouse", || (!kill("-0", &pid)).then_some(()));
    assert_eq!(fs::read_dir(&temporary).unwrap().count(), 0);
}

#[cfg(unix)]
#[test]
fn the_command_for_a_lone_mouse_opens_a_maze_that_it_did_not_solve() {
    let home = Home::new();
    let ended = home.run(&["compare", "harbour", "--mouse", "lost=true", "--strategies", "none"]);
    let command = "  mmsim compare --open 01-harbour --mouse 'lost=true' --strategies none\n";
    assert!(ended.stdout.contains(command), "{ended:?}");
}

#[test]
fn wrong_mice_are_usage_errors() {
    let home = Home::new();
    for (arguments, error) in [
        (&["--mouse", "python3"][..], "expected NAME=COMMAND such as \"mine=python3 mouse.py\""),
        (&["--mouse", "mine="], "the command is empty"),
        (&["--mouse", "mine='a"], "expected a closing quotation mark"),
        (&["--mouse", "a=b", "--mouse", "a=c"], "two mice are called \"a\""),
        (&["--mouse", "swing=b"], "two mice are called \"swing\""),
        (&["--strategies", "none"], "no mice: --strategies none"),
        (&["--time-limit", "3"], "--mouse <NAME=COMMAND>"),
        (&["--max-states", "3"], "--mouse <NAME=COMMAND>"),
        (&["--time-limit", "0"], "--time-limit"),
        (&["--max-states", "0"], "--max-states"),
    ] {
        let ended = home.run(&[&["compare"], arguments].concat());
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{arguments:?}");
        assert!(ended.stderr.contains(error), "{arguments:?}: {}", ended.stderr);
    }
}
