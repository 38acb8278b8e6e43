//! Tests when the viewer page is served, and at which address.

mod harness;

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};

use harness::Home;
use mmsim_tests::TIMEOUT;
#[cfg(target_os = "linux")]
use mmsim_tests::wait_for;

/// Connects to the page at the reported address. Returns the connection and the host.
fn connect(messages: &str) -> (TcpStream, String) {
    let address = messages.split("watch at http://").nth(1).unwrap().lines().next().unwrap();
    let (host, _) = address.split_once('/').unwrap_or((address, ""));
    let port = host.rsplit(':').next().unwrap();
    let stream = TcpStream::connect(format!("127.0.0.1:{port}")).unwrap();
    stream.set_read_timeout(Some(TIMEOUT)).unwrap();
    (stream, host.into())
}

/// Returns the reply to `GET /`.
fn page(messages: &str) -> String {
    get(messages, "/")
}

fn get(messages: &str, path: &str) -> String {
    let (mut stream, host) = connect(messages);
    write!(stream, "GET {path} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n\r\n").unwrap();
    let mut reply = String::new();
    stream.read_to_string(&mut reply).unwrap();
    reply
}

#[test]
fn reports_the_address_of_the_page() {
    let home = Home::new();
    for arguments in [
        &["--port", "0", "--viewer-port", "0"][..],
        &["demo", "--port", "0", "--viewer-port", "0", "first steps"],
    ] {
        let server = home.serve_until(arguments, "watch at http://");
        assert!(page(&server.messages).starts_with("HTTP/1.1 200 OK"), "{arguments:?}");
    }
}

#[test]
fn an_explicit_page_port_in_use_is_an_error() {
    let home = Home::new();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let ended = home.run(&["--port", "0", "--viewer-port", &port]);
    assert_eq!(ended.code, Some(1));
    assert_eq!(
        ended.stderr,
        format!(
            "mmsim: cannot serve the viewer page: port {port} on 127.0.0.1 is already in use (try \
             --viewer-port 0)\n"
        )
    );
}

#[test]
fn a_second_simulator_serves_without_a_page() {
    let home = Home::new();
    let usual = TcpListener::bind(("127.0.0.1", mmsim_viewer::DEFAULT_VIEWER_PORT));
    let second = harness::Serving::start(home.command(&["--port", "0"]), "tcp://");
    let ended = home.run(&["solve", "flood-fill", "--connect", &second.address]);
    assert_eq!(ended.code, Some(0));
    assert!(
        second
            .messages
            .contains("cannot serve the viewer page: port 6575 on 127.0.0.1 is already in use")
    );
    // This test also passes if another process uses the port.
    drop(usual);
}

#[test]
fn the_page_can_be_disabled() {
    let home = Home::new();
    let mut server = home.serve_until(&["-v", "--port", "0", "--no-viewer"], "keeping up to");
    server.kill();
    assert!(!server.wait().1.contains("watch"));
    let wrong = home.run(&["--no-viewer", "--viewer-port", "7000"]);
    assert_eq!(wrong.code, Some(2));
}

#[test]
fn a_token_is_required_from_other_machines() {
    let home = Home::new();
    let server =
        home.serve_until(&["--port", "0", "--viewer-port", "0", "--host", "0.0.0.0"], "watch at ");
    assert!(server.messages.contains("/?token="), "{}", server.messages);
    assert!(
        !server.messages.contains("watch at http://0.0.0.0"),
        "the wildcard address is not reachable"
    );
    assert!(page(&server.messages).starts_with("HTTP/1.1 401 Unauthorized"));
}

