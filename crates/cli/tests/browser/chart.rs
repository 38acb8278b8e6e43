//! The chart above the slider: its axes, and the values at a state.

use mmsim_solvers::BundledStrategy;
use serde_json::{Value, json};

use crate::browser::{Browser, wait_for, with_page};
use crate::http;
use crate::layout::{LAPTOP, PHONE, SMALL, resize};
use crate::page::Panel;
use crate::simulator::{Simulator, bundled};

/// The states that a test shows, as shares of all states in percent.
const SHARES: [usize; 6] = [0, 1, 23, 50, 99, 100];

/// Finds a node in a tree of the document, including the parts of form controls.
fn find<'a>(node: &'a Value, attribute: [&str; 2]) -> Option<&'a Value> {
    let attributes = node["attributes"].as_array().map_or(&[][..], Vec::as_slice);
    if attributes.chunks(2).any(|pair| pair == attribute) {
        return Some(node);
    }
    let parts = ["children", "shadowRoots"].map(|key| node[key].as_array());
    parts.into_iter().flatten().flatten().find_map(|child| find(child, attribute))
}

/// The thumb of the slider, which is not part of the document.
struct Thumb<'a> {
    browser: &'a Browser,
    node: Value,
}

impl<'a> Thumb<'a> {
    fn new(browser: &'a Browser) -> Self {
        let everything = json!({ "depth": -1, "pierce": true });
        let document = browser.devtools("DOM.getDocument", &everything);
        let slider = find(&document["root"], ["name", "slider"]).expect("a slider");
        let thumb = find(slider, ["id", "thumb"]).expect("a thumb");
        Self { browser, node: json!({ "nodeId": thumb["nodeId"] }) }
    }

    /// Returns the horizontal position of the middle in pixels.
    fn x(&self) -> f64 {
        let corners =
            self.browser.devtools("DOM.getBoxModel", &self.node)["model"]["border"].take();
        let x = |corner: usize| corners[2 * corner].as_f64().unwrap();
        f64::midpoint(x(0), x(1))
    }
}

/// Returns the position of a state in the chart in pixels.
pub(crate) fn chart_point(live: Panel<'_>, at: usize) -> (f64, f64) {
    let script = "
        const svg = document.querySelector(arguments[0]);
        const { x, y } = new DOMPoint(arguments[1], 50).matrixTransform(svg.getScreenCTM());
        return [x, y];";
    live.browser.run(script, &[json!(live.part(".plot svg")), json!(at)])
}

/// Returns the numbers along an axis, each with the position of its middle in pixels.
fn ticks(live: Panel<'_>, axis: &str) -> Vec<(usize, f64, f64)> {
    let script = "
        return [...document.querySelectorAll(arguments[0])].map((label) => {
            const { left, right, top, bottom } = label.getBoundingClientRect();
            return [Number(label.textContent.replace(',', '')), (left + right) / 2, (top + bottom) / 2];
        });";
    live.browser.run(script, &[json!(live.part(&format!(".plot .{axis} span")))])
}

fn assert_near(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() < 0.75, "{what}: {found}, not {expected}");
}

/// Runs a search and waits until it is drawn. Returns the index of the last state.
fn search(live: Panel<'_>, simulator: &Simulator) -> usize {
    live.wait_until_empty();
    let maze = bundled("05-hedgerow.txt");
    let last = simulator.search(&maze, BundledStrategy::ShortestPathSearch).len() - 1;
    live.wait_for_state(last);
    let view_box = format!("0 0 {last} 100");
    wait_for("the chart", || {
        let is_drawn = live.attribute(".plot .optimistic", "d").ends_with(&format!("H{last}"));
        (is_drawn && live.attribute(".plot svg", "viewBox") == view_box).then_some(())
    });
    last
}

