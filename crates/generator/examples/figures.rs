//! Compares real 16×16 mazes with generated ones. Prints a table with the mean of each figure, such
//! as the number of dead ends, and the range that contains 90 % of the mazes.
//!
//! ```sh
//! cargo run --release -p mmsim-generator --example figures -- MAZES
//! ```
#![allow(clippy::cast_precision_loss)] // the counts are small

use std::error::Error;
use std::path::Path;

use mmsim_formats::Catalogue;
use mmsim_generator::{Style, generate};
use mmsim_maze::{Cell, CellSet, Heading, Maze, MazeSize, Wall};
use mmsim_solvers::{Distances, MazeFacts};

/// The names and units of the figures.
const NAMES: [&str; 7] = [
    "inner walls",
    "dead ends",
    "loops",
    "shortest path, steps",
    "mean straight, steps",
    "longest straight, steps",
    "stairs of four steps",
];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("no maze folder given")?;
    let catalogue = Catalogue::from_path(Path::new(&folder))?;
    let mut real = Vec::new();
    for entry in catalogue.entries() {
        real.push(entry.maze()?);
    }
    real.retain(|maze| maze.size() == MazeSize::CLASSIC);
    let generated: Vec<Maze> =
        (0..10_000).map(|seed| generate(MazeSize::CLASSIC, seed, Style::Contest)).collect();
    let (real, generated) = (figures(&real), figures(&generated));
    println!(
        "{:26}{:>18}{:>24}",
        "",
        format!("{} real mazes", real[0].len()),
        "10,000 generated mazes"
    );
    for ((name, real), generated) in NAMES.iter().zip(real).zip(generated) {
        println!("{name:26}{}{}", summary(real, 8), summary(generated, 14));
    }
    Ok(())
}

/// Formats the mean and the range that contains 90 % of the values.
fn summary(mut values: Vec<f64>, width: usize) -> String {
    values.sort_by(f64::total_cmp);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let decimals = usize::from(mean < 10.);
    let (low, high) = (values[values.len() / 20], values[values.len() - 1 - values.len() / 20]);
    let range = format!("{low:.decimals$}-{high:.decimals$}");
    format!("{mean:width$.decimals$} {range:>9}")
}

/// Returns the values of each figure for all mazes. Undefined values, such as the shortest path to
/// an unreachable goal, are omitted.
fn figures(mazes: &[Maze]) -> [Vec<f64>; NAMES.len()] {
    let mut all = [const { Vec::new() }; NAMES.len()];
    for maze in mazes {
        let (size, walls) = (maze.size(), maze.walls());
        let open = |cell| walls.open_neighbours(cell).count();
        let inner = 2 * size.area() - usize::from(size.width()) - usize::from(size.height());
        let open_sides = size.cells().map(open).sum::<usize>() / 2;
        let facts = MazeFacts::new(maze);
        let reachable = reachable(maze);
        let reachable_sides = reachable.iter().map(open).sum::<usize>() / 2;
        let straights = straights(maze);
        let figures = [
            Some(inner - open_sides),
            Some(reachable.iter().filter(|&cell| open(cell) == 1).count()),
            Some(reachable_sides + 1 - facts.reachable_cells),
            facts.shortest_path.map(usize::from),
            None,
            straights.iter().copied().max(),
            Some(stairs(maze)),
        ];
        for (all, figure) in all.iter_mut().zip(figures) {
            all.extend(figure.map(|figure| figure as f64));
        }
        all[4].push(straights.iter().sum::<usize>() as f64 / straights.len() as f64);
    }
    all
}

/// Returns the cells that are reachable from the start.
fn reachable(maze: &Maze) -> CellSet {
    let start = [maze.start().cell].into_iter().collect();
    let distances = Distances::flood(maze.walls(), &start);
    maze.size().cells().filter(|&cell| distances.at(cell).is_some()).collect()
}

/// Returns the length in steps of each straight passage.
fn straights(maze: &Maze) -> Vec<usize> {
    let mut straights = Vec::new();
    for Wall { cell, heading, .. } in maze.size().walls() {
        let step =
            |cell: &Cell| cell.neighbour(heading).filter(|_| !maze.walls().has(*cell, heading));
        let steps = std::iter::successors(Some(cell), step).count() - 1;
        if steps > 0 && maze.walls().has(cell, heading.back()) {
            straights.push(steps);
        }
    }
    straights
}

/// Counts the staircases of four steps. A staircase is counted once, not once for each direction.
fn stairs(maze: &Maze) -> usize {
    let step =
        |cell: Cell, heading| cell.neighbour(heading).filter(|_| !maze.walls().has(cell, heading));
    let turns = [Heading::North, Heading::South]
        .into_iter()
        .flat_map(|first| [(first, first.left()), (first, first.right())])
        .flat_map(|(one, other)| [[one, other], [other, one]]);
    let is_open = |from, [one, other]: [Heading; 2]| {
        [one, other, one, other].into_iter().try_fold(from, step).is_some()
    };
    let both_directions = turns
        .map(|pair| maze.size().cells().filter(|&cell| is_open(cell, pair)).count())
        .sum::<usize>();
    both_directions / 2
}
