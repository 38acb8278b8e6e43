//! `mmsim mazes fetch`: download a public collection of mazes.

mod archive;
mod folder;
mod source;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use mmsim_formats::{Catalogue, Choice, Entry};
use mmsim_maze::{Counted, Escaped, counted};
use serde::Serialize;

use crate::args::CommandResult;
use crate::output::{note, own_command, print, print_pretty_json};
use crate::selection::home_folder;
use archive::{Contents, Files};
use folder::Changes;

pub(super) const FETCH: &str = "\
Download a public collection of real contest mazes, and write the bundled mazes next to them: text \
files, and mazes of the two-run trial in its own format.

Collections:
  mazefiles  the maze files of micromouseonline, classic and half-size; no licence: the mazes belong \
to their authors, and you download them for your own use (github.com/micromouseonline/mazefiles)
  maze-data  mazes of Japanese contests by Ryotaro Onuki, many of them half-size; MIT licence \
(github.com/kerikun11/micromouse-maze-data)
  maze-tool  older maze files of micromouseonline, each in several formats; MIT licence \
(github.com/micromouseonline/micromouse_maze_tool)
  bundled    only the bundled mazes, without a download

The mazes are stored in the subfolder `fetched`. Fetching again replaces mazes that have changed in \
the collection, removes mazes that are not in it, such as those of another collection, and keeps files \
that you have added or changed. Nothing outside the subfolder is touched. The environment variables \
HTTPS_PROXY, HTTP_PROXY and NO_PROXY apply.";

#[derive(Debug, Args)]
pub(super) struct FetchArgs {
    /// Folder for the mazes [default: ~/.mmsim, where mmsim looks for mazes first]
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
    /// Collection to fetch: mazefiles, maze-data, maze-tool or bundled; or an archive (.tar.gz, .zip
    /// or .tar): an https, http or file URL, or a local file
    #[arg(long, value_name = "NAME|URL|FILE", default_value = COLLECTIONS[0].0)]
    from: String,
    /// Print a JSON object
    #[arg(long)]
    json: bool,
}

/// The names of the collections, and their repositories on GitHub. The first is the default.
const COLLECTIONS: [(&str, &str); 3] = [
    ("mazefiles", "micromouseonline/mazefiles"),
    ("maze-data", "kerikun11/micromouse-maze-data"),
    ("maze-tool", "micromouseonline/micromouse_maze_tool"),
];

/// The value of `--from` for the bundled mazes alone.
const BUNDLED: &str = "bundled";

/// The output of `mazes fetch --json`. The field names are JSON keys.
#[derive(Serialize)]
struct FetchReport<'a> {
    from: &'a str,
    folder: String,
    maze_count: usize,
    #[serde(flatten)]
    changes: Changes,
    skipped: usize,
}

pub(super) fn run(args: &FetchArgs) -> CommandResult {
    let Some(parent) = args.folder.clone().or_else(home_folder) else {
        let fetch = own_command("mazes fetch DIR");
        return Err(format!("cannot find the home folder (name a folder with {fetch})").into());
    };
    let collection = COLLECTIONS.iter().find(|(name, _)| *name == args.from);
    let address = collection.map(|(_, repository)| archive_url(repository));
    let from = address.as_deref().unwrap_or(&args.from);
    let cannot_fetch = |why: String| format!("cannot fetch {from}: {why}; nothing was changed");
    let Contents { files, invalid_names, .. } = if from == BUNDLED {
        Contents::default()
    } else {
        archive::unpack(&source::read(from)?).map_err(cannot_fetch)?
    };
    let mut all = files.len() + invalid_names.len();
    let (mut files, mut mazes) = select(files);
    if from == BUNDLED || (collection.is_some() && !mazes.is_empty()) {
        for &(name, content) in mmsim_mazes::FILES {
            let path = format!("mmsim/{name}");
            mazes.push(path.clone());
            files.insert(path, content.into());
            all += 1;
        }
    }
    let Some(example) = mazes.first() else {
        let all = counted(all, "file");
        return Err(cannot_fetch(format!("no mazes found in {all}")).into());
    };
    let changes = folder::replace(&parent, &files)?;
    note_files(&invalid_names, |count| {
        format!("skipped {count} with names that are not valid on every system")
    });
    note_files(&changes.kept, |count| format!("kept {count} that you have changed"));
    let (folder, skipped) = (parent.join(folder::FOLDER).display().to_string(), all - files.len());
    let report = FetchReport { from, folder, maze_count: mazes.len(), changes, skipped };
    if args.json {
        print_pretty_json(&report)?;
    } else {
        let (count, folder) = (counted(mazes.len(), "maze"), Escaped(report.folder));
        let Changes { new, replaced, unchanged, removed, .. } = report.changes;
        print(&format!(
            "{count} in {folder} (files: {new} new, {replaced} replaced, {unchanged} unchanged, \
             {removed} removed, {skipped} skipped)\n"
        ))?;
        // The separator at the end tells a folder from a command.
        let place = args.folder.as_ref().map(|folder| format!("{} ", folder.join("").display()));
        let words = Path::new(example).file_stem().unwrap_or_default().display();
        let serve = own_command(&format!("{}\"{words}\"", place.unwrap_or_default()));
        print(&format!("serve a maze with {serve}\n"))?;
    }
    Ok(true)
}

