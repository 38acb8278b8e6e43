//! Comparing each element of the map with the server's maze and the client's state.

use std::collections::BTreeSet;
use std::path::Path;

use mmsim_maze::{Cell, Heading, Maze};
use mmsim_tests::shared;
use serde_json::json;

use crate::browser::{Browser, wait_for, with_page};
use crate::http;
use crate::page::{Page, Panel};
use crate::simulator::{bundled, maze_at};
use crate::test_state::{SIDES, TestState, VISITED, neighbour};

/// Loads each of these mazes and asserts that the map shows it.
fn assert_shows_each(browser: &Browser, mazes: &[(&str, Maze)]) {
    let (page, live) = (Page(browser), Panel::live(browser));
    for (path, maze) in mazes {
        page.choose_maze(path);
        wait_for(path, || (live.text("h2").starts_with(stem(path))).then_some(()));
        live.wait_until_empty();
        live.assert_shows(maze, &[]);
        assert_drawn_in_place(browser, maze);
    }
}

fn stem(path: &str) -> &str {
    path.rsplit('/').next().unwrap().trim_end_matches(".txt")
}

/// Asserts the layout of the rendered map: the first and last cells are in their corners, north is
/// up, and cells are square.
fn assert_drawn_in_place(browser: &Browser, maze: &Maze) {
    let script = r"
        const [first, last] = [...arguments].map((cell) => {
            const { left, right, top, bottom } =
                document.querySelector(`.map [data-cell='${cell}'].cell`).getBoundingClientRect();
            return { left, right, top, bottom };
        });
        const { left, right, top, bottom } = document.querySelector('.map svg').getBoundingClientRect();
        return [
            left < first.left && last.right < right && top < last.top && first.bottom < bottom,
            first.left < last.left && last.top < first.top,
            Math.abs(first.right - first.left - (first.bottom - first.top)) < 0.1,
        ];";
    let size = maze.size();
    let corner = format!("{},{}", size.width() - 1, size.height() - 1);
    let is: [bool; 3] = browser.run(script, &[json!("0,0"), json!(corner)]);
    assert_eq!(is, [true; 3]);
}

#[test]
fn every_wall_of_a_bundled_maze_is_on_the_map() {
    with_page(&[], |browser, _| {
        let mazes = [
            "oblong-long-meadow.txt",
            "half-size-old-quarter.txt",
            "training-first-steps.txt",
            "unreachable-closed-garden.txt",
            "01-harbour.txt",
        ];
        assert_shows_each(browser, &mazes.map(|path| (path, bundled(path))));
    });
}

#[test]
fn every_wall_of_a_contest_maze_is_on_the_map() {
    let Some(folder) = shared("mazes") else { return };
    with_page(&[folder.to_str().unwrap()], |browser, simulator| {
        let listed = http::get(&simulator.url("/api/mazes")).json();
        let listed = listed.as_array().unwrap();
        let readable = listed.iter().filter(|maze| maze["error"].is_null());
        assert!(readable.count() >= 281, "{listed:?}");
        // Test one maze per size and folder.
        let mut kinds = BTreeSet::new();
        let paths = listed.iter().filter_map(|maze| {
            let path = maze["path"].as_str().unwrap();
            let kind = (Path::new(path).parent(), maze["width"].as_u64(), maze["height"].as_u64());
            (maze["error"].is_null() && kinds.insert(kind)).then_some(path)
        });
        let mazes: Vec<_> = paths.map(|path| (path, maze_at(&folder.join(path)))).collect();
        assert!(mazes.len() > 3, "{}", mazes.len());
        assert_shows_each(browser, &mazes);
    });
}

#[test]
fn both_matrix_orders_are_decoded() {
    with_page(&["meadow"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let live = Panel::live(browser);
        live.wait_until_empty();
        let mut states = Vec::new();
        for (number, orders) in
            [('C', 'C'), ('F', 'F'), ('C', 'F'), ('F', 'C')].into_iter().enumerate()
        {
            states.push(TestState::new(number, maze.size()));
            let message = states[number].message(orders.0, orders.1);
            assert_ne!(message, states[number].message(orders.1, orders.0).split_off(1));
            simulator.send(&message);
            live.wait_for_state(number);
            live.assert_shows(&maze, &states);
        }
    });
}

