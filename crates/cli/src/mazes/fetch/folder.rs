//! The folder of fetched mazes, which mmsim owns, inside a folder of the user's choice.
//!
//! A fetch builds the new folder next to the old one, copies the files that the user has added or
//! changed, and renames it into place. A manifest distinguishes fetched files from the user's.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, Metadata};
use std::io;
use std::path::{Path, PathBuf};

use mmsim_formats::MAX_FILE_BYTES;
use tempfile::TempDir;

use super::archive::Files;

/// The name of the folder.
pub(super) const FOLDER: &str = "fetched";
/// The manifest: a line for each fetched file, its CRC-32 in hexadecimal and its path. Earlier versions
/// had no folder of their own, and wrote files and manifest directly into the user's folder.
const MANIFEST: &str = ".mmsim-fetched";
/// The file that is locked during a fetch.
const LOCK: &str = ".mmsim-fetching";
/// The prefix of temporary folders.
const TEMPORARY: &str = ".mmsim-fetching-";
/// The name of the old folder between the two renames.
const OLD: &str = ".mmsim-fetching-old";

/// What a fetch has changed, in numbers of files.
#[derive(Debug, Default)]
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
    let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    let missing: Vec<&Path> = parent.ancestors().take_while(is_missing).collect();
    let changes = fs::create_dir_all(parent)
        .map_err(cannot_write(parent))
        .and_then(|()| replace_in(parent, files));
    if changes.is_err() && !missing.is_empty() {
        let _ = fs::remove_file(parent.join(LOCK));
        // Fails for folders that are in use by now.
        for folder in missing {
            let _ = fs::remove_dir(folder);
        }
    }
    changes
}

fn replace_in(parent: &Path, files: &Files) -> Result<Changes, String> {
    let (folder, old) = (parent.join(FOLDER), parent.join(OLD));
    check_owned(&folder)?;
    let _lock = lock(parent)?;
    let legacy = legacy_files(parent).map_err(cannot_write(parent))?;
    let temporary = TempDir::with_prefix_in(TEMPORARY, parent).map_err(cannot_write(parent))?;
    // The temporary folder itself is private to the user.
    let new = temporary.path().join(FOLDER);
    let manifest = Manifest::new(files);
    for (path, content) in files {
        write(&new.join(path), content).map_err(cannot_write(&folder.join(path)))?;
    }
    write(&new.join(MANIFEST), manifest.to_string().as_bytes()).map_err(cannot_write(&folder))?;
    let changes = carry_over(&folder, &new, &manifest, &legacy)?;
    if folder.exists() {
        fs::rename(&folder, &old).map_err(cannot_write(&folder))?;
    }
    if let Err(error) = fs::rename(&new, &folder) {
        let _ = fs::rename(&old, &folder);
        return Err(cannot_write(&folder)(error));
    }
    // The mazes are in place. What cannot be removed now is removed by the next fetch.
    let _ = fs::remove_dir_all(&old);
    remove_legacy(parent, &legacy);
    Ok(changes)
}

/// Compares the old folder with the new one, and copies the user's files to the new one.
fn carry_over(
    folder: &Path,
    new: &Path,
    manifest: &Manifest,
    legacy: &[(PathBuf, u32)],
) -> Result<Changes, String> {
    let old_manifest = Manifest::read(folder);
    let mut changes = Changes::default();
    let mut count = |path: &Path, sum| match manifest.0.get(path) {
        Some(sums) if sums.contains(&sum) => changes.unchanged += 1,
        Some(_) => changes.replaced += 1,
        None => changes.removed += 1,
    };
    for (path, sum) in legacy {
        count(path, *sum);
    }
    let mut kept = Vec::new();
    let old =
        if folder.exists() { walk(folder).map_err(cannot_write(folder))? } else { Vec::new() };
    for (path, metadata) in old.into_iter().filter(|(path, _)| path != Path::new(MANIFEST)) {
        let from = folder.join(&path);
        if !metadata.is_file() {
            return Err(in_the_way(&from, "is a link"));
        }
        let sum = checksum(&from, &metadata).map_err(cannot_write(&from))?;
        if let Some(sum) =
            sum.filter(|&sum| old_manifest.has(&path, sum) || manifest.has(&path, sum))
        {
            count(&path, sum);
            continue;
        }
        let to = new.join(&path);
        fs::create_dir_all(to.parent().unwrap_or(new))
            .and_then(|()| fs::copy(&from, &to))
            .map_err(|error| in_the_way(&from, &format!("cannot be kept: {error}")))?;
        if manifest.0.contains_key(&path) || old_manifest.0.contains_key(&path) {
            kept.push(path);
        }
    }
    let present = kept.iter().filter(|path| manifest.0.contains_key(*path)).count();
    changes.new = manifest.0.len() - present - changes.unchanged - changes.replaced;
    kept.sort();
    changes.kept = kept.iter().map(|path| path.display().to_string()).collect();
    Ok(changes)
}

