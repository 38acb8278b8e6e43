//! `mmsim`: serving a maze.

mod harness;

use harness::Home;
#[cfg(target_os = "linux")]
use mmsim_tests::wait_for;

const OPEN: &str = "o---o---o\n| S   G |\no---o---o\n";
const CLOSED: &str = "o---o---o\n| S | G |\no---o---o\n";

fn port(address: &str) -> &str {
    address.rsplit(':').next().unwrap()
}

#[test]
fn without_mazes_of_ones_own_a_bundled_one_is_served() {
    let server = Home::new().serve(&["--port", "0"]);
    assert!(
        server
            .said
            .starts_with("serving 01-harbour.txt (16x16, goal 52 steps away) at tcp://127.0.0.1:")
    );
}

#[test]
fn the_folder_in_the_home_is_found() {
    let home = Home::new();
    home.write(".mmsim/contest/own.txt", OPEN);
    let server = home.serve(&["-p", "0"]);
    assert!(server.said.contains("own.txt (2x1, goal 1 step away)"), "{}", server.said);
}

#[test]
fn a_folder_in_the_home_without_a_maze_is_no_obstacle() {
    let home = Home::new();
    home.write(".mmsim/rubbish.txt", "rubbish");
    let server = home.serve(&["-p", "0"]);
    assert!(
        server.said.contains(".mmsim, found none; here are the bundled ones"),
        "{}",
        server.said
    );
    assert!(server.said.contains("serving 01-harbour.txt"), "{}", server.said);
}

#[test]
fn words_pick_a_maze_of_a_folder_and_its_subfolders() {
    let home = Home::new();
    home.write("mazes/a-closed.txt", CLOSED);
    home.write("mazes/b-rubbish.txt", "rubbish");
    home.write("mazes/deep/er/c-open.txt", OPEN);
    let served = |arguments: &[&str]| home.serve(arguments).said.clone();
    assert!(served(&["./mazes", "-p", "0"]).contains("c-open.txt"), "the first within reach");
    assert!(served(&["./mazes", "-p", "0", "--maze", "CLOSED a"]).contains("a-closed.txt"));
    assert!(served(&["mazes/a-closed.txt", "-p", "0"]).contains("goal cannot be reached"));
    let ended = home.run(&["./mazes", "--maze", "no such"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.starts_with("mmsim: expected a maze whose path holds \"no such\""));
    let ended = home.run(&["mazes/b-rubbish.txt"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.contains("b-rubbish.txt: line 1, column 1: expected "), "{ended:?}");
}

#[test]
fn a_port_in_use_is_a_clear_error() {
    let home = Home::new();
    let server = home.serve(&["--port", "0"]);
    for command in
        [vec!["--port", port(&server.address)], vec!["demo", "--port", port(&server.address)]]
    {
        let ended = home.run(&command);
        assert_eq!(ended.code, Some(1));
        let expected =
            format!("mmsim: port {} on 127.0.0.1 is already in use", port(&server.address));
        assert!(ended.stderr.contains(&expected), "{ended:?}");
    }
}

#[test]
fn serving_others_than_this_machine_is_asked_for_and_said() {
    let home = Home::new();
    let warning = "whoever reaches this port can read walls, add states and delete the history: \
                   the protocol has neither password nor encryption\n";
    for host in ["0.0.0.0", "*"] {
        let server = home.serve_until(&["--port", "0", "--host", host], "encryption");
        assert!(server.said.contains("at tcp://0.0.0.0:"), "{}", server.said);
        assert!(server.said.ends_with(warning), "{}", server.said);
    }
}

#[cfg(unix)]
#[test]
fn signals_end_it_cleanly() {
    for signal in ["INT", "TERM", "HUP"] {
        let home = Home::new();
        let mut server = home.serve(&["--port", "0"]);
        assert_eq!(home.run(&["solve", "flood-fill", "--connect", &server.address]).code, Some(0));
        server.signal(signal);
        let (status, said) = server.wait();
        assert_eq!(status.code(), Some(0), "{said}");
        assert_eq!(said.lines().count(), 2, "{said}");
        assert!(said.contains("MiB of states, half of the free memory"), "{said}");
    }
}

/// It looks for the next request for a moment, and then no more.
#[cfg(target_os = "linux")]
#[test]
fn an_idle_server_uses_no_processor_time() {
    let home = Home::new();
    let server = home.serve(&["--port", "0"]);
    assert_eq!(home.run(&["solve", "flood-fill", "--connect", &server.address]).code, Some(0));
    let ticks = || {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", server.id())).unwrap();
        // In user and in kernel mode: the 12th and 13th number behind the name.
        let numbers = stat.rsplit(')').next().unwrap().split(' ').skip(12).take(2);
        numbers.map(|number| number.parse::<u64>().unwrap()).sum::<u64>()
    };
    // At the beginning the end of the search is still counted.
    wait_for("a second in which the server uses no processor time", || {
        let before = ticks();
        std::thread::sleep(std::time::Duration::from_secs(1));
        (ticks() == before).then_some(())
    });
}

#[test]
fn a_server_whose_messages_nobody_reads_goes_on() {
    let home = Home::new();
    let server = home.serve_unheard(&["--port", "0", "--maze", "hedgerow"]);
    for size in ["8x8", "16x16"] {
        let reaches = size == "16x16";
        let arguments = ["solve", "flood-fill", "--size", size, "--connect", &server.address];
        assert_eq!(home.run(&arguments).code, Some(i32::from(!reaches)), "{size}");
    }
}

#[test]
fn wrong_usage_is_told_apart_from_failure() {
    let home = Home::new();
    for arguments in [
        &["--nonsense"][..],
        &["--port", "65536"],
        &["solve"],
        &["solve", "floodfill"],
        &["solve", "flood-fill", "--size", "33x33"],
        &["solve", "flood-fill", "--goal", "16,0"],
        &["solve", "flood-fill", "--goal", "server", "1,1"],
        &["solve", "flood-fill", "--max-steps", "0"],
        &["mazes"],
        &["mazes", "check"],
        &["--port", "0", "demo"],
    ] {
        let ended = home.run(arguments);
        assert_eq!(ended.code, Some(2), "{arguments:?}: {ended:?}");
        assert!(ended.stdout.is_empty() && ended.stderr.contains("--help"), "{ended:?}");
    }
    for arguments in [&["no-such-folder"][..], &["--host", "no such host"]] {
        assert_eq!(home.run(arguments).code, Some(1), "{arguments:?}");
    }
}

#[test]
fn help_shows_every_default() {
    let home = Home::new();
    insta::assert_snapshot!("help", home.run(&["--help"]).stdout);
    insta::assert_snapshot!("help-solve", home.run(&["solve", "--help"]).stdout);
    insta::assert_snapshot!("help-demo", home.run(&["demo", "--help"]).stdout);
}
