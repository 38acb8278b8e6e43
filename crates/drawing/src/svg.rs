//! The SVG drawing.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::ops::Range;

use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Pose};

use crate::colours::{self, INSET};
use crate::font::decimals;
use crate::geometry::{Area, MARGIN, PITCH, around, cell_area, centre, corner, units};
use crate::heat::{self, Rgb};
use crate::label::{self, Label};
use crate::marks::{LETTER_G, LETTER_S, MOUSE, frame};
use crate::passages;
use crate::scene::{Layers, Scene};
use crate::theme::file_style;
use crate::trail::Trail;
use crate::walls::{self, INVISIBLE};

/// The purpose of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum View {
    /// For a web page that contains the stylesheet and updates the drawing.
    Page,
    /// For a standalone file with its own styles.
    File,
    /// For the rasterizer. Invisible elements are omitted.
    Pixels,
}

/// A writer that draws a scene as SVG.
pub(crate) struct Svg<'a> {
    scene: &'a Scene<'a>,
    view: View,
    text: String,
    parts: Vec<Part>,
}

/// An element of a drawing that can be omitted, and the area in which it is visible.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// The byte range of the element in the text.
    pub(crate) text: Range<usize>,
    pub(crate) area: Area,
}

impl<'a> Svg<'a> {
    /// Returns the whole drawing.
    pub(crate) fn draw(scene: &'a Scene<'a>, view: View) -> String {
        Self::with_parts(scene, view).0
    }

    /// Returns the whole drawing and its parts in document order.
    pub(crate) fn with_parts(scene: &'a Scene<'a>, view: View) -> (String, Vec<Part>) {
        let text = String::with_capacity(scene.size.area() * 400 + 4096);
        let mut svg = Self { scene, view, text, parts: Vec::new() };
        svg.head();
        svg.cells();
        svg.heats();
        svg.colours();
        svg.marks();
        svg.trail();
        svg.walls();
        svg.numbers();
        svg.texts();
        svg.mouse();
        svg.text.push_str("</svg>\n");
        (svg.text, svg.parts)
    }

    fn put(&mut self, text: impl std::fmt::Display) {
        let _ = write!(self.text, "{text}");
    }

    /// Writes an element that is visible only in this area. With [`View::Pixels`], invisible
    /// elements are omitted.
    fn put_part(&mut self, area: Area, is_visible: bool, element: impl std::fmt::Display) {
        if self.view == View::Pixels && !is_visible {
            return;
        }
        let start = self.text.len();
        self.put(element);
        self.parts.push(Part { text: start..self.text.len(), area });
    }

    /// Returns true if the drawing contains this layer.
    fn has(&self, layer: impl Fn(Layers) -> bool) -> bool {
        self.view != View::Pixels || layer(self.scene.layers)
    }

