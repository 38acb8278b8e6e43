//! `mmsim trial`: robots in the two-run trial.

mod harness;

use std::path::Path;
use std::process::Stdio;

use harness::{Home, Output};
use mmsim_tests::{ask, connect_to, wait_with_output};
use serde_json::{Value, json};

const MAZE: &str = "\
o---o---o---o---o
|         G |   |
o   o---o---o   o
| S |           |
o---o---o---o---o
";
const CLOSED: &str = "o---o---o\n| S | G |\no---o---o\n";

/// Runs the trial with the random robot, which is fast enough in small mazes.
fn random(home: &Home, arguments: &[&str]) -> Output {
    home.run(&[&["trial", "--robot", "random"], arguments].concat())
}

#[test]
fn prints_a_line_per_trial_and_a_summary_per_robot() {
    let home = Home::new();
    home.write("mazes/a.txt", MAZE);
    home.write("mazes/b/closed.txt", CLOSED);
    home.write("mazes/c.txt", MAZE);
    let ended = random(&home, &["mazes"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(1), ""), "too long in the closed one");
    insta::assert_snapshot!(ended.stdout.replace('\\', "/"), @"
    maze
      robot   explore  race    score  optimum  race excess  score excess
    mazes/a.txt
      random        4     3    3.133        2            1         1.033
    mazes/b/closed.txt
      random     1000     0  out of time, goal unreachable
    mazes/c.txt
      random        4     3    3.133        2            1         1.033
    random: 2 of 3 trials scored; means: 4.0 explore steps, 3.0 race steps, score
      3.133, score excess 1.033
    ");
    let ended = random(&home, &["mazes/a.txt"]);
    assert_eq!((ended.code, ended.stdout.lines().count()), (Some(0), 2), "{ended:?}");
    assert_eq!(random(&home, &["mazes/a.txt"]).stdout, ended.stdout, "the same seed");
    assert_ne!(random(&home, &["mazes/a.txt", "--seed", "7"]).stdout, ended.stdout);
    let [noisy, percent] =
        ["0.5", "50%"].map(|noise| random(&home, &["mazes/a.txt", "--noise", noise]));
    assert_ne!(noisy.code, Some(2), "{noisy:?}");
    assert_eq!(noisy.stdout, percent.stdout);
}

#[test]
fn json_has_an_object_for_each_trial() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    home.write("closed.txt", CLOSED);
    let ended = random(&home, &["closed.txt", "a.txt", "--json", "--seed", "3"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(1), ""));
    let report = ended.json();
    assert_eq!(
        report[0],
        json!({
            "path": "closed.txt", "maze": "closed", "mouse": "random", "ending": "out_of_time", "score": null,
            "explore_steps": 1000, "race_steps": 0, "race_optimum": null, "seed": 3, "noise": 0.0,
        })
    );
    let steps = |name: &str| report[1][name].as_f64().unwrap();
    let score = steps("race_steps") + steps("explore_steps") / 30.;
    assert_eq!(report[1]["score"], json!((score * 1000.).round() / 1000.), "{report}");
    assert_eq!((&report[1]["race_optimum"], &report[1]["ending"]), (&json!(2), &json!("scored")));
    assert_eq!(report.as_array().unwrap().len(), 2);
    let path = random(&home, &["a.txt", "--json", "--path"]).json();
    assert!(path[0]["drawing"].as_str().unwrap().starts_with("o---o"), "{path}");
    // Without trials, the output is still an array.
    let ended = random(&home, &["no such", "--json"]);
    assert_eq!((ended.code, ended.json()), (Some(1), json!([])));
}

#[test]
fn path_draws_the_race_in_the_explored_maze() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    insta::assert_snapshot!(random(&home, &["a.txt", "--path"]).stdout, @"
    a.txt, random
    o---o---o---o---o
    | R   R   X |   |
    o   o---o---o . o
    | U |   .   .   |
    o---o---o---o---o

    maze   robot   explore  race    score  optimum  race excess  score excess
    a.txt  random        4     3    3.133        2            1         1.033
    ");
}

