//! `mmsim mazes check`: what is wrong with maze files.

use std::path::PathBuf;

use mmsim_maze::Catalogue;

use super::row::{Row, print_rows};
use crate::Outcome;

pub(super) fn run(paths: &[PathBuf], json: bool) -> Outcome {
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
