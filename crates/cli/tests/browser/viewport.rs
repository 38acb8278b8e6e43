//! Zooming and moving the map, its coordinates and its legend.

use fantoccini::key::Key;
use serde_json::json;

use crate::browser::{Browser, wait_for, with_page};
use crate::page::{Page, Panel};
use crate::simulator::bundled;
use crate::test_state::TestState;

const WHOLE: &str = "-2 -2 644 644";

fn view_box(live: Panel<'_>) -> [f64; 4] {
    let text = live.attribute(".map svg", "viewBox");
    let numbers: Vec<f64> = text.split(' ').map(|number| number.parse().unwrap()).collect();
    numbers.try_into().unwrap()
}

/// Returns the middle of a cell in the window, in pixels.
fn middle(browser: &Browser, cell: &str) -> (f64, f64) {
    let script = "
        const cell = document.querySelector(`.map .cell[data-cell='${arguments[0]}']`);
        const { left, right, top, bottom } = cell.getBoundingClientRect();
        return [(left + right) / 2, (top + bottom) / 2];";
    browser.run(script, &[json!(cell)])
}

/// Returns the coordinates along the map, each with its distance in pixels from the middle of its
/// column or row.
fn coordinates(browser: &Browser, axis: &str) -> Vec<(String, f64)> {
    let script = "
        const axis = arguments[0];
        const middle = ({ left, right, top, bottom }) =>
            axis === 'x' ? (left + right) / 2 : (top + bottom) / 2;
        return [...document.querySelectorAll(`.axes .${axis}`)].map((label) => {
            const name = axis === 'x' ? `${label.textContent},0` : `0,${label.textContent}`;
            const cell = document.querySelector(`.map .cell[data-cell='${name}']`);
            const distance = middle(label.getBoundingClientRect()) - middle(cell.getBoundingClientRect());
            return [label.textContent, Math.abs(distance)];
        });";
    browser.run(script, &[json!(axis)])
}

fn mouse(browser: &Browser, kind: &str, (x, y): (f64, f64), more: &serde_json::Value) {
    let mut event = json!({ "type": kind, "x": x, "y": y });
    event.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    browser.devtools("Input.dispatchMouseEvent", &event);
}

#[test]
fn the_map_zooms_and_moves() {
    with_page(&["old quarter"], |browser, simulator| {
        let live = Panel::live(browser);
        live.wait_until_empty();
        simulator.send(
            &TestState::new(0, bundled("half-size-old-quarter.txt").size()).message('C', 'C'),
        );
        live.wait_for_state(0);
        assert_eq!(live.attribute(".map svg", "viewBox"), WHOLE);
        let press = |key: char| browser.press([key]);
        let disabled = |name: &str| live.attribute(&format!("[name={name}]"), "disabled") != "none";
        assert!(disabled("zoom-out") && disabled("zoom-reset") && !disabled("zoom-in"));

        // With keys, around the middle.
        press('+');
        press('+');
        let zoomed = view_box(live);
        assert!(zoomed[2] < 644.0 && zoomed[3] < 644.0, "{zoomed:?}");
        assert!((zoomed[0] + zoomed[2] / 2.0 - 320.0).abs() < 1.0, "{zoomed:?}");
        press('-');
        press('-');
        assert_eq!(live.attribute(".map svg", "viewBox"), WHOLE);

        // With the wheel, around the pointer.
        let before = middle(browser, "12,18");
        mouse(browser, "mouseWheel", before, &json!({ "deltaX": 0, "deltaY": -400 }));
        wait_for("the zoom", || (view_box(live)[3] < 500.0).then_some(()));
        let (x, y) = middle(browser, "12,18");
        assert!((x - before.0).abs() < 2.0 && (y - before.1).abs() < 2.0, "{x} {y} {before:?}");
        for axis in ["x", "y"] {
            let labels = coordinates(browser, axis);
            assert!(labels.len() > 5 && labels.len() < 32, "{labels:?}");
            assert!(labels.iter().all(|(_, distance)| *distance < 2.0), "{labels:?}");
        }

        // The pointer shows the cell under it, and drags the map.
        mouse(browser, "mouseMoved", (x, y), &json!({}));
        wait_for("the cell", || live.text(".readout").starts_with("cell (12, 18)").then_some(()));
        let pressed = json!({ "button": "left", "buttons": 1, "clickCount": 1 });
        mouse(browser, "mousePressed", (x, y), &pressed);
        mouse(browser, "mouseMoved", (x - 30.0, y + 5.0), &pressed);
        mouse(browser, "mouseMoved", (x - 60.0, y - 10.0), &pressed);
        mouse(browser, "mouseReleased", (x - 60.0, y - 10.0), &pressed);
        let (moved_x, moved_y) = middle(browser, "12,18");
        assert!((moved_x - (x - 60.0)).abs() < 2.0, "{moved_x} {x}");
        assert!((moved_y - (y - 10.0)).abs() < 2.0, "{moved_y} {y}");
        let shown = live.text(".position");
        assert_eq!(shown, "State 0 of 0", "dragging does not step through the history");

        // The button is released outside the map, so the pointer does not drag the map any more.
        press('0');
        mouse(browser, "mousePressed", (x, y), &pressed);
        mouse(browser, "mouseMoved", (x + 2.0, y), &pressed);
        mouse(browser, "mouseReleased", (2.0, 2.0), &pressed);
        mouse(browser, "mouseWheel", (x, y), &json!({ "deltaX": 0, "deltaY": -400 }));
        wait_for("the zoom", || (view_box(live)[3] < 500.0).then_some(()));
        let before = live.attribute(".map svg", "viewBox");
        for step in 1..4 {
            mouse(browser, "mouseMoved", (x + 15.0 * f64::from(step), y), &json!({}));
        }
        assert_eq!(live.attribute(".map svg", "viewBox"), before);

        // The map stays within the maze.
        for _ in 0..12 {
            live.click("[name=zoom-in]");
            if disabled("zoom-in") {
                break;
            }
        }
        assert!(disabled("zoom-in"));
        let closest = view_box(live);
        assert!(closest[2].max(closest[3]) >= 3.0 * 20.0, "{closest:?}");

        // The arrow keys move the map to the cell.
        let focus = "document.querySelector('.map').focus({ focusVisible: true })";
        browser.run::<()>(focus, &[]);
        for _ in 0..31 {
            press(char::from(Key::Right));
        }
        let readout = live.text(".readout");
        assert!(readout.starts_with("cell (31, "), "{readout}");
        let [west, _, width, _] = view_box(live);
        assert!((600.0..=642.5).contains(&(west + width)), "{west} {width}");

        press('0');
        assert_eq!(live.attribute(".map svg", "viewBox"), WHOLE);
        for axis in ["x", "y"] {
            let labels = coordinates(browser, axis);
            assert_eq!(labels[0].0, "0");
            assert!(labels.iter().all(|(_, distance)| *distance < 2.0), "{labels:?}");
        }
    });
}

