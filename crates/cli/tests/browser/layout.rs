//! The layout of the page in windows of several sizes.

use mmsim_maze::Cell;
use mmsim_protocol::{Annotation, AnnotationWriter};
use serde_json::json;

use crate::browser::{Browser, wait_for, with_browser, with_page};
use crate::harness::Home;
use crate::page::Panel;
use crate::simulator::{Simulator, bundled, connect};
use crate::test_state::TestState;

pub(crate) const PHONE: (u32, u32) = (390, 844);
pub(crate) const SMALL: (u32, u32) = (1024, 768);
pub(crate) const LAPTOP: (u32, u32) = (1440, 900);

/// A mouse that neither moves nor exits: a server.
const WAITS: [&str; 4] = [env!("CARGO_BIN_EXE_mmsim"), "--no-viewer", "--port", "0"];

/// Changes the size of the window.
pub(crate) fn resize(browser: &Browser, (width, height): (u32, u32)) {
    let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
    browser.devtools("Emulation.setDeviceMetricsOverride", &size);
    wait_for("the new size", || {
        let script = "return [innerWidth, innerHeight]";
        (browser.run::<(u32, u32)>(script, &[]) == (width, height)).then_some(())
    });
}

/// Returns true if all of an element is visible without scrolling.
pub(crate) fn is_in_sight(browser: &Browser, selector: &str) -> bool {
    let script = "
        const element = document.querySelector(arguments[0]);
        const { left, right, top, bottom, width } = element.getBoundingClientRect();
        let isVisible = width > 0;
        for (let box = element.parentElement; box; box = box.parentElement) {
            const isPage = box === document.documentElement;
            if (!isPage && !/auto|scroll|hidden/.test(getComputedStyle(box).overflowY)) continue;
            const area = isPage ? new DOMRect(0, 0, innerWidth, innerHeight) : box.getBoundingClientRect();
            isVisible &&= area.left <= left && right <= area.right + 1 && area.top <= top && bottom <= area.bottom + 1;
        }
        return isVisible;";
    browser.run(script, &[json!(selector)])
}

pub(crate) fn assert_in_sight(browser: &Browser, live: Panel<'_>, parts: &[&str]) {
    for part in parts {
        wait_for(part, || is_in_sight(browser, &live.part(part)).then_some(()));
    }
}

pub(crate) fn assert_no_sideways_scrolling(browser: &Browser) {
    let script = "return [...document.querySelectorAll('html, body, main, .panel, .details, .export')]
        .filter((box) => box.scrollWidth > box.clientWidth + 1).map((box) => box.className || box.tagName)";
    assert_eq!(browser.run::<Vec<String>>(script, &[]), [""; 0]);
}

#[test]
fn a_strategy_can_run_without_scrolling() {
    with_page(&["harbour"], |browser, _| {
        let live = Panel::live(browser);
        live.wait_until_empty();
        for size in [PHONE, SMALL, LAPTOP] {
            resize(browser, size);
            assert_in_sight(browser, live, &[".run [name=run]", ".run [name=stop]"]);
            assert_no_sideways_scrolling(browser);
        }
    });
}

/// The mouse writes to its log, which takes space.
#[test]
fn the_own_mouse_and_its_figures_are_in_sight() {
    with_browser(|browser| {
        let options = ["--maze", "harbour", "--stay"];
        let simulator = Simulator::start_mouse(Home::new(), &options, &WAITS);
        browser.open(&simulator.page);
        let live = Panel::live(browser);
        let wait_for_phase = |phase: &str| {
            let name = live.part(".run .phase");
            wait_for(phase, || {
                (browser.exists(&name) && live.text(".run .phase") == phase).then_some(())
            });
        };
        wait_for_phase("running");
        // The mouse never connects. The test sends a log and states in its place.
        let socket = connect(&simulator.serving.address);
        let mut buffer = [0; 64];
        let mut writer = AnnotationWriter::new(&mut buffer);
        writer.push(Annotation::Log("at the start")).unwrap();
        let log = writer.finish().unwrap().to_vec();
        let size = bundled("01-harbour.txt").size();
        let start = TestState { cell: Cell::new(0, 0), heading: 'N', ..TestState::new(0, size) };
        for request in [log, start.message('C', 'C')] {
            assert_eq!(mmsim_tests::ask(&socket, &request), b"ok");
        }
        live.wait_for_state(0);
        wait_for("the log", || is_in_sight(browser, &live.part(".log")).then_some(()));
        let controls = [".run [name=again]", ".run [name=stop]", ".run [name=pause]"];
        let bounds = [".distances .optimistic", ".distances .pessimistic", ".actual"];
        let figures = [".figures", ".phases", ".log", bounds[0], bounds[1], bounds[2]];
        let check = || {
            for size in [PHONE, SMALL, LAPTOP] {
                resize(browser, size);
                assert_in_sight(browser, live, &controls);
                if size != PHONE {
                    assert_in_sight(browser, live, &figures);
                }
                assert_no_sideways_scrolling(browser);
            }
        };
        check();
        live.click(".run [name=stop]");
        wait_for_phase("ended");
        check();
        browser.leave();
    });
}

#[test]
fn walls_of_a_large_maze_are_at_least_2_pixels_wide() {
    with_page(&["old quarter"], |browser, simulator| {
        let live = Panel::live(browser);
        live.wait_until_empty();
        let size = bundled("half-size-old-quarter.txt").size();
        let mut state = TestState::new(0, size);
        state.walls.fill(0);
        simulator.send(&state.message('C', 'C'));
        live.wait_for_state(0);
        // Returns the width of a line in pixels.
        let width = |selector: &str| -> f64 {
            let script = "
                const wall = document.querySelector(`.map ${arguments[0]}`);
                return parseFloat(getComputedStyle(wall).strokeWidth) * wall.getScreenCTM().a;";
            browser.run(script, &[json!(selector)])
        };
        for size in [PHONE, SMALL, LAPTOP] {
            resize(browser, size);
            let [unknown, known] = [".wall.true:not(.known)", ".wall.known"];
            // On a phone, a cell is about 11 pixels wide, and in a small window about 12.
            let least = [(PHONE, 1.4), (SMALL, 1.7)].into_iter().find(|it| it.0 == size);
            let least = least.map_or(1.9, |(_, least)| least);
            wait_for("wide walls", || (width(unknown) >= least).then_some(()));
            assert!(width(known) > 1.4 * width(unknown), "{} {}", width(known), width(unknown));
        }
        browser.press(['+', '+', '+', '+', '+']);
        let scale = "return document.querySelector('.map svg').getScreenCTM().a";
        wait_for("a thin wall", || {
            let scale: f64 = browser.run(scale, &[]);
            (scale > 2.0 && (width(".wall.true:not(.known)") / scale - 1.2).abs() < 0.01)
                .then_some(())
        });
    });
}
