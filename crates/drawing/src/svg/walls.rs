//! The walls and posts of a drawing.

use mmsim_maze::{Cell, Heading, KnownMaze, Maze, MazeSize, Wall, WallState};

use super::{Svg, key};
use crate::scene::Scene;
use crate::shapes::{PITCH, cell_area, corner};

impl Svg<'_> {
    pub(super) fn walls(&mut self) {
        let Scene { size, truth, map, .. } = *self.scene;
        // A wall extends half its width beyond each side of the cell.
        #[expect(clippy::cast_possible_truncation, reason = "at most 3")]
        let half = (self.wall_widths().known / 2.0).ceil() as i32;
        self.put("<g class=\"walls\">\n");
        for wall in all_walls(size) {
            let (Wall { cell, heading, .. }, class) = (wall, wall_class(wall, truth, map));
            let (x, y) = corner(size, cell);
            let line = match heading {
                Heading::North => format!("M{x} {y}h{PITCH}"),
                Heading::East => format!("M{} {y}v{PITCH}", x + PITCH),
                Heading::South => format!("M{x} {}h{PITCH}", y + PITCH),
                Heading::West => format!("M{x} {y}v{PITCH}"),
            };
            let [west, north, east, south] = cell_area((x, y));
            let area = [west - half, north - half, east + half, south + half];
            let key = key(cell, heading);
            let element =
                format_args!("<path class=\"{class}\" data-wall=\"{key}\" d=\"{line}\"/>\n");
            self.put_part(area, class != INVISIBLE, element);
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

/// Returns all walls that a maze can have, each once: [`MazeSize::walls`], then the outer walls in the
/// south, then those in the west.
pub(crate) fn all_walls(size: MazeSize) -> impl Iterator<Item = Wall> {
    let south = (0..size.width()).map(|x| Wall::new(Cell::new(x, 0), Heading::South));
    let west = (0..size.height()).map(|y| Wall::new(Cell::new(0, y), Heading::West));
    size.walls().chain(south).chain(west)
}

/// The class of a wall that is neither in the true maze nor on the client's map.
pub(crate) const INVISIBLE: &str = "wall";

/// Returns the class attribute of a wall.
pub(crate) fn wall_class(
    Wall { cell, heading, .. }: Wall,
    truth: Option<&Maze>,
    map: Option<&KnownMaze>,
) -> &'static str {
    let stands = truth.is_some_and(|maze| maze.walls().has(cell, heading));
    let reported = map.map_or(WallState::Unknown, |map| map.wall(cell, heading));
    match (stands, reported) {
        (false, WallState::Absent | WallState::Unknown) => INVISIBLE,
        (true, WallState::Unknown) => "wall true",
        (true, WallState::Absent) => "wall true missed",
        (true, WallState::Present) => "wall true known",
        (false, WallState::Present) if truth.is_none() => "wall known",
        (false, WallState::Present) => "wall mistaken",
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

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

    #[test]
    fn each_wall_occurs_once() {
        for (width, height) in [(1, 1), (3, 2), (32, 5)] {
            let size = MazeSize::new(width, height).unwrap();
            // Identify a wall by its midpoint in half cells, so that both adjacent cells agree.
            let middle = |Wall { cell, heading, .. }: Wall| {
                let (x, y) = (2 * u16::from(cell.x) + 1, 2 * u16::from(cell.y) + 1);
                match heading {
                    Heading::North => (x, y + 1),
                    Heading::East => (x + 1, y),
                    Heading::South => (x, y - 1),
                    Heading::West => (x - 1, y),
                }
            };
            let distinct: BTreeSet<_> = all_walls(size).map(middle).collect();
            assert_eq!(all_walls(size).count(), distinct.len());
            assert_eq!(distinct.len(), width * (height + 1) + height * (width + 1));
        }
    }
}
