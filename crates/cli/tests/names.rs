//! Checks that no command prints control characters from file names or from other programs.
#![cfg(unix)]

mod harness;

use std::fs;
use std::thread;

use harness::{Home, Output};

const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";
/// Ambiguous hex digits.
const AMBIGUOUS: &str = "bf\nab\nee\n";

/// Text that clears the screen, sets a title, breaks the line, sets a colour and reverses the text
/// direction.
const EVIL: &str = "\u{1b}[2J\u{1b}]0;x\u{7}\r\n\u{9b}31m\u{202e}\u{7f}";

/// Asserts that a text has no control characters.
fn check(what: &str, text: &str) {
    let is_obeyed = |c: char| c.is_control() && c != '\n' || ('\u{202a}'..='\u{202e}').contains(&c);
    assert!(!text.contains(is_obeyed), "{what}: {text:?}");
}

fn check_ended(arguments: &[&str], ended: &Output) {
    check(&format!("{arguments:?}"), &(ended.stdout.clone() + &ended.stderr));
    assert!([Some(0), Some(1), Some(2)].contains(&ended.code), "{arguments:?}: {ended:?}");
}

/// Returns a home folder in which a folder, a recording and several mazes have malicious names. The
/// mazes include a duplicate, an ambiguous maze, and a maze whose goal is unreachable.
fn evil_home() -> (Home, String) {
    let home = Home::new();
    let folder = format!("mazes{EVIL}");
    for (name, content) in [
        ("a", MAZE),
        ("b", MAZE),
        ("closed", "o---o---o\n| S | G |\no---o---o\n"),
        ("hex", AMBIGUOUS),
        ("rubbish", "o---o---o\n| \u{1b}[2Jrubbish\u{9b} |\n"),
    ] {
        home.write(&format!("{folder}/{name}{EVIL}.txt"), content);
    }
    let recorded = home.run(&["demo", &folder, "--once", "--port", "0", "--record", "records"]);
    check_ended(&["demo"], &recorded);
    let record = harness::recorded(&home.path().join("records"));
    fs::rename(record, home.path().join(format!("run{EVIL}.mcap"))).unwrap();
    home.write(&format!("cut{EVIL}.mcap"), "\u{89}MCAP0\r\n\u{1b}[2J");
    (home, folder)
}

#[test]
fn no_command_prints_control_characters() {
    let (home, folder) = evil_home();
    let file = |name: &str| format!("{folder}/{name}{EVIL}.txt");
    let [a, hex, closed, rubbish] = ["a", "hex", "closed", "rubbish"].map(file);
    let (run, cut) = (format!("run{EVIL}.mcap"), format!("cut{EVIL}.mcap"));
    let (picture, new) = (format!("{EVIL}.svg"), format!("new{EVIL}"));
    let (none, vehicle) = (format!("none {EVIL}"), format!("vehicle{EVIL}.toml"));
    let name = r"\u001b[2J\u202e\n";
    home.write(&vehicle, format!("base = 'ares'\nname = \"{name}\"\n"));
    let (folder, once) = (&folder[..], ["--once", "--port", "0"]);
    let solve = ["solve", "swing", "--timeout", "0.1", "--connect"];
    let robots = ["--robot", "random"];
    let commands: &[&[&str]] = &[
        &["mazes", "list", folder],
        &["mazes", "list", folder, "--json"],
        &["mazes", "list", &new],
        &["mazes", "show", &a],
        &["mazes", "show", &a, "--json"],
        &["mazes", "show", EVIL],
        &["mazes", "show", &rubbish, "--bits", "codes"],
        &["mazes", "check", folder, &new],
        &["mazes", "check", folder, &new, "--json"],
        &["mazes", "convert", &hex, "-"],
        &["mazes", "convert", &rubbish, "-"],
        &["mazes", "convert", &a, &new],
        &["mazes", "convert", folder, "-"],
        &["mazes", "diff", folder, folder],
        &["mazes", "fetch", folder, "--from", &rubbish],
        &["mazes", "fetch", folder, "--from", &new],
        &["mazes", "fetch", folder, "--from", &format!("http://127.0.0.1:1/{EVIL}")],
        &["mazes", "generate", "-o", &a],
        &["mazes", "generate", "-o", &format!("{new}/")],
        &["compare", folder, EVIL, "--strategies", "swing"],
        &["compare", folder, "--csv"],
        &["compare", folder, "--json"],
        &["compare", folder, "--vehicle", &vehicle, "--strategies", "swing"],
        &["contest", folder, EVIL, "--vehicle", &vehicle, "--strategies", "left-wall,swing"],
        &["contest", folder, "--json", "--mouse", &format!("a={EVIL}")],
        &["fast-run", folder, "--vehicle", &vehicle, "--route", "all"],
        &["fast-run", folder, "--explain"],
        &["fast-run", folder, "--json", "--vehicle", &vehicle],
        &["fast-run", &a, "--vehicle", &vehicle, "--c-array", "-"],
        &["fast-run", &a, "--csv", EVIL],
        &["fast-run", &a, "--csv", &format!("{none}/{EVIL}")],
        &["fast-run", &closed],
        &["fast-run", EVIL, "--vehicle", EVIL],
        &["fast-run", "--vehicle", &rubbish],
        &["fast-run", "--print-vehicle", "--vehicle", &vehicle],
        &[&["trial", folder], &robots[..]].concat(),
        &[&["trial", folder, "--path"], &robots[..]].concat(),
        &[&["trial", folder, "--json"], &robots[..]].concat(),
        &["trial", &a, EVIL, "--compare"],
        &[&["trial", &a, "--serve"], &once[..], &robots].concat(),
        &[&["demo", folder], &once[..]].concat(),
        &[&["demo", &closed], &once[..]].concat(),
        &[&["demo", folder, &none], &once[..]].concat(),
        &["replay", &run],
        &["replay", &run, "--json"],
        &["replay", &cut],
        &["replay", &a],
        &["export", &run, "-o", &picture],
        &["export", &run, "--at", "999", "-o", &picture],
        &["export", &a, "-o", &format!("{EVIL}.gif")],
        &["export", &a, "-o", EVIL],
        &["export", EVIL, "-o", &picture],
        &["export", &run, "-o", &format!("{EVIL}.html")],
        &["export", &run, "-o", EVIL],
        &["export", &cut, "-o", "a.html"],
        &["run", "--maze", folder, "--port", "0", "--no-viewer", "--", "true"],
        &["run", "--maze", folder, "--port", "0", "--no-viewer", "--", EVIL],
        &["run", "--maze", folder, "--port", "0", "--no-viewer", "--watch", "--", EVIL],
        &["run", "--as", "mms", "--maze", folder, "--port", "0", "--no-viewer", "echo", EVIL],
        &[&solve[..], &["tcp://127.0.0.1:1"], &["--record", &run]].concat(),
        &[&solve[..], &[EVIL]].concat(),
        &["check-server", "tcp://127.0.0.1:1", "--timeout", "0.1"],
        &["check-server", EVIL],
        &["man", EVIL],
        &["man", "-o", &a],
        &["completions", EVIL],
        &[EVIL],
        &["--port", "0", folder, &none],
        &["--port", EVIL],
        &[&format!("--{EVIL}")],
        &["solve", EVIL],
        &["-v", "mazes", "show", folder, "rubbish"],
        &["help", EVIL],
    ];
    for arguments in commands {
        check_ended(arguments, &home.run(arguments));
    }
    let help = home.run(&["help"]).stdout;
    let (_, listed) = help.split_once("Commands:\n").unwrap();
    for line in listed.lines().take_while(|line| !line.is_empty()) {
        let Some(name) = line.split_whitespace().next().filter(|_| !line.starts_with("     "))
        else {
            continue;
        };
        assert!(commands.iter().any(|arguments| arguments[0] == name), "{name} is missing here");
    }
}

