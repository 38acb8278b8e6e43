//! The map shows what the server holds and what a client believes, element by element.

use std::collections::BTreeSet;
use std::path::Path;

use mmsim_maze::{Cell, Heading, Maze};
use mmsim_tests::shared;
use serde_json::json;

use crate::browser::{Browser, wait_for, watch};
use crate::http;
use crate::page::{Page, Panel};
use crate::simulator::{bundled, maze_at};
use crate::told::{SIDES, Told, VISITED, neighbour};

/// Serves each of these mazes of the simulator's and looks whether the map shows it.
fn assert_shows_each(browser: &Browser, mazes: &[(&str, Maze)]) {
    let (page, live) = (Page(browser), Panel::live(browser));
    for (path, maze) in mazes {
        page.choose_maze(path);
        wait_for(path, || (live.text("h2").starts_with(stem(path))).then_some(()));
        live.wait_empty();
        live.assert_shows(maze, &[]);
        assert_drawn_in_place(browser, maze);
    }
}

fn stem(path: &str) -> &str {
    path.rsplit('/').next().unwrap().trim_end_matches(".txt")
}

/// A browser that has drawn it says where: the corners of the maze are where the first and the last
/// cells are, north on top, and no cell is higher than wide.
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
    watch(&[], |browser, _| {
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
    watch(&[folder.to_str().unwrap()], |browser, simulator| {
        let listed = http::get(&simulator.at("/api/mazes")).json();
        let listed = listed.as_array().unwrap();
        let readable = listed.iter().filter(|maze| maze["error"].is_null());
        assert!(readable.count() >= 281, "{listed:?}");
        // One of each size and folder.
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

/// The map must tell (x, y) from (y, x), C from F, and a wall from one that is only believed in.
#[test]
fn both_orders_land_in_the_right_cells() {
    watch(&["--maze", "meadow"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let live = Panel::live(browser);
        live.wait_empty();
        let mut told = Vec::new();
        for (number, orders) in
            [('C', 'C'), ('F', 'F'), ('C', 'F'), ('F', 'C')].into_iter().enumerate()
        {
            told.push(Told::of(number, maze.size()));
            let message = told[number].message(orders.0, orders.1);
            assert_ne!(message, told[number].message(orders.1, orders.0).split_off(1));
            simulator.send(&message);
            live.wait_at(number);
            live.assert_shows(&maze, &told);
        }
    });
}

/// One thing in one cell of a message that is written out by hand.
#[test]
fn one_byte_is_one_thing_on_the_map() {
    watch(&["--maze", "meadow"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let live = Panel::live(browser);
        live.wait_empty();
        let class = |place: &str| live.says_of(&format!(r#"[data-wall="{place}"]"#), "class");
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
            live.wait_at(usize::from(order == b'F'));
            let visited: Vec<String> = browser.run(
                "return [...document.querySelectorAll('.map .visited')].map((cell) => cell.dataset.cell)",
                &[],
            );
            assert_eq!(visited, ["5,7"]);
            let number = |cell: &str| live.says_of(&format!(r#".number[data-cell="{cell}"]"#), "d");
            assert_eq!(number("7,5"), mmsim_drawing::digits(42));
            assert_eq!(number("5,7"), mmsim_drawing::digits(0));
            let stands = maze.walls().has(Cell::new(5, 7), Heading::East);
            assert_eq!(class("5,7,E"), if stands { "wall true known" } else { "wall mistaken" });
            assert_eq!(live.says_of(".mouse", "transform"), "translate(70 110) rotate(270)");
        }
    });
}

/// A client that is right about all walls but one.
#[test]
fn a_mistaken_wall_looks_mistaken() {
    watch(&["--maze", "harbour"], |browser, simulator| {
        let maze = bundled("01-harbour.txt");
        let size = maze.size();
        let mut told = Told::of(0, size);
        for cell in size.cells() {
            let bits = SIDES.iter().zip(Heading::ALL).filter_map(|(side, heading)| {
                assert_eq!(side.0, heading.letter());
                maze.walls().has(cell, heading).then_some(side.3)
            });
            let index = told.index(cell);
            told.walls[index] = bits.sum::<u8>() | VISITED;
        }
        // Only the cell to the south of it says that it is there.
        let is_open = |&cell: &Cell| {
            neighbour(size, cell, (0, 1)).is_some() && !maze.walls().has(cell, Heading::North)
        };
        let cell = size.cells().find(is_open).unwrap();
        let index = told.index(cell);
        told.walls[index] |= 16;
        simulator.send(&told.message('C', 'C'));

        let live = Panel::live(browser);
        live.wait_at(0);
        live.assert_shows(&maze, std::slice::from_ref(&told));
        let mistaken: Vec<String> = browser.run(
            "return [...document.querySelectorAll('.map .mistaken')].map((wall) => wall.dataset.wall)",
            &[],
        );
        assert_eq!(mistaken, [format!("{},{},N", cell.x, cell.y)]);
    });
}

/// The least is cool, the largest is warm, in the colours that pictures in files have.
#[test]
fn heat_is_the_weights_in_colours() {
    watch(&["--maze", "meadow"], |browser, simulator| {
        let told = Told::of(9, bundled("oblong-long-meadow.txt").size());
        simulator.send(&told.message('F', 'C'));
        let live = Panel::live(browser);
        live.wait_at(0);
        let heat = || -> Vec<[String; 2]> {
            let script = "return [...document.querySelectorAll('.map .heat')]
                .map((heat) => [heat.dataset.cell, heat.getAttribute('fill')])";
            browser.run(script, &[])
        };
        assert!(browser.is_there(&live.part(".map svg.hide-heat")));
        live.click("[name=heat]");
        wait_for("heat", || (!browser.is_there(&live.part(".map svg.hide-heat"))).then_some(()));
        let largest = told.weights.iter().copied().map(u32::from).max().unwrap();
        let ramps = http::get(&simulator.at("/drawing.json")).json();
        for scheme in ["light", "dark"] {
            let feature = json!({ "name": "prefers-color-scheme", "value": scheme });
            browser.tell("Emulation.setEmulatedMedia", &json!({ "features": [feature] }));
            let expected: Vec<_> = told
                .size
                .cells()
                .map(|cell| {
                    // Rounded to the nearest of 64 colours.
                    let weight = u32::from(told.weights[told.index(cell)]);
                    let index = (weight * 63 * 2 + largest) / (largest * 2);
                    let colour = ramps["heat"][scheme][index as usize].as_str().unwrap();
                    [format!("{},{}", cell.x, cell.y), colour.to_string()]
                })
                .collect();
            wait_for(scheme, || (heat() == expected).then_some(()));
        }
    });
}

/// What is seen of a wall: nothing, or a colour.
#[test]
fn kinds_of_walls_are_told_apart_in_light_and_dark() {
    watch(&["--maze", "meadow"], |browser, simulator| {
        let size = bundled("oblong-long-meadow.txt").size();
        simulator.send(&Told::of(5, size).message('C', 'C'));
        Panel::live(browser).wait_at(0);
        // Colour, opacity, and whether it is painted.
        let look = |class: &str| -> (String, f64, bool) {
            let script = "
                const wall = [...document.querySelectorAll('.map .wall')]
                    .find((wall) => wall.getAttribute('class') === arguments[0]);
                const style = getComputedStyle(wall);
                return [
                    style.stroke,
                    parseFloat(style.opacity) * parseFloat(style.strokeOpacity),
                    wall.checkVisibility() && style.stroke !== 'none' && parseFloat(style.strokeWidth) >= 1,
                ];";
            browser.run(script, &[json!(class)])
        };
        let floor = || -> String {
            browser.run("return getComputedStyle(document.querySelector('.map .floor')).fill", &[])
        };
        let mut floors = BTreeSet::new();
        for scheme in ["light", "dark"] {
            let feature = json!({ "name": "prefers-color-scheme", "value": scheme });
            browser.tell("Emulation.setEmulatedMedia", &json!({ "features": [feature] }));
            wait_for(scheme, || floors.insert(floor()).then_some(()));
            assert!(!look("wall").2, "there is nothing");
            let [unknown, known, mistaken] =
                ["wall true", "wall true known", "wall mistaken"].map(look);
            for seen in [&unknown, &known, &mistaken] {
                assert!(seen.2 && seen.1 > 0.1 && seen.0 != floor(), "{seen:?}");
            }
            assert!(known.1 > 0.9 && mistaken.1 > 0.9 && unknown.1 < 0.5, "{unknown:?} is pale");
            assert_ne!(known.0, mistaken.0);
        }
    });
}
