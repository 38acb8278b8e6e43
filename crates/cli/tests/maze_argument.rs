//! The argument MAZE, which has one grammar in all commands.

mod harness;

use harness::{Home, Output, commands, help, recorded};

const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";

/// The words of a command before and after MAZE. `run` and the commands for several mazes take the words
/// of a maze as one argument.
const COMMANDS: [(&[&str], &[&str]); 13] = [
    (&["demo"], &["--once", "--port", "0", "--no-viewer"]),
    (&["export"], &["-o", "maze.svg"]),
    (&["mazes", "show"], &[]),
    (&["mazes", "list"], &[]),
    (&["fast-run"], &[]),
    (&["compare"], &["--strategies", "flood-fill"]),
    (&["contest"], &["--strategies", "flood-fill"]),
    (&["trial"], &["--robot", "random"]),
    (&["mazes", "check"], &[]),
    (&["mazes", "convert"], &["-"]),
    (&["mazes", "diff"], &["small.txt"]),
    (&["mazes", "diff", "small.txt"], &[]),
    (&["run", "--port", "0", "--no-viewer", "--maze"], &["--", "mmsim-no-such-mouse"]),
];

/// The commands in which all words after the options are one MAZE.
const TAKE_WORDS: [&str; 4] = ["demo", "export", "show", "list"];

fn home() -> Home {
    let home = Home::new();
    home.write("small.txt", MAZE);
    home.write("my-mazes/closed.txt", MAZE.replace("S  ", "S |"));
    home.write("my-mazes/open.txt", MAZE);
    home.write("my-mouse", b"\x7fELF\x02\x01\x01\0\xff");
    home.write("empty/README", "about");
    let demo = ["demo", "small.txt", "--once", "--port", "0", "--no-viewer", "--record", "kept"];
    assert_eq!(home.run(&demo).code, Some(0));
    std::fs::rename(recorded(&home.path().join("kept")), home.path().join("run.mcap")).unwrap();
    home
}

/// Runs each command with MAZE and checks what it prints.
fn for_each_command(home: &Home, maze: &[&str], check: impl Fn(&[&str], &Output, String)) {
    let joined = maze.join(" ");
    for (before, after) in COMMANDS {
        let takes_words = TAKE_WORDS.contains(before.last().unwrap());
        let maze = if takes_words { maze } else { &[&joined[..]] };
        let arguments = [before, maze, after].concat();
        let ended = home.run(&arguments);
        check(before, &ended, format!("{arguments:?}: {}{}", ended.stdout, ended.stderr));
    }
}

#[test]
fn every_command_with_a_maze_is_tested() {
    let home = Home::new();
    let takes_maze = |command: &String| {
        let help = help(&home, command);
        help.lines().any(|line| line.contains("MAZE") || line.contains("words from"))
    };
    let found: Vec<String> = commands(&home).into_iter().filter(takes_maze).collect();
    for command in &found {
        let words: Vec<&str> = command.split(' ').collect();
        assert!(COMMANDS.iter().any(|(before, _)| before.starts_with(&words)), "{command}");
    }
    assert!(found.len() >= 11, "{found:?}");
}

#[test]
fn a_maze_is_a_file_a_folder_or_words() {
    let home = home();
    for maze in [&["small.txt"][..], &["my-mazes"], &["winding", "river"], &["my-mazes/", "open"]] {
        for_each_command(&home, maze, |command, ended, shown| {
            if maze == ["my-mazes"] && command == ["mazes", "convert"] {
                assert!(shown.contains("my-mazes is a folder, not a maze"), "{shown}");
                return;
            }
            let errors = ended.stderr.lines().filter(|line| line.starts_with("mmsim: "));
            let errors: Vec<_> = errors.filter(|line| !line.contains("no-such-mouse")).collect();
            assert!(errors.is_empty() && ended.code != Some(2), "{shown}");
        });
    }
    let servers = [
        (&["small.txt"][..], "small.txt"),
        (&["my-mazes"], "open.txt"),
        (&["winding", "river"], "winding-river.txt"),
        (&["my-mazes/", "clo"], "closed.txt"),
    ];
    for (maze, file) in servers {
        let server = home.serve(&[maze, &["--port", "0"]].concat());
        assert!(server.messages.contains(file), "{}", server.messages);
    }
}