#[test]
fn no_server_prints_control_characters() {
    let (home, folder) = evil_home();
    let run = format!("run{EVIL}.mcap");
    for (arguments, until) in [
        (&[&*folder, "--port", "0", "--record", EVIL, "-vv", "--json"][..], "recording to"),
        (&["replay", &run, "--serve", "--viewer-port", "0"], "watch at"),
    ] {
        let mut server = home.serve_until(arguments, until);
        server.signal("TERM");
        check(&format!("{arguments:?}"), &server.wait().1);
        check(&format!("{arguments:?}"), &server.stdout());
    }
}

/// The simulator sends malicious text.
#[test]
fn text_from_another_simulator_is_escaped() {
    let home = Home::new();
    let answers = [
        format!("error: {EVIL}"),
        format!("{{\"name\": {EVIL:?}"),
        serde_json::json!({
            "maze": EVIL, "width": 0, "height": 1, "start": [0, 0], "heading": "N", "goals": [],
            "states": 0, "protocol": 1,
        })
        .to_string(),
        EVIL.into(),
    ];
    for answer in answers {
        let simulator = zmq::Context::new().socket(zmq::REP).unwrap();
        simulator.bind("tcp://127.0.0.1:*").unwrap();
        simulator.set_rcvtimeo(10_000).unwrap();
        let endpoint = simulator.get_last_endpoint().unwrap().unwrap();
        // Each command sends one or two requests before it gives up.
        let serving = thread::spawn(move || {
            while simulator.recv_bytes(0).is_ok_and(|request| request != b"end") {
                simulator.send(&answer, 0).unwrap();
            }
        });
        for goal in [&["--goal", "server"][..], &[]] {
            for command in [&["solve", "swing"][..], &["run"]] {
                let mouse: &[&str] = if command == ["run"] { &["echo", "mazeWidth"] } else { &[] };
                let arguments = [command, &["--connect", &endpoint], goal, mouse].concat();
                check_ended(&arguments, &home.run(&arguments));
            }
        }
        for options in [&[][..], &["--json"]] {
            let arguments = [&["check-server", &endpoint][..], options].concat();
            check_ended(&arguments, &home.run(&arguments));
        }
        let end = zmq::Context::new().socket(zmq::REQ).unwrap();
        end.connect(&endpoint).unwrap();
        end.send("end", 0).unwrap();
        serving.join().unwrap();
    }
}
