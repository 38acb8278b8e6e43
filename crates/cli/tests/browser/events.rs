//! The marks of the events of a run, between the chart and the slider.

use fantoccini::key::Key;
use mmsim_maze::Cell;
use mmsim_protocol::Annotation;
use mmsim_solvers::BundledStrategy;
use serde_json::json;

use crate::browser::{Browser, wait_for, with_page};
use crate::chart::chart_point;
use crate::notes::annotations;
use crate::page::Panel;
use crate::simulator::bundled;
use crate::test_state::TestState;

/// Returns the tooltip of each mark in the order of the states, and its position in pixels.
fn marks(live: Panel<'_>) -> Vec<(String, f64)> {
    let script = "
        return [...document.querySelectorAll(arguments[0])].map((mark) => {
            const { left, right } = mark.getBoundingClientRect();
            return [mark.title, (left + right) / 2];
        });";
    live.browser.run(script, &[json!(live.part(".marks button"))])
}

pub(crate) fn wait_for_marks(live: Panel<'_>, expected: &[String]) {
    let mut found = Vec::new();
    let names = || marks(live).into_iter().map(|(name, _)| name).collect::<Vec<_>>();
    wait_for(&format!("the marks {expected:?}"), || {
        found = names();
        (found == expected).then_some(())
    });
}

fn name(what: &str, at: usize) -> String {
    format!("{what}, state {at}")
}

fn press(browser: &Browser, live: Panel<'_>, key: char, at: usize) {
    browser.press([key]);
    live.wait_for_state(at);
}

#[test]
fn each_event_of_a_search_has_a_mark_at_its_state() {
    with_page(&["hedgerow"], |browser, simulator| {
        let maze = bundled("05-hedgerow.txt");
        let live = Panel::live(browser);
        live.wait_until_empty();
        let states = simulator.search(&maze, BundledStrategy::ShortestPathSearch);
        let last = states.len() - 1;
        live.wait_for_state(last);
        let goal = states.iter().position(|state| maze.goals().contains(state.cell)).unwrap();
        let is_start = |state: &TestState| state.cell == Cell::new(0, 0);
        let start = goal + states[goal..].iter().position(is_start).unwrap();
        // The strategy returns when it has proven the shortest path. A proof is not lost again.
        let (mut unproven, mut proven) = (0, last);
        while unproven + 1 < proven {
            let middle = usize::midpoint(unproven, proven);
            live.slide_to(middle);
            let is_proven = live.data("proven") == "true";
            *(if is_proven { &mut proven } else { &mut unproven }) = middle;
        }
        assert!(goal + 1 < proven && proven < start, "{goal} {proven} {start}");
        let events = [
            ("goal reached", goal),
            ("return run begins", goal + 1),
            ("shortest path proven", proven),
            ("fast run begins", start + 1),
            ("goal reached", last),
        ];
        let names = events.map(|(what, at)| name(what, at));
        wait_for_marks(live, &names);
        for ((_, x), (what, at)) in marks(live).into_iter().zip(events) {
            let expected = chart_point(live, at).0;
            assert!((x - expected).abs() < 1.0, "{what}: {x}, not {expected}");
        }

        live.slide_to(0);
        for (_, at) in events {
            press(browser, live, ']', at);
        }
        press(browser, live, ']', last);
        for (_, at) in events.iter().rev().skip(1) {
            press(browser, live, '[', *at);
        }
        wait_for("the announcement", || {
            live.text(".announcement").contains("goal reached").then_some(())
        });
        live.click(&format!(".marks [title='{}']", names[2]));
        live.wait_for_state(proven);

        // Events that would overlap share a mark. Each click shows another one.
        simulator.send_all(&[states[0].message('C', 'C'), states[last].message('C', 'C')]);
        let shared = format!(
            "{}\n{}",
            name("put back at the start", last + 1),
            name("jumped to another cell", last + 2)
        );
        let expected = [&names[..], std::slice::from_ref(&shared)].concat();
        wait_for_marks(live, &expected);
        for at in [last + 1, last + 2, last + 1] {
            live.click(".marks .several");
            live.wait_for_state(at);
        }
    });
}

#[test]
fn resets_jumps_wrong_walls_and_log_lines_have_marks() {
    with_page(&["hedgerow"], |browser, simulator| {
        let maze = bundled("05-hedgerow.txt");
        let live = Panel::live(browser);
        live.wait_until_empty();
        let state = |x: u8, y: u8, wrong: bool| {
            let mut walls = vec![0; maze.size().area()];
            // There is no wall between (0, 0) and (0, 1).
            walls[0] = if wrong { 16 } else { 0 };
            let cell = Cell::new(x, y);
            TestState { cell, heading: 'N', walls, ..TestState::new(0, maze.size()) }
        };
        let send = |at: usize, x, y, wrong| {
            if at.is_multiple_of(2) {
                simulator.send(&annotations(&[Annotation::Log("a line")]));
            }
            simulator.send(&state(x, y, wrong).message('C', 'C'));
        };
        for (at, (x, y, wrong)) in [
            (0, 0, false),
            (0, 1, false),
            (0, 2, true),
            (0, 3, true),
            (0, 0, false),
            (0, 1, true),
            (9, 9, true),
            (0, 0, true),
        ]
        .into_iter()
        .enumerate()
        {
            send(at, x, y, wrong);
        }
        live.wait_for_state(7);
        let log = |at: usize| name("log lines", at);
        wait_for_marks(
            live,
            &[
                log(0),
                name("another wrong wall", 2),
                log(2),
                name("put back at the start", 4),
                log(4),
                name("another wrong wall", 5),
                name("jumped to another cell", 6),
                log(6),
                name("put back at the start", 7),
            ],
        );
        live.slide_to(0);
        for at in [2, 4, 5, 6, 7] {
            press(browser, live, ']', at);
        }
        // With Shift, the keys also stop at log lines.
        live.slide_to(1);
        browser.press_with(Key::Shift, '[');
        live.wait_for_state(0);
        press(browser, live, '}', 2);

        // The legend and the list of shortcuts explain the marks.
        live.click("[name=legend]");
        let kinds =
            "return [...document.querySelectorAll(arguments[0])].filter((it) => !it.hidden).length";
        assert_eq!(browser.run::<usize>(kinds, &[json!(live.part(".legend [data-event]"))]), 8);
        assert!(browser.text("#keys dl").contains("Previous or next event"));

        simulator.send(b"reset");
        live.wait_for_run(simulator.run_number());
        wait_for_marks(live, &[]);
    });
}
