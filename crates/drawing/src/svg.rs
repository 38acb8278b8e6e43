//! The SVG drawing.

mod labels;
pub(crate) mod legend;
mod paths;
mod walls;

use std::collections::HashMap;
use std::fmt::Write as _;
use std::ops::Range;

use mmsim_maze::{Cell, CellSet, Heading, Pose, Wall};

use crate::scene::{Layers, Scene};
use crate::shapes::{
    Area, LETTER_G, LETTER_S, MARGIN, MOUSE, PITCH, around, cell_area, centre, corner, frame,
    passage_path, trail_age, trail_gradients, trail_ink, units,
};
use crate::style::data_colours::{INSET, heat_ramp, heat_step};
use crate::style::{WallWidths, file_style};
use crate::text::Label;

/// The purpose of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum View {
    /// For a web page that contains the stylesheet and updates the drawing.
    Page,
    /// For a standalone file with its own styles.
    File,
    /// For the rasterizer, in a picture of this width. Invisible elements are omitted.
    Pixels { width_px: u32 },
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

impl Scene<'_> {
    /// Returns the drawing for a page that uses the [`stylesheet`](crate::stylesheet). The drawing
    /// contains all layers, but no styles and no size in pixels. Each element that can change has a
    /// class. If it belongs to a cell or wall, it also has an attribute that identifies that cell
    /// or wall. A page can therefore update the drawing in place:
    ///
    /// ```text
    /// <svg class="maze" viewBox="…">              hide-numbers, hide-heat, hide-trail hide a layer,
    ///                                             no-labels: lines are not faint behind labels,
    ///                                             small-cells: no labels, whatever they are
    ///   <defs> the gradients of the trail
    ///   <rect class="floor"/>
    ///   <g class="cells"> <rect class="cell [start] [goal] [visited]" data-cell="x,y"/> …
    ///   <g class="heats"> <rect class="heat" data-cell="x,y" fill="#rrggbb or none"/> …
    ///   <g class="colours"> <rect class="colour" data-cell="x,y" fill="#rrggbb"/> for coloured cells
    ///   <g class="marks"> frames and badges of start and goals, which stay
    ///   <g class="trail"> <path class="passage [age0-5]" data-passage="x,y,NE" d="line or nothing"/> …
    ///   <path class="shortest-route" d="line"/> and <path class="planned-route" d="line"/> if present
    ///   <g class="walls"> <path class="wall [true] [known, missed or mistaken]" data-wall="x,y,NESW"/> …
    ///   <path class="posts"/>
    ///   <g class="numbers"> <path class="number [on-dark or on-light]" data-cell="x,y" d="digits or nothing"/> …
    ///   <g class="texts"> <path class="text [on-dark or on-light]" data-cell="x,y" data-text="…"/> for cells with texts
    ///   <path class="mouse [absent]" transform="translate(x y) rotate(degrees)"/>
    /// </svg>
    /// ```
    ///
    /// Cells are ordered row by row from the south. The drawing contains a wall element for each
    /// possible wall. Wall elements are ordered as follows: first the north and east sides of each
    /// cell, then the south sides of the southernmost row, then the west sides of the westernmost
    /// column. The `true` class marks a wall of the true maze, `known` marks a wall on the client's
    /// map, `missed` marks a wall that exists but is absent on the client's map, and `mistaken` marks
    /// a wall on the client's map that does not exist. A wall element with none of these classes is
    /// invisible.
    pub fn page_svg(&self) -> String {
        Svg::draw(self, View::Page)
    }

    /// Returns the drawing as a standalone SVG file with the style of the theme, a size in pixels
    /// and the selected layers.
    pub fn svg(&self) -> String {
        Svg::draw(self, View::File)
    }
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
        svg.routes();
        if view != View::Page {
            svg.driven_paths();
        }
        svg.walls();
        svg.numbers();
        svg.texts();
        svg.mouse();
        if view != View::Page {
            svg.mice_on_paths();
            svg.legend();
        }
        svg.text.push_str("</svg>\n");
        (svg.text, svg.parts)
    }

    fn put(&mut self, text: impl std::fmt::Display) {
        let _ = write!(self.text, "{text}");
    }

    /// Writes an element that is visible only in this area. With [`View::Pixels`], invisible
    /// elements are omitted.
    fn put_part(&mut self, area: Area, is_visible: bool, element: impl std::fmt::Display) {
        if matches!(self.view, View::Pixels { .. }) && !is_visible {
            return;
        }
        let start = self.text.len();
        self.put(element);
        self.parts.push(Part { text: start..self.text.len(), area });
    }

    /// Returns true if the drawing contains this layer.
    fn has(&self, layer: impl Fn(Layers) -> bool) -> bool {
        !matches!(self.view, View::Pixels { .. }) || layer(self.scene.layers)
    }

    fn wall_widths(&self) -> WallWidths {
        match self.view {
            View::Page | View::File => WallWidths::default(),
            View::Pixels { width_px } => {
                let (width, _) = self.scene.extent();
                WallWidths::at_scale(f64::from(width_px) / f64::from(width))
            }
        }
    }

    fn head(&mut self) {
        let scene = self.scene;
        let is_page = self.view == View::Page;
        let (width, height) = if is_page { units(scene.size) } else { scene.extent() };
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
            let style = file_style(scene.theme, self.wall_widths(), scene.map.is_none());
            self.put(format_args!("\n<style>\n{style}</style>"));
        }
        self.put(format_args!(
            "\n{}<rect class=\"floor\" x=\"-{MARGIN}\" y=\"-{MARGIN}\" width=\"{width}\" height=\"{height}\"/>\n",
            trail_gradients()
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
        let ramp = heat_ramp(self.scene.theme);
        let number = |(_, label): (Cell, Option<&Label>)| label?.number();
        let largest = self.scene.labels().filter_map(number).max().unwrap_or(0);
        self.put("<g class=\"heats\">\n");
        for (cell, label) in self.scene.labels() {
            let number = label.and_then(Label::number);
            let colour = number.map(|number| ramp[heat_step(number, largest)].to_string());
            let colour = colour.unwrap_or_else(|| "none".into());
            self.tile("heat", cell, number.is_some(), &colour);
        }
        self.put("</g>\n");
    }

    fn colours(&mut self) {
        let size = self.scene.size;
        self.put("<g class=\"colours\">\n");
        for cell in size.cells() {
            let Some(colour) = self.scene.colour(cell) else { continue };
            self.tile("colour", cell, true, &colour.to_string());
        }
        self.put("</g>\n");
    }

    /// Draws a coloured area in a cell.
    fn tile(&mut self, class: &str, cell: Cell, is_visible: bool, fill: &str) {
        let (corner, width) = (corner(self.scene.size, cell), PITCH - 2 * INSET);
        let (x, y, Cell { x: column, y: row }) = (corner.0 + INSET, corner.1 + INSET, cell);
        self.put_part(cell_area(corner), is_visible, format_args!(
            "<rect class=\"{class}\" data-cell=\"{column},{row}\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{width}\" fill=\"{fill}\"/>\n"
        ));
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
        let aged = |(position, &passage): (usize, &Pose)| {
            let wall = Wall::new(passage.cell, passage.heading);
            (wall, (passage, trail_age(position, trail.len())))
        };
        let passages: HashMap<_, _> = trail.iter().enumerate().map(aged).collect();
        self.put("<g class=\"trail\">\n");
        for wall in size.inner_walls() {
            let Wall { cell, heading, .. } = wall;
            let (class, ink, path) = match passages.get(&wall) {
                Some(&(passage, age)) => (
                    format!("passage age{age}"),
                    format!(" stroke=\"url(#{})\"", trail_ink(heading, age)),
                    passage_path(size, passage),
                ),
                None => ("passage".into(), String::new(), String::new()),
            };
            let [area, next] = [cell, cell.neighbour(heading).unwrap_or(cell)]
                .map(|cell| cell_area(corner(size, cell)));
            let key = key(cell, heading);
            let element = format_args!(
                "<path class=\"{class}\" data-passage=\"{key}\"{ink} d=\"{path}\"/>\n"
            );
            self.put_part(around(area, next), !path.is_empty(), element);
        }
        self.put("</g>\n");
    }

    /// Draws the shortest path and the planned path.
    fn routes(&mut self) {
        let Scene { size, shortest_path, planned_path, .. } = self.scene;
        for (name, path) in [("shortest", shortest_path), ("planned", planned_path)] {
            let cells = path.iter().filter(|cell| size.contains(**cell));
            let points: Vec<_> = cells.clone().map(|&cell| centre(*size, cell)).collect();
            let areas = cells.map(|&cell| cell_area(corner(*size, cell)));
            let Some(area) = areas.reduce(around) else { continue };
            let line: Vec<_> = points.iter().map(|(x, y)| format!("{x} {y}")).collect();
            let line = line.join("L");
            let element = format_args!("<path class=\"{name}-route\" d=\"M{line}\"/>\n");
            self.put_part(area, true, element);
        }
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

/// Returns the text that identifies a wall or a passage of a cell in a page.
fn key(cell: Cell, heading: Heading) -> String {
    format!("{},{},{}", cell.x, cell.y, heading.letter())
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{KnownMaze, Maze, MazeSize, WallState, Walls};

    use super::*;
    use crate::style::colour::Theme;

    pub(crate) fn maze() -> Maze {
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
    fn paths_are_lines_below_the_walls() {
        let maze = maze();
        let cells = |list: &[(u8, u8)]| list.iter().map(|&(x, y)| Cell::new(x, y)).collect();
        let bare = Scene::from_maze(&maze);
        assert!(!bare.svg().contains("<path class=\"shortest-route\""));
        let scene = bare
            .with_shortest_path(cells(&[(0, 0), (0, 1), (1, 1)]))
            .with_planned_path(cells(&[(1, 0), (9, 9), (1, 1)]));
        let height = 20 * u32::from(maze.size().height());
        let (south, north) = (height - 10, height - 30);
        for drawing in [scene.svg(), scene.page_svg()] {
            let lines = format!(
                "<path class=\"shortest-route\" d=\"M10 {south}L10 {north}L30 {north}\"/>\n\
                 <path class=\"planned-route\" d=\"M30 {south}L30 {north}\"/>\n\
                 <g class=\"walls\">"
            );
            assert!(drawing.contains(&lines), "{drawing}");
        }
        let plain = Scene::from_maze(&maze).png(400).unwrap();
        assert!(scene.png(400).unwrap() != plain);
    }

    #[test]
    fn the_drawing_of_a_small_maze_is_stable() {
        let maze = maze();
        let map = map(&maze);
        let trail = [Pose::new(Cell::new(0, 0), Heading::North)];
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
    fn numbers_are_above_all_lines() {
        let svg = Scene::from_maze(&maze()).page_svg();
        let places = ["trail", "walls", "posts", "numbers"]
            .map(|class| svg.find(&format!("class=\"{class}\"")).unwrap());
        assert!(places.is_sorted(), "{places:?}");
    }

    #[test]
    fn items_outside_the_maze_are_ignored() {
        let maze = maze();
        let outside = [Pose::new(Cell::new(6, 0), Heading::East)];
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
}