#[test]
fn swing_as_published_may_crash() {
    let home = Home::new();
    let trial = ["trial", "wrong turn", "--robot", "swing", "--as-published", "--json"];
    let report = home.run(&trial).json();
    assert_eq!(
        (&report[0]["mouse"], &report[0]["score"]),
        (&json!("swing-as-published"), &json!(28.6))
    );
    home.write("closed.txt", CLOSED);
    let trial = ["trial", "closed.txt", "--robot", "swing", "--as-published"];
    let ended = home.run(&trial);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(1), ""));
    insta::assert_snapshot!(ended.stdout, @"
    maze
      robot               explore  race    score  optimum  race excess  score excess
    closed.txt
      swing-as-published        1     0  step 1: no path to (0, 0), so the published
        robot crashes
    ");
}

/// Returns the picture that a trial in the maze `wrong turn` draws.
fn picture(home: &Home, arguments: &[&str]) -> String {
    let ended = home.run(&[&["trial", "wrong turn"], arguments].concat());
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    std::fs::read_to_string(home.path().join("out.svg")).unwrap()
}

#[test]
fn pictures_show_the_paths_of_both_runs_and_the_tour() {
    let home = Home::new();
    let lines = |svg: &str| {
        let paths = svg.split("class=\"driven-paths\"").nth(1).unwrap();
        let paths = paths.split("<path stroke=").skip(1).take_while(|path| path.contains(" d=\"M"));
        let paths = paths.map(|path| path.split('"').nth(3).unwrap().to_string());
        paths.filter(|path| path.contains('L')).collect::<Vec<_>>()
    };
    let swing = ["--robot", "swing", "--as-published"];
    let svg = picture(&home, &[&swing[..], &["-o", "out.svg"]].concat());
    let [explore, race] = &lines(&svg)[..] else { panic!("{svg}") };
    // Both runs begin at the start, and no line leads back to it: all lines are one cell long.
    for path in [explore, race] {
        let points: Vec<(f64, f64)> = path[1..]
            .split('L')
            .map(|point| point.split_once(' ').unwrap())
            .map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap()))
            .collect();
        assert_eq!(points[0], (10.0, 230.0), "{path}");
        for pair in points.windows(2) {
            let (east, north) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
            assert!((east.abs() + north.abs() - 20.0).abs() < 1e-9, "{pair:?}");
        }
    }
    assert!(explore.len() > 5 * race.len());
    let several = ["--robot", "count-expansion", "--robot", "champion", "-o", "out.svg"];
    assert_eq!(lines(&picture(&home, &several)).len(), 2);
    let tour = picture(&home, &[&swing[..], &["--tour", "out.svg", "--theme", "dark"]].concat());
    assert_eq!(lines(&tour).len(), 1);
    let failing = ["trial", "closed garden", "--robot", "swing", "-o", "out.png"];
    assert_eq!(home.run(&failing).code, Some(0));
    let png = std::fs::read(home.path().join("out.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
}

#[test]
fn words_select_a_maze() {
    let home = Home::new();
    let maze = |arguments: &[&str]| {
        let report: Value = random(&home, &[&["--json"], arguments].concat()).json();
        report[0]["path"].as_str().unwrap_or_default().to_string()
    };
    assert_eq!(maze(&["first steps"]), "training-first-steps.txt");
    home.write(".mmsim/own-steps.txt", MAZE);
    assert!(maze(&["STEPS own"]).ends_with("own-steps.txt"));
}

#[test]
fn reports_unreadable_mazes_and_runs_the_others() {
    let home = Home::new();
    home.write("mazes/a.txt", "o---o\n| S \no---o\n");
    home.write("mazes/b.txt", MAZE);
    home.write("empty/README.md", "no maze");
    let ended = random(&home, &["no such", "empty", "mazes"]);
    assert_eq!((ended.code, ended.stdout.lines().count()), (Some(1), 2), "{ended:?}");
    let messages: Vec<_> = ended.stderr.lines().collect();
    assert!(messages[0].starts_with("mmsim: no maze matches \"no such\" in "));
    assert_eq!(messages[1], "mmsim: no mazes in empty");
    assert!(
        messages[2]
            .replace('\\', "/")
            .starts_with("mmsim: mazes/a.txt: line 2, column 5: expected ")
    );
    let ended = random(&home, &["mazes/a.txt"]);
    assert_eq!((ended.code, &ended.stdout[..]), (Some(1), ""), "no table without a trial");
}

#[test]
fn a_trial_works_in_the_smallest_maze() {
    let home = Home::new();
    home.write("one.txt", "o---o\n|SG |\no---o\n");
    let report = home.run(&["trial", "one.txt", "--robot", "all", "--json"]).json();
    assert!(report.as_array().unwrap().iter().all(|trial| trial["race_optimum"] == 1), "{report}");
}

#[test]
fn a_comparison_prints_tables_and_json_and_draws_charts() {
    let home = Home::new();
    home.write("mazes/a.txt", MAZE);
    home.write("mazes/b &c.txt", MAZE);
    let ended = home.run(&["trial", "mazes", "--compare", "--charts", "new/charts"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    let head: Vec<_> = ended.stdout.lines().next().unwrap().split_whitespace().collect();
    assert_eq!(head, ["Benchmarks", "a", "b", "&c", "sum"]);
    let random: Vec<_> = ended.stdout.lines().nth(1).unwrap().split("  ").map(str::trim).collect();
    let random: Vec<_> = random.into_iter().filter(|column| !column.is_empty()).collect();
    assert_eq!(random, ["random, seed 0", "4 + 3 = 3.133", "4 + 3 = 3.133", "6.267"]);
    let charts = home.path().join("new/charts");
    for (measure, title) in
        [("score", "score"), ("explore-steps", "explore steps"), ("race-steps", "race steps")]
    {
        let chart = charts.join(format!("{measure}-distribution.svg"));
        let svg = std::fs::read_to_string(&chart).unwrap();
        assert!(svg.contains(&format!(">{title}</text>")) && svg.contains(">champion</text>"));
    }
    let tables: Vec<_> = ended.stdout.split("\n\n").collect();
    assert_eq!(tables.len(), 4, "{}", ended.stdout);
    assert!(tables[1].starts_with("Variants of swing ") && tables[1].contains("\njust-arrive "));
    assert!(tables[1].contains("\njust-arrive, as published "), "{}", tables[1]);
    assert_eq!(tables[2].lines().count(), 9, "{}", tables[2]);
    let rows = home.run(&["trial", "mazes", "--compare", "--json"]).json();
    assert_eq!(
        (&rows[0]["table"], &rows[0]["row"]),
        (&json!("benchmarks"), &json!("random, seed 0"))
    );
    assert_eq!(rows[1]["path"].as_str().map(|maze| maze.ends_with("b &c.txt")), Some(true));
    // A robot without a score is a result, not a failure.
    home.write("closed.txt", CLOSED);
    let ended = home.run(&["trial", "closed.txt", "--compare"]);
    assert_eq!(ended.code, Some(0));
    let random = ended.stdout.lines().nth(1).unwrap().split_whitespace();
    assert!(
        random.eq(["random,", "seed", "0", "1000", "+", "0,", "out", "of", "time", "-"]),
        "{ended:?}"
    );
    let ended = home.run(&["trial", "closed.txt", "no such", "--compare"]);
    assert_eq!(ended.code, Some(1));
    home.write("file", "");
    let ended = home.run(&["trial", "closed.txt", "--compare", "--charts", "file"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.starts_with("mmsim: cannot create file: "), "{ended:?}");
}

#[test]
fn the_variant_determines_how_far_swing_explores() {
    let home = Home::new();
    let explore_steps = |arguments: &[&str]| {
        let trial = ["trial", "first steps", "--robot", "swing", "--json"];
        home.run(&[&trial[..], arguments].concat()).json()[0]["explore_steps"].as_u64().unwrap()
    };
    let variants = ["just-arrive", "arrive-and-back", "all"];
    let steps = variants.map(|variant| explore_steps(&["--variant", variant]));
    assert!(steps.is_sorted() && steps[0] < steps[2], "{steps:?}");
    let steps = ["0", "3"].map(|number| explore_steps(&["--key-points", number]));
    assert!(steps[0] < steps[1], "{steps:?}");
}

#[test]
fn many_mazes_are_compared_by_means() {
    let home = Home::new();
    for number in 0..7 {
        home.write(&format!("mazes/{number}.txt"), MAZE);
    }
    home.write("mazes/closed.txt", CLOSED);
    let ended = home.run(&["trial", "mazes", "--compare"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    let lines: Vec<Vec<_>> =
        ended.stdout.lines().map(|line| line.split_whitespace().collect()).collect();
    let head =
        ["Benchmarks", "scored", "unreachable", "failed", "explore", "race", "score", "excess"];
    assert_eq!(lines[0], head);
    assert_eq!(lines[1][3..], ["7", "0", "1", "4.0", "3.0", "3.133", "1.033"]);
}

#[test]
fn a_trial_is_sent_as_states() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    let trial = ["trial", "a.txt", "--robot", "random", "--serve", "--port", "0"];
    let ended = home.run(&[&trial[..], &["--once", "--record", "kept", "--json"]].concat());
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let report = &ended.json()[0];
    let steps = report["explore_steps"].as_u64().unwrap() + report["race_steps"].as_u64().unwrap();
    let file = harness::recorded(&home.path().join("kept")).display().to_string();
    let state = |more: &[&str]| home.run(&[&["replay", &file, "--json"], more].concat()).json();
    let (first, last) = (state(&["--at", "0"]), state(&[]));
    assert_eq!(last["states"], json!(steps + 1), "{last}");
    let map = "o---o---o---o---o\n|   .   . G .   |\no   o . o . o . o\n| ^ |   .   .   |\no---o---o---o---o\n";
    assert_eq!(
        (&first["state"]["map"], &first["state"]["weights"][0]),
        (&json!(map), &json!([2, 1]))
    );
    assert_eq!(
        (&last["state"]["cell"], &last["state"]["wrong_walls"]),
        (&json!([2, 1]), &json!(0))
    );
    // The recording contains the figures of the trial.
    let (trial, optimum) = (&last["state"]["trial"], &report["race_optimum"]);
    assert_eq!((&trial["mouse"], &trial["status"]), (&json!("random"), &json!("scored")));
    assert_eq!(trial["run_1"]["steps"], report["explore_steps"]);
    assert_eq!(trial["run_2"]["steps"], report["race_steps"]);
    assert_eq!(trial["score"], report["score"]);
    assert!(last["state"]["optimistic_distance"].as_u64() <= optimum.as_u64());
    let text = home.run(&["replay", &file]).stdout;
    assert!(text.contains("\ntwo-run trial of random: scored, score "), "{text}");
    let explore = report["explore_steps"].as_u64().unwrap();
    let reset = &state(&["--at", &explore.to_string()])["state"];
    assert_eq!((&reset["trial"]["status"], &reset["cell"]), (&json!("run_2"), &json!([0, 0])));
    assert_eq!(reset["trial"]["run_2"]["steps"], 0);
    let before = &state(&["--at", &(explore - 1).to_string()])["state"]["trial"];
    assert_eq!((&before["status"], &before["run_2"]), (&json!("run_1"), &Value::Null));
    assert_eq!(before["run_1"]["steps"], explore - 1);
    // Other tools read the same figures.
    let messages = harness::mouse_messages(Path::new(&file));
    assert_eq!(messages.len() as u64, steps + 1);
    for (index, message) in messages.iter().enumerate() {
        let state = &state(&["--at", &index.to_string()])["state"];
        let sum = |key: &str| {
            let run = |run: &str| state["trial"][run][key].as_u64().unwrap_or(0);
            run("run_1") + run("run_2")
        };
        assert_eq!(message["phase"], state["trial"]["status"], "state {index}");
        assert_eq!(
            message["phase_number"],
            if index as u64 == steps { 7 } else { 5 + u8::from(index as u64 >= explore) }
        );
        assert_eq!(
            (&message["steps"], &message["turns"]),
            (&sum("steps").into(), &sum("turns").into())
        );
        harness::check_mouse_message(message, state);
    }
}

#[test]
#[cfg_attr(not(unix), allow(unused_mut))]
fn a_trial_is_served_until_interrupted() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    let trial =
        ["trial", "a.txt", "--robot", "random", "--serve", "--port", "0", "--viewer-port", "0"];
    let mut server = harness::Serving::start(home.command(&trial), "still serving");
    assert!(server.messages.contains("watch at http://127.0.0.1:"), "{}", server.messages);
    let reply = ask(&connect_to(&server.address, zmq::REQ), b"info");
    let info: Value = serde_json::from_slice(&reply).unwrap();
    assert_eq!((&info["maze"], &info["states"]), (&json!("a"), &json!(8)));
    #[cfg(unix)]
    {
        server.signal("INT");
        assert_eq!(server.wait().0.code(), Some(0));
        assert!(server.stdout().contains("3.133"));
        let slow = ["trial", "-v", "a.txt", "--serve", "--port", "0", "--pace", "60000"];
        let mut server = home.serve_until(&slow, "keeping up to");
        server.signal("TERM");
        assert_eq!(server.wait().0.code(), Some(0));
    }
}

#[test]
fn usage_errors_set_exit_code_2() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    for (arguments, error) in [
        (&[][..], "<MAZE>"),
        (&["--published", "robot.py", "a.txt"], "put each MAZE first"),
        (&["--json", "--published", "robot.py"], "Usage: mmsim trial <MAZE>... [OPTIONS]"),
        (&["a.txt", "--python", "python3"], "--published <FILE>"),
        (&["a.txt", "--robot", "Random"], "[possible values: random"),
        (&["a.txt", "--noise", "1.5"], "expected a probability from 0 to 100%"),
        (&["a.txt", "--seed=-1"], "--seed"),
        (&["a.txt", "--charts", "charts"], "--compare"),
        (&["a.txt", "--compare", "--robot", "random"], "cannot be used with"),
        (&["a.txt", "--compare", "--variant", "all"], "cannot be used with"),
        (&["a.txt", "--key-points", "4"], "expected 0 to 3 corners"),
        (&["a.txt", "--variant", "some"], "[possible values: just-arrive, arrive-and-back, all]"),
        (&["a.txt", "--once"], "--serve"),
        (&["a.txt", "--open"], "recording, history and viewer options require --serve"),
        (&["a.txt", "--serve", "a.txt"], "--serve takes one maze, found 2"),
        (&["a.txt", "--as-published"], "--as-published requires --robot swing"),
        (&["a.txt", "a.txt", "-o", "a.svg"], "--output takes one maze, found 2"),
        (&["a.txt", "--robot", "all", "-o", "a.svg"], "--output takes at most 6 robots, found 7"),
        (&["a.txt", "-o", "a.gif"], "expected a file ending in .svg or .png"),
        (
            &["a.txt", "--tour", "a.svg"],
            "--tour requires one robot: swing, swing-as-published or swing-timed",
        ),
        (&["a.txt", "--key-points", "2"], "--key-points and --variant require a robot: swing"),
        (&["a.txt", "--variant", "just-arrive", "--robot", "proven"], "require a robot: swing"),
        (&["a.txt", "--answer-limit", "3"], "--published <FILE>"),
        (&["a.txt", "--compare", "--answer-limit", "3"], "--published <FILE>"),
        (&["a.txt", "--answer-limit", "0"], "expected a number of seconds greater than 0"),
    ] {
        let ended = home.run(&[&["trial"], arguments].concat());
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{arguments:?}");
        assert!(ended.stderr.contains(error), "{arguments:?}: {}", ended.stderr);
    }
}

#[test]
fn a_closed_pipe_is_not_a_failure() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    let mut command = home.command(&["trial", "a.txt", "--robot", "random"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = wait_with_output(child);
    assert_eq!((output.stderr, output.status.code()), (Vec::new(), Some(0)));
}
