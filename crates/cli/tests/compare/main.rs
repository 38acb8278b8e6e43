//! `mmsim compare`: comparing mice on collections of mazes.

#[path = "../harness/mod.rs"]
mod harness;

mod baseline;
mod own_mice;
mod report;
mod times;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use harness::Home;
use serde_json::{Value, json};

const MAZE: &str = "\
o---o---o---o---o
|         G |   |
o   o---o---o   o
| S |           |
o---o---o---o---o
";
const CLOSED: &str = "o---o---o\n| S | G |\no---o---o\n";

/// The strategies whose results are in the snapshots.
const STRATEGIES: &str =
    "flood-fill,weight-increment,left-wall,swing,shortest-path-search,fastest-path-search";

/// Returns the tables after the verdict, except that of processor times, which it checks.
fn without_times(text: &str) -> String {
    let is_timed = |section: &&str| section.starts_with("processor time");
    let (timed, others): (Vec<&str>, Vec<&str>) = text.split("\n\n").skip(2).partition(is_timed);
    assert_eq!(timed.len(), 1, "{text}");
    for row in timed[0].lines().skip(2).take_while(|line| !line.starts_with("Means")) {
        let time = row.split_whitespace().nth(2).unwrap();
        assert!(time.parse::<f64>().unwrap() > 0., "{row}");
    }
    others.join("\n\n")
}

/// Checks the times in the reports and returns the reports without them.
fn timeless(mut reports: Value) -> Value {
    for report in reports.as_array_mut().unwrap() {
        let report = report.as_object_mut().unwrap();
        let statistics = report["statistics"].as_object_mut().unwrap();
        let times = statistics.remove("processor_time_us").unwrap();
        let times = &times["distribution"];
        assert!(times.is_null() || times["mean"].as_f64().unwrap() > 0.);
        for search in report["mazes"].as_array_mut().unwrap() {
            let time = search.as_object_mut().unwrap().remove("processor_time_us").unwrap();
            assert!(time.as_f64().unwrap() > 0., "{search}");
        }
    }
    reports
}

#[test]
fn the_first_screen_is_the_verdict() {
    let home = Home::new();
    let ended = home.run(&["compare", "--strategies", STRATEGIES]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "no bar where there is no terminal");
    insta::assert_snapshot!("bundled", ended.stdout);
    assert!(ended.stdout.lines().count() <= 47, "{}", ended.stdout);
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/compare.md");
    assert!(fs::read_to_string(page).unwrap().contains(&ended.stdout), "docs/compare.md");
}

