//! Fetching into a folder in which there is something.

use std::fs;

use crate::archives::{tar_gz, zip};
use crate::harness::Home;
use crate::{MAZE, OTHER_MAZE, all_of, fetch, fetch_in_vain, home_with_mazes};

/// As it may look in an editor.
const EDITED: &str = "o---o---o\n| S | G |\no---o---o\n";

#[test]
fn what_changed_is_replaced_what_is_gone_is_removed_and_what_is_the_users_is_kept() {
    let home = Home::new();
    let names = ["same", "changed", "gone", "deep/gone", "edited", "edited-gone", "deleted"];
    let paths = names.map(|name| format!("top/{name}.txt"));
    let contents: Vec<_> = paths.iter().map(|path| (&path[..], MAZE)).collect();
    let old = home.write("old.tar.gz", tar_gz(&contents));
    assert_eq!(fetch(&home, old.to_str().unwrap()).code, Some(0));
    home.write("mazes/edited.txt", EDITED);
    home.write("mazes/edited-gone.txt", EDITED);
    home.write("mazes/mine.txt", EDITED);
    home.write("mazes/equal.txt", OTHER_MAZE);
    home.write("mazes/taken.txt", EDITED);
    fs::remove_file(home.path().join("mazes/deleted.txt")).unwrap();

    let new = zip(&[
        ("top/same.txt", MAZE),
        ("top/changed.txt", OTHER_MAZE),
        ("top/edited.txt", OTHER_MAZE),
        ("top/equal.txt", OTHER_MAZE),
        ("top/taken.txt", OTHER_MAZE),
        ("top/deleted.txt", MAZE),
    ]);
    let new = home.write("new.zip", new);
    let ended = fetch(&home, new.to_str().unwrap());
    assert_eq!(ended.code, Some(0));
    insta::assert_snapshot!(ended.stderr, @"kept 3 files of yours that the collection has otherwise: edited.txt, taken.txt, edited-gone.txt");
    insta::assert_snapshot!(ended.stdout.lines().next().unwrap(), @"6 mazes in mazes (files: 1 new, 1 replaced, 2 unchanged, 2 removed, 0 passed over)");
    let read = |name: &str| fs::read_to_string(home.path().join("mazes").join(name)).ok();
    let is = |name: &str| match read(name).as_deref() {
        Some(MAZE) => "old",
        Some(OTHER_MAZE) => "new",
        Some(EDITED) => "mine",
        _ => "none",
    };
    assert_eq!(
        ["same.txt", "changed.txt", "equal.txt", "deleted.txt"].map(is),
        ["old", "new", "new", "old"]
    );
    assert_eq!(["edited.txt", "edited-gone.txt", "mine.txt", "taken.txt"].map(is), ["mine"; 4]);
    assert_eq!(["gone.txt", "deep/gone.txt"].map(is), ["none"; 2]);
    assert!(!home.path().join("mazes/deep").exists());

    let before = all_of(&home.path().join("mazes"));
    let again = fetch(&home, new.to_str().unwrap());
    insta::assert_snapshot!(again.stdout.lines().next().unwrap(), @"6 mazes in mazes (files: 0 new, 0 replaced, 4 unchanged, 0 removed, 0 passed over)");
    insta::assert_snapshot!(again.stderr, @"kept 2 files of yours that the collection has otherwise: edited.txt, taken.txt");
    assert_eq!(all_of(&home.path().join("mazes")), before);
}

#[test]
fn what_another_run_left_behind_when_it_was_killed_is_cleaned_up() {
    let home = home_with_mazes();
    home.write("mazes/.mmsim-fetching-abc/new-1", MAZE);
    // It was killed after it had replaced the file, when the list held both.
    home.write("mazes/classic/old.txt", OTHER_MAZE);
    let [old, new] = [MAZE, OTHER_MAZE].map(|maze| crc32fast::hash(maze.as_bytes()));
    let list = format!("{old:08x} classic/old.txt\n{new:08x} classic/old.txt\n");
    home.write("mazes/.mmsim-fetched", list);
    let ended = fetch(&home, "old.tar.gz");
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    assert_eq!(fs::read_to_string(home.path().join("mazes/classic/old.txt")).unwrap(), MAZE);
    assert!(!home.path().join("mazes/.mmsim-fetching-abc").exists());
}

#[test]
fn a_list_that_leads_elsewhere_removes_nothing() {
    let home = home_with_mazes();
    let outside = home.write("outside.txt", MAZE);
    let sum = crc32fast::hash(MAZE.as_bytes());
    let absolute = outside.display();
    home.write(
        "mazes/.mmsim-fetched",
        format!("{sum:08x} ../outside.txt\n{sum:08x} {absolute}\nx\n"),
    );
    assert_eq!(fetch(&home, "old.tar.gz").code, Some(0));
    assert!(outside.is_file());
}