/// Sends a message that the test assembles byte by byte.
#[test]
fn each_byte_changes_one_element() {
    with_page(&["meadow"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let live = Panel::live(browser);
        live.wait_until_empty();
        let class = |place: &str| live.attribute(&format!(r#"[data-wall="{place}"]"#), "class");
        let (width, height, area) = (24, 10, 240);
        // Cell (5, 7) is visited and has an east wall, cell (7, 5) has the weight 42.
        for (order, seven_five, five_seven) in
            [(b'C', 5 * width + 7, 7 * width + 5), (b'F', 7 * height + 5, 5 * height + 7)]
        {
            let mut message = vec![0; 6 + 2 * area];
            message[..5].copy_from_slice(&[b'S', 3, 4, b'W', order]);
            message[5 + seven_five] = 42;
            message[5 + area] = order;
            message[6 + area + five_seven] = 1 + 2;
            simulator.send(&message);
            live.wait_for_state(usize::from(order == b'F'));
            let visited: Vec<String> = browser.run(
                "return [...document.querySelectorAll('.map .visited')].map((cell) => cell.dataset.cell)",
                &[],
            );
            assert_eq!(visited, ["5,7"]);
            let number =
                |cell: &str| live.attribute(&format!(r#".number[data-cell="{cell}"]"#), "d");
            assert_eq!(number("7,5"), mmsim_drawing::digits(42));
            assert_eq!(number("5,7"), mmsim_drawing::digits(0));
            let exists = maze.walls().has(Cell::new(5, 7), Heading::East);
            assert_eq!(class("5,7,E"), if exists { "wall true known" } else { "wall mistaken" });
            assert_eq!(live.attribute(".mouse", "transform"), "translate(70 110) rotate(270)");
        }
    });
}

/// The client reports a wall that does not exist.
#[test]
fn a_wrong_wall_is_marked() {
    with_page(&["harbour"], |browser, simulator| {
        let maze = bundled("01-harbour.txt");
        let size = maze.size();
        let mut state = TestState::new(0, size);
        for cell in size.cells() {
            let bits = SIDES.iter().zip(Heading::ALL).filter_map(|(side, heading)| {
                assert_eq!(side.0, heading.letter());
                maze.walls().has(cell, heading).then_some(side.3)
            });
            let index = state.index(cell);
            state.walls[index] = bits.sum::<u8>() | VISITED;
        }
        // Only the cell south of the wall reports it.
        let is_open = |&cell: &Cell| {
            neighbour(size, cell, (0, 1)).is_some() && !maze.walls().has(cell, Heading::North)
        };
        let cell = size.cells().find(is_open).unwrap();
        let index = state.index(cell);
        state.walls[index] |= 16;
        simulator.send(&state.message('C', 'C'));

        let live = Panel::live(browser);
        live.wait_for_state(0);
        live.assert_shows(&maze, std::slice::from_ref(&state));
        let mistaken: Vec<String> = browser.run(
            "return [...document.querySelectorAll('.map .mistaken')].map((wall) => wall.dataset.wall)",
            &[],
        );
        assert_eq!(mistaken, [format!("{},{},N", cell.x, cell.y)]);
    });
}

/// The heat map has the same colours as exported pictures.
#[test]
fn the_heat_map_colours_weights() {
    with_page(&["meadow"], |browser, simulator| {
        let state = TestState::new(9, bundled("oblong-long-meadow.txt").size());
        simulator.send(&state.message('F', 'C'));
        let live = Panel::live(browser);
        live.wait_for_state(0);
        let heat = || -> Vec<[String; 2]> {
            let script = "return [...document.querySelectorAll('.map .heat')]
                .map((heat) => [heat.dataset.cell, getComputedStyle(heat).fill])";
            browser.run(script, &[])
        };
        assert!(browser.exists(&live.part(".map svg.hide-heat")));
        live.click("[name=heat]");
        wait_for("heat", || (!browser.exists(&live.part(".map svg.hide-heat"))).then_some(()));
        let largest = state.weights.iter().copied().map(u32::from).max().unwrap();
        let ramps = http::get(&simulator.url("/drawing.json")).json();
        for scheme in ["light", "dark"] {
            let feature = json!({ "name": "prefers-color-scheme", "value": scheme });
            browser.devtools("Emulation.setEmulatedMedia", &json!({ "features": [feature] }));
            let expected: Vec<_> = state
                .size
                .cells()
                .map(|cell| {
                    // Rounded to the nearest of 64 colours.
                    let weight = u32::from(state.weights[state.index(cell)]);
                    let index = (weight * 63 * 2 + largest) / (largest * 2);
                    let colour = ramps["heat"][scheme][index as usize].as_str().unwrap();
                    let colour = u32::from_str_radix(&colour[1..], 16).unwrap();
                    let [_, red, green, blue] = colour.to_be_bytes();
                    [format!("{},{}", cell.x, cell.y), format!("rgb({red}, {green}, {blue})")]
                })
                .collect();
            wait_for(scheme, || (heat() == expected).then_some(()));
        }
    });
}

#[test]
fn wall_kinds_look_different_in_light_and_dark() {
    with_page(&["meadow"], |browser, simulator| {
        let size = bundled("oblong-long-meadow.txt").size();
        simulator.send(&TestState::new(5, size).message('C', 'C'));
        Panel::live(browser).wait_for_state(0);
        // Returns colour, width and visibility.
        let look = |class: &str| -> (String, f64, bool) {
            let script = "
                const wall = [...document.querySelectorAll('.map .wall')]
                    .find((wall) => wall.getAttribute('class') === arguments[0]);
                const style = getComputedStyle(wall);
                return [
                    style.stroke,
                    parseFloat(style.strokeWidth),
                    wall.checkVisibility() && style.stroke !== 'none'
                        && parseFloat(style.opacity) * parseFloat(style.strokeOpacity) === 1,
                ];";
            browser.run(script, &[json!(class)])
        };
        let floor = || -> String {
            browser.run("return getComputedStyle(document.querySelector('.map .floor')).fill", &[])
        };
        let mut floors = BTreeSet::new();
        for scheme in ["light", "dark"] {
            let feature = json!({ "name": "prefers-color-scheme", "value": scheme });
            browser.devtools("Emulation.setEmulatedMedia", &json!({ "features": [feature] }));
            wait_for(scheme, || floors.insert(floor()).then_some(()));
            assert!(!look("wall").2, "an absent wall is invisible");
            let [unknown, known, mistaken] =
                ["wall true", "wall true known", "wall mistaken"].map(look);
            for seen in [&unknown, &known, &mistaken] {
                assert!(seen.2 && seen.0 != floor(), "{seen:?}");
            }
            assert!(known.1 > 1.9 && mistaken.1 > 1.9, "{known:?} {mistaken:?}");
            assert!(unknown.1 < 0.7 * known.1, "{unknown:?} is thin");
            assert_eq!(BTreeSet::from([&known.0, &unknown.0, &mistaken.0]).len(), 3);
        }
    });
}
