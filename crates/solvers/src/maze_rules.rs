//! What contest rules require of a maze.

use core::fmt;

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, Maze, MazeSize, Wall};

use crate::driver::SearchDriver;
use crate::flood::Distances;
use crate::left_wall::LeftWall;
use crate::mouse::Mouse;

/// The rules of contests for the walls, the start and the goal of a maze.
///
/// Each set of rules requires that every cell is reachable, and that every post has a wall. The post
/// in the middle of a maze needs none, nor do posts inside the goal or inside an unreachable area.
///
/// ```
/// use mmsim_solvers::{MazeRules, MazeViolation};
/// let maze = "\
/// o---o---o---o
/// |         G |
/// o   o   o---o
/// | S         |
/// o---o---o---o
/// ".parse()?;
/// let found = MazeRules::Common.violations(&maze);
/// assert!(matches!(found[..], [MazeViolation::PostWithoutWall(_)]));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MazeRules {
    /// The rules of classic contests: the start is a corner cell with walls on three sides. The
    /// central cells are the goal, a room with one entrance and no walls inside, which a mouse that
    /// follows the walls does not find.
    Classic,
    /// The rules of half-size contests: the start is a corner cell with walls on three sides. The
    /// goal is a rectangular room anywhere, with no walls inside.
    HalfSize,
    /// The rules that all contests share.
    Common,
}

/// What a maze does against the rules of contests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MazeViolation {
    /// The start is not a corner cell.
    StartNotInCorner,
    /// The start does not have walls on exactly three sides, but on this number of sides.
    StartNotClosed(usize),
    /// The goal does not consist of the central cells.
    GoalNotCentral,
    /// The goal cells do not form a rectangle.
    GoalNotRectangular,
    /// The goal has this number of entrances, which is more than one.
    GoalEntrances(usize),
    /// A wall stands between two goal cells.
    WallInGoal(Wall),
    /// A mouse that follows the left wall finds the goal.
    GoalOnWallFollowerPath,
    /// No wall touches the post to the south-west of this cell.
    PostWithoutWall(Cell),
    /// This cell is unreachable from the start.
    UnreachableCell(Cell),
}

impl fmt::Display for MazeViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StartNotInCorner => f.write_str("the start is not in a corner"),
            Self::StartNotClosed(walls) => {
                write!(f, "the start has walls on {walls} of 4 sides instead of 3")
            }
            Self::GoalNotCentral => f.write_str("the goal is not in the centre"),
            Self::GoalNotRectangular => f.write_str("the goal is not a rectangle"),
            Self::GoalEntrances(count) => write!(f, "the goal has {count} entrances"),
            Self::WallInGoal(Wall { cell, heading, .. }) => {
                write!(f, "a wall inside the goal, {heading} of {cell}")
            }
            Self::GoalOnWallFollowerPath => f.write_str("a wall follower finds the goal"),
            Self::PostWithoutWall(cell) => {
                write!(f, "no wall touches the post south-west of {cell}")
            }
            Self::UnreachableCell(cell) => write!(f, "cell {cell} is unreachable"),
        }
    }
}

impl MazeRules {
    /// The minimum side length of a contest maze in cells. In smaller mazes, the goal touches the
    /// start or the outer wall.
    const MIN_SIDE: u8 = 5;

    /// Returns the rules for mazes of a size: classic rules for square mazes of 5×5 to 16×16 cells,
    /// half-size rules for larger square mazes, and the common rules for all other mazes.
    ///
    /// ```
    /// use mmsim_maze::MazeSize;
    /// use mmsim_solvers::MazeRules;
    /// assert_eq!(MazeRules::for_size(MazeSize::CLASSIC), MazeRules::Classic);
    /// ```
    pub fn for_size(size: MazeSize) -> Self {
        let width = size.width();
        if width != size.height() || width < Self::MIN_SIDE {
            Self::Common
        } else if width <= MazeSize::CLASSIC.width() {
            Self::Classic
        } else {
            Self::HalfSize
        }
    }

    /// Returns everything in a maze that is against the rules: first the start, then the goal, the
    /// posts, and the unreachable cells.
    pub fn violations(self, maze: &Maze) -> Vec<MazeViolation> {
        let mut found = Vec::new();
        if self != Self::Common {
            found.extend(start_violations(maze));
            found.extend(self.goal_violations(maze));
        }
        let start = CellSet::from_iter([maze.start().cell]);
        let distances = Distances::flood(maze.walls(), &start);
        let is_unreachable = |cell: &Cell| distances.at(*cell).is_none();
        let is_exempt = |Cell { x, y }: &Cell| {
            let around = [(x - 1, y - 1), (x - 1, *y), (*x, y - 1), (*x, *y)];
            let around = around.map(|(x, y)| Cell::new(x, y));
            around.iter().all(|&cell| maze.goals().contains(cell))
                || around.iter().all(is_unreachable)
        };
        let posts = maze.posts_without_wall().filter(|post| !is_exempt(post));
        found.extend(posts.map(MazeViolation::PostWithoutWall));
        let unreachable = maze.size().cells().filter(is_unreachable);
        found.extend(unreachable.map(MazeViolation::UnreachableCell));
        found
    }

