//! What a map must show, made anew from the maze and from what a client has told, and what a page
//! shows, read off its elements.

use std::fmt::Debug;

use mmsim_maze::{Cell, Heading, Maze, MazeSize};
use serde::Deserialize;
use serde_json::json;

use crate::browser::Browser;
use crate::told::{SIDES, Told, VISITED, neighbour};

/// Units from cell to cell.
const PITCH: u32 = 20;

/// A drawing by its attributes. Words of a class are in the order of the alphabet.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
pub(crate) struct Drawing {
    view_box: String,
    /// Cell, class, x, y, width, height.
    cells: Vec<[String; 6]>,
    /// Cell, transform, path.
    numbers: Vec<[String; 3]>,
    /// Cell and side, class, path.
    walls: Vec<[String; 3]>,
    /// Class and transform.
    mouse: [String; 2],
    trail: String,
}

impl Drawing {
    /// Of a maze, and of what a client has told last; its mouse was in these cells so far.
    pub(crate) fn of(maze: &Maze, told: Option<&Told>, trail: &[Cell]) -> Self {
        let size = maze.size();
        let classes = |class: &str, others: &[(bool, &str)]| {
            let others = others.iter().filter(|(is, _)| *is).map(|(_, name)| *name);
            in_order([class].into_iter().chain(others))
        };
        let cell_of = |cell: Cell| {
            let is_visited = told.is_some_and(|told| told.walls[told.index(cell)] & VISITED != 0);
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
            let some = |told: &&Told| told.weights.iter().any(|&weight| weight > 0);
            let weight = told.filter(some).map(|told| told.weights[told.index(cell)]);
            let path = weight.map(|weight| mmsim_drawing::digits(weight.into()));
            [
                name(cell),
                format!("translate({})", centre(size, cell, " ")),
                path.unwrap_or_default(),
            ]
        };
        let wall_of = |(cell, side, heading): (Cell, char, Heading)| {
            let stands = maze.walls().has(cell, heading);
            // Of outer walls everybody knows.
            let is_believed =
                told.map_or_else(|| is_outer(size, cell, side), |told| told.believes(cell, side));
            let others = [
                (stands, "true"),
                (is_believed && stands, "known"),
                (is_believed && !stands, "mistaken"),
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
            told.map_or((maze.start().cell, 'N'), |told| (told.cell, told.heading));
        let turns = "NESW".find(heading).unwrap();
        let view = |cells: u8| u32::from(cells) * PITCH + 4;
        Self {
            view_box: format!("-2 -2 {} {}", view(size.width()), view(size.height())),
            cells: size.cells().map(cell_of).collect(),
            numbers: size.cells().map(number_of).collect(),
            walls: places(size).map(wall_of).collect(),
            mouse: [
                "mouse".into(),
                format!("translate({}) rotate({})", centre(size, cell, " "), 90 * turns),
            ],
            trail: trail.iter().map(|&cell| centre(size, cell, ",")).collect::<Vec<_>>().join(" "),
        }
    }

    /// What the panel of a source shows.
    pub(crate) fn shown(browser: &Browser, source: &str) -> Self {
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
                trail: all(".trail", "points")[0][0],
            };"#;
        browser.run(script, &[json!(source)])
    }

    /// Fails if another drawing differs, and says where.
    pub(crate) fn assert_shown(&self, shown: &Self) {
        assert_eq!(self.view_box, shown.view_box);
        assert_same("cells", &self.cells, &shown.cells);
        assert_same("numbers", &self.numbers, &shown.numbers);
        assert_same("walls", &self.walls, &shown.walls);
        assert_eq!(self.mouse, shown.mouse);
        assert_eq!(self.trail, shown.trail);
    }
}

fn assert_same<T: Debug + PartialEq>(what: &str, expected: &[T], found: &[T]) {
    assert_eq!(expected.len(), found.len(), "{what}");
    let pairs = expected.iter().zip(found).filter(|(expected, found)| expected != found);
    let differing: Vec<_> = pairs.collect();
    let (count, first) = (differing.len(), &differing[..differing.len().min(4)]);
    assert!(first.is_empty(), "{count} {what} differ (expected, found): {first:#?}");
}

/// Every place of a wall once: the north and the east side of each cell, the south sides of the
/// south row, the west sides of the west column.
fn places(size: MazeSize) -> impl Iterator<Item = (Cell, char, Heading)> {
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

fn in_order<'a>(words: impl Iterator<Item = &'a str>) -> String {
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

/// The north-west corner of a cell.
fn corner(size: MazeSize, cell: Cell) -> (u32, u32) {
    (u32::from(cell.x) * PITCH, u32::from(size.height() - 1 - cell.y) * PITCH)
}

fn centre(size: MazeSize, cell: Cell, between: &str) -> String {
    let (x, y) = corner(size, cell);
    format!("{}{between}{}", x + PITCH / 2, y + PITCH / 2)
}
