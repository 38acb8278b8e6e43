//! `mmsim contest`: mice compete under the rules of a contest.

mod harness;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use harness::Home;
use harness::mice::{AROUND, BACK, LOOP, assert_close, commands, script, works};
use serde_json::{Value, json};

const STRATEGIES: &str =
    "flood-fill,weight-increment,left-wall,swing,shortest-path-search,fastest-path-search";

/// A vehicle that searches at 1 s for each cell and turns in no time.
const SLOW: &str = "base = 'expert'\nsearch_speed = 180\nsearch_turn_time = 0\n";

const CLOSED: &str = "o---o---o\n| S | G |\no---o---o\n";

/// Returns the words of each line that has any.
fn words(text: &str) -> Vec<Vec<&str>> {
    let lines = text.lines().map(|line| line.split_whitespace().collect());
    lines.filter(|words: &Vec<_>| !words.is_empty()).collect()
}

#[test]
fn the_tables_are_those_of_the_documentation() {
    let home = Home::new();
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/contest.md");
    let page = fs::read_to_string(page).unwrap();
    let shown = words(&page);
    for arguments in [&["harbour", "--rules", "apec"][..], &["--rules", "uk"]] {
        let arguments = [&["contest", "--strategies", STRATEGIES], arguments].concat();
        let ended = home.run(&arguments);
        assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
        assert!(ended.stdout.lines().all(|line| line.len() <= 80), "{}", ended.stdout);
        for line in words(&ended.stdout) {
            assert!(shown.contains(&line), "{line:?} is missing in docs/contest.md");
        }
    }
}

fn entry<'r>(contest: &'r Value, maze: usize, mouse: &str) -> &'r Value {
    let mut entries = contest["mazes"][maze]["entries"].as_array().unwrap().iter();
    entries.find(|entry| entry["mouse"] == mouse).expect("the mouse")
}

/// Returns the times of the run to the east, from rest to rest and from gate to gate: 450 mm with
/// 17 m/s² and 2.5 m/s. The gates are 135 mm from the ends.
fn straight() -> (f64, f64) {
    let rest_to_rest = 5.0 / 17.0 + (0.45 - 6.25 / 17.0) / 2.5;
    (rest_to_rest, rest_to_rest - 2.0 * (2.0 * 0.135_f64 / 17.0).sqrt())
}

#[test]
fn json_has_every_run_of_every_mouse() {
    let home = Home::new();
    home.write("a.txt", LOOP);
    home.write("slow.toml", "base = 'expert'\nsearch_speed = 180\nsearch_turn_time = 0.5\n");
    let arguments = ["contest", "a.txt", "--rules", "apec", "--vehicle", "slow.toml", "--json"];
    let mice = ["--strategies", "flood-fill,shortest-path-search"];
    let contest = home.run(&[&arguments[..], &mice].concat()).json();
    let (rest_to_rest, gate_to_gate) = straight();
    for (key, value) in [
        ("rules", json!("apec")),
        ("time_limit_s", json!(420.0)),
        ("max_runs", json!(5)),
        ("touch_penalty_s", json!(2.0)),
        (
            "vehicles",
            json!([{"vehicle": "slow", "search_speed_mm_s": 180.0, "search_turn_time_s": 0.5}]),
        ),
        ("skipped", json!([])),
    ] {
        assert_eq!(contest[key], value);
    }
    assert_close(&contest["search_share"], 1.0 / 30.0);
    let flood = entry(&contest, 0, "flood-fill");
    let search_run = flood["runs"][0]["time_s"].as_f64().unwrap();
    assert_eq!((&flood["runs"][0]["kind"], &flood["touched"]), (&json!("search"), &json!(true)));
    assert_close(&flood["runs"][0]["score_s"], search_run);
    let begins = search_run + 2.0 + 4.0 * 0.5;
    assert_close(&flood["search_time_s"], begins);
    let mut start = begins;
    for run in 1..5 {
        let found = &flood["runs"][run];
        assert_eq!((&found["kind"], &found["touched"]), (&json!("fast"), &json!(true)));
        assert_close(&found["start_s"], start);
        assert_close(&found["time_s"], gate_to_gate);
        assert_close(&found["rest_to_rest_s"], rest_to_rest);
        assert_close(&found["score_s"], gate_to_gate + start / 30.0 + 2.0);
        start += rest_to_rest + 2.0 + 4.0 * 0.5;
    }
    assert_eq!(flood["runs"].as_array().unwrap().len(), 5);
    let best = entry(&contest, 0, "shortest-path-search");
    assert_eq!(
        (&best["touched"], &best["rank"], &flood["rank"]),
        (&json!(false), &json!(1), &json!(2))
    );
    assert_close(&best["score_s"], gate_to_gate + best["search_time_s"].as_f64().unwrap() / 30.0);
    let standings = contest["standings"].as_array().unwrap();
    assert_eq!(standings[0]["mouse"], "shortest-path-search");
    assert_eq!((&standings[0]["scored"], &standings[0]["wins"]), (&json!(1), &json!(1)));
    assert_eq!([&standings[0]["points"], &standings[1]["points"]], [1.0, 0.0]);
}

