//! Compares the map on the page with the one expected from the maze and the client's states.

use std::fmt::Debug;

use mmsim_drawing::Scene;
use mmsim_maze::{Cell, Heading, Maze, MazeSize, Pose};
use serde::Deserialize;
use serde_json::json;

use crate::browser::Browser;
use crate::test_state::{SIDES, TestState, VISITED, neighbour};

/// The distance between cell centres in SVG user units.
const PITCH: u32 = 20;

/// The SVG attributes of a drawn map. Class names are sorted.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
pub(crate) struct Drawing {
    view_box: String,
    /// The `data-cell`, `class`, `x`, `y`, `width` and `height` attributes of each cell.
    cells: Vec<[String; 6]>,
    /// The `data-cell`, `transform` and `d` attributes of each number.
    numbers: Vec<[String; 3]>,
    /// The `data-wall`, `class` and `d` attributes of each wall.
    walls: Vec<[String; 3]>,
    /// The `class` and `transform` attributes of the mouse.
    mouse: [String; 2],
    /// The `data-passage`, `class`, `stroke` and `d` attributes of each passage of the trail.
    passages: Vec<[String; 4]>,
}

impl Drawing {
    /// Returns the map that the page should show for this maze and a client's last state. `trail`
    /// holds its passages, oldest first.
    pub(crate) fn expected(maze: &Maze, state: Option<&TestState>, trail: &[Pose]) -> Self {
        let size = maze.size();
        let classes = |class: &str, others: &[(bool, &str)]| {
            let others = others.iter().filter(|(is, _)| *is).map(|(_, name)| *name);
            sorted([class].into_iter().chain(others))
        };
        let cell_of = |cell: Cell| {
            let is_visited =
                state.is_some_and(|state| state.walls[state.index(cell)] & VISITED != 0);
            let others = [
                (cell == maze.start().cell, "start"),
                (maze.goals().contains(cell), "goal"),
                (is_visited, "visited"),
            ];
            let (x, y) = corner(size, cell);
            let pitch = PITCH.to_string();
            [name(cell), classes("cell", &others), text(x), text(y), pitch.clone(), pitch]
        };
        let number_of = |cell: Cell| {
            let has_weights = |state: &&TestState| state.weights.iter().any(|&weight| weight > 0);
            let weight = state.filter(has_weights).map(|state| state.weights[state.index(cell)]);
            let path = weight.map(mmsim_drawing::weight);
            [name(cell), format!("translate({})", centre(size, cell)), path.unwrap_or_default()]
        };
        let wall_of = |(cell, side, heading): (Cell, char, Heading)| {
            let exists = maze.walls().has(cell, heading);
            // Outer walls are known from the start.
            let is_reported = state
                .map_or_else(|| is_outer(size, cell, side), |state| state.has_wall(cell, side));
            // The client has not sent which walls it has read.
            let is_missed = exists
                && !is_reported
                && state.is_some_and(|state| {
                    let is_visited = |cell| state.walls[state.index(cell)] & VISITED != 0;
                    is_visited(cell) || size.neighbour(cell, heading).is_some_and(is_visited)
                });
            let others = [
                (exists, "true"),
                (is_reported && exists, "known"),
                (is_reported && !exists, "mistaken"),
                (is_missed, "missed"),
            ];
            let (x, y) = corner(size, cell);
            let path = match side {
                'N' => format!("M{x} {y}h{PITCH}"),
                'E' => format!("M{} {y}v{PITCH}", x + PITCH),
                'S' => format!("M{x} {}h{PITCH}", y + PITCH),
                _ => format!("M{x} {y}v{PITCH}"),
            };
            [format!("{},{side}", name(cell)), classes("wall", &others), path]
        };
        let (cell, heading) =
            state.map_or((maze.start().cell, 'N'), |state| (state.cell, state.heading));
        let turns = "NESW".find(heading).unwrap();
        let view = |cells: u8| u32::from(cells) * PITCH + 4;
        Self {
            view_box: format!("-2 -2 {} {}", view(size.width()), view(size.height())),
            cells: size.cells().map(cell_of).collect(),
            numbers: size.cells().map(number_of).collect(),
            walls: all_walls(size).map(wall_of).collect(),
            mouse: [
                "mouse".into(),
                format!("translate({}) rotate({})", centre(size, cell), 90 * turns),
            ],
            passages: passages(&Scene::from_maze(maze).with_trail(trail).page_svg()),
        }
    }

