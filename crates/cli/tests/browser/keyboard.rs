//! Everything with the keyboard alone, and the focus is seen wherever it is.

use std::collections::BTreeSet;

use fantoccini::key::Key;
use serde::Deserialize;
use serde_json::json;

use crate::browser::{Browser, wait_for, watch};
use crate::page::{Page, Panel};
use crate::simulator::bundled;
use crate::told::Told;

/// Where the focus is.
#[derive(Debug, Deserialize)]
struct Stop {
    /// The number of the element among all that can have the focus, none for the page itself.
    number: Option<usize>,
    name: String,
    /// Whether it looks otherwise than without the focus.
    is_seen: bool,
}

/// Numbers all elements that a person can see and that can do something.
fn number_all(browser: &Browser) -> Vec<String> {
    let script = "
        const seen = (element) => element.checkVisibility({ checkVisibilityCSS: true, checkOpacity: false });
        const able = 'a[href], button, input, select, textarea, summary, [tabindex]';
        window.able = [...document.querySelectorAll(able)].filter((element) =>
            !element.disabled && element.tabIndex >= 0 && (seen(element) || element.type === 'file'));
        window.nameOf = (element) => `${element.tagName} ${element.name || element.id || element.className
            || element.dataset.export} ${element.closest('section')?.id || ''}`.trim();
        return window.able.map(window.nameOf);";
    browser.run(script, &[])
}

/// The look of the focused element and of what holds it, with and without the focus.
fn stop(browser: &Browser) -> Stop {
    let script = "
        const element = document.activeElement;
        const look = () => {
            let looks = '';
            for (let at = element, depth = 0; at && depth < 3; at = at.parentElement, depth++) {
                const { outlineStyle, outlineWidth, outlineColor, boxShadow, borderColor } = getComputedStyle(at);
                looks += [outlineStyle, outlineStyle === 'none' ? '' : outlineWidth + outlineColor,
                    boxShadow, borderColor].join(' ') + '; ';
            }
            return looks;
        };
        const number = window.able.indexOf(element);
        if (number < 0) return { number: null, name: window.nameOf(element), is_seen: true };
        const focused = look();
        element.blur();
        const blurred = look();
        element.focus({ focusVisible: true });
        return { number, name: window.nameOf(element), is_seen: focused !== blurred };";
    browser.run(script, &[])
}

#[test]
fn tab_reaches_everything_and_the_focus_is_seen() {
    watch(&["--maze", "meadow"], |browser, simulator| {
        let size = bundled("oblong-long-meadow.txt").size();
        for number in 0..5 {
            simulator.send(&Told::of(number, size).message('C', 'C'));
        }
        let live = Panel::live(browser);
        live.wait_at(4);
        // In the middle of the history, where every button does something.
        live.click("button[name=back]");
        live.wait_at(3);
        wait_for("the exports", || {
            (live.says_of("[data-export='picture.svg']", "href") != "none").then_some(())
        });
        browser.run::<()>("document.activeElement.blur()", &[]);
        let all = number_all(browser);
        assert!(all.len() > 20, "{all:?}");
        let (mut reached, mut order) = (BTreeSet::new(), Vec::new());
        // Once round, from the top of the page to the top of the page.
        browser.run::<()>("window.getSelection().collapse(document.body, 0)", &[]);
        for _ in 0..=all.len() + 3 {
            browser.press([char::from(Key::Tab)]);
            let stop = stop(browser);
            assert!(stop.is_seen, "nothing shows that the focus is on {}", stop.name);
            order.extend(stop.number);
            reached.extend(stop.number);
        }
        let missed: Vec<_> =
            (0..all.len()).filter(|number| !reached.contains(number)).map(|n| &all[n]).collect();
        assert!(missed.is_empty(), "Tab does not reach {missed:?}");
        // In the order in which they stand there, from wherever it began.
        let turns = order.windows(2).filter(|pair| pair[1] < pair[0]).count();
        assert!(turns <= 1, "{order:?}");
        // And back.
        let before = stop(browser).number;
        browser.press_with(Key::Shift, char::from(Key::Tab));
        assert_ne!(stop(browser).number, before);
    });
}

#[test]
fn a_whole_visit_needs_no_mouse_but_the_one_in_the_maze() {
    watch(&["--maze", "harbour"], |browser, simulator| {
        let live = Panel::live(browser);
        let key = |key: Key| browser.press([char::from(key)]);
        let focus = |selector: &str| {
            // As often as it takes.
            wait_for(selector, || {
                key(Key::Tab);
                let script = "return document.activeElement.matches(arguments[0])";
                browser.run::<bool>(script, &[json!(selector)]).then_some(())
            });
        };
        live.wait_empty();
        wait_for("the list", || browser.is_there(&Page::maze("05-hedgerow.txt")).then_some(()));

        // Another maze: the only one that has these words.
        browser.press("/hedge".chars());
        key(Key::Down);
        key(Key::Enter);
        wait_for("hedgerow", || (simulator.info().name == "05-hedgerow").then_some(()));
        live.wait_empty();

        // A search.
        focus("[name=strategy]");
        browser.press("left".chars());
        focus("[name=pace]");
        key(Key::Home);
        focus("[name=run]");
        key(Key::Enter);
        wait_for("the goal", || live.text(".run .says").contains("goal reached").then_some(()));
        assert!(live.text(".run .says").starts_with("left-wall"));
        let last = simulator.info().states - 1;
        live.wait_run_at(simulator.run(), last);

        // Its history, from wherever the focus is now.
        key(Key::Home);
        live.wait_at(0);
        browser.press("g12".chars());
        key(Key::Enter);
        live.wait_at(11);
        // The field has kept the focus, and the keys.
        focus("[name=follow]");
        key(Key::Enter);
        live.wait_at(last);

        // A layer, and cells under the map's keys.
        focus("[name=numbers]");
        browser.press([' ']);
        wait_for("no numbers", || {
            browser.is_there(&live.part(".map svg.hide-numbers")).then_some(())
        });
        assert_eq!(live.says("at"), last.to_string(), "the key was the box's own");
        browser.run::<()>("document.activeElement.blur()", &[]);
        focus(".map");
        let cell = live.text(".readout");
        key(Key::Up);
        wait_for("a cell", || {
            let readout = live.text(".readout");
            (readout.starts_with("cell (") && readout != cell).then_some(())
        });
        assert_eq!(live.says("at"), last.to_string(), "the key was the map's own");

        // Another maze again: that is asked about first, and the answer is no.
        browser.press("/meadow".chars());
        key(Key::Enter);
        let is_open = |dialog: &str| {
            browser
                .run::<bool>("return document.querySelector(arguments[0]).open", &[json!(dialog)])
        };
        wait_for("the question", || is_open("#confirm").then_some(()));
        // Keys of the page mean nothing meanwhile.
        key(Key::Left);
        key(Key::Escape);
        wait_for("its end", || (!is_open("#confirm")).then_some(()));
        assert_eq!(
            (simulator.info().name.as_str(), simulator.info().states),
            ("05-hedgerow", last + 1)
        );
        assert_eq!(live.says("at"), last.to_string());

        // Help.
        browser.run::<()>("document.activeElement.blur()", &[]);
        browser.press(['?']);
        wait_for("the keys", || is_open("#keys").then_some(()));
        key(Key::Escape);
        wait_for("its end", || (!is_open("#keys")).then_some(()));
    });
}
