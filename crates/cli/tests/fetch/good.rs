//! Valid archives.

use std::fs;
use std::path::Path;
use std::thread;

use serde_json::json;

use tar::EntryType;

use crate::archives::{Zipped, gz, tar, tar_entry, tar_gz, zip, zip_of};
use crate::harness::{Home, Output};
use crate::server::{answer, serve, serve_content};
use crate::{MAZE, OTHER_MAZE, fetch};

const CONTENTS: &[(&str, &str)] = &[
    ("top/README.md", "whose mazes they are"),
    ("top/LICENCE", "none"),
    ("top/.github/workflow.txt", MAZE),
    ("top/classic/japan2013.txt", MAZE),
    ("top/classic/deep/er/a b (c).maz", OTHER_MAZE),
    ("top/tool.py", "print()"),
];

/// Asserts that only the README, the licence and the mazes outside hidden folders were fetched from
/// `CONTENTS`.
fn assert_is_fetched(home: &Home, folder: &str) {
    let read = |name: &str| {
        fs::read_to_string(home.path().join(folder).join("fetched").join(name)).unwrap()
    };
    assert_eq!(read("classic/japan2013.txt"), MAZE);
    assert_eq!(read("classic/deep/er/a b (c).maz"), OTHER_MAZE);
    assert_eq!(read("README.md"), "whose mazes they are");
    assert_eq!(read("LICENCE"), "none");
    let names = fs::read_dir(home.path().join(folder).join("fetched")).unwrap();
    let mut names: Vec<_> = names.map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    let expected = [".mmsim-fetched", "LICENCE", "README.md", "classic"];
    assert_eq!(names, expected);
}

