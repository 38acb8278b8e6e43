//! The walls and posts of a drawing.

use mmsim_maze::{Heading, Wall};

use super::Svg;
use crate::geometry::{PITCH, cell_area, corner};
use crate::scene::Scene;
use crate::walls::{self, INVISIBLE};

impl Svg<'_> {
    pub(super) fn walls(&mut self) {
        let Scene { size, truth, map, .. } = *self.scene;
        // A wall extends half its width beyond each side of the cell.
        #[expect(clippy::cast_possible_truncation, reason = "at most 3")]
        let half = (self.wall_widths().known / 2.0).ceil() as i32;
        self.put("<g class=\"walls\">\n");
        for wall in walls::all(size) {
            let (Wall { cell, heading, .. }, class) = (wall, walls::class(wall, truth, map));
            let (x, y) = corner(size, cell);
            let line = match heading {
                Heading::North => format!("M{x} {y}h{PITCH}"),
                Heading::East => format!("M{} {y}v{PITCH}", x + PITCH),
                Heading::South => format!("M{x} {}h{PITCH}", y + PITCH),
                Heading::West => format!("M{x} {y}v{PITCH}"),
            };
            let [west, north, east, south] = cell_area((x, y));
            let area = [west - half, north - half, east + half, south + half];
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
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, CellSet, KnownMaze, Maze, MazeSize, WallState, Walls};
    use proptest::prelude::*;

    use super::*;

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
            for (Wall { cell, heading, .. }, (stands, believed)) in
                size.walls().zip(stands.into_iter().zip(believed))
            {
                walls.set(cell, heading, stands);
                let states = [WallState::Present, WallState::Absent, WallState::Unknown];
                map.set_wall(cell, heading, states[usize::from(believed)]);
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
                match map.wall(cell, heading) {
                    WallState::Present if stands || !is_truth_known => classes.push("known"),
                    WallState::Present => classes.push("mistaken"),
                    WallState::Absent if stands => classes.push("missed"),
                    WallState::Absent | WallState::Unknown => {}
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
