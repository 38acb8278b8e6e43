//! Searching the list of mazes, and loading a maze from the list or from a file of the user.

use fantoccini::key::Key;
use mmsim_formats::Choice;
use mmsim_maze::Maze;
use mmsim_solvers::BundledStrategy;
use serde_json::json;

use crate::browser::{Browser, wait_for, with_browser, with_page};
use crate::harness::Home;
use crate::page::{Page, Panel};
use crate::simulator::{Simulator, bundled};
use crate::test_state::TestState;

const OPEN: &str = "o---o---o\n| S   G |\no---o---o\n";
const CLOSED: &str = "o---o---o\n| S | G |\no---o---o\n";
const SEARCH: &str = "#mazes input";

#[test]
fn the_search_matches_all_words_in_any_order_and_case() {
    with_browser(|browser| {
        let home = Home::new();
        for name in ["Japan/Final 2024.txt", "Japan/final 1999.txt", "taiwan/2024 half.txt"] {
            home.write(&format!("mazes/{name}"), OPEN);
        }
        home.write("mazes/closed 2024.txt", CLOSED);
        home.write("mazes/damaged.txt", "o---o\n| S \no---o\n");
        let simulator = Simulator::start_in(home, &["mazes"]);
        browser.open(&simulator.page);
        let page = Page(browser);
        let count = |count: usize| {
            wait_for(&format!("{count} mazes"), || {
                (page.maze_names().len() == count).then(|| page.maze_names())
            })
        };
        let all = count(5);
        assert_eq!(browser.text("#mazes .count"), "5");
        for (words, expected) in [
            ("2024", &["Final 2024", "2024 half", "closed 2024"][..]),
            ("fINAL", &["Final 2024", "final 1999"]),
            ("2024 japan", &["Final 2024"]),
            ("  JAPAN   2024  ", &["Final 2024"]),
            ("1999 2024", &[]),
            ("japan/f", &["Final 2024", "final 1999"]),
            ("unsolvable", &["closed 2024"]),
            ("", &["Final 2024", "final 1999", "2024 half", "closed 2024", "damaged"]),
        ] {
            browser.clear(SEARCH);
            browser.type_into(SEARCH, words);
            let mut found = count(expected.len());
            let mut expected = expected.to_vec();
            found.sort_unstable();
            expected.sort_unstable();
            assert_eq!(found, expected, "{words:?}");
            let count = browser.text("#mazes .count");
            let is_all = expected.len() == all.len();
            assert_eq!(count, if is_all { "5".into() } else { format!("{} of 5", expected.len()) });
        }

        let kind = |path: &str| -> String {
            let script = "return document.querySelector(arguments[0]).parentElement.dataset.kind";
            browser.run(script, &[Page::maze_selector(path).into()])
        };
        assert_eq!(kind("mazes/closed 2024.txt"), "unsolvable");
        assert_eq!(kind("mazes/damaged.txt"), "unreadable");
        assert_eq!(kind("mazes/taiwan/2024 half.txt"), "solvable");
        let shortest_path =
            |path: &str| browser.text(&format!("{} .path", Page::maze_selector(path)));
        assert_eq!(shortest_path("mazes/Japan/Final 2024.txt"), "1 step");
        assert_eq!(shortest_path("mazes/closed 2024.txt"), "unsolvable");
        assert_eq!(
            browser.text(&format!("{} .size", Page::maze_selector("mazes/closed 2024.txt"))),
            "2 × 1"
        );
        // Choosing an unreadable maze shows the reason.
        page.choose_maze("mazes/damaged.txt");
        wait_for("the error", || {
            browser.text("#error span").contains("line 2, column 5").then_some(())
        });
        assert_eq!(simulator.info().maze, "Final 2024");
        browser.leave();
    });
}

const LONG: &str = "o---o---o---o\n| S       G |\no---o---o---o\n";

/// Returns the visible headings and names in the list, each in a row of its own. Headings start
/// with `#`.
fn rows(browser: &Browser) -> Vec<String> {
    let script = "return [...document.querySelectorAll('#mazes h3, #mazes .name')]
        .filter((row) => row.checkVisibility())
        .map((row) => (row.matches('h3') ? '# ' : '') + row.textContent)";
    browser.run(script, &[])
}