    /// Reads the map from the panel that shows the states from `source`.
    pub(crate) fn on_page(browser: &Browser, source: &str) -> Self {
        let script = r#"
            const svg = document.querySelector(`.panel[data-source="${arguments[0]}"] .map svg`);
            const read = (element, names) => names.map((name) => {
                const value = element.getAttribute(name) ?? "none";
                return name === "class" ? value.split(" ").sort().join(" ") : value;
            });
            const all = (selector, ...names) =>
                [...svg.querySelectorAll(selector)].map((element) => read(element, names));
            return {
                view_box: svg.getAttribute("viewBox"),
                cells: all(".cells > *", "data-cell", "class", "x", "y", "width", "height"),
                numbers: all(".numbers > *", "data-cell", "transform", "d"),
                walls: all(".walls > *", "data-wall", "class", "d"),
                mouse: all(".mouse", "class", "transform")[0],
                passages: all(".trail > *", "data-passage", "class", "stroke", "d"),
            };"#;
        browser.run(script, &[json!(source)])
    }

    /// Asserts that `shown` has the same elements as this map, and reports any differences.
    pub(crate) fn assert_shown(&self, shown: &Self) {
        assert_eq!(self.view_box, shown.view_box);
        assert_same("cells", &self.cells, &shown.cells);
        assert_same("numbers", &self.numbers, &shown.numbers);
        assert_same("walls", &self.walls, &shown.walls);
        assert_eq!(self.mouse, shown.mouse);
        assert_same("passages", &self.passages, &shown.passages);
    }
}

fn assert_same<T: Debug + PartialEq>(what: &str, expected: &[T], found: &[T]) {
    assert_eq!(expected.len(), found.len(), "{what}");
    let pairs = expected.iter().zip(found).filter(|(expected, found)| expected != found);
    let differing: Vec<_> = pairs.collect();
    let (count, first) = (differing.len(), &differing[..differing.len().min(4)]);
    assert!(first.is_empty(), "{count} {what} differ (expected, found): {first:#?}");
}

/// Returns the attributes of the passages in a drawing. Those that are not visible have no stroke.
fn passages(svg: &str) -> Vec<[String; 4]> {
    let attribute = |line: &str, name: &str| {
        let value = line.split_once(&format!(" {name}=\""));
        let value = value.map_or("none", |(_, rest)| rest.split('"').next().unwrap());
        if name == "class" { sorted(value.split(' ')) } else { value.to_string() }
    };
    let names = ["data-passage", "class", "stroke", "d"];
    let lines = svg.lines().filter(|line| line.contains("data-passage"));
    lines.map(|line| names.map(|name| attribute(line, name))).collect()
}

/// Returns every wall once: the north and east sides of all cells, the south sides of the southern
/// row, and the west sides of the western column.
fn all_walls(size: MazeSize) -> impl Iterator<Item = (Cell, char, Heading)> {
    let [north, east, south, west] = SIDES.map(|(letter, ..)| {
        let heading = Heading::ALL.into_iter().find(|heading| heading.letter() == letter);
        (letter, heading.unwrap())
    });
    let at = |cell, (letter, heading)| (cell, letter, heading);
    let inner = size.cells().flat_map(move |cell| [at(cell, north), at(cell, east)]);
    let south = (0..size.width()).map(move |x| at(Cell::new(x, 0), south));
    let west = (0..size.height()).map(move |y| at(Cell::new(0, y), west));
    inner.chain(south).chain(west)
}

fn is_outer(size: MazeSize, cell: Cell, letter: char) -> bool {
    let (_, dx, dy, _) = SIDES.into_iter().find(|side| side.0 == letter).unwrap();
    neighbour(size, cell, (dx, dy)).is_none()
}

fn sorted<'a>(words: impl Iterator<Item = &'a str>) -> String {
    let mut words: Vec<_> = words.collect();
    words.sort_unstable();
    words.join(" ")
}

fn name(cell: Cell) -> String {
    format!("{},{}", cell.x, cell.y)
}

fn text(number: u32) -> String {
    number.to_string()
}

/// Returns the north-west corner of a cell.
fn corner(size: MazeSize, cell: Cell) -> (u32, u32) {
    (u32::from(cell.x) * PITCH, u32::from(size.height() - 1 - cell.y) * PITCH)
}

fn centre(size: MazeSize, cell: Cell) -> String {
    let (x, y) = corner(size, cell);
    format!("{} {}", x + PITCH / 2, y + PITCH / 2)
}