#[test]
fn a_new_run_keeps_the_zoom_and_another_size_does_not() {
    with_page(&["harbour"], |browser, simulator| {
        let live = Panel::live(browser);
        live.wait_until_empty();
        browser.press(['+']);
        let zoomed = live.attribute(".map svg", "viewBox");
        assert_ne!(zoomed, "-2 -2 324 324");
        simulator.send(&TestState::new(0, bundled("01-harbour.txt").size()).message('C', 'C'));
        live.wait_for_state(0);
        mouse(browser, "mouseMoved", middle(browser, "7,7"), &json!({}));
        wait_for("the cell", || live.text(".readout").starts_with("cell (7, 7)").then_some(()));
        simulator.send(b"reset");
        live.wait_for_run(simulator.run_number());
        assert!(live.text(".readout").starts_with("cell (7, 7)"), "the pointer is still there");
        assert_eq!(live.attribute(".map svg", "viewBox"), zoomed);
        simulator.send(&TestState::new(0, bundled("01-harbour.txt").size()).message('C', 'C'));
        live.wait_for_state(0);
        simulator.send(b"reset");
        Page(browser).choose_maze("half-size-old-quarter.txt");
        wait_for("the maze", || (live.attribute(".map svg", "viewBox") == WHOLE).then_some(()));
    });
}

#[test]
fn the_legend_is_remembered() {
    with_page(&["meadow"], |browser, simulator| {
        let live = Panel::live(browser);
        live.wait_until_empty();
        let is_shown = || -> bool {
            browser.run("return document.querySelector('.legend').checkVisibility()", &[])
        };
        assert!(!is_shown());
        live.click("[name=legend]");
        assert!(is_shown() && live.attribute("[name=legend]", "aria-expanded") == "true");
        let invisible = "return [...document.querySelectorAll('.legend svg :is(path, rect)')]
            .filter((shape) => {
                const { fill, stroke } = getComputedStyle(shape);
                return fill === 'none' && stroke === 'none';
            })
            .map((shape) => shape.outerHTML)";
        assert_eq!(browser.run::<Vec<String>>(invisible, &[]), [""; 0]);
        browser.open(&simulator.page);
        live.wait_until_empty();
        assert!(is_shown());
        live.click("[name=legend]");
        assert!(!is_shown());
    });
}