#[test]
fn a_file_in_place_of_a_folder_is_not_lost() {
    let home = Home::new();
    home.write("mazes/classic", "my notes");
    home.write("new.tar.gz", tar_gz(&[("top/a.txt", MAZE), ("top/classic/new.txt", MAZE)]));
    insta::assert_snapshot!(fetch_in_vain(&home, "new.tar.gz").replace('\\', "/"), @"mmsim: mazes/classic: expected a folder, found a file; move it away or fetch into another folder");
    let home = Home::new();
    home.write("mazes", "my notes");
    home.write("new.tar.gz", tar_gz(&[("a.txt", MAZE)]));
    let error = fetch_in_vain(&home, "new.tar.gz");
    assert!(error.starts_with("mmsim: mazes"), "{error}");
}

/// The third file cannot be written, when two have taken their places.
#[test]
fn half_of_a_collection_is_taken_back() {
    let home = home_with_mazes();
    let new = [
        ("top/a.txt", MAZE),
        ("top/classic/old.txt", OTHER_MAZE),
        ("top/x", MAZE),
        ("top/x/y", MAZE),
    ];
    home.write("new.tar.gz", tar_gz(&new));
    let error = fetch_in_vain(&home, "new.tar.gz");
    assert!(
        error.replace('\\', "/").starts_with("mmsim: mazes/x/y: cannot be written: "),
        "{error}"
    );
    let home = Home::new();
    home.write("new.tar.gz", tar_gz(&new));
    fetch_in_vain(&home, "new.tar.gz");
    assert!(!home.path().join("mazes").exists());
}

#[cfg(unix)]
#[test]
fn links_in_the_folder_lead_nowhere() {
    use std::os::unix::fs::symlink;
    let home = home_with_mazes();
    home.write("elsewhere/old.txt", MAZE);
    home.write("new.tar.gz", tar_gz(&[("top/classic/old.txt", OTHER_MAZE), ("top/z.txt", MAZE)]));
    let classic = home.path().join("mazes/classic");
    fs::remove_dir_all(&classic).unwrap();
    symlink(home.path().join("elsewhere"), &classic).unwrap();
    insta::assert_snapshot!(fetch_in_vain(&home, "new.tar.gz"), @"mmsim: mazes/classic: expected a folder, found a link; move it away or fetch into another folder");
    // What is gone from the collection is not looked for behind a link either.
    home.write("none.tar.gz", tar_gz(&[("z.txt", MAZE)]));
    assert_eq!(fetch(&home, "none.tar.gz").code, Some(0));
    assert!(home.path().join("elsewhere/old.txt").is_file());

    // A link in place of a file is the user's, a folder that is one itself is what he asks for.
    let home = home_with_mazes();
    let file = home.path().join("mazes/classic/old.txt");
    fs::remove_file(&file).unwrap();
    let mine = home.write("mine.txt", "mine");
    symlink(&mine, &file).unwrap();
    home.write("new.tar.gz", tar_gz(&[("top/classic/old.txt", OTHER_MAZE), ("top/z.txt", MAZE)]));
    assert!(fetch(&home, "new.tar.gz").stderr.starts_with("kept 1 file of yours"));
    assert_eq!(fs::read(&mine).unwrap(), b"mine");
    fs::rename(home.path().join("mazes"), home.path().join("elsewhere")).unwrap();
    symlink("elsewhere", home.path().join("mazes")).unwrap();
    assert_eq!(fetch(&home, "old.tar.gz").code, Some(0));
    assert!(!home.path().join("elsewhere/z.txt").exists());
}

/// What is of ours in the folder may have been put there to lead elsewhere.
#[cfg(unix)]
#[test]
fn links_in_place_of_our_own_files_are_refused() {
    use std::os::unix::fs::symlink;
    let home = home_with_mazes();
    let outside = home.write("outside", "mine");
    for own in [".mmsim-fetching", ".mmsim-fetched"] {
        let path = home.path().join("mazes").join(own);
        let old = fs::read(&path).unwrap();
        for target in [home.path().join("missing"), outside.clone()] {
            fs::remove_file(&path).unwrap();
            symlink(target, &path).unwrap();
            let expected = format!(
                "mmsim: mazes/{own}: expected a file, found a link; move it away or fetch into another folder\n"
            );
            assert_eq!(fetch_in_vain(&home, "old.tar.gz"), expected);
        }
        fs::remove_file(&path).unwrap();
        fs::write(&path, old).unwrap();
    }
}

/// A limit on the size of files stands for a disk that is full.
#[cfg(unix)]
#[test]
fn a_full_disk_changes_nothing() {
    use std::process::Command;
    let home = home_with_mazes();
    let large = MAZE.to_string() + &"and more\n".repeat(1000);
    home.write("new.tar.gz", tar_gz(&[("top/classic/old.txt", OTHER_MAZE), ("top/z.txt", &large)]));
    let before = all_of(home.path());
    let limited = "trap '' XFSZ; ulimit -f 8; exec \"$0\" mazes fetch mazes --from new.tar.gz";
    let mut command = Command::new("sh");
    command.args(["-c", limited]).arg(env!("CARGO_BIN_EXE_mmsim")).current_dir(home.path());
    let ended = mmsim_tests::output(&mut command);
    let error = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(1), "{error}");
    assert!(error.starts_with("mmsim: mazes: cannot be written: "), "{error}");
    assert_eq!(all_of(home.path()), before);
}
