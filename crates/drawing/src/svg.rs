//! The drawing itself.

use std::fmt::Write as _;

use mmsim_maze::{Cell, Heading, MazeSize, Pose};

use crate::digits::{decimals, digits};
use crate::heat::{self, Rgb};
use crate::theme::file_style;
use crate::walls::{Belief, WallClass, places};
use crate::{Layers, Scene};

/// How wide a cell is, in units.
pub(crate) const PITCH: u32 = 20;

/// How many units there are around the maze.
pub(crate) const MARGIN: u32 = 2;

/// For what a drawing is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum View {
    /// For a page that has the stylesheet and changes the drawing.
    Page,
    /// For a file, with its style.
    File,
    /// For pixels: as a file, without what cannot be seen.
    Pixels,
}

/// Writes the drawing of a scene.
pub(crate) struct Svg<'a> {
    scene: &'a Scene<'a>,
    view: View,
    text: String,
}

/// The size of the drawing of a maze in units, width and height.
pub(crate) fn units(size: MazeSize) -> (u32, u32) {
    let length = |cells: u8| u32::from(cells) * PITCH + 2 * MARGIN;
    (length(size.width()), length(size.height()))
}

impl<'a> Svg<'a> {
    /// The whole drawing.
    pub(crate) fn of(scene: &'a Scene<'a>, view: View) -> String {
        let cells = scene.size.area();
        let mut svg = Self { scene, view, text: String::with_capacity(cells * 400 + 4096) };
        svg.head();
        svg.cells();
        svg.heats();
        svg.marks();
        svg.trail();
        svg.numbers();
        svg.walls();
        svg.mouse();
        svg.text.push_str("</svg>\n");
        svg.text
    }

    fn put(&mut self, text: impl std::fmt::Display) {
        let _ = write!(self.text, "{text}");
    }

    /// Whether a layer is written at all.
    fn has(&self, layer: impl Fn(Layers) -> bool) -> bool {
        self.view != View::Pixels || layer(self.scene.layers)
    }

    fn head(&mut self) {
        let (scene, (width, height)) = (self.scene, units(self.scene.size));
        let mut class = String::from("maze");
        let mut size = String::new();
        if self.view != View::Page {
            let Layers { numbers, heat, trail } = scene.layers;
            let hidden = [(numbers, "numbers"), (heat, "heat"), (trail, "trail")];
            for (_, name) in hidden.iter().filter(|(is_shown, _)| !is_shown) {
                let _ = write!(class, " hide-{name}");
            }
            size = format!(r#" width="{}" height="{}""#, 2 * width, 2 * height);
        }
        let (columns, rows) = (scene.size.width(), scene.size.height());
        self.put(format_args!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" class="{class}" viewBox="-{MARGIN} -{MARGIN} {width} {height}"{size} role="img" aria-label="a maze of {columns} by {rows} cells">"#
        ));
        if self.view != View::Page {
            let style = file_style(scene.theme, scene.map.is_none());
            self.put(format_args!("\n<style>\n{style}</style>"));
        }
        self.put(format_args!(
            "\n<rect class=\"floor\" x=\"-{MARGIN}\" y=\"-{MARGIN}\" width=\"{width}\" height=\"{height}\"/>\n"
        ));
    }

    fn cells(&mut self) {
        let Scene { size, start, goals, map, .. } = *self.scene;
        self.put("<g class=\"cells\">\n");
        for cell in size.cells() {
            let is_visited = map.is_some_and(|map| map.visited().contains(cell));
            let classes = [
                (cell == start, " start"),
                (goals.contains(cell), " goal"),
                (is_visited, " visited"),
            ];
            let classes: String =
                classes.iter().filter(|(is, _)| *is).map(|(_, class)| *class).collect();
            if self.view == View::Pixels && classes.is_empty() {
                continue;
            }
            let (x, y) = corner(size, cell);
            self.put(format_args!(
                "<rect class=\"cell{classes}\" data-cell=\"{},{}\" x=\"{x}\" y=\"{y}\" width=\"{PITCH}\" height=\"{PITCH}\"/>\n",
                cell.x, cell.y
            ));
        }
        self.put("</g>\n");
    }

