//! `mmsim export`: writing recordings as HTML files and as packed recordings.

mod harness;

use std::fs;

use harness::{Home, recorded};

const MAZE: &str = "o---o---o---o\n|     G |   |\no   o---o   o\n| S |       |\no---o---o---o\n";

/// Returns a home folder with the recording `run.mcap` of a search.
fn home() -> Home {
    let home = Home::new();
    home.write("small.txt", MAZE);
    let demo = ["demo", "small.txt", "--once", "--port", "0", "--no-viewer", "--record", "kept"];
    assert_eq!(home.run(&demo).code, Some(0));
    fs::rename(recorded(&home.path().join("kept")), home.path().join("run.mcap")).unwrap();
    home
}

fn read(home: &Home, name: &str) -> String {
    fs::read_to_string(home.path().join(name)).unwrap()
}

#[test]
fn a_recording_is_exported() {
    let home = home();
    home.write("run.html", "old");
    let ended = home.run(&["export", "run.mcap", "-o", "run.html"]);
    assert_eq!((ended.code, &ended.stdout[..], &ended.stderr[..]), (Some(0), "", ""));
    let page = read(&home, "run.html");
    assert!(page.starts_with("<!doctype html>") && page.ends_with("</html>\n"));
    assert!(page.contains("<title>run.mcap: small, mmsim – mmsim</title>"));
    let printed = home.run(&["export", "run.mcap", "-o", "-"]);
    assert_eq!((printed.code, printed.stdout == page), (Some(0), true), "{}", printed.stderr);
}

#[test]
fn the_intact_part_of_a_recording_is_exported() {
    let home = home();
    let bytes = fs::read(home.path().join("run.mcap")).unwrap();
    home.write("cut.mcap", &bytes[..bytes.len() - 100]);
    let ended = home.run(&["export", "cut.mcap", "-o", "cut.html"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    assert!(read(&home, "cut.html").ends_with("</html>\n"));

    let mut damaged = bytes;
    let end = damaged.len() - 60;
    damaged[end..].fill(0xff);
    home.write("damaged.mcap", damaged);
    let ended = home.run(&["export", "damaged.mcap", "-o", "damaged.html"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.contains("damaged.mcap: damaged after byte "), "{ended:?}");
    assert!(read(&home, "damaged.html").ends_with("</html>\n"));
}

#[test]
fn errors_keep_the_old_file() {
    let home = home();
    home.write("old.html", "old");
    home.write("rubbish.mcap", "rubbish");
    for (arguments, code, error) in [
        (["no.mcap", "-o", "old.html"], 1, "mmsim: no such file or folder: no.mcap\n"),
        (["rubbish.mcap", "-o", "old.html"], 1, "mmsim: rubbish.mcap: "),
        (
            ["small.txt", "-o", "old.html"],
            1,
            "mmsim: small.txt: an .html file needs a recording, not a maze\n",
        ),
        (["run.mcap", "-o", "no/a.html"], 1, "mmsim: cannot write no/a.html: "),
        (
            ["run.mcap", "-o", "run.jpg"],
            2,
            "ending in .svg, .png, .gif, .html or .mcap, found .jpg",
        ),
        (["run.mcap", "--history-limit", "0"], 2, "0 is not in 1.."),
    ] {
        let ended = home.run(&[&["export"], &arguments[..]].concat());
        assert_eq!(ended.code, Some(code), "{arguments:?}");
        assert!(ended.stderr.contains(error), "{arguments:?}: {}", ended.stderr);
    }
    for (arguments, error) in [
        (["-o", "old.html", "--states-only"], "--states-only needs an .mcap file"),
        (["-o", "a.mcap", "--vehicle=expert"], "--vehicle needs an .html file"),
    ] {
        let ended = home.run(&[&["export", "run.mcap"], &arguments[..]].concat());
        assert_eq!(ended.code, Some(2));
        assert!(ended.stderr.contains(error), "{}", ended.stderr);
    }
    assert_eq!(home.run(&["export", "run.mcap"]).code, Some(2));
    assert_eq!(read(&home, "old.html"), "old");
}