#[test]
fn mazes_are_sorted_and_those_without_a_solution_come_last() {
    with_browser(|browser| {
        let home = Home::new();
        for (name, maze) in [
            ("b/maze 10.txt", OPEN),
            ("b/maze 9.txt", OPEN),
            ("b/c/long.txt", LONG),
            ("a/closed.txt", CLOSED),
            ("a/open.txt", OPEN),
            ("a/damaged.txt", "o---o\n| S \no---o\n"),
            ("loose.txt", OPEN),
        ] {
            home.write(&format!("mazes/{name}"), maze);
        }
        let simulator = Simulator::start_in(home, &["mazes"]);
        browser.open(&simulator.page);
        let last = ["# Goal unreachable", "closed", "# Unreadable", "damaged"];
        let wait_for_rows = |expected: &[&str]| {
            let expected = [expected, &last].concat();
            wait_for("the mazes", || (rows(browser).len() == expected.len()).then_some(()));
            assert_eq!(rows(browser), expected);
        };
        wait_for_rows(&["loose", "# a", "open", "# b", "maze 9", "maze 10", "# b/c", "long"]);
        let sort = |order: &str| {
            let script = "
                const list = document.querySelector('#mazes [name=sort]');
                list.value = arguments[0];
                list.dispatchEvent(new Event('change'));";
            browser.run::<()>(script, &[order.into()]);
        };
        sort("name");
        wait_for_rows(&["long", "loose", "maze 9", "maze 10", "open"]);
        assert_eq!(
            browser.text(&format!("{} .folder", Page::maze_selector("mazes/b/c/long.txt"))),
            "b/c"
        );
        sort("path");
        wait_for_rows(&["loose", "maze 9", "maze 10", "open", "long"]);
        sort("size");
        wait_for_rows(&["# 2 × 1", "loose", "maze 9", "maze 10", "open", "# 3 × 1", "long"]);
        // A search hides empty groups, and the arrow keys follow the order of the list.
        sort("folder");
        browser.type_into(SEARCH, "open");
        wait_for("the match", || (rows(browser) == ["# a", "open"]).then_some(()));
        browser.clear(SEARCH);
        browser.press([char::from(Key::Down), char::from(Key::Down), char::from(Key::Down)]);
        let focused = "return document.activeElement.querySelector('.name').textContent";
        assert_eq!(browser.run::<String>(focused, &[]), "maze 9");
        browser.leave();
    });
}

#[test]
fn loading_a_maze_asks_for_confirmation_if_there_are_states() {
    with_page(&["harbour"], |browser, simulator| {
        let (page, live) = (Page(browser), Panel::live(browser));
        let is_asking =
            || browser.run::<bool>("return document.querySelector('#confirm').open", &[]);
        let served = |path: &str| {
            wait_for(path, || {
                let current = format!("{}[aria-current=true]", Page::maze_selector(path));
                browser.exists(&current).then_some(())
            });
            live.wait_for_run(simulator.run_number());
            live.wait_until_empty();
            live.assert_shows(&bundled(path), &[]);
            assert_eq!(format!("{}.txt", simulator.info().maze), path);
        };
        live.wait_until_empty();
        served("01-harbour.txt");

        // Without states, no confirmation is needed.
        page.choose_maze("oblong-long-meadow.txt");
        served("oblong-long-meadow.txt");
        assert!(!is_asking());

        let meadow = bundled("oblong-long-meadow.txt");
        let states: Vec<_> = (0..3).map(|number| TestState::new(number, meadow.size())).collect();
        for state in &states {
            simulator.send(&state.message('F', 'F'));
        }
        live.wait_for_state(2);
        // Cancel with the button, then with Escape.
        for by_key in [false, true] {
            page.choose_maze("half-size-old-quarter.txt");
            wait_for("the dialog", || is_asking().then_some(()));
            assert_eq!(browser.text("#confirm .states"), "3 states");
            assert_eq!(browser.text("#confirm .name"), "half-size-old-quarter");
            if by_key {
                browser.press([char::from(Key::Escape)]);
            } else {
                browser.click("#confirm button[value='']");
            }
            wait_for("the dialog to close", || (!is_asking()).then_some(()));
            assert_eq!(
                (simulator.info().maze.as_str(), simulator.info().states),
                ("oblong-long-meadow", 3)
            );
            live.assert_shows(&meadow, &states);
        }
        // Confirm.
        page.choose_maze("half-size-old-quarter.txt");
        wait_for("the dialog", || is_asking().then_some(()));
        browser.click("#confirm button[value=confirm]");
        served("half-size-old-quarter.txt");
        assert_eq!(simulator.info().states, 0);

        // The new maze can be searched.
        let maze = bundled("half-size-old-quarter.txt");
        let states = simulator.search(&maze, BundledStrategy::FloodFill);
        live.wait_for_run_state(simulator.run_number(), states.len() - 1);
        live.assert_shows(&maze, &states);
    });
}

