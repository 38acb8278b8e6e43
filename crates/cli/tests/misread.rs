//! Mice that misread walls, in each command that runs mice.

mod harness;

use harness::Home;
use harness::mice::{script, works};
use serde_json::{Value, json};

const MMSIM: &str = env!("CARGO_BIN_EXE_mmsim");
const MISREAD: [&str; 4] = ["--misread", "10%", "--misread-seed", "2"];

/// Returns the search of a mouse in the only maze.
fn search<'r>(reports: &'r Value, mouse: &str) -> &'r Value {
    let reports = reports.as_array().unwrap();
    &reports.iter().find(|one| one["mouse"] == mouse).unwrap()["mazes"][0]
}

/// Returns what a mouse has done in the only maze of a contest.
fn entry(contest: &Value, mouse: &str) -> Value {
    let entries = contest["mazes"][0]["entries"].as_array().unwrap();
    let mut entry = entries.iter().find(|one| one["mouse"] == mouse).unwrap().clone();
    (entry["mouse"], entry["rank"]) = (Value::Null, Value::Null);
    entry
}

#[test]
fn the_same_seed_gives_the_same_search_in_each_command() {
    let home = Home::new();
    for kind in [&[][..], &["--misread-fixed"]] {
        let options = [&MISREAD[..], kind].concat();
        let client = |name: &str, strategy: &str| {
            format!("{name}='{MMSIM}' solve {strategy} --recover --connect {{endpoint}}")
        };
        let (first, second) = (client("f", "flood-fill"), client("s", "shortest-path-search"));
        let strategies = ["--strategies", "flood-fill,shortest-path-search"];
        let compare = ["compare", "harbour", "--recover", "--vehicle", "expert", "--json"];
        let mice = ["--mouse", &first, "--mouse", &second];
        let reports = home.run(&[&compare[..], &strategies, &options, &mice].concat()).json();
        let contest = ["contest", "harbour", "--recover", "--json"];
        let contest = home.run(&[&contest[..], &strategies, &options, &mice].concat()).json();
        for (strategy, own) in [("flood-fill", "f"), ("shortest-path-search", "s")] {
            let run = entry(&contest, strategy);
            assert_eq!(entry(&contest, own), run, "{strategy} with {options:?}");
            let (mut bundled, own) = (search(&reports, strategy).clone(), search(&reports, own));
            let seconds = |value: &Value| value.as_f64().unwrap();
            let first = &run["runs"][1];
            let end = seconds(&first["start_s"]) + seconds(&first["rest_to_rest_s"]);
            assert!((end - seconds(&bundled["total_time_s"])).abs() < 1e-3, "{run} and {bundled}");
            assert!(bundled["crashes"].as_u64() > Some(0), "{bundled}");
            // Only bundled strategies have a processor time.
            bundled["processor_time_us"] = Value::Null;
            assert_eq!(own, &bundled, "{strategy} with {options:?}");
            let optimal = |key: &str, best: &str| bundled[key].as_f64() >= bundled[best].as_f64();
            assert!(optimal("path_found", "shortest_path"), "{bundled}");
            assert!(optimal("known_run_time_s", "optimal_time_s"), "{bundled}");
        }
        let bundled = search(&reports, "flood-fill");
        let serving = home.serve(&[&["--port", "0", "harbour"], &options[..]].concat());
        let solve = ["solve", "flood-fill", "--recover", "--json", "--connect"];
        for _ in 0..2 {
            let solved = home.run(&[&solve[..], &[&serving.address]].concat()).json();
            assert_eq!(solved["steps"], bundled["search_steps"], "{solved}");
        }
        let run = ["run", "--port", "0", "--no-viewer", "--maze", "harbour"];
        let mouse = ["--", MMSIM, "solve", "flood-fill", "--recover", "--json"];
        let mouse = [&mouse[..], &["--connect", "{endpoint}"]].concat();
        let ran = home.run(&[&run[..], &options, &mouse].concat());
        assert_eq!((ran.code, &ran.json()["steps"]), (Some(0), &bundled["search_steps"]));
        let crashes = format!(", {} crashed movements", bundled["crashes"]);
        assert!(
            ran.stderr.contains(&crashes) && !ran.stderr.contains("requests refused"),
            "{ran:?}"
        );
    }
}

#[test]
fn a_strategy_that_does_not_recover_fails() {
    let home = Home::new();
    let compare = ["compare", "harbour", "--strategies", "flood-fill,shortest-path-search"];
    let misread = ["--misread", "20%", "--misread-fixed"];
    let reports = home.run(&[&compare[..], &misread, &["--json"]].concat()).json();
    for mouse in ["flood-fill", "shortest-path-search"] {
        let found = search(&reports, mouse);
        assert_eq!(
            (&found["goal_reached"], &found["fast_run_steps"]),
            (&json!(false), &json!(null))
        );
        assert!(["failed", "gave_up"].contains(&found["ending"].as_str().unwrap()), "{found}");
    }
    let text = home.run(&[&compare[..], &misread, &["--tables"]].concat()).stdout;
    assert!(text.contains("  fast runs  crashes"), "{text}");
    let note = "Walls are misread with a probability of 20 % (seed 1, always the same walls).";
    let report = home.path().join("report.html");
    let html = ["--html", report.to_str().unwrap()];
    home.run(&[&compare[..], &misread, &html].concat());
    assert!(std::fs::read_to_string(report).unwrap().contains(note));
}

