//! `mmsim mazes convert`.

mod harness;

use std::fs;
use std::io::Write;
use std::process::Stdio;

use harness::Home;
use mmsim_tests::wait_with_output;
#[cfg(unix)]
use mmsim_tests::{output, within};
use serde_json::json;

/// A 2x2 maze, in which all cells are goal cells.
const SMALL: &str = "o---o---o\n| G   G |\no   o---o\n|SG   G |\no---o---o\n";
const NUM: &str = "0 0 0 0 1 1\n0 1 1 0 0 1\n1 0 1 1 1 0\n1 1 1 1 1 0\n";
const TRIAL: &str = "2\n3,6\n8,8\n";

#[test]
fn the_extension_selects_the_format() {
    let home = Home::new();
    home.write("small.txt", SMALL);
    for (ending, content) in [("num", NUM), ("NUM", NUM), ("trial", TRIAL)] {
        let out = format!("out.{ending}");
        let ended = home.run(&["mazes", "convert", "small.txt", &out]);
        assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
        assert_eq!(fs::read_to_string(home.path().join(&out)).unwrap(), content);
        let back = home.run(&["mazes", "convert", &out, "-"]);
        assert_eq!(back.stdout, SMALL);
    }
    let forced = home.run(&["mazes", "convert", "small.txt", "-", "--to", "num"]);
    assert_eq!(forced.stdout, NUM);
    let unknown = home.run(&["mazes", "convert", "small.txt", "out.csv"]);
    assert_eq!(unknown.code, Some(2));
    assert!(unknown.stderr.starts_with(
        "error: unknown format of out.csv (use .txt, .trial, .maz or .num, or --to FORMAT)\n"
    ));
}

#[test]
fn mazes_are_converted_through_pipes() {
    let home = Home::new();
    let maze = mmsim_mazes::HARBOUR.as_bytes();
    let pipe = |arguments: &[&str], input: &[u8]| {
        let mut command = home.command(arguments);
        let pipes = command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = pipes.spawn().unwrap();
        child.stdin.take().unwrap().write_all(input).unwrap();
        let output = wait_with_output(child);
        assert!(output.status.success());
        output.stdout
    };
    let maz = pipe(&["mazes", "convert", "-", "-", "--to", "maz"], maze);
    assert_eq!((maz.len(), maz[0]), (256, 14));
    assert_eq!(pipe(&["mazes", "convert", "-", "-"], &maz), maze);
}

#[test]
fn unsupported_content_is_refused_and_the_old_file_is_kept() {
    let home = Home::new();
    home.write("marked.txt", SMALL.replace("|SG   G |", "| S     |"));
    home.write("out.num", "old");
    home.write("out.maz", "old");
    let old = |name: &str| fs::read_to_string(home.path().join(name)).unwrap();
    let ended = home.run(&["mazes", "convert", "marked.txt", "out.num"]);
    assert_eq!((ended.code, &old("out.num")[..]), (Some(1), "old"));
    insta::assert_snapshot!(ended.stderr, @"mmsim: cannot write out.num: the format num requires the central cells as the goal, but the goal is (0, 1) (1, 1) (use --lossy to omit it)");
    let size = home.run(&["mazes", "convert", "marked.txt", "out.maz", "--lossy"]);
    assert_eq!((size.code, &old("out.maz")[..]), (Some(1), "old"));
    insta::assert_snapshot!(size.stderr, @"mmsim: cannot write out.maz: the format maz requires a 16x16 or 32x32 maze, but the maze is 2x2");
    let lossy = home.run(&["mazes", "convert", "marked.txt", "out.num", "--lossy"]);
    assert_eq!((lossy.code, &old("out.num")[..]), (Some(0), NUM));
    insta::assert_snapshot!(lossy.stderr, @"omitted: goal (0, 1) (1, 1), which will be read as (0, 0) (1, 0) (0, 1) (1, 1)");
    let files = fs::read_dir(home.path()).unwrap().count();
    assert_eq!(files, 3, "no other files remain");
}