    fn head(&mut self) {
        let (scene, (width, height)) = (self.scene, units(self.scene.size));
        let mut class = String::from("maze");
        let mut size = String::new();
        if self.view != View::Page {
            let Layers { numbers, heat, trail, .. } = scene.layers;
            let hidden = [(numbers, "numbers"), (heat, "heat"), (trail, "trail")];
            for (_, name) in hidden.iter().filter(|(is_shown, _)| !is_shown) {
                let _ = write!(class, " hide-{name}");
            }
            if !numbers && !scene.has_texts() {
                class.push_str(" no-labels");
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
            "\n{}<rect class=\"floor\" x=\"-{MARGIN}\" y=\"-{MARGIN}\" width=\"{width}\" height=\"{height}\"/>\n",
            passages::gradients()
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
            let (x, y) = corner(size, cell);
            self.put_part(cell_area((x, y)), !classes.is_empty(), format_args!(
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
        let Scene { size, theme, .. } = *self.scene;
        let ramp: Vec<Rgb> = heat::ramp(theme);
        let number = |(_, label): (Cell, Option<&Label>)| label?.number();
        let largest = self.scene.labels().filter_map(number).max().unwrap_or(0);
        self.put("<g class=\"heats\">\n");
        for (cell, label) in self.scene.labels() {
            let number = label.and_then(Label::number);
            let colour = number.map(|number| ramp[heat::step(number, largest)].to_string());
            let colour = colour.unwrap_or_else(|| "none".into());
            let (x, y) = corner(size, cell);
            let tile = tile((x, y));
            self.put_part(
                cell_area((x, y)),
                number.is_some(),
                format_args!(
                    "<rect class=\"heat\" data-cell=\"{},{}\" {tile} fill=\"{colour}\"/>\n",
                    cell.x, cell.y
                ),
            );
        }
        self.put("</g>\n");
    }

    fn colours(&mut self) {
        let size = self.scene.size;
        self.put("<g class=\"colours\">\n");
        for cell in size.cells() {
            let Some(colour) = self.scene.colour(cell) else { continue };
            let (x, y) = corner(size, cell);
            let tile = tile((x, y));
            self.put_part(
                cell_area((x, y)),
                true,
                format_args!(
                    "<rect class=\"colour\" data-cell=\"{},{}\" {tile} fill=\"{colour}\"/>\n",
                    cell.x, cell.y
                ),
            );
        }
        self.put("</g>\n");
    }

    /// Returns the class of the label of a cell, preceded by a space.
    fn label_class(&self, cell: Cell) -> String {
        let colour = self.scene.colour(cell);
        colour.map(|colour| format!(" {}", colours::label_class(colour))).unwrap_or_default()
    }

    /// Draws a frame with the badge S around the start cell, and a frame with the badge G around
    /// the goal cells. The frames and badges are drawn on top of the heat colours.
    fn marks(&mut self) {
        let Scene { size, start, goals, .. } = *self.scene;
        self.put("<g class=\"marks\">\n");
        let inside = |cell: &Cell| size.contains(*cell);
        let starts: CellSet = [start].into_iter().filter(inside).collect();
        let goals: CellSet = goals.iter().filter(inside).collect();
        for (class, cells, letter) in [("start", starts, LETTER_S), ("goal", goals, LETTER_G)] {
            for cell in &cells {
                self.mark(class, cell, &cells, letter);
            }
        }
        self.put("</g>\n");
    }

    /// Draws the part of the frame that lies in `cell`, and the badge if `cell` is the north-west
    /// corner of the frame.
    fn mark(&mut self, class: &str, cell: Cell, cells: &CellSet, letter: &str) {
        let Scene { size, start, .. } = *self.scene;
        let (x, y) = corner(size, cell);
        let frame = frame(size, cell, cells);
        if !frame.is_empty() {
            let mark = format_args!("<path class=\"mark {class}\" d=\"{frame}\"/>\n");
            // The frame may bend around a corner of the adjacent cells.
            let [west, north, east, south] = cell_area((x, y));
            self.put_part([west - 3, north - 3, east + 3, south + 3], true, mark);
        }
        let goes_on = |side| cell.neighbour(side).is_some_and(|next| cells.contains(next));
        if goes_on(Heading::North) || goes_on(Heading::West) {
            return;
        }
        // If start and goal share a cell, the G is drawn beside the S.
        let left = if class == "goal" && cell == start { x + 7 } else { x + 1 };
        let top = y + 1;
        self.put_part(
            cell_area((x, y)),
            true,
            format_args!(
                "<path class=\"badge {class}\" d=\"M{left} {top}h5.8v4.2a1.6 1.6 0 0 1-1.6 1.6h-4.2z\"/>\n\
                 <path class=\"letter\" d=\"M{} {}{letter}\"/>\n",
                left + 3,
                top + 3,
            ),
        );
    }

    fn trail(&mut self) {
        if !self.has(|layers| layers.trail) {
            return;
        }
        let Scene { size, trail, .. } = *self.scene;
        let passages = trail.map(Trail::passages).unwrap_or_default();
        let count = passages.len();
        let passages: HashMap<_, _> = (passages.into_iter().enumerate())
            .map(|(position, passage)| (passage.side(), (passage, passages::age(position, count))))
            .collect();
        self.put("<g class=\"trail\">\n");
        for (cell, heading) in walls::inner_places(size) {
            let (class, ink, path) = match passages.get(&(cell, heading)) {
                Some(&(passage, age)) => (
                    format!("passage age{age}"),
                    format!(" stroke=\"url(#{})\"", passages::ink(heading, age)),
                    passages::path(size, passage),
                ),
                None => ("passage".into(), String::new(), String::new()),
            };
            let [area, next] = [cell, cell.neighbour(heading).unwrap_or(cell)]
                .map(|cell| cell_area(corner(size, cell)));
            self.put_part(
                around(area, next),
                !path.is_empty(),
                format_args!(
                    "<path class=\"{class}\" data-passage=\"{},{},{}\"{ink} d=\"{path}\"/>\n",
                    cell.x,
                    cell.y,
                    heading.letter()
                ),
            );
        }
        self.put("</g>\n");
    }

    fn numbers(&mut self) {
        if !self.has(|layers| layers.numbers) {
            return;
        }
        let size = self.scene.size;
        self.put("<g class=\"numbers\">\n");
        for (cell, label) in self.scene.labels() {
            let label = label.filter(|_| self.scene.text(cell).is_none());
            let (class, position) =
                (self.label_class(cell), position(size, cell, label.map_or(1.0, Label::scale)));
            let path = label.map(Label::path).unwrap_or_default();
            self.put_part(cell_area(corner(size, cell)), label.is_some(), format_args!(
                "<path class=\"number{class}\" data-cell=\"{},{}\" transform=\"{position}\" d=\"{path}\"/>\n",
                cell.x, cell.y
            ));
        }
        self.put("</g>\n");
    }

    fn texts(&mut self) {
        let size = self.scene.size;
        self.put("<g class=\"texts\">\n");
        for cell in size.cells() {
            let Some(text) = self.scene.text(cell) else { continue };
            let ((path, scale), class) = (label::text(text), self.label_class(cell));
            let position = position(size, cell, scale);
            self.put_part(cell_area(corner(size, cell)), true, format_args!(
                "<path class=\"text{class}\" data-cell=\"{},{}\" data-text=\"{}\" transform=\"{position}\" d=\"{path}\"/>\n",
                cell.x, cell.y, escape(text)
            ));
        }
        self.put("</g>\n");
    }

    fn walls(&mut self) {
        let Scene { size, truth, map, .. } = *self.scene;
        self.put("<g class=\"walls\">\n");
        for (cell, heading) in walls::places(size) {
            let class = walls::class((cell, heading), truth, map);
            let (x, y) = corner(size, cell);
            let line = match heading {
                Heading::North => format!("M{x} {y}h{PITCH}"),
                Heading::East => format!("M{} {y}v{PITCH}", x + PITCH),
                Heading::South => format!("M{x} {}h{PITCH}", y + PITCH),
                Heading::West => format!("M{x} {y}v{PITCH}"),
            };
            // A wall extends half its width beyond each side of the cell.
            let [west, north, east, south] = cell_area((x, y));
            let area = [west - 1, north - 1, east + 1, south + 1];
            self.put_part(
                area,
                class != INVISIBLE,
                format_args!(
                    "<path class=\"{class}\" data-wall=\"{},{},{}\" d=\"{line}\"/>\n",
                    cell.x,
                    cell.y,
                    heading.letter()
                ),
            );
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
        let class = if mouse.is_some() { "mouse" } else { "mouse absent" };
        let start = if size.contains(start) { start } else { Cell::new(0, 0) };
        let pose = mouse.unwrap_or(Pose::new(start, Heading::North));
        let (x, y) = centre(size, pose.cell);
        let degrees = 90 * pose.heading as u16;
        self.put_part(cell_area(corner(size, pose.cell)), mouse.is_some(), format_args!(
            "<path class=\"{class}\" transform=\"translate({x} {y}) rotate({degrees})\" d=\"{MOUSE}\"/>\n"
        ));
    }
}

/// Returns the attributes of a coloured area in the cell with this corner.
fn tile((x, y): (u32, u32)) -> String {
    let (x, y, width) = (x + INSET, y + INSET, PITCH - 2 * INSET);
    format!(r#"x="{x}" y="{y}" width="{width}" height="{width}""#)
}

/// Returns the transformation of a label in this cell.
fn position(size: MazeSize, cell: Cell, scale: f64) -> String {
    let ((x, y), scale) = (centre(size, cell), decimals(scale));
    let scale = if scale == "1" { String::new() } else { format!(" scale({scale})") };
    format!("translate({x} {y}){scale}")
}

/// Escapes a text for an attribute of an XML document. Control characters, U+FFFE and U+FFFF are
/// removed, because XML documents cannot contain them.
fn escape(text: &str) -> String {
    let is_allowed = |c: &char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    let text: String = text.chars().filter(is_allowed).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{KnownMaze, Maze, WallState, Walls};
    use proptest::prelude::*;

    use super::*;
    use crate::font::digits;
    use crate::heat::ramp;
    use crate::label::INFINITY;
    use crate::theme::Theme;
    use crate::trail::through;

    fn maze() -> Maze {
        "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse().unwrap()
    }

    /// Returns a map with one wall that exists and one wall that does not exist.
    fn map(maze: &Maze) -> KnownMaze {
        let mut map = KnownMaze::unexplored(maze);
        map.visit(Cell::new(0, 0));
        map.set_wall(Cell::new(1, 0), Heading::North, WallState::Present);
        map.set_wall(Cell::new(0, 1), Heading::East, WallState::Present);
        map
    }

    #[test]
    fn the_drawing_of_a_small_maze_is_stable() {
        let maze = maze();
        let map = map(&maze);
        let trail = through(maze.size(), &[Cell::new(0, 0), Cell::new(0, 1)]);
        let scene = Scene::from_map(&map)
            .with_truth(Some(&maze))
            .with_mouse(Pose::new(Cell::new(0, 1), Heading::East))
            .with_weights(|cell| 2 - cell.x - cell.y)
            .with_trail(&trail);
        insta::assert_snapshot!("page", scene.page_svg());
        insta::assert_snapshot!("file", scene.with_theme(Theme::Dark).svg());
    }

    #[test]
    fn a_page_starts_with_the_true_maze_only() {
        let maze = maze();
        let svg = Scene::from_maze(&maze).page_svg();
        assert!(svg.contains(r#"class="mouse absent" transform="translate(10 30) rotate(0)""#));
        assert!(!svg.contains("passage age"));
        assert_eq!(svg.matches(r#" d=""/>"#).count(), 8, "numbers and passages");
        assert_eq!(svg.matches(r#"fill="none""#).count(), 4);
        assert!(!svg.contains("known") && !svg.contains("style"));
    }

    #[test]
    fn all_zero_weights_are_hidden() {
        let maze = maze();
        assert_eq!(
            Scene::from_maze(&maze).with_weights(|_| 0).page_svg(),
            Scene::from_maze(&maze).page_svg()
        );
        let svg = Scene::from_maze(&maze).with_weights(|cell| cell.x).page_svg();
        assert_eq!((svg.matches(r#"fill="none""#).count(), numbers(&svg).len()), (0, 4));
    }

    /// Returns the paths of the numbers in a drawing.
    fn numbers(svg: &str) -> Vec<&str> {
        let lines = svg.lines().filter(|line| line.starts_with(r#"<path class="number"#));
        let paths = lines.map(|line| line.rsplit('"').nth(1).unwrap());
        paths.filter(|path| !path.is_empty()).collect()
    }

    #[test]
    fn the_weight_255_is_infinite_and_has_no_heat_colour() {
        let maze = maze();
        let weight = |cell: Cell| if cell == Cell::new(1, 1) { 255 } else { cell.x + cell.y };
        let svg = Scene::from_maze(&maze).with_weights(weight).page_svg();
        assert_eq!(numbers(&svg), [&digits(0), &digits(1), &digits(1), INFINITY]);
        assert!(svg.contains(r#"data-cell="1,1" x="22" y="2" width="16" height="16" fill="none""#));
        assert_eq!(svg.matches(r#"fill="none""#).count(), 1);
        let warmest = ramp(Theme::Light)[63].to_string();
        assert_eq!(svg.matches(&warmest).count(), 2, "1 is the largest weight");
        let numbered = Scene::from_maze(&maze).with_numbers(|_| Some(255)).page_svg();
        assert_eq!(numbers(&numbered), [&digits(255)[..]; 4]);
    }

    #[test]
    fn texts_replace_numbers_and_follow_the_colour_of_the_cell() {
        let maze = maze();
        let text = |cell: Cell| ["1200", "", "<\"é&\"> 12", ""][usize::from(2 * cell.y + cell.x)];
        let colour =
            |cell: Cell| ['w', 'B', '?', 'y'].get(usize::from(2 * cell.y + cell.x)).copied();
        let scene = Scene::from_maze(&maze).with_weights(|_| 7);
        let svg = scene.with_texts(text).with_colours(colour).svg();
        let lines = |start: &str| -> Vec<&str> {
            svg.lines().filter(|line| line.starts_with(start)).collect()
        };
        let (first, first_scale) = label::text("1200");
        assert_eq!(
            lines("<path class=\"text"),
            [
                format!(
                    r#"<path class="text on-light" data-cell="0,0" data-text="1200" transform="translate(10 30) scale({first_scale})" d="{first}"/>"#
                ),
                format!(
                    r#"<path class="text" data-cell="0,1" data-text="&lt;&quot;é&amp;&quot;> 12" transform="translate(10 10) scale(0.6)" d="{}"/>"#,
                    label::text("<\"é&\"> 12").0
                ),
            ]
        );
        assert_eq!(numbers(&svg), [digits(7), digits(7)]);
        let classes = ["number on-light", "number on-dark", "number", "number on-light"];
        for (line, class) in lines("<path class=\"number").into_iter().zip(classes) {
            assert!(line.contains(&format!("class=\"{class}\"")), "{line}");
        }
        let colours: Vec<_> = lines("<rect class=\"colour\"")
            .into_iter()
            .map(|line| (line.split('"').nth(3).unwrap(), line.rsplit('"').nth(1).unwrap()))
            .collect();
        assert_eq!(colours, [("0,0", "#ffffff"), ("1,0", "#000033"), ("1,1", "#b3b300")]);
    }

    #[test]
    fn weight_0_is_hidden_if_other_cells_have_texts() {
        let maze = maze();
        let text = |cell: Cell| ["0", "12"].get(usize::from(cell.x + 2 * cell.y)).copied();
        let scene = Scene::from_maze(&maze)
            .with_weights(|cell| if cell == Cell::new(1, 0) { 12 } else { 0 })
            .with_texts(|cell| text(cell).unwrap_or_default());
        let svg = scene.page_svg();
        assert_eq!(numbers(&svg), [""; 0], "a number in a cell without a text");
        assert_eq!(svg.matches(r#"fill="none""#).count(), 2, "heat colours of cells without texts");
        let without_texts = scene.with_layers(Layers { texts: false, ..Layers::ALL }).page_svg();
        assert_eq!(numbers(&without_texts), [0, 12, 0, 0].map(digits));
        assert!(!without_texts.contains("data-text"));
    }

    #[test]
    fn characters_that_xml_forbids_are_removed() {
        let text = "a\u{1}\u{7f}\u{85}\u{fffd}\u{fffe}\u{ffff}b";
        let maze = maze();
        let scene = Scene::from_maze(&maze).with_texts(|_| text);
        assert!(scene.svg().contains("data-text=\"a\u{fffd}b\""));
        assert!(scene.png(200).is_ok());
    }

    #[test]
    fn numbers_are_above_all_lines() {
        let svg = Scene::from_maze(&maze()).page_svg();
        let places = ["trail", "walls", "posts", "numbers"]
            .map(|class| svg.find(&format!("class=\"{class}\"")).unwrap());
        assert!(places.is_sorted(), "{places:?}");
    }

    #[test]
    fn items_outside_the_maze_are_ignored() {
        let maze = maze();
        let wide = MazeSize::new(8, 1).unwrap();
        let outside = through(wide, &[Cell::new(0, 0), Cell::new(1, 0)]);
        let scene = Scene::from_maze(&maze)
            .with_trail(&outside)
            .with_mouse(Pose::new(Cell::new(2, 0), Heading::North));
        let svg = scene.page_svg();
        assert!(!svg.contains("passage age") && svg.contains("absent"));
        let far = Cell::new(200, 200);
        let map = KnownMaze::new(maze.size(), far, [far].into_iter().collect());
        let svg = Scene::from_map(&map).svg();
        assert!(!svg.contains("class=\"mark ") && svg.contains("mouse absent"), "{svg}");
        let other = Maze::new(Walls::open(MazeSize::CLASSIC), Cell::new(0, 0), CellSet::EMPTY);
        let (map, other) = (KnownMaze::unexplored(&maze), other.unwrap());
        let svg = Scene::from_map(&map).with_truth(Some(&other)).page_svg();
        assert_eq!(svg, Scene::from_map(&map).page_svg());
    }

    #[test]
    fn long_numbers_are_scaled_to_fit() {
        let maze = maze();
        let svg = Scene::from_maze(&maze).with_numbers(|_| Some(1023)).page_svg();
        assert_eq!(svg.matches(") scale(0.75)\"").count(), 4);
    }

    /// Returns the walls of a drawing, each with its classes.
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
        fn walls_have_the_expected_classes(
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
            let svg = Scene::from_map(&map).with_truth(truth).page_svg();
            prop_assert_eq!(walls_of(&svg), expected);
        }
    }
}