#[test]
fn words_without_quotes_name_one_of_several_mazes() {
    let home = home();
    let rows = |arguments: &[&str]| {
        let ended = home.run(&[&["fast-run", "--json"], arguments].concat());
        ended.json().as_array().unwrap().len()
    };
    assert_eq!(rows(&["winding", "river"]), 1);
    assert_eq!(rows(&["harbour", "hedgerow"]), 2);
    assert_eq!(rows(&["my-mazes/open.txt", "small.txt", "harbour"]), 3);
}

#[test]
fn every_command_reports_a_wrong_maze_in_the_same_words() {
    let home = home();
    for (maze, error) in [
        (
            &["harbuor"][..],
            "no maze matches \"harbuor\" in the bundled mazes (did you mean harbour?)",
        ),
        (&["winding", "rivr"], "(did you mean winding river?)"),
        (&["my-mazes", "opne"], "no maze matches \"opne\" in my-mazes (did you mean open?)"),
        (&["zzzz"], "in the bundled mazes (list the 19 files with `mmsim mazes list`)"),
        (&["no/"], "no such file or folder: no/\n"),
        (&["no/", "apec", "2018"], "no such file or folder: no/\n"),
        (&["no.txt"], "no such file or folder: no.txt\n"),
        (&["~/mazes"], "no such file or folder: ~/mazes\n"),
        (&["small.txt", "open"], "small.txt is a file, so \"open\" cannot follow it"),
        (&["empty"], "no mazes in empty\n"),
    ] {
        for_each_command(&home, maze, |command, ended, shown| {
            if maze == ["empty"] && command == ["mazes", "convert"] {
                return;
            }
            assert!(shown.contains(error) && ended.code == Some(1), "{error}: {shown}");
        });
        let server = home.run(&[maze, &["--port", "0"]].concat());
        let is_command = server.stderr.starts_with("mmsim: no such command or maze: ");
        assert!(is_command || server.stderr.contains(error), "{server:?}");
    }
    home.write("mouse.py", "print('mazeWidth')\n");
    for program in ["my-mouse", "mouse.py"] {
        for_each_command(&home, &[program], |_, ended, shown| {
            let run = format!("(run it as a mouse with `mmsim run {program}`)");
            let error = format!("{program} is a program, not a maze {run}");
            assert!(shown.contains(&error) && ended.code == Some(1), "{shown}");
        });
    }
    for_each_command(&home, &["run.mcap"], |command, _, shown| {
        let error = "run.mcap is a recording, not a maze (view it with `mmsim replay run.mcap`)";
        let takes_recordings = [["export"], ["fast-run"]].iter().any(|name| command == name);
        assert!(takes_recordings || shown.contains(error), "{shown}");
    });
    for maze in ["small.txt", "harbour"] {
        let hint = format!("(show it with `mmsim mazes show {maze}`)");
        let error = format!("mmsim: {maze} is a maze, not a recording {hint}\n");
        assert_eq!(home.run(&["replay", maze]).stderr, error);
    }
    assert_eq!(home.run(&["replay", "no.mcap"]).stderr, "mmsim: no such file: no.mcap\n");
    let error = "mmsim: empty is a folder (name a recording in it)\n";
    assert_eq!(home.run(&["replay", "empty"]).stderr, error);
}

#[test]
fn the_server_suggests_commands_and_mazes() {
    let home = home();
    for (code, words, hint) in [
        (1, &["harbuor"][..], "no such command or maze: \"harbuor\" (did you mean harbour?)"),
        (1, &["winding", "rivr"], "\"winding rivr\" (did you mean winding river?)"),
        (2, &["demoo"], "no such command or maze: \"demoo\" (did you mean `mmsim demo …`?)"),
        (2, &["demoo", "harbour", "--once"], "maze: \"demoo\" (did you mean `mmsim demo …`?)"),
        (1, &["nosuch"], "maze: \"nosuch\" (list the 19 files with `mmsim mazes list`)"),
        (2, &["harbour", "--nosuch"], "unexpected argument '--nosuch'"),
    ] {
        let ended = home.run(words);
        assert!(ended.code == Some(code) && ended.stderr.contains(hint), "{words:?}: {ended:?}");
    }
}