    fn heats(&mut self) {
        if !self.has(|layers| layers.heat) {
            return;
        }
        let Scene { size, ref numbers, theme, .. } = *self.scene;
        let ramp: Vec<Rgb> = heat::ramp(theme);
        let largest = numbers.iter().copied().flatten().max().unwrap_or(0);
        self.put("<g class=\"heats\">\n");
        for (index, cell) in size.cells().enumerate() {
            let number = numbers.get(index).copied().flatten();
            let colour = number.map(|number| ramp[heat::step(number, largest)].to_string());
            if self.view == View::Pixels && colour.is_none() {
                continue;
            }
            let colour = colour.unwrap_or_else(|| "none".into());
            let (x, y) = corner(size, cell);
            self.put(format_args!(
                "<rect class=\"heat\" data-cell=\"{},{}\" x=\"{x}\" y=\"{y}\" width=\"{PITCH}\" height=\"{PITCH}\" fill=\"{colour}\"/>\n",
                cell.x, cell.y
            ));
        }
        self.put("</g>\n");
    }

    /// An S in the start, a G in each goal cell, in the corner that numbers leave free.
    fn marks(&mut self) {
        let Scene { size, start, goals, .. } = *self.scene;
        self.put("<g class=\"marks\">\n");
        for cell in size.cells() {
            let (x, y) = corner(size, cell);
            for (is, class, letter) in
                [(cell == start, "start", LETTER_S), (goals.contains(cell), "goal", LETTER_G)]
            {
                if is {
                    let x = if class == "goal" && cell == start { x + 5 } else { x };
                    self.put(format_args!(
                        "<path class=\"mark {class}\" d=\"M{x} {y}{letter}\"/>\n"
                    ));
                }
            }
        }
        self.put("</g>\n");
    }

    fn trail(&mut self) {
        if !self.has(|layers| layers.trail) {
            return;
        }
        let Scene { size, trail, .. } = *self.scene;
        let points: Vec<String> = trail
            .iter()
            .filter(|&&cell| size.contains(cell))
            .map(|&cell| centre(size, cell))
            .map(|(x, y)| format!("{x},{y}"))
            .collect();
        self.put(format_args!("<polyline class=\"trail\" points=\"{}\"/>\n", points.join(" ")));
    }

    fn numbers(&mut self) {
        if !self.has(|layers| layers.numbers) {
            return;
        }
        let Scene { size, ref numbers, .. } = *self.scene;
        self.put("<g class=\"numbers\">\n");
        for (index, cell) in size.cells().enumerate() {
            let number = numbers.get(index).copied().flatten();
            if self.view == View::Pixels && number.is_none() {
                continue;
            }
            let (x, y) = centre(size, cell);
            // A number of four digits is made to fit.
            let scale = match number {
                Some(1000..) => format!(" scale({})", decimals(0.75)),
                _ => String::new(),
            };
            let path = number.map(digits).unwrap_or_default();
            self.put(format_args!(
                "<path class=\"number\" data-cell=\"{},{}\" transform=\"translate({x} {y}){scale}\" d=\"{path}\"/>\n",
                cell.x, cell.y
            ));
        }
        self.put("</g>\n");
    }

    fn walls(&mut self) {
        let Scene { size, truth, map, .. } = *self.scene;
        self.put("<g class=\"walls\">\n");
        for (cell, heading) in places(size) {
            let class = WallClass::of((cell, heading), truth, map);
            let is_seen = class.stands || class.belief != Belief::None;
            if self.view == View::Pixels && !is_seen {
                continue;
            }
            let (x, y) = corner(size, cell);
            let line = match heading {
                Heading::North => format!("M{x} {y}h{PITCH}"),
                Heading::East => format!("M{} {y}v{PITCH}", x + PITCH),
                Heading::South => format!("M{x} {}h{PITCH}", y + PITCH),
                Heading::West => format!("M{x} {y}v{PITCH}"),
            };
            self.put(format_args!(
                "<path class=\"{}\" data-wall=\"{},{},{}\" d=\"{line}\"/>\n",
                class.names(),
                cell.x,
                cell.y,
                heading.letter()
            ));
        }
        self.put("</g>\n<path class=\"posts\" d=\"");
        for row in 0..=u32::from(size.height()) {
            for column in 0..=u32::from(size.width()) {
                let corner = |post: u32| i64::from(post * PITCH) - 1;
                self.put(format_args!("M{} {}h2v2h-2z", corner(column), corner(row)));
            }
        }
        self.put("\"/>\n");
    }

