//! `mmsim solve` against a server in another process, and `mmsim demo`.

mod harness;

use std::process::Stdio;

use harness::{Home, Serving};
use mmsim_tests::wait_with_output;
use serde_json::json;

#[test]
fn each_strategy_searches_a_served_maze() {
    let home = Home::new();
    let server = home.serve(&["--port", "0", "hedgerow"]);
    let solve = |strategy| home.run(&["solve", strategy, "--connect", &server.address, "--json"]);
    for (strategy, steps) in [("flood-fill", 191), ("weight-increment", 445), ("left-wall", 301)] {
        let ended = solve(strategy);
        let report = ended.json();
        assert_eq!(ended.code, Some(0), "{ended:?}");
        assert_eq!(report["mouse"], strategy);
        assert_eq!(report["goal_reached"], json!(true));
        assert_eq!(report["error"], json!(null));
        let took = report["steps"].as_u64().unwrap();
        assert_eq!(took, steps, "{strategy}");
        assert_eq!(report["states"].as_u64().unwrap(), took + 1);
        assert_eq!(report["requests"].as_u64().unwrap(), 2 * took + 3);
        let phases = &report["phases"];
        assert_eq!(phases["search_run"]["steps"], took);
        assert_eq!(phases["search_run"]["turns"], report["turns"]);
        assert_eq!((&phases["return_run"], &phases["fast_run"]), (&json!(null), &json!(null)));
    }
}

/// A search, its recording and the text of both have the same figures for each phase.
#[test]
fn the_phases_of_a_search_equal_those_of_its_recording() {
    let home = Home::new();
    let server = home.serve(&["--port", "0", "hedgerow"]);
    let solve = |more: &[&str]| {
        let command = ["solve", "shortest-path-search", "--connect", &server.address];
        home.run(&[&command[..], more].concat())
    };
    // With `--goal server`, the mouse knows that the simulator accepts its name.
    let report = solve(&["--json", "--record", "own.mcap", "--goal", "server"]).json();
    let phases = &report["phases"];
    let [search, back, fast] = ["search_run", "return_run", "fast_run"].map(|run| &phases[run]);
    let steps = [search, back, fast].map(|run| run["steps"].as_u64().unwrap());
    assert_eq!(steps.iter().sum::<u64>(), report["steps"].as_u64().unwrap());
    assert_eq!(steps[2], 59, "the shortest path");
    assert_eq!(phases["total"]["turns"], report["turns"]);
    // Without the breaks of long lines.
    let text = solve(&[]).stdout.replace(",\n  ", ", ");
    let (_, table) = text.split_once("shortest-path-search: goal reached after ").unwrap();
    let [a, b, c] = steps;
    let expected = format!(" steps (search run {a}, return run {b}, fast run {c}), ");
    assert!(table.contains(&expected), "{table}");
    let lines = table.lines().skip(1).map(|line| line.split("  ").next().unwrap());
    assert_eq!(
        lines.take(4).collect::<Vec<_>>(),
        ["search run", "return run", "fast run", "total"]
    );

    let report = home.run(&["replay", "own.mcap", "--json"]).json();
    let names = [&report["mouse"], &report["strategy"]];
    assert_eq!(names, [&json!("mmsim"), &json!("shortest-path-search")]);
    assert!(report["maze"].as_str().unwrap().ends_with("hedgerow"), "{}", report["maze"]);
    let (state, replayed) = (&report["state"], &report["state"]["phases"]);
    for run in ["search_run", "return_run", "fast_run", "total"] {
        for figure in ["steps", "turns", "time_s"] {
            assert_eq!(replayed[run][figure], phases[run][figure], "{run} {figure}");
        }
        assert!(replayed[run]["wall_time_s"].as_f64().unwrap() > 0.);
    }
    assert_eq!(replayed["best_run"], replayed["fast_run"]);
    let [least, most] = ["optimistic_distance", "pessimistic_distance"].map(|key| &state[key]);
    assert_eq!((least, most, &state["proven"]), (&json!(59), &json!(59), &json!(true)));
    let shown = home.run(&["replay", "own.mcap"]).stdout;
    assert!(shown.contains("\nmouse mmsim, strategy shortest-path-search\n"), "{shown}");
    assert!(shown.contains("\nsearch run  ") && shown.contains("\nfast run  "), "{shown}");
    assert!(shown.contains("\nshortest path: 59 steps, proven\n"), "{shown}");
    // The total is that of the last state.
    let at = format!("{}", a + b / 2);
    let during = home.run(&["replay", "own.mcap", "--json", "--at", &at]).json();
    let phases = &during["state"]["phases"];
    assert_eq!(
        (&phases["search_run"]["steps"], &phases["return_run"]["steps"]),
        (&json!(a), &json!(b / 2))
    );
    assert_eq!((&phases["fast_run"], &during["state"]["event"]), (&json!(null), &json!(null)));
}

