//! Compiling the array of straights and turns that `mmsim fast-run` writes.

use std::fmt::Write as _;

use mmsim_tests::output;
use serde_json::Value;

use crate::client;
use crate::harness::Home;

/// The turns in the order of the constants.
const TURNS: [&str; 9] = ["s90", "l90", "180", "45in", "135in", "45out", "135out", "v90", "k90"];

/// Returns the expected output of `fast_run.c`.
fn expected(run: &Value) -> String {
    let mut text = format!("{}\n", &run["moves"].as_str().unwrap()[..1]);
    for segment in run["segments"].as_array().unwrap() {
        let length = segment["length_mm"].as_f64().unwrap();
        if let Some(steps) = segment["steps"].as_u64() {
            let diagonal = u8::from(segment["segment"] == "diagonal");
            let top_speed = segment["top_speed_mm_s"].as_f64().unwrap();
            write!(text, "{steps} {diagonal} {length:.2} {top_speed:.1} ").unwrap();
            continue;
        }
        let name = segment["segment"].as_str().unwrap();
        let (turn, side) = name.split_at(name.len() - 1);
        let index = TURNS.iter().position(|other| *other == turn).unwrap();
        let speed = segment["exit_speed_mm_s"].as_f64().unwrap();
        writeln!(text, "{index}{side} {length:.2} {speed:.1}").unwrap();
    }
    // The other run has 11 turns, and begins with s90.
    text + "stop\n12 0 200000\n"
}

#[test]
fn the_array_compiles_and_contains_the_run() {
    let home = Home::new();
    let evil = "a*/ #error \"b\" \\.txt";
    home.write("jerk.toml", "base = 'ukmars'\nalong.jerk = 2e5\n");
    let first = ["fast-run", "first steps", "--vehicle", "jerk.toml"];
    let first = home.run(&[&first[..], &["--c-array", "first.h"]].concat());
    assert_eq!((first.code, &first.stderr[..]), (Some(0), ""));
    home.write(evil, "o---o---o\n| S   G |\no---o---o\n");
    for (maze, vehicle) in
        [("galleries", "expert"), ("old quarter", "kerise"), ("hedgerow", "ukmars"), (evil, "ares")]
    {
        let selected = ["fast-run", maze, "--vehicle", vehicle];
        let ended = home.run(&[&selected[..], &["--c-array", "final.h"]].concat());
        assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "{maze}");
        let json = home.run(&[&selected[..], &["--json", "--explain"]].concat()).json();
        let expected = expected(&json[0]);
        for (name, language) in client::COMPILERS {
            let Some(mut program) = client::with_header(name, language, "fast_run.c", &home) else {
                continue;
            };
            let printed = output(&mut program);
            assert!(printed.status.success());
            assert_eq!(String::from_utf8(printed.stdout).unwrap(), expected, "{maze} with {name}");
        }
    }
}

/// A mouse that starts in the goal stays there.
#[test]
fn the_array_is_never_empty() {
    let home = Home::new();
    home.write("here.txt", "o---o\n|SG |\no---o\n");
    let ended = home.run(&["fast-run", "here.txt", "--c-array", "-"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    let stop = "fast_run[] = {\n    { 0.000f, 0, 0, 0.000f, FAST_RUN_STOP, FAST_RUN_LEFT, 0.000f, 0.000f },\n};";
    assert!(ended.stdout.contains(stop), "{}", ended.stdout);
}
