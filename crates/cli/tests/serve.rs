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
fn serves_a_bundled_maze_by_default() {
    let server = Home::new().serve(&["--port", "0"]);
    assert!(
        server.messages.starts_with(
            "serving 10-two-roads.txt (16x16, goal 44 steps away) at tcp://127.0.0.1:"
        )
    );
}

#[test]
fn finds_the_folder_in_the_home() {
    let home = Home::new();
    home.write(".mmsim/contest/own.txt", OPEN);
    let server = home.serve(&["-p", "0"]);
    assert!(server.messages.contains("own.txt (2x1, goal 1 step away)"), "{}", server.messages);
}

#[test]
fn falls_back_to_bundled_mazes() {
    let home = Home::new();
    home.write(".mmsim/rubbish.txt", "rubbish");
    let server = home.serve(&["-p", "0"]);
    assert!(server.messages.contains(".mmsim; using the bundled mazes"), "{}", server.messages);
    assert!(server.messages.contains("serving 10-two-roads.txt"), "{}", server.messages);
}

#[test]
fn words_select_a_maze_in_a_folder_tree() {
    let home = Home::new();
    home.write("mazes/a-closed.txt", CLOSED);
    home.write("mazes/b-damaged.txt", "o---o\n| S \no---o\n");
    home.write("mazes/deep/er/c-open.txt", OPEN);
    let served = |arguments: &[&str]| home.serve(arguments).messages.clone();
    assert!(
        served(&["./mazes", "-p", "0"]).contains("c-open.txt"),
        "the first with a reachable goal"
    );
    assert!(served(&["./mazes", "-p", "0", "CLOSED a"]).contains("a-closed.txt"));
    assert!(served(&["mazes/a-closed.txt", "-p", "0"]).contains("goal unreachable"));
    let ended = home.run(&["./mazes", "no such"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.contains("matches \"no such\""));
    let ended = home.run(&["mazes/b-damaged.txt"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.contains("b-damaged.txt: line 2, column 5: expected "), "{ended:?}");
}

#[test]
fn reports_a_port_in_use() {
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
fn warns_when_exposed_to_other_machines() {
    let home = Home::new();
    let warning = "anyone who can reach this port can read walls, add states and delete the \
                   history: the protocol has no authentication and no encryption\n";
    for host in ["0.0.0.0", "*"] {
        let server = home.serve_until(&["--port", "0", "--host", host], "encryption");
        assert!(server.messages.contains("at tcp://0.0.0.0:"), "{}", server.messages);
        assert!(server.messages.ends_with(warning), "{}", server.messages);
    }
}

#[cfg(unix)]
#[test]
fn signals_stop_the_server_cleanly() {
    for signal in ["INT", "TERM", "HUP"] {
        let home = Home::new();
        let mut server = home.serve(&["--port", "0"]);
        assert_eq!(home.run(&["solve", "flood-fill", "--connect", &server.address]).code, Some(0));
        server.signal(signal);
        let (status, messages) = server.wait();
        assert_eq!(status.code(), Some(0), "{messages}");
        assert_eq!(messages.lines().count(), 2, "{messages}");
        assert!(messages.contains("run `mmsim mazes fetch`"), "{messages}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_idle_server_uses_no_processor_time() {
    let home = Home::new();
    let server = home.serve(&["--port", "0"]);
    assert_eq!(home.run(&["solve", "flood-fill", "--connect", &server.address]).code, Some(0));
    let ticks = || {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", server.id())).unwrap();
        // The 12th and 13th numbers after the name are the user and kernel time.
        let numbers = stat.rsplit(')').next().unwrap().split(' ').skip(12).take(2);
        numbers.map(|number| number.parse::<u64>().unwrap()).sum::<u64>()
    };
    // The first measurement may include the end of the search.
    wait_for("a second in which the server uses no processor time", || {
        let before = ticks();
        std::thread::sleep(std::time::Duration::from_secs(1));
        (ticks() == before).then_some(())
    });
}

#[test]
fn a_closed_stderr_does_not_stop_the_server() {
    let home = Home::new();
    let server = home.serve_unheard(&["--port", "0", "hedgerow"]);
    for size in ["8x8", "16x16"] {
        let reaches = size == "16x16";
        let arguments = ["solve", "flood-fill", "--size", size, "--connect", &server.address];
        assert_eq!(home.run(&arguments).code, Some(i32::from(!reaches)), "{size}");
    }
}

#[test]
fn usage_errors_have_a_separate_exit_code() {
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
    let help = home.run(&["solve", "--help"]).stdout;
    let ipc = " or ipc://PATH";
    assert_eq!(help.contains(ipc), cfg!(feature = "libzmq"), "{help}");
    insta::assert_snapshot!("help-solve", help.replace(ipc, ""));
    insta::assert_snapshot!("help-demo", home.run(&["demo", "--help"]).stdout);
}
