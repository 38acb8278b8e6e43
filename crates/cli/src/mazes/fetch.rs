//! `mmsim mazes fetch`: download a public collection of mazes.

mod archive;
mod folder;
mod path;
mod source;

use std::path::Path;

use archive::{Contents, Files};
use folder::Changes;
use mmsim_maze::Escaped;
use serde::Serialize;

use super::args::FetchArgs;
use crate::output::{counted, note, own_command, print, print_pretty_json};
use crate::selection::home_folder;
use crate::usage::CommandResult;

/// The output of `--json`. The field names are JSON keys.
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
    let from = &args.from;
    let Contents { files, invalid_names, .. } = archive::unpack(&source::read(from)?)
        .map_err(|error| format!("cannot fetch {from}: {error}; nothing was changed"))?;
    let all = files.len() + invalid_names.len();
    let (files, mazes) = select(files);
    let Some(example) = mazes.first() else {
        let all = counted(all as u64, "file");
        return Err(
            format!("cannot fetch {from}: no mazes in its {all}; nothing was changed").into()
        );
    };
    let changes = folder::replace(&parent, &files)?;
    note_files("skipped", "with names that are not valid on every system", &invalid_names);
    note_files("kept", "that you have changed", &changes.kept);
    let (folder, skipped) = (parent.join(folder::FOLDER).display().to_string(), all - files.len());
    let report = FetchReport { from, folder, mazes: mazes.len(), changes, skipped };
    if args.json {
        print_pretty_json(&report)?;
    } else {
        let (count, folder) = (counted(mazes.len() as u64, "maze"), Escaped(report.folder));
        let Changes { new, replaced, unchanged, removed, .. } = report.changes;
        print(&format!(
            "{count} in {folder} (files: {new} new, {replaced} replaced, {unchanged} unchanged, \
             {removed} removed, {skipped} skipped)\n"
        ))?;
        let place = args.folder.as_ref().map(|folder| format!("{} ", folder.display()));
        let words = Path::new(example).file_stem().unwrap_or_default().display();
        let serve = own_command(&format!("{}--maze \"{words}\"", place.unwrap_or_default()));
        print(&format!("serve one of them with {serve}\n"))?;
    }
    Ok(true)
}

/// Reports what was done with some files, and names the first ones.
fn note_files(done: &str, which: &str, files: &[String]) {
    if !files.is_empty() {
        let count = counted(files.len() as u64, "file");
        let (first, more) =
            (files[..files.len().min(3)].join(", "), if files.len() > 3 { ", …" } else { "" });
        note(format_args!("{done} {count} {which}: {first}{more}"));
    }
}

/// Selects the files to install: mazes, and files about them such as licences. The top folder is
/// stripped. Also returns the paths of the mazes.
fn select(mut all: Files) -> (Files, Vec<String>) {
    // The top folder may be hidden, such as in an archive of ~/.mmsim.
    let has_top = strip_top_folder(&mut all);
    all.retain(|path, _| !is_hidden(path));
    if !has_top {
        strip_top_folder(&mut all);
    }
    let (mut files, mut mazes) = (Files::new(), Vec::new());
    for (path, content) in all {
        if !is_text(&path) && mmsim_formats::parse_maze(&content).is_ok() {
            mazes.push(path.clone());
            files.insert(path, content);
        } else if is_about(&path) {
            // A collection of mazes ignores files with this extension.
            files.insert(if is_text(&path) { path } else { path + ".md" }, content);
        }
    }
    (files, mazes)
}

/// Whether a file is hidden. macOS puts metadata into `__MACOSX`.
fn is_hidden(path: &str) -> bool {
    path.split('/').any(|name| name.starts_with('.') || name == "__MACOSX")
}

/// Whether a collection of mazes ignores this file, whatever its content.
fn is_text(path: &str) -> bool {
    let extension = Path::new(path).extension().unwrap_or_default();
    ["md", "json"].iter().any(|text| extension.eq_ignore_ascii_case(text))
}

/// Strips the top folder if all files are in the same one. Returns whether they are.
fn strip_top_folder(files: &mut Files) -> bool {
    let first = files.keys().next().and_then(|path| path.split_once('/'));
    let top = first.map(|(top, _)| format!("{top}/"));
    let Some(top) = top.filter(|top| files.keys().all(|path| path.starts_with(top))) else {
        return false;
    };
    let strip = |(path, content): (String, _)| (path[top.len()..].to_string(), content);
    *files = std::mem::take(files).into_iter().map(strip).collect();
    true
}

/// Whether a file is about the collection.
fn is_about(path: &str) -> bool {
    let name = path.rsplit('/').next().unwrap_or(path).to_lowercase();
    ["readme", "license", "licence", "copying"].iter().any(|start| name.starts_with(start))
}
