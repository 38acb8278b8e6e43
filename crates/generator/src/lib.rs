//! Random micromouse mazes in the styles contest, perfect and open. The same seed gives the same
//! maze on every machine and in every version.
//!
//! ```
//! use mmsim_generator::{Style, generate};
//! use mmsim_maze::{Cell, Heading, MazeSize};
//!
//! let maze = generate(MazeSize::CLASSIC, 7, Style::Contest);
//! assert!(maze.walls().has(Cell::new(0, 0), Heading::East), "the start opens only to the north");
//! assert_eq!(maze, generate(MazeSize::CLASSIC, 7, Style::Contest));
//! ```
//!
//! In every maze the start is (0, 0), with an opening only to the north. The goal is the room of
//! the central cells ([`MazeSize::central_cells`]), which has no walls inside. Every cell is
//! reachable. The smallest mazes are exceptions: a start that is a goal cell is open to the other
//! goal cells, and in a maze of one row the start is open to the east. [`Style`] describes the
//! properties of each style.
//!
//! # How contest mazes are generated
//! A randomized depth-first search creates the passages. The depth-first search prefers straight
//! passages and alternating turns, and ends passages at random. Then one wall is removed to
//! disconnect the goal from the outer wall, and further walls are removed at dead ends and at
//! random positions. A wall is kept if removing it would leave a post without walls or make the
//! shortest path too short. The parameters, such as the number of loops, are drawn at random for
//! each maze. The following table compares generated mazes with 250 real mazes of 16×16 cells. It
//! shows the mean of each figure and the range that contains 90 % of the mazes.
//!
//! ```text
//!                               250 real mazes  10,000 generated mazes
//! inner walls                    209   185-232           208   196-219
//! dead ends                       23      5-47            21      8-34
//! loops                           17      2-36            17      6-29
//! shortest path, steps            58    24-108            48     30-76
//! mean straight, steps           2.7   1.9-4.2           2.6   1.7-3.5
//! longest straight, steps         14      8-15            12      8-15
//! stairs of four steps            42      2-90            33      8-78
//! ```
//!
//! The `figures` example prints this table.
#![forbid(unsafe_code)]

mod contest;
mod perfect;
mod posts;

use std::fmt;
use std::hash::{BuildHasher, RandomState};

use mmsim_maze::{CellSet, Maze, MazeSize, WyRand};

use perfect::START;

/// Generates the maze for a size, a seed and a style.
///
/// # Panics
/// This function never panics, because the start is inside every maze.
pub fn generate(size: MazeSize, seed: u64, style: Style) -> Maze {
    let mut rng = WyRand::new(seed);
    let shortest_side = size.width().min(size.height());
    let walls = match style {
        Style::Contest if shortest_side >= contest::MIN_SIDE => contest::walls(size, &mut rng),
        Style::Contest | Style::Perfect => perfect::perfect(size, &mut rng),
        Style::Open => perfect::open(size, &mut rng),
    };
    Maze::new(walls, START, CellSet::EMPTY).expect("the start is inside every maze")
}

/// The style of a generated maze.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Style {
    /// A maze that resembles contest mazes, with loops, dead ends, straight passages and
    /// staircases. The goal has one entrance. Every post has a wall, except the post in the middle
    /// of the goal.
    ///
    /// If both sides of the maze are at least five cells long, no chain of walls connects the goal
    /// to the outer wall, so a wall follower never reaches the goal. In a contest maze of 16×16
    /// cells, the shortest path is at least 28 steps long, which is twice its length in a maze
    /// without walls.
    ///
    /// If a side of the maze is shorter than three cells, the goal touches the outer wall, and the
    /// maze is a [`Perfect`](Self::Perfect) maze.
    Contest,
    /// A maze with exactly one path between any two cells, if the goal counts as one cell. All
    /// perfect mazes are equally likely.
    Perfect,
    /// A maze with few walls and many paths, for training.
    Open,
}

impl Style {
    /// All styles.
    pub const ALL: &'static [Self] = &[Self::Contest, Self::Perfect, Self::Open];

    /// Returns the name that selects the style on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Contest => "contest",
            Self::Perfect => "perfect",
            Self::Open => "open",
        }
    }

    /// Returns a short description of the style.
    pub const fn about(self) -> &'static str {
        match self {
            Self::Contest => "contest-like maze with loops, dead ends and one goal entrance",
            Self::Perfect => "exactly one path between any two cells",
            Self::Open => "few walls and many paths, for training",
        }
    }
}

impl fmt::Display for Style {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Returns a new random seed below 2³², which is short enough to type.
///
/// ```
/// use mmsim_generator::{Style, generate, random_seed};
/// use mmsim_maze::MazeSize;
///
/// let seed = random_seed();
/// let maze = generate(MazeSize::CLASSIC, seed, Style::Open);
/// println!("the maze of seed {seed}:\n{maze}");
/// ```
pub fn random_seed() -> u64 {
    // The standard library takes the keys of its hashes from the operating system.
    RandomState::new().hash_one(()) >> 32
}

/// Runs the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use mmsim_maze::{Cell, Heading, Wall};
    use mmsim_solvers::{MazeFacts, MazeRules, MazeViolation};
    use proptest::prelude::*;

