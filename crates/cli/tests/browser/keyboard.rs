//! Operating the whole page with the keyboard. The focus must always be visible.

use std::collections::BTreeSet;

use fantoccini::key::Key;
use mmsim_solvers::BundledStrategy;
use serde::Deserialize;
use serde_json::json;

use crate::browser::{Browser, wait_for, with_page};
use crate::page::{Page, Panel};
use crate::simulator::bundled;
use crate::test_state::TestState;

#[derive(Debug, Deserialize)]
struct Focus {
    /// The index of the focused element in the list of focusable elements, or `None` if no
    /// focusable element has the focus.
    index: Option<usize>,
    name: String,
    /// True if the user can see that the element has the focus.
    is_visible: bool,
}

/// Returns the names of all visible elements that can receive the focus.
fn focusable(browser: &Browser) -> Vec<String> {
    let script = "
        const seen = (element) => element.checkVisibility({ checkVisibilityCSS: true, checkOpacity: false });
        const selector = 'a[href], button, input, select, textarea, summary, [tabindex]';
        window.focusable = [...document.querySelectorAll(selector)].filter((element) =>
            !element.disabled && element.tabIndex >= 0 && (seen(element) || element.type === 'file'));
        window.nameOf = (element) => `${element.tagName} ${element.name || element.id || element.className
            || element.dataset.export} ${element.closest('section')?.id || ''}`.trim();
        return window.focusable.map(window.nameOf);";
    browser.run(script, &[])
}

/// Returns the focused element. The focus counts as visible if removing it changes how the element
/// or one of its ancestors looks.
fn focus_of(browser: &Browser) -> Focus {
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
        const number = window.focusable.indexOf(element);
        if (number < 0) return { index: null, name: window.nameOf(element), is_visible: true };
        const focused = look();
        element.blur();
        const blurred = look();
        element.focus({ focusVisible: true });
        return { index: number, name: window.nameOf(element), is_visible: focused !== blurred };";
    browser.run(script, &[])
}

#[test]
fn tab_reaches_every_control_with_a_visible_focus() {
    with_page(&["meadow"], |browser, simulator| {
        let size = bundled("oblong-long-meadow.txt").size();
        for number in 0..5 {
            simulator.send(&TestState::new(number, size).message('C', 'C'));
        }
        let live = Panel::live(browser);
        live.wait_for_state(4);
        // In the middle of the history, all buttons are enabled.
        live.click("button[name=previous]");
        live.wait_for_state(3);
        wait_for("the exports", || {
            (live.attribute("[data-export='picture.svg']", "href") != "none").then_some(())
        });
        browser.run::<()>("document.activeElement.blur()", &[]);
        let all = focusable(browser);
        assert!(all.len() > 20, "{all:?}");
        let (mut reached, mut order) = (BTreeSet::new(), Vec::new());
        // Go through all elements once from the top of the page.
        browser.run::<()>("window.getSelection().collapse(document.body, 0)", &[]);
        for _ in 0..=all.len() + 3 {
            browser.press([char::from(Key::Tab)]);
            let focus = focus_of(browser);
            assert!(focus.is_visible, "no visible focus on {}", focus.name);
            order.extend(focus.index);
            reached.extend(focus.index);
        }
        let missed: Vec<_> =
            (0..all.len()).filter(|number| !reached.contains(number)).map(|n| &all[n]).collect();
        assert!(missed.is_empty(), "Tab does not reach {missed:?}");
        // The order is that of the document and wraps around at most once.
        let turns = order.windows(2).filter(|pair| pair[1] < pair[0]).count();
        assert!(turns <= 1, "{order:?}");
        // Shift+Tab moves the focus back.
        let before = focus_of(browser).index;
        browser.press_with(Key::Shift, char::from(Key::Tab));
        assert_ne!(focus_of(browser).index, before);
    });
}

