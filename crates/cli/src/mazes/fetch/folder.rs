//! The folder of fetched mazes, which mmsim owns, inside a folder of the user's choice.
//!
//! A fetch builds the new folder next to the old one, copies the files that the user has added or
//! changed, and renames it into place. A manifest distinguishes fetched files from the user's.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;
use walkdir::WalkDir;

use super::archive::Files;

/// The name of the folder.
pub(super) const FOLDER: &str = "fetched";
/// The manifest: a line for each fetched file, its CRC-32 in hexadecimal and its path.
const MANIFEST: &str = ".mmsim-fetched";
/// The file that is locked during a fetch.
const LOCK: &str = ".mmsim-fetching";
/// The name of the new folder until it is complete.
const NEW: &str = ".mmsim-fetching-new";
/// The name of the old folder between the two renames.
const OLD: &str = ".mmsim-fetching-old";

/// What a fetch has changed, in numbers of files. The field names are JSON keys.
#[derive(Debug, Default, Serialize)]
pub(super) struct Changes {
    pub(super) new: usize,
    pub(super) replaced: usize,
    pub(super) unchanged: usize,
    pub(super) removed: usize,
    /// The user's versions of fetched files, which stay.
    pub(super) kept: Vec<String>,
}

/// Replaces the fetched files in `parent` by `files`.
///
/// # Errors
/// A file cannot be written, or the folder is not one of mmsim's. Nothing is changed then.
pub(super) fn replace(parent: &Path, files: &Files) -> Result<Changes, String> {
    check_owned(parent)?;
    let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    let missing: Vec<&Path> = parent.ancestors().take_while(is_missing).collect();
    let changes = fs::create_dir_all(parent)
        .and_then(|()| lock(parent))
        .map_err(cannot_write(parent))
        .and_then(|_lock| replace_locked(parent, files));
    if changes.is_err() {
        let _ = fs::remove_dir_all(parent.join(NEW));
        if !missing.is_empty() {
            let _ = fs::remove_file(parent.join(LOCK));
        }
        // Fails for folders that are in use by now.
        for folder in missing {
            let _ = fs::remove_dir(folder);
        }
    }
    changes
}

fn replace_locked(parent: &Path, files: &Files) -> Result<Changes, String> {
    let [folder, new, old] = [FOLDER, NEW, OLD].map(|name| parent.join(name));
    // A fetch may have been killed.
    if !folder.exists() {
        let _ = fs::rename(&old, &folder);
    }
    let _ = fs::remove_dir_all(&old);
    let _ = fs::remove_dir_all(&new);
    for (path, content) in files {
        write(&new.join(path), content).map_err(cannot_write(&folder.join(path)))?;
    }
    let line = |(path, content): (_, &Vec<u8>)| format!("{} {path}\n", checksum(content));
    let manifest: String = files.iter().map(line).collect();
    write(&new.join(MANIFEST), manifest.as_bytes()).map_err(cannot_write(&folder))?;
    let mut changes = Changes { new: files.len(), ..Changes::default() };
    if folder.exists() {
        carry_over(&folder, &new, files, &mut changes)?;
        fs::rename(&folder, &old).map_err(cannot_write(&folder))?;
    }
    if let Err(error) = fs::rename(&new, &folder) {
        let _ = fs::rename(&old, &folder);
        return Err(cannot_write(&folder)(error));
    }
    // The mazes are in place. What cannot be removed now is removed by the next fetch.
    let _ = fs::remove_dir_all(&old);
    Ok(changes)
}

/// Compares the old folder with the new files, and copies the user's files to the new folder.
fn carry_over(
    folder: &Path,
    new: &Path,
    files: &Files,
    changes: &mut Changes,
) -> Result<(), String> {
    let manifest = fs::read_to_string(folder.join(MANIFEST)).map_err(cannot_read(folder))?;
    let fetched: HashMap<&str, &str> = (manifest.lines())
        .filter_map(|line| line.split_once(' ').map(|(sum, path)| (path, sum)))
        .collect();
    for entry in WalkDir::new(folder) {
        let entry = entry.map_err(|error| cannot_read(folder)(error.into()))?;
        let (from, kind) = (entry.path(), entry.file_type());
        let names: Vec<_> = from.iter().skip(folder.iter().count()).collect();
        let path = names.join("/".as_ref()).to_string_lossy().into_owned();
        if kind.is_dir() || path == MANIFEST {
            continue;
        }
        if !kind.is_file() {
            return Err(in_the_way(from, "is a link"));
        }
        let content = fs::read(from).map_err(cannot_read(from))?;
        let is_fetched = fetched.get(&*path).is_some_and(|&sum| sum == checksum(&content));
        let new_content = files.get(&path);
        changes.new -= usize::from(new_content.is_some());
        match new_content {
            Some(new) if *new == content => changes.unchanged += 1,
            Some(_) if is_fetched => changes.replaced += 1,
            None if is_fetched => changes.removed += 1,
            _ => {
                let to = new.join(names.iter().collect::<PathBuf>());
                fs::create_dir_all(to.parent().unwrap_or(new))
                    .and_then(|()| fs::copy(from, &to))
                    .map_err(|error| in_the_way(from, &format!("cannot be kept: {error}")))?;
                if new_content.is_some() || fetched.contains_key(&*path) {
                    changes.kept.push(path);
                }
            }
        }
    }
    changes.kept.sort();
    Ok(())
}

/// Checks that a fetch created the folder and the lock, if they exist.
fn check_owned(parent: &Path) -> Result<(), String> {
    let [folder, lock] = [FOLDER, LOCK].map(|name| parent.join(name));
    let kind = |path| fs::symlink_metadata(path).ok().map(|found| found.file_type());
    match kind(&folder) {
        Some(kind) if kind.is_symlink() => Err(in_the_way(&folder, "is a link")),
        Some(kind) if !kind.is_dir() => Err(in_the_way(&folder, "is a file")),
        Some(_) if !folder.join(MANIFEST).is_file() => {
            Err(in_the_way(&folder, "was not created by mmsim"))
        }
        _ if kind(&lock).is_some_and(|kind| !kind.is_file()) => {
            Err(in_the_way(&lock, "is not a regular file"))
        }
        // They would be there twice.
        _ if parent.join(MANIFEST).exists() => {
            Err(in_the_way(parent, "has mazes of an unreleased version of mmsim"))
        }
        _ => Ok(()),
    }
}

/// Waits for other fetches, but not on file systems without locks.
fn lock(parent: &Path) -> io::Result<File> {
    let lock = File::options().create(true).append(true).open(parent.join(LOCK))?;
    let _ = lock.lock();
    Ok(lock)
}

fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    path.parent().map_or(Ok(()), fs::create_dir_all)?;
    fs::write(path, content)
}

fn checksum(content: &[u8]) -> String {
    format!("{:08x}", crc32fast::hash(content))
}

fn in_the_way(path: &Path, problem: &str) -> String {
    format!("{} {problem} (move it away or fetch into another folder)", path.display())
}

fn cannot_read(path: &Path) -> impl Fn(io::Error) -> String {
    move |error| format!("cannot read {}: {error}", path.display())
}

fn cannot_write(path: &Path) -> impl Fn(io::Error) -> String {
    move |error| format!("cannot write {}: {error}", path.display())
}
