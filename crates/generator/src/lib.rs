//! Micromouse mazes made to measure: like those of contests, perfect ones, and open ones to train
//! in. The same seed gives the same maze, on every machine and for ever.
//!
//! ```
//! use mmsim_generator::{Style, generate};
//! use mmsim_maze::{Cell, Heading, MazeSize};
//!
//! let maze = generate(MazeSize::CLASSIC, 7, Style::Contest);
//! assert!(maze.walls().has(Cell::new(0, 0), Heading::East), "the start is open to the north only");
//! assert_eq!(maze, generate(MazeSize::CLASSIC, 7, Style::Contest));
//! ```
//!
//! In every maze the start is (0, 0), open to the north only, the goal is the room of the central
//! cells ([`MazeSize::central_cells`]) without walls inside, and each cell can be reached. Only the
//! smallest ones differ: a start that is a goal itself is open to the others, and a maze of one row
//! goes east. What else is promised is said of each [`Style`].
//!
//! # How contest mazes are made
//! A search in depth lays passages that like to go straight on, or to turn left and right in turns,
//! and that end here and there. Then walls are opened: one such that no wall leads from the goal to
//! the outer wall, some in dead ends, some anywhere, but never where a post would be left without a
//! wall or the goal would come too near. How much of each, every maze draws for itself. The outcome
//! beside 250 real mazes of 16×16 cells, as the mean and what nine of ten mazes lie within:
//!
//! ```text
//!                                250 real ones   10,000 generated ones
//! inner walls                    209   185-232           207   196-219
//! dead ends                       23      5-47            21      9-35
//! loops                           17      2-36            18      6-29
//! shortest path, steps            58    24-108            48     30-75
//! mean straight, steps           2.7   1.9-4.2           2.5   1.7-3.4
//! longest straight, steps         14      8-15            12      7-15
//! stairs of four steps            42      2-90            33      8-80
//! ```
//!
//! The example `figures` prints it.
#![forbid(unsafe_code)]

mod contest;
mod posts;
mod random;
mod style;
mod tree;

pub use style::Style;

use mmsim_maze::{Cell, CellSet, Heading, Maze, MazeSize, Walls};

use random::Random;

/// Where mice start.
const START: Cell = Cell::new(0, 0);

/// The maze of this size, seed and style.
///
/// # Panics
/// Never: the start lies inside of every maze.
pub fn generate(size: MazeSize, seed: u64, style: Style) -> Maze {
    let mut random = Random::new(seed);
    let shortest_side = size.width().min(size.height());
    let walls = match style {
        Style::Contest if shortest_side >= contest::SHORTEST_SIDE => {
            contest::walls(size, &mut random)
        }
        Style::Contest | Style::Perfect => perfect(size, &mut random),
        Style::Open => open(size, &mut random),
    };
    Maze::new(walls, START, CellSet::EMPTY).expect("the corner lies inside of every maze")
}

fn perfect(size: MazeSize, random: &mut Random) -> Walls {
    let room = size.central_cells();
    let mut walls = closed_round(size, &room);
    let mut free: CellSet = size.cells().filter(|&cell| !room.contains(cell)).collect();
    // The start is a dead end, where there is more than a single row to go on in.
    if size.width() > 1 && size.height() > 1 && free.remove(START) {
        walls.set(START, Heading::North, false);
    }
    tree::uniform(&mut walls, room, &free, random);
    walls
}

fn open(size: MazeSize, random: &mut Random) -> Walls {
    /// How many of ten walls of a perfect maze are left.
    const LEFT_IN_TEN: u32 = 3;
    let mut walls = perfect(size, random);
    for cell in size.cells().filter(|&cell| cell != START) {
        for heading in [Heading::North, Heading::East] {
            if random.below(10) >= LEFT_IN_TEN {
                walls.set(cell, heading, false);
            }
        }
    }
    walls
}

/// All walls but those inside of the room.
fn closed_round(size: MazeSize, room: &CellSet) -> Walls {
    let mut walls = Walls::closed(size);
    for cell in room.iter() {
        for heading in Heading::ALL {
            if cell.neighbour(heading).is_some_and(|next| room.contains(next)) {
                walls.set(cell, heading, false);
            }
        }
    }
    walls
}

