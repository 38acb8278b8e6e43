//! The list of mazes: it filters, and choosing a maze serves it.

use fantoccini::key::Key;
use mmsim_solvers::BundledStrategy;

use crate::browser::{browse, wait_for, watch};
use crate::harness::Home;
use crate::page::{Page, Panel};
use crate::simulator::{Simulator, bundled};
use crate::told::Told;

const OPEN: &str = "o---o---o\n| S   G |\no---o---o\n";
const CLOSED: &str = "o---o---o\n| S | G |\no---o---o\n";
const SEARCH: &str = "#mazes input";

#[test]
fn the_list_filters_by_all_words_in_any_order_and_case() {
    browse(|browser| {
        let home = Home::new();
        for name in ["Japan/Final 2024.txt", "Japan/final 1999.txt", "taiwan/2024 half.txt"] {
            home.write(&format!("mazes/{name}"), OPEN);
        }
        home.write("mazes/closed 2024.txt", CLOSED);
        home.write("mazes/rubbish.txt", "rubbish");
        let simulator = Simulator::start_in(home, &["mazes"]);
        browser.open(&simulator.page);
        let page = Page(browser);
        let count = |count: usize| {
            wait_for(&format!("{count} mazes"), || {
                (page.mazes().len() == count).then(|| page.mazes())
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
            ("", &["Final 2024", "final 1999", "2024 half", "closed 2024", "rubbish"]),
        ] {
            // As a person does, without what stood there before.
            browser.clear(SEARCH);
            browser.type_into(SEARCH, words);
            let mut found = count(expected.len());
            let mut expected = expected.to_vec();
            found.sort_unstable();
            expected.sort_unstable();
            assert_eq!(found, expected, "{words:?}");
            let told = browser.text("#mazes .count");
            let is_all = expected.len() == all.len();
            assert_eq!(told, if is_all { "5".into() } else { format!("{} of 5", expected.len()) });
        }

        let kind = |path: &str| -> String {
            let script = "return document.querySelector(arguments[0]).parentElement.dataset.kind";
            browser.run(script, &[Page::maze(path).into()])
        };
        assert_eq!(kind("mazes/closed 2024.txt"), "unsolvable");
        assert_eq!(kind("mazes/rubbish.txt"), "unreadable");
        assert_eq!(kind("mazes/taiwan/2024 half.txt"), "solvable");
        let way = |path: &str| browser.text(&format!("{} .way", Page::maze(path)));
        assert_eq!(way("mazes/Japan/Final 2024.txt"), "path 1");
        assert_eq!(way("mazes/closed 2024.txt"), "unsolvable");
        assert_eq!(
            browser.text(&format!("{} .size", Page::maze("mazes/closed 2024.txt"))),
            "2 × 1"
        );
        // What cannot be read cannot be served, and why is said.
        page.choose_maze("mazes/rubbish.txt");
        wait_for("why", || {
            browser.text("#problem span").contains("line 1, column 1").then_some(())
        });
        assert_eq!(simulator.info().name, "Final 2024");
        browser.leave();
    });
}

#[test]
fn choosing_another_maze_asks_if_there_is_a_history_then_serves_and_shows_it() {
    watch(&["--maze", "harbour"], |browser, simulator| {
        let (page, live) = (Page(browser), Panel::live(browser));
        let is_asked =
            || browser.run::<bool>("return document.querySelector('#confirm').open", &[]);
        let served = |path: &str| {
            wait_for(path, || {
                let current = format!("{}[aria-current=true]", Page::maze(path));
                browser.is_there(&current).then_some(())
            });
            live.wait_run(simulator.run());
            live.wait_empty();
            live.assert_shows(&bundled(path), &[]);
            assert_eq!(format!("{}.txt", simulator.info().name), path);
        };
        live.wait_empty();
        served("01-harbour.txt");

        // Nothing is lost, so nothing is asked.
        page.choose_maze("oblong-long-meadow.txt");
        served("oblong-long-meadow.txt");
        assert!(!is_asked());

        let meadow = bundled("oblong-long-meadow.txt");
        let told: Vec<_> = (0..3).map(|number| Told::of(number, meadow.size())).collect();
        for told in &told {
            simulator.send(&told.message('F', 'F'));
        }
        live.wait_at(2);
        // No, by the button and by the key.
        for by_key in [false, true] {
            page.choose_maze("half-size-old-quarter.txt");
            wait_for("the question", || is_asked().then_some(()));
            assert_eq!(browser.text("#confirm .states"), "3 states");
            assert_eq!(browser.text("#confirm .name"), "half-size-old-quarter");
            if by_key {
                browser.press([char::from(Key::Escape)]);
            } else {
                browser.click("#confirm button[value='']");
            }
            wait_for("the end of it", || (!is_asked()).then_some(()));
            assert_eq!(
                (simulator.info().name.as_str(), simulator.info().states),
                ("oblong-long-meadow", 3)
            );
            live.assert_shows(&meadow, &told);
        }
        // Yes.
        page.choose_maze("half-size-old-quarter.txt");
        wait_for("the question", || is_asked().then_some(()));
        browser.click("#confirm button[value=serve]");
        served("half-size-old-quarter.txt");
        assert_eq!(simulator.info().states, 0);

        // And it goes on from there.
        let maze = bundled("half-size-old-quarter.txt");
        let told = simulator.search(&maze, BundledStrategy::FloodFill);
        live.wait_run_at(simulator.run(), told.len() - 1);
        live.assert_shows(&maze, &told);
    });
}
