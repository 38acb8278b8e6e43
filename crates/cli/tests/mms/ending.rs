//! The output and the exit code for each way a mouse can exit.

use super::harness::while_default_port_is_in_use;
use super::*;

#[test]
fn the_exit_code_is_that_of_the_mouse() {
    let home = Home::new();
    let Some(ended) = run(&home, &[], "sys.exit(7)") else { return };
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(7), ""));
    assert!(
        ended.stderr.contains("exited with code 7; goal not reached, no command of mms and no "),
        "{ended:?}"
    );
    let at_once = run(&home, &["--as", "mms", "--score"], "").unwrap();
    assert_eq!(at_once.code, Some(0));
    insta::assert_snapshot!(at_once.stdout, @"
    score: 2000
    best-run-distance: -1
    best-run-effective-distance: -1
    best-run-turns: -1
    total-distance: 0
    total-effective-distance: 0
    total-turns: 0
    ");
}

#[cfg(unix)]
#[test]
fn a_signal_that_kills_the_mouse_sets_the_exit_code() {
    let home = Home::new();
    let mouse = "ask('moveForward')\nos.kill(os.getpid(), 9)";
    let Some(ended) = run(&home, &["--json"], mouse) else { return };
    assert_eq!(ended.code, Some(137));
    assert!(
        ended.stderr.contains("mouse killed by signal 9 after command 1; goal not reached"),
        "{ended:?}"
    );
    assert_eq!((&ended.json()["exit_code"], &ended.json()["signal"]), (&json!(null), &json!(9)));
}

#[test]
fn a_mouse_asks_for_the_goal_cells() {
    let home = Home::new();
    home.write("small.txt", SMALL);
    let mouse = "print(ask('goals'), ask('mazeWidth'), file=sys.stderr)";
    let Some(ended) = run(&home, &["--maze", "small.txt"], mouse) else { return };
    assert!(ended.stderr.contains("\n1 3 2 4\n"), "{ended:?}");
}

#[test]
fn the_limit_stops_the_mouse() {
    let home = Home::new();
    home.write("small.txt", SMALL);
    let mouse = "while True: ask('turnLeft')";
    let Some(ended) = run(&home, &["--maze", "small.txt", "--limit", "50", "--json"], mouse) else {
        return;
    };
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.contains("mouse stopped: exceeded --limit 50;"), "{ended:?}");
    let report = ended.json();
    assert_eq!((&report["ending"], &report["total_turns"]), (&json!("step_limit"), &json!(51)));
    let within = "ask('turnLeft'), ask('turnRight'), ask('moveForward 0')";
    assert_eq!(run(&home, &["--maze", "small.txt", "--limit", "2"], within).unwrap().code, Some(0));
}

#[test]
fn the_time_limit_stops_a_mouse_that_waits_or_loops() {
    let home = Home::new();
    home.write("small.txt", SMALL);
    // The last mouse closes its output but does not exit.
    let mice = [
        ("time.sleep(600)", &["--time-limit", "0.5"][..]),
        ("while True: ask('wallFront')", &["--time-limit", "0.5"]),
        ("ask('turnLeft'), ask('turnLeft')", &["--time-limit", "0.5", "--pace", "600000"]),
        ("os.close(1), time.sleep(600)", &["--time-limit", "0.5"]),
    ];
    for (mouse, options) in mice {
        let options = [&["--maze", "small.txt", "--json"], options].concat();
        let Some(ended) = run(&home, &options, mouse) else { return };
        assert_eq!(ended.code, Some(1), "{mouse}");
        assert!(ended.stderr.contains("mouse stopped after 0.5 s;"), "{ended:?}");
        assert_eq!(ended.json()["ending"], "time_limit", "{mouse}");
    }
    let ended =
        run(&home, &["--maze", "small.txt", "--time-limit", "600", "--json"], "sys.exit(3)")
            .unwrap();
    assert_eq!((ended.code, &ended.json()["ending"]), (Some(3), &json!("failed")));
}

/// Returns true if this process exists and is not a zombie.
#[cfg(target_os = "linux")]
fn lives(id: &str) -> bool {
    let status = fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    status.rsplit(')').next().is_some_and(|rest| !rest.trim().is_empty() && !rest.starts_with(" Z"))
}

#[cfg(target_os = "linux")]
#[test]
fn child_processes_of_the_mouse_are_killed() {
    let home = Home::new();
    // The limit kills the script and its child process.
    let script = "sleep 600 & echo sleeps $! >&2; echo turnLeft; wait";
    let limited = home.run(&arguments(&["--limit", "0"], &["sh", "-c", script]));
    assert_eq!(limited.code, Some(1), "{limited:?}");
    let sleeps = limited.stderr.split("sleeps ").nth(1).unwrap().lines().next().unwrap();
    assert!(!lives(sleeps), "{limited:?}");
    // The script exits. The command does not wait for the child process, which keeps the pipe open.
    let ended = home.run(&arguments(&[], &["sh", "-c", "sleep 600 & exit 3"]));
    assert_eq!(ended.code, Some(3), "{ended:?}");
}

