//! Updates `fetched`, the subfolder for fetched mazes in a folder chosen by the user.
//!
//! A fetch writes the fetched files to a new folder. It also copies any files that the user has
//! added or changed in the old folder. Finally, the new folder replaces the old one. A manifest in
//! the folder lists the fetched files.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io;
use std::path::{MAIN_SEPARATOR, Path};

use serde::Serialize;
use walkdir::WalkDir;

use super::archive::Files;

/// The name of the folder of fetched mazes.
pub(super) const FOLDER: &str = "fetched";
/// The name of the manifest file. The manifest has a line for each fetched file, with its CRC-32
/// in hexadecimal and its path.
const MANIFEST: &str = ".mmsim-fetched";
/// The name of the file that a fetch locks.
const LOCK: &str = ".mmsim-fetching";
/// The temporary name of the new folder.
const NEW: &str = ".mmsim-fetching-new";
/// The temporary name of the old folder.
const OLD: &str = ".mmsim-fetching-old";

/// The numbers of files that a fetch has added, replaced, left unchanged and removed. The field
/// names are JSON keys.
#[derive(Debug, Default, Serialize)]
pub(super) struct Changes {
    pub(super) new: usize,
    pub(super) replaced: usize,
    pub(super) unchanged: usize,
    pub(super) removed: usize,
    /// The paths of fetched files that are kept because the user has changed them.
    pub(super) kept: Vec<String>,
}

/// Replaces the fetched files in `parent` with `files`.
///
/// # Errors
/// Returns an error if a file cannot be read or written, or if the existing folder was not created
/// by mmsim. After an error, the existing folder is unchanged.
pub(super) fn replace(parent: &Path, files: &Files) -> Result<Changes, String> {
    check_owned(parent)?;
    let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    let missing: Vec<&Path> = parent.ancestors().take_while(is_missing).collect();
    let changes = fs::create_dir_all(parent)
        .and_then(|()| lock(parent))
        .map_err(cannot("write", parent))
        .and_then(|_lock| {
            let changes = replace_locked(parent, files);
            let _ = fs::remove_dir_all(parent.join(NEW));
            changes
        });
    if changes.is_err() && !missing.is_empty() {
        let _ = fs::remove_file(parent.join(LOCK));
        // Folders that are in use now are not empty and cannot be removed.
        for folder in missing {
            let _ = fs::remove_dir(folder);
        }
    }
    changes
}

fn replace_locked(parent: &Path, files: &Files) -> Result<Changes, String> {
    let [folder, new, old] = [FOLDER, NEW, OLD].map(|name| parent.join(name));
    // Clean up after a killed fetch. The rename fails unless the folder is missing.
    let _ = fs::rename(&old, &folder);
    let _ = fs::remove_dir_all(&old);
    let _ = fs::remove_dir_all(&new);
    let mut manifest = String::new();
    for (path, content) in files {
        let to = new.join(path);
        create_parent(&to)
            .and_then(|()| fs::write(&to, content))
            .map_err(cannot("write", &folder.join(path)))?;
        manifest.extend([&checksum(content), " ", path, "\n"]);
    }
    fs::write(new.join(MANIFEST), manifest).map_err(cannot("write", &folder))?;
    let changes = carry_over(&folder, &new, files)?;
    if folder.exists() {
        fs::rename(&folder, &old).map_err(cannot("write", &folder))?;
    }
    if let Err(error) = fs::rename(&new, &folder) {
        let _ = fs::rename(&old, &folder);
        return Err(cannot("write", &folder)(error));
    }
    // If this fails, the next fetch removes the old folder.
    let _ = fs::remove_dir_all(&old);
    Ok(changes)
}

/// Copies to `new` the files in `folder` that the user has added or changed. Copies nothing if
/// `folder` does not exist. Returns the numbers of new, replaced, unchanged and removed files, and
/// the paths of the files that the user has changed.
fn carry_over(folder: &Path, new: &Path, files: &Files) -> Result<Changes, String> {
    let mut changes = Changes { new: files.len(), ..Changes::default() };
    if !folder.exists() {
        return Ok(changes);
    }
    let manifest = fs::read_to_string(folder.join(MANIFEST)).map_err(cannot("read", folder))?;
    let fetched: HashMap<&str, &str> = (manifest.lines())
        .filter_map(|line| line.split_once(' ').map(|(sum, path)| (path, sum)))
        .collect();
    for entry in WalkDir::new(folder) {
        let entry = entry.map_err(|error| cannot("read", folder)(error.into()))?;
        let (from, kind) = (entry.path(), entry.file_type());
        let relative = from.strip_prefix(folder).unwrap_or(from);
        let path = relative.to_string_lossy().replace(MAIN_SEPARATOR, "/");
        if kind.is_dir() || path == MANIFEST {
            continue;
        }
        if !kind.is_file() {
            return Err(in_the_way(from, "is a link"));
        }
        let content = fs::read(from).map_err(cannot("read", from))?;
        let is_fetched = fetched.get(&*path).is_some_and(|&sum| sum == checksum(&content));
        let new_content = files.get(&path);
        changes.new -= usize::from(new_content.is_some());
        match new_content {
            Some(new) if *new == content => changes.unchanged += 1,
            Some(_) if is_fetched => changes.replaced += 1,
            None if is_fetched => changes.removed += 1,
            _ => {
                let to = new.join(relative);
                create_parent(&to)
                    .and_then(|()| fs::copy(from, &to))
                    .map_err(|error| in_the_way(from, &format!("cannot be kept: {error}")))?;
                if new_content.is_some() || fetched.contains_key(&*path) {
                    changes.kept.push(path);
                }
            }
        }
    }
    changes.kept.sort();
    Ok(changes)
}

/// Returns an error if the folder or the lock file exists but was not created by a fetch.
fn check_owned(parent: &Path) -> Result<(), String> {
    let [folder, lock] = [FOLDER, LOCK].map(|name| parent.join(name));
    let is_foreign = folder.exists() && !folder.join(MANIFEST).is_file();
    let problems: [(bool, &Path, &str); 4] = [
        (folder.is_symlink(), &folder, "is a link"),
        (folder.exists() && !folder.is_dir(), &folder, "is a file"),
        (is_foreign, &folder, "was not created by mmsim"),
        (lock.is_symlink() || lock.exists() && !lock.is_file(), &lock, "is not a regular file"),
    ];
    match problems.iter().find(|(is_present, ..)| *is_present) {
        Some((_, path, problem)) => Err(in_the_way(path, problem)),
        None => Ok(()),
    }
}

/// Locks the folder against other fetches, waiting if necessary. Does nothing on file systems that
/// do not support locks.
fn lock(parent: &Path) -> io::Result<File> {
    let lock = File::options().create(true).append(true).open(parent.join(LOCK))?;
    let _ = lock.lock();
    Ok(lock)
}

fn create_parent(path: &Path) -> io::Result<()> {
    path.parent().map_or(Ok(()), fs::create_dir_all)
}

fn checksum(content: &[u8]) -> String {
    format!("{:08x}", crc32fast::hash(content))
}

fn in_the_way(path: &Path, problem: &str) -> String {
    format!("{} {problem} (move it away or fetch into another folder)", path.display())
}

fn cannot(act: &str, path: &Path) -> impl Fn(io::Error) -> String {
    move |error| format!("cannot {act} {}: {error}", path.display())
}
