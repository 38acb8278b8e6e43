//! A folder of fetched files, in which its user may have files, too.
//!
//! A hidden list tells what was fetched. What differs from it is the user's and stays. New files are
//! written into a hidden folder inside and then take their places one by one; if that fails, all are
//! put back.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::Path;

use mmsim_formats::MAX_FILE_BYTES;
use tempfile::TempDir;

use super::archive::Files;
use super::path;
use super::undo::Undo;

/// The list of what was fetched: a line for each file, its CRC-32 in hexadecimal and its path.
const LIST: &str = ".mmsim-fetched";
/// Locked while somebody changes the folder.
const LOCK: &str = ".mmsim-fetching";
/// What the names of folders begin with in which new files are written.
const STAGING: &str = ".mmsim-fetching-";

/// What has become of the files.
#[derive(Debug, Default)]
pub(super) struct Placed {
    pub(super) new: usize,
    pub(super) replaced: usize,
    pub(super) unchanged: usize,
    pub(super) removed: usize,
    /// The user's own, which stay though the collection has others or none.
    pub(super) kept: Vec<String>,
}

/// Makes the folder hold these files instead of those that were fetched before.
///
/// # Errors
/// What cannot be written or would lead elsewhere, with its path. The folder is as it was then.
pub(super) fn place(folder: &Path, files: &Files) -> Result<Placed, String> {
    let mut undo = Undo::default();
    let placed = change(folder, files, &mut undo);
    if placed.is_err() {
        undo.all();
    }
    placed
}

fn change(folder: &Path, files: &Files, undo: &mut Undo) -> Result<Placed, String> {
    undo.create_folders(folder).map_err(at(folder))?;
    for own in [LOCK, LIST] {
        check_is_file(&folder.join(own))?;
    }
    let _lock = lock(folder, undo)?;
    let fetched = Fetched::read(folder);
    let plan = Plan::new(folder, files, &fetched)?;

    // All that can be full is full here, before anything is changed.
    let staging = TempDir::with_prefix_in(STAGING, folder).map_err(at(folder))?;
    let beside = staging.path().to_path_buf();
    undo.keep(staging);
    let stage = |name: &str, content: &[u8]| {
        let staged = beside.join(name);
        fs::write(&staged, content).map_err(at(folder)).map(|()| staged)
    };
    // Should this be killed half-way, both the old and the new files are told from the user's.
    let list_of_both = stage("both", plan.list.and(&fetched).text().as_bytes())?;
    let list = stage("list", plan.list.text().as_bytes())?;
    let mut staged = Vec::new();
    for (number, (path, content)) in plan.write.iter().enumerate() {
        staged.push((path, stage(&format!("new-{number}"), content)?));
    }

    undo.put(list_of_both, &folder.join(LIST)).map_err(at(folder))?;
    for (path, staged) in staged {
        let path = folder.join(path);
        let parent = path.parent().unwrap_or(folder);
        undo.create_folders(parent).and_then(|()| undo.put(staged, &path)).map_err(at(&path))?;
    }
    for path in &plan.remove {
        let path = folder.join(path);
        undo.remove(&path).map_err(at(&path))?;
    }
    undo.put(list, &folder.join(LIST)).map_err(at(folder))?;

    // No failure from here on: a folder that is not empty is kept.
    for path in &plan.remove {
        for parent in Path::new(path).ancestors().skip(1).filter(|parent| *parent != Path::new(""))
        {
            let _ = fs::remove_dir(folder.join(parent));
        }
    }
    Ok(plan.placed)
}

/// Waits until nobody else changes the folder, and cleans up after those that were killed. Some
/// network drives know no locks; there everybody has to see to it himself.
fn lock(folder: &Path, undo: &mut Undo) -> Result<File, String> {
    let path = folder.join(LOCK);
    let is_new = !path.exists();
    let lock = File::options().create(true).append(true).open(&path).map_err(at(&path))?;
    if is_new {
        undo.created(path);
    }
    if lock.lock().is_ok() {
        for entry in fs::read_dir(folder).map_err(at(folder))?.flatten() {
            if entry.file_name().as_encoded_bytes().starts_with(STAGING.as_bytes()) {
                let _ = fs::remove_dir_all(entry.path());
            }
        }
    }
    Ok(lock)
}

/// What is to be done.
struct Plan<'a> {
    write: Vec<(&'a str, &'a [u8])>,
    remove: Vec<&'a str>,
    list: Fetched,
    placed: Placed,
}