#[test]
fn assumptions_about_the_input_are_reported() {
    let home = Home::new();
    home.write("dot.maze", SMALL.replace("|SG   ", "|SG . "));
    home.write("bad.txt", "o---o\n| S |\no-- o\n");
    let unknown = home.run(&["mazes", "convert", "dot.maze", "-"]);
    assert_eq!((unknown.code, &unknown.stdout[..]), (Some(0), SMALL));
    assert_eq!(unknown.stderr, "dot.maze: 1 unknown wall read as open\n");
    let errors = |input: &str| home.run(&["mazes", "convert", input, "out.num"]).stderr;
    insta::assert_snapshot!(errors("bad.txt"), @r#"mmsim: bad.txt: line 3, column 2: expected a wall or blanks, found "-- ""#);
    insta::assert_snapshot!(errors("."), @"mmsim: . is a folder, not a maze (add words of its path)");
    assert!(errors("missing.txt").starts_with("mmsim: no such file or folder: missing.txt\n"));
}

#[test]
fn every_reading_of_an_ambiguous_file_can_be_written() {
    let home = Home::new();
    home.write("rows.txt", "bf\nab\nee\n");
    let commands: [&[&str]; 5] = [
        &["rows.txt"],
        &["mazes", "show", "rows.txt"],
        &["mazes", "convert", "rows.txt", "-", "--quiet"],
        &["compare", "rows.txt"],
        &["fast-run", "rows.txt"],
    ];
    let refused = commands.map(|command| {
        let ended = home.run(command);
        assert_eq!((ended.code, &ended.stdout[..]), (Some(1), ""), "{command:?}");
        ended.stderr
    });
    assert!(refused.iter().all(|message| *message == refused[0]), "{refused:?}");
    insta::assert_snapshot!(refused[0], @r"
    mmsim: rows.txt: line 1, column 1: expected numbers that fit one maze, found numbers that fit 3 mazes (use --bits and --rows)
    --bits N1E2S4W8 --rows north
    o---o---o
    |   |   |
    o   o---o
    | G | G |
    o   o   o
    | S |   |
    o---o---o
    --bits N1E2S4W8 --rows north-east
    o---o---o
    |   |   |
    o---o   o
    | G | G |
    o   o   o
    | S |   |
    o---o---o
    --bits N4E2S1W8 --rows south
    o---o---o
    |   |   |
    o   o   o
    | G | G |
    o   o---o
    | S |   |
    o---o---o
    write the right maze with `mmsim mazes convert FILE OUT.txt --bits ... --rows ...`
    ");
    let checked = home.run(&["mazes", "check", "rows.txt"]);
    assert_eq!((checked.code, format!("mmsim: {}", checked.stdout)), (Some(1), refused[0].clone()));
    let checked = home.run(&["mazes", "check", "rows.txt", "--json"]).json();
    let finding = &checked[0]["findings"][0];
    assert_eq!((&finding["kind"], &finding["severity"]), (&json!("ambiguous"), &json!("error")));
    let readings = finding["readings"].as_array().unwrap();
    assert_eq!(readings.len(), 3);
    for reading in readings {
        let [bits, rows, maze] =
            ["bits", "rows", "drawing"].map(|key| reading[key].as_str().unwrap());
        let options = ["--bits", bits, "--rows", rows];
        let written = home.run(&[&["mazes", "convert", "rows.txt", "-"][..], &options].concat());
        assert_eq!((written.code, &written.stdout[..]), (Some(0), maze));
        assert!(refused[0].contains(&format!("\n{}\n{maze}", options.join(" "))), "{refused:?}");
        for words in [&["rows.txt"][..], &[".", "rows"]] {
            let show = [&["mazes", "show", "--json"], words, &options].concat();
            assert_eq!(home.run(&show).json()["drawing"], maze);
        }
        let checked = home.run(&[&["mazes", "check", "rows.txt"][..], &options].concat());
        assert_eq!(checked.code, Some(0));
    }
}

/// Checks that the command writes to pipes and devices directly, and that it replaces the target of
/// a link instead of the link.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_not_replaced() {
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    use std::process::Command;
    use std::thread;
    let home = Home::new();
    home.write("small.txt", SMALL);
    let path = |name: &str| home.path().join(name);
    let convert = |output: &str| {
        let ended = home.run(&["mazes", "convert", "small.txt", output, "--to", "num"]);
        assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
        ended.stdout
    };

    assert!(output(Command::new("mkfifo").arg(path("pipe"))).status.success());
    let pipe = path("pipe");
    let reader = thread::spawn(move || fs::read_to_string(pipe).unwrap());
    convert("pipe");
    assert!(fs::metadata(path("pipe")).unwrap().file_type().is_fifo());
    assert_eq!(within("the end of the pipe", || reader.join()).unwrap(), NUM);
    symlink("/dev/stdout", path("out")).unwrap();
    assert_eq!(convert("out"), NUM);
    let folder = home.run(&["mazes", "convert", "small.txt", ".", "--to", "num"]);
    assert_eq!(folder.code, Some(1));
    assert!(folder.stderr.starts_with("mmsim: cannot write .: "), "{folder:?}");

    home.write("folder/target.num", "old");
    fs::set_permissions(path("folder/target.num"), PermissionsExt::from_mode(0o640)).unwrap();
    symlink("folder/target.num", path("link")).unwrap();
    symlink("folder/missing.num", path("dangling")).unwrap();
    for (link, target) in [("link", "folder/target.num"), ("dangling", "folder/missing.num")] {
        convert(link);
        assert!(path(link).is_symlink());
        assert_eq!(fs::read_to_string(path(target)).unwrap(), NUM);
    }
    let mode = fs::metadata(path("folder/target.num")).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
    assert_eq!(fs::read_dir(home.path()).unwrap().count(), 6, "no other files remain");
    assert_eq!(fs::read_dir(path("folder")).unwrap().count(), 2);
}
