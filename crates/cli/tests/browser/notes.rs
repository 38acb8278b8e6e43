//! The texts, colours, declared walls and names that a mouse displays.

use std::collections::BTreeMap;
use std::fs;
use std::process::{Command, Stdio};

use mmsim_drawing::Scene;
use mmsim_maze::{Cell, Heading, Maze, MazeSize, WallState};
use mmsim_protocol::{Annotation, AnnotationWriter, Colour, MAX_ANNOTATIONS_BYTES, StateMessage};
use mmsim_recording::Recording;
use mmsim_tests::MMS_COLOURS;
use serde_json::json;

use crate::browser::{wait_for, with_browser, with_page};
use crate::harness::{Home, recorded};
use crate::http;
use crate::page::Panel;
use crate::simulator::{Simulator, bundled};
use crate::test_state::TestState;

/// What is displayed in cells, by the name of the cell.
type Notes = BTreeMap<String, String>;

fn hex(letter: char) -> String {
    MMS_COLOURS.iter().find(|(known, _)| *known == letter).unwrap().1.to_string()
}

fn name(cell: Cell) -> String {
    format!("{},{}", cell.x, cell.y)
}

/// Functions that return what the page displays in cells.
const READ: &str = "
    const read = (selector, name) => Object.fromEntries([...document.querySelectorAll(selector)]
        .filter((element) => element.checkVisibility())
        .map((element) => [element.dataset.cell, element.getAttribute(name)]));
    const displayed = () => [read('.map .text', 'data-text'), read('.map .colour', 'fill')];";

/// Returns the texts and colours on the page in several states.
fn displayed_at(live: Panel<'_>, states: &[usize]) -> Vec<(Notes, Notes)> {
    let script = "
        const [panel, states, done] = arguments;
        const { dataset } = document.querySelector(panel);
        const slider = document.querySelector(`${panel} [name=slider]`);
        // Painting takes time, and is not tested here.
        document.querySelector(panel).style.visibility = 'hidden';
        (async () => {
            const all = [];
            for (const state of states) {
                slider.value = state;
                slider.dispatchEvent(new Event('input', { bubbles: true }));
                while (dataset.index !== `${state}`) {
                    await new Promise((next) => setTimeout(next));
                }
                all.push(displayed());
            }
            document.querySelector(panel).style.visibility = '';
            done(all);
        })();";
    let arguments = [json!(live.part("").trim_end()), json!(states)];
    live.browser.run_async(&format!("{READ} {script}"), &arguments)
}

