//! `mmsim mazes`: list, show and check.

mod harness;

use harness::Home;
use serde_json::json;

const SMALL: &str = "o---o---o\n| S   G |\no---o---o\n";

#[test]
fn the_list_tells_size_goal_and_shortest_path() {
    let home = Home::new();
    insta::assert_snapshot!("list", home.run(&["mazes", "list"]).stdout);
    let list = home.run(&["mazes", "list", "--json"]).json();
    assert_eq!(list.as_array().unwrap().len(), 15);
    assert_eq!(list[0]["shortest_path"], 52);
}

#[test]
fn a_maze_is_shown_with_its_distances() {
    let home = Home::new();
    insta::assert_snapshot!("show", home.run(&["mazes", "show", "training", "STEPS"]).stdout);
    home.write("mazes/small.txt", SMALL);
    let by_words = home.run(&["mazes", "show", "small", "--mazes", "mazes"]);
    let by_path = home.run(&["mazes", "show", "mazes/small.txt"]);
    assert_eq!(by_words.stdout.replace('\\', "/"), by_path.stdout);
    let shown = home.run(&["mazes", "show", "mazes/small.txt", "--json"]).json();
    assert_eq!(shown["maze"], SMALL);
    assert_eq!(home.run(&["mazes", "show", "no such"]).code, Some(1));
}

#[test]
fn a_check_gives_facts_or_the_error_of_each_file() {
    let home = Home::new();
    home.write("mazes/a.txt", SMALL);
    home.write("mazes/b/closed.txt", SMALL.replace("S  ", "S |"));
    home.write("bad.txt", SMALL.replace("---o\n|", "-- o\n|"));
    let good = home.run(&["mazes", "check", "mazes", "--json"]);
    assert_eq!(good.code, Some(0));
    let path = std::path::Path::new("mazes").join("a.txt");
    assert_eq!(
        good.json().as_array().unwrap()[0],
        json!({"path": path, "width": 2, "height": 1, "goals": [[1, 0]],
               "shortest_path": 1, "reachable_cells": 2, "error": null})
    );
    assert_eq!(good.json()[1]["shortest_path"], json!(null));
    assert_eq!(good.json()[1]["reachable_cells"], 1);
    let bad = home.run(&["mazes", "check", "mazes", "bad.txt", "missing.txt", "--json"]);
    assert_eq!(bad.code, Some(1));
    assert_eq!(bad.json().as_array().unwrap().len(), 4);
    assert_eq!(
        bad.json()[2]["error"],
        "bad.txt: line 1, column 6: expected \"---\" or three spaces between posts, found \"-- \""
    );
    assert_eq!(bad.json()[2]["width"], json!(null));
    assert!(bad.json()[3]["error"].as_str().unwrap().starts_with("missing.txt: cannot be read"));
    let text = home.run(&["mazes", "check", "mazes", "bad.txt"]);
    insta::assert_snapshot!(text.stdout.replace('\\', "/"), @r#"
    mazes/a.txt: 2x1, 1 goal cell, goal 1 step away
    mazes/b/closed.txt: 2x1, 1 goal cell, goal cannot be reached, 1 cell cannot be reached
    bad.txt: line 1, column 6: expected "---" or three spaces between posts, found "-- "
    "#);
}
