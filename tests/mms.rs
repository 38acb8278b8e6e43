//! Compares the commands and colours of mice for mms with those of mms itself.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use mmsim_drawing::Scene;
use mmsim_maze::{Cell, Colour, MazeSize};
use mmsim_mms::Command;
use mmsim_tests::{MMS_COLOURS, MMS_COMMANDS, MMS_REFUSED};

fn is_valid(line: &str) -> bool {
    Command::parse(line.as_bytes(), MazeSize::CLASSIC).is_ok()
}

#[test]
fn the_colours_are_those_of_mms() {
    let maze = mmsim_mazes::HARBOUR.parse().unwrap();
    let cell = Cell::new(0, 1);
    for letter in '\0'..='\u{7f}' {
        let rgb = MMS_COLOURS.iter().find(|(known, _)| *known == letter).map(|&(_, rgb)| rgb);
        let colour = Colour::from_letter(letter);
        assert_eq!(colour.is_some(), rgb.is_some(), "{letter:?}");
        assert_eq!(is_valid(&format!("setColor 0 1 {letter}")), rgb.is_some(), "{letter:?}");
        let svg = Scene::from_maze(&maze).with_colours(|at| colour.filter(|_| at == cell)).svg();
        let fill = rgb.map(|rgb| format!(r#"fill="{rgb}""#));
        assert!(fill.is_none_or(|fill| svg.contains(&fill)), "{letter:?}");
    }
    assert_eq!(Colour::ALL.map(Colour::letter), MMS_COLOURS.map(|(letter, _)| letter));
}

#[test]
fn the_commands_are_those_of_mms() {
    for line in MMS_COMMANDS {
        assert!(is_valid(line), "{line:?}");
    }
    for line in MMS_REFUSED {
        assert!(!is_valid(line), "{line:?}");
    }
}

fn read(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)).unwrap()
}

#[test]
fn documents_and_clients_list_all_commands_and_colours_of_mms() {
    let docs = read("docs/mms.md");
    let (_, commands) = docs.split_once("\n## Commands\n").unwrap();
    let rows = commands.lines().skip_while(|line| !line.starts_with('|')).skip(2);
    let rows: Vec<&str> = rows.take_while(|line| line.starts_with('|')).collect();
    let names = MMS_COMMANDS.iter().filter_map(|line| line.split(' ').next());
    let expected: BTreeSet<&str> = names.chain(["setColor"]).collect();
    let spans =
        rows.iter().flat_map(|row| row.split('|').nth(1).unwrap().split('`').skip(1).step_by(2));
    let listed: BTreeSet<&str> = spans.filter_map(|command| command.split(' ').next()).collect();
    assert_eq!(listed, expected);
    for (_, statistic) in MMS_COMMANDS.iter().filter_map(|line| line.split_once("getStat ")) {
        let row = rows.iter().find(|row| row.starts_with("| `getStat ")).unwrap();
        assert!(row.contains(&format!("`{statistic}`")), "{statistic}");
    }
    let letters = String::from_iter(MMS_COLOURS.map(|(letter, _)| letter));
    for name in ["docs/clients.md", "docs/mms.md", "examples/python/mmsim.py", "examples/c/mmsim.h"]
    {
        assert!(read(name).contains(&letters), "{name}");
    }
}
