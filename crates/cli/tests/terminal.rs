//! Tests how commands use a terminal: columns of tables, colours and progress bars.

mod harness;

use harness::{Home, commands, recorded};

const MAZE: &str = "o---o---o---o\n| S       G |\no   o---o   o\n|           |\no---o---o---o\n";

/// File names whose characters occupy one column, two columns or none.
const NAMES: [&str; 4] =
    ["plain.txt", "全日本2017決勝.txt", "か\u{3099}e\u{301}.txt", "a long name.txt"];

/// Returns the number of columns that a text with characters of [`NAMES`] occupies.
fn columns(text: &str) -> usize {
    let columns = |c: char| match c {
        '\u{301}' | '\u{3099}' => 0,
        _ if c.is_ascii() || c == 'µ' => 1,
        _ => 2,
    };
    text.chars().map(columns).sum()
}

/// Checks that all columns of the table that begins with `head` end at the same place. The last
/// column is right-aligned.
#[track_caller]
fn check_table(text: &str, head: &str, rows: usize) {
    let mut sections = text.split("\n\n");
    let table = sections.find(|section| section.starts_with(head)).unwrap_or_else(|| {
        panic!("no table begins with {head:?}:\n{text}");
    });
    let widths: Vec<usize> = table.lines().take(rows + 1).map(columns).collect();
    assert_eq!(widths, vec![widths[0]; rows + 1], "{table}");
}

#[test]
fn tables_align_wide_and_combining_characters() {
    let home = Home::new();
    for name in NAMES {
        home.write(&format!("mazes/{name}"), MAZE);
    }
    let vehicle = home.run(&["fast-run", "--print-vehicle", "--vehicle", "expert"]).stdout;
    home.write("wide.toml", vehicle.replace("\"expert\"", "\"快速\""));
    let stdout = |arguments: &[&str]| {
        let ended = home.run(arguments);
        assert_eq!(ended.stderr, "", "{arguments:?}");
        ended.stdout
    };
    let runs = stdout(&["fast-run", "mazes", "--vehicle", "wide.toml", "--vehicle", "ukmars"]);
    let runs = runs.replace('\\', "/");
    let rows: Vec<&str> = runs.lines().filter(|line| line.starts_with("  ")).collect();
    assert!(runs.contains("\nmazes/全日本2017決勝.txt\n  快速   "), "{runs}");
    let widths: Vec<usize> = rows.iter().map(|row| columns(row)).collect();
    assert_eq!(widths, vec![widths[0]; 1 + 2 * NAMES.len() + 2], "{runs}");
    let trials = stdout(&["trial", "mazes", "--compare"]);
    check_table(&trials, "Benchmarks ", 7);
    let strategies = ["--strategies", "flood-fill,swing"];
    let contest = stdout(&[&["contest", "mazes"][..], &strategies].concat());
    check_table(&contest, "maze ", NAMES.len());
    let one = format!("mazes/{}", NAMES[1]);
    let contest = stdout(&[&["contest", &*one][..], &strategies].concat());
    check_table(&contest, "  ", 2);
}

/// Commands that write data or files, or need the internet.
const WITHOUT_TEXT: [&str; 8] = [
    "mazes help",
    "completions",
    "man",
    "help",
    "export",
    "mazes convert",
    "mazes fetch",
    "mazes generate",
];

