//! The page and the commands show the same seconds for a search: those of the mouse.

mod harness;
#[path = "browser/http.rs"]
#[allow(dead_code, reason = "browser tests use the rest")]
mod http;

use harness::Home;
use serde_json::{Value, json};

const MMSIM: &str = env!("CARGO_BIN_EXE_mmsim");

/// A corridor of three steps. `crates/python/tests/test_search.py` expects the same seconds.
const MAZE: &str = "o---o---o---o---o\n| S           G |\no---o---o---o---o\n";

/// A vehicle that searches at 1 s for each cell and 0.5 s for each quarter turn.
const SLOW: &str = "base = 'expert'\nsearch_speed = 180\nsearch_turn_time = 0.5\n";

fn times(report: &Value) -> [Value; 4] {
    ["search_run", "return_run", "fast_run", "total"]
        .map(|run| report["phases"][run]["time_s"].clone())
}

#[test]
fn the_page_and_the_commands_show_the_same_seconds() {
    let home = Home::new();
    home.write("maze.txt", MAZE);
    home.write("slow.toml", SLOW);
    // 3 cells of 0.3 s and a turn of 0.2 s; 3 cells and 2 turns; 630 mm with 17 m/s² and at most 2.5 m/s,
    // which take 2.5 / 17 s + 630 mm / 2.5 m/s.
    let expert = [1.1, 1.3, 0.3991, 2.7991].map(|time| json!(time));
    // 3 cells of 1 s and a turn of 0.5 s; 3 cells and 2 turns; the same fast run.
    let slow = [3.5, 4.0, 0.3991, 7.8991].map(|time| json!(time));

    let server = home.serve_until(&["--port", "0", "--viewer-port", "0", "maze.txt"], "http://");
    let solve = |options: &[&str]| {
        let search = ["solve", "shortest-path-search", "--goal", "server"];
        let command = [&search[..], &["--connect", &server.address]].concat();
        home.run(&[&command[..], options].concat())
    };
    assert_eq!(times(&solve(&["--json", "--vehicle", "slow.toml"]).json()), slow);
    let solved = solve(&["--json", "--record", "run.mcap"]).json();
    assert_eq!(times(&solved), expert);
    assert_eq!(
        (&solved["vehicle"], &solved["fastest_run_proven"]),
        (&json!("expert"), &json!(true))
    );
    assert_eq!(solved["known_run_time_s"], json!(0.3991));
    let text = solve(&[]).stdout;
    let expected = "search run  3 steps   1 turn  1.100 s\n\
                    return run  3 steps  2 turns  1.300 s\n\
                    fast run    3 steps  2 turns  0.399 s\n\
                    total       9 steps  5 turns  2.799 s\n\
                    fastest known run: 0.399 s with the vehicle expert, proven to be the fastest run\n";
    assert!(text.ends_with(expected), "{text}");

    let replay = |options: &[&str]| {
        home.run(&[&["replay", "run.mcap", "--json"], options].concat()).json()["state"].clone()
    };
    assert_eq!(times(&replay(&[])), expert);
    assert_eq!(times(&replay(&["--vehicle", "slow.toml"])), slow);
    let shown = home.run(&["replay", "run.mcap"]).stdout;
    assert!(expected.lines().all(|line| shown.contains(line)), "{shown}");

    let command = [MMSIM, "solve", "shortest-path-search", "--goal", "server"];
    let run = |options: &[&str]| {
        let run = ["run", "--maze", "maze.txt", "--port", "0", "--no-viewer"];
        home.run(&[&run, options, &command].concat())
    };
    assert_eq!(times(&run(&["--json"]).json()), expert);
    assert_eq!(times(&run(&["--json", "--vehicle", "slow.toml"]).json()), slow);
    let noted = run(&[]).stderr;
    assert!(expected.lines().all(|line| noted.contains(line)), "{noted}");

    let page = server.messages.split_whitespace().find(|word| word.starts_with("http://"));
    let page = page.expect("the address of the page").trim_end_matches(['/', ';', ',']);
    let source = http::get(&format!("{page}/api/sources/live")).json();
    let get = |resource: &str, query: &str| {
        let url = format!("{page}/api/sources/live/{resource}?run={}{query}", source["run"]);
        http::get(&url).json()
    };
    let at = format!("&at={}", source["states"].as_u64().unwrap() - 1);
    assert_eq!(times(&get("moment", &at)), expert);
    let ukmars = get("moment", &format!("{at}&vehicle=ukmars"));
    // 3 cells of 0.45 s and a turn of 0.35 s; 3 cells and 2 turns.
    let expected = [json!(1.7), json!(2.05)];
    assert_eq!(times(&ukmars)[..2], expected);
    let result = get("result", "");
    assert_eq!(result["search_time_s"], json!(2.4));
    assert_eq!(result["fast_run_time_s"], json!(0.3991));
    assert_eq!(result["total_time_s"], json!(2.7991));
    // After two steps, the mouse reads that the goal cell is open.
    assert_eq!(result["steps_until_fastest_run_proven"], json!(2));
}