#[test]
fn each_state_is_above_the_thumb_of_the_slider() {
    with_page(&["hedgerow"], |browser, simulator| {
        let live = Panel::live(browser);
        let last = search(live, simulator);
        let thumb = Thumb::new(browser);
        for size in [LAPTOP, (1280, 720), SMALL, PHONE, (571, 900)] {
            resize(browser, size);
            for at in SHARES.map(|share| share * last / 100) {
                live.slide_to(at);
                let thumb = thumb.x();
                let what = format!("state {at} in a window of {size:?}");
                assert_near(chart_point(live, at).0, thumb, &what);
                let script = "
                    const { left, right } = document.querySelector(arguments[0]).getBoundingClientRect();
                    return (left + right) / 2;";
                let cursor = browser.run(script, &[json!(live.part(".timeline .cursor"))]);
                assert_near(cursor, thumb, &what);
            }
            // Round numbers, which do not overlap.
            let numbers = wait_for("the numbers", || {
                let numbers = ticks(live, "x");
                let ends = [&numbers[1], &numbers[numbers.len() - 1]];
                let expected = ends.map(|&(number, ..)| chart_point(live, number).0);
                ends.iter()
                    .zip(expected)
                    .all(|(end, x)| (end.1 - x).abs() < 0.75)
                    .then_some(numbers)
            });
            assert!(numbers[0].0 == 0 && numbers.len() > 4, "{numbers:?}");
            let step = numbers[1].0;
            for (i, &(number, x, _)) in numbers.iter().enumerate().skip(1) {
                assert_eq!(number, i * step);
                assert_near(x, chart_point(live, number).0, &format!("number {number}"));
                assert!(x - numbers[i - 1].1 > 25.0, "{numbers:?}");
            }
            assert!([10, 20, 50, 100].contains(&step), "{step}");
        }
    });
}

#[test]
fn the_chart_shows_the_values_at_a_state() {
    with_page(&["hedgerow"], |browser, simulator| {
        let live = Panel::live(browser);
        let last = search(live, simulator);
        assert_eq!(
            (live.text(".plot .y-title"), live.text(".plot .x-title")),
            ("steps".into(), "State".into())
        );
        let heights = ticks(live, "y");
        assert_eq!(heights.iter().map(|tick| tick.0).collect::<Vec<_>>(), [0, 20, 40, 60]);
        let run = simulator.run_number();
        for at in SHARES.map(|share| share * last / 100) {
            let (x, y) = chart_point(live, at);
            browser.devtools(
                "Input.dispatchMouseEvent",
                &json!({ "type": "mouseMoved", "x": x, "y": y }),
            );
            let path = format!("/api/sources/live/moment?run={run}&at={at}");
            let view = http::get(&simulator.url(&path)).json();
            let values = match (
                view["optimistic_distance"].as_u64().unwrap(),
                view["pessimistic_distance"].as_u64(),
            ) {
                (open, None) => format!("at least {open} steps"),
                (open, Some(closed)) if open == closed => format!("{open} steps, proven"),
                (open, Some(closed)) => format!("{open} to {closed} steps"),
            };
            let expected = format!("State {at}: {values}");
            wait_for(&expected, || (live.text(".timeline .tip") == expected).then_some(()));
            // The line ends at the height of the value.
            let script = "
                const line = document.querySelector(arguments[0]);
                const end = line.getPointAtLength(line.getTotalLength());
                return end.matrixTransform(line.getScreenCTM()).y;";
            let optimistic = json!(live.part(".plot .optimistic"));
            let end: f64 = browser.run(script, &[optimistic]);
            assert_near(end, heights[3].2 + (heights[0].2 - heights[3].2) / 60.0, "59 steps");
            for kind in ["mousePressed", "mouseReleased"] {
                let click =
                    json!({ "type": kind, "x": x, "y": y, "button": "left", "clickCount": 1 });
                browser.devtools("Input.dispatchMouseEvent", &click);
            }
            live.wait_for_state(at);
        }
    });
}

/// The chart is drawn about once a second, but its axis always agrees with that of the slider.
#[test]
fn the_axis_grows_with_the_run() {
    with_page(&["hedgerow"], |browser, simulator| {
        let live = Panel::live(browser);
        let last = search(live, simulator);
        let thumb = Thumb::new(browser);
        live.slide_to(last / 2);
        let state = simulator.search(&bundled("05-hedgerow.txt"), BundledStrategy::FloodFill);
        live.wait_for_run_state(simulator.run_number(), state.len() - 1);
        live.slide_to(state.len() / 2);
        let is_drawn =
            |last: usize| live.attribute(".plot svg", "viewBox") == format!("0 0 {last} 100");
        wait_for("the new run", || is_drawn(state.len() - 1).then_some(()));
        for extra in 1..=3 {
            simulator.send(&state[0].message('C', 'C'));
            let last = state.len() - 1 + extra;
            wait_for("a longer axis", || is_drawn(last).then_some(()));
            assert_near(chart_point(live, state.len() / 2).0, thumb.x(), "the shown state");
        }
    });
}
