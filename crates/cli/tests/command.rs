//! The command line: completions, manual pages, verbosity and suggestions.

mod harness;

use std::fs;
use std::process::Command;

use harness::Home;
use mmsim_tests::output;
use serde_json::json;

/// The commands and subcommands to test.
const COMMANDS: [&str; 9] = [
    "solve",
    "demo",
    "replay",
    "export",
    "compare",
    "trial",
    "mazes check",
    "check-server",
    "completions",
];

#[test]
fn generates_completions() {
    let home = Home::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = home.run(&["completions", shell]);
        assert_eq!(script.code, Some(0), "{script:?}");
        for word in ["compare", "check", "max-steps", "viewer-port"] {
            assert!(script.stdout.contains(word), "{shell} {word}");
        }
    }
    assert_eq!(home.run(&["completions", "dos"]).code, Some(2));
}

#[test]
fn the_version_names_the_commit_and_the_target() {
    let home = Home::new();
    let short = concat!("mmsim ", env!("CARGO_PKG_VERSION"));
    assert_eq!(home.run(&["-V"]).stdout.trim_end(), short);
    let long = home.run(&["--version"]).stdout;
    let details = long.strip_prefix(&format!("{short} (")).and_then(|rest| rest.split_once(", "));
    let (commit, target) = details.unwrap_or_else(|| panic!("{long}"));
    assert!(target.starts_with(std::env::consts::ARCH) && target.ends_with(")\n"), "{long}");
    // A checkout without git, or of an archive, has no commit.
    let git = Command::new("git").args(["log", "-1", "--abbrev=9", "--format=%h %cs"]).output();
    let head = git.ok().filter(|git| git.status.success() && commit != "unknown commit");
    if let Some(head) = head {
        assert_eq!(commit, String::from_utf8_lossy(&head.stdout).trim_end());
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let home = Home::new();
    let own = home.run(&["man"]).stdout;
    assert!(own.contains(".TH MMSIM 1") && own.contains("viewer\\-port"), "{own}");
    assert!(own.contains("\\&  mmsim demo                           watch a"), "{own}");
    assert_eq!(home.run(&["man", "-o", "man1"]).code, Some(0));
    for command in COMMANDS {
        let words: Vec<&str> = ["man"].into_iter().chain(command.split(' ')).collect();
        let page = home.run(&words).stdout;
        let name = format!("mmsim-{}", command.replace(' ', "-"));
        assert!(page.contains(&name.replace('-', "\\-")), "{page}");
        assert_eq!(fs::read_to_string(home.path().join(format!("man1/{name}.1"))).unwrap(), page);
    }
    let ended = home.run(&["man", "mazes", "chekc"]);
    assert_eq!(ended.code, Some(2));
    assert!(ended.stderr.contains("`mmsim mazes` has no command \"chekc\""));
}

#[test]
fn quiet_works_before_and_after_a_command_and_keeps_errors() {
    let home = Home::new();
    home.write("small.txt", "o---o---o\n| S   G |\no---o---o\n");
    for arguments in [&["-q", "demo", "small.txt"][..], &["demo", "small.txt", "--quiet"]] {
        let arguments = [arguments, &["--once", "--port", "0"]].concat();
        let ended = home.run(&arguments);
        assert_eq!((ended.code, &*ended.stderr), (Some(0), ""), "{ended:?}");
        assert!(ended.stdout.contains("goal reached"), "{ended:?}");
    }
    let ended = home.run(&["-q", "mazes", "show", "no such"]);
    assert!(ended.code == Some(1) && ended.stderr.contains("no such"), "{ended:?}");
    assert_eq!(home.run(&["-q", "-v", "mazes", "list"]).code, Some(2));
}

#[test]
fn verbose_prints_more() {
    let home = Home::new();
    let messages =
        |verbose: &[&str]| home.run(&[&["mazes", "show", "harbour"], verbose].concat()).stderr;
    assert_eq!(messages(&[]), "");
    assert!(messages(&["-v"]).contains("19 files in the bundled mazes"), "{}", messages(&["-v"]));
}

#[test]
fn server_options_before_a_command_are_usage_errors() {
    let home = Home::new();
    for (arguments, command) in [
        (&["--port", "0", "demo"][..], "demo"),
        (&["--no-viewer", "demo", "--once"], "demo"),
        (&["-q", "--port", "0", "solve", "swing"], "solve"),
    ] {
        let ended = home.run(arguments);
        assert_eq!(ended.code, Some(2), "{ended:?}");
        let expected = format!("options of {command} must come after {command}");
        assert!(ended.stderr.contains(&expected), "{ended:?}");
    }
    let ended = home.run(&["--port", "nonsense", "demo"]);
    assert!(ended.stderr.contains("invalid value 'nonsense'"), "{ended:?}");
}

#[test]
fn a_folder_may_have_the_name_of_a_command() {
    let home = Home::new();
    home.write("mazes/small.txt", "o---o---o\n| S   G |\no---o---o\n");
    assert!(home.serve(&["--port", "0", "mazes"]).messages.contains("small.txt (2x1"));
}

#[test]
fn every_form_of_help_works() {
    let home = Home::new();
    for arguments in [&["help"][..], &["--help"], &["-q", "help"], &["no-such-folder", "--help"]] {
        let ended = home.run(arguments);
        assert_eq!(ended.code, Some(0), "{arguments:?}: {ended:?}");
        assert!(ended.stdout.contains("Usage: mmsim [OPTIONS] [MAZE]..."), "{ended:?}");
    }
    for arguments in [&["help", "solve"][..], &["solve", "--help"], &["help", "mazes", "check"]] {
        let ended = home.run(arguments);
        assert!(ended.code == Some(0) && ended.stdout.contains("--json"), "{ended:?}");
    }
}

#[test]
fn suggests_similar_commands() {
    let home = Home::new();
    let messages = |name| home.run(&[name]).stderr;
    assert!(
        messages("sovle").contains(" (did you mean `mmsim solve …`?)\n"),
        "{}",
        messages("sovle")
    );
    assert!(!messages("my-mazes").contains("mean"), "{}", messages("my-mazes"));
    assert!(
        messages("fetch").contains(" (did you mean `mmsim mazes fetch …`?)\n"),
        "{}",
        messages("fetch")
    );
    let ended = home.run(&["slove", "flood-fill"]);
    assert_eq!(ended.code, Some(2));
    let expected = "no such command or maze: \"slove\" (did you mean `mmsim solve …`?)\n";
    assert!(ended.stderr.contains(expected), "{ended:?}");
    let ended = home.run(&["solve", "swing", "--connect", "tcp://127.0.0.1:1", "--timeout", "0.1"]);
    assert!(ended.stderr.ends_with(" (start a simulator with `mmsim`)\n"), "{ended:?}");
}

#[test]
fn json_reports_the_address() {
    let home = Home::new();
    let mut server = home.serve(&["--port", "0", "--json"]);
    // The JSON is printed before the first request is served.
    home.run(&["solve", "flood-fill", "--connect", &server.address]);
    server.kill();
    let stdout = server.stdout();
    let place: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(place["address"], server.address);
    assert_eq!(place["page"], json!(null));
    assert_eq!(place["info"]["goals"], json!([[7, 7], [8, 7], [7, 8], [8, 8]]));
}

#[test]
fn an_invalid_log_filter_is_reported_and_ignored() {
    let home = Home::new();
    let messages = |filter: &str| {
        let output = output(home.command(&["mazes", "show", "harbour"]).env("RUST_LOG", filter));
        assert_eq!(output.status.code(), Some(0));
        String::from_utf8(output.stderr).unwrap()
    };
    let warning = messages("mmsim=loud");
    assert!(warning.starts_with("ignoring RUST_LOG=mmsim=loud: "), "{warning}");
    assert_eq!(messages("mmsim=warn"), "");
    assert!(messages("mmsim=info").contains("files in the bundled mazes"));
}
