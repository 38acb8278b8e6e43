//! The layers that show another panel: the mouse and the trail of the other panel, and the walls that
//! only one of the two mice knows.

use std::collections::BTreeSet;

use mmsim_maze::MazeSize;
use serde_json::json;

use crate::browser::wait_for;
use crate::page::{Page, Panel};
use crate::side_by_side::{open_newest_recording, with_two_panels};
use crate::simulator::bundled;
use crate::test_state::TestState;

/// Returns the lines of a path, such as `M20 40h20`.
fn lines(panel: Panel<'_>, path: &str) -> BTreeSet<String> {
    let path = panel.attribute(&format!(".map .{path}"), "d");
    path.split('M').skip(1).map(|line| format!("M{line}")).collect()
}

/// Returns the lines of the inner walls that `one` has and `other` does not have.
fn difference(one: &TestState, other: &TestState, size: MazeSize) -> BTreeSet<String> {
    let mut lines = BTreeSet::new();
    for cell in size.cells() {
        let is_new = |side| one.has_wall(cell, side) && !other.has_wall(cell, side);
        let (x, y) = (20 * u32::from(cell.x), 20 * u32::from(size.height() - 1 - cell.y));
        if is_new('N') {
            lines.insert(format!("M{x} {y}h20"));
        }
        if is_new('E') {
            lines.insert(format!("M{} {y}v20", x + 20));
        }
    }
    lines
}

/// Waits until a panel shows the mouse and the trail of another panel.
fn wait_for_ghost(panel: Panel<'_>, other: Panel<'_>) {
    wait_for("the ghost", || {
        let mouse = panel.attribute(".map .ghost-mouse", "transform");
        let passages = ".map .passage:not([stroke=none])";
        let script = "return document.querySelectorAll(arguments[0]).length";
        let count: usize = other.browser.run(script, &[json!(other.part(passages))]);
        let is_shown = panel.attribute(".map .ghost-mouse", "hidden") == "none";
        let is_same = mouse == other.attribute(".map .mouse", "transform");
        (is_shown && is_same && lines(panel, "ghost-trail").len() == count).then_some(())
    });
}

#[test]
fn a_panel_shows_the_ghost_of_another_panel_and_the_differences() {
    with_two_panels(40, 30, |simulator, live, recording| {
        let browser = live.browser;
        let size = bundled("oblong-long-meadow.txt").size();
        assert_eq!(lines(live, "only-here").len() + lines(live, "ghost-trail").len(), 0);
        live.click("[name=ghost]");
        wait_for_ghost(live, recording);
        live.click("[name=differences]");
        // The recording contains the states from 0, and the live run those from 100.
        let wait_for_differences = |recording_at: usize, live_at: usize| {
            let one = TestState::new(100 + live_at, size);
            let other = TestState::new(recording_at, size);
            let (here, there) = (difference(&one, &other, size), difference(&other, &one, size));
            assert!(!here.is_empty() && !there.is_empty());
            wait_for("the differences", || {
                let shown = (lines(live, "only-here"), lines(live, "only-there"));
                (shown == (here.clone(), there.clone())).then_some(())
            });
            let text = format!("{} walls known only here, {} only there", here.len(), there.len());
            assert_eq!(live.text(".differences"), text);
        };
        wait_for_differences(39, 29);
        // Both layers follow both panels. The other panel shows no layers.
        browser.click("#compare [value=off]");
        recording.slide_to(3);
        wait_for_ghost(live, recording);
        wait_for_differences(3, 29);
        live.slide_to(8);
        wait_for_differences(3, 8);
        assert_eq!(lines(recording, "only-here").len(), 0);
        assert_eq!(recording.attribute(".map .ghost-mouse", "hidden"), "");
        live.click("[name=differences]");
        wait_for("no differences", || lines(live, "only-there").is_empty().then_some(()));
        assert_eq!(live.text(".differences"), "");

        // With three panels, the user chooses one.
        assert!(!browser.is_visible(&live.part("[name=other]")));
        let third = open_newest_recording(browser, "2");
        wait_for("the list", || browser.is_visible(&live.part("[name=other]")).then_some(()));
        wait_for_ghost(live, recording);
        live.choose("[name=other]", "2");
        wait_for_ghost(live, third);
        third.click("[name=close]");
        wait_for_ghost(live, recording);

        // A maze of another size.
        Page(browser).choose_maze("01-harbour.txt");
        let reason = "Ghost and Differences need mazes of the same size, not 16 × 16 and 24 × 10.";
        wait_for("the reason", || (live.text(".differences") == reason).then_some(()));
        assert_eq!(live.attribute("[name=ghost]", "disabled"), "");
        assert_eq!(simulator.info().maze, "01-harbour");

        // A single panel has no such layers.
        recording.click("[name=close]");
        let layer = live.part("[name=ghost]");
        wait_for("the layers to disappear", || (!browser.is_visible(&layer)).then_some(()));
        assert_eq!(live.text(".differences"), "");
    });
}
