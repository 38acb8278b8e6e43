//! Mice in the manner of strangers: each file in `tests/strangers/mice` has its right answer.

use mmsim_protocol::Colour;
use mmsim_tests::MMS_COLOURS;

use super::harness::mice::python2;
use super::*;

/// A maze in which a mouse that follows the left wall reaches the goal.
const ROOM: &str = "\
o---o---o---o---o---o
|                   |
o   o---o---o---o   o
|   |           |   |
o   o   o   o---o   o
|   |     G         |
o   o   o   o---o   o
|   |           |   |
o   o---o---o---o   o
| S |               |
o---o---o---o---o---o
";

/// The mice that run in any Python, each with whether it reaches the goal, the number of its invalid
/// lines, and a part of its output on stderr.
const MICE: [(&str, bool, u64, &str); 8] = [
    ("bare_statistic.py", false, 0, ""),
    ("colours.py", false, 0, ""),
    ("crlf.py", true, 0, ""),
    ("extensions.py", true, 0, "fast run"),
    ("never_ends.py", true, 0, ""),
    ("stderr.py", true, 0, "step 19999 of 20000"),
    (
        "two_blanks.py",
        false,
        1,
        "mms: line 1: expected setText X Y TEXT, with one blank before X and Y",
    ),
    ("unflushed.py", true, 0, ""),
];

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/strangers/mice").join(name)
}

/// Runs a mouse in [`ROOM`] until it reaches the goal and records the search in the folder `seen`.
fn run(home: &Home, python: &str, mouse: &str) -> Output {
    home.write("room.txt", ROOM);
    let options =
        [&QUIET[..], &["--maze", "room.txt", "--json", "--stop-at-goal", "--record", "seen"]];
    let file = file(mouse);
    let mut command =
        home.command(&arguments(&options.concat(), &[python, file.to_str().unwrap()]));
    Output::new(command.env("PYTHONDONTWRITEBYTECODE", "1"))
}

#[test]
fn each_mouse_has_its_right_answer() {
    let Some(python) = python() else { return };
    for (mouse, goal_reached, refused, message) in MICE {
        let ended = run(&Home::new(), python, mouse);
        assert_eq!(ended.code, Some(0), "{mouse}: {ended:?}");
        let report = ended.json();
        assert_eq!(report["goal_reached"], goal_reached, "{mouse}: {ended:?}");
        assert_eq!(report["refused_requests"], refused, "{mouse}: {ended:?}");
        assert_eq!(report["crashes"], 0, "{mouse}");
        assert_eq!(report["moves"].is_string(), mouse == "extensions.py", "{report}");
        assert!(ended.stderr.contains(message), "{mouse}: {ended:?}");
    }
    let all = fs::read_dir(file("")).unwrap().map(|file| file.unwrap().file_name());
    let all = all.map(|name| name.into_string().unwrap());
    // Python may have written a folder for its cache.
    let mut all: Vec<String> = all.filter(|name| !name.contains("cache")).collect();
    all.sort();
    let mut tested: Vec<&str> = MICE.iter().map(|(mouse, ..)| *mouse).collect();
    tested.extend(["follower.py", "python2.py"]);
    tested.sort_unstable();
    assert_eq!(all, tested);
}

#[test]
fn all_colours_are_recorded() {
    let (home, Some(python)) = (Home::new(), python()) else { return };
    run(&home, python, "colours.py");
    let recording = recording(&home.path().join("seen"));
    let context = recording.last_context();
    for (place, (letter, _)) in (0..).zip(MMS_COLOURS) {
        let colour = context.notes().colour(Cell::new(place % 5, place / 5));
        assert_eq!(colour.map(Colour::letter), Some(letter));
    }
}

#[test]
fn a_mouse_that_never_ends_has_not_failed() {
    let (home, Some(python)) = (Home::new(), python()) else { return };
    for maze in ["a.txt", "b.txt"] {
        home.write(&format!("mazes/{maze}"), ROOM);
    }
    let mouse = format!("never={python} '{}'", file("never_ends.py").display());
    let compare = ["compare", "mazes", "--strategies", "none", "--time-limit", "600", "--mouse"];
    let run = |options: &[&str]| {
        let mut command = home.command(&[&compare[..], &[&mouse], options].concat());
        let ended = Output::new(command.env("PYTHONDONTWRITEBYTECODE", "1"));
        assert_eq!(ended.code, Some(0), "{ended:?}");
        ended
    };
    let ended = run(&[]);
    let row = ended.stdout.lines().find(|line| line.starts_with("1 never "));
    assert!(row.is_some_and(|row| row.contains(" 2/2 ")), "{ended:?}");
    assert!(!ended.stdout.contains("not solved") && ended.stderr.is_empty(), "{ended:?}");
    let report = run(&["--json"]).json();
    for maze in 0..2 {
        let search = &report[0]["mazes"][maze];
        assert_eq!((&search["ending"], &search["error"]), (&json!("finished"), &json!(null)));
    }
}

#[test]
fn a_mouse_in_python_2_needs_python_2() {
    let mouse = "python2.py";
    if let Some(python) = python() {
        let ended = run(&Home::new(), python, mouse);
        assert_eq!(ended.code, Some(1), "{ended:?}");
        assert!(ended.stderr.contains("SyntaxError: "), "{ended:?}");
    }
    let Some(python2) = python2() else { return };
    let ended = run(&Home::new(), &python2, mouse);
    assert_eq!((ended.code, &ended.json()["goal_reached"]), (Some(0), &json!(true)), "{ended:?}");
}