    fn mouse(&mut self) {
        let Scene { size, start, mouse, .. } = *self.scene;
        if self.view == View::Pixels && mouse.is_none() {
            return;
        }
        let class = if mouse.is_some() { "mouse" } else { "mouse absent" };
        let pose = mouse.unwrap_or(Pose::new(start, Heading::North));
        let (x, y) = centre(size, pose.cell);
        let degrees = match pose.heading {
            Heading::North => 0,
            Heading::East => 90,
            Heading::South => 180,
            Heading::West => 270,
        };
        self.put(format_args!(
            "<path class=\"{class}\" transform=\"translate({x} {y}) rotate({degrees})\" d=\"{MOUSE}\"/>\n"
        ));
    }
}

/// The north-west corner of a cell, in units.
fn corner(size: MazeSize, cell: Cell) -> (u32, u32) {
    let row = u32::from(size.height()) - 1 - u32::from(cell.y);
    (u32::from(cell.x) * PITCH, row * PITCH)
}

/// The middle of a cell, in units.
fn centre(size: MazeSize, cell: Cell) -> (u32, u32) {
    let (x, y) = corner(size, cell);
    (x + PITCH / 2, y + PITCH / 2)
}

/// Letters for the corner of a cell, from its north-west corner.
const LETTER_S: &str = "m5 2.6c-.4-.4-.9-.6-1.5-.6-.8 0-1.4.4-1.4 1.1 0 1.5 3 .7 3 2.2 0 .7-.6 1.1-1.5 1.1-.7 0-1.3-.3-1.6-.7";
const LETTER_G: &str =
    "m5.2 2.8c-.3-.5-.8-.8-1.4-.8-1.1 0-1.8.9-1.8 2.2s.7 2.2 1.8 2.2c.9 0 1.6-.6 1.6-1.7h-1.5";

/// A mouse seen from above, its nose to the north: body, two ears, and a light spot on its back.
const MOUSE: &str = "M0-8C2-6.6 3-5 3.4-3.6A2.4 2.4 0 1 1 5.3.7C5.7 2 5.8 3 5.4 4.2 4.7 6.4 2.6 7.6 0 7.6S-4.7 6.4-5.4 4.2C-5.8 3-5.7 2-5.3.7A2.4 2.4 0 1 1-3.4-3.6C-3-5-2-6.6 0-8Z";

#[cfg(test)]
mod tests {
    use mmsim_maze::{CellSet, KnownMaze, Maze, WallState, Walls};
    use proptest::prelude::*;

    use super::*;
    use crate::Theme;

    fn maze() -> Maze {
        "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse().unwrap()
    }

    /// The mouse knows of one wall and believes in another one that is not there.
    fn map(maze: &Maze) -> KnownMaze {
        let mut map = KnownMaze::before(maze);
        map.visit(Cell::new(0, 0));
        map.set_wall(Cell::new(1, 0), Heading::North, WallState::Present);
        map.set_wall(Cell::new(0, 1), Heading::East, WallState::Present);
        map
    }

    #[test]
    fn a_small_maze_is_drawn_as_agreed() {
        let maze = maze();
        let map = map(&maze);
        let trail = [Cell::new(0, 0), Cell::new(0, 1)];
        let scene = Scene::of_map(&map)
            .with_truth(Some(&maze))
            .with_mouse(Pose::new(Cell::new(0, 1), Heading::East))
            .with_weights(|cell| 2 - cell.x - cell.y)
            .with_trail(&trail);
        insta::assert_snapshot!("page", scene.page_svg());
        insta::assert_snapshot!("file", scene.with_theme(Theme::Dark).svg());
    }