#[test]
fn tables_contain_every_strategy() {
    let home = Home::new();
    home.write(".mmsim/a.txt", MAZE);
    home.write(".mmsim/closed.txt", CLOSED);
    let ended = home.run(&["compare", "--strategies", "flood-fill,swing", "--tables"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    insta::assert_snapshot!("tables", without_times(&ended.stdout));
    let closed = ["compare", "closed.txt", ".mmsim/closed.txt", "--strategies", "swing"];
    let ended = home.run(&[&closed[..], &["--tables"]].concat());
    assert_eq!(ended.code, Some(0), "words find a maze in the home, too: {ended:?}");
    let row = ended.stdout.lines().find(|line| line.starts_with("swing  ")).unwrap();
    let row: Vec<_> = row.split_whitespace().collect();
    assert_eq!(row[..5], ["swing", "2", "0/0", "2/2", "0"]);
}

/// Wall followers solve few mazes. The ranks, losses and worst mazes of the others stay the same.
#[test]
fn a_wall_follower_changes_nothing_for_the_others() {
    let home = Home::new();
    let reports = |strategies: &str| {
        let ended = home.run(&["compare", "--strategies", strategies, "--json"]);
        ended.json().as_array().unwrap().clone()
    };
    let (with, without) = (reports("left-wall,flood-fill,swing"), reports("flood-fill,swing"));
    for (with, without) in with[1..].iter().zip(&without) {
        for key in ["rank", "solved", "mean_loss", "paired_maze_count", "worst_mazes", "reasons"] {
            assert_eq!(with[key], without[key], "{key}");
        }
        assert_eq!((&with["solved"], &with["reachable"]), (&json!(18), &json!(18)));
    }
    let follower = &with[0];
    let unsolved: Vec<_> = follower["unsolved_mazes"].as_array().unwrap().iter().collect();
    assert_eq!((follower["rank"].as_u64(), follower["solved"].as_u64()), (Some(3), Some(3)));
    assert_eq!((unsolved.len(), &unsolved[0]["maze"]), (15, &json!("01-harbour")));
    assert_eq!(unsolved[0]["error"], "loops over 139 cells, (0, 1) to (13, 8), since state 1");
    assert_eq!(follower["reasons"][0], "not_solved");
}

#[test]
fn json_has_an_object_for_each_strategy_with_its_searches() {
    let home = Home::new();
    home.write("mazes/a.txt", MAZE);
    home.write("mazes/closed.txt", CLOSED);
    let ended = home.run(&["compare", "mazes", "--strategies", "flood-fill", "--json"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    let mut reports = timeless(ended.json());
    for key in times::KEYS {
        for search in reports[0]["mazes"].as_array_mut().unwrap() {
            search.as_object_mut().unwrap().remove(key).expect(key);
        }
    }
    let statistics = reports[0].as_object_mut().unwrap().remove("statistics").unwrap();
    let ranking = json!({
        "rank": 1, "solved": 1, "reachable": 1, "paired_maze_count": 1,
        "mean_loss": { "loss_s": 0.0, "search_loss_s": 0.0, "route_loss_s": 0.0 },
        "reasons": [], "crashes": 0, "not_proven": 0, "worst_mazes": [], "unsolved_mazes": [],
    });
    for (key, value) in ranking.as_object().unwrap() {
        assert_eq!(reports[0].as_object_mut().unwrap().remove(key).as_ref(), Some(value), "{key}");
    }
    let path = |name: &str| Path::new("mazes").join(name);
    assert_eq!(
        reports,
        json!([{
            "mouse": "flood-fill", "command": null, "goal_reached": 1, "fastest_run_found": 1,
            "gave_up_rightly": 1, "failed": 0, "proven": 1, "shortest_path_found": 1,
            "endings": {
                "finished": 1, "gave_up": 1, "failed": 0, "stopped": 0, "time_limit": 0, "step_limit": 0,
                "skipped": 0,
            },
            "mazes": [
                {
                    "path": path("a.txt"), "maze": "a", "width": 4, "height": 2,
                    "goal_reached": true, "steps_to_goal": 3, "steps_until_proven": 2,
                    "search_steps": 3, "search_turns": 1, "path_found": 3, "shortest_path": 3,
                    "visited_cells": 4, "states": 4,
                    "error": null, "ending": "finished", "fast_run_steps": null, "crashes": 0,
                    "cause": null, "random": null,
                },
                {
                    "path": path("closed.txt"), "maze": "closed", "width": 2, "height": 1,
                    "goal_reached": false, "steps_to_goal": null, "steps_until_proven": null,
                    "search_steps": 0, "search_turns": 0, "path_found": null, "shortest_path": null,
                    "visited_cells": 1, "states": 1,
                    "error": "goal unreachable from (0, 0)", "ending": "gave_up",
                    "fast_run_steps": null, "crashes": 0,
                    "cause": null, "random": null,
                },
            ],
        }])
    );
    assert_eq!(
        statistics["search_turns"],
        json!({
            "maze_count": 1, "common_maze_count": 1, "difference": null,
            "distribution": {
                "mean": 1.0, "median": 1.0, "lower_quartile": 1.0, "upper_quartile": 1.0,
                "standard_deviation": null, "minimum": 1.0, "maximum": 1.0,
            },
        })
    );
}

/// Checks the statistics of one measure against the searches.
fn check_statistics(reports: &[Value], key: &str) {
    let value = |report: &Value, maze: usize| {
        let search = &report["mazes"][maze];
        search[key].as_f64().filter(|_| search["goal_reached"] == true)
    };
    let solved = |report: &Value| (0..19).filter(|&maze| value(report, maze).is_some()).count();
    let most = reports.iter().map(solved).max().unwrap();
    let is_compared = |report: &&Value| solved(report) > 0 && 2 * solved(report) >= most;
    let first = reports.iter().find(|report| solved(report) > 0).unwrap();
    let solvers: Vec<_> = reports.iter().filter(is_compared).collect();
    let common: Vec<usize> =
        (0..19).filter(|&maze| solvers.iter().all(|one| value(one, maze).is_some())).collect();
    for report in reports {
        let statistics = &report["statistics"][key];
        assert_eq!(statistics["maze_count"], solved(report), "{key}");
        assert_eq!(statistics["common_maze_count"], common.len(), "{key}");
        let mean = &statistics["distribution"]["mean"];
        let numbers = common.iter().filter(|_| is_compared(&report));
        let numbers: Vec<f64> = numbers.filter_map(|&maze| value(report, maze)).collect();
        assert_eq!(mean.is_null(), numbers.is_empty(), "{key}");
        let mean = mean.as_f64().unwrap_or_default();
        let rest: f64 = numbers.iter().map(|number| number - mean).sum();
        assert!(rest.abs() < 1e-6, "{key}: {report}");
        let differences = |maze| Some(value(report, maze)? - value(first, maze)?);
        let differences: Vec<f64> = (0..19).filter_map(differences).collect();
        if report != first && !differences.is_empty() {
            let difference = &statistics["difference"];
            assert_eq!(difference["maze_count"], differences.len(), "{key}");
            let count = |is: fn(&&f64) -> bool| differences.iter().filter(is).count();
            assert_eq!(difference["better"], count(|number| **number < 0.), "{key}");
            assert_eq!(difference["worse"], count(|number| **number > 0.), "{key}");
        }
    }
}

#[test]
fn statistics_compare_the_same_mazes() {
    let home = Home::new();
    let reports = home.run(&["compare", "--json"]).json();
    let reports = reports.as_array().unwrap();
    let names: Vec<_> = reports.iter().map(|report| &report["mouse"]).collect();
    assert!(names.len() >= 4 && names.contains(&&json!("weight-increment")), "{names:?}");
    for key in [
        "total_time_s",
        "steps_to_goal",
        "steps_until_proven",
        "search_steps",
        "search_turns",
        "path_found",
        "fast_run_steps",
        "processor_time_us",
    ] {
        check_statistics(reports, key);
    }
    for report in reports {
        let searches = report["mazes"].as_array().unwrap();
        let reached: Vec<_> = searches.iter().filter(|of| of["goal_reached"] == true).collect();
        assert_eq!((searches.len(), &report["reachable"]), (19, &json!(18)));
        assert_eq!(report["goal_reached"], reached.len());
        let found = reached.iter().filter(|of| of["path_found"] == of["shortest_path"]).count();
        assert_eq!(report["shortest_path_found"], found);
        let given_up =
            searches.iter().filter(|of| of["shortest_path"].is_null() && of["ending"] == "gave_up");
        assert_eq!(report["gave_up_rightly"], given_up.count());
        let endings = report["endings"].as_object().unwrap();
        assert_eq!(endings.values().filter_map(Value::as_u64).sum::<u64>(), 19);
    }
}

#[test]
fn csv_has_a_line_for_each_search() {
    let home = Home::new();
    home.write("mazes/a, \"b\".txt", MAZE);
    home.write("mazes/closed.txt", CLOSED);
    let arguments = ["compare", "mazes", "--strategies", "flood-fill,left-wall"];
    let ended = home.run(&[&arguments[..], &["--csv"]].concat());
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    let lines: Vec<_> = ended.stdout.lines().collect();
    let head = "mouse,path,maze,width,height,goal_reached,steps_to_goal,steps_until_proven,\
                search_steps,search_turns,path_found,shortest_path,visited_cells,states,\
                processor_time_us,error,ending,fast_run_steps,crashes,search_time_s,fast_run_time_s,\
                fast_run_loss_percent,total_time_s,known_run_time_s,optimal_time_s";
    assert_eq!((lines[0], lines.len()), (head, 5));
    let quoted = lines[1].replace('\\', "/");
    assert!(
        quoted.starts_with(r#"flood-fill,"mazes/a, ""b"".txt","a, ""b""",4,2,true,3,2,3,1,3,3,"#),
        "{quoted}"
    );
    // The columns match the JSON.
    let reports = home.run(&[&arguments[..], &["--json"]].concat()).json();
    let mut rows = csv::Reader::from_reader(ended.stdout.as_bytes());
    let rows: Vec<BTreeMap<String, String>> = rows.deserialize().collect::<Result<_, _>>().unwrap();
    let searches = reports.as_array().unwrap().iter().flat_map(|report| {
        let of = |search| (&report["mouse"], search);
        report["mazes"].as_array().unwrap().iter().map(of)
    });
    for (row, (strategy, search)) in rows.iter().zip(searches) {
        // CSV has the name of the mouse, and no objects.
        let search: BTreeMap<&String, &Value> = search
            .as_object()
            .unwrap()
            .iter()
            .filter(|(key, _)| !["cause", "random"].contains(&&***key))
            .collect();
        assert_eq!(row.len(), search.len() + 1);
        assert_eq!(&json!(row["mouse"]), strategy);
        for (key, value) in search.into_iter().filter(|(key, _)| *key != "processor_time_us") {
            let text = match value {
                Value::Null => String::new(),
                Value::String(text) => text.clone(),
                other => other.to_string(),
            };
            assert_eq!(row[key], text, "{key}");
        }
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let home = Home::new();
    let reports = |arguments: &[&str]| {
        timeless(home.run(&[&["compare", "--json"], arguments].concat()).json())
    };
    let alone = reports(&["--jobs", "1"]);
    assert_eq!(reports(&["--jobs", "7"]), alone);
    assert_eq!(reports(&["--jobs", "65535"]), alone);
    assert_eq!(reports(&[]), alone);
}

#[test]
fn strategies_run_once_and_in_the_given_order() {
    let home = Home::new();
    let names = |arguments: &[&str]| {
        let ended = home.run(&[&["compare", "first steps", "--json"], arguments].concat()).json();
        let reports = ended.as_array().unwrap().iter();
        reports.map(|report| report["mouse"].as_str().unwrap().to_string()).collect::<Vec<_>>()
    };
    let swing_first = ["--strategies", "swing,left-wall", "--strategies", "swing"];
    assert_eq!(names(&swing_first), ["swing", "left-wall"]);
    let all = names(&[]);
    assert_eq!(names(&["--strategies", "all,swing"]), all);
    assert_eq!(names(&["--strategies", "swing,all"]).len(), all.len());
}

#[test]
fn reports_unreadable_mazes_and_compares_the_others() {
    let home = Home::new();
    home.write("mazes/a.txt", "o---o\n| S \no---o\n");
    home.write("mazes/b.txt", MAZE);
    let ended = home.run(&["compare", "mazes", "no such", "--strategies", "swing"]);
    assert_eq!(ended.code, Some(1), "{ended:?}");
    let row: Vec<_> = ended.stdout.lines().nth(1).unwrap().split_whitespace().collect();
    assert_eq!(row[..3], ["1", "swing", "1/1"]);
    let messages: Vec<_> = ended.stderr.lines().collect();
    assert!(
        messages[0]
            .replace('\\', "/")
            .starts_with("mmsim: mazes/a.txt: line 2, column 5: expected ")
    );
    assert!(messages[1].contains("matches \"no such\""), "{messages:?}");
    assert_eq!(messages.len(), 2);
    let ended = home.run(&["compare", "mazes/a.txt"]);
    assert_eq!((ended.code, &ended.stdout[..]), (Some(1), ""), "no table without a maze");
    let ended = home.run(&["compare", "mazes/a.txt", "--json", "--strategies", "swing"]);
    assert_eq!((ended.code, &ended.json()[0]["mazes"]), (Some(1), &json!([])));
}

#[test]
fn usage_errors_set_exit_code_2() {
    let home = Home::new();
    let all = "[possible values: flood-fill, weight-increment, left-wall, swing";
    for (arguments, error) in [
        (&["--strategies", "swing,floodfill"][..], all),
        (&["--strategies", ""], all),
        (&["--strategies", "swing,"], all),
        (&["--jobs", "0"], "--jobs"),
        (&["--jobs", "many"], "--jobs"),
        (&["--csv", "--json"], "cannot be used with"),
    ] {
        let ended = home.run(&[&["compare"], arguments].concat());
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{arguments:?}");
        assert!(ended.stderr.contains(error), "{arguments:?}: {}", ended.stderr);
    }
}
