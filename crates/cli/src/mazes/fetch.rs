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
use crate::output::{counted, note, own_command, print, print_json};
use crate::parallel::map_each;
use crate::selection::home_folder;
use crate::usage::CommandResult;

/// The output of `--json`. The field names are JSON keys.
#[derive(Serialize)]
struct FetchReport<'a> {
    from: &'a str,
    folder: String,
    mazes: usize,
    new: usize,
    replaced: usize,
    unchanged: usize,
    removed: usize,
    kept: Vec<String>,
    #[serde(rename = "passed_over")]
    skipped: usize,
}

/// The files of an archive to install: mazes, and files about them such as licences.
struct Collection {
    files: Files,
    /// The number of mazes.
    mazes: usize,
    /// The number of files that are not installed.
    skipped: usize,
    /// The skipped files whose names are not valid on every system.
    invalid_names: Vec<String>,
}

pub(super) fn run(args: &FetchArgs) -> CommandResult {
    let Some(parent) = args.folder.clone().or_else(home_folder) else {
        let fetch = own_command("mazes fetch DIR");
        return Err(format!("cannot find the home folder (name a folder with {fetch})").into());
    };
    let from = &args.from;
    let archive = source::read(from)?;
    let collection = archive::unpack(&archive)
        .and_then(Collection::new)
        .map_err(|error| format!("cannot fetch {from}: {error}; nothing was changed"))?;
    drop(archive);
    let Collection { files, mazes, skipped, invalid_names } = collection;
    let Changes { new, replaced, unchanged, removed, kept } = folder::replace(&parent, &files)?;
    note_files("skipped", "with names that are not valid on every system", &invalid_names);
    note_files("kept", "that you have changed", &kept);
    let folder = parent.join(folder::FOLDER).display().to_string();
    if args.json {
        let report =
            FetchReport { from, folder, mazes, new, replaced, unchanged, removed, kept, skipped };
        print_json(&serde_json::to_string_pretty(&report)?)?;
    } else {
        let (count, folder) = (counted(mazes as u64, "maze"), Escaped(folder));
        print(&format!(
            "{count} in {folder} (files: {new} new, {replaced} replaced, {unchanged} unchanged, \
             {removed} removed, {skipped} skipped)\n"
        ))?;
        let place = args.folder.as_ref().map(|folder| format!("{} ", folder.display()));
        let words = example_words(&files);
        let serve = own_command(&format!("{}--maze {words:?}", place.unwrap_or_default()));
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

impl Collection {
    /// Selects the files to install. Hidden files and the top folder are dropped.
    fn new(contents: Contents) -> Result<Self, String> {
        let Contents { mut files, invalid_names, .. } = contents;
        let (all, mut mazes) = (files.len() + invalid_names.len(), 0);
        // Such as an archive of ~/.mmsim.
        let is_all_hidden = files.keys().all(|path| is_hidden(path));
        if is_all_hidden {
            strip_top_folder(&mut files);
        }
        files.retain(|path, _| !is_hidden(path));
        if !is_all_hidden {
            strip_top_folder(&mut files);
        }
        let files: Vec<(String, Vec<u8>)> = files.into_iter().collect();
        let are_mazes = map_each(&files, |(path, content)| {
            !is_text(path) && mmsim_formats::parse_maze(content).is_ok()
        });
        let mut installed = Files::new();
        for ((path, content), is_maze) in files.into_iter().zip(are_mazes) {
            mazes += usize::from(is_maze);
            // A collection of mazes ignores files with this extension.
            let path = if is_maze || is_text(&path) { path } else { path + ".md" };
            if is_maze || is_about(&path) {
                installed.insert(path, content);
            }
        }
        if mazes == 0 {
            return Err(format!("no mazes in its {}", counted(all as u64, "file")));
        }
        Ok(Self { mazes, skipped: all - installed.len(), files: installed, invalid_names })
    }
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

/// Strips the top folder if all files are in the same one.
fn strip_top_folder(files: &mut Files) {
    let top = |path: &String| path.split_once('/').map(|(top, _)| top.to_string());
    let first = files.keys().next().and_then(top);
    if let Some(first) =
        first.filter(|first| files.keys().all(|path| top(path).as_ref() == Some(first)))
    {
        let strip = |(path, content): (String, _)| (path[first.len() + 1..].to_string(), content);
        *files = std::mem::take(files).into_iter().map(strip).collect();
    }
}

/// Whether a file is about the collection.
fn is_about(path: &str) -> bool {
    let name = path.rsplit('/').next().unwrap_or(path).to_lowercase();
    ["readme", "license", "licence", "copying"].iter().any(|start| name.starts_with(start))
}

/// Returns words that select one of the mazes.
fn example_words(files: &Files) -> String {
    const KNOWN: &str = "japan 2013";
    let is_known = |path: &String| KNOWN.split(' ').all(|word| path.to_lowercase().contains(word));
    if files.keys().any(is_known) {
        return KNOWN.into();
    }
    let first = files.keys().find(|path| !is_about(path)).map(Path::new);
    first.and_then(Path::file_stem).unwrap_or_default().to_string_lossy().into()
}
