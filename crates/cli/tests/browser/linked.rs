//! Linked panels: moving one panel moves the others to the corresponding states.

use mmsim_maze::{Heading, Maze, Pose};
use mmsim_run::{MovementRules, Phases};
use mmsim_solvers::BundledStrategy;

use crate::browser::{Browser, wait_for, with_page};
use crate::page::Panel;
use crate::side_by_side::{send_states, with_two_panels};
use crate::simulator::bundled;
use crate::test_state::TestState;

fn link(browser: &Browser, kind: &str) {
    browser.click(&format!("#compare [value={kind}]"));
}

/// Returns the phases of each state of a search.
fn phases(maze: &Maze, states: &[TestState]) -> Vec<Phases> {
    let (rules, mut phases) = (MovementRules::from_maze(maze), Phases::default());
    let add = |state: &TestState| {
        let heading = Heading::from_letter(state.heading).unwrap();
        phases.add(&rules, Pose::new(state.cell, heading), false);
        phases
    };
    states.iter().map(add).collect()
}

#[test]
fn panels_move_to_the_same_state() {
    with_two_panels(40, 30, |simulator, live, recording| {
        let browser = live.browser;
        let wait_for_both = |live_at: usize, recording_at: usize| {
            live.wait_for_state(live_at);
            recording.wait_for_state(recording_at);
        };
        // Nothing moves before the user moves a panel.
        assert_eq!((live.data("index"), recording.data("index")), ("29".into(), "39".into()));
        recording.slide_to(7);
        wait_for_both(7, 7);
        live.slide_to(12);
        wait_for_both(12, 12);
        // The keys apply to the panel that the user clicked last.
        recording.click("h2");
        browser.press(['\u{e014}', '\u{e014}']);
        wait_for_both(14, 14);
        recording.click("button[name=follow]");
        wait_for_both(29, 39);
        // A running search goes on until it reaches the state.
        send_states(simulator, 130, 5);
        wait_for_both(34, 39);
        send_states(simulator, 135, 9);
        wait_for_both(39, 39);
        assert_eq!(live.position(), "State 39 of 43");
        browser.type_into(&recording.part("[name=jump]"), "3\u{e007}");
        wait_for_both(3, 3);
        recording.click("button[name=first]");
        wait_for_both(0, 0);
        recording.set_pace("×64");
        recording.click("button[name=play]");
        wait_for_both(39, 39);
        // While the live run is followed, the recording shows the same state.
        live.slide_to(2);
        wait_for_both(2, 2);
        simulator.send(b"reset");
        live.wait_until_empty();
        send_states(simulator, 0, 6);
        wait_for_both(5, 5);

        link(browser, "off");
        recording.slide_to(20);
        live.slide_to(1);
        recording.slide_to(21);
        wait_for_both(1, 21);
        // Linking moves the other panels to the state of the active panel.
        live.click("h2");
        link(browser, "state");
        wait_for_both(1, 1);
        recording.click("[name=close]");
        wait_for("the bar to disappear", || (!browser.is_visible("#compare")).then_some(()));
        live.slide_to(0);
    });
}

#[test]
fn panels_move_to_the_same_step_or_the_same_phase() {
    with_page(&["harbour", "--record", "kept"], |browser, simulator| {
        let maze = bundled("01-harbour.txt");
        let recorded = simulator.search(&maze, BundledStrategy::Swing);
        simulator.send(b"reset");
        // The live run has turns in place, so states and steps differ.
        let searched = simulator.search(&maze, BundledStrategy::ShortestPathSearch);
        let live_states: Vec<_> = searched.iter().flat_map(turned).collect();
        simulator.send(b"reset");
        for state in &live_states {
            simulator.send(&state.message('C', 'C'));
        }
        let recording = {
            let first = "#recordings [title$='_0001.mcap']";
            browser.wait_until_exists(first);
            browser.click(first);
            Panel { browser, source: "1" }
        };
        let live = Panel::live(browser);
        live.wait_for_state(live_states.len() - 1);
        recording.wait_for_state(recorded.len() - 1);
        let (here, there) = (phases(&maze, &live_states), phases(&maze, &recorded));
        let last = there.len() - 1;
        let count = live_states.len();
        let moments = [0, 9, count / 3, count / 2, count - 40, count - 1];

        link(browser, "step");
        for at in moments {
            live.slide_to(at);
            let steps = here[at].total.steps;
            let expected = there.iter().position(|phases| phases.total.steps >= steps);
            recording.wait_for_state(expected.unwrap_or(last));
        }
        link(browser, "phase");
        let mut legs = Vec::new();
        for at in moments {
            live.slide_to(at);
            let progress = here[at].leg();
            legs.push(progress.leg);
            // The last state that has come no further, or the first one with as many steps.
            let reached = there.iter().position(|phases| phases.leg() == progress);
            let before = there.iter().rposition(|phases| phases.leg() <= progress);
            recording.wait_for_state(reached.or(before).unwrap());
        }
        legs.dedup();
        // The turn in the goal begins a second return run, which the recording does not have.
        assert_eq!(legs, [0, 1, 2, 3]);
        // The recording moves the live run, too.
        recording.click("button[name=first]");
        recording.wait_for_state(0);
        live.wait_for_state(0);
    });
}

/// Returns the state and another one, in which the mouse has turned in place.
fn turned(state: &TestState) -> [TestState; 2] {
    let heading = match state.heading {
        'N' => 'E',
        'E' => 'S',
        'S' => 'W',
        _ => 'N',
    };
    [state.clone(), TestState { heading, ..state.clone() }]
}