#[test]
fn a_mouse_for_mms_misreads_walls_but_does_not_drive_through_them() {
    if !works("python3", &["--version"]) {
        return;
    }
    let home = Home::new();
    home.write("maze.txt", "o---o---o\n|     G |\no   o   o\n| S     |\no---o---o\n");
    // Every inner wall seems to stand, and the mouse drives through all of them.
    let mouse = "\
import sys
def ask(line):
    print(line, flush=True)
    return input()
found = [ask(line) for line in ['wallFront', 'wallLeft', 'moveForward', 'wallRight', 'turnRight',
                                'wallFront', 'moveForward', 'moveForward']]
sys.exit(found != ['true', 'true', 'ack', 'true', 'ack', 'true', 'ack', 'crash'])
";
    let command = script(&home, "mouse", mouse);
    let always = ["--misread", "100%"];
    let compare = ["compare", "maze.txt", "--strategies", "none", "--json", "--mouse", &command];
    let reports = home.run(&[&compare[..], &always].concat()).json();
    let found = search(&reports, "mouse");
    assert_eq!((&found["goal_reached"], &found["crashes"]), (&json!(true), &json!(1)), "{found}");
    let mms = ["run", "--maze", "maze.txt", "--port", "0", "--no-viewer"];
    let arguments = [&mms[..], &always, &["--", "python3", "mouse.py"]].concat();
    let ended = home.run(&arguments);
    assert_eq!(ended.code, Some(0), "{ended:?}");
}

#[test]
fn a_mouse_for_mms_ends_if_its_simulator_misreads_walls() {
    if !works("python3", &["--version"]) {
        return;
    }
    let home = Home::new();
    home.write("maze.txt", "o---o---o\n|     G |\no   o   o\n| S |   |\no---o---o\n");
    let mouse = "\
def ask(line):
    print(line, flush=True)
    return input()
assert [ask('turnRight'), ask('wallFront')] == ['ack', 'false']
ask('moveForward')
";
    home.write("mouse.py", mouse);
    let serving = home.serve(&["maze.txt", "--port", "0", "--misread", "100%"]);
    let options = ["--connect", &serving.address, "--goal", "server", "--json"];
    let ended = home.run(&[&["run"], &options[..], &["--", "python3", "mouse.py"]].concat());
    let report = ended.json();
    assert_eq!((ended.code, &report["goal_reached"]), (Some(1), &json!(false)), "{report}");
    let error = report["error"].as_str().unwrap();
    assert!(error.starts_with("stopped: the simulator refused S: crash"), "{error}");
    let hint = "(if the simulator misreads walls, use mmsim run --misread instead of --connect)";
    assert!(error.ends_with(hint), "{error}");
}

#[test]
fn a_crash_counts_as_a_touch_in_a_contest() {
    let home = Home::new();
    home.write(
        "maze.txt",
        "o---o---o---o\n|         G |\no   o---o---o\n| S |       |\no---o---o---o\n",
    );
    let misread = ["--misread", "100%", "--misread-fixed", "--recover"];
    let contest = ["contest", "maze.txt", "--strategies", "flood-fill", "--json"];
    let result = home.run(&[&contest[..], &misread].concat()).json();
    let entry = &result["mazes"][0]["entries"][0];
    assert_eq!(
        (&entry["goal_reached"], &entry["touched"]),
        (&json!(true), &json!(true)),
        "{entry}"
    );
}

#[test]
fn wrong_options_are_usage_errors() {
    let home = Home::new();
    for (wrong, reason) in [
        (&["compare", "--recover"][..], "--misread"),
        (&["compare", "--misread-fixed"], "--misread"),
        (&["--misread-seed", "2"], "--misread"),
        (&["--misread", "2"], "expected a probability from 0 to 100%, such as 1% or 0.01"),
        (&["run", "--misread", "1%", "--connect", "tcp://127.0.0.1:1", "--", "true"], "--connect"),
    ] {
        let refused = home.run(wrong);
        assert_eq!(refused.code, Some(2), "{refused:?}");
        assert!(refused.stderr.contains(reason), "{refused:?}");
    }
}

#[test]
fn the_same_seed_gives_a_mouse_for_mms_the_same_replies_in_each_command() {
    if !works("python3", &["--version"]) {
        return;
    }
    let home = Home::new();
    let mouse = "\
import sys
replies = []
def ask(line):
    print(line, flush=True)
    replies.append(input())
    return replies[-1] == 'true'
for _ in range(60):
    if not ask('wallLeft'):
        ask('turnLeft')
    elif ask('wallFront'):
        ask('turnRight')
        continue
    ask('moveForward')
open(sys.argv[1], 'w').write(' '.join(replies))
";
    let command = script(&home, "mouse", mouse);
    let maze = concat!(env!("CARGO_MANIFEST_DIR"), "/../../mazes/01-harbour.txt");
    for kind in [&[][..], &["--misread-fixed"]] {
        let options = [&MISREAD[..], kind].concat();
        let [compared, run] = ["compared.txt", "run.txt"].map(|name| home.path().join(name));
        let own = format!("{command} '{}'", compared.display());
        let compare = ["compare", maze, "--strategies", "none", "--json", "--mouse", &own];
        home.run(&[&compare[..], &options].concat()).json();
        let mms = ["run", "--maze", maze, "--port", "0", "--no-viewer"];
        let mouse = ["--", "python3", "mouse.py", run.to_str().unwrap()];
        home.run(&[&mms[..], &options, &mouse].concat());
        let [compared, run] = [compared, run].map(|path| std::fs::read_to_string(path).unwrap());
        assert_eq!(compared, run, "{options:?}");
        assert!(run.contains("crash"), "{run}");
    }
}
