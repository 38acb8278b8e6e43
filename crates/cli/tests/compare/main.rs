//! `mmsim compare`: comparing mice on collections of mazes.

#[path = "../harness/mod.rs"]
mod harness;

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

/// Returns the tables with a placeholder for each time in the last column of the first one.
fn without_times(tables: &str) -> String {
    let (first, others) = tables.split_once("\n\n").unwrap();
    let (head, rows) = first.split_once('\n').unwrap();
    let width = head.chars().count();
    let timeless = rows.lines().map(|row| {
        let (figures, time) = row.rsplit_once(' ').unwrap();
        assert!(time == "-" || time.parse::<f64>().unwrap() > 0., "{row}");
        format!("\n{:<1$}T", figures.trim_end(), width - 1)
    });
    format!("{head}{}\n\n{others}", timeless.collect::<String>())
}

/// Checks the times in the reports and returns the reports without them.
fn timeless(mut reports: Value) -> Value {
    for report in reports.as_array_mut().unwrap() {
        let report = report.as_object_mut().unwrap();
        let time = report.remove("processor_time_us").unwrap();
        assert!(time.is_null() || time.as_f64().unwrap() > 0.);
        report["statistics"].as_object_mut().unwrap().remove("processor_time_us").unwrap();
        for search in report["mazes"].as_array_mut().unwrap() {
            let time = search.as_object_mut().unwrap().remove("processor_time_us").unwrap();
            assert!(time.as_f64().unwrap() > 0., "{search}");
        }
    }
    reports
}

#[test]
fn every_strategy_has_a_row() {
    let home = Home::new();
    let ended = home.run(&["compare", "--strategies", STRATEGIES]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "no bar where there is no terminal");
    let table = without_times(&ended.stdout);
    insta::assert_snapshot!("bundled", table);
    // docs/compare.md shows the same tables, with the times of one machine.
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/compare.md");
    let page = fs::read_to_string(page).unwrap();
    let words = |line: &str| line.split_whitespace().map(String::from).collect::<Vec<_>>();
    let shown: Vec<_> = page.lines().map(words).collect();
    for row in table.lines().map(words).filter(|row| !row.is_empty()) {
        let figures = row.strip_suffix(&["T".into()]).unwrap_or(&row);
        assert!(shown.iter().any(|line| line.starts_with(figures)), "{row:?}");
    }
    home.write(".mmsim/a.txt", MAZE);
    home.write(".mmsim/closed.txt", CLOSED);
    let ended = home.run(&["compare", "--strategies", STRATEGIES]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    insta::assert_snapshot!(without_times(&ended.stdout));
    let ended = home.run(&["compare", "closed.txt", ".mmsim/closed.txt", "--strategies", "swing"]);
    assert_eq!(ended.code, Some(0), "words find a maze in the home, too: {ended:?}");
    let row: Vec<_> = ended.stdout.lines().nth(1).unwrap().split_whitespace().collect();
    assert_eq!(row, ["swing", "2", "0/0", "2/2", "0", "0", "0", "-"]);
}

#[test]
fn json_has_an_object_for_each_strategy_with_its_searches() {
    let home = Home::new();
    home.write("mazes/a.txt", MAZE);
    home.write("mazes/closed.txt", CLOSED);
    let ended = home.run(&["compare", "mazes", "--strategies", "flood-fill", "--json"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    let mut reports = timeless(ended.json());
    let statistics = reports[0].as_object_mut().unwrap().remove("statistics").unwrap();
    let path = |name: &str| Path::new("mazes").join(name);
    assert_eq!(
        reports,
        json!([{
            "mouse": "flood-fill", "command": null, "reachable": 1, "goal_reached": 1,
            "gave_up_rightly": 1, "failed": 0, "proven": 1, "shortest_path_found": 1,
            "endings": {
                "finished": 1, "gave_up": 1, "failed": 0, "stopped": 0, "time_limit": 0, "step_limit": 0,
                "skipped": 0,
            },
            "steps_to_goal": 3.0, "steps_until_proven": 2.0, "search_steps": 3.0, "search_turns": 1.0,
            "path_found": 3.0, "shortest_path": 3.0, "fast_run_steps": null,
            "mazes": [
                {
                    "path": path("a.txt"), "maze": "a", "width": 4, "height": 2,
                    "goal_reached": true, "steps_to_goal": 3, "steps_until_proven": 2,
                    "search_steps": 3, "search_turns": 1, "path_found": 3, "shortest_path": 3,
                    "visited_cells": 4, "states": 4,
                    "error": null, "ending": "finished", "fast_run_steps": null, "crashes": 0,
                },
                {
                    "path": path("closed.txt"), "maze": "closed", "width": 2, "height": 1,
                    "goal_reached": false, "steps_to_goal": null, "steps_until_proven": null,
                    "search_steps": 0, "search_turns": 0, "path_found": null, "shortest_path": null,
                    "visited_cells": 1, "states": 1,
                    "error": "goal unreachable from (0, 0)", "ending": "gave_up",
                    "fast_run_steps": null, "crashes": 0,
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
    let solvers: Vec<_> = reports.iter().filter(|report| solved(report) > 0).collect();
    let common: Vec<usize> =
        (0..19).filter(|&maze| solvers.iter().all(|one| value(one, maze).is_some())).collect();
    for report in reports {
        let statistics = &report["statistics"][key];
        assert_eq!(statistics["maze_count"], solved(report), "{key}");
        assert_eq!(statistics["common_maze_count"], common.len(), "{key}");
        assert_eq!(statistics["distribution"]["mean"], report[key], "{key}");
        let numbers: Vec<f64> = common.iter().filter_map(|&maze| value(report, maze)).collect();
        let mean = report[key].as_f64().unwrap_or_default();
        let rest: f64 = numbers.iter().map(|number| number - mean).sum();
        assert!(rest.abs() < 1e-6, "{key}: {report}");
        let differences = |maze| Some(value(report, maze)? - value(solvers[0], maze)?);
        let differences: Vec<f64> = (0..19).filter_map(differences).collect();
        if report != solvers[0] && !differences.is_empty() {
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
            searches.iter().filter(|of| of["shortest_path"].is_null() && !of["error"].is_null());
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
                processor_time_us,error,ending,fast_run_steps,crashes";
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
        assert_eq!(row.len(), search.as_object().unwrap().len() + 1);
        assert_eq!(&json!(row["mouse"]), strategy);
        for (key, value) in
            search.as_object().unwrap().iter().filter(|(key, _)| *key != "processor_time_us")
        {
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
    assert_eq!(row[..3], ["swing", "1", "1/1"]);
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