    use super::*;
    use crate::posts::{Post, walls_to_outer_wall};

    fn any_size() -> impl Strategy<Value = MazeSize> {
        (1_usize..=32, 1_usize..=32)
            .prop_map(|(width, height)| MazeSize::new(width, height).unwrap())
    }

    /// Returns the number of open sides between neighbouring cells.
    fn open_sides(maze: &Maze) -> usize {
        maze.size().cells().map(|cell| maze.walls().open_neighbours(cell).count()).sum::<usize>()
            / 2
    }

    /// Returns the number of entrances to the goal room.
    fn entrances(maze: &Maze) -> usize {
        let next = maze.goals().iter().flat_map(|cell| maze.walls().open_neighbours(cell));
        next.filter(|&cell| !maze.goals().contains(cell)).count()
    }

    fn check_common_properties(maze: &Maze, size: MazeSize) {
        assert_eq!(maze.size(), size);
        assert_eq!(MazeFacts::new(maze).reachable_cells, size.area(), "{maze}");
        assert_eq!(*maze.goals(), size.central_cells());
        let room = maze.goals();
        for cell in room {
            let inside = |&heading: &Heading| {
                cell.neighbour(heading).is_some_and(|next| room.contains(next))
            };
            assert!(
                Heading::ALL.iter().filter(|to| inside(to)).all(|&to| !maze.walls().has(cell, to))
            );
        }
        let start = maze.start();
        assert_eq!(start.cell, START);
        if size.height() > 1 && !room.contains(START) {
            assert!(maze.walls().open_neighbours(START).eq([Cell::new(0, 1)]), "{maze}");
        }
        assert_eq!(&maze.to_string().parse::<Maze>().unwrap(), maze);
    }

    fn check_perfect(maze: &Maze) {
        // A tree has one edge fewer than it has nodes; the room is a node with inner edges.
        let room = maze.goals().len();
        let inside = [0, 0, 1, 2, 4][room];
        assert_eq!(open_sides(maze), maze.size().area() - room + inside, "{maze}");
    }

    fn check_contest(maze: &Maze) {
        let size = maze.size();
        if size.width().min(size.height()) < 3 {
            return check_perfect(maze);
        }
        assert_eq!(entrances(maze), 1, "{maze}");
        let sides = size.cells().map(|cell| Wall::new(cell, Heading::North));
        let posts: Vec<Post> = sides.flat_map(Post::ends).collect();
        let bare = posts.iter().filter(|post| !post.has_wall(maze.walls()));
        // Each inner post is the end of two such sides.
        assert_eq!(bare.count(), if maze.goals().len() == 4 { 2 } else { 0 }, "{maze}");
        if size.width().min(size.height()) >= 5 {
            let corner = size.central_cells().iter().next().unwrap();
            let room_post = Post::ends(Wall::new(corner, Heading::West));
            assert_eq!(walls_to_outer_wall(maze.walls(), room_post), None, "{maze}");
        }
    }

    proptest! {
        #[test]
        fn mazes_of_all_sizes_and_seeds_have_the_documented_properties(size in any_size(), seed in any::<u64>()) {
            for &style in Style::ALL {
                let maze = generate(size, seed, style);
                check_common_properties(&maze, size);
                match style {
                    Style::Contest => check_contest(&maze),
                    Style::Perfect => check_perfect(&maze),
                    Style::Open => {}
                }
                prop_assert_eq!(generate(size, seed, style), maze);
            }
        }
    }

    proptest! {
        #[test]
        fn contest_mazes_keep_the_rules_and_a_wall_follower_solves_perfect_mazes(
            side in 5_usize..=32, seed in any::<u64>()
        ) {
            let violations = |style| {
                let size = MazeSize::new(side, side).unwrap();
                MazeRules::Classic.violations(&generate(size, seed, style))
            };
            prop_assert_eq!(violations(Style::Contest), []);
            let follower = MazeViolation::GoalOnWallFollowerPath;
            prop_assert!(violations(Style::Perfect).contains(&follower));
        }
    }

    #[test]
    fn the_smallest_mazes_have_the_documented_properties() {
        for (width, height) in (1..=6).flat_map(|width| (1..=6).map(move |height| (width, height)))
        {
            let size = MazeSize::new(width, height).unwrap();
            for seed in 0..20 {
                check_common_properties(&generate(size, seed, Style::Contest), size);
                check_contest(&generate(size, seed, Style::Contest));
                check_common_properties(&generate(size, seed, Style::Perfect), size);
                check_perfect(&generate(size, seed, Style::Perfect));
                check_common_properties(&generate(size, seed, Style::Open), size);
            }
        }
    }