#[test]
fn fetches_every_kind_of_archive_from_files_and_urls() {
    let stored = Zipped { method: 0, data: MAZE.into(), ..Zipped::new(b"a.txt", MAZE.as_bytes()) };
    for archive in [tar_gz(CONTENTS), zip(CONTENTS), tar(CONTENTS)] {
        let home = Home::new();
        let file = home.write("archive", &archive);
        let by_file = fetch(&home, file.to_str().unwrap());
        assert_eq!((by_file.code, &by_file.stderr[..]), (Some(0), ""));
        assert_is_fetched(&home, "mazes");
        let from = format!("http://{}/archive", serve_content(&archive));
        let by_address = home.run(&["mazes", "fetch", "new/folder", "--from", &from]);
        assert_eq!((by_address.code, &by_address.stderr[..]), (Some(0), ""), "no bar");
        assert_is_fetched(&home, "new/folder");
        let other = by_address.stdout.replace("new/folder", "mazes");
        assert_eq!(other, by_file.stdout);
        insta::allow_duplicates! {
            insta::assert_snapshot!(by_file.stdout, @r#"
            2 mazes in mazes/fetched (files: 4 new, 0 replaced, 0 unchanged, 0 removed, 2 skipped)
            serve a maze with `mmsim mazes/ "a b (c)"`
            "#);
        }
    }
    let home = Home::new();
    let file = home.write("stored.zip", zip_of(&[stored]));
    assert_eq!(fetch(&home, file.to_str().unwrap()).code, Some(0));
    assert_eq!(fs::read_to_string(home.path().join("mazes/fetched/a.txt")).unwrap(), MAZE);
}

#[test]
fn default_folder_is_searched_for_mazes() {
    let home = Home::new();
    let from = home.write("a.tar.gz", tar_gz(&[("one.txt", MAZE), ("two/three.txt", MAZE)]));
    let fetched = home.run(&["mazes", "fetch", "--from", from.to_str().unwrap()]);
    assert_eq!(fetched.code, Some(0), "{fetched:?}");
    assert!(fetched.stdout.contains("serve a maze with `mmsim \"one\"`"), "{fetched:?}");
    let list = home.run(&["mazes", "list", "--json"]).json();
    assert_eq!(list.as_array().unwrap().len(), 2);
    assert!(list[0]["path"].as_str().unwrap().contains(".mmsim"), "{list}");
    assert_eq!(home.run(&["mazes", "show", "three"]).code, Some(0));
    let checked = home.run(&["mazes", "check", ".mmsim"]);
    assert_eq!(checked.code, Some(0), "{checked:?}");
}

#[test]
fn follows_redirects_and_accepts_unknown_lengths() {
    let archive = tar_gz(CONTENTS);
    let there = serve([b"HTTP/1.0 200 OK\r\n\r\n", &archive[..]].concat());
    let head = format!("302 Found\r\nLocation: http://{there}/elsewhere");
    let here = serve(answer(&head, 0, b""));
    let home = Home::new();
    let output = fetch(&home, &format!("http://{here}/"));
    assert_eq!((output.code, &output.stderr[..]), (Some(0), ""));
    assert_is_fetched(&home, "mazes");
}

#[test]
fn tar_gz_may_have_several_members_and_long_names() {
    let tar = tar(CONTENTS);
    let (one, other) = tar.split_at(700);
    let home = Home::new();
    let from = home.write("parts.tar.gz", [gz(one), gz(other)].concat());
    assert_eq!(fetch(&home, from.to_str().unwrap()).code, Some(0));
    assert_is_fetched(&home, "mazes");

    let mut long = tar::Builder::new(Vec::new());
    let name = format!("top/{}/{}.txt", "a".repeat(90), "b".repeat(60));
    let mut header = tar::Header::new_gnu();
    header.set_size(MAZE.len() as u64);
    long.append_data(&mut header, &name, MAZE.as_bytes()).unwrap();
    let from = home.write("long.tar.gz", gz(&long.into_inner().unwrap()));
    assert_eq!(fetch(&home, from.to_str().unwrap()).code, Some(0));
    assert!(home.path().join("mazes/fetched").join(&name[4..]).is_file());
}

/// Zeros after the compressed data are ignored, as in GNU gzip.
#[test]
fn zeros_after_a_tar_gz_are_ignored() {
    let home = Home::new();
    let padded = [tar_gz(CONTENTS), vec![0; 10_000]].concat();
    home.write("padded.tar.gz", &padded);
    assert_eq!(fetch(&home, "padded.tar.gz").code, Some(0));
    assert_is_fetched(&home, "mazes");
    let more = [padded, b"x".into()].concat();
    home.write("more.tar.gz", more);
    assert_eq!(fetch(&home, "more.tar.gz").code, Some(1));
}

#[test]
fn schemes_ignore_case_and_file_urls_work() {
    let home = Home::new();
    let archive = tar_gz(CONTENTS);
    let file = home.write("a b.tar.gz", &archive);
    let file = file.display().to_string().replace('\\', "/").replace(' ', "%20");
    let file = file.trim_start_matches('/');
    let address = serve_content(&archive);
    for from in [
        format!("HTTP://{address}/"),
        format!("file:///{file}"),
        format!("File://localhost/{file}"),
    ] {
        let output = home.run(&["mazes", "fetch", "mazes", "--from", &from]);
        assert_eq!(output.code, Some(0), "{output:?}");
        assert_is_fetched(&home, "mazes");
        std::fs::remove_dir_all(home.path().join("mazes")).unwrap();
    }
}

/// Hidden files, such as macOS metadata, must not prevent the detection of a common top folder.
#[test]
fn hidden_files_are_skipped_first() {
    let mac = [
        ("__MACOSX/._mazes", "of the system"),
        ("__MACOSX/mazes/b.maze", MAZE),
        ("__MACOSX/mazes/._a.txt", MAZE),
        (".DS_Store", "of the system"),
        ("mazes/.DS_Store", "of the system"),
        ("mazes/classic/a.txt", MAZE),
    ];
    let packed_home = [
        (".mmsim/.mmsim-fetched", ""),
        (".mmsim/.trash/b.txt", MAZE),
        (".mmsim/classic/a.txt", MAZE),
    ];
    for (archive, skipped) in [(zip(&mac), 5), (zip(&packed_home), 2)] {
        let home = Home::new();
        home.write("a.zip", archive);
        let output = fetch(&home, "a.zip");
        let expected = format!(
            "1 maze in mazes/fetched (files: 1 new, 0 replaced, 0 unchanged, 0 removed, {skipped} skipped)"
        );
        assert_eq!(output.stdout.lines().next(), Some(&expected[..]), "{output:?}");
        assert_eq!(
            fs::read_to_string(home.path().join("mazes/fetched/classic/a.txt")).unwrap(),
            MAZE
        );
        assert_eq!(fs::read_dir(home.path().join("mazes/fetched")).unwrap().count(), 2);
    }
}

#[test]
fn unportable_names_are_skipped() {
    let long = "a".repeat(90) + "/" + &"b".repeat(120);
    let odd: [&[u8]; 8] = [
        b"top/12:30.txt",
        b"top/a\"b.txt",
        b"top/b?.txt",
        b"top/caf\x82.txt",
        b"top/nul.txt",
        b"top/\x1b[2J.txt",
        b"top/dot.",
        long.as_bytes(),
    ];
    let names = [&[&b"top/classic/good.txt"[..]], &odd[..]].concat();
    let zipped: Vec<_> = names.iter().map(|name| Zipped::new(name, MAZE.as_bytes())).collect();
    let kind = EntryType::Regular;
    // In a tar archive, such a long name needs a separate entry.
    let mut tar: Vec<u8> =
        names[..8].iter().flat_map(|name| tar_entry(name, kind, MAZE.as_bytes())).collect();
    tar.extend([0; 1024]);
    for (archive, skipped) in [(zip_of(&zipped), 8), (gz(&tar), 7)] {
        let home = Home::new();
        home.write("archive", archive);
        let output = fetch(&home, "archive");
        let expected = format!(
            "1 maze in mazes/fetched (files: 1 new, 0 replaced, 0 unchanged, 0 removed, {skipped} skipped)"
        );
        assert_eq!(output.stdout.lines().next(), Some(&expected[..]), "{output:?}");
        let messages = format!(
            "skipped {skipped} files with names that are not valid on every system: \"top/12:30.txt\", \"top/a\\\"b.txt\", \"top/b?.txt\", …\n"
        );
        assert_eq!(output.stderr, messages);
        assert_eq!(
            fs::read_to_string(home.path().join("mazes/fetched/classic/good.txt")).unwrap(),
            MAZE
        );
        assert_eq!(fs::read_dir(home.path().join("mazes/fetched")).unwrap().count(), 2);
    }
}

/// Some Windows tools create zip archives that separate the parts of a path with backslashes and
/// have an entry for each folder.
#[test]
fn backslashes_in_a_zip_are_separators() {
    let home = Home::new();
    home.write("a.zip", zip(&[("top\\classic\\", ""), ("top\\classic\\a.txt", MAZE)]));
    let output = fetch(&home, "a.zip");
    assert_eq!((output.code, &output.stderr[..]), (Some(0), ""));
    assert_eq!(fs::read_to_string(home.path().join("mazes/fetched/classic/a.txt")).unwrap(), MAZE);
}

#[test]
fn json_has_all_results() {
    let home = Home::new();
    let from = home.write("a.zip", zip(CONTENTS));
    let from = from.to_str().unwrap();
    let json = home.run(&["mazes", "fetch", "mazes", "--json", "--from", from]).json();
    let folder = Path::new("mazes").join("fetched");
    let expected = json!({
        "from": from, "folder": folder, "maze_count": 2, "new": 4, "replaced": 0, "unchanged": 0,
        "removed": 0, "kept": [], "skipped": 2,
    });
    assert_eq!(json, expected);
}

#[test]
fn concurrent_fetches_leave_a_complete_collection() {
    let home = Home::new();
    let names: Vec<String> = (0..50).map(|number| format!("top/{number}.txt")).collect();
    let contents = |maze| names.iter().map(|name| (&name[..], maze)).collect::<Vec<_>>();
    let one = home.write("one.tar.gz", tar_gz(&contents(MAZE)));
    let other = home.write("other.zip", zip(&contents(OTHER_MAZE)));
    thread::scope(|scope| {
        for from in [&one, &other, &one, &other] {
            scope.spawn(|| assert_eq!(fetch(&home, from.to_str().unwrap()).code, Some(0)));
        }
    });
    let again = fetch(&home, one.to_str().unwrap());
    assert_eq!(
        (again.code, &again.stderr[..]),
        (Some(0), ""),
        "no file counts as changed by the user"
    );
    let read =
        |number: u32| fs::read_to_string(home.path().join(format!("mazes/fetched/{number}.txt")));
    assert!((0..50).all(|number| read(number).unwrap() == MAZE));
    assert_eq!(fs::read_dir(home.path().join("mazes/fetched")).unwrap().count(), 51);
}

#[test]
fn collections_are_fetched_by_name() {
    let home = Home::new();
    for (name, repository) in [
        (None, "micromouseonline/mazefiles"),
        (Some("mazefiles"), "micromouseonline/mazefiles"),
        (Some("maze-data"), "kerikun11/micromouse-maze-data"),
        (Some("maze-tool"), "micromouseonline/micromouse_maze_tool"),
    ] {
        let from = name.map_or(vec![], |name| vec!["--from", name]);
        let mut command = home.command(&[&["mazes", "fetch", "mazes"], &from[..]].concat());
        // No proxy answers, so nothing is downloaded.
        let ended = Output::new(command.env("HTTPS_PROXY", "http://127.0.0.1:1"));
        assert_eq!(ended.code, Some(1));
        let address = format!("https://github.com/{repository}/archive/HEAD.tar.gz");
        assert!(ended.stderr.contains(&format!("cannot download {address}: ")), "{ended:?}");
    }
}

#[test]
fn the_bundled_mazes_are_written_without_a_download() {
    let home = Home::new();
    let ended = home.run(&["mazes", "fetch", "--from", "bundled", "--json"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    assert_eq!((&ended.json()["maze_count"], &ended.json()["new"]), (&19.into(), &19.into()));
    let folder = home.path().join(".mmsim/fetched/mmsim");
    let trial = std::fs::read_to_string(folder.join("trial-12-orchard.txt")).unwrap();
    assert!(trial.starts_with("12\n1,"), "{trial}");
    let text = std::fs::read_to_string(folder.join("01-harbour.txt")).unwrap();
    assert!(text.starts_with("o---o"), "{text}");
    let listed = home.run(&["mazes", "list", "--json"]).json();
    assert_eq!(listed.as_array().unwrap().len(), 19);
}
