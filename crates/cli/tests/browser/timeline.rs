//! Checks that the player controls show each state exactly as the client sent it.

use fantoccini::key::Key;
use serde_json::json;

use crate::browser::{wait_for, with_page};
use crate::clock::Clock;
use crate::page::Panel;
use crate::simulator::{Simulator, bundled};
use crate::test_state::TestState;

const STATES: usize = 40;

/// Sends `STATES` different states for a maze that is not square.
fn history(simulator: &Simulator) -> Vec<TestState> {
    let size = bundled("oblong-long-meadow.txt").size();
    let states: Vec<_> = (0..STATES).map(|number| TestState::new(number, size)).collect();
    for (number, state) in states.iter().enumerate() {
        let orders = [('C', 'C'), ('C', 'F'), ('F', 'C'), ('F', 'F')][number % 4];
        simulator.send(&state.message(orders.0, orders.1));
    }
    states
}

#[test]
fn each_state_is_shown_as_it_was_sent() {
    with_page(&["meadow"], |browser, simulator| {
        let states = history(simulator);
        let maze = bundled("oblong-long-meadow.txt");
        let live = Panel::live(browser);
        let assert_at = |at: usize| {
            live.wait_for_state(at);
            live.assert_shows(&maze, &states[..=at]);
            assert_eq!(live.position(), format!("State {at} of {}", STATES - 1));
        };
        assert_at(STATES - 1);
        for at in [0, 1, 38, 2, 17, 3, 16, 39] {
            live.slide_to(at);
            assert_at(at);
            assert_eq!(live.data("following"), "false");
        }

        // A click in the middle of the slider.
        live.click("[name=slider]");
        let at = wait_for("the middle", || {
            live.data("index").parse().ok().filter(|at| (15..25).contains(at))
        });
        assert_at(at);

        live.click("button[name=first]");
        assert_at(0);
        live.click("button[name=next]");
        live.click("button[name=next]");
        assert_at(2);
        live.click("button[name=previous]");
        assert_at(1);
        live.click("button[name=follow]");
        assert_at(39);
        assert_eq!(live.data("following"), "true");

        for (text, at) in [("17", 17), ("0", 0), ("39", 39), ("40", 39), ("999999999999", 39)] {
            browser
                .type_into(&live.part("[name=jump]"), &format!("{text}{}", char::from(Key::Enter)));
            assert_at(at);
        }
    });
}

#[test]
fn keys_step_through_the_history() {
    with_page(&["meadow"], |browser, simulator| {
        history(simulator);
        let live = Panel::live(browser);
        live.wait_for_state(39);
        let press = |keys: &[Key], at: usize| {
            browser.press(keys.iter().copied().map(char::from));
            live.wait_for_state(at);
        };
        press(&[Key::Home], 0);
        press(&[Key::Right, Key::Right, Key::Right], 3);
        press(&[Key::Left], 2);
        press(&[Key::Left, Key::Left, Key::Left], 0);
        press(&[Key::End], 39);
        assert_eq!(live.data("following"), "true");
        press(&[Key::Right], 39);
        browser.press_with(Key::Shift, char::from(Key::Left));
        live.wait_for_state(29);
        browser.press_with(Key::Shift, char::from(Key::Right));
        live.wait_for_state(39);
        // `g` moves the focus to the field.
        browser.press("g7".chars().chain([char::from(Key::Enter)]));
        live.wait_for_state(7);
        // With the focus on the slider, each key takes effect only once.
        browser.run::<()>(
            "document.querySelector(arguments[0]).focus()",
            &[json!(live.part("[name=slider]"))],
        );
        press(&[Key::Right], 8);
        press(&[Key::Home], 0);
        press(&[Key::Right, Key::Right], 2);
        press(&[Key::End], 39);
        press(&[Key::Left], 38);
    });
}

#[test]
fn playing_continues_to_the_newest_state() {
    with_page(&["meadow"], |browser, simulator| {
        let states = history(simulator);
        let live = Panel::live(browser);
        live.wait_for_state(39);
        let is_playing = || live.attribute("button[name=play]", "aria-pressed") == "true";
        // 20 states per second.
        live.set_pace("×1");
        let clock = Clock::stop(browser);
        live.click("button[name=play]");
        clock.advance(0);
        live.wait_for_state(0);
        for at in 1..39 {
            clock.advance(51);
            live.wait_for_state(at);
            assert!(is_playing());
        }
        clock.advance(51);
        live.wait_for_state(39);
        assert!(!is_playing());
        assert_eq!(live.data("following"), "true", "new states are followed");
        live.assert_shows(&bundled("oblong-long-meadow.txt"), &states);

        // Play with the keyboard, with a pause. While the pace slider has the focus, keys change the
        // pace.
        browser.run::<()>("document.activeElement.blur()", &[]);
        browser.press([char::from(Key::Home)]);
        clock.advance(0);
        live.wait_for_state(0);
        browser.press([' ']);
        clock.advance(0);
        clock.advance(201);
        live.wait_for_state(4);
        assert!(is_playing());
        browser.press([' ']);
        assert!(!is_playing());
        clock.advance(10_000);
        assert_eq!(live.data("index"), "4");
        browser.press([' ']);
        clock.advance(0);
        clock.advance(51);
        live.wait_for_state(5);
    });
}