/// A half-size mouse drives in mazes of more than 16 cells in a row.
#[test]
fn each_maze_has_the_vehicle_of_its_size() {
    let home = Home::new();
    let corridor = |cells: usize| {
        let (edge, room) = ("o---".repeat(cells) + "o", "    ".repeat(cells - 2));
        format!("{edge}\n| S {room}  G |\n{edge}\n")
    };
    home.write("mazes/a.txt", corridor(16));
    home.write("mazes/b.txt", corridor(17));
    let contest = ["contest", "mazes", "--strategies", "flood-fill"];
    let report = home.run(&[&contest[..], &["--json"]].concat()).json();
    // A turn and 15 cells of 180 mm at 600 mm/s; a turn and 16 cells of 90 mm at 300 mm/s.
    let expected = [("expert", 0.2 + 15.0 * 0.3), ("kerise", 0.25 + 16.0 * 0.3)];
    for (index, (vehicle, time)) in expected.into_iter().enumerate() {
        assert_eq!(report["mazes"][index]["vehicle"], vehicle);
        let runs = &entry(&report, index, "flood-fill")["runs"];
        assert_close(&runs[0]["time_s"], time);
        assert_eq!(report["vehicles"][index]["vehicle"], vehicle);
    }
    let text = home.run(&contest).stdout;
    let expected = "Vehicle expert in 1 maze; searches at 600 mm/s and 0.2 s per quarter turn.\n\
                    Vehicle kerise in 1 maze; searches at 300 mm/s and 0.25 s per quarter turn.\n";
    assert!(text.contains(expected), "{text}");
    let driven = home.run(&["fast-run", "mazes", "--json"]).json();
    assert_eq!([&driven[0]["vehicle"], &driven[1]["vehicle"]], ["expert", "kerise"]);
}

#[test]
fn csv_has_a_line_for_each_mouse_in_each_maze() {
    let home = Home::new();
    home.write("mazes/a.txt", LOOP);
    home.write("mazes/closed.txt", CLOSED);
    let arguments = ["contest", "mazes", "--strategies", "flood-fill,shortest-path-search"];
    let ended = home.run(&[&arguments[..], &["--csv"]].concat());
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    let contest = home.run(&[&arguments[..], &["--json"]].concat()).json();
    let mut csv = csv::Reader::from_reader(ended.stdout.as_bytes());
    let rows: Vec<BTreeMap<String, String>> = csv.deserialize().collect::<Result<_, _>>().unwrap();
    assert_eq!(rows.len(), 2, "a maze with an unreachable goal has no line");
    for (row, entry) in rows.iter().zip(contest["mazes"][0]["entries"].as_array().unwrap()) {
        assert_eq!(row["vehicle"], "expert");
        for key in [
            "rank",
            "mouse",
            "points",
            "score_s",
            "search_time_s",
            "touched",
            "goal_reached",
            "ending",
        ] {
            let value = entry[key].as_str().map_or_else(|| entry[key].to_string(), String::from);
            assert_eq!(row[key], value, "{key}");
        }
        let runs = entry["runs"].as_array().unwrap();
        let best = runs.iter().find(|run| run["score_s"] == entry["score_s"]).unwrap();
        for key in ["time_s", "rest_to_rest_s", "start_s"] {
            assert_eq!(row[key], best[key].to_string(), "{key}");
        }
        assert_eq!((&*row["maze"], &*row["error"]), ("a", ""));
        assert_eq!(row["runs"], runs.len().to_string());
        assert_eq!(row["search_run_s"], runs[0]["time_s"].to_string());
    }
    let ended = home.run(&[&arguments[..], &["--csv", "--json"]].concat());
    assert_eq!(ended.code, Some(2));
}

