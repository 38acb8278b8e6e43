//! `mmsim mazes`: list, show, check and diff.

mod harness;

use harness::{Home, Output};
use mmsim_formats::Format;
use mmsim_generator::{Style, generate};
use mmsim_maze::MazeSize;
use serde_json::json;

const SMALL: &str = "o---o---o\n| S   G |\no---o---o\n";

#[test]
fn list_prints_size_goal_and_shortest_path() {
    let home = Home::new();
    insta::assert_snapshot!("list", home.run(&["mazes", "list"]).stdout);
    let list = home.run(&["mazes", "list", "--json"]).json();
    assert_eq!(list.as_array().unwrap().len(), 19);
    assert_eq!(list[0]["shortest_path"], 52);
}

#[test]
fn a_maze_is_shown_with_its_distances() {
    let home = Home::new();
    insta::assert_snapshot!("show", home.run(&["mazes", "show", "training", "STEPS"]).stdout);
    home.write("mazes/small.txt", SMALL);
    let by_words = home.run(&["mazes", "show", "mazes", "small"]);
    let by_path = home.run(&["mazes", "show", "mazes/small.txt"]);
    assert_eq!(by_words.stdout.replace('\\', "/"), by_path.stdout);
    let shown = home.run(&["mazes", "show", "mazes/small.txt", "--json"]).json();
    assert_eq!(shown["drawing"], SMALL);
    assert_eq!(home.run(&["mazes", "show", "no such"]).code, Some(1));
}

#[test]
fn finds_bundled_mazes_in_addition_to_user_mazes() {
    let home = Home::new();
    home.write(".mmsim/small.txt", SMALL);
    assert!(home.run(&["mazes", "list"]).stdout.contains("small.txt"));
    let shown = home.run(&["mazes", "show", "harbour", "--json"]);
    assert_eq!((shown.code, &shown.json()["path"]), (Some(0), &json!("01-harbour.txt")));
    let named = home.run(&["mazes", "show", ".mmsim", "harbour"]);
    assert!(named.code == Some(1) && named.stderr.contains("list the 1 file with"), "{named:?}");
}

