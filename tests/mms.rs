//! Compares the commands and colours of mice for mms with those of mms itself.

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
