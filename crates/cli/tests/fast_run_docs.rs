//! Checks that the pictures, tables and examples in docs/fast-run.md are up to date.

mod harness;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

use harness::Home;
use mmsim_fastrun::{FastRun, StraightLimits, TurnKind, Vehicle, VehicleParameters};
use mmsim_maze::Cell;

fn at_root(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

fn page() -> String {
    fs::read_to_string(at_root("docs/fast-run.md")).unwrap()
}

/// Compares a picture in the documentation with a new one. Set `MMSIM_UPDATE_PICTURES=1` to
/// replace the pictures after changing the planner or the drawing code.
#[track_caller]
fn check_picture(name: &str, drawn: &[u8]) {
    let shown = at_root("docs/fast-run").join(name);
    if env::var_os("MMSIM_UPDATE_PICTURES").is_some() {
        fs::create_dir_all(shown.parent().unwrap()).unwrap();
        fs::write(&shown, drawn).unwrap();
    }
    let is_same = fs::read(&shown).is_ok_and(|shown| shown == drawn);
    assert!(is_same, "{} differs from the picture of today", shown.display());
    assert!(page().contains(&format!("(fast-run/{name})")), "{name} is not in docs/fast-run.md");
}

#[test]
fn the_pictures_show_the_runs() {
    let vehicles = ["--vehicle", "ukmars", "--vehicle", "ares", "--vehicle", "expert"];
    for (name, maze, arguments) in [
        ("fastest.png", "winding river", &[][..]),
        ("race.gif", "winding river", &["--route", "all"]),
        ("vehicles.png", "left bank", &vehicles),
    ] {
        let home = Home::new();
        let command = ["fast-run", maze, "-o", name, "--width", "400"];
        assert_eq!(home.run(&[&command, arguments].concat()).code, Some(0), "{name}");
        check_picture(name, &fs::read(home.path().join(name)).unwrap());
    }
}

#[test]
fn the_example_shows_the_output() {
    let ended = Home::new().run(&["fast-run", "first steps", "--explain"]);
    let run = &ended.stdout[ended.stdout.find("run       ").unwrap()..];
    assert!(page().contains(&format!("```\n{run}```\n")), "docs/fast-run.md lacks\n{run}");
}

#[test]
fn the_keys_are_those_of_the_output() {
    let page = page();
    let (_, tables) = page.split_once("## JSON").unwrap();
    let json = Home::new().run(&["fast-run", "first steps", "--explain", "--json"]).json();
    let run = json[0].as_object().unwrap();
    let segment = run["segments"][0].as_object().unwrap();
    let keys: Vec<&String> = run.keys().chain(segment.keys()).collect();
    for key in &keys {
        assert!(tables.contains(&format!("`{key}`")), "docs/fast-run.md lacks the key {key}");
    }
    let documented = tables.split('`').skip(1).step_by(2).filter(|word| !word.starts_with('-'));
    for key in documented {
        assert!(keys.iter().any(|known| *known == key), "the output lacks the key {key}");
    }
}

#[test]
fn the_examples_of_vehicles_can_be_read() {
    let page = page();
    let examples: Vec<&str> =
        page.split("```toml\n").skip(1).map(|rest| rest.split_once("```").unwrap().0).collect();
    let [own, changed] = examples[..] else { panic!("expected two examples, found {examples:?}") };
    let own = Vehicle::from_toml(own, "").unwrap();
    assert_eq!((own.name(), own.parameters().diagonal), ("my mouse", None));
    let changed = Vehicle::from_toml(changed, "changed").unwrap();
    let expert = Vehicle::expert();
    assert!(changed.parameters().along.top_speed > expert.parameters().along.top_speed);
    assert_eq!(changed.arc(TurnKind::V90), expert.arc(TurnKind::V90));
    let home = Home::new();
    home.write("my-mouse.toml", examples[0]);
    let ended = home.run(&["fast-run", "harbour", "--vehicle", "my-mouse.toml"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
}

/// Formats a number with at most two decimals.
fn number(number: f64) -> String {
    ((number * 100.0).round() / 100.0).to_string()
}

#[test]
fn the_table_of_presets_has_their_parameters() {
    let page = page();
    let presets = Vehicle::PRESETS.map(|name| Vehicle::preset(name).unwrap());
    let row = |name: &str, value: &dyn Fn(&Vehicle) -> Option<String>| {
        let values = presets.each_ref().map(|preset| value(preset).unwrap_or_else(|| "–".into()));
        let values = values.join(" | ");
        let start = format!("| {name}");
        let found = page
            .lines()
            .any(|line| line.starts_with(&start) && line.ends_with(&format!("| {values} |")));
        assert!(found, "docs/fast-run.md lacks {start} … | {values} |");
    };
    let line = |line: &StraightLimits| {
        format!("{}, {}", number(line.acceleration), number(line.top_speed))
    };
    row("in mm, s, mm/s and mm/s²", &|preset| Some(format!("`{}`", preset.name())));
    row("half a cell", &|preset| Some(number(preset.half_cell())));
    row("along", &|preset| Some(line(&preset.parameters().along)));
    row("diagonal", &|preset| preset.parameters().diagonal.as_ref().map(line));
    row("search", &|preset| {
        let VehicleParameters { search_speed, search_turn_time, .. } = preset.parameters();
        Some(format!("{}, {}", number(*search_speed), number(*search_turn_time)))
    });
    for kind in TurnKind::ALL {
        row(&format!("`{kind}`"), &|preset| {
            let arc = preset.parameters().turns.iter().find(|(other, _)| *other == kind)?.1;
            Some(format!("{}, {}", number(arc.length), number(arc.speed)))
        });
    }
}

#[test]
fn the_longest_arcs_are_the_longest_that_fit() {
    let page = page();
    let (_, table) = page.split_once("longest arc in a classic maze").unwrap();
    for kind in TurnKind::ALL {
        let row = table.lines().find(|line| line.starts_with(&format!("| `{kind}`"))).unwrap();
        let longest = row.rsplit('|').nth(1).unwrap();
        let longest: f64 = longest.trim().split(' ').next().unwrap().parse().unwrap();
        let expert = Vehicle::expert();
        let with_length = |length| {
            let mut parameters: VehicleParameters = expert.parameters().clone();
            let small = parameters.turns[0].1;
            parameters.turns.retain(|(other, _)| *other != kind);
            parameters.turns.push((kind, mmsim_fastrun::Arc { length, ..small }));
            Vehicle::new(parameters)
        };
        assert!(with_length(longest).is_ok(), "{kind}");
        assert!(with_length(longest + 0.1).is_err(), "{kind} of {} mm fits", longest + 0.1);
    }
}

/// Places in a maze: the distances to the east and to the north, in cells.
type Places = Vec<(f64, f64)>;

/// Returns the curve of a turn, and the south-west corners of the cells in which it is.
fn turn(kind: TurnKind) -> (Places, Places) {
    let vehicle = Vehicle::kerise();
    let fitted = vehicle.arc(kind).unwrap();
    // A long straight in which the mouse reaches the speed of the turn. On a diagonal, it can
    // turn to the left only.
    let name = format!("{kind}L@{}", fitted.arc.speed);
    let (text, index) = match kind {
        TurnKind::S90 => (format!("N 9 {name} 9"), 1),
        _ if kind.begins_diagonal() => (format!("N 8 45inR@412 8 {name} 9"), 3),
        _ => (format!("N 8 {name} 9"), 1),
    };
    let run = FastRun::parse(Cell::new(9, 0), &text).unwrap();
    let trajectory = run.drive(&vehicle).unwrap();
    let arc = &trajectory.segments()[index];
    let (from, length) =
        (arc.entry.distance - fitted.before, fitted.before + arc.length + fitted.after);
    let moments =
        (0..=40).map(|step| trajectory.at_distance(from + length * f64::from(step) / 40.0));
    let pitch = 2.0 * trajectory.half_cell();
    let (mut points, mut cells) = (Vec::new(), Vec::new());
    for moment in moments {
        points.push((moment.x / pitch, moment.y / pitch));
        // A mouse on a wall is in both cells.
        for share in [-0.01, 0.01] {
            let (sin, cos) = moment.heading.sin_cos();
            let cell = (
                (moment.x / pitch + share * cos).floor(),
                (moment.y / pitch + share * sin).floor(),
            );
            if !cells.contains(&cell) {
                cells.push(cell);
            }
        }
    }
    (points, cells)
}

#[test]
fn the_picture_of_turns_shows_the_curves() {
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 20.4 8.6\" width=\"816\" height=\"344\" \
         font-family=\"sans-serif\" font-size=\".5\" text-anchor=\"middle\" fill=\"#7b8794\">\n",
    );
    for (index, kind) in TurnKind::ALL.into_iter().enumerate() {
        let (points, cells) = turn(kind);
        let middle = |axis: &dyn Fn(&(f64, f64)) -> f64| {
            let values = cells.iter().map(axis);
            let least = values.clone().fold(f64::INFINITY, f64::min);
            f64::midpoint(least, values.fold(least, f64::max) + 1.0)
        };
        let (west, south) = (middle(&|cell| cell.0), middle(&|cell| cell.1));
        let (column, row) = if index < 5 { (index, 0) } else { (index - 5, 1) };
        let left = 2.0 + 4.0 * f64::from(u8::try_from(column).unwrap()) + 2.0 * f64::from(row);
        let top = 1.8 + 4.2 * f64::from(row);
        let place = |(x, y): (f64, f64)| (left + x - west, top - y + south);
        for &(x, y) in &cells {
            let (x, y) = place((x, y + 1.0));
            writeln!(
                svg,
                "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"1\" height=\"1\" fill-opacity=\".15\" \
                 stroke=\"#7b8794\" stroke-width=\".04\"/>"
            )
            .unwrap();
        }
        let places: Vec<_> = points.iter().map(|&point| place(point)).collect();
        let line: Vec<_> = places.iter().map(|(x, y)| format!("{x:.3} {y:.3}")).collect();
        writeln!(
            svg,
            "<path d=\"M{}\" fill=\"none\" stroke=\"#3b82f6\" stroke-width=\".1\"/>",
            line.join("L")
        )
        .unwrap();
        let ((x, y), (end_x, end_y)) = (places[0], places[places.len() - 1]);
        writeln!(
            svg,
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\".14\" fill=\"none\" stroke=\"#3b82f6\" stroke-width=\".07\"/>\n\
             <circle cx=\"{end_x:.2}\" cy=\"{end_y:.2}\" r=\".12\" fill=\"#3b82f6\"/>\n\
             <text x=\"{left:.2}\" y=\"{:.2}\">{kind}</text>",
            top + 2.1
        )
        .unwrap();
    }
    svg.push_str("</svg>\n");
    check_picture("turns.svg", svg.as_bytes());
}

#[test]
fn the_documentation_shows_a_table_and_exports() {
    let page = page();
    let home = Home::new();
    let vehicles = ["--vehicle", "ukmars", "--vehicle", "ares", "--vehicle", "expert"];
    let table = home.run(&[&["fast-run", "left bank"], &vehicles[..]].concat()).stdout;
    assert!(page.contains(&format!("```text\n{table}```\n")), "{table}");
    let export = |option| home.run(&["fast-run", "first steps", option, "-"]).stdout;
    for column in export("--csv").lines().next().unwrap().split(',') {
        assert!(page.contains(&format!("`{column}`")), "{column}");
    }
    let (_, array) = page.split_once("```c\n").unwrap();
    let (array, _) = array.split_once("```").unwrap();
    let found = home.run(&["fast-run", "first steps", "--c-array", "final.h"]);
    assert_eq!(found.code, Some(0));
    let header = fs::read_to_string(home.path().join("final.h")).unwrap();
    assert!(header.contains(array), "{array}");
}
