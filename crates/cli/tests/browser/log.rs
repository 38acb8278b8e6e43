//! The log of a mouse.

use fantoccini::key::Key;
use mmsim_maze::{Cell, MazeSize};
use mmsim_protocol::Annotation;
use serde_json::json;

use crate::browser::{wait_for, with_page};
use crate::notes::{annotations, send_notes};
use crate::page::Panel;
use crate::simulator::{Simulator, bundled};
use crate::test_state::TestState;

/// Opens the page of a simulator without states, and runs a test. The maze has the given size.
fn with_empty_run(test: impl FnOnce(Panel<'_>, &Simulator, MazeSize)) {
    with_page(&["meadow"], |browser, simulator| {
        let live = Panel::live(browser);
        live.wait_until_empty();
        test(live, simulator, bundled("oblong-long-meadow.txt").size());
    });
}

/// Sends a state with one line of the log.
fn send_line(simulator: &Simulator, number: usize, size: MazeSize, line: &str) {
    simulator.send(&annotations(&[Annotation::Log(line)]));
    simulator.send(&TestState::new(number, size).message('C', 'F'));
}

/// A mouse often logs its result after its last state.
#[test]
fn lines_and_texts_after_the_last_state_are_shown_with_it() {
    with_empty_run(|live, simulator, size| {
        let wait_for_lines = |expected: [&str; 2]| {
            let script =
                "return [...document.querySelectorAll('.log li')].map((line) => line.textContent)";
            let lines = || live.browser.run::<Vec<String>>(script, &[]);
            wait_for(&format!("{expected:?}"), || (lines() == expected).then_some(()));
        };
        send_line(simulator, 0, size, "first");
        live.wait_for_state(0);
        let text = Annotation::Text { cell: Cell::new(0, 0), text: "end" };
        simulator.send(&annotations(&[Annotation::Log("RESULT"), text]));
        wait_for_lines(["0first", "0RESULT"]);
        let texts = || {
            live.browser.run::<bool>("return document.querySelector('.texts-layer').hidden", &[])
        };
        wait_for("the layer of texts", || (!texts()).then_some(()));
        // The line belongs to the next state if there is one.
        simulator.send(&TestState::new(1, size).message('C', 'F'));
        live.wait_for_state(1);
        wait_for_lines(["0first", "1RESULT"]);
    });
}

#[test]
fn the_log_follows_the_slider_and_can_be_searched() {
    with_empty_run(|live, simulator, size| {
        let browser = live.browser;
        // A run without log lines has no log.
        simulator.send(&TestState::new(0, size).message('C', 'C'));
        live.wait_for_state(0);
        let lines = || -> Vec<(String, bool)> {
            let script = "return [...document.querySelectorAll('.log li button')]
                .filter((line) => line.checkVisibility())
                .map((line) => [line.textContent, line.ariaCurrent === 'true'])";
            browser.run(script, &[])
        };
        let log = |number: usize| format!("{number}line {number} of the mouse");
        let wait_for_lines = |expected: &[usize], current: Option<usize>| {
            let expected: Vec<_> =
                expected.iter().map(|&number| (log(number), Some(number) == current)).collect();
            wait_for(&format!("{expected:?}"), || (lines() == expected).then_some(()));
        };
        wait_for_lines(&[], None);
        simulator.send(b"reset");
        live.wait_for_run(simulator.run_number());
        send_notes(simulator, size);
        live.wait_for_state(29);
        let all: Vec<usize> = (0..30).collect();
        wait_for_lines(&all, Some(29));
        live.slide_to(12);
        wait_for_lines(&all[..=12], Some(12));

        // A click shows the state of a line.
        live.click(".log li:nth-child(4) button");
        live.wait_for_state(3);
        wait_for_lines(&all[..=3], Some(3));

        // A search covers the whole run. Enter goes to the previous match, then starts again.
        browser.type_into(".log input", "LINE 2");
        let matches: Vec<usize> = [2].into_iter().chain(20..30).collect();
        wait_for_lines(&matches, Some(2));
        let enter = |expected: usize| {
            browser.press(['\u{e007}']);
            live.wait_for_state(expected);
            wait_for_lines(&matches, Some(expected));
        };
        enter(2);
        enter(29);
        enter(28);
        browser.type_into(".log input", "x");
        wait_for("no match", || (live.text(".log .empty") == "No line matches.").then_some(()));
        browser.clear(".log input");
        wait_for_lines(&all[..=28], Some(28));
        let fits = "return document.documentElement.scrollWidth <= innerWidth";
        assert!(browser.run::<bool>(fits, &[]), "the page does not scroll sideways");
    });
}

/// The log of a long run. Each state has one line.
#[test]
fn the_search_reaches_all_lines_of_a_long_log() {
    with_empty_run(|live, simulator, size| {
        let browser = live.browser;
        let send = |number: usize| {
            let odd = if number % 2 == 1 { "odd" } else { "even" };
            let line = format!("{odd} {number}{}", if number == 7 { " seven" } else { "" });
            send_line(simulator, number, size, &line);
        };
        (0..900).for_each(send);
        live.wait_for_state(899);
        let enter = '\u{e007}';
        // Enter directly after the text already uses the matches.
        browser.wait_until_exists(".log li");
        browser.type_into(".log input", &format!("seven{enter}"));
        live.wait_for_state(7);
        browser.clear(".log input");
        live.slide_to(899);
        browser.type_into(".log input", &format!("odd{enter}"));
        live.wait_for_state(897);
        let partial = "Only lines near the shown state are listed.";
        wait_for("the note", || (live.text(".log .partial") == partial).then_some(()));
        // The matches go on at both ends of the loaded lines, and after the last match.
        let next = || browser.press_with(Key::Shift, enter);
        for (from, expected) in [(500, 499), (1, 899), (101, 99), (700, 699)] {
            live.slide_to(from);
            browser.press([enter]);
            live.wait_for_state(expected);
        }
        for (from, expected) in [(0, 1), (899, 1), (400, 401), (100, 101)] {
            live.slide_to(from);
            next();
            live.wait_for_state(expected);
        }
        // Only the lines of new states are searched.
        live.click("[name=follow]");
        live.wait_for_state(899);
        let shown = |number: usize| {
            wait_for("the newest line", || {
                let script = "return document.querySelector('.log li:last-child')?.textContent";
                let newest: String = browser.run(script, &[]);
                newest.ends_with(&number.to_string()).then_some(())
            });
        };
        shown(899);
        browser.run::<()>("performance.clearResourceTimings()", &[]);
        send(900);
        send(901);
        shown(901);
        let script = "return performance.getEntriesByType('resource').map(({ name }) => name)
            .filter((name) => name.includes('/log?'))
            .map((name) => new URL(name).searchParams.get('from'))";
        let from: Vec<String> = browser.run(script, &[]);
        assert!(!from.is_empty() && from.iter().all(|from| from != "0"), "{from:?}");
    });
}

#[test]
fn a_long_log_scrolls_to_the_shown_state_after_a_click() {
    with_empty_run(|live, simulator, size| {
        let browser = live.browser;
        for number in 0..120 {
            send_line(simulator, number, size, &format!("line {number}"));
        }
        live.wait_for_state(119);
        let wait_for_line = |number: usize| {
            wait_for(&format!("line {number} in view"), || {
                let script = "
                    const line = document.querySelector('.log [aria-current]');
                    if (!line?.textContent.endsWith(` ${arguments[0]}`)) return false;
                    const [inner, outer] = [line, line.closest('ol')].map((it) => it.getBoundingClientRect());
                    return inner.top >= outer.top - 1 && inner.bottom <= outer.bottom + 1;";
                browser.run::<bool>(script, &[json!(number)]).then_some(())
            });
        };
        wait_for_line(119);
        live.click(".log li:nth-child(118) button");
        live.wait_for_state(117);
        wait_for_line(117);
        for number in [119, 60, 3, 80] {
            live.slide_to(number);
            wait_for_line(number);
        }
        let focused = "return document.activeElement.closest('.log li') !== null";
        assert!(browser.run::<bool>(focused, &[]), "the log keeps the focus");
    });
}