#[test]
fn a_small_search_prints_what_the_mouse_knows() {
    let home = Home::new();
    let server = home.serve(&["--port", "0", "first steps"]);
    let ended =
        home.run(&["solve", "flood-fill", "--connect", &server.address, "--goal", "server"]);
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
    insta::assert_snapshot!(ended.stdout, @"
    o---o---o---o---o---o---o---o---o
    | 9 . 8 . 7   6   5   6 . 5 . 6 |
    o . o . o---o   o   o . o . o . o
    |10 . 9 | 8   7 | 4 | 5 . 4 . 5 |
    o . o   o   o---o   o---o . o . o
    |11 |10   9 | 4   3   2 | 3 . 4 |
    o---o   o---o---o---o   o . o . o
    | 8   9 |10 | 0   <   1   2 . 3 |
    o   o---o   o . o   o   o . o . o
    | 7   8   9 | 0 . 0 . 1 . 2 . 3 |
    o   o---o---o . o . o . o . o . o
    | 6 | 3 . 2 . 1 . 1 . 2 . 3 . 4 |
    o   o . o . o . o . o . o . o . o
    | 5   4 . 3 . 2 . 2 . 3 . 4 . 5 |
    o   o . o . o . o . o . o . o . o
    | 6 | 5 . 4 . 3 . 3 . 4 . 5 . 6 |
    o---o---o---o---o---o---o---o---o
    flood-fill: goal reached after 24 steps, 21 cells visited, 51 requests
    search run  24 steps  19 turns  11.000 s
    fastest known run: 1.364 s with the vehicle expert, at most 101.01% slower than
      the fastest run
    ");
    let maze = ["--size", "8x8", "--goal", "3,3", "4,3", "--goal", "3,4", "4,4"];
    let arguments = [&["solve", "flood-fill", "--connect", &server.address][..], &maze].concat();
    assert_eq!(home.run(&arguments).stdout.lines().last(), ended.stdout.lines().last());
}

#[test]
fn an_unreached_goal_sets_exit_code_1() {
    let home = Home::new();
    let server = home.serve(&["--port", "0", "closed garden"]);
    let solve = |more: &[&str]| {
        home.run(&[&["solve", "flood-fill", "--connect", &server.address][..], more].concat())
    };
    let ended = solve(&[]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.starts_with("mmsim: goal unreachable from "), "{ended:?}");
    assert!(ended.stdout.contains("goal not reached after 137 steps"), "{ended:?}");
    let report = solve(&["--json"]).json();
    assert_eq!((&report["goal_reached"], &report["ending"]), (&json!(false), &json!("gave_up")));
    assert!(report["error"].as_str().unwrap().starts_with("goal unreachable from "));
    let ended = solve(&["--max-steps", "10"]);
    assert_eq!(
        (ended.code, ended.stderr.as_str()),
        (Some(1), "gave up at the limit of 10 states (see --max-steps)\n")
    );
    assert!(ended.stdout.contains("goal not reached after 9 steps"), "{ended:?}");
    let ended = solve(&["--size", "32x32"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.contains("refused S: expected a state of 518 bytes"), "{ended:?}");
    assert!(ended.stderr.contains("use --goal server"), "{ended:?}");
}

#[test]
fn a_client_without_a_server_waits_until_the_timeout() {
    let home = Home::new();
    let arguments = ["solve", "left-wall", "--connect", "tcp://127.0.0.1:1", "--timeout", "0.1"];
    let ended = home.run(&arguments);
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(1), ""));
    assert!(ended.stderr.contains("within 0.1 s (start a simulator"), "{ended:?}");
    let patient = home.command(&arguments[..4]);
    let waiting = Serving::start(patient, "press Ctrl-C to give up");
    let start = "no reply from tcp://127.0.0.1:1 for ";
    assert!(waiting.messages.starts_with(start), "{}", waiting.messages);
    let end = "(start a simulator with `mmsim`); press Ctrl-C to give up\n";
    assert!(waiting.messages.ends_with(end), "{}", waiting.messages);
    let asking = home.run(&[&arguments[..], &["--goal", "server", "--json"]].concat());
    assert_eq!(asking.json()["goal_reached"], json!(false));
    assert!(asking.json()["error"].as_str().unwrap().contains("within 0.1 s"));
}