/// The `script` tool runs a shell in its own pseudo-terminal, and the shell runs the command in the
/// background.
#[cfg(target_os = "linux")]
#[test]
fn runs_in_the_background_of_a_terminal() {
    let home = Home::new();
    let mouse = "run --no-viewer --port 0 -- sh -c 'sleep 0.5; exit 5'";
    let mmsim = env!("CARGO_BIN_EXE_mmsim");
    let lines = [
        "set -m",
        &format!("{mmsim} {mouse} &"),
        // A stopped process would never exit.
        "mouse=$!; (sleep 300; kill -KILL $mouse) & end=$!",
        "wait $mouse; echo status $?; kill -- -$end",
    ];
    home.write("run.sh", lines.join("\n"));
    let mut script = Command::new("script");
    let script = script.args(["-qc", "bash run.sh", "/dev/null"]).current_dir(home.path());
    let output = output(script.env("HOME", home.path()));
    let messages = String::from_utf8_lossy(&output.stdout);
    assert!(messages.contains("status 5"), "{messages}");
    assert!(!messages.contains("press Enter"), "{messages}");
}

#[test]
fn a_missing_program_is_an_error() {
    let home = Home::new();
    let ended = home.run(&arguments(&QUIET, &["no-such-mouse", "1"]));
    assert_eq!(ended.code, Some(1));
    let messages = ended.stderr.lines().last().unwrap();
    assert!(messages.starts_with("mmsim: cannot start the mouse no-such-mouse: "), "{messages}");
    assert!(messages.ends_with("give its path, such as ./my-mouse)"), "{messages}");
    let options = [&QUIET[..], &["--stay", "--json"]].concat();
    let report = home.run(&arguments(&options, &["no-such-mouse"])).json();
    assert_eq!(report["error"].as_str(), messages.strip_prefix("mmsim: "));
    for wrong in [
        &["run"][..],
        &["run", "--"],
        &["run", "--size", "8x8", "--", "mouse"],
        &["run", "--connect", "tcp://127.0.0.1:1", "--maze", "a", "--", "mouse"],
        &["run", "--connect", "tcp://127.0.0.1:1", "--port", "1", "--", "mouse"],
        &["run", "--connect", "tcp://127.0.0.1:1", "--watch", "--", "mouse"],
        &["run", "--watch", "--", "java"],
        &["run", "--watch", "--", "./no-such-mouse"],
        &["run", "--connect", "tcp://127.0.0.1:1", "--goal", "server", "1,1", "--", "mouse"],
    ] {
        assert_eq!(home.run(wrong).code, Some(2), "{wrong:?}");
    }
}

#[test]
fn a_free_port_is_used_if_the_default_port_is_in_use() {
    let home = Home::new();
    let mouse = ["--no-viewer", "--", env!("CARGO_BIN_EXE_mmsim"), "--version"];
    let free = [&["run"], &mouse[..]].concat();
    let ended = while_default_port_is_in_use(|| home.run(&free));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let expected = "port 6574 on 127.0.0.1 is already in use; using a free port instead\n";
    assert!(ended.stderr.contains(expected), "{ended:?}");
    let given = [&["run", "--port", "6574"], &mouse[..]].concat();
    let given = while_default_port_is_in_use(|| home.run(&given));
    assert_eq!(given.code, Some(1), "{given:?}");
}

#[cfg(unix)]
#[test]
fn stay_keeps_serving_after_the_mouse_exits() {
    let home = Home::new();
    let options = ["--port", "0", "--viewer-port", "0", "--stay"];
    let Some(command) = command(&home, &options, "ask('moveForward')\nsys.exit(5)") else { return };
    let mut serving = Serving::start(command, "still serving");
    assert!(serving.messages.contains("watch at http://"), "{}", serving.messages);
    assert_eq!(states_of(&serving.address), 2);
    serving.signal("INT");
    assert_eq!(serving.wait().0.code(), Some(5));
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_the_mouse() {
    let home = Home::new();
    let silent = "print('mouse', os.getpid(), file=sys.stderr, flush=True)\ntime.sleep(600)";
    let slow = "print('mouse', os.getpid(), file=sys.stderr, flush=True)\nask('turnLeft')";
    for (mouse, options) in
        [(silent, &QUIET[..]), (slow, &[&QUIET[..], &["--pace", "60000"]].concat())]
    {
        let Some(command) = command(&home, options, mouse) else { return };
        let mut serving = Serving::start(command, "mouse ");
        let mouse = serving.messages.split_whitespace().last().unwrap().to_string();
        serving.signal("INT");
        let (status, messages) = serving.wait();
        assert_eq!(status.code(), Some(130), "{messages}");
        assert!(messages.contains("mouse stopped by Ctrl-C"), "{messages}");
        let is_there = output(Command::new("sh").args(["-c", &format!("kill -0 {mouse} 2>&-")]));
        assert!(!is_there.status.success(), "{mouse} lives on");
    }
}