#[test]
fn check_prints_facts_or_the_error_of_each_file() {
    let home = Home::new();
    home.write("mazes/a.txt", SMALL);
    home.write("mazes/b/wide.txt", SMALL.replace("S  ", "S |").replace(" G |", "   |"));
    home.write("bad.txt", SMALL.replace("---o\n|", "-- o\n|"));
    let good = home.run(&["mazes", "check", "mazes", "--json"]);
    assert_eq!(good.code, Some(0));
    let path = std::path::Path::new("mazes").join("a.txt");
    assert_eq!(
        good.json().as_array().unwrap()[0],
        json!({"path": path, "width": 2, "height": 1, "goals": [[1, 0]],
               "shortest_path": 1, "reachable_cells": 2, "error": null,
               "notation": "drawing", "findings": []})
    );
    let unreachable = json!([{"severity": "warning", "kind": "unreachable_cells",
        "message": "cell (1, 0) is unreachable", "line": null, "column": null,
        "byte": null, "cell": [1, 0], "readings": []}]);
    assert_eq!(good.json()[1]["findings"], unreachable);
    assert_eq!(good.json()[1]["reachable_cells"], 1);
    let bad = home.run(&["mazes", "check", "mazes", "bad.txt", "missing.txt", "--json"]);
    assert_eq!(bad.code, Some(1));
    assert_eq!(bad.json().as_array().unwrap().len(), 4);
    assert_eq!(
        bad.json()[2]["error"],
        "bad.txt: line 1, column 6: expected a wall or blanks, found \"-- \""
    );
    assert_eq!(bad.json()[2]["width"], json!(null));
    assert_eq!(bad.json()[2]["findings"][0]["kind"], "unreadable");
    assert_eq!(bad.json()[2]["findings"][0]["column"], 6);
    assert!(
        bad.json()[3]["error"].as_str().unwrap().starts_with("no such file or folder: missing.txt")
    );
    assert_eq!(bad.json()[3]["notation"], json!(null));
    let text = home.run(&["mazes", "check", "mazes", "bad.txt"]);
    insta::assert_snapshot!(text.stdout.replace('\\', "/"), @r#"
    mazes/a.txt: 2x1, 1 goal cell, goal 1 step away
    mazes/b/wide.txt: 2x1, 2 goal cells, goal 0 steps away, 1 cell unreachable
      warning: cell (1, 0) is unreachable
    bad.txt: line 1, column 6: expected a wall or blanks, found "-- "
    "#);
}

#[test]
fn check_reports_every_finding_with_its_position() {
    let home = Home::new();
    let open = "o---o---o---o---o\n|               |\no   o   o   o   o\n| S | G         |\no   o---o---o---o\n|   |   |       |\no---o---o---o---o\n";
    home.write(
        "mazes/1-gaps.txt",
        open.replace("o---o---o---o---o\n|  ", "o   o---o---o   o\n   "),
    );
    home.write("mazes/2-contradiction.csv", "8,2,7\n5,10,6\n");
    home.write("mazes/3-closed.txt", SMALL.replace("S  ", "S |"));
    home.write("mazes/4-posts.txt", open);
    home.write("mazes/5-unknown.maze", SMALL.replace("S  ", "S ."));
    home.write("mazes/6-known.txt", SMALL);
    home.write("mazes/7-again.txt", SMALL.replace('o', "+"));
    let checked = home.run(&["mazes", "check", "mazes"]);
    assert_eq!(checked.code, Some(1));
    insta::assert_snapshot!(checked.stdout.replace('\\', "/"), @r#"
    mazes/1-gaps.txt: line 1, column 2: expected the outer wall, found "   "
      error: 2 more gaps in the outer wall, at line 1, column 14; line 2, column 1
    mazes/2-contradiction.csv: line 1, column 3: expected a wall between (1, 0) and (1, 1) to match line 2, column 3, found 2 (nearest encoding: --bits codes --rows north)
    mazes/3-closed.txt: 2x1, 1 goal cell, goal unreachable, 1 cell unreachable
      error: goal (1, 0) unreachable from the start (0, 0)
      warning: cell (1, 0) is unreachable
    mazes/4-posts.txt: 4x3, 1 goal cell, goal 3 steps away, 3 cells unreachable
      warning: 2 posts without a wall, south-west of (2, 2); (3, 2)
      warning: 3 unreachable cells: (1, 0); (2, 0); (3, 0)
    mazes/5-unknown.maze: 2x1, 1 goal cell, goal 1 step away
      warning: line 2, column 5: unknown wall, read as open
    mazes/6-known.txt: 2x1, 1 goal cell, goal 1 step away
      warning: the same walls, start and goal as mazes/5-unknown.maze
    mazes/7-again.txt: 2x1, 1 goal cell, goal 1 step away
      warning: the same walls, start and goal as mazes/5-unknown.maze
    "#);
    let json = home.run(&["mazes", "check", "mazes", "--json"]).json();
    let notations: Vec<_> = json.as_array().unwrap().iter().map(|file| &file["notation"]).collect();
    assert_eq!(notations[..2], [&json!(null); 2], "unreadable");
    assert_eq!(notations[2..], [&json!("drawing"); 5]);
    assert_eq!(json[0]["findings"][2]["line"], 2);
    assert_eq!(json[1]["findings"][0]["kind"], "contradiction");
    assert_eq!(json[1]["findings"][0]["cell"], json!([1, 1]));
    assert_eq!(json[3]["findings"][0]["cell"], json!([2, 2]));
    let errors = |file: &serde_json::Value| {
        file["findings"].as_array().unwrap().iter().any(|found| found["severity"] == "error")
    };
    let failed: Vec<bool> = json.as_array().unwrap().iter().map(errors).collect();
    assert_eq!(failed, [true, true, true, false, false, false, false]);
    let warned = home.run(&["mazes", "check", "mazes/4-posts.txt", "mazes/6-known.txt"]);
    assert_eq!(warned.code, Some(0), "warnings alone");
}

#[test]
fn files_in_a_folder_that_are_no_mazes_are_no_fault() {
    let home = Home::new();
    let maze = generate(MazeSize::new(12, 12).unwrap(), 1, Style::Contest).to_string();
    home.write("mazes/maze.txt", &maze);
    let others: [(&str, &[u8]); 5] = [
        ("README", b"about these mazes\n"),
        ("picture.png", b"\x89PNG\r\n\x1a\n"),
        ("tool.py", b"import sys\nprint(sys.argv)\n"),
        ("maze.txt.meta", b"author: someone\nyear: 2024\n"),
        ("table.ods", b"PK\x03\x04\x14\0"),
    ];
    for (name, content) in others {
        home.write(&format!("mazes/{name}"), content);
    }
    let commands: [&[&str]; 6] = [
        &["mazes", "list"],
        &["mazes", "check"],
        &["compare", "--strategies", "swing", "--json"],
        &["contest", "--strategies", "swing", "--json"],
        &["trial", "--robot", "random", "--json"],
        &["fast-run", "--json"],
    ];
    for command in commands {
        let run = |path: &str| home.run(&[command, &[path]].concat());
        // Some results contain times.
        let facts = |ended: Output| (ended.code, ended.stdout.lines().count(), ended.stderr);
        assert_eq!(facts(run("mazes")), facts(run("mazes/maze.txt")), "{command:?}");
        for (name, _) in others {
            let named = run(&format!("mazes/{name}"));
            // A list names unreadable files, too, but no programs.
            let is_listed = command[1] == "list" && name != "tool.py";
            assert_eq!(named.code, Some(i32::from(!is_listed)), "{command:?} {name}: {named:?}");
        }
    }
    home.write("mazes/damaged.txt", maze.split_at(maze.len() / 2).0);
    for command in commands.iter().filter(|command| command[1] != "list") {
        let ended = home.run(&[command, &["mazes"][..]].concat());
        assert_eq!(ended.code, Some(1), "{command:?}: {ended:?}");
    }
    // Both names contain the word.
    let ended = home.run(&["mazes", "check", "mazes/ ma"]);
    assert!(ended.code == Some(1) && ended.stdout.contains("damaged.txt"), "{ended:?}");
    home.write("others/README", "no mazes");
    assert_eq!(home.run(&["mazes", "check", "others"]).code, Some(1));
}

#[test]
fn check_reports_what_contest_rules_forbid() {
    let home = Home::new();
    let write = |name: &str, side, style| {
        let maze = generate(MazeSize::new(side, side).unwrap(), 1, style).to_string();
        home.write(name, &maze);
        maze
    };
    let contest = write("contest.txt", 8, Style::Contest);
    write("perfect.txt", 8, Style::Perfect);
    write("large.txt", 20, Style::Contest);
    home.write("marked.txt", contest.replace('G', " ").replacen("|   |", "| G |", 1));
    let check = |paths: &[&str], options: &[&str]| {
        let checked = home.run(&[&["mazes", "check"], paths, options].concat());
        (checked.code, checked.stdout)
    };
    let all = ["contest.txt", "large.txt", "perfect.txt", "marked.txt"];
    let (code, text) = check(&all, &[]);
    assert_eq!(code, Some(0));
    insta::assert_snapshot!(text, @"
    contest.txt: 8x8, 4 goal cells, goal 23 steps away
    large.txt: 20x20, 4 goal cells, goal 37 steps away
    perfect.txt: 8x8, 4 goal cells, goal 7 steps away
      warning: the goal has 5 entrances
      warning: a wall follower finds the goal
    marked.txt: 8x8, 1 goal cell, goal 15 steps away
      warning: the goal is not in the centre
      warning: the goal has 2 entrances
      warning: a wall follower finds the goal
    ");
    assert_eq!(check(&all, &["--strict"]), (Some(1), text));
    assert_eq!(check(&["contest.txt"], &["--strict"]).0, Some(0));
    let (code, text) = check(&all, &["--strict", "--rules", "none"]);
    assert!(code == Some(0) && !text.contains("warning"), "{text}");
    let (_, text) = check(&["marked.txt", "large.txt"], &["--rules", "half-size"]);
    assert!(!text.contains("goal is not"), "{text}");
    assert_eq!(check(&["large.txt"], &["--rules", "CLASSIC"]).0, Some(2));
}

#[test]
fn rotated_and_mirrored_mazes_are_duplicates() {
    let home = Home::new();
    home.write("1.txt", "o---o---o\n| G | S |\no   o   o\n|       |\no---o---o\n");
    home.write("2-mirrored.txt", "o---o---o\n| S | G |\no   o   o\n|       |\no---o---o\n");
    home.write("3-turned.txt", "o---o---o\n|     G |\no   o---o\n|     S |\no---o---o\n");
    home.write("4-other-goal.txt", "o---o---o\n|   | S |\no   o   o\n|     G |\no---o---o\n");
    let checked = home.run(&["mazes", "check", ".", "--rules", "none"]);
    insta::assert_snapshot!(checked.stdout.replace('\\', "/"), @"
    ./1.txt: 2x2, 1 goal cell, goal 3 steps away
    ./2-mirrored.txt: 2x2, 1 goal cell, goal 3 steps away
      warning: mirrored, east and west swapped, the maze has the same walls, start
        and goal as ./1.txt
    ./3-turned.txt: 2x2, 1 goal cell, goal 3 steps away
      warning: rotated by 90° anticlockwise, the maze has the same walls, start and
        goal as ./1.txt
    ./4-other-goal.txt: 2x2, 1 goal cell, goal 1 step away
    ");
}

#[test]
fn diff_draws_the_walls_that_differ() {
    let home = Home::new();
    home.write("a.txt", "o---o---o\n| S | G |\no   o   o\n|       |\no---o---o\n");
    home.write("b.txt", "o---o---o\n|   | G |\no---o   o\n| S     |\no---o---o\n");
    home.write("c.txt", SMALL);
    home.write("turned.txt", "o---o---o\n|     S |\no   o---o\n|     G |\no---o---o\n");
    let diff = |a: &str, b: &str| {
        let ended = home.run(&["mazes", "diff", a, b]);
        assert_eq!((ended.code, &ended.stderr[..]), (Some(1), ""), "{ended:?}");
        ended.stdout
    };
    insta::assert_snapshot!(diff("a.txt", "b.txt"), @"
    start: (0, 1) in a.txt, (0, 0) in b.txt
    < 0 walls only in a.txt
    > 1 wall only in b.txt
    o---o---o
    | S | G |
    o>>>o   o
    | S     |
    o---o---o
    ");
    insta::assert_snapshot!(diff("a.txt", "c.txt"), @"
    size: 2x2 cells in a.txt, 2x1 cells in c.txt
    start: (0, 1) in a.txt, (0, 0) in c.txt
    goals: (1, 1) in a.txt, (1, 0) in c.txt
    ");
    insta::assert_snapshot!(diff("a.txt", "turned.txt"), @"
    start: (0, 1) in a.txt, (1, 1) in turned.txt
    goals: (1, 1) in a.txt, (1, 0) in turned.txt
    walls: turned.txt is a.txt, rotated by 90° clockwise
    < 1 wall only in a.txt
    > 1 wall only in turned.txt
    o---o---o
    | S < G |
    o   o>>>o
    |     G |
    o---o---o
    ");
    let coloured =
        Output::new(home.command(&["mazes", "diff", "a.txt", "b.txt"]).env("CLICOLOR_FORCE", "1"));
    assert_eq!(coloured.stdout.matches("\x1b[32m>\x1b[0m").count(), 3);
    let json = home.run(&["mazes", "diff", "a.txt", "b.txt", "--json"]).json();
    assert_eq!(json["differs"], json!(["start", "walls"]));
    assert_eq!(json["only_a"], json!([]));
    assert_eq!(json["only_b"], json!([{"cell": [0, 0], "side": "north"}]));
    let same = home.run(&["mazes", "diff", "harbour", "01 harbour"]);
    assert_eq!(same.code, Some(0));
    assert!(same.stdout.ends_with(" have the same walls, start and goal\n"), "{same:?}");
    assert_eq!(home.run(&["mazes", "diff", "a.txt", "no such"]).code, Some(1));
    assert_eq!(home.run(&["mazes", "diff", "a.txt"]).code, Some(2));
}

#[test]
fn diff_finds_equal_mazes_in_a_folder() {
    let home = Home::new();
    home.write("a/maze.txt", "o---o---o\n| S | G |\no   o   o\n|       |\no---o---o\n");
    home.write("b/1-mirrored.txt", "o---o---o\n| G | S |\no   o   o\n|       |\no---o---o\n");
    home.write("b/2-turned.txt", "o---o---o\n|     S |\no   o---o\n|     G |\no---o---o\n");
    home.write("b/3-goal.txt", "o---o---o\n| S | G |\no   o   o\n| G     |\no---o---o\n");
    home.write("b/4-other.txt", SMALL);
    let found = home.run(&["mazes", "diff", "a/maze.txt", "b"]);
    assert_eq!((found.code, &found.stderr[..]), (Some(0), ""));
    insta::assert_snapshot!(found.stdout.replace('\\', "/"), @"
    b/1-mirrored.txt is a/maze.txt, mirrored, east and west swapped
    b/2-turned.txt is a/maze.txt, rotated by 90° clockwise
    b/3-goal.txt is a/maze.txt, unchanged, another goal
    ");
    assert_eq!(home.run(&["mazes", "diff", "a", "b"]).stdout.lines().count(), 3);
    assert_eq!(home.run(&["mazes", "diff", "b", "a/maze.txt"]).stdout.lines().count(), 3);
    let json = home.run(&["mazes", "diff", "a", "b", "--json"]).json();
    assert_eq!((&json[2]["same_start"], &json[2]["same_goals"]), (&json!(true), &json!(false)));
    // Of two folders with the same files, each pair is printed once.
    let pairs = |a: &str, b: &str| home.run(&["mazes", "diff", a, b]).stdout.lines().count();
    assert_eq!(
        (pairs("b", "b"), pairs("b", "./b"), pairs(".", "b"), pairs(".", ".")),
        (3, 3, 6, 6)
    );
    let none = home.run(&["mazes", "diff", "b/4-other.txt", "b"]);
    assert_eq!((none.code, &none.stdout[..]), (Some(1), ""));
    assert!(none.stderr.starts_with("no maze in b is equal to "), "{none:?}");
}

#[test]
fn a_file_is_no_duplicate_of_itself() {
    let home = Home::new();
    home.write("mazes/x.txt", SMALL);
    let check = |paths: &[&str]| {
        let checked = home.run(&[&["mazes", "check"], paths].concat());
        assert_eq!(checked.code, Some(0));
        checked.stdout
    };
    assert_eq!(check(&["mazes/x.txt", "mazes/x.txt"]).matches("same").count(), 0);
    assert_eq!(check(&["./mazes/x.txt", "mazes/x.txt"]).matches("same").count(), 0);
    assert_eq!(check(&[".", "mazes/x.txt", "mazes"]).matches("same").count(), 0);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("x.txt", home.path().join("mazes/link.txt")).unwrap();
        assert_eq!(check(&["mazes"]).matches("same").count(), 0);
    }
    home.write("mazes/y.txt", SMALL);
    assert_eq!(check(&["mazes", "mazes/x.txt"]).matches("same").count(), 1);
}

#[test]
fn check_reports_bytes_and_their_cells() {
    let home = Home::new();
    let bytes = Format::Maz.write(&mmsim_mazes::HARBOUR.parse().unwrap()).unwrap();
    let east = 2;
    home.write("high.maz", [&bytes[..18], &[16], &bytes[19..]].concat());
    home.write("open.maz", [&bytes[..255], &[bytes[255] & !east]].concat());
    let checked = home.run(&["mazes", "check", "high.maz", "open.maz", "--json"]).json();
    let finding = |file: usize, kind: &str, byte: usize, cell: [u8; 2]| {
        let found = &checked[file]["findings"][0];
        let expected = json!({"severity": "error", "kind": kind, "message": found["message"],
            "line": null, "column": null, "byte": byte, "cell": cell, "readings": []});
        assert_eq!(found, &expected);
    };
    finding(0, "contradiction", 19, [1, 2]);
    finding(1, "open_perimeter", 256, [15, 15]);
}
