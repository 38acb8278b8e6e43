//! `mmsim mazes fetch`: download a public collection of mazes.

mod archive;
mod folder;
mod source;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use mmsim_formats::{Catalogue, Entry};
use mmsim_maze::{Counted, Escaped, counted};
use serde::Serialize;

use crate::args::CommandResult;
use crate::output::{note, own_command, print, print_pretty_json};
use crate::selection::home_folder;
use archive::{Contents, Files};
use folder::Changes;

pub(super) const FETCH: &str = "\
Download a public collection of real contest mazes, the maze files of micromouseonline, and write \
the bundled mazes next to them: text files, and mazes of the two-run trial in its own format.

The collection has no licence: the mazes belong to their authors, and you download them for your \
own use.

The mazes are stored in the subfolder `fetched`. Fetching again replaces mazes that have changed in \
the collection, removes mazes that were deleted from it, and keeps files that you have added or \
changed. Nothing outside the subfolder is touched. The environment variables HTTPS_PROXY, HTTP_PROXY \
and NO_PROXY apply.";

#[derive(Debug, Args)]
pub(super) struct FetchArgs {
    /// Folder for the mazes [default: ~/.mmsim, where mmsim looks for mazes first]
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
    /// Archive to fetch instead (.tar.gz, .zip or .tar): an https, http or file URL, or a local
    /// file; `bundled` writes only the bundled mazes, without a download
    #[arg(long, value_name = "URL|FILE|bundled")]
    from: Option<String>,
    /// Print a JSON object
    #[arg(long)]
    json: bool,
}

/// The URL of the latest version of the maze collection.
const COLLECTION: &str =
    "https://github.com/micromouseonline/mazefiles/archive/refs/heads/master.tar.gz";

/// The value of `--from` for the bundled mazes alone.
const BUNDLED: &str = "bundled";

/// The output of `mazes fetch --json`. The field names are JSON keys.
#[derive(Serialize)]
struct FetchReport<'a> {
    from: &'a str,
    folder: String,
    mazes: usize,
    #[serde(flatten)]
    changes: Changes,
    #[serde(rename = "passed_over")]
    skipped: usize,
}

pub(super) fn run(args: &FetchArgs) -> CommandResult {
    let Some(parent) = args.folder.clone().or_else(home_folder) else {
        let fetch = own_command("mazes fetch DIR");
        return Err(format!("cannot find the home folder (name a folder with {fetch})").into());
    };
    let from = args.from.as_deref().unwrap_or(COLLECTION);
    let cannot_fetch = |why: String| format!("cannot fetch {from}: {why}; nothing was changed");
    let Contents { files, invalid_names, .. } = if from == BUNDLED {
        Contents::default()
    } else {
        archive::unpack(&source::read(from)?).map_err(cannot_fetch)?
    };
    let mut all = files.len() + invalid_names.len();
    let (mut files, mut mazes) = select(files);
    if from == BUNDLED || (args.from.is_none() && !mazes.is_empty()) {
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
    let report = FetchReport { from, folder, mazes: mazes.len(), changes, skipped };
    if args.json {
        print_pretty_json(&report)?;
    } else {
        let (count, folder) = (counted(mazes.len(), "maze"), Escaped(report.folder));
        let Changes { new, replaced, unchanged, removed, .. } = report.changes;
        print(&format!(
            "{count} in {folder} (files: {new} new, {replaced} replaced, {unchanged} unchanged, \
             {removed} removed, {skipped} skipped)\n"
        ))?;
        let place = args.folder.as_ref().map(|folder| format!("{} ", folder.display()));
        let words = Path::new(example).file_stem().unwrap_or_default().display();
        let serve = own_command(&format!("{}--maze \"{words}\"", place.unwrap_or_default()));
        print(&format!("serve a maze with {serve}\n"))?;
    }
    Ok(true)
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
    let catalogue = Catalogue::from_contents(contents);
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