/// Without a terminal, lines are as long as on a terminal of 80 columns.
#[test]
fn lines_of_all_commands_fit_80_columns() {
    let home = Home::new();
    let long = "a maze with a long name";
    home.write(&format!("mazes/{long}.txt"), MAZE);
    home.write(&format!("mazes/{long} without a way.txt"), MAZE.replace("S  ", "S |"));
    let strategies = ["--strategies", "swing,flood-fill,left-wall"];
    let demo = ["demo", "old quarter", "--once", "--port", "0", "--no-viewer", "--record", "."];
    let demo = [&demo[..], &["--pace", "0"]].concat();
    assert_eq!(home.run(&demo[..8]).code, Some(0));
    std::fs::rename(recorded(home.path()), home.path().join("search.mcap")).unwrap();
    let server = home.serve(&["old", "quarter", "--port", "0"]);
    let classic = home.serve(&["harbour", "--port", "0"]);
    let connect = ["--connect", &server.address];
    let solve = ["solve", "fastest-path-search", "--goal", "server"];
    let long = format!("mazes/{long}.txt");
    let run = ["run", "--port", "0", "--no-viewer", "--maze", &long, env!("CARGO_BIN_EXE_mmsim")];
    let cases = [
        demo.clone(),
        [&solve[..], &connect].concat(),
        [&run[..], &["solve", "shortest-path-search", "--goal", "server"]].concat(),
        vec!["check-server", &classic.address],
        vec!["replay", "search.mcap"],
        vec!["mazes", "list"],
        vec!["mazes", "list", "mazes"],
        vec!["mazes", "show", "closed", "garden"],
        vec!["mazes", "show", "old", "quarter"],
        vec!["mazes", "check", "mazes"],
        vec!["mazes", "diff", "harbour", "hedgerow"],
        vec!["fast-run", "mazes"],
        vec!["fast-run", "harbour", "old quarter", "--route", "all"],
        vec!["fast-run", "harbour", "--explain"],
        vec!["fast-run", "--explain", "--vehicle", "ukmars", "--route", "all"],
        [&["contest"][..], &strategies].concat(),
        [&["contest", "mazes"][..], &strategies].concat(),
        vec!["compare"],
        vec!["compare", "--tables"],
        [&["compare", "mazes"][..], &strategies].concat(),
        vec!["trial", "orchard", "terraces", "harbour", "hedgerow", "--compare"],
        vec!["trial", "orchard", "mazes", "--robot", "champion", "--robot", "random"],
        vec!["trial", "orchard", "--path"],
    ];
    for arguments in &cases {
        let ended = home.run(arguments);
        assert!(ended.stdout.lines().count() > 1, "{arguments:?}: {ended:?}");
        for line in ended.stdout.lines() {
            // Shells of Windows differ in how they continue a command on another line.
            let is_command = cfg!(windows) && line.starts_with("  mmsim ");
            assert!(is_command || columns(line) <= 80, "{arguments:?}: {line}");
        }
    }
    let words: Vec<String> = cases.iter().map(|words| words.join(" ") + " ").collect();
    for command in commands(&home) {
        let is_tested = words.iter().any(|words| words.starts_with(&format!("{command} ")));
        assert!(is_tested || WITHOUT_TEXT.contains(&&*command), "{command}");
    }
}

/// A mouse that fails at once.
#[cfg(unix)]
#[test]
fn tables_align_names_of_mice() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    let mouse = "全日本鼠=false";
    let compared = home.run(&["compare", "a.txt", "--strategies", "flood-fill", "--mouse", mouse]);
    assert!(compared.stdout.contains("\n2 全日本鼠 "), "{compared:?}");
    check_table(&compared.stdout, "mouse ", 2);
}

/// The `script` tool runs commands in its own pseudo-terminal.
#[cfg(target_os = "linux")]
mod on_linux {
    use std::collections::BTreeSet;
    use std::fs;
    use std::io::Read as _;
    use std::process::{Command, Stdio};

    use mmsim_tests::{output, wait_for_exit, within};

    use super::*;

