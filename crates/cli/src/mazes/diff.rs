//! `mmsim mazes diff`: the differences between two mazes, and the mazes of a folder that are equal
//! to a maze.

use std::collections::HashSet;
use std::path::PathBuf;
use std::{io, slice};

use clap::Args;
use mmsim_compare::NamedMaze;
use mmsim_maze::{CellSet, Escaped, Maze, Wall, counted};
use serde::Serialize;

use super::index::{EqualMaze, MazeIndex, real_path};
use crate::args::CommandResult;
use crate::output::{note, print, print_json, print_report};
use crate::selection::Inputs;
use crate::terminal::has_colours;

/// The help for each of the two mazes.
const DIFF_HELP: &str =
    "Maze file, folder, words from the path of a maze, or a folder and words in quotes";

#[derive(Debug, Args)]
pub(super) struct DiffArgs {
    #[arg(help = DIFF_HELP)]
    a: PathBuf,
    #[arg(help = DIFF_HELP)]
    b: PathBuf,
    /// Print a JSON object or, for folders, a JSON array
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &DiffArgs) -> CommandResult {
    let [a, b] = [&args.a, &args.b].map(|name| Inputs::read(slice::from_ref(name)));
    let all_readable = a.all_readable && b.all_readable;
    if args.a.is_dir() || args.b.is_dir() {
        return Ok(print_equal(&a.mazes, &b.mazes, args)? && all_readable);
    }
    let ([a], [b]) = (&a.mazes[..], &b.mazes[..]) else { return Ok(false) };
    let difference = Difference::new(a, b);
    if args.json {
        print_json(&difference)?;
    } else {
        print(&difference.text(has_colours(&io::stdout())))?;
    }
    Ok(difference.differs.is_empty())
}

/// Prints the mazes of `b` that are equal to mazes of `a` after a rotation or reflection, each pair
/// once. Returns false if there are none.
fn print_equal(a: &[NamedMaze], b: &[NamedMaze], args: &DiffArgs) -> CommandResult {
    let mut index = MazeIndex::default();
    for b in b {
        index.add(&b.path, &b.maze);
    }
    let (mut found, mut pairs) = (Vec::new(), HashSet::new());
    for a in a {
        for b in index.find(&a.maze) {
            let mut pair = [&a.path, b.path].map(real_path);
            pair.sort();
            if pair[0] != pair[1] && pairs.insert(pair) {
                found.push(Equal::new(a, &b));
            }
        }
    }
    print_report(args.json, &found, || found.iter().map(Equal::line).collect())?;
    if found.is_empty() {
        note(format_args!("no maze in {} is equal to {}", args.b.display(), args.a.display()));
    }
    Ok(!found.is_empty())
}

/// Two mazes with the same walls, perhaps after a rotation or reflection of `a`. The field names are
/// JSON keys.
#[derive(Serialize)]
struct Equal {
    a: String,
    b: String,
    /// What turns the walls of `a` into those of `b`.
    symmetry: String,
    same_start: bool,
    same_goals: bool,
}

impl Equal {
    fn new(a: &NamedMaze, b: &EqualMaze<'_>) -> Self {
        let EqualMaze { symmetry, same_start, same_goals, .. } = *b;
        let [a, b] = [&a.path, b.path].map(|path| path.display().to_string());
        Self { a, b, symmetry: symmetry.to_string(), same_start, same_goals }
    }

    fn line(&self) -> String {
        let start = if self.same_start { "" } else { ", another start" };
        let goals = if self.same_goals { "" } else { ", another goal" };
        let Self { a, b, symmetry, .. } = self;
        format!("{} is {}, {symmetry}{start}{goals}\n", Escaped(b), Escaped(a))
    }
}

/// The differences between two mazes. The field names are JSON keys.
#[derive(Serialize)]
struct Difference<'a> {
    a: String,
    b: String,
    /// What differs: `size`, `start`, `goals` or `walls`.
    differs: Vec<&'static str>,
    /// The walls that only one of the mazes has. Mazes of different sizes have no such list.
    only_a: Option<Vec<Side>>,
    only_b: Option<Vec<Side>>,
    /// How the mazes are equal after a rotation or reflection.
    equal: Option<Equal>,
    #[serde(skip)]
    mazes: [&'a Maze; 2],
}

