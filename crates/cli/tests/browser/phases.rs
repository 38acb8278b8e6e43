//! Checks the steps and turns of each phase, and what the page shows when a mouse is put back.

use fantoccini::key::Key;
use mmsim_fastrun::Vehicle;
use mmsim_maze::Cell;
use mmsim_solvers::BundledStrategy;

use crate::browser::{Browser, wait_for, with_page};
use crate::page::Panel;
use crate::simulator::bundled;
use crate::test_state::TestState;

/// Returns the steps, the turns and the time in a row of the table of phases.
fn row(browser: &Browser, live: Panel<'_>, run: &str) -> [String; 3] {
    let script = "return [...document.querySelectorAll(arguments[0])].map((it) => it.textContent)";
    browser.run(script, &[live.part(&format!(".phases .{run} td")).into()])
}

/// Asserts that the page shows the steps and turns of consecutive states of a mouse that moves one
/// cell at a time.
fn assert_run(browser: &Browser, live: Panel<'_>, run: &str, states: &[TestState]) {
    let shown = row(browser, live, run);
    if states.len() < 2 {
        assert_eq!(shown, ["–", "–", "–"], "{run}");
        return;
    }
    let turns = states.windows(2).map(|pair| {
        let [from, to] = [0, 1].map(|it: usize| "NESW".find(pair[it].heading).unwrap());
        from.abs_diff(to).min(4 - from.abs_diff(to))
    });
    let counts: [usize; 2] = [states.len() - 1, turns.sum()];
    assert_eq!(shown[..2], counts.map(|count| count.to_string()), "{run}");
    if run == "fast-run" {
        return assert!(shown[2].ends_with(" s"), "{}", shown[2]);
    }
    let [steps, turns] = counts.map(|count| u32::try_from(count).unwrap());
    let time = Vehicle::expert().search_time(steps, turns);
    assert_eq!(shown[2], format!("{time:.3} s"), "{run}");
}

fn go_to(browser: &Browser, live: Panel<'_>, at: usize) {
    browser.press(format!("g{at}\u{e007}").chars());
    live.wait_for_state(at);
}

#[test]
fn each_phase_has_its_steps_and_turns_at_every_state() {
    with_page(&["hedgerow"], |browser, simulator| {
        let maze = bundled("05-hedgerow.txt");
        let live = Panel::live(browser);
        live.wait_until_empty();
        let states = simulator.search(&maze, BundledStrategy::ShortestPathSearch);
        let last = states.len() - 1;
        live.wait_for_state(last);
        let is_goal = |state: &TestState| maze.goals().contains(state.cell);
        let goal = states.iter().position(is_goal).unwrap();
        let is_start = |state: &TestState| state.cell == Cell::new(0, 0);
        let start = states[goal..].iter().position(is_start).unwrap() + goal;
        assert!(is_goal(&states[last]) && goal > 60 && start > goal + 40 && last == start + 59);
        let sentences = [
            (goal - 1, "Searching for the goal. "),
            (goal, &format!("Goal found after {goal} steps. Unknown walls may hide a path of ")),
            (goal + 1, "Exploring on the return run. "),
            (start - 1, "Returning to the start. The path of 59 steps is proven to be shortest."),
            (start, "At the start, ready for a fast run. The path of 59 steps is proven "),
            (start + 1, "On the fast run. The path of 59 steps is proven to be shortest."),
            (
                last,
                "Fast run completed in 59 steps. The path of 59 steps is proven to be shortest.",
            ),
        ];
        for (at, sentence) in sentences {
            go_to(browser, live, at);
            let shown = live.text(".sentence");
            assert!(shown.starts_with(sentence), "{shown}");
        }
        for at in [last, goal - 1, goal, goal + 1, start, start + 1, last] {
            go_to(browser, live, at);
            assert_run(browser, live, "search-run", &states[..=at.min(goal)]);
            let returned = if at > goal { &states[goal..=at.min(start)] } else { &[] };
            assert_run(browser, live, "return-run", returned);
            let fast = if at > start { &states[start..=at] } else { &[] };
            assert_run(browser, live, "fast-run", fast);
            assert_eq!(live.text(".steps dd"), at.to_string());
            assert_eq!(live.text(".happened"), "");
        }
    });
}

#[test]
fn a_restart_makes_no_steps() {
    with_page(&["hedgerow"], |browser, simulator| {
        let size = bundled("05-hedgerow.txt").size();
        let live = Panel::live(browser);
        live.wait_until_empty();
        let state = |x: u8, y: u8, heading| TestState {
            cell: Cell::new(x, y),
            heading,
            ..TestState::new(0, size)
        };
        // The mouse is put back from (0, 3) and later appears in another cell.
        for (x, y, heading) in [
            (0, 0, 'N'),
            (0, 1, 'N'),
            (0, 3, 'N'),
            (0, 0, 'N'),
            (0, 1, 'N'),
            (9, 9, 'E'),
            (0, 0, 'N'),
        ] {
            simulator.send(&state(x, y, heading).message('C', 'C'));
        }
        live.wait_for_state(6);
        let shown = |at: usize, steps: &str, events: &str| {
            go_to(browser, live, at);
            assert_eq!(live.text(".steps dd"), steps);
            assert_eq!(row(browser, live, "search-run")[0], steps);
            assert_eq!(live.text(".happened"), events);
        };
        shown(2, "3", "");
        shown(3, "3", "Put back at the start in this state");
        wait_for("the announcement", || {
            live.text(".announcement").contains("put back at the start").then_some(())
        });
        shown(4, "4", "Put back at the start once");
        let goal = "Goal not reached: jumped from (0, 1) to (9, 9), which no movement can reach";
        shown(5, "4", &format!("Put back at the start once. Jumped to this cell. {goal}"));
        let events =
            "Put back at the start in this state (2 times so far). Jumped to another cell once";
        shown(6, "4", &format!("{events}. {goal}"));
    });
}

/// A mouse may mark a cell as visited before it reads the walls of the cell.
#[test]
fn walls_that_the_mouse_has_not_read_are_listed_as_unknown() {
    with_page(&["hedgerow"], |browser, simulator| {
        let maze = bundled("05-hedgerow.txt");
        let size = maze.size();
        let live = Panel::live(browser);
        live.wait_until_empty();
        // The mouse claims to have visited all cells, and reports only the outer walls.
        let all_visited = TestState {
            walls: vec![1; size.area()],
            cell: Cell::new(0, 0),
            heading: 'N',
            ..TestState::new(0, size)
        };
        assert_eq!(simulator.request(b"W\0\0N").len(), 3);
        simulator.send(&all_visited.message('C', 'C'));
        live.wait_for_state(0);
        let shown = |row: &str| live.text(&format!(".{row} dd"));
        assert_eq!((shown("optimistic").as_str(), shown("actual").as_str()), ("14", "59"));
        assert_eq!(shown("pessimistic"), "no path");
        assert_eq!(live.text(".proven"), "not proven");
        // The first arrow key moves from the cell of the mouse.
        let map = live.part(".map");
        browser.run::<()>("document.querySelector(arguments[0]).focus()", &[map.into()]);
        browser.press([char::from(Key::Up)]);
        let readout = wait_for("a cell", || {
            Some(live.text(".readout")).filter(|text| text.starts_with("cell (0, 1)"))
        });
        assert!(readout.ends_with("visited · unknown walls: north, east"), "{readout}");
    });
}