/// Checks that the folder was created by a fetch, if it exists.
fn check_owned(folder: &Path) -> Result<(), String> {
    match fs::symlink_metadata(folder) {
        Err(_) => Ok(()),
        Ok(found) if found.is_symlink() => Err(in_the_way(folder, "is a link")),
        Ok(found) if !found.is_dir() => Err(in_the_way(folder, "is a file")),
        Ok(_) if folder.join(MANIFEST).is_file() => Ok(()),
        Ok(_) => Err(in_the_way(folder, "was not created by mmsim")),
    }
}

/// Waits for other fetches, and cleans up after those that were killed. Does not wait on file systems
/// without locks.
fn lock(parent: &Path) -> Result<File, String> {
    let path = parent.join(LOCK);
    if fs::symlink_metadata(&path).is_ok_and(|found| !found.is_file()) {
        return Err(in_the_way(&path, "is not a regular file"));
    }
    let lock =
        File::options().create(true).append(true).open(&path).map_err(cannot_write(&path))?;
    if lock.lock().is_ok() {
        if !parent.join(FOLDER).exists() {
            let _ = fs::rename(parent.join(OLD), parent.join(FOLDER));
        }
        for entry in fs::read_dir(parent).map_err(cannot_write(parent))?.flatten() {
            if entry.file_name().as_encoded_bytes().starts_with(TEMPORARY.as_bytes()) {
                let _ = fs::remove_dir_all(entry.path());
            }
        }
    }
    Ok(lock)
}

/// Returns the unchanged files of earlier versions, with their checksums.
fn legacy_files(parent: &Path) -> io::Result<Vec<(PathBuf, u32)>> {
    let manifest = Manifest::read(parent);
    if manifest.0.is_empty() {
        return Ok(Vec::new());
    }
    let mut files = Vec::new();
    for (path, metadata) in walk(parent)? {
        if let Some(sum) = checksum(&parent.join(&path), &metadata)?
            && manifest.has(&path, sum)
        {
            files.push((path, sum));
        }
    }
    Ok(files)
}

fn remove_legacy(parent: &Path, files: &[(PathBuf, u32)]) {
    let mut is_complete = true;
    for (path, _) in files {
        is_complete &= fs::remove_file(parent.join(path)).is_ok();
        for folder in path.ancestors().skip(1).filter(|folder| *folder != Path::new("")) {
            // Fails for folders that are not empty.
            let _ = fs::remove_dir(parent.join(folder));
        }
    }
    if is_complete {
        let _ = fs::remove_file(parent.join(MANIFEST));
    }
}

/// Lists everything below a folder but folders, without following links. Paths are relative.
fn walk(root: &Path) -> io::Result<Vec<(PathBuf, Metadata)>> {
    let (mut found, mut folders) = (Vec::new(), vec![PathBuf::new()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(root.join(&folder))? {
            let entry = entry?;
            let (path, metadata) = (folder.join(entry.file_name()), entry.metadata()?);
            if metadata.is_dir() {
                folders.push(path);
            } else {
                found.push((path, metadata));
            }
        }
    }
    Ok(found)
}

/// Returns the CRC-32 of a file, `None` if no fetch can have written it.
fn checksum(path: &Path, metadata: &Metadata) -> io::Result<Option<u32>> {
    let is_possible = metadata.is_file() && metadata.len() <= MAX_FILE_BYTES;
    is_possible.then(|| Ok(crc32fast::hash(&fs::read(path)?))).transpose()
}

fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    path.parent().map_or(Ok(()), fs::create_dir_all)?;
    fs::write(path, content)
}

/// The paths of fetched files and their possible checksums.
struct Manifest(BTreeMap<PathBuf, BTreeSet<u32>>);

impl Manifest {
    fn new(files: &Files) -> Self {
        let sum = |content: &Vec<u8>| [crc32fast::hash(content)].into();
        Self(files.iter().map(|(path, content)| (path.into(), sum(content))).collect())
    }

    /// Reads the manifest in this folder, if there is one. Malformed lines are skipped.
    fn read(folder: &Path) -> Self {
        let text = fs::read_to_string(folder.join(MANIFEST)).unwrap_or_default();
        let mut files = BTreeMap::<PathBuf, BTreeSet<u32>>::new();
        for (sum, path) in text.lines().filter_map(|line| line.split_once(' ')) {
            if let Ok(sum) = u32::from_str_radix(sum, 16) {
                files.entry(path.into()).or_default().insert(sum);
            }
        }
        Self(files)
    }

    fn has(&self, path: &Path, sum: u32) -> bool {
        self.0.get(path).is_some_and(|sums| sums.contains(&sum))
    }
}

impl std::fmt::Display for Manifest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut lines =
            self.0.iter().flat_map(|(path, sums)| sums.iter().map(move |sum| (path, sum)));
        lines.try_for_each(|(path, sum)| writeln!(f, "{sum:08x} {}", path.display()))
    }
}

fn in_the_way(path: &Path, problem: &str) -> String {
    format!("{} {problem} (move it away or fetch into another folder)", path.display())
}

fn cannot_write(path: &Path) -> impl Fn(io::Error) -> String {
    move |error| format!("cannot write {}: {error}", path.display())
}
