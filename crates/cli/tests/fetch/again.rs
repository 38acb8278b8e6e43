//! Fetching mazes into a folder that is not empty.

use std::fs;

use crate::archives::{tar_gz, zip};
use crate::harness::Home;
use crate::{MAZE, OTHER_MAZE, all_of, fetch, fetch_fails, home_with_mazes};

/// A fetched maze that the user has edited.
const EDITED: &str = "o---o---o\n| S | G |\no---o---o\n";

#[test]
fn fetch_replaces_changed_files_removes_missing_files_and_keeps_user_files() {
    let home = Home::new();
    let names = ["same", "changed", "gone", "deep/gone", "edited", "edited-gone", "deleted"];
    let paths = names.map(|name| format!("top/{name}.txt"));
    let contents: Vec<_> = paths.iter().map(|path| (&path[..], MAZE)).collect();
    let old = home.write("old.tar.gz", tar_gz(&contents));
    assert_eq!(fetch(&home, old.to_str().unwrap()).code, Some(0));
    home.write("mazes/mine.txt", EDITED);
    for name in ["edited", "edited-gone", "mine", "taken"] {
        home.write(&format!("mazes/fetched/{name}.txt"), EDITED);
    }
    home.write("mazes/fetched/equal.txt", OTHER_MAZE);
    fs::remove_file(home.path().join("mazes/fetched/deleted.txt")).unwrap();

    let new = zip(&[
        ("top/same.txt", MAZE),
        ("top/changed.txt", OTHER_MAZE),
        ("top/edited.txt", OTHER_MAZE),
        ("top/equal.txt", OTHER_MAZE),
        ("top/taken.txt", OTHER_MAZE),
        ("top/deleted.txt", MAZE),
    ]);
    let new = home.write("new.zip", new);
    let output = fetch(&home, new.to_str().unwrap());
    assert_eq!(output.code, Some(0));
    insta::assert_snapshot!(output.stderr, @"kept 3 files that you have changed: edited-gone.txt, edited.txt, taken.txt");
    insta::assert_snapshot!(output.stdout.lines().next().unwrap(), @"6 mazes in mazes/fetched (files: 1 new, 1 replaced, 2 unchanged, 2 removed, 0 skipped)");
    let read = |name: &str| fs::read_to_string(home.path().join("mazes/fetched").join(name)).ok();
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
    let mine = ["edited.txt", "edited-gone.txt", "mine.txt", "taken.txt", "../mine.txt"];
    assert_eq!(mine.map(is), ["mine"; 5]);
    assert_eq!(["gone.txt", "deep/gone.txt"].map(is), ["none"; 2]);
    assert!(!home.path().join("mazes/fetched/deep").exists());

    let before = all_of(&home.path().join("mazes"));
    let again = fetch(&home, new.to_str().unwrap());
    insta::assert_snapshot!(again.stdout.lines().next().unwrap(), @"6 mazes in mazes/fetched (files: 0 new, 0 replaced, 4 unchanged, 0 removed, 0 skipped)");
    insta::assert_snapshot!(again.stderr, @"kept 2 files that you have changed: edited.txt, taken.txt");
    assert_eq!(all_of(&home.path().join("mazes")), before);
}

#[test]
fn cleans_up_after_a_killed_fetch() {
    let home = home_with_mazes();
    let mazes = home.path().join("mazes");
    home.write("mazes/.mmsim-fetching-new/new.txt", MAZE);
    let before = all_of(&mazes.join("fetched"));
    // Simulate a process that was killed between the two renames.
    fs::rename(mazes.join("fetched"), mazes.join(".mmsim-fetching-old")).unwrap();
    home.write("empty.zip", zip(&[]));
    assert_eq!(fetch(&home, "empty.zip").code, Some(1), "too early to clean up");
    let output = fetch(&home, "old.tar.gz");
    assert_eq!((output.code, &output.stderr[..]), (Some(0), ""));
    assert!(output.stdout.contains("0 new, 0 replaced, 1 unchanged"), "{output:?}");
    assert_eq!(all_of(&mazes.join("fetched")), before);
    assert_eq!(fs::read_dir(&mazes).unwrap().count(), 2, "the folder and the lock");
}

