//! Several panels on the page: their layout, closing and reopening them.

use mmsim_maze::Cell;
use mmsim_protocol::Annotation;
use serde::Deserialize;
use serde_json::json;

use crate::browser::{Browser, wait_for, with_browser, with_page};
use crate::harness::{Home, Serving, recorded};
use crate::layout::{LAPTOP, PHONE, SMALL, assert_in_sight, assert_no_sideways_scrolling, resize};
use crate::notes::annotations;
use crate::page::{Page, Panel};
use crate::simulator::{Simulator, bundled, page_address};
use crate::test_state::TestState;

const WIDE: (u32, u32) = (1920, 1080);
const LARGE: (u32, u32) = (1440, 900);
const SHOW_LIVE: &str = "#show-live";

/// Sends `count` states of the maze meadow, starting with the state `first`.
pub(crate) fn send_states(simulator: &Simulator, first: usize, count: usize) {
    let size = bundled("oblong-long-meadow.txt").size();
    for number in first..first + count {
        simulator.send(&TestState::new(number, size).message('C', 'C'));
    }
}

/// Opens the newest recording in the list and waits for its panel.
pub(crate) fn open_newest_recording<'a>(browser: &'a Browser, id: &'a str) -> Panel<'a> {
    browser.wait_until_exists("#recordings li");
    browser.click("#recordings li:first-child button");
    let opened = Panel { browser, source: id };
    browser.wait_until_exists(&opened.part(".map svg"));
    opened
}

/// Serves the maze meadow. The page shows a live run of `live` states and a recording of `recorded`
/// states.
pub(crate) fn with_two_panels(
    recorded: usize,
    live: usize,
    test: impl FnOnce(&Simulator, Panel<'_>, Panel<'_>),
) {
    with_page(&["meadow", "--record", "kept"], |browser, simulator| {
        send_states(simulator, 0, recorded);
        simulator.send(b"reset");
        let recording = open_newest_recording(browser, "1");
        recording.wait_for_state(recorded - 1);
        send_states(simulator, 100, live);
        let panel = Panel::live(browser);
        panel.wait_for_run_state(simulator.run_number(), live - 1);
        test(simulator, panel, recording);
    });
}

/// The edges of an element in pixels.
#[derive(Debug, Deserialize, PartialEq, Eq)]
struct Area {
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
}

fn area(panel: Panel<'_>, part: &str) -> Area {
    let script = "
        const { left, right, top, bottom } = document.querySelector(arguments[0]).getBoundingClientRect();
        const [l, r, t, b] = [left, right, top, bottom].map(Math.round);
        return { left: l, right: r, top: t, bottom: b };";
    panel.browser.run(script, &[json!(panel.part(part))])
}

fn panels(browser: &Browser) -> Vec<String> {
    let script =
        "return [...document.querySelectorAll('.panel')].map((panel) => panel.dataset.source)";
    browser.run(script, &[])
}

fn has_focus(browser: &Browser, selector: &str) -> bool {
    browser.run("return document.activeElement.matches(arguments[0])", &[json!(selector)])
}

/// Waits until the whole of both panels is either side by side or one below the other.
fn wait_for_layout(panels: [Panel<'_>; 2], are_beside: bool) {
    wait_for("the layout", || {
        let [first, second] = panels.map(|panel| area(panel, ".map"));
        let is_beside = first.top == second.top && first.right < second.left;
        let is_below = first.left == second.left && first.bottom < second.top;
        (if are_beside { is_beside } else { is_below }).then_some(())
    });
}

#[test]
fn two_panels_are_side_by_side_and_aligned() {
    with_two_panels(5, 3, |_, live, recording| {
        let browser = live.browser;
        let parts = [".title h2", ".map", "[name=slider]", "[name=jump]", ".figures"];
        for (size, are_beside) in [(WIDE, true), (LAPTOP, true), (SMALL, true), (PHONE, false)] {
            resize(browser, size);
            wait_for_layout([live, recording], are_beside);
            assert_no_sideways_scrolling(browser);
            // Only the panels scroll, except on a phone.
            let is_page = "return document.documentElement.scrollHeight > innerHeight";
            assert_eq!(browser.run::<bool>(is_page, &[]), size == PHONE, "{size:?}");
            if size == LAPTOP || size == WIDE {
                for panel in [live, recording] {
                    assert_in_sight(browser, panel, &parts);
                }
                for part in parts {
                    let [one, other] = [area(live, part), area(recording, part)];
                    assert_eq!((one.top, one.bottom), (other.top, other.bottom), "{part}");
                }
                assert_in_sight(browser, live, &[".run [name=stop]", ".run [name=run]"]);
            }
        }
        // A third and a fourth panel.
        resize(browser, LAPTOP);
        for count in [3, 4] {
            let id = (count - 1).to_string();
            open_newest_recording(browser, &id);
            assert_no_sideways_scrolling(browser);
            let script = "return new Set([...document.querySelectorAll('.panel')]
                .map((panel) => panel.getBoundingClientRect().left)).size";
            let columns = if count == 3 { 3 } else { 2 };
            wait_for("the columns", || (browser.run::<i32>(script, &[]) == columns).then_some(()));
        }
    });
}