/// No text field keeps the keys for itself.
#[test]
fn escape_and_enter_leave_a_field() {
    with_page(&["harbour"], |browser, simulator| {
        let states = simulator.search(&bundled("01-harbour.txt"), BundledStrategy::FloodFill);
        let (live, last) = (Panel::live(browser), states.len() - 1);
        live.wait_for_state(last);
        wait_for("the list", || {
            browser.exists(&Page::maze_selector("05-hedgerow.txt")).then_some(())
        });
        let [enter, escape, home, end] =
            [Key::Enter, Key::Escape, Key::Home, Key::End].map(char::from);
        browser.press(['g', '1', '2', enter]);
        live.wait_for_state(12);
        browser.press([home]);
        live.wait_for_state(0);
        for keys in [&['g', escape][..], &['g', '9', escape], &['/', 'x', escape, escape]] {
            browser.press(keys.iter().copied().chain([end]));
            live.wait_for_state(last);
            browser.press([home]);
            live.wait_for_state(0);
        }
        browser.run::<()>("document.querySelector('[name=strategy]').focus()", &[]);
        browser.press([escape, end]);
        live.wait_for_state(last);
    });
}

#[test]
fn everything_works_without_a_pointer() {
    with_page(&["harbour"], |browser, simulator| {
        let live = Panel::live(browser);
        let key = |key: Key| browser.press([char::from(key)]);
        let focus = |selector: &str| {
            wait_for(selector, || {
                key(Key::Tab);
                let script = "return document.activeElement.matches(arguments[0])";
                browser.run::<bool>(script, &[json!(selector)]).then_some(())
            });
        };
        live.wait_until_empty();
        wait_for("the list", || {
            browser.exists(&Page::maze_selector("05-hedgerow.txt")).then_some(())
        });

        // Load another maze, the only one that matches the search.
        browser.press("/hedge".chars());
        key(Key::Down);
        key(Key::Enter);
        wait_for("hedgerow", || (simulator.info().maze == "05-hedgerow").then_some(()));
        live.wait_until_empty();

        // Run a strategy.
        focus("[name=pace]");
        key(Key::End);
        assert_eq!(live.text(".pace output"), "no limit");
        focus("[name=strategy]");
        browser.press("left".chars());
        focus("[name=run]");
        key(Key::Enter);
        wait_for("the goal", || live.text(".run .result").contains("goal reached").then_some(()));
        assert_eq!(live.text(".run .name"), "left-wall");
        let last = simulator.info().states - 1;
        live.wait_for_run_state(simulator.run_number(), last);

        // Step through the history. The shortcuts do not depend on the focus.
        key(Key::Home);
        live.wait_for_state(0);
        browser.press("g12".chars());
        key(Key::Enter);
        live.wait_for_state(12);
        // A field with the focus handles its own keys.
        focus("[name=follow]");
        key(Key::Enter);
        live.wait_for_state(last);

        // Toggle a layer, then move between cells of the map.
        focus("[name=numbers]");
        browser.press([' ']);
        wait_for("no numbers", || {
            browser.exists(&live.part(".map svg.hide-numbers")).then_some(())
        });
        assert_eq!(live.data("index"), last.to_string(), "the checkbox handles the key");
        browser.run::<()>("document.activeElement.blur()", &[]);
        focus(".map");
        let cell = live.text(".readout");
        key(Key::Up);
        wait_for("a cell", || {
            let readout = live.text(".readout");
            (readout.starts_with("cell (") && readout != cell).then_some(())
        });
        assert_eq!(live.data("index"), last.to_string(), "the map handles the key");

        // Loading another maze asks for confirmation; cancel it.
        browser.press("/meadow".chars());
        key(Key::Enter);
        let is_open = |dialog: &str| {
            browser
                .run::<bool>("return document.querySelector(arguments[0]).open", &[json!(dialog)])
        };
        wait_for("the dialog", || is_open("#confirm").then_some(()));
        // Shortcuts are disabled while the dialog is open.
        key(Key::Left);
        key(Key::Escape);
        wait_for("the dialog to close", || (!is_open("#confirm")).then_some(()));
        assert_eq!(
            (simulator.info().maze.as_str(), simulator.info().states),
            ("05-hedgerow", last + 1)
        );
        assert_eq!(live.data("index"), last.to_string());

        // Open the help.
        browser.run::<()>("document.activeElement.blur()", &[]);
        browser.press(['?']);
        wait_for("the keys", || is_open("#keys").then_some(()));
        key(Key::Escape);
        wait_for("the dialog to close", || (!is_open("#keys")).then_some(()));
    });
}
