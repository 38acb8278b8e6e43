//! A mouse that drives slalom turns, from the documentation.

use mmsim_fastrun::{FastRun, Planner, Vehicle};
use mmsim_maze::Maze;

use super::*;

/// A maze with one path from the start to the goal, and dead ends.
const PATH: &str = "\
o---o---o---o---o---o
|           |     G |
o   o---o   o   o---o
|   |       |       |
o   o   o---o---o   o
|   |   |           |
o   o   o   o---o---o
| S |               |
o---o---o---o---o---o
";

/// Returns the mouse in docs/mms.md.
fn documented_mouse() -> String {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/mms.md");
    let page = fs::read_to_string(page).unwrap();
    let (_, mouse) = page.split_once("```python\n").unwrap();
    mouse.split_once("```\n").unwrap().0.to_string()
}

#[test]
fn the_documented_mouse_needs_the_time_of_the_model() {
    let home = Home::new();
    let maze: Maze = PATH.parse().unwrap();
    home.write("path.txt", PATH);
    let mouse = documented_mouse();
    assert!(mouse.lines().count() <= 60);
    let Some(python) = python() else { return };
    home.write("mouse.py", mouse);
    for name in ["ukmars", "expert"] {
        let options = [
            "--maze",
            "path.txt",
            "--json",
            "--vehicle",
            name,
            "--port",
            "0",
            "--viewer-port",
            "0",
        ];
        let ended = home.run(&arguments(&options, &[python, "mouse.py"]));
        assert_eq!(ended.code, Some(0), "{ended:?}");
        let report = ended.json();
        let (run, time) = (&report["moves"], report["fast_run_time_s"].as_f64().unwrap());
        let vehicle = Vehicle::preset(name).unwrap();
        let driven = FastRun::parse(maze.start().cell, run.as_str().unwrap()).unwrap();
        assert!(driven.is_possible(maze.walls(), maze.goals()) && driven.turns().len() > 2);
        assert!((driven.time(&vehicle).unwrap() - time).abs() < 1e-4, "{report}");
        assert!(ended.stderr.contains(&format!("mms: fast run in {time:.4} s with {name}\n")));
        // With small turns only, there is no faster run in this maze.
        let mut planner = Planner::new(vehicle.clone());
        let fastest = planner.plan(maze.walls(), maze.start().cell, maze.goals()).unwrap();
        let difference = time - fastest.time(&vehicle).unwrap();
        assert!(difference > -1e-4 && (name != "ukmars" || difference < 1e-4), "{report}");
        let verdict = (&report["goal_reached"], &report["ending"], &report["crashes"]);
        assert_eq!(verdict, (&json!(true), &json!("finished"), &json!(0)), "{report}");
        let mouse = format!("mouse={python} mouse.py");
        let options = ["path.txt", "--strategies", "none", "--json", "--vehicle", name];
        let compared =
            home.run(&[&["compare"], &options[..], &["--mouse", &mouse]].concat()).json();
        let found = &compared[0]["mazes"][0];
        assert_eq!(found["fast_run_time_s"], report["fast_run_time_s"], "{found}");
    }
}

#[test]
fn a_run_with_a_turn_in_place_has_no_time() {
    let home = Home::new();
    home.write("small.txt", SMALL);
    let mouse = "ask('moveForward 2'), ask('turnRight'), ask('moveForward 3')";
    let Some(ended) = run(&home, &["--maze", "small.txt", "--json"], mouse) else { return };
    let report = ended.json();
    assert_eq!((&report["goal_reached"], &report["moves"]), (&json!(true), &json!(null)));
    assert_eq!(report["fast_run_time_s"], json!(null));
    let mouse = "ask('moveForwardHalf 3'), ask('slalomRight s90'), ask('moveForward 2'), \
                 ask('moveForwardHalf'), ask('moveForwardHalf 2')";
    let ended = run(&home, &["--maze", "small.txt", "--json"], mouse).unwrap();
    assert!(ended.json()["moves"].is_string(), "{ended:?}");
}

#[test]
fn a_run_that_is_too_long_for_the_log_is_timed() {
    let home = Home::new();
    let open = "o---o---o---o\n|           |\no   o   o   o\n| S       G |\no---o---o---o\n";
    home.write("open.txt", open);
    let turn = "ask('slalomRight s90')";
    let mouse = |circles: u32| {
        format!(
            "ask('moveForwardHalf 1'), [{turn} for _ in range({})], \
             ask('moveForwardHalf 2'), {turn}, ask('moveForwardHalf 1')",
            4 * circles + 1
        )
    };
    let read = |circles, folder: &str| {
        let options = ["--maze", "open.txt", "--json", "--record", folder];
        let ended = run(&home, &options, &mouse(circles))?;
        assert_eq!(ended.code, Some(0), "{ended:?}");
        assert!(ended.json()["moves"].is_string(), "{ended:?}");
        let recording = recording(&home.path().join(folder));
        let lines = recording.log();
        let is_logged = lines.iter().any(|line| line.text.starts_with(mmsim_run::DRIVEN_RUN));
        let message = "mms: the page cannot play the fast run of 202 turns\n";
        Some((is_logged, ended.stderr.contains(message)))
    };
    let Some(short) = read(2, "short") else { return };
    assert_eq!(short, (true, false));
    assert_eq!(read(50, "long"), Some((false, true)));
}