#[test]
fn the_demo_draws_the_last_map_without_a_terminal() {
    let home = Home::new();
    let ended = home.run(&["demo", "--port", "0", "--once", "first steps"]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    insta::assert_snapshot!("demo", ended.stdout);
    home.write("own.txt", "o---o---o\n| S   G |\no---o---o\n");
    let ended = home.run(&["demo", "own.txt", "--port", "0", "--once"]);
    assert!(ended.stdout.contains("goal reached after 1 step, 2 cells visited"), "{ended:?}");
    let ended = home.run(&["demo", "--port", "0", "--once", "closed garden"]);
    assert_eq!(ended.code, Some(1), "{ended:?}");
}

#[cfg(unix)]
#[test]
fn the_demo_keeps_serving_until_interrupted() {
    let home = Home::new();
    let mut demo = home.serve_until(&["demo", "--port", "0"], "still serving");
    let searched = home.run(&["solve", "weight-increment", "--connect", &demo.address]);
    assert_eq!(searched.code, Some(0), "{searched:?}");
    demo.signal("INT");
    let (status, messages) = demo.wait();
    assert_eq!(status.code(), Some(0), "{messages}");
    assert!(demo.stdout().contains("flood-fill: goal reached after 124 steps"));
}

#[cfg(unix)]
#[test]
fn an_interrupt_stops_a_running_demo() {
    let home = Home::new();
    let mut demo = home.serve(&["demo", "--port", "0", "--pace", "60000"]);
    demo.signal("TERM");
    assert_eq!(demo.wait().0.code(), Some(0));
    assert!(demo.stdout().contains("flood-fill: interrupted after 0 steps"));
}

#[test]
fn a_closed_pipe_does_not_change_the_exit_code() {
    let home = Home::new();
    home.write("rubbish.txt", "rubbish");
    for (arguments, code) in
        [(["mazes", "list"].as_slice(), 0), (&["mazes", "check", "rubbish.txt"], 1)]
    {
        let mut command = home.command(arguments);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = wait_with_output(child);
        assert_eq!((output.stderr, output.status.code()), (Vec::new(), Some(code)));
    }
}

/// The options decide what the mouse proves, and the output states it.
#[test]
fn a_search_for_the_fastest_run_states_its_proof() {
    let home = Home::new();
    let server = home.serve(&["--port", "0", "mirage"]);
    let solve = |strategy, options: &[&str]| {
        home.run(&[&["solve", strategy, "--connect", &server.address][..], options].concat())
    };
    let search = |options: &[&str]| solve("fastest-path-search", options);
    let text = search(&[]).stdout.replace("\n  ", " ");
    let last = text.lines().last().unwrap();
    assert!(last.starts_with("fastest known run: "), "{last}");
    assert!(last.ends_with(" s with the vehicle expert, proven to be the fastest run"), "{last}");
    let exact = search(&["--vehicle", "ares", "--json"]).json();
    let near = search(&["--vehicle", "ares", "--tolerance", "20%", "--json"]).json();
    let number = |report: &serde_json::Value, key: &str| report[key].as_f64().unwrap();
    for (report, most) in [(&exact, 1e-9), (&near, 0.2)] {
        assert_eq!(report["vehicle"], "ares");
        let (time, bound) =
            (number(report, "known_run_time_s"), number(report, "fastest_run_lower_bound_s"));
        assert!(bound <= time + 1e-9 && time <= bound * (1.0 + most) + 1e-9, "{time} {bound}");
    }
    assert!(number(&near, "steps") < number(&exact, "steps"));

    let refused = solve("swing", &["--tolerance", "3%"]);
    assert_eq!(refused.code, Some(2), "{refused:?}");
    let refused = search(&["--tolerance", "3"]);
    assert!(
        refused.code == Some(2) && refused.stderr.contains("such as 3% or 0.03"),
        "{refused:?}"
    );
}
