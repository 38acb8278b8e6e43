//! Checks that the live panel follows the states that clients send.

use std::thread;

use mmsim_solvers::BundledStrategy;

use crate::browser::{wait_for, with_page};
use crate::page::Panel;
use crate::simulator::{bundled, connect};
use crate::test_state::TestState;

#[test]
fn a_search_at_full_speed_is_followed_to_its_last_state() {
    with_page(&["harbour"], |browser, simulator| {
        let maze = bundled("01-harbour.txt");
        let live = Panel::live(browser);
        live.wait_until_empty();

        // First, `mmsim solve` is the client.
        let solve = ["solve", "flood-fill", "--connect", &simulator.serving.address];
        assert_eq!(simulator.home.run(&solve).code, Some(0));
        live.wait_for_state(simulator.info().states - 1);

        // Then the test itself searches, so that the states are known.
        for strategy in [BundledStrategy::FloodFill, BundledStrategy::WeightIncrement] {
            let states = simulator.search(&maze, strategy);
            assert_eq!(simulator.info().states, states.len());
            live.wait_for_run_state(simulator.run_number(), states.len() - 1);
            live.assert_shows(&maze, &states);
            assert!(maze.goals().contains(states.last().unwrap().cell));
            assert_eq!(live.text(".steps dd"), (states.len() - 1).to_string());
        }
    });
}

#[test]
fn a_half_size_search_is_shown() {
    with_page(&["quarter"], |browser, simulator| {
        let maze = bundled("half-size-old-quarter.txt");
        let live = Panel::live(browser);
        live.wait_until_empty();
        let states = simulator.search(&maze, BundledStrategy::FloodFill);
        live.wait_for_state(states.len() - 1);
        live.assert_shows(&maze, &states);
    });
}

#[test]
fn the_page_keeps_up_with_many_states() {
    const STATES: usize = 5000;
    with_page(&["steps"], |browser, simulator| {
        let maze = bundled("training-first-steps.txt");
        let states: Vec<_> =
            (0..STATES).map(|number| TestState::new(number, maze.size())).collect();
        let live = Panel::live(browser);
        live.wait_until_empty();
        let mut seen = Vec::new();
        let address = simulator.serving.address.as_str();
        thread::scope(|scope| {
            let sending = scope.spawn(|| {
                let socket = connect(address);
                for state in &states {
                    socket.send(state.message('F', 'C'), 0).unwrap();
                    assert_eq!(socket.recv_bytes(0).unwrap(), b"ok");
                }
            });
            while !sending.is_finished() {
                seen.push(live.data("index").parse().unwrap_or(0));
            }
        });
        assert!(seen.is_sorted(), "{seen:?}");
        live.wait_for_state(STATES - 1);
        live.assert_shows(&maze, &states);
        assert_eq!(live.position(), "State 4,999 of 4,999");

        // A page that shows an earlier state stays there.
        browser.press("g1233\u{e007}".chars());
        live.wait_for_state(1233);
        let more = TestState::new(STATES, maze.size());
        simulator.send(&more.message('C', 'C'));
        wait_for("one more state", || (live.position() == "State 1,233 of 5,000").then_some(()));
        live.assert_shows(&maze, &states[..1234]);
    });
}

#[test]
fn reset_empties_the_page_and_it_follows_the_new_run() {
    with_page(&["hedgerow"], |browser, simulator| {
        let maze = bundled("05-hedgerow.txt");
        let live = Panel::live(browser);
        live.wait_until_empty();
        for round in 0..3 {
            let states: Vec<_> =
                (0..10).map(|number| TestState::new(100 * round + number, maze.size())).collect();
            for state in &states {
                simulator.send(&state.message('C', 'F'));
            }
            live.wait_for_state(9);
            live.assert_shows(&maze, &states);
            if round == 1 {
                live.click("button[name=first]");
                live.wait_for_state(0);
            }
            simulator.send(b"reset");
            live.wait_until_empty();
            live.assert_shows(&maze, &[]);
            assert_eq!(live.position(), "No states yet");
            assert_eq!(live.text(".steps dd"), "–");
        }
    });
}
