//! `mmsim mazes generate`: generating mazes.

mod harness;

use std::collections::HashSet;
use std::fs;

use harness::Home;
use mmsim_formats::Catalogue;
use mmsim_maze::Maze;

#[test]
fn the_same_seed_prints_the_same_maze() {
    let home = Home::new();
    let generate = ["mazes", "generate", "--size", "5x4", "--seed", "3"];
    let printed = home.run(&generate);
    assert_eq!((printed.code, &printed.stderr[..]), (Some(0), ""));
    insta::assert_snapshot!(printed.stdout, @r"
    o---o---o---o---o---o
    |                   |
    o   o---o---o---o   o
    |       | G |   |   |
    o   o   o   o   o   o
    |   |   | G |   |   |
    o   o   o   o   o   o
    | S |               |
    o---o---o---o---o---o
    ");
    assert_eq!(home.run(&generate).stdout, printed.stdout);
    let open = home.run(&[&generate[..], &["--style", "open"]].concat());
    assert_ne!(open.stdout, printed.stdout);
}

#[test]
fn a_random_seed_is_printed() {
    let home = Home::new();
    let any = home.run(&["mazes", "generate"]);
    let seed = any.stderr.strip_prefix("seed ").unwrap().split(' ').next().unwrap();
    assert_eq!(any.stdout.parse::<Maze>().unwrap().size(), mmsim_maze::MazeSize::CLASSIC);
    assert_eq!(home.run(&["mazes", "generate", "--seed", seed]).stdout, any.stdout);
    assert_ne!(home.run(&["mazes", "generate"]).stdout, any.stdout);
}

#[test]
fn several_mazes_use_the_next_seeds() {
    let home = Home::new();
    let generate = |arguments: &[&str]| {
        let ended = home.run(&[&["mazes", "generate", "--size", "6x6"], arguments].concat());
        assert_eq!(ended.code, Some(0), "{ended:?}");
        ended
    };
    let printed = generate(&["--seed", "8", "--count", "3"]).stdout;
    let single = ["8", "9", "10"].map(|seed| generate(&["--seed", seed]).stdout);
    assert_eq!(printed, single.join("\n"));
    assert!(printed.split("\n\n").all(|text| text.parse::<Maze>().is_ok()));

    let messages = generate(&["--seed", "8", "--count", "3", "-o", "new/mazes"]).stderr;
    assert_eq!(messages, "wrote 3 mazes to new/mazes; serve one with `mmsim new/mazes`\n");
    let read = |name: &str| fs::read_to_string(home.path().join("new/mazes").join(name)).unwrap();
    assert_eq!(read("contest-6x6-8.txt"), single[0]);
    assert_eq!(read("contest-6x6-10.txt"), single[2]);
    assert_eq!(Catalogue::from_path(&home.path().join("new/mazes")).unwrap().entries().len(), 3);

    let largest = u64::MAX.to_string();
    let wrapped = generate(&["--seed", &largest, "--count", "2"]).stdout;
    assert!(wrapped.ends_with(&generate(&["--seed", "0"]).stdout), "after the last seed the first");
}

#[test]
fn different_files_are_replaced_only_with_force() {
    let home = Home::new();
    let path = home.write("mine.txt", "my maze");
    let generate = ["mazes", "generate", "--size", "6x6", "--seed", "8", "-o", "mine.txt"];
    let refused = home.run(&generate);
    assert_eq!((refused.code, &refused.stdout[..]), (Some(1), ""));
    insta::assert_snapshot!(refused.stderr, @"mmsim: mine.txt already exists with different content (use --force to replace it)");
    assert_eq!(fs::read(&path).unwrap(), b"my maze");
    assert_eq!(home.run(&[&generate[..], &["--force"]].concat()).code, Some(0));
    let printed = home.run(&generate[..6]).stdout;
    assert_eq!(fs::read_to_string(&path).unwrap(), printed);
    assert_eq!(home.run(&generate).code, Some(0), "the same again is nothing else");
    let nowhere = home.run(&["mazes", "generate", "--seed", "1", "-o", "none/maze.txt"]);
    assert_eq!(nowhere.code, Some(1));
    assert!(nowhere.stderr.contains("cannot write "), "{nowhere:?}");
    let files: Vec<_> = fs::read_dir(home.path()).unwrap().collect();
    assert_eq!(files.len(), 1, "{files:?}");
}

#[test]
fn the_output_path_selects_folder_or_format() {
    let home = Home::new();
    let generate = |size, output| {
        home.run(&["mazes", "generate", "--size", size, "--seed", "8", "-o", output])
    };
    let printed = |size| home.run(&["mazes", "generate", "--size", size, "--seed", "8"]).stdout;
    let read = |name: &str| fs::read(home.path().join(name)).unwrap();
    assert_eq!(
        generate("6x6", "new/").stderr,
        "wrote 1 maze to new/; serve one with `mmsim new/`\n"
    );
    assert_eq!(read("new/contest-6x6-8.txt"), printed("6x6").as_bytes());

    assert_eq!(generate("16x16", "x.MAZ").code, Some(0));
    assert_eq!(read("x.MAZ").len(), 256);
    assert_eq!(home.run(&["mazes", "convert", "x.MAZ", "-"]).stdout, printed("16x16"));
    assert_eq!(generate("16x16", "x.MAZ").code, Some(0), "the same again is nothing else");
    let refused = generate("5x4", "small.maz");
    assert_eq!(refused.code, Some(1));
    insta::assert_snapshot!(refused.stderr, @"mmsim: cannot write small.maz: the format maz requires a 16x16 or 32x32 maze, but the maze is 5x4");
    for other in ["maze", "maze.csv"] {
        assert_eq!(generate("5x4", other).code, Some(0));
        assert_eq!(read(other), printed("5x4").as_bytes());
    }
    assert_eq!(fs::read_dir(home.path()).unwrap().count(), 4);
}

/// Writing to a device is safe without `--force`, because a device has no content that could be
/// lost.
#[cfg(unix)]
#[test]
fn devices_are_written_to_without_force() {
    let home = Home::new();
    let generate = ["mazes", "generate", "--size", "5x4", "--seed", "3"];
    std::os::unix::fs::symlink("/dev/stdout", home.path().join("out")).unwrap();
    let out = home.run(&[&generate[..], &["-o", "out"]].concat());
    assert_eq!((out.code, out.stdout), (Some(0), home.run(&generate).stdout));
}

#[test]
fn json_has_an_object_for_each_maze() {
    let home = Home::new();
    let generate = ["mazes", "generate", "--size", "3x2", "--seed", "7", "--style", "perfect"];
    let json = home.run(&[&generate[..], &["--count", "20", "--json"]].concat()).json();
    let mazes = json.as_array().unwrap();
    assert_eq!(mazes.len(), 20);
    let first = &mazes[0];
    assert_eq!(first["drawing"], home.run(&generate).stdout);
    assert_eq!((&first["seed"], &first["style"]), (&7.into(), &"perfect".into()));
    assert_eq!((&first["width"], &first["height"]), (&3.into(), &2.into()));
    assert_eq!(first["goals"], serde_json::json!([[1, 0], [1, 1]]));
    let different: HashSet<_> = mazes.iter().map(|maze| maze["drawing"].to_string()).collect();
    assert_eq!(different.len(), 3, "every maze of this size: {different:?}");
    assert!(mazes.iter().all(|maze| maze["shortest_path"].as_u64() >= Some(2)), "{json}");
}

#[test]
fn usage_errors_name_what_is_expected() {
    let home = Home::new();
    for (arguments, expected) in [
        (["--size", "33x1"], "expected a maze of 1x1 to 32x32 cells, found 33x1"),
        (["--style", "hard"], "[possible values: contest, perfect, open]"),
        (["--count", "0"], "0 is not in 1.."),
        (["--seed", "-1"], "'-1'"),
    ] {
        let ended = home.run(&[&["mazes", "generate"], &arguments[..]].concat());
        assert_eq!(ended.code, Some(2), "{ended:?}");
        assert!(ended.stderr.contains(expected), "{ended:?}");
    }
}