/// A wall as a side of a cell. The field names are JSON keys.
#[derive(Serialize)]
struct Side {
    cell: [u8; 2],
    side: String,
}

impl<'a> Difference<'a> {
    fn new(a: &'a NamedMaze, b: &'a NamedMaze) -> Self {
        let mazes = [&a.maze, &b.maze];
        let mut index = MazeIndex::default();
        index.add(&b.path, &b.maze);
        let is_same_size = a.maze.size() == b.maze.size();
        let only = |[one, other]: [&Maze; 2]| {
            let has = |maze: &Maze, wall: &Wall| maze.walls().has(wall.cell, wall.heading);
            let walls = one.size().inner_walls();
            let walls = walls.filter(|wall| has(one, wall) && !has(other, wall));
            let side = |Wall { cell, heading, .. }| Side {
                cell: [cell.x, cell.y],
                side: heading.to_string(),
            };
            is_same_size.then(|| walls.map(side).collect())
        };
        let differs = [
            ("size", !is_same_size),
            ("start", a.maze.start() != b.maze.start()),
            ("goals", a.maze.goals() != b.maze.goals()),
            ("walls", a.maze.walls() != b.maze.walls()),
        ];
        Self {
            a: a.path.display().to_string(),
            b: b.path.display().to_string(),
            differs: differs.into_iter().filter_map(|(what, is)| is.then_some(what)).collect(),
            only_a: only(mazes),
            only_b: only([&b.maze, &a.maze]),
            equal: index.find(&a.maze).first().map(|b| Equal::new(a, b)),
            mazes,
        }
    }

    /// Lists the differences, and draws those between the walls.
    fn text(&self, has_colours: bool) -> String {
        let (a, b) = (Escaped(&self.a), Escaped(&self.b));
        if self.differs.is_empty() {
            return format!("{a} and {b} have the same walls, start and goal\n");
        }
        let mut lines = Vec::new();
        for what in &self.differs {
            let value = |maze: &Maze| match *what {
                "size" => format!("{} cells", maze.size()),
                "start" => maze.start().cell.to_string(),
                _ => cells(maze.goals()),
            };
            if *what != "walls" {
                let [a_value, b_value] = self.mazes.map(value);
                lines.push(format!("{what}: {a_value} in {a}, {b_value} in {b}\n"));
                continue;
            }
            if let Some(Equal { symmetry, .. }) = &self.equal {
                lines.push(format!("walls: {b} is {a}, {symmetry}\n"));
            }
            if let (Some(only_a), Some(only_b)) = (&self.only_a, &self.only_b) {
                lines.push(format!("< {} only in {a}\n", counted(only_a.len(), "wall")));
                lines.push(format!("> {} only in {b}\n", counted(only_b.len(), "wall")));
                lines.push(overlay(self.mazes, has_colours));
            }
        }
        lines.concat()
    }
}

pub(super) fn cells(cells: &CellSet) -> String {
    cells.iter().map(|cell| cell.to_string()).collect::<Vec<_>>().join(" ")
}

/// Draws two mazes of the same size in one picture. The walls of only one maze are drawn as `<` or
/// `>`.
fn overlay(mazes: [&Maze; 2], has_colours: bool) -> String {
    const RED: u8 = 31;
    const GREEN: u8 = 32;
    let marked = |mark: char, colour: u8| {
        if has_colours { format!("\x1b[{colour}m{mark}\x1b[0m") } else { mark.into() }
    };
    let [a, b] = mazes.map(ToString::to_string);
    let draw = |(a, b)| match (a, b) {
        ('-' | '|', ' ') => marked('<', RED),
        (' ', '-' | '|') => marked('>', GREEN),
        (' ', mark) | (mark, _) => mark.into(),
    };
    a.chars().zip(b.chars()).map(draw).collect()
}
