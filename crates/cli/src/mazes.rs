//! `mmsim mazes`: list, show, check, compare, convert, fetch and generate mazes.

mod check;
mod convert;
mod diff;
mod fetch;
mod generate;
mod index;
mod row;

use std::ffi::OsStr;
use std::path::PathBuf;

use clap::{Args, Subcommand};
use mmsim_compare::NamedMaze;
use mmsim_formats::{Bits, Choice, Rows};
use mmsim_solvers::Distances;
use serde::Serialize;

use crate::args::CommandResult;
use crate::output::{print, print_json, print_report};
use crate::screen::fitting;
use crate::selection::{DEFAULT_MAZES, MAZE_HELP, Selection, join};
use check::CheckArgs;
use convert::ConvertArgs;
use diff::DiffArgs;
use fetch::{FETCH, FetchArgs};
use generate::GenerateArgs;
use row::MazeRow;

#[derive(Debug, Args)]
pub(crate) struct MazesArgs {
    #[command(subcommand)]
    command: MazesCommand,
}

#[derive(Debug, Subcommand)]
enum MazesCommand {
    /// List mazes
    List {
        #[arg(
            value_name = "MAZE",
            help = format!("List only mazes of a file or folder, or with words in their path \
                            [default: {DEFAULT_MAZES}]")
        )]
        maze: Vec<PathBuf>,
        /// Print a JSON array
        #[arg(long)]
        json: bool,
    },
    /// Draw a maze, with the number of steps from each cell to the goal
    Show {
        #[arg(required = true, value_name = "MAZE", help = MAZE_HELP)]
        maze: Vec<PathBuf>,
        #[command(flatten)]
        encoding: EncodingArgs,
        /// Print a JSON object
        #[arg(long)]
        json: bool,
    },
    /// Check maze files for errors and against contest rules, and print their size, goals and
    /// shortest path
    ///
    /// The exit code is 1 if there are errors: unreadable files, contradictory cells, gaps in the
    /// outer wall, numbers that fit several mazes, or an unreachable goal. Warnings are printed for
    /// unknown walls, duplicate mazes, also if rotated or mirrored, and for what contest rules
    /// forbid: a start or goal in the wrong place, several goal entrances, walls inside the goal, a
    /// goal that a wall follower finds, posts without a wall, and unreachable cells. Notes are
    /// printed for everything else in a file that is not part of its maze.
    Check(CheckArgs),
    /// Draw the walls that differ between two mazes, or find equal mazes in a folder
    ///
    /// For two mazes, prints the size, start and goals that differ, and draws the walls that only A
    /// has as `<` and those that only B has as `>`. If A or B is a folder, lists the mazes of B that
    /// have the walls of a maze of A, also if they are rotated or mirrored. The exit code is 0 if the
    /// mazes are equal or an equal maze is found, else 1.
    Diff(DiffArgs),
    /// Write a maze file in another format
    Convert(ConvertArgs),
    /// Download a public collection of real contest mazes
    #[command(long_about = FETCH)]
    Fetch(FetchArgs),
    /// Generate mazes for contests or training; the same seed gives the same maze
    Generate(GenerateArgs),
}

/// The encoding of files with a number for each cell.
#[derive(Debug, Args)]
struct EncodingArgs {
    /// Bits of the numbers in the file: N1E2S4W8 for walls, N1E2S4W8-open for openings (each side
    /// with its bit), or codes [default: what fits]
    #[arg(long)]
    bits: Option<Bits>,
    /// Edge of the maze that the first line of numbers describes: north, south, west or east; for
    /// lines that begin at the other end, north-east, south-east, west-north or east-north
    /// [default: what fits]
    #[arg(long, value_name = "EDGE")]
    rows: Option<Rows>,
}

impl EncodingArgs {
    fn choice(&self) -> Choice {
        Choice { bits: self.bits, rows: self.rows }
    }
}

pub(crate) fn run(args: &MazesArgs) -> CommandResult {
    match &args.command {
        MazesCommand::List { maze, json } => list(&join(maze), *json),
        MazesCommand::Show { maze, encoding, json } => show(&join(maze), encoding, *json),
        MazesCommand::Check(args) => check::run(args),
        MazesCommand::Diff(args) => diff::run(args),
        MazesCommand::Convert(args) => convert::run(args),
        MazesCommand::Fetch(args) => fetch::run(args),
        MazesCommand::Generate(args) => generate::run(args),
    }
}

fn list(maze: &OsStr, json: bool) -> CommandResult {
    let entries = Selection::read(maze)?.matching()?;
    let rows: Vec<MazeRow> = entries.iter().map(MazeRow::from_entry).collect();
    print_report(json, &rows, || rows.iter().map(|row| row.line() + "\n").collect())?;
    Ok(true)
}

fn show(maze: &OsStr, encoding: &EncodingArgs, json: bool) -> CommandResult {
    let NamedMaze { path, maze, .. } = Selection::encoded(maze, encoding.choice())?.first()?;
    let row = MazeRow::from_maze(&path, &maze);
    if json {
        #[derive(Serialize)]
        struct Shown {
            #[serde(flatten)]
            row: MazeRow,
            drawing: String,
        }
        let shown = Shown { row, drawing: maze.to_string() };
        print_json(&shown)?;
    } else {
        let distances = Distances::flood(maze.walls(), maze.goals());
        let distance = |cell| distances.at(cell);
        let numbers = maze.picture().with_numbers(&distance).to_string();
        let [compact, narrow] = [maze.picture().compact(), maze.picture().narrow()];
        let pictures = [numbers, compact.to_string(), narrow.to_string()];
        print(&format!("{}\n{}", row.line(), fitting(&pictures)))?;
    }
    Ok(true)
}