#[test]
fn folders_and_files_of_the_user_are_not_replaced() {
    let home = Home::new();
    home.write("new.tar.gz", tar_gz(&[("top/a.txt", MAZE), ("top/classic/new.txt", MAZE)]));
    home.write("mazes/fetched/mine.txt", MAZE);
    insta::assert_snapshot!(fetch_fails(&home, "new.tar.gz").replace('\\', "/"), @"mmsim: mazes/fetched was not created by mmsim (move it away or fetch into another folder)");
    fs::remove_dir_all(home.path().join("mazes/fetched")).unwrap();
    home.write("mazes/fetched", "my notes");
    insta::assert_snapshot!(fetch_fails(&home, "new.tar.gz").replace('\\', "/"), @"mmsim: mazes/fetched is a file (move it away or fetch into another folder)");
    fs::remove_dir_all(home.path().join("mazes")).unwrap();
    home.write("mazes", "my notes");
    let error = fetch_fails(&home, "new.tar.gz");
    assert!(error.starts_with("mmsim: cannot write mazes: "), "{error}");
    // The user's file is where the collection has a folder.
    let home = home_with_mazes();
    home.write("mazes/fetched/new", EDITED);
    home.write("new.tar.gz", tar_gz(&[("new/a.txt", MAZE), ("b.txt", MAZE)]));
    let error = fetch_fails(&home, "new.tar.gz").replace('\\', "/");
    assert!(error.starts_with("mmsim: mazes/fetched/new cannot be kept: "), "{error}");
}

/// The fetch fails at the last file, after all other files have been written.
#[test]
fn failed_fetches_change_nothing() {
    let home = home_with_mazes();
    let new = [
        ("top/a.txt", MAZE),
        ("top/classic/old.txt", OTHER_MAZE),
        ("top/x", MAZE),
        ("top/x/y", MAZE),
    ];
    home.write("new.tar.gz", tar_gz(&new));
    let error = fetch_fails(&home, "new.tar.gz").replace('\\', "/");
    assert!(error.starts_with("mmsim: cannot write mazes/fetched/x/y: "), "{error}");
    let home = Home::new();
    home.write("new.tar.gz", tar_gz(&new));
    fetch_fails(&home, "new.tar.gz");
    assert!(!home.path().join("mazes").exists());
}

#[cfg(unix)]
#[test]
fn links_are_not_followed() {
    use std::os::unix::fs::symlink;
    let home = home_with_mazes();
    let outside = home.write("outside/old.txt", MAZE);
    home.write("new.tar.gz", tar_gz(&[("top/classic/old.txt", OTHER_MAZE), ("top/z.txt", MAZE)]));
    // The link replaces a file or a folder inside the fetched folder.
    for (path, target) in [("classic/old.txt", &outside), ("classic", &home.path().join("outside"))]
    {
        let path = home.path().join("mazes/fetched").join(path);
        let _ = fs::remove_file(&path).or_else(|_| fs::remove_dir_all(&path));
        symlink(target, &path).unwrap();
        let error = fetch_fails(&home, "new.tar.gz");
        assert!(
            error.ends_with(" is a link (move it away or fetch into another folder)\n"),
            "{error}"
        );
    }
    // The link replaces the fetched folder or the lock file.
    let folder = home.path().join("mazes/fetched");
    fs::remove_dir_all(&folder).unwrap();
    symlink(home.path().join("outside"), &folder).unwrap();
    insta::assert_snapshot!(fetch_fails(&home, "new.tar.gz"), @"mmsim: mazes/fetched is a link (move it away or fetch into another folder)");
    fs::remove_file(&folder).unwrap();
    let lock = home.path().join("mazes/.mmsim-fetching");
    fs::remove_file(&lock).unwrap();
    symlink(home.path().join("missing"), &lock).unwrap();
    insta::assert_snapshot!(fetch_fails(&home, "new.tar.gz"), @"mmsim: mazes/.mmsim-fetching is not a regular file (move it away or fetch into another folder)");

    // The user's folder itself may be a link.
    let home = home_with_mazes();
    fs::rename(home.path().join("mazes"), home.path().join("elsewhere")).unwrap();
    symlink("elsewhere", home.path().join("mazes")).unwrap();
    assert_eq!(fetch(&home, "old.tar.gz").code, Some(0));
    assert!(home.path().join("elsewhere/fetched/classic/old.txt").exists());
}

/// A limit on the file size simulates a full disk.
#[cfg(unix)]
#[test]
fn full_disks_change_nothing() {
    use std::process::Command;
    let home = home_with_mazes();
    let large = MAZE.to_string() + &"and more\n".repeat(1000);
    home.write("new.tar.gz", tar_gz(&[("top/classic/old.txt", OTHER_MAZE), ("top/z.txt", &large)]));
    let before = all_of(home.path());
    let limited = "trap '' XFSZ; ulimit -f 8; exec \"$0\" mazes fetch mazes --from new.tar.gz";
    let mut command = Command::new("sh");
    command.args(["-c", limited]).arg(env!("CARGO_BIN_EXE_mmsim")).current_dir(home.path());
    let output = mmsim_tests::output(&mut command);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.starts_with("mmsim: cannot write mazes/fetched"), "{error}");
    assert_eq!(all_of(home.path()), before);
}
