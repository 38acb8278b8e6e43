//! `mmsim mazes fetch`: a public collection of mazes.

mod archive;
mod folder;
mod path;
mod source;
mod undo;

use std::path::Path;

use archive::{Contents, Files};
use folder::Placed;
use mmsim_maze::Escaped;
use serde::Serialize;

use super::args::FetchArgs;
use crate::output::{counted, note, own_command, print, print_json};
use crate::parallel::map_each;
use crate::selection::home_folder;
use crate::usage::CommandResult;

/// What was fetched. The names are those of the JSON.
#[derive(Serialize)]
struct Report<'a> {
    from: &'a str,
    folder: String,
    mazes: usize,
    new: usize,
    replaced: usize,
    unchanged: usize,
    removed: usize,
    kept: Vec<String>,
    passed_over: usize,
}

/// The files of an archive that are worth keeping.
struct Collection {
    files: Files,
    /// How many of them are mazes.
    mazes: usize,
    /// How many others there were.
    passed_over: usize,
    /// Those of them whose names not every system can have.
    odd: Vec<String>,
}

pub(super) fn run(args: &FetchArgs) -> CommandResult {
    let Some(folder) = args.folder.clone().or_else(home_folder) else {
        let fetch = own_command("mazes fetch DIR");
        return Err(
            format!("expected a folder of the user's own, found none; name one: {fetch}").into()
        );
    };
    let from = &args.from;
    let archive = source::read(from)?;
    let collection = archive::unpack(&archive)
        .map_err(|refused| refused.to_string())
        .and_then(Collection::of)
        .map_err(|error| format!("{from}: {error}; nothing was changed"))?;
    drop(archive);
    let Collection { files, mazes, passed_over, odd } = collection;
    let Placed { new, replaced, unchanged, removed, kept } = folder::place(&folder, &files)?;
    say_files("passed over", "that not every system can name", &odd);
    say_files("kept", "of yours that the collection has otherwise", &kept);
    let shown = folder.display().to_string();
    if args.json {
        let report = Report {
            from,
            folder: shown,
            mazes,
            new,
            replaced,
            unchanged,
            removed,
            kept,
            passed_over,
        };
        print_json(&serde_json::to_string_pretty(&report)?)?;
    } else {
        let count = counted(mazes as u64, "maze");
        let shown = Escaped(shown);
        print(&format!(
            "{count} in {shown} (files: {new} new, {replaced} replaced, {unchanged} unchanged, \
             {removed} removed, {passed_over} passed over)\n"
        ))?;
        let place = args.folder.as_ref().map(|_| format!("{shown} ")).unwrap_or_default();
        let serve = own_command(&format!("{place}--maze {:?}", words(&files)));
        print(&format!("{serve} serves one of them\n"))?;
    }
    Ok(true)
}

/// Says what was done with which files, if there are some; the first of them by name.
fn say_files(done: &str, which: &str, files: &[String]) {
    if !files.is_empty() {
        let count = counted(files.len() as u64, "file");
        let (first, more) =
            (files[..files.len().min(3)].join(", "), if files.len() > 3 { ", …" } else { "" });
        note(format_args!("{done} {count} {which}: {first}{more}"));
    }
}

impl Collection {
    /// The mazes of an archive, and what tells where they are from.
    fn of(contents: Contents) -> Result<Self, String> {
        let Contents { mut files, odd, .. } = contents;
        let (all, mut mazes) = (files.len() + odd.len(), 0);
        // Such as ~/.mmsim, packed as it is.
        let is_all_hidden = files.keys().all(|path| is_hidden(path));
        if is_all_hidden {
            leave_top_folder_out(&mut files);
        }
        files.retain(|path, _| !is_hidden(path));
        if !is_all_hidden {
            leave_top_folder_out(&mut files);
        }
        let files: Vec<(String, Vec<u8>)> = files.into_iter().collect();
        let are_mazes = map_each(&files, |(path, content)| {
            !is_text(path) && mmsim_formats::parse_maze(content).is_ok()
        });
        let files: Files = files
            .into_iter()
            .zip(are_mazes)
            .filter_map(|((path, content), is_maze)| {
                if is_maze {
                    mazes += 1;
                    return Some((path, content));
                }
                // With this ending nobody takes it for a maze.
                let path = if is_text(&path) { path } else { path + ".md" };
                is_about(&path).then_some((path, content))
            })
            .collect();
        if mazes == 0 {
            return Err(format!(
                "expected an archive with mazes, found none in {}",
                counted(all as u64, "file")
            ));
        }
        let passed_over = all - files.len();
        Ok(Self { files, mazes, passed_over, odd })
    }
}

/// Whether this is no file to its user: macOS puts what it knows of each file into `__MACOSX`.
fn is_hidden(path: &str) -> bool {
    path.split('/').any(|name| name.starts_with('.') || name == "__MACOSX")
}

/// Whether this file counts as text, whatever is in it: a collection of mazes skips it.
fn is_text(path: &str) -> bool {
    let ending = Path::new(path).extension().unwrap_or_default();
    ["md", "json"].iter().any(|text| ending.eq_ignore_ascii_case(text))
}

/// Takes the one folder away that all files are in, if there is one.
fn leave_top_folder_out(files: &mut Files) {
    let top = |path: &String| path.split_once('/').map(|(top, _)| top.to_string());
    let first = files.keys().next().and_then(top);
    if let Some(first) =
        first.filter(|first| files.keys().all(|path| top(path).as_ref() == Some(first)))
    {
        *files = std::mem::take(files)
            .into_iter()
            .map(|(path, content)| (path[first.len() + 1..].to_string(), content))
            .collect();
    }
}

/// Whether this tells whose mazes they are.
fn is_about(path: &str) -> bool {
    let name = path.rsplit('/').next().unwrap_or(path).to_lowercase();
    ["readme", "license", "licence", "copying"].iter().any(|begin| name.starts_with(begin))
}

/// Words that find a maze of these.
fn words(files: &Files) -> String {
    const KNOWN: &str = "japan 2013";
    let is_known = |path: &String| KNOWN.split(' ').all(|word| path.to_lowercase().contains(word));
    if files.keys().any(is_known) {
        return KNOWN.into();
    }
    let first = files.keys().find(|path| !is_about(path)).map(Path::new);
    first.and_then(Path::file_stem).unwrap_or_default().to_string_lossy().into()
}