/// The code in the README of this crate runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use mmsim_solvers::MazeFacts;
    use proptest::prelude::*;

    use super::*;
    use crate::posts::{Post, walls_to_the_edge};

    fn any_size() -> impl Strategy<Value = MazeSize> {
        (1_usize..=32, 1_usize..=32)
            .prop_map(|(width, height)| MazeSize::new(width, height).unwrap())
    }

    /// Ways between neighbours.
    fn ways(maze: &Maze) -> usize {
        maze.size().cells().map(|cell| maze.walls().open_neighbours(cell).count()).sum::<usize>()
            / 2
    }

    /// Ways into the room from outside.
    fn ways_in(maze: &Maze) -> usize {
        let next = maze.goals().iter().flat_map(|cell| maze.walls().open_neighbours(cell));
        next.filter(|&cell| !maze.goals().contains(cell)).count()
    }

    fn check_what_all_promise(maze: &Maze, size: MazeSize) {
        assert_eq!(maze.size(), size);
        assert_eq!(MazeFacts::new(maze).reachable_cells, size.area(), "{maze}");
        assert_eq!(*maze.goals(), size.central_cells());
        let room = maze.goals();
        for cell in room.iter() {
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

    fn check_one_way(maze: &Maze) {
        // A tree has one way less than it has cells; the room is a cell with ways inside.
        let room = maze.goals().len();
        let inside = [0, 0, 1, 2, 4][room];
        assert_eq!(ways(maze), maze.size().area() - room + inside, "{maze}");
    }

    fn check_contest(maze: &Maze) {
        let size = maze.size();
        if size.width().min(size.height()) < 3 {
            return check_one_way(maze);
        }
        assert_eq!(ways_in(maze), 1, "{maze}");
        let places = size.cells().map(|cell| (cell, Heading::North));
        let posts: Vec<Post> = places.flat_map(Post::ends).collect();
        let bare = posts.iter().filter(|post| !post.carries_wall(maze.walls()));
        // Each post ends two such places, but for those of the outer walls.
        assert_eq!(bare.count(), if maze.goals().len() == 4 { 2 } else { 0 }, "{maze}");
        if size.width().min(size.height()) >= 5 {
            let corner = size.central_cells().iter().next().unwrap();
            let room_post = Post::ends((corner, Heading::West));
            assert_eq!(walls_to_the_edge(maze.walls(), room_post), None, "{maze}");
        }
    }

    proptest! {
        #[test]
        fn every_size_and_seed_gives_what_is_promised(size in any_size(), seed in any::<u64>()) {
            for style in Style::ALL {
                let maze = generate(size, seed, style);
                check_what_all_promise(&maze, size);
                match style {
                    Style::Contest => check_contest(&maze),
                    Style::Perfect => check_one_way(&maze),
                    Style::Open => {}
                }
                prop_assert_eq!(generate(size, seed, style), maze);
            }
        }
    }

    #[test]
    fn the_smallest_sizes_give_what_is_promised() {
        for (width, height) in (1..=6).flat_map(|width| (1..=6).map(move |height| (width, height)))
        {
            let size = MazeSize::new(width, height).unwrap();
            for seed in 0..20 {
                check_what_all_promise(&generate(size, seed, Style::Contest), size);
                check_contest(&generate(size, seed, Style::Contest));
                check_what_all_promise(&generate(size, seed, Style::Perfect), size);
                check_one_way(&generate(size, seed, Style::Perfect));
                check_what_all_promise(&generate(size, seed, Style::Open), size);
            }
        }
    }

    #[test]
    fn ten_thousand_contest_mazes_are_all_reachable_and_different() {
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
        assert!((390..430).contains(&ways(&maze)), "of 480, found {}", ways(&maze));
    }

    // What a seed gives never changes, so neither do these.
    #[test]
    fn the_same_seed_gives_the_same_maze_for_ever() {
        let size = MazeSize::new(9, 8).unwrap();
        insta::assert_snapshot!(generate(MazeSize::CLASSIC, 1, Style::Contest), @r"
        o---o---o---o---o---o---o---o---o---o---o---o---o---o---o---o---o
        |                               |       |                       |
        o   o   o---o   o---o   o---o---o   o   o---o   o---o---o   o   o
        |   |   |               |           |                       |   |
        o   o   o   o---o---o---o   o---o---o---o---o---o---o---o   o   o
        |   |       |                                                   |
        o   o   o   o   o---o---o---o---o---o---o---o   o---o   o---o   o
        |   |   |                                           |       |   |
        o   o   o   o---o---o---o---o---o---o   o   o   o   o   o   o   o
        |   |   |           |                   |   |   |       |   |   |
        o   o   o   o   o   o---o---o   o---o---o   o   o   o   o   o   o
        |           |   |                           |   |   |   |       |
        o   o   o   o   o   o---o---o---o---o---o   o   o   o   o   o   o
        |   |   |   |       |                   |   |   |   |   |   |   |
        o---o   o   o   o   o   o   o---o---o   o   o   o   o   o   o   o
        |   |       |   |   |   |   | G   G |   |   |   |   |   |   |   |
        o   o   o---o   o   o   o   o   o   o   o   o---o   o   o   o   o
        |                   |   |   | G   G     |   |   |   |   |       |
        o   o   o   o---o---o   o   o---o---o   o   o   o   o   o   o---o
        |   |   |   |           |               |   |   |   |   |       |
        o   o---o---o---o---o   o---o   o---o   o   o   o   o   o---o   o
        |                   |       |           |   |   |       |   |   |
        o   o---o---o   o---o   o   o---o---o   o---o   o   o   o   o   o
        |   |       |       |   |       |               |   |   |       |
        o   o   o   o---o   o---o---o   o---o---o---o---o   o   o   o   o
        |   |   |       |           |                       |       |   |
        o   o   o---o   o---o---o   o---o---o---o---o---o---o   o   o   o
        |   |   |               |                               |   |   |
        o   o   o   o---o---o   o---o---o---o---o---o---o---o---o---o   o
        |           |       |                                   |       |
        o   o   o---o   o   o---o   o---o---o   o---o---o---o   o   o---o
        | S |           |                                               |
        o---o---o---o---o---o---o---o---o---o---o---o---o---o---o---o---o
        ");
        insta::assert_snapshot!(generate(size, 2, Style::Perfect), @r"
        o---o---o---o---o---o---o---o---o---o
        |           |       |       |   |   |
        o---o   o   o   o   o   o   o   o   o
        |   |   |   |   |       |   |   |   |
        o   o---o   o   o   o   o   o   o   o
        |   |   |       |   |   |       |   |
        o   o   o---o   o   o   o   o   o   o
        |   |   |       | G |   |   |       |
        o   o   o---o---o   o---o---o   o---o
        |   |       |     G         |       |
        o   o   o---o---o---o   o   o---o---o
        |           |   |       |   |       |
        o   o---o   o   o---o---o   o   o---o
        |   |                               |
        o   o---o---o---o---o---o   o   o---o
        | S |                       |       |
        o---o---o---o---o---o---o---o---o---o
        ");
        insta::assert_snapshot!(generate(size, u64::MAX, Style::Open), @r"
        o---o---o---o---o---o---o---o---o---o
        |                                   |
        o   o   o   o   o   o   o   o   o   o
        |       |   |                       |
        o   o   o   o   o   o---o---o   o   o
        |   |           |                   |
        o   o   o   o   o---o   o   o   o---o
        |                 G                 |
        o   o   o---o   o   o   o   o---o   o
        |                 G             |   |
        o   o   o   o   o   o---o   o   o   o
        |                               |   |
        o   o   o   o   o   o   o---o   o   o
        |                           |       |
        o   o   o   o   o   o   o   o   o   o
        | S |       |           |           |
        o---o---o---o---o---o---o---o---o---o
        ");
    }
}