    /// The variables that control escape codes.
    const VARIABLES: [&str; 5] = ["TERM", "NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "CI"];

    /// A log line, the messages of the argument parser, and its help.
    const MESSAGES: &str = "$MMSIM -v mazes show harbour; $MMSIM --nonsense; $MMSIM --help";

    /// A map that is redrawn during the search.
    const MAP: &str = "$MMSIM -q demo --port 0 --once --pace 0 harbour";

    /// A comparison with a progress bar. The mouse waits for the file `end`.
    const COMPARE: &str = "$MMSIM compare a.txt --strategies none --time-limit 300 \
        --mouse \"m=sh -c 'until [ -e end ]; do sleep 0.01; done'\" >/dev/null";

    /// Returns a command with only these of the [`VARIABLES`].
    fn command(home: &Home, program: &str, environment: &[(&str, &str)]) -> Command {
        let mut command = Command::new(program);
        for variable in VARIABLES {
            command.env_remove(variable);
        }
        command.env("MMSIM", env!("CARGO_BIN_EXE_mmsim")).env("HOME", home.path());
        command.current_dir(home.path()).envs(environment.iter().copied());
        command
    }

    /// Returns the output of a command.
    fn text(mut command: Command) -> String {
        let output = output(&mut command);
        String::from_utf8([output.stdout, output.stderr].concat()).unwrap()
    }

    /// Returns a command that runs shell commands on a terminal.
    fn terminal(home: &Home, commands: &str, environment: &[(&str, &str)]) -> Command {
        // Shells set this variable if it is missing.
        let has_term = environment.iter().any(|(name, _)| *name == "TERM");
        let unset = if has_term { "" } else { "unset TERM;" };
        let commands = format!("stty cols 100 rows 60; {unset} {commands}");
        let mut script = command(home, "script", environment);
        script.args(["-qec", &commands, "/dev/null"]);
        script
    }

    /// Runs shell commands on a terminal and returns their output.
    fn on_terminal(home: &Home, commands: &str, environment: &[(&str, &str)]) -> String {
        text(terminal(home, commands, environment))
    }

    /// Runs shell commands whose output is piped, and returns their output.
    fn in_pipe(home: &Home, commands: &str, environment: &[(&str, &str)]) -> String {
        let mut sh = command(home, "sh", environment);
        sh.args(["-c", commands]);
        text(sh)
    }

    /// Returns the final characters of all escape sequences: `m` sets a colour, others move the
    /// cursor or erase text.
    fn escape_codes(text: &str) -> BTreeSet<char> {
        let sequences = text.split("\u{1b}[").skip(1);
        assert_eq!(text.matches('\u{1b}').count(), text.matches("\u{1b}[").count(), "{text:?}");
        sequences.map(|rest| rest.chars().find(char::is_ascii_alphabetic).unwrap()).collect()
    }

    #[test]
    fn escape_codes_follow_the_terminal_and_the_environment() {
        let home = Home::new();
        let (xterm, dumb) = (("TERM", "xterm"), ("TERM", "dumb"));
        for (environment, has_colours, can_redraw) in [
            (&[xterm][..], true, true),
            (&[xterm, ("NO_COLOR", "")], true, true),
            (&[xterm, ("NO_COLOR", "1")], false, true),
            (&[xterm, ("CLICOLOR", "0")], false, true),
            (&[xterm, ("CLICOLOR", "1")], true, true),
            (&[xterm, ("NO_COLOR", "1"), ("CLICOLOR_FORCE", "1")], false, true),
            (&[dumb], false, false),
            (&[dumb, ("CLICOLOR_FORCE", "1")], true, false),
            (&[], false, false),
        ] {
            // Each kind of message follows the same rule.
            for commands in MESSAGES.split(';') {
                let shown = on_terminal(&home, commands, environment);
                let expected = if has_colours { BTreeSet::from(['m']) } else { BTreeSet::new() };
                assert_eq!(escape_codes(&shown), expected, "{environment:?}: {shown:?}");
            }
            let shown = on_terminal(&home, MAP, environment);
            assert_eq!(!escape_codes(&shown).is_empty(), can_redraw, "{environment:?}: {shown:?}");
            assert!(!escape_codes(&shown).contains(&'m'), "{environment:?}: {shown:?}");
        }
    }

    #[test]
    fn pipes_get_escape_codes_only_by_force() {
        let home = Home::new();
        for environment in [&[("TERM", "xterm")][..], &[("TERM", "xterm"), ("CLICOLOR", "1")]] {
            for commands in [MESSAGES, MAP, "$MMSIM compare"] {
                let piped = in_pipe(&home, commands, environment);
                assert!(!piped.contains('\u{1b}'), "{environment:?}: {piped:?}");
            }
        }
        let force = [("TERM", "xterm"), ("CLICOLOR_FORCE", "1")];
        for commands in MESSAGES.split(';') {
            assert_eq!(escape_codes(&in_pipe(&home, commands, &force)), BTreeSet::from(['m']));
        }
        for commands in [MAP, "$MMSIM compare"] {
            assert!(!in_pipe(&home, commands, &force).contains('\u{1b}'), "{commands}");
        }
    }

    #[test]
    fn progress_is_shown_and_removed_on_a_terminal() {
        for environment in [&[("TERM", "xterm")][..], &[("TERM", "xterm"), ("NO_COLOR", "1")]] {
            let home = Home::new();
            home.write("a.txt", MAZE);
            let mut command = terminal(&home, COMPARE, environment);
            let pipes = command.stdin(Stdio::null()).stdout(Stdio::piped());
            let mut child = pipes.spawn().unwrap();
            let mut screen = child.stdout.take().unwrap();
            let (end, bar) = (home.path().join("end"), "0 of 1 searches, ");
            let shown = within("the comparison", move || {
                let (mut shown, mut buffer) = (Vec::new(), [0; 4096]);
                loop {
                    let count = screen.read(&mut buffer).unwrap();
                    if count == 0 {
                        return String::from_utf8(shown).unwrap();
                    }
                    shown.extend(&buffer[..count]);
                    if String::from_utf8_lossy(&shown).contains(bar) {
                        fs::write(&end, "").unwrap();
                    }
                }
            });
            assert!(wait_for_exit(&mut child).success(), "{shown:?}");
            assert!(shown.contains(&format!("░ {bar}")), "{shown:?}");
            assert!(!escape_codes(&shown).contains(&'m'), "{shown:?}");
            let rest = shown.rsplit("\u{1b}[2K").next().unwrap();
            assert_eq!(rest.trim(), "", "{shown:?}");
        }
    }

    #[test]
    fn progress_is_hidden_on_a_dumb_terminal_and_by_quiet() {
        let home = Home::new();
        home.write("a.txt", MAZE);
        // Long enough for several updates of a bar.
        let compare = COMPARE.replace("--time-limit 300", "--time-limit 0.3");
        let quiet = compare.replace("compare", "compare -q");
        for (commands, environment) in [
            (&compare, &[("TERM", "dumb")][..]),
            (&compare, &[("TERM", "dumb"), ("CLICOLOR_FORCE", "1")]),
            (&compare, &[]),
            (&quiet, &[("TERM", "xterm")]),
        ] {
            assert_eq!(on_terminal(&home, commands, environment), "", "{environment:?}");
        }
    }
}
