//! `mmsim mazes`: list, show, check, convert, fetch and generate mazes.

pub(crate) mod args;
mod check;
mod convert;
mod fetch;
mod finding;
mod generate;
mod row;

use std::path::{Path, PathBuf};

use args::{MazesArgs, MazesCommand};
use mmsim_compare::NamedMaze;
use mmsim_formats::{Format, ReadError, read_content};
use mmsim_solvers::Distances;
use row::{MazeRow, print_rows};
use serde::Serialize;

use crate::args::CommandResult;
use crate::output::{print, print_json};
use crate::selection::Collection;

pub(crate) fn run(args: &MazesArgs) -> CommandResult {
    match &args.command {
        MazesCommand::List { mazes, json } => list(mazes.as_deref(), *json),
        MazesCommand::Show { name, mazes, format, json } => {
            show(&name.join(" "), mazes.as_deref(), *format, *json)
        }
        MazesCommand::Check { paths, format, json } => check::run(paths, *format, *json),
        MazesCommand::Convert(args) => convert::run(args),
        MazesCommand::Fetch(args) => fetch::run(args),
        MazesCommand::Generate(args) => generate::run(args),
    }
}

fn list(mazes: Option<&Path>, json: bool) -> CommandResult {
    let rows: Vec<MazeRow> =
        Collection::at(mazes)?.catalogue.entries().iter().map(MazeRow::from_entry).collect();
    print_rows(&rows, json)?;
    Ok(true)
}

fn show(name: &str, mazes: Option<&Path>, format: Option<Format>, json: bool) -> CommandResult {
    let (path, maze) = if let Some(format) = format {
        let path = PathBuf::from(name);
        let maze = format.parse(&read_content(&path)?);
        let maze = maze.map_err(|source| ReadError::Parse { path: path.clone(), source })?;
        (path, maze)
    } else {
        let NamedMaze { path, maze, .. } = Collection::with(name, mazes)?.select(name)?;
        (path, maze)
    };
    let row = MazeRow::from_maze(&path, &maze);
    if json {
        #[derive(Serialize)]
        struct Shown {
            #[serde(flatten)]
            row: MazeRow,
            maze: String,
        }
        let shown = Shown { row, maze: maze.to_string() };
        print_json(&shown)?;
    } else {
        let distances = Distances::flood(maze.walls(), maze.goals());
        let distance = |cell| distances.at(cell);
        print(&format!("{}\n{}", row.line(), maze.picture().with_numbers(&distance)))?;
    }
    Ok(true)
}
