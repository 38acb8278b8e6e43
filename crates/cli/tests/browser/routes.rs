//! The shortest path and the planned path on the map.

use mmsim_maze::{Cell, Heading, Maze, MazeSize};
use mmsim_solvers::{BundledStrategy, Distances};
use serde_json::json;

use crate::browser::{Browser, with_page};
use crate::http;
use crate::page::Panel;
use crate::simulator::{Simulator, bundled};
use crate::test_state::{SIDES, TestState, neighbour};

/// Returns the cells of a line on the map.
fn cells(panel: Panel<'_>, route: &str, size: MazeSize) -> Vec<Cell> {
    let line = panel.attribute(&format!(".map .{route}-route"), "d");
    let points = line.trim_start_matches('M').split('L').filter(|point| !point.is_empty());
    let middle = |text: &str| -> u8 {
        let units: u32 = text.parse().unwrap();
        assert_eq!(units % 20, 10, "{line}");
        u8::try_from(units / 20).unwrap()
    };
    points
        .map(|point| {
            let (x, y) = point.split_once(' ').unwrap();
            Cell::new(middle(x), size.height() - 1 - middle(y))
        })
        .collect()
}

/// Follows the lowest weights, independently of mmsim. Ties do not matter for the checks.
fn assert_is_planned(path: &[Cell], state: &TestState) {
    let weight = |cell: Cell| state.weights[state.index(cell)];
    let lowest = |cell: Cell| {
        let open = SIDES.into_iter().filter(|side| !state.has_wall(cell, side.0));
        let next = open.filter_map(|(_, dx, dy, _)| neighbour(state.size, cell, (dx, dy)));
        next.map(weight).min().filter(|&lowest| lowest < weight(cell))
    };
    let Some(last) = path.last() else { return assert_eq!(lowest(state.cell), None) };
    assert_eq!(path[0], state.cell);
    for pair in path.windows(2) {
        let side = SIDES
            .into_iter()
            .find(|&(_, dx, dy, _)| neighbour(state.size, pair[0], (dx, dy)) == Some(pair[1]));
        assert!(!state.has_wall(pair[0], side.unwrap().0), "{path:?}");
        assert_eq!(lowest(pair[0]), Some(weight(pair[1])), "{path:?}");
    }
    assert_eq!(lowest(*last), None, "{path:?}");
}

/// Returns the saved picture of the shown state.
fn saved(browser: &Browser, simulator: &Simulator) -> String {
    let script = "
        document.querySelector('.export').dispatchEvent(new Event('pointerdown'));
        return document.querySelector(`.export [data-export='picture.svg']`).getAttribute('href')";
    http::get(&simulator.url(&browser.run::<String>(script, &[]))).text()
}

fn assert_is_shortest(path: &[Cell], maze: &Maze) {
    let distances = Distances::flood(maze.walls(), maze.goals());
    assert_eq!(path[0], maze.start().cell);
    for (step, &cell) in path.iter().rev().enumerate() {
        assert_eq!(distances.at(cell).map(usize::from), Some(step));
    }
    for pair in path.windows(2) {
        let is_open = |&heading: &Heading| {
            pair[0].neighbour(heading) == Some(pair[1]) && !maze.walls().has(pair[0], heading)
        };
        assert!(Heading::ALL.iter().any(is_open), "{pair:?}");
    }
}

#[test]
fn the_shortest_path_and_the_planned_path_can_be_shown() {
    with_page(&["hedgerow"], |browser, simulator| {
        let maze = bundled("05-hedgerow.txt");
        let live = Panel::live(browser);
        live.wait_until_empty();
        let states = simulator.search(&maze, BundledStrategy::ShortestPathSearch);
        let last = states.len() - 1;
        live.wait_for_state(last);
        let shown = |route: &str| cells(live, route, maze.size());
        // Both are hidden at first, also in saved pictures.
        assert_eq!((shown("shortest"), shown("planned")), (vec![], vec![]));
        assert!(!saved(browser, simulator).contains("<path class=\"shortest-route\""));
        live.click("[name=shortest]");
        live.click("[name=plan]");
        assert_is_shortest(&shown("shortest"), &maze);
        let title = || live.attribute(".plan-layer", "title");
        for at in [0, 1, 40, 60, 97, 98, 120, 187, last] {
            live.slide_to(at);
            assert_is_planned(&shown("planned"), &states[at]);
            assert_eq!(title().contains("None in this state"), shown("planned").is_empty());
        }
        assert!(title().contains("None in this state"), "at the goal");
        live.slide_to(60);
        assert!(shown("planned").len() > 5 && !title().contains("None"));
        let picture = saved(browser, simulator);
        for route in ["shortest", "planned"] {
            let path = live.attribute(&format!(".map .{route}-route"), "d");
            assert!(picture.contains(&format!("<path class=\"{route}-route\" d=\"{path}\"/>")));
        }
        live.click("[name=shortest]");
        live.click("[name=plan]");
        assert_eq!((shown("shortest"), shown("planned")), (vec![], vec![]));
        // The lines look different.
        let dashes =
            "return getComputedStyle(document.querySelector(arguments[0])).strokeDasharray";
        let dashes = |name: &str| -> String { browser.run(dashes, &[json!(live.part(name))]) };
        assert!(dashes(".map .shortest-route") != dashes(".map .planned-route"));
    });
}
