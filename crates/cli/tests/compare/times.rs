//! The times of searches and fast runs.

use std::collections::BTreeMap;
use std::fs;

use serde_json::{Value, json};

use crate::MAZE;
use crate::harness::Home;
use crate::harness::mice::{AROUND, BACK, LOOP, assert_close, commands, works};

pub(crate) const KEYS: [&str; 6] = [
    "search_time_s",
    "fast_run_time_s",
    "fast_run_loss_percent",
    "total_time_s",
    "known_run_time_s",
    "optimal_time_s",
];

/// Checks the loss of a search against its times, which are rounded to 0.1 ms.
fn assert_loss(search: &Value, time: f64, best: f64) {
    let loss = search["fast_run_loss_percent"].as_f64().unwrap();
    assert!((loss - (time / best - 1.0) * 100.0).abs() < 0.02 / best, "{search}");
}

/// In a straight of 180·n + 90 mm, ukmars accelerates at 3 m/s² and brakes in the second half.
#[test]
fn a_corridor_has_the_times_of_the_formula() {
    let home = Home::new();
    home.write("a.txt", "o---o---o---o---o\n| S           G |\no---o---o---o---o\n");
    let arguments = ["compare", "a.txt", "--strategies", "flood-fill,shortest-path-search"];
    home.write("slow.toml", "base = 'ukmars'\nsearch_speed = 360\nsearch_turn_time = 0.25\n");
    let options = ["--vehicle", "slow.toml", "--json"];
    let reports = home.run(&[&arguments[..], &options].concat()).json();
    let fast_run = 2.0 * (0.63_f64 / 3.0).sqrt();
    // The flood fill stops in the goal and is carried back, with a U-turn at each end.
    let back = 3.0 * 0.5 + 4.0 * 0.25;
    for (mouse, search, back) in [(0, 1.75, back), (1, 6.0 * 0.5 + 3.0 * 0.25, 0.0)] {
        let times = &reports[mouse]["mazes"][0];
        assert_close(&times["search_time_s"], search);
        assert_close(&times["fast_run_time_s"], fast_run);
        assert_close(&times["fast_run_loss_percent"], 0.0);
        assert_close(&times["total_time_s"], search + back + fast_run);
        assert_close(&times["known_run_time_s"], fast_run);
        assert_close(&times["optimal_time_s"], fast_run);
        assert_eq!(reports[mouse]["fastest_run_found"], 1);
        let mean = &reports[mouse]["statistics"]["total_time_s"]["distribution"]["mean"];
        assert_close(mean, search + back + fast_run);
    }
    let difference = &reports[1]["statistics"]["search_time_s"]["difference"];
    assert_close(&difference["mean"], 2.0);
}

#[test]
fn the_times_of_real_searches_agree_with_each_other() {
    let home = Home::new();
    let arguments = ["compare", "--vehicle", "ares"];
    let reports = home.run(&[&arguments[..], &["--json"]].concat()).json();
    let mut losses = 0;
    for report in reports.as_array().unwrap() {
        let mut optimal = 0;
        for search in report["mazes"].as_array().unwrap() {
            let number = |key: &str| search[key].as_f64();
            let steps =
                number("search_steps").unwrap() * 0.36 + number("search_turns").unwrap() * 0.25;
            assert_close(&search["search_time_s"], steps);
            let Some(time) = number("fast_run_time_s") else {
                assert!(search["goal_reached"] == false, "{search}");
                assert!(number("total_time_s").is_none() && number("known_run_time_s").is_none());
                continue;
            };
            let best = number("optimal_time_s").unwrap();
            assert!(time >= best && number("known_run_time_s").unwrap() >= best);
            assert!(time >= number("known_run_time_s").unwrap(), "{search}");
            assert_loss(search, time, best);
            let back = number("total_time_s").unwrap() - steps - time;
            // A strategy with a fast run returns to the start by itself.
            let returns = !search["fast_run_steps"].is_null();
            assert_eq!(returns, back.abs() < 2e-4, "{search}");
            optimal += usize::from(time < best + 1e-4);
            losses += usize::from(time > best * 1.01);
        }
        assert_eq!(report["fastest_run_found"], optimal);
    }
    assert!(losses > 10, "some routes are slower than the fastest run: {losses}");
}

