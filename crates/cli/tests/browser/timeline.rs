//! The history under the slider: state N is shown exactly as it was sent.

use std::thread;
use std::time::Duration;

use fantoccini::key::Key;
use serde_json::json;

use crate::browser::{Browser, wait_for, watch};
use crate::page::Panel;
use crate::simulator::{Simulator, bundled};
use crate::told::Told;

const STATES: usize = 40;

/// A maze that is no square, with a history of states of which no two are alike.
fn history(simulator: &Simulator) -> Vec<Told> {
    let size = bundled("oblong-long-meadow.txt").size();
    let told: Vec<_> = (0..STATES).map(|number| Told::of(number, size)).collect();
    for (number, told) in told.iter().enumerate() {
        let orders = [('C', 'C'), ('C', 'F'), ('F', 'C'), ('F', 'F')][number % 4];
        simulator.send(&told.message(orders.0, orders.1));
    }
    told
}

/// Moves the slider as a hand does.
fn slide(browser: &Browser, live: Panel<'_>, to: usize) {
    let script = "
        const slider = document.querySelector(arguments[0]);
        slider.value = arguments[1];
        slider.dispatchEvent(new Event('input', { bubbles: true }));";
    browser.run::<()>(script, &[json!(live.part("[name=slider]")), json!(to)]);
}

#[test]
fn each_state_is_shown_as_it_was_sent() {
    watch(&["--maze", "meadow"], |browser, simulator| {
        let told = history(simulator);
        let maze = bundled("oblong-long-meadow.txt");
        let live = Panel::live(browser);
        let assert_at = |at: usize| {
            live.wait_at(at);
            live.assert_shows(&maze, &told[..=at]);
            assert_eq!(live.place(), format!("state {} of {STATES}", at + 1));
        };
        assert_at(STATES - 1);
        for at in [0, 1, 38, 2, 17, 3, 16, 39] {
            slide(browser, live, at);
            assert_at(at);
            assert_eq!(live.says("following"), "false");
        }

        // A click on it, at its middle.
        live.click("[name=slider]");
        let at = wait_for("the middle", || {
            live.says("at").parse().ok().filter(|at| (15..25).contains(at))
        });
        assert_at(at);

        live.click("button[name=first]");
        assert_at(0);
        live.click("button[name=on]");
        live.click("button[name=on]");
        assert_at(2);
        live.click("button[name=back]");
        assert_at(1);
        live.click("button[name=follow]");
        assert_at(39);
        assert_eq!(live.says("following"), "true");

        for (text, at) in [("18", 17), ("1", 0), ("40", 39), ("41", 39), ("999999999999", 39)] {
            browser
                .type_into(&live.part("[name=jump]"), &format!("{text}{}", char::from(Key::Enter)));
            assert_at(at);
        }
    });
}

#[test]
fn keys_go_through_the_history() {
    watch(&["--maze", "meadow"], |browser, simulator| {
        history(simulator);
        let live = Panel::live(browser);
        live.wait_at(39);
        let press = |keys: &[Key], at: usize| {
            browser.press(keys.iter().copied().map(char::from));
            live.wait_at(at);
        };
        press(&[Key::Home], 0);
        press(&[Key::Right, Key::Right, Key::Right], 3);
        press(&[Key::Left], 2);
        press(&[Key::Left, Key::Left, Key::Left], 0);
        press(&[Key::End], 39);
        assert_eq!(live.says("following"), "true");
        press(&[Key::Right], 39);
        browser.press_with(Key::Shift, char::from(Key::Left));
        live.wait_at(29);
        browser.press_with(Key::Shift, char::from(Key::Right));
        live.wait_at(39);
        // To the field, and back to the map's keys.
        browser.press("g7".chars().chain([char::from(Key::Enter)]));
        live.wait_at(6);
        // The same with the focus on the slider, where each key must go one step only.
        browser.run::<()>(
            "document.querySelector(arguments[0]).focus()",
            &[json!(live.part("[name=slider]"))],
        );
        press(&[Key::Right], 7);
        press(&[Key::Home], 0);
        press(&[Key::Right, Key::Right], 2);
        press(&[Key::End], 39);
        press(&[Key::Left], 38);
    });
}

/// Notes which states are shown from now on.
fn note(browser: &Browser) {
    let script = r#"
        const panel = document.querySelector('.panel[data-source="live"]');
        window.noted = [];
        new MutationObserver(() => window.noted.push(Number(panel.dataset.at)))
            .observe(panel, { attributeFilter: ["data-at"] });"#;
    browser.run::<()>(script, &[]);
}

#[test]
fn playing_goes_on_to_the_newest_state() {
    watch(&["--maze", "meadow"], |browser, simulator| {
        let told = history(simulator);
        let live = Panel::live(browser);
        live.wait_at(39);
        let is_playing = || live.says_of("button[name=play]", "aria-pressed") == "true";
        live.choose("[name=speed]", "60");
        note(browser);
        live.click("button[name=play]");
        wait_for("the end", || (!is_playing() && live.says("at") == "39").then_some(()));
        assert_eq!(live.says("following"), "true", "what comes next will be seen");
        let mut noted: Vec<usize> = browser.run("return window.noted", &[]);
        noted.dedup();
        assert!(noted.is_sorted() && noted.first() <= Some(&2) && noted.len() > 8, "{noted:?}");
        live.assert_shows(&bundled("oblong-long-meadow.txt"), &told);

        // With a key, and in between.
        live.choose("[name=speed]", "20");
        // In the list of speeds, keys choose a speed.
        browser.run::<()>("document.activeElement.blur()", &[]);
        browser.press([char::from(Key::Home)]);
        live.wait_at(0);
        browser.press([' ']);
        wait_for("some states", || (live.says("at").parse::<usize>().unwrap() > 3).then_some(()));
        assert!(is_playing());
        browser.press([' ']);
        assert!(!is_playing());
        // What was asked for already is still drawn; then four states would pass in this time.
        let paused = wait_for("the pause", || {
            let at = live.says("at");
            thread::sleep(Duration::from_millis(200));
            (live.says("at") == at).then_some(at)
        });
        assert!(paused != "39");
    });
}