impl<'a> Plan<'a> {
    fn new(folder: &Path, files: &'a Files, fetched: &'a Fetched) -> Result<Self, String> {
        let (list, placed) = (Fetched::default(), Placed::default());
        let mut plan = Self { write: Vec::new(), remove: Vec::new(), list, placed };
        let placed = &mut plan.placed;
        for (path, content) in files {
            check_parents(folder, path)?;
            let sum = crc32fast::hash(content);
            match Found::at(&folder.join(path))? {
                Found::File(found) if found == *content => placed.unchanged += 1,
                Found::File(found) if fetched.has(path, &found) => {
                    placed.replaced += 1;
                    plan.write.push((path, content));
                }
                Found::Nothing => {
                    placed.new += 1;
                    plan.write.push((path, content));
                }
                Found::File(_) | Found::Other => {
                    placed.kept.push(path.clone());
                    continue;
                }
            }
            plan.list.0.entry(path.clone()).or_default().insert(sum);
        }
        for path in fetched.0.keys().filter(|path| !files.contains_key(*path)) {
            // What is no folder any more is the user's.
            let found = check_parents(folder, path).and_then(|()| Found::at(&folder.join(path)));
            match found.unwrap_or(Found::Nothing) {
                Found::File(found) if fetched.has(path, &found) => {
                    placed.removed += 1;
                    plan.remove.push(path);
                }
                Found::File(_) | Found::Other => placed.kept.push(path.clone()),
                Found::Nothing => {}
            }
        }
        Ok(plan)
    }
}

/// What there is at the place of a file.
enum Found {
    Nothing,
    File(Vec<u8>),
    /// A folder, a link, or more than is fetched.
    Other,
}

impl Found {
    fn at(path: &Path) -> Result<Self, String> {
        match fs::symlink_metadata(path) {
            Ok(found) if found.is_file() && found.len() <= MAX_FILE_BYTES => {
                fs::read(path).map(Self::File).map_err(at(path))
            }
            Ok(_) => Ok(Self::Other),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Self::Nothing),
            Err(error) => Err(at(path)(error)),
        }
    }
}

/// A link in place of a folder would lead elsewhere.
fn check_parents(folder: &Path, path: &str) -> Result<(), String> {
    for (end, _) in path.match_indices('/') {
        let parent = folder.join(&path[..end]);
        match fs::symlink_metadata(&parent) {
            Ok(found) if found.is_dir() => {}
            Ok(found) => {
                let found = if found.is_symlink() { "a link" } else { "a file" };
                return Err(format!(
                    "{}: expected a folder, found {found}; move it away or fetch into another folder",
                    parent.display()
                ));
            }
            Err(error) if error.kind() == ErrorKind::NotFound => break,
            Err(error) => return Err(at(&parent)(error)),
        }
    }
    Ok(())
}

/// A link in place of a file of ours would lead elsewhere, and a pipe would never end.
fn check_is_file(path: &Path) -> Result<(), String> {
    let found = match fs::symlink_metadata(path) {
        Ok(found) if found.is_symlink() => "a link",
        Ok(found) if !found.is_file() => "something else",
        _ => return Ok(()),
    };
    Err(format!(
        "{}: expected a file, found {found}; move it away or fetch into another folder",
        path.display()
    ))
}

/// The files that were fetched, by their paths, with the checksums of what they may hold.
#[derive(Debug, Default)]
struct Fetched(BTreeMap<String, BTreeSet<u32>>);

impl Fetched {
    /// The list of this folder. Lines that no fetch has written do not count.
    fn read(folder: &Path) -> Self {
        let mut fetched = Self::default();
        for line in fs::read_to_string(folder.join(LIST)).unwrap_or_default().lines() {
            let Some((sum, path)) = line.split_once(' ') else { continue };
            let is_inside = path::inside(path.as_bytes()) == Ok(Some(path.into()));
            if let Some(sum) = u32::from_str_radix(sum, 16).ok().filter(|_| is_inside) {
                fetched.0.entry(path.into()).or_default().insert(sum);
            }
        }
        fetched
    }

    fn text(&self) -> String {
        let lines = self
            .0
            .iter()
            .flat_map(|(path, sums)| sums.iter().map(move |sum| format!("{sum:08x} {path}\n")));
        lines.collect()
    }

    /// Whether this is what was fetched to there.
    fn has(&self, path: &str, content: &[u8]) -> bool {
        self.0.get(path).is_some_and(|sums| sums.contains(&crc32fast::hash(content)))
    }

    fn and(&self, other: &Self) -> Self {
        let mut both = self.0.clone();
        for (path, sums) in &other.0 {
            both.entry(path.clone()).or_default().extend(sums);
        }
        Self(both)
    }
}

/// What the system says of a path.
fn at(path: &Path) -> impl Fn(io::Error) -> String {
    move |error| format!("{}: cannot be written: {error}", path.display())
}