/// Drops files, given as pairs of a name and a text, on the page.
fn drop_files(browser: &Browser, files: &[(&str, &str)]) {
    let script = "
        const dataTransfer = new DataTransfer();
        for (const [name, text] of arguments[0]) dataTransfer.items.add(new File([text], name));
        document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));";
    browser.run::<()>(script, &[json!(files)]);
}

#[test]
fn a_dropped_maze_is_loaded() {
    with_page(&["harbour"], |browser, simulator| {
        let live = Panel::live(browser);
        let is_asking =
            || browser.run::<bool>("return document.querySelector('#confirm').open", &[]);
        let served = |name: &str, text: &str| {
            wait_for(name, || (simulator.info().maze == name).then_some(()));
            live.wait_for_run(simulator.run_number());
            live.wait_until_empty();
            live.assert_shows(&text.parse().unwrap(), &[]);
        };
        live.wait_until_empty();
        drop_files(browser, &[("long.v2.txt", &LONG.replace('o', "+"))]);
        served("long.v2", LONG);
        assert!(!browser.exists("#mazes [aria-current]"));

        // A file that is no maze changes nothing.
        drop_files(browser, &[("notes.txt", "no maze")]);
        browser.wait_for_text("#error span", "notes.txt: line 1, column 1: expected ");
        assert_eq!(simulator.info().maze, "long.v2");
        let errors = browser.take_errors();
        assert!(errors.len() == 1 && errors[0].message.contains("400 (Bad Request)"), "{errors:?}");

        // Loading deletes states only after confirmation.
        let size = LONG.parse::<Maze>().unwrap().size();
        simulator.send(&TestState::new(0, size).message('F', 'F'));
        live.wait_for_run_state(simulator.run_number(), 0);
        let file = simulator.home.write("closed.txt", CLOSED);
        browser.type_into("#recordings [name=file]", file.to_str().unwrap());
        wait_for("the dialog", || is_asking().then_some(()));
        assert_eq!(browser.text("#confirm .name"), "closed");
        assert_eq!(simulator.info().maze, "long.v2");
        browser.click("#confirm button[value=confirm]");
        served("closed", CLOSED);
    });
}

#[test]
fn the_user_chooses_between_the_readings_of_a_dropped_maze() {
    with_page(&["harbour"], |browser, simulator| {
        Panel::live(browser).wait_until_empty();
        let name = simulator.info().maze.clone();
        let digits = "b93\neee\n";
        let readings = Choice::default().read(digits.as_bytes()).unwrap_err().remove(0).readings;
        let is_asking =
            || browser.run::<bool>("return document.querySelector('#readings').open", &[]);
        let ask = || {
            drop_files(browser, &[("two.txt", digits)]);
            wait_for("the dialog", || is_asking().then_some(()));
        };
        ask();
        let script = "return [...document.querySelectorAll('#readings li')].map((item) =>
            `${item.querySelector('.name').textContent} ${item.querySelector('img').naturalWidth > 0}`)";
        wait_for("the pictures", || {
            let shown: Vec<String> = browser.run(script, &[]);
            let expected = readings.iter().map(|reading| format!("{} true", reading.encodings[0]));
            expected.eq(shown).then_some(())
        });
        browser.press([char::from(Key::Escape)]);
        wait_for("the dialog to close", || (!is_asking()).then_some(()));
        assert_eq!(simulator.info().maze, name);
        ask();
        browser.click("#readings li:nth-child(2) button");
        wait_for("the maze", || (simulator.info().maze == "two").then_some(()));
        Panel::live(browser).wait_for_run(simulator.run_number());
        Panel::live(browser).assert_shows(&readings[1].maze, &[]);
    });
}

#[test]
fn each_dropped_file_is_asked_about_in_turn() {
    with_page(&["harbour"], |browser, simulator| {
        let live = Panel::live(browser);
        live.wait_until_empty();
        let digits = "b93\neee\n";
        let readings = Choice::default().read(digits.as_bytes()).unwrap_err().remove(0).readings;
        for name in ["first.txt", "second.txt"] {
            drop_files(browser, &[(name, digits)]);
        }
        for (name, chosen) in [("first", 2), ("second", 1)] {
            browser.wait_for_text("#readings .name", name);
            browser.click(&format!("#readings li:nth-child({chosen}) button"));
            wait_for(name, || (simulator.info().maze == name).then_some(()));
            live.wait_for_run(simulator.run_number());
            live.assert_shows(&readings[chosen - 1].maze, &[]);
        }
    });
}
