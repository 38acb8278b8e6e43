//! `mmsim mazes`: list, show and check mazes.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use mmsim_maze::{Catalogue, Entry, Maze};
use mmsim_solvers::{Distances, MazeFacts};
use serde::Serialize;

use crate::Outcome;
use crate::args::{MazesArgs, MazesCommand};
use crate::output::{counted, goal_away, print};
use crate::selection::{Collection, Selected};

pub(crate) fn run(args: &MazesArgs) -> Outcome {
    match &args.command {
        MazesCommand::List { mazes, json } => list(mazes.as_deref(), *json),
        MazesCommand::Show { name, mazes, json } => show(&name.join(" "), mazes.as_deref(), *json),
        MazesCommand::Check { paths, json } => check(paths, *json),
    }
}

fn list(mazes: Option<&Path>, json: bool) -> Outcome {
    let rows: Vec<Row> =
        Collection::at(mazes)?.catalogue.entries().iter().map(Row::of_entry).collect();
    print_rows(&rows, json)?;
    Ok(true)
}

fn check(paths: &[PathBuf], json: bool) -> Outcome {
    let rows: Vec<Row> = paths
        .iter()
        .flat_map(|path| match Catalogue::of_path(path) {
            Ok(catalogue) if catalogue.entries().is_empty() => {
                vec![Row::of_error(
                    path,
                    &format!("{}: expected a maze file, found none", path.display()),
                )]
            }
            Ok(catalogue) => catalogue.entries().iter().map(Row::of_entry).collect(),
            Err(error) => vec![Row::of_error(path, &error)],
        })
        .collect();
    print_rows(&rows, json)?;
    Ok(rows.iter().all(|row| row.error.is_none()))
}

fn show(name: &str, mazes: Option<&Path>, json: bool) -> Outcome {
    let Selected { path, maze, .. } = Collection::with(name, mazes)?.select(name)?;
    let row = Row::of_maze(&path, &maze);
    if json {
        #[derive(Serialize)]
        struct Shown {
            #[serde(flatten)]
            row: Row,
            maze: String,
        }
        let shown = Shown { row, maze: maze.to_string() };
        print(&format!("{}\n", serde_json::to_string(&shown)?))?;
    } else {
        let distances = Distances::flood(maze.walls(), maze.goals());
        let distance = |cell| distances.at(cell);
        print(&format!("{}\n{}", row.line(), maze.drawing().with_numbers(&distance)))?;
    }
    Ok(true)
}

/// What there is to say of a file. The names are those of the JSON.
#[derive(Serialize)]
struct Row {
    path: String,
    width: Option<u8>,
    height: Option<u8>,
    goals: Option<Vec<[u8; 2]>>,
    shortest_path: Option<u16>,
    reachable_cells: Option<usize>,
    error: Option<String>,
}

impl Row {
    fn of_entry(entry: &Entry) -> Self {
        match entry.maze() {
            Ok(maze) => Self::of_maze(entry.path(), &maze),
            Err(error) => Self::of_error(entry.path(), &error),
        }
    }

    fn of_maze(path: &Path, maze: &Maze) -> Self {
        let facts = MazeFacts::of(maze);
        Self {
            path: path.display().to_string(),
            width: Some(maze.size().width()),
            height: Some(maze.size().height()),
            goals: Some(maze.goals().iter().map(|cell| [cell.x, cell.y]).collect()),
            shortest_path: facts.shortest_path,
            reachable_cells: Some(facts.reachable_cells),
            error: None,
        }
    }

    fn of_error(path: &Path, error: &impl Display) -> Self {
        Self {
            path: path.display().to_string(),
            width: None,
            height: None,
            goals: None,
            shortest_path: None,
            reachable_cells: None,
            error: Some(error.to_string()),
        }
    }

    /// The row as text: the error names the file itself.
    fn line(&self) -> String {
        let Self { path, width: Some(width), height: Some(height), goals: Some(goals), .. } = self
        else {
            return self.error.clone().unwrap_or_default();
        };
        let size = format!("{width}x{height}");
        let goal = goal_away(self.shortest_path);
        let cells = usize::from(*width) * usize::from(*height);
        let closed = match cells - self.reachable_cells.unwrap_or(cells) {
            0 => String::new(),
            closed => format!(", {} cannot be reached", counted(closed as u64, "cell")),
        };
        let goals = counted(goals.len() as u64, "goal cell");
        format!("{path}: {size}, {goals}, {goal}{closed}")
    }
}

fn print_rows(rows: &[Row], json: bool) -> io::Result<()> {
    if json {
        return print(&(serde_json::to_string_pretty(rows)? + "\n"));
    }
    print(&rows.iter().map(|row| row.line() + "\n").collect::<String>())
}
