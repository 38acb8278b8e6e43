//! `mmsim mazes fetch`: a collection from made archives, by a server here and from files.

#[path = "../harness/mod.rs"]
mod harness;

mod again;
mod archives;
mod good;
mod hostile;
mod server;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use harness::{Ended, Home};

const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";
const OTHER_MAZE: &str = "o---o---o---o\n| S       G |\no---o---o---o\n";

/// Everything in a folder: its files with their content, and its folders and links.
fn all_of(folder: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let kind = entry.file_type().unwrap();
        all.insert(entry.path(), kind.is_file().then(|| fs::read(entry.path()).unwrap()));
        if kind.is_dir() {
            all.extend(all_of(&entry.path()));
        }
    }
    all
}

/// Fetches into the folder `mazes` of the home.
fn fetch(home: &Home, from: &str) -> Ended {
    home.run(&["mazes", "fetch", "mazes", "--from", from])
}

/// Tries to, and asserts that this failed and changed nothing, neither in the folder nor beside it.
fn fetch_in_vain(home: &Home, from: &str) -> String {
    let before = all_of(home.path());
    let ended = fetch(home, from);
    assert_eq!((ended.code, &ended.stdout[..]), (Some(1), ""), "{ended:?}");
    let after = all_of(home.path());
    let (before, after): (Vec<_>, Vec<_>) = (before.iter().collect(), after.iter().collect());
    assert!(before == after, "{:?}", after.iter().map(|(path, _)| path).collect::<Vec<_>>());
    ended.stderr
}

/// A home in which mazes have been fetched into the folder `mazes`.
fn home_with_mazes() -> Home {
    let home = Home::new();
    let archive = home.write("old.tar.gz", archives::tar_gz(&[("top/classic/old.txt", MAZE)]));
    assert_eq!(fetch(&home, archive.to_str().unwrap()).code, Some(0));
    home
}