    fn goal_violations(self, maze: &Maze) -> Vec<MazeViolation> {
        let (walls, goals) = (maze.walls(), maze.goals());
        let mut found = Vec::new();
        let entrances = goals.iter().flat_map(|cell| walls.open_neighbours(cell));
        let entrances = entrances.filter(|&cell| !goals.contains(cell)).count();
        if self == Self::Classic {
            if *goals != maze.size().central_cells() {
                found.push(MazeViolation::GoalNotCentral);
            }
            if entrances > 1 {
                found.push(MazeViolation::GoalEntrances(entrances));
            }
            if is_found_by_wall_follower(maze) {
                found.push(MazeViolation::GoalOnWallFollowerPath);
            }
        } else if !is_rectangle(goals) {
            found.push(MazeViolation::GoalNotRectangular);
        }
        let is_inside = |wall: &Wall| {
            walls.has(wall.cell, wall.heading) && wall.cells().all(|cell| goals.contains(cell))
        };
        found.extend(maze.size().inner_walls().filter(is_inside).map(MazeViolation::WallInGoal));
        found
    }
}

fn start_violations(maze: &Maze) -> impl Iterator<Item = MazeViolation> {
    let (size, Cell { x, y }) = (maze.size(), maze.start().cell);
    let is_corner = (x == 0 || x == size.width() - 1) && (y == 0 || y == size.height() - 1);
    let closed = Heading::ALL.len() - maze.walls().open_neighbours(maze.start().cell).count();
    let not_corner = (!is_corner).then_some(MazeViolation::StartNotInCorner);
    let not_closed = (closed != 3).then_some(MazeViolation::StartNotClosed(closed));
    not_corner.into_iter().chain(not_closed)
}

/// Returns true if the cells form one rectangle.
fn is_rectangle(cells: &CellSet) -> bool {
    let extent = |coordinate: fn(Cell) -> u8| {
        let all = || cells.iter().map(coordinate);
        all().max().zip(all().min()).map_or(0, |(max, min)| usize::from(max - min) + 1)
    };
    extent(|cell| cell.x) * extent(|cell| cell.y) == cells.len()
}

fn is_found_by_wall_follower(maze: &Maze) -> bool {
    let mut mouse = Mouse::new(LeftWall::new(), KnownMaze::unexplored(maze), maze.start());
    // A follower that has been in each pose repeats itself.
    let poses = maze.size().area() * Heading::ALL.len();
    let mut driver = SearchDriver::new(&mut mouse, u32::try_from(poses).unwrap_or(u32::MAX));
    while driver.advance_in(maze) == Ok(true) {}
    driver.stats().goal_reached()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAZE: &str = "\
o---o---o---o---o---o---o
|       |               |
o   o   o   o---o---o   o
|   |               |   |
o   o   o---o---o   o   o
|       | G   G |   |   |
o   o   o   o   o   o   o
|   |   | G   G |   |   |
o   o   o---o   o   o   o
|   |   |           |   |
o   o   o---o---o---o   o
| S |                   |
o---o---o---o---o---o---o
";

    fn violations(rules: MazeRules, text: &str) -> String {
        let found = rules.violations(&text.parse().unwrap());
        found.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    }

    #[test]
    fn each_rule_is_checked() {
        use MazeRules::{Classic, Common, HalfSize};
        let check = |rules, from: &str, to: &str, expected: &str| {
            assert_eq!(MAZE.matches(from).count(), 1, "{from}");
            assert_eq!(violations(rules, &MAZE.replace(from, to)), expected, "{rules:?} {to}");
        };
        for rules in [Classic, HalfSize, Common] {
            assert_eq!(violations(rules, MAZE), "");
        }
        let (from, to) = ("| S |                   |", "|   |             S     |");
        let start =
            "the start is not in a corner; the start has walls on 2 of 4 sides instead of 3";
        check(Classic, from, to, start);
        check(HalfSize, from, to, start);
        check(Common, from, to, "");
        let (from, two_goals) = ("|   |   | G   G |", "|   |   |       |");
        check(Classic, from, two_goals, "the goal is not in the centre; the goal has 2 entrances");
        check(HalfSize, from, two_goals, "");
        let three_goals = "|   |   | G     |";
        check(HalfSize, from, three_goals, "the goal is not a rectangle");
        let row = "|       | G   G |";
        check(Classic, row, "|         G   G |", "the goal has 2 entrances");
        check(HalfSize, row, "|         G   G |", "");
        check(HalfSize, row, "|       | G | G |", "a wall inside the goal, east of (2, 3)");
        let (from, to) = ("o   o   o---o   o   o   o", "o   o---o---o   o   o   o");
        check(Classic, from, to, "a wall follower finds the goal");
        check(HalfSize, from, to, "");
        let (from, to) = ("|       |               |", "|                       |");
        check(Common, from, to, "no wall touches the post south-west of (2, 5)");
    }

    #[test]
    fn posts_in_an_unreachable_area_need_no_wall() {
        let maze = "\
o---o---o---o---o
|     G |       |
o   o   o   o   o
|   |   |       |
o   o---o---o---o
|               |
o   o   o---o   o
| S |           |
o---o---o---o---o
";
        let cells = ["(2, 2)", "(3, 2)", "(2, 3)", "(3, 3)"];
        let expected = cells.map(|cell| format!("cell {cell} is unreachable")).join("; ");
        assert_eq!(violations(MazeRules::Common, maze), expected);
    }

    #[test]
    fn the_size_selects_the_rules() {
        let rules = |width, height| MazeRules::for_size(MazeSize::new(width, height).unwrap());
        assert_eq!([rules(5, 5), rules(16, 16)], [MazeRules::Classic; 2]);
        assert_eq!([rules(17, 17), rules(32, 32)], [MazeRules::HalfSize; 2]);
        assert_eq!([rules(4, 4), rules(16, 15), rules(1, 32)], [MazeRules::Common; 3]);
    }
}