/// Only one of the mice writes texts, so only one of the panels has their layer.
#[test]
fn square_maps_fill_two_panels_with_equal_toolbars() {
    with_page(&["harbour", "--record", "kept"], |browser, simulator| {
        let size = bundled("01-harbour.txt").size();
        let state = TestState::new(0, size).message('C', 'C');
        simulator.send(&state);
        simulator.send(b"reset");
        let recording = open_newest_recording(browser, "1");
        simulator.send(&annotations(&[Annotation::Text { cell: Cell::new(0, 0), text: "a" }]));
        simulator.send(&state);
        let live = Panel::live(browser);
        live.wait_for_state(0);
        browser.wait_until_exists(&live.part("label.texts-layer:not([hidden])"));
        for size in [WIDE, LARGE, LAPTOP] {
            resize(browser, size);
            wait_for_layout([live, recording], true);
            for part in [".map", ".toolbar", ".figures"] {
                let [one, other] = [area(live, part), area(recording, part)];
                assert_eq!((one.top, one.bottom), (other.top, other.bottom), "{size:?} {part}");
            }
            assert_in_sight(browser, live, &[".figures"]);
            let map = area(live, ".map");
            assert!(5 * (map.bottom - map.top) > 2 * i32::try_from(size.1).unwrap(), "{map:?}");
        }
    });
}

#[test]
fn the_live_panel_can_be_closed_and_shown_again() {
    with_two_panels(5, 3, |simulator, live, recording| {
        let browser = live.browser;
        let is_offered = || browser.is_visible(SHOW_LIVE);
        assert!(!is_offered());
        live.click("[name=close]");
        wait_for("the panel to close", || (panels(browser) == ["1"]).then_some(()));
        assert!(is_offered() && has_focus(browser, &recording.part("")));
        // The simulation continues.
        send_states(simulator, 200, 4);
        browser.click(SHOW_LIVE);
        live.wait_for_state(6);
        live.assert_shows(&bundled("oblong-long-meadow.txt"), &{
            let size = bundled("oblong-long-meadow.txt").size();
            let numbers = (100..103).chain(200..204);
            numbers.map(|number| TestState::new(number, size)).collect::<Vec<_>>()
        });
        assert_eq!(panels(browser), ["live", "1"], "the live panel comes first");
        assert!(!is_offered() && has_focus(browser, &live.part("")));
        // The controls of the mouse work in the new panel.
        send_states(simulator, 300, 1);
        live.wait_for_state(7);
        assert_eq!(live.attribute(".run [name=run]", "disabled"), "", "a client is connected");

        // With all panels closed, the button receives the focus.
        recording.click("[name=close]");
        wait_for("the panel to close", || (panels(browser) == ["live"]).then_some(()));
        live.click("[name=close]");
        wait_for("the panel to close", || panels(browser).is_empty().then_some(()));
        assert!(has_focus(browser, SHOW_LIVE));
        assert_eq!(browser.text("#nothing-open"), "No run is open.");
        // Loading a maze shows the live simulation.
        Page(browser).choose_maze("05-hedgerow.txt");
        live.wait_until_empty();
        wait_for("the maze", || (live.text("h2") == "05-hedgerow").then_some(()));
    });
}

#[test]
fn a_page_without_a_simulation_offers_no_live_panel() {
    with_browser(|browser| {
        let simulator = Simulator::start_in(Home::new(), &["meadow", "--record", "kept"]);
        send_states(&simulator, 0, 3);
        simulator.send(b"reset");
        let file = recorded(&simulator.home.path().join("kept"));
        let arguments = ["replay", file.to_str().unwrap(), "--serve", "--viewer-port", "0"];
        let replay = Serving::start(simulator.home.command(&arguments), "watch at");
        browser.open(&page_address(&replay));
        let opened = Panel { browser, source: "1" };
        opened.wait_for_state(2);
        assert!(!browser.is_visible(SHOW_LIVE));
        opened.click("[name=close]");
        wait_for("the panel to close", || panels(browser).is_empty().then_some(()));
        assert!(!browser.is_visible(SHOW_LIVE));
        browser.leave();
    });
}