    #[test]
    fn contest_mazes_of_10000_seeds_are_reachable_and_distinct() {
        let mut mazes = HashSet::new();
        for seed in 0..10_000 {
            let maze = generate(MazeSize::CLASSIC, seed, Style::Contest);
            check_contest(&maze);
            let facts = MazeFacts::new(&maze);
            assert_eq!(facts.reachable_cells, 256);
            assert!(facts.shortest_path >= Some(28), "{maze}");
            mazes.insert(maze);
        }
        assert_eq!(mazes.len(), 10_000);
    }

    #[test]
    fn an_open_maze_has_few_walls() {
        let maze = generate(MazeSize::CLASSIC, 1, Style::Open);
        assert!((390..430).contains(&open_sides(&maze)), "{} of 480", open_sides(&maze));
    }

    // The maze for a seed never changes, so these snapshots must not change either.
    #[test]
    fn the_mazes_for_seeds_never_change() {
        let size = MazeSize::new(9, 8).unwrap();
        insta::assert_snapshot!(generate(MazeSize::CLASSIC, 1, Style::Contest), @r"
        o---o---o---o---o---o---o---o---o---o---o---o---o---o---o---o---o
        |                                       |                       |
        o   o---o   o---o---o   o---o---o---o   o   o---o---o---o   o   o
        |   |       |               |   |                   |       |   |
        o   o   o---o---o   o---o   o   o   o---o---o---o   o---o   o   o
        |   |   |       |       |           |               |       |   |
        o   o   o   o   o---o   o   o   o   o   o---o   o   o   o   o   o
        |   |       |               |   |           |   |   |   |   |   |
        o---o   o---o---o   o---o   o   o   o---o   o   o   o   o   o   o
        |               |       |       |           |       |           |
        o   o   o---o   o   o   o---o   o   o   o---o---o---o   o---o---o
        |   |               |           |   |                   |       |
        o   o   o   o---o---o---o---o---o   o   o---o   o---o---o---o   o
        |   |   |   |                       |   |                       |
        o   o   o---o   o   o---o---o---o---o   o   o---o---o---o   o   o
        |   |   |       |           | G   G |   |           |       |   |
        o   o   o   o---o   o---o   o   o   o   o   o---o   o   o---o   o
        |   |   |       |       |   | G   G     |   |           |   |   |
        o   o   o---o   o   o   o---o---o---o   o---o   o---o---o   o   o
        |   |       |       |               |   |       |       |       |
        o   o---o   o---o---o   o---o---o   o   o   o---o   o   o   o---o
        |   |               |       |   |   |   |   |       |           |
        o   o   o---o---o   o---o   o   o   o   o   o   o---o---o---o   o
        |   |       |           |       |   |   |   |   |       |       |
        o   o   o   o---o---o   o---o---o   o   o   o   o   o   o---o---o
        |   |   |       |                   |   |       |   |           |
        o   o   o---o   o---o   o---o   o---o   o   o   o   o---o---o   o
        |   |   |   |       |                   |   |       |       |   |
        o   o   o   o   o   o   o---o---o---o   o---o   o---o   o   o   o
        |   |           |   |           |                   |   |       |
        o   o   o---o   o   o   o---o---o   o---o   o---o   o---o---o   o
        | S |           |                           |                   |
        o---o---o---o---o---o---o---o---o---o---o---o---o---o---o---o---o
        ");
        insta::assert_snapshot!(generate(size, 2, Style::Perfect), @r"
        o---o---o---o---o---o---o---o---o---o
        |               |                   |
        o---o   o   o   o   o---o---o   o---o
        |       |   |           |       |   |
        o---o   o---o---o---o---o---o   o   o
        |   |               |   |       |   |
        o   o   o---o   o---o   o   o---o   o
        |   |       |     G |       |       |
        o   o   o---o---o   o---o---o   o---o
        |   |       |     G         |   |   |
        o   o---o---o   o---o   o---o   o   o
        |       |   |       |               |
        o   o   o   o   o---o   o---o   o   o
        |   |   |   |   |   |   |       |   |
        o   o   o   o   o   o---o   o---o   o
        | S |           |           |       |
        o---o---o---o---o---o---o---o---o---o
        ");
        insta::assert_snapshot!(generate(size, u64::MAX, Style::Open), @r"
        o---o---o---o---o---o---o---o---o---o
        |                                   |
        o---o---o   o   o   o   o   o   o   o
        |               |   |               |
        o   o   o   o   o   o   o---o   o   o
        |                               |   |
        o   o   o   o   o   o   o   o   o---o
        |                 G     |           |
        o   o   o   o   o   o   o   o---o   o
        |                 G                 |
        o   o   o   o   o   o   o   o---o   o
        |   |                               |
        o   o   o   o   o   o   o   o---o   o
        |                                   |
        o   o   o   o   o---o   o   o   o   o
        | S |       |                       |
        o---o---o---o---o---o---o---o---o---o
        ");
    }
}