    #[test]
    fn a_page_begins_with_the_truth_alone() {
        let maze = maze();
        let svg = Scene::of_maze(&maze).page_svg();
        assert!(svg.contains(r#"class="mouse absent" transform="translate(10 30) rotate(0)""#));
        assert!(svg.contains(r#"<polyline class="trail" points=""/>"#));
        assert_eq!(svg.matches(r#" d=""/>"#).count(), 4, "numbers");
        assert_eq!(svg.matches(r#"fill="none""#).count(), 4);
        assert!(!svg.contains("known") && !svg.contains("style"));
    }

    #[test]
    fn weights_that_are_all_zero_are_not_shown() {
        let maze = maze();
        assert_eq!(
            Scene::of_maze(&maze).with_weights(|_| 0).page_svg(),
            Scene::of_maze(&maze).page_svg()
        );
        let svg = Scene::of_maze(&maze).with_weights(|cell| cell.x).page_svg();
        assert_eq!(svg.matches(r#"fill="none""#).count() + svg.matches(r#" d=""/>"#).count(), 0);
    }

    #[test]
    fn only_what_is_inside_is_drawn() {
        let maze = maze();
        let outside = [Cell::new(0, 0), Cell::new(7, 0)];
        let scene = Scene::of_maze(&maze)
            .with_trail(&outside)
            .with_mouse(Pose::new(Cell::new(2, 0), Heading::North));
        let svg = scene.page_svg();
        assert!(svg.contains(r#"points="10,30"/>"#) && svg.contains("absent"));
        let other = Maze::new(Walls::open(MazeSize::CLASSIC), Cell::new(0, 0), CellSet::EMPTY);
        let (map, other) = (KnownMaze::before(&maze), other.unwrap());
        let svg = Scene::of_map(&map).with_truth(Some(&other)).page_svg();
        assert_eq!(svg, Scene::of_map(&map).page_svg());
    }

    #[test]
    fn long_numbers_are_made_to_fit() {
        let maze = maze();
        let svg = Scene::of_maze(&maze).with_numbers(|_| Some(1023)).page_svg();
        assert_eq!(svg.matches(") scale(0.75)\"").count(), 4);
    }

    /// The classes of each wall in a drawing, with the side of the cell.
    fn walls_of(svg: &str) -> Vec<(String, String)> {
        let attribute = |line: &str, name: &str| {
            let (_, rest) = line.split_once(&format!(" {name}=\"")).unwrap();
            rest.split('"').next().unwrap().to_string()
        };
        let lines = svg.lines().filter(|line| line.contains(" data-wall="));
        lines.map(|line| (attribute(line, "data-wall"), attribute(line, "class"))).collect()
    }

    proptest! {
        #[test]
        fn each_wall_has_the_classes_of_the_rule(
            (width, height) in (1usize..=9, 1usize..=9),
            stands in prop::collection::vec(any::<bool>(), 2 * 81),
            believed in prop::collection::vec(0u8..3, 2 * 81),
            is_truth_known in any::<bool>(),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let mut walls = Walls::open(size);
            let mut map = KnownMaze::new(size, Cell::new(0, 0), size.central_cells());
            for (index, cell) in size.cells().enumerate() {
                for (side, heading) in [Heading::North, Heading::East].into_iter().enumerate() {
                    walls.set(cell, heading, stands[2 * index + side]);
                    let states = [WallState::Present, WallState::Absent, WallState::Unknown];
                    map.set_wall(cell, heading, states[usize::from(believed[2 * index + side])]);
                }
            }
            let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap();
            let truth = is_truth_known.then_some(&maze);
            let mut expected = Vec::new();
            let mut expect = |x: u8, y: u8, heading: Heading| {
                let cell = Cell::new(x, y);
                let mut classes = vec!["wall"];
                let stands = is_truth_known && maze.walls().has(cell, heading);
                if stands {
                    classes.push("true");
                }
                if map.wall(cell, heading) == WallState::Present {
                    classes.push(if stands || !is_truth_known { "known" } else { "mistaken" });
                }
                expected.push((format!("{x},{y},{}", heading.letter()), classes.join(" ")));
            };
            let (width, height) = (size.width(), size.height());
            for y in 0..height {
                for x in 0..width {
                    expect(x, y, Heading::North);
                    expect(x, y, Heading::East);
                }
            }
            for x in 0..width {
                expect(x, 0, Heading::South);
            }
            for y in 0..height {
                expect(0, y, Heading::West);
            }
            let svg = Scene::of_map(&map).with_truth(truth).page_svg();
            prop_assert_eq!(walls_of(&svg), expected);
        }
    }
}