#[test]
fn points_of_several_mazes_are_added() {
    let home = Home::new();
    home.write("mazes/a.txt", LOOP);
    home.write("mazes/b.txt", "o---o---o\n| S   G |\no---o---o\n");
    home.write("mazes/closed.txt", CLOSED);
    home.write("mazes/damaged.txt", "o---o\n| S \no---o\n");
    let arguments = ["contest", "mazes", "--strategies", "swing,left-wall"];
    let ended = home.run(&arguments);
    assert_eq!(ended.code, Some(1), "a maze cannot be read");
    assert!(ended.stderr.contains("damaged.txt"), "{}", ended.stderr);
    assert!(ended.stdout.contains("\nSkipped 1 maze with an unreachable goal: closed\n"));
    let contest = home.run(&[&arguments[..], &["--json"]].concat()).json();
    assert_eq!(
        (contest["mazes"].as_array().unwrap().len(), &contest["skipped"]),
        (2, &json!(["closed"]))
    );
    for standing in contest["standings"].as_array().unwrap() {
        let mouse = standing["mouse"].as_str().unwrap();
        let points = [0, 1].map(|maze| entry(&contest, maze, mouse)["points"].as_f64().unwrap());
        assert_close(&standing["points"], points[0] + points[1]);
        assert_eq!(standing["scored"], 2);
    }
    let ended = home.run(&["contest", "mazes/closed.txt"]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(ended.stdout.ends_with("\nSkipped 1 maze with an unreachable goal: closed\n"));
    let ended = home.run(&["contest", "mazes/damaged.txt"]);
    assert_eq!((ended.code, &ended.stdout[..]), (Some(1), ""));
}

#[test]
fn a_slow_search_leaves_time_for_fewer_runs() {
    let home = Home::new();
    home.write("a.txt", LOOP);
    home.write("slow.toml", SLOW);
    let slow = ["--vehicle", "slow.toml"];
    let runs = |options: &[&str]| {
        let arguments = ["contest", "a.txt", "--strategies", "shortest-path-search", "--json"];
        let contest = home.run(&[&arguments[..], options].concat()).json();
        let found = entry(&contest, 0, "shortest-path-search").clone();
        (found["runs"].as_array().unwrap().len(), found["error"].clone(), found)
    };
    let (count, error, found) = runs(&slow);
    assert_eq!((count, error), (5, Value::Null));
    let back = found["search_time_s"].as_f64().unwrap();
    // One run takes 0.33 s, and the mouse needs 2 s to return.
    let limit = |seconds: f64| seconds.to_string();
    let (count, ..) = runs(&[&slow[..], &["--contest-time", &limit(back + 3.0)]].concat());
    assert_eq!(count, 3);
    let (count, error, found) =
        runs(&[&slow[..], &["--contest-time", &limit(back + 0.1)]].concat());
    assert_eq!((count, &found["score_s"]), (1, &found["runs"][0]["time_s"]));
    assert!(
        error.as_str().unwrap().starts_with("no time for a fast run: back at the start after ")
    );
    let (count, error, found) = runs(&[&slow[..], &["--contest-time", "1"]].concat());
    assert_eq!((count, &found["score_s"], &found["rank"]), (0, &Value::Null, &Value::Null));
    assert!(error.as_str().unwrap().ends_with(" the contest takes 1 s"), "{error}");
    assert_eq!(runs(&["--max-runs", "2"]).0, 2);
}

#[test]
fn touches_are_resets_crashes_and_mice_that_do_not_return() {
    let home = Home::new();
    if !works("python3", &["--version"]) {
        return;
    }
    home.write("a.txt", LOOP);
    let mice = [
        commands(&home, "returns", &[AROUND, BACK].concat()),
        commands(&home, "stops", AROUND),
        commands(&home, "crashes", &["turnLeft moveForward turnRight ", AROUND, BACK].concat()),
        commands(&home, "resets", &[AROUND, "ackReset ", AROUND].concat()),
        commands(&home, "begins-again", &["moveForward ackReset ", AROUND, BACK].concat()),
    ];
    let mut arguments = vec!["contest", "a.txt", "--strategies", "none", "--rules", "uk"];
    home.write("slow.toml", SLOW);
    arguments.extend(["--vehicle", "slow.toml", "--time-limit", "60", "--json"]);
    arguments.extend(mice.iter().flat_map(|mouse| ["--mouse", mouse]));
    let contest = home.run(&arguments).json();
    for (mouse, is_touched, is_touched_early, search_run, search) in [
        ("returns", false, false, 4.0, 6.0),
        // Being carried back takes as long as driving back on the known path.
        ("stops", true, false, 4.0, 8.0),
        ("crashes", true, true, 4.0, 6.0),
        // A reset takes no time.
        ("resets", true, false, 4.0, 4.0),
        ("begins-again", true, true, 5.0, 7.0),
    ] {
        let found = entry(&contest, 0, mouse);
        let [first, second] = [&found["runs"][0], &found["runs"][1]];
        assert_eq!(found["touched"], is_touched, "{mouse}");
        assert_eq!(
            (&first["touched"], &second["touched"]),
            (&json!(is_touched_early), &json!(is_touched))
        );
        assert_close(&first["time_s"], search_run);
        assert_close(&second["start_s"], search);
        let penalty = if is_touched { 3.0 } else { 0.0 };
        let time = second["time_s"].as_f64().unwrap();
        assert_close(&second["score_s"], time + search / 30.0 + penalty);
    }
    let (_, gate_to_gate) = straight();
    assert_close(&entry(&contest, 0, "returns")["runs"][1]["time_s"], gate_to_gate);
    // The first one knows only this path, the second one chooses it for its own fast run.
    for mouse in ["stops", "resets"] {
        let around = entry(&contest, 0, mouse)["runs"][1]["time_s"].as_f64().unwrap();
        assert!(around > 1.5 * gate_to_gate, "{mouse}: {around}");
    }
}

#[test]
fn failures_are_named_and_stop_nothing() {
    let home = Home::new();
    if !works("python3", &["--version"]) {
        return;
    }
    home.write("a.txt", LOOP);
    let late = format!(
        "{}raise SystemExit('too happy')\n",
        "for command in 'moveForward turnRight moveForward moveForward turnRight moveForward'.split():\n    print(command, flush=True)\n    input()\n"
    );
    let mice = [
        script(&home, "fails", "import sys\nsys.exit('a bad day')"),
        script(&home, "late", &late),
        commands(&home, "lost", "moveForward"),
        "missing=no-such-mouse".into(),
    ];
    let mut arguments = vec!["contest", "a.txt", "--strategies", "swing", "--time-limit", "60"];
    arguments.extend(mice.iter().flat_map(|mouse| ["--mouse", mouse]));
    let ended = home.run(&arguments);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    for line in [
        "\nfails made no fast run in 1 maze:\n  a: exited with code 1: a bad day\n",
        "\nlate made no fast run in 1 maze:\n  a: after reaching the goal: exited with code 1: too happy\n",
        "\nlost made no fast run in 1 maze:\n  a: exited without reaching the goal: gave up in (0, 1) at state 1, 3 steps\n    from the goal\n",
        "\nmissing made no fast run in 1 maze:\n  a: cannot start the mouse no-such-mouse: ",
    ] {
        assert!(ended.stdout.contains(line), "{line}: {}", ended.stdout);
    }
    assert!(!ended.stdout.contains("swing made no"), "{}", ended.stdout);
    let contest = home.run(&[&arguments[..], &["--json"]].concat()).json();
    let entries = contest["mazes"][0]["entries"].as_array().unwrap();
    let order: Vec<_> = entries.iter().map(|entry| (&entry["mouse"], &entry["rank"])).collect();
    let expected = [
        (json!("swing"), json!(1)),
        // The search run of this mouse counts.
        (json!("late"), json!(2)),
        (json!("fails"), json!(null)),
        (json!("lost"), json!(null)),
        (json!("missing"), json!(null)),
    ];
    assert!(
        order.into_iter().eq(expected.iter().map(|(mouse, rank)| (mouse, rank))),
        "{entries:?}"
    );
    assert_eq!(entry(&contest, 0, "late")["runs"].as_array().unwrap().len(), 1);
}

#[test]
fn usage_errors_set_exit_code_2() {
    let home = Home::new();
    for (arguments, error) in [
        (&["--rules", "all-japan"][..], "[possible values: best-run, apec, uk]"),
        (&["--contest-time", "0"], "expected a number of seconds greater than 0"),
        (&["--max-runs", "0"], "--max-runs"),
        (&["--vehicle", "exprt"], "did you mean expert?"),
        (&["--strategies", "none"], "no mice: --strategies none requires --mouse"),
        (&["--mouse", "swing=b"], "two mice are called \"swing\""),
    ] {
        let ended = home.run(&[&["contest"], arguments].concat());
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{arguments:?}");
        assert!(ended.stderr.contains(error), "{arguments:?}: {}", ended.stderr);
    }
}
