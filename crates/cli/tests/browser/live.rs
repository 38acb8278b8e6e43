//! What a client does is on the page at once.

use std::thread;

use mmsim_solvers::BundledStrategy;

use crate::browser::{wait_for, watch};
use crate::page::Panel;
use crate::simulator::{bundled, connect};
use crate::told::Told;

#[test]
fn a_search_at_full_speed_is_followed_to_its_last_state() {
    watch(&["--maze", "harbour"], |browser, simulator| {
        let maze = bundled("01-harbour.txt");
        let live = Panel::live(browser);
        live.wait_empty();

        // The command, as a client like any other.
        let solve = ["solve", "flood-fill", "--connect", &simulator.serving.address];
        assert_eq!(simulator.home.run(&solve).code, Some(0));
        live.wait_at(simulator.info().states - 1);

        // The same search, of which it is known what it tells.
        for strategy in [BundledStrategy::FloodFill, BundledStrategy::WeightIncrement] {
            let told = simulator.search(&maze, strategy);
            assert_eq!(simulator.info().states, told.len());
            live.wait_run_at(simulator.run(), told.len() - 1);
            live.assert_shows(&maze, &told);
            assert!(maze.goals().contains(told.last().unwrap().cell));
            assert_eq!(live.text(".steps dd"), (told.len() - 1).to_string());
        }
    });
}

#[test]
fn a_half_size_search_is_shown() {
    watch(&["--maze", "quarter"], |browser, simulator| {
        let maze = bundled("half-size-old-quarter.txt");
        let live = Panel::live(browser);
        live.wait_empty();
        let told = simulator.search(&maze, BundledStrategy::FloodFill);
        live.wait_at(told.len() - 1);
        live.assert_shows(&maze, &told);
    });
}

#[test]
fn many_states_at_once_lose_none_and_the_page_keeps_up() {
    const STATES: usize = 5000;
    watch(&["--maze", "steps"], |browser, simulator| {
        let maze = bundled("training-first-steps.txt");
        let told: Vec<_> = (0..STATES).map(|number| Told::of(number, maze.size())).collect();
        let live = Panel::live(browser);
        live.wait_empty();
        let mut seen = Vec::new();
        let address = simulator.serving.address.as_str();
        thread::scope(|scope| {
            let sending = scope.spawn(|| {
                let socket = connect(address);
                for told in &told {
                    socket.send(told.message('F', 'C'), 0).unwrap();
                    assert_eq!(socket.recv_bytes(0).unwrap(), b"ok");
                }
            });
            while !sending.is_finished() {
                seen.push(live.says("at").parse().unwrap_or(0));
            }
        });
        assert!(seen.is_sorted(), "{seen:?}");
        live.wait_at(STATES - 1);
        live.assert_shows(&maze, &told);
        assert_eq!(live.place(), "state 5,000 of 5,000");

        // Whoever looks at an earlier one is left there.
        browser.press("g1234\u{e007}".chars());
        live.wait_at(1233);
        let more = Told::of(STATES, maze.size());
        simulator.send(&more.message('C', 'C'));
        wait_for("one state more", || (live.place() == "state 1,234 of 5,001").then_some(()));
        live.assert_shows(&maze, &told[..1234]);
    });
}

#[test]
fn reset_empties_the_page_and_it_follows_the_new_run() {
    watch(&["--maze", "hedgerow"], |browser, simulator| {
        let maze = bundled("05-hedgerow.txt");
        let live = Panel::live(browser);
        live.wait_empty();
        for round in 0..3 {
            let told: Vec<_> =
                (0..10).map(|number| Told::of(100 * round + number, maze.size())).collect();
            for told in &told {
                simulator.send(&told.message('C', 'F'));
            }
            live.wait_at(9);
            live.assert_shows(&maze, &told);
            // From wherever it stands.
            if round == 1 {
                live.click("button[name=first]");
                live.wait_at(0);
            }
            simulator.send(b"reset");
            live.wait_empty();
            live.assert_shows(&maze, &[]);
            assert_eq!(live.place(), "no state yet");
            assert_eq!(live.text(".steps dd"), "–");
        }
    });
}
