//! `mmsim mazes check`: find problems in maze files.

use std::collections::HashMap;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use mmsim_formats::{Catalogue, Entry, Format};
use mmsim_maze::Maze;
use serde::Serialize;

use super::finding::{Finding, lines};
use super::row::MazeRow;
use crate::args::CommandResult;
use crate::output::{print, print_pretty_json};

/// A maze file and the problems found in it. The field names are JSON keys.
#[derive(Serialize)]
struct Checked {
    #[serde(flatten)]
    row: MazeRow,
    format: Option<&'static str>,
    findings: Vec<Finding>,
}

pub(super) fn run(paths: &[PathBuf], format: Option<Format>, json: bool) -> CommandResult {
    let mut seen = HashMap::new();
    let mut files = Vec::new();
    for path in paths {
        match Catalogue::from_path(path) {
            Ok(catalogue) if catalogue.entries().is_empty() => {
                let error = format!("{}: no maze files", path.display());
                files.push(Checked::unread(path, &error));
            }
            Ok(catalogue) => {
                let entries = catalogue.entries().iter();
                files.extend(entries.map(|entry| Checked::new(entry, format, &mut seen)));
            }
            Err(error) => files.push(Checked::unread(path, &error)),
        }
    }
    if json {
        print_pretty_json(&files)?;
    } else {
        print(&files.iter().map(Checked::text).collect::<String>())?;
    }
    Ok(!files.iter().flat_map(|file| &file.findings).any(Finding::is_error))
}

impl Checked {
    /// Checks a file. `seen` maps each maze found so far to the first file that contains it.
    fn new(entry: &Entry, format: Option<Format>, seen: &mut HashMap<Maze, PathBuf>) -> Self {
        let path = entry.path();
        let content = match entry.content() {
            Ok(content) => content,
            Err(error) => return Self::unread(path, &error),
        };
        let format = format.unwrap_or_else(|| Format::detect(&content));
        let (row, findings) = match format.read(&content) {
            Ok(reading) => {
                let row = MazeRow::from_maze(path, &reading.maze);
                let mut findings = Finding::from_reading(&reading);
                let first = seen.entry(reading.maze).or_insert_with(|| path.into());
                if !is_same_file(first, path) {
                    findings.push(Finding::duplicate(&first.display().to_string()));
                }
                (row, findings)
            }
            Err(errors) => {
                let findings: Vec<Finding> = errors.iter().map(Finding::from_error).collect();
                let first = errors.first().map(ToString::to_string).unwrap_or_default();
                (MazeRow::from_error(path, &format!("{}: {first}", path.display())), findings)
            }
        };
        Self { row, format: Some(format.name()), findings }
    }

    /// Returns the result for a file or folder that cannot be read. `error` must contain the path.
    fn unread(path: &Path, error: &impl Display) -> Self {
        let findings = vec![Finding::unreadable(error.to_string())];
        Self { row: MazeRow::from_error(path, error), format: None, findings }
    }

    /// Formats one line with the properties of the maze, or with the first error if the file cannot
    /// be read. The remaining findings follow, one line per kind.
    fn text(&self) -> String {
        let printed = usize::from(self.row.error.is_some()).min(self.findings.len());
        format!("{}\n{}", self.row.line(), lines(&self.findings[printed..]))
    }
}

/// Returns true if two paths refer to the same file, for example through a link.
fn is_same_file(one: &Path, other: &Path) -> bool {
    one == other
        || one.canonicalize().is_ok_and(|one| other.canonicalize().is_ok_and(|it| one == it))
}