/// Returns the URL of the latest version of a repository on GitHub.
fn archive_url(repository: &str) -> String {
    format!("https://github.com/{repository}/archive/HEAD.tar.gz")
}

/// Prints a message with the number of files and the names of the first three. Prints nothing if
/// there are no files.
fn note_files(files: &[String], message: fn(Counted<'_>) -> String) {
    if !files.is_empty() {
        let message = message(counted(files.len(), "file"));
        let names = files[..files.len().min(3)].join(", ");
        let more = if files.len() > 3 { ", …" } else { "" };
        note(format_args!("{message}: {names}{more}"));
    }
}

/// Selects the mazes and the files about the collection, such as licences, and strips the top
/// folder from their paths. Returns all selected files, and the paths of the mazes among them.
fn select(mut all: Files) -> (Files, Vec<String>) {
    // The top folder itself may be hidden, such as in an archive of ~/.mmsim.
    let top = top_folder_bytes(&all);
    all.retain(|path, _| !is_hidden(&path[top..]));
    let top = top_folder_bytes(&all);
    let contents = all.iter().map(|(path, content)| (path[top..].into(), Ok(content.clone())));
    let catalogue = Catalogue::from_contents(contents, Choice::default());
    let is_maze = |entry: &&Entry| match entry.parsed() {
        Ok(_) => true,
        Err(error) => !error.readings().is_empty(),
    };
    let mazes = catalogue.entries().iter().filter(is_maze);
    let mazes: Vec<String> = mazes.map(|entry| entry.path().display().to_string()).collect();
    let selected: BTreeSet<&String> = mazes.iter().collect();
    let files = all.into_iter().map(|(path, content)| (path[top..].to_string(), content));
    let files = files.filter(|(path, _)| selected.contains(path) || is_about(path)).collect();
    (files, mazes)
}

/// Returns true if a file is hidden or in `__MACOSX`, where macOS stores metadata.
fn is_hidden(path: &str) -> bool {
    path.split('/').any(|name| name.starts_with('.') || name == "__MACOSX")
}

/// Returns the length of the top folder's name in bytes, including the `/`, or 0 if no top folder
/// contains all files.
fn top_folder_bytes(files: &Files) -> usize {
    let first = files.keys().next().map_or("", String::as_str);
    let top = first.find('/').map_or(0, |slash| slash + 1);
    if files.keys().all(|path| path.starts_with(&first[..top])) { top } else { 0 }
}

/// Returns true if a file describes the collection.
fn is_about(path: &str) -> bool {
    let name = path.rsplit('/').next().unwrap_or(path).to_lowercase();
    ["readme", "license", "licence", "copying"].iter().any(|start| name.starts_with(start))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_lists_all_collections_with_their_licences() {
        let listed = FETCH.lines().filter(|line| line.starts_with("  "));
        let names: Vec<_> = listed.map(|line| line.split_whitespace().next().unwrap()).collect();
        let all = COLLECTIONS.map(|(name, _)| name);
        assert_eq!(names, [&all[..], &[BUNDLED]].concat());
        for (name, repository) in COLLECTIONS {
            let line = FETCH.lines().find(|line| line.trim_start().starts_with(name)).unwrap();
            assert!(line.ends_with(&format!("(github.com/{repository})")), "{line}");
            assert!(line.contains("licence"), "{line}");
        }
    }
}