#[test]
fn tables_csv_and_charts_contain_the_times() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    home.write("b.txt", "o---o---o\n| S | G |\no---o---o\n");
    let arguments =
        ["compare", "a.txt", "./b.txt", "--strategies", "swing,flood-fill", "--vehicle", "expert"];
    let run = |options: &[&str]| home.run(&[&arguments[..], options].concat());
    let ended = run(&["--tables", "--charts", "charts", "--html", "report.html"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    for text in [
        "fastest run found",
        "\ntime of the search (s)\nmouse solved mean median difference 95 % interval\n",
        "\ntime of the fast run (s)\n",
        "\nloss of the fast run (%)\n",
        "\nVehicle expert; searches at 600 mm/s and 0.2 s per quarter turn.\n",
    ] {
        let squeezed = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(squeezed(&ended.stdout).contains(&squeezed(text)), "{text}: {}", ended.stdout);
    }
    assert!(home.path().join("charts/fast_run_time_s-distribution.svg").exists());
    let page = fs::read_to_string(home.path().join("report.html")).unwrap();
    assert!(page.contains("Vehicle expert; searches at 600 mm/s"));
    let headings: Vec<_> =
        page.split("<h2>").skip(1).map(|rest| rest.split("</h2>").next()).collect();
    let times = [Some("time until the end of the fast run (s)"), Some("time of the search (s)")];
    assert!(headings.windows(2).any(|two| two == times), "{headings:?}");
    assert!(headings.contains(&Some("steps to the goal")), "{headings:?}");
    let reports = run(&["--json"]).json();
    let csv = run(&["--csv"]).stdout;
    let mut rows = csv::Reader::from_reader(csv.as_bytes());
    let rows: Vec<BTreeMap<String, String>> = rows.deserialize().collect::<Result<_, _>>().unwrap();
    assert_eq!(rows.len(), 4);
    for (index, row) in rows.iter().enumerate() {
        let search = &reports[index / 2]["mazes"][index % 2];
        for key in KEYS {
            let text = search[key].as_f64().map(|number| number.to_string());
            assert_eq!(
                row[key].parse().ok(),
                text.map(|text| text.parse::<f64>().unwrap()),
                "{key}"
            );
        }
    }
}

#[test]
fn each_maze_has_a_default_vehicle() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    home.write(
        "large.txt",
        format!(
            "{}o\n|{} G|\n{}o\n",
            "o---".repeat(17),
            " S  ".to_string() + &"    ".repeat(15) + " ",
            "o---".repeat(17)
        ),
    );
    let run = |maze: &str, options: &[&str]| {
        let ended = home.run(&[&["compare", maze, "--strategies", "swing"], options].concat());
        assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
        ended
    };
    for (maze, vehicle) in [("a.txt", "expert"), ("./large.txt", "kerise")] {
        let default = run(maze, &["--json"]).json();
        let given = run(maze, &["--json", "--vehicle", vehicle]).json();
        for key in KEYS {
            assert!(default[0]["mazes"][0][key].is_number(), "{default}");
            assert_eq!(default[0]["mazes"][0][key], given[0]["mazes"][0][key], "{key}");
        }
        assert!(run(maze, &[]).stdout.contains(&format!("Vehicle {vehicle}; searches at ")));
    }
}

#[test]
fn a_mouse_of_the_user_drives_its_own_fast_run() {
    let home = Home::new();
    if !works("python3", &["--version"]) {
        return;
    }
    home.write("a.txt", LOOP);
    let stops = commands(&home, "stops", &[AROUND, BACK].concat());
    let around = commands(&home, "around", &[AROUND, BACK, AROUND].concat());
    let mut arguments = vec!["compare", "a.txt", "--strategies", "shortest-path-search"];
    arguments.extend(["--vehicle", "expert", "--time-limit", "60", "--json"]);
    arguments.extend([&stops, &around].iter().flat_map(|mouse| ["--mouse", mouse]));
    let reports = home.run(&arguments).json();
    let [stops, around, bundled] = [0, 1, 2].map(|mouse| &reports[mouse]["mazes"][0]);
    // 450 mm with 17 m/s² and 2.5 m/s.
    let straight = 5.0 / 17.0 + (0.45 - 6.25 / 17.0) / 2.5;
    assert_close(&bundled["fast_run_time_s"], straight);
    // This mouse makes no fast run, but knows both paths.
    assert_close(&stops["fast_run_time_s"], straight);
    assert_eq!(stops["search_steps"], 6);
    let time = around["fast_run_time_s"].as_f64().unwrap();
    assert!(time > 1.5 * straight, "{around}");
    assert_close(&around["known_run_time_s"], straight);
    let best = around["optimal_time_s"].as_f64().unwrap();
    assert_loss(around, time, best);
    assert_eq!(around["search_time_s"], json!(6.0 * 0.3 + 3.0 * 0.2));
}

#[test]
fn wrong_vehicles_are_usage_errors() {
    let home = Home::new();
    home.write("wrong.toml", "base = 'expert'\nspeed = 5\n");
    for (arguments, error) in [
        (&["--vehicle", "exprt"][..], "did you mean expert?"),
        (&["--vehicle", "wrong.toml"], "line 2"),
        (&["--vehicle", "none.toml"], "cannot read the file"),
    ] {
        let ended = home.run(&[&["compare"], arguments].concat());
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{arguments:?}");
        assert!(ended.stderr.contains(error), "{arguments:?}: {}", ended.stderr);
    }
}
