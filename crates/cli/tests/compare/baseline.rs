//! Comparisons with a saved one.

use std::fs;

use serde_json::{Value, json};

use crate::harness::Home;

const COMPARE: [&str; 4] = ["compare", "two roads", "--strategies", "flood-fill,swing"];

#[test]
fn a_saved_comparison_shows_what_has_become_worse() {
    let home = Home::new();
    let run = |arguments: &[&str]| home.run(&[&COMPARE[..], arguments].concat());
    let saved = run(&["--save", "base.json"]);
    assert_eq!((saved.code, &saved.stderr[..]), (Some(0), ""));
    let file = home.path().join("base.json");
    let read = || -> Value { serde_json::from_slice(&fs::read(&file).unwrap()).unwrap() };
    let mut reports = run(&["--json"]).json();
    let mut base = read();
    for report in [&mut reports, &mut base].into_iter().flat_map(|it| it.as_array_mut().unwrap()) {
        report["statistics"]["processor_time_us"] = Value::Null;
        report["mazes"][0]["processor_time_us"] = Value::Null;
    }
    assert_eq!(reports, base, "the file has what --json prints");

    let same = run(&["--against", "base.json"]);
    assert_eq!((same.code, &same.stderr[..]), (Some(0), ""));
    assert!(same.stdout.contains("\nflood-fill against base.json: 0 worse, 0 better, 1 equal\n"));

    // The saved flood-fill was 10 % faster, and the saved swing did not solve the maze.
    let mut base = read();
    let time = base[0]["mazes"][0]["total_time_s"].as_f64().unwrap();
    base[0]["mazes"][0]["total_time_s"] = json!(time / 1.1);
    base[1]["mazes"][0]["total_time_s"] = Value::Null;
    home.write("base.json", base.to_string());
    let worse = run(&["--against", "base.json"]);
    assert_eq!(worse.code, Some(1));
    let lines: Vec<_> =
        worse.stdout.lines().filter(|line| line.contains("10-two-roads: ")).collect();
    assert_eq!(lines.len(), 2, "{}", worse.stdout);
    assert!(lines[0].starts_with("  worse: 10-two-roads: ") && lines[0].ends_with(" (+10.0 %)"));
    assert!(lines[1].starts_with("  better: 10-two-roads: solved in "), "{}", lines[1]);
    assert_eq!(run(&["--against", "base.json", "--allow", "11%"]).code, Some(0));
    assert_eq!(run(&["--against", "base.json", "--allow", "9%"]).code, Some(1));
    let report = run(&["--against", "base.json", "--json"]);
    assert_eq!(report.code, Some(1));
    let changes = &report.json()[0]["changes"];
    assert_eq!(changes["worse_mazes"][0]["maze"], "10-two-roads");
    assert_eq!((&changes["equal"], &changes["new_maze_count"]), (&json!(0), &json!(0)));
}

/// A comparison of nothing would pass whatever the mouse does.
#[test]
fn other_mazes_and_vehicles_cannot_be_compared() {
    let home = Home::new();
    let maze = "o---o---o\n| S   G |\no---o---o\n";
    for name in ["mazes/a.txt", "mazes/b.txt", "c.txt"] {
        home.write(name, maze);
    }
    let run = |arguments: &[&str]| {
        home.run(&[&["compare", "--strategies", "flood-fill"], arguments].concat())
    };
    assert_eq!(run(&["mazes", "--save", "base.json"]).code, Some(0));
    let same = run(&["./mazes", "--against", "base.json"]);
    assert_eq!((same.code, &same.stderr[..]), (Some(0), ""));
    let fails = |arguments: &[&str], error: &str| {
        let ended = run(&[arguments, &["--against", "base.json"]].concat());
        assert_eq!(ended.code, Some(1), "{ended:?}");
        assert!(ended.stderr.contains(error), "{error}: {ended:?}");
    };
    fails(&["c.txt"], "base.json has none of the mazes of flood-fill\n");
    fails(&["mazes/a.txt"], "flood-fill has not searched 1 maze of base.json\n");
    fails(&["mazes", "--vehicle", "ares"], "a.txt has changed, or was saved with another vehicle");
    // Nothing is saved of mazes that could not be read.
    home.write("mazes/a.txt", maze.replace("G |", "G"));
    let before = fs::read(home.path().join("base.json")).unwrap();
    let ended = run(&["mazes", "--save", "base.json"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.contains("base.json was not written, because a maze could not be read"));
    assert_eq!(fs::read(home.path().join("base.json")).unwrap(), before);
}

#[test]
fn a_file_that_was_not_saved_is_an_error() {
    let home = Home::new();
    home.write("other.json", "[{\"mouse\": \"mine\", \"mazes\": []}]");
    home.write("no.json", "{\"mouse\": 3}");
    for (file, error) in [
        ("missing.json", "mmsim: cannot read missing.json: "),
        ("no.json", "mmsim: no.json: expected the JSON that `mmsim compare --save` writes: "),
        ("other.json", "other.json has no mouse called flood-fill, but mine\n"),
    ] {
        let ended = home.run(&[&COMPARE[..], &["--against", file]].concat());
        assert_eq!(ended.code, Some(1), "{ended:?}");
        assert!(ended.stderr.starts_with(error), "{ended:?}");
    }
}