/// Returns the texts and colours on the page. Asserts that they are drawn as in a picture, and that
/// no number is drawn below a text.
fn displayed(live: Panel<'_>, maze: &Maze) -> (Notes, Notes) {
    let browser = live.browser;
    let script = format!("{READ} return [...displayed(), read('.map .number', 'd')];");
    let [texts, colours, numbers]: [Notes; 3] = browser.run(&script, &[]);
    for (cell, text) in &texts {
        assert_eq!(numbers.get(cell).map_or("", String::as_str), "", "a number below {text}");
    }
    let colour = |fill: &String| {
        let (letter, _) = MMS_COLOURS.iter().find(|(_, hex)| hex == fill)?;
        Colour::from_letter(*letter)
    };
    let picture = Scene::from_maze(maze)
        .with_texts(|cell| texts.get(&name(cell)).map_or("", String::as_str))
        .with_colours(|cell| colours.get(&name(cell)).and_then(colour))
        .page_svg();
    let kinds = [r#"<path class="text"#, r#"<rect class="colour"#];
    let lines = picture.lines().filter(|line| kinds.iter().any(|kind| line.starts_with(kind)));
    let expected: String = lines.collect();
    let script = "
        const expected = new DOMParser().parseFromString(`<svg>${arguments[0]}</svg>`, 'text/xml');
        const read = (elements) => [...elements].map((element) =>
            [...element.attributes].map(({ name, value }) => `${name}=${value}`).sort().join(' ')).sort();
        return [read(expected.documentElement.children),
            read(document.querySelectorAll('.map .text, .map .colour'))];";
    let [expected, found]: [Vec<String>; 2] = browser.run(script, &[json!(expected)]);
    assert_eq!(found, expected);
    (texts, colours)
}

pub(crate) fn annotations(entries: &[Annotation<'_>]) -> Vec<u8> {
    let mut buffer = [0; MAX_ANNOTATIONS_BYTES];
    let mut writer = AnnotationWriter::new(&mut buffer);
    for entry in entries {
        writer.push(*entry).unwrap();
    }
    writer.finish().unwrap().to_vec()
}

/// Sends 30 states with texts of all lengths, all colours and log lines. Returns what is displayed at
/// each state.
pub(crate) fn send_notes(simulator: &Simulator, size: MazeSize) -> Vec<(Notes, Notes)> {
    let texts = ["0", "42", "2000", "start", "0123456789", "<&\"'>", "é ü", "ABCDEF", ""];
    let (mut shown, mut history) = ((Notes::new(), Notes::new()), Vec::new());
    for number in 0..30 {
        let cell = |step: usize| {
            let index = (number * 7 + step * 13) % size.area();
            size.cells().nth(index).unwrap()
        };
        let log = format!("line {number} of the mouse");
        let mut entries = vec![Annotation::Log(&log)];
        if number == 0 {
            entries.extend([Annotation::Mouse("Theseus"), Annotation::Strategy("thread")]);
        }
        match number {
            12 => {
                entries.push(Annotation::ClearTexts);
                shown.0.clear();
            }
            20 => {
                entries.push(Annotation::ClearColours);
                shown.1.clear();
            }
            _ => {}
        }
        for step in 0..3 {
            let (cell, text) = (cell(step), texts[(number + step) % texts.len()]);
            entries.push(Annotation::Text { cell, text });
            shown.0.insert(name(cell), text.to_string());
            let colour =
                Some(Colour::ALL[(3 * number + step) % Colour::ALL.len()]).filter(|_| step < 2);
            entries.push(Annotation::Colour { cell, colour });
            match colour {
                Some(colour) => shown.1.insert(name(cell), hex(colour.letter())),
                None => shown.1.remove(&name(cell)),
            };
        }
        shown.0.retain(|_, text| !text.is_empty());
        simulator.send(&annotations(&entries));
        simulator.send(&TestState::new(number, size).message('C', 'F'));
        history.push(shown.clone());
    }
    history
}

#[test]
fn every_text_and_colour_returns_when_scrubbing() {
    with_page(&["meadow"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let size = maze.size();
        let live = Panel::live(browser);
        let displayed = || displayed(live, &maze);
        live.wait_until_empty();
        let is_offered = |name: &str| -> bool {
            let script = "return document.querySelector(arguments[0]).checkVisibility()";
            browser.run(script, &[json!(live.part(name))])
        };
        assert!(!is_offered("[name=texts]") && !is_offered("[name=colours]"));
        let history = send_notes(simulator, size);
        live.wait_for_state(history.len() - 1);
        let assert_at = |index: usize| {
            let expected = &history[index];
            let (texts, colours) = displayed();
            assert_eq!((&texts, &colours), (&expected.0, &expected.1), "state {index}");
        };
        assert_at(history.len() - 1);
        for index in (0..history.len()).rev().chain([0, 29, 11, 12, 13, 19, 20, 5]) {
            live.slide_to(index);
            assert_at(index);
        }
        assert_eq!(live.text(".about-mouse"), "Theseus · thread");

        // The layers can be hidden. Without texts, the weights are shown.
        assert!(is_offered("[name=texts]") && is_offered("[name=colours]"));
        live.click("[name=texts]");
        live.click("[name=colours]");
        assert_eq!(displayed(), (Notes::new(), Notes::new()));
        let numbers = "return [...document.querySelectorAll('.map .number')].every((it) => it.getAttribute('d'))";
        assert!(browser.run::<bool>(numbers, &[]));
        // Saved pictures show the same.
        let saved = |page: &str| {
            let script = format!("
                document.querySelector('.export').dispatchEvent(new Event('pointerdown'));
                return document.querySelector(`.export [data-export='{page}']`).getAttribute('href')");
            let path: String = browser.run(&script, &[]);
            http::get(&simulator.url(&path)).text()
        };
        let bare = saved("picture.svg");
        assert!(!bare.contains("data-text") && !bare.contains("class=\"colour\""));
        live.click("[name=texts]");
        live.click("[name=colours]");
        assert_at(5);
        let full = saved("picture.svg");
        let (texts, colours) = &history[5];
        assert_eq!(full.matches("data-text").count(), texts.len());
        assert_eq!(full.matches("class=\"colour\"").count(), colours.len());
        // A new run displays nothing.
        simulator.send(b"reset");
        live.wait_for_run(simulator.run_number());
        live.wait_until_empty();
        assert_eq!(displayed(), (Notes::new(), Notes::new()));
        assert!(!is_offered("[name=texts]") && live.text(".about-mouse").is_empty());
    });
}

/// In mms, a cell without a text is empty.
#[test]
fn cells_without_texts_have_no_number() {
    with_page(&["meadow"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let live = Panel::live(browser);
        live.wait_until_empty();
        let mut state = TestState::new(0, maze.size());
        state.weights.fill(0);
        let mut entries = Vec::new();
        for (cell, text, weight) in [(Cell::new(1, 1), "12", 12), (Cell::new(2, 0), "0", 0)] {
            let index = state.index(cell);
            state.weights[index] = weight;
            entries.push(Annotation::Text { cell, text });
        }
        simulator.send(&annotations(&entries));
        simulator.send(&state.message('C', 'C'));
        live.wait_for_state(0);
        let numbers = || -> usize {
            let script = "return [...document.querySelectorAll('.map .number')]
                .filter((number) => number.getAttribute('d')).length";
            browser.run(script, &[])
        };
        assert_eq!((displayed(live, &maze).0.len(), numbers()), (2, 0));
        live.click("[name=heat]");
        let hot = "return document.querySelectorAll('.map .heat:not([fill=none])').length";
        assert_eq!(browser.run::<usize>(hot, &[]), 2);
        live.click("[name=texts]");
        assert_eq!((displayed(live, &maze).0.len(), numbers()), (0, maze.size().area()));
    });
}

#[test]
fn declared_walls_override_the_flags_of_the_state() {
    with_page(&["meadow"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let live = Panel::live(browser);
        live.wait_until_empty();
        let known = |cell: Cell, letter: char| {
            let wall = format!(r#"[data-wall="{},{letter}"]"#, name(cell));
            live.attribute(&wall, "class").ends_with("known")
        };
        let walls = |cell: Cell| {
            maze.walls().has(cell, Heading::North) && cell.y + 1 < maze.size().height()
        };
        let mut cells = maze.size().cells().filter(|&cell| walls(cell));
        let (declared, withdrawn) = (cells.next().unwrap(), cells.next().unwrap());
        let mut state = TestState::new(0, maze.size());
        state.walls.fill(0);
        let index = state.index(withdrawn);
        state.walls[index] = 1 | 16;
        simulator.send(&state.message('C', 'C'));
        live.wait_for_state(0);
        assert!(!known(declared, 'N') && known(withdrawn, 'N'));
        let wall =
            |cell, state| Annotation::Wall { cell, heading: Heading::North, state: Some(state) };
        let entries = [wall(declared, WallState::Present), wall(withdrawn, WallState::Unknown)];
        simulator.send(&annotations(&entries));
        simulator.send(&state.message('C', 'C'));
        live.wait_for_state(1);
        assert!(known(declared, 'N') && !known(withdrawn, 'N'));
        // A wall that exists is declared absent.
        simulator.send(&annotations(&[wall(declared, WallState::Absent)]));
        simulator.send(&state.message('C', 'C'));
        live.wait_for_state(2);
        let missed = format!(r#"[data-wall="{},N"]"#, name(declared));
        assert_eq!(live.attribute(&missed, "class"), "wall true missed");
        live.slide_to(0);
        assert!(!known(declared, 'N') && known(withdrawn, 'N'));
    });
}

/// Returns what a mouse displays after each of its movements, according to its commands.
fn interpreted(commands: &str) -> Vec<(Notes, Notes)> {
    let (mut shown, mut history) = ((Notes::new(), Notes::new()), Vec::new());
    for command in commands.lines() {
        match *command.splitn(4, ' ').collect::<Vec<_>>() {
            ["setText", x, y, text] => drop(shown.0.insert(format!("{x},{y}"), text.into())),
            ["setColor", x, y, letter] => {
                let letter = letter.chars().next().unwrap();
                shown.1.insert(format!("{x},{y}"), hex(letter));
            }
            ["clearAllText"] => shown.0.clear(),
            ["moveForward" | "turnRight" | "turnLeft"] => history.push(shown.clone()),
            ["mazeWidth" | "mazeHeight" | "wallFront" | "wallRight" | "wallLeft"]
            | ["setWall", ..] => {}
            ref other => panic!("{other:?}"),
        }
    }
    history
}

/// A mouse like the templates of mms looks on the page as it does in mms.
#[test]
fn a_mouse_of_mms_is_displayed() {
    let quiet = Stdio::null;
    let shell = "python3 --version && tee --version";
    let found = Command::new("sh").args(["-c", shell]).stdout(quiet()).stderr(quiet()).status();
    if !found.is_ok_and(|status| status.success()) {
        assert_ne!(std::env::var("MMSIM_CLIENTS").as_deref(), Ok("required"), "no python3 and tee");
        eprintln!("skipped, python3 or tee is missing");
        return;
    }
    with_browser(|browser| {
        let home = Home::new();
        home.write("template.py", include_str!("template.py"));
        let mouse = ["sh", "-c", "python3 template.py | tee commands"];
        let options = ["--maze", "harbour", "--stay", "--record", "runs"];
        let simulator = Simulator::start_mouse(home, &options, &mouse);
        browser.open(&simulator.page);
        let live = Panel::live(browser);
        wait_for("the mouse to exit", || {
            let is_open = browser.exists(&live.part(".run .phase"));
            (is_open && live.text(".run .phase") == "ended").then_some(())
        });
        let maze = bundled("01-harbour.txt");
        let commands = fs::read_to_string(simulator.home.path().join("commands")).unwrap();
        let mut expected = interpreted(&commands);
        // The first state precedes all commands.
        expected.insert(0, (Notes::new(), Notes::new()));
        let states = simulator.info().states;
        let recording = Recording::open(&recorded(&simulator.home.path().join("runs"))).unwrap();
        let pose = |index| {
            let state = recording.history().get(index).unwrap();
            StateMessage::new(&state, maze.size()).and_then(|state| state.pose()).unwrap()
        };
        // If the machine is busy, a change arrives in a further state before the next movement.
        let is_moved = |&index: &usize| index == 0 || pose(index - 1) != pose(index);
        let moved = (0..states).filter(|index| is_moved(index) || index + 1 == states);
        let moved: Vec<usize> = moved.collect();
        assert_eq!(moved.len(), expected.len());
        let numbers = expected.iter().flat_map(|(texts, _)| texts.values());
        assert!(numbers.clone().any(|text| text == "2000") && states > 200, "{states}");
        live.wait_for_state(states - 1);
        for ((&index, displayed), expected) in
            moved.iter().zip(displayed_at(live, &moved)).zip(&expected)
        {
            assert_eq!(displayed, *expected, "state {index}");
        }
        // The drawing of a state does not depend on other states.
        for (&index, expected) in moved.iter().zip(&expected).rev().step_by(7) {
            live.slide_to(index);
            assert_eq!(displayed(live, &maze), *expected, "state {index}");
        }
        browser.leave();
    });
}