#[test]
fn a_recording_is_shown_on_the_page() {
    let home = Home::new();
    let server = home.serve(&["--port", "0", "first steps"]);
    let arguments = ["solve", "flood-fill", "--connect", &server.address];
    home.run(&[&arguments[..], &["--goal", "server", "--record", "own.mcap"]].concat());
    let command = home.command(&["replay", "own.mcap", "--serve", "--viewer-port", "0"]);
    let mut replay = harness::Serving::start(command, "watch at http://");
    assert!(page(&replay.messages).starts_with("HTTP/1.1 200 OK"));
    replay.kill();
    assert!(replay.stdout().starts_with("own.mcap: "));
    let two = ["replay", "own.mcap", "own.mcap", "--serve", "--viewer-port", "0"];
    let mut replay = harness::Serving::start(home.command(&two), "watch at http://");
    let info = get(&replay.messages, "/api/page");
    assert!(info.contains(r#""opened":["1","2"]"#), "{info}");
    replay.kill();
    let missing = home.run(&["replay", "own.mcap", "missing.mcap", "--serve"]);
    assert_eq!(missing.code, Some(1), "{missing:?}");
    assert_eq!(home.run(&["replay", "own.mcap", "own.mcap"]).code, Some(2));
    assert_eq!(home.run(&["replay", "own.mcap", "--viewer-port", "0"]).code, Some(2));
    assert_eq!(home.run(&["replay", "own.mcap", "--serve", "--at", "1"]).code, Some(2));
}

/// Some of these tests read a server's open files and threads from `/proc`, which Linux provides.
#[cfg(target_os = "linux")]
mod on_linux {
    use std::ffi::OsString;
    use std::fs;
    use std::path::Path;

    use super::*;

    #[test]
    fn a_killed_server_leaves_no_upload_behind() {
        let (home, temporary) = (Home::new(), Home::new());
        let mut command = home.command(&["--port", "0", "--viewer-port", "0"]);
        command.env("TMPDIR", temporary.path());
        let mut server = harness::Serving::start(command, "watch at http://");
        let (mut stream, host) = connect(&server.messages);
        write!(
            stream,
            "POST /api/recordings?name=a.mcap HTTP/1.1\r\nhost: {host}\r\norigin: http://{host}\r\n\
             content-length: 1000000\r\n\r\nwhat is left of it?"
        )
        .unwrap();
        let descriptors = format!("/proc/{}/fd", server.id());
        wait_for("the upload to be written to a file", || {
            let is_temporary = |path: &Path| path.starts_with(temporary.path());
            let mut files = fs::read_dir(&descriptors).unwrap().flatten();
            files
                .any(|file| fs::read_link(file.path()).is_ok_and(|path| is_temporary(&path)))
                .then_some(())
        });
        server.kill();
        server.wait();
        assert_eq!(fs::read_dir(temporary.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_lack_of_descriptors_is_reported_once() {
        let home = Home::new();
        let mut command = std::process::Command::new("sh");
        let limited = "ulimit -n 40 && exec \"$0\" --port 0 --viewer-port 0";
        command.args(["-c", limited, env!("CARGO_BIN_EXE_mmsim")]).env("HOME", home.path());
        let mut server = harness::Serving::start(command, "watch at http://");
        let page = server.messages.split("http://").nth(1).unwrap().split('/').next().unwrap();
        let descriptors = format!("/proc/{}/fd", server.id());
        // The process that runs the tests may pass on descriptors above the limit.
        let is_limited = |name: &OsString| name.to_str().unwrap().parse::<u32>().unwrap() < 40;
        for _ in 0..3 {
            let all: Vec<_> = (0..60).map(|_| TcpStream::connect(page.trim()).unwrap()).collect();
            wait_for("the last descriptor", || {
                let open = fs::read_dir(&descriptors).unwrap();
                let names = open.map(|entry| entry.unwrap().file_name());
                (names.filter(is_limited).count() == 40).then_some(())
            });
            drop(all);
            assert!(self::page(&server.messages).starts_with("HTTP/1.1 200 OK"));
        }
        server.kill();
        let (_, messages) = server.wait();
        assert_eq!(messages.matches("cannot accept a connection").count(), 1, "{messages}");
    }

    #[test]
    fn animations_are_drawn_in_the_background() {
        let home = Home::new();
        let server = home.serve_until(&["--port", "0", "--viewer-port", "0"], "watch at http://");
        let arguments = ["solve", "flood-fill", "--connect", &server.address];
        assert_eq!(home.run(&arguments).code, Some(0));
        let (mut stream, host) = connect(&server.messages);
        let animation = "/api/sources/live/animation.gif";
        write!(stream, "GET {animation}?run=2 HTTP/1.1\r\nhost: {host}\r\n\r\n").unwrap();
        wait_for("a thread that draws at the lowest priority", || {
            let tasks = fs::read_dir(format!("/proc/{}/task", server.id())).unwrap().flatten();
            let mut stats = tasks.flat_map(|task| fs::read_to_string(task.path().join("stat")));
            stats
                .any(|stat| {
                    let (name, fields) = stat.rsplit_once(") ").unwrap();
                    // The 19th field is the nice value of the thread, at most 19.
                    name.ends_with("(exports") && fields.split(' ').nth(19 - 3) == Some("19")
                })
                .then_some(())
        });
    }
}

/// The command is run as it is printed. It finds no browser.
#[cfg(target_os = "linux")]
#[test]
fn the_command_of_a_comparison_shows_both_searches() {
    let home = Home::new();
    home.write(
        "my mazes/a.txt",
        "o---o---o---o---o\n|         G |   |\no   o---o---o   o\n| S |           |\no---o---o---o---o\n",
    );
    let mine = format!("mine={} solve swing --goal server", env!("CARGO_BIN_EXE_mmsim"));
    let compare = ["compare", "my mazes", "--mouse", &mine, "--strategies", "flood-fill"];
    let ended = home.run(&compare);
    let (_, shown) = ended.stdout.split_once("  mmsim compare --open ").expect("a command");
    let mmsim = std::path::Path::new(env!("CARGO_BIN_EXE_mmsim"));
    let shown = shown.split("\n\n").next().unwrap();
    let shell = format!("exec mmsim compare --open {} --viewer-port 0", shown.trim_end());
    let mut command = std::process::Command::new("/bin/sh");
    command.args(["-c", &shell]).current_dir(home.path()).env("HOME", home.path());
    command.env("PATH", mmsim.parent().unwrap()).env_remove("BROWSER");
    let serving = harness::Serving::start(command, "watch at http://");
    for (source, title) in [("1", "mine"), ("2", "flood-fill")] {
        let reply = get(&serving.messages, &format!("/api/sources/{source}"));
        assert!(reply.contains(&format!("\"{title}\"")), "{reply}");
    }
}

#[test]
fn a_comparison_shows_one_maze() {
    let ended = Home::new().run(&["compare", "--open"]);
    assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""));
    assert!(ended.stderr.contains("--open takes one maze, found 19"), "{ended:?}");
}
