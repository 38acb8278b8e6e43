//! `mmsim mazes fetch`: fetching generated archives from a local server and from files.

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

use harness::{Home, Output};

const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";
const OTHER_MAZE: &str = "o---o---o---o\n| S       G |\no---o---o---o\n";

/// Returns the paths of all entries in a folder, recursively, and the content of each file.
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

/// Fetches mazes from a file or URL into the `mazes` folder.
fn fetch(home: &Home, from: &str) -> Output {
    home.run(&["mazes", "fetch", "mazes", "--from", from])
}

/// Asserts that a fetch fails and changes no file in the home folder. Returns the error.
fn fetch_fails(home: &Home, from: &str) -> String {
    let before = all_of(home.path());
    let output = fetch(home, from);
    assert_eq!((output.code, &output.stdout[..]), (Some(1), ""), "{output:?}");
    let after = all_of(home.path());
    let (before, after): (Vec<_>, Vec<_>) = (before.iter().collect(), after.iter().collect());
    assert!(before == after, "{:?}", after.iter().map(|(path, _)| path).collect::<Vec<_>>());
    output.stderr
}

/// Returns a home folder with fetched mazes in the `mazes` folder.
fn home_with_mazes() -> Home {
    let home = Home::new();
    let archive = home.write("old.tar.gz", archives::tar_gz(&[("top/classic/old.txt", MAZE)]));
    assert_eq!(fetch(&home, archive.to_str().unwrap()).code, Some(0));
    home
}
