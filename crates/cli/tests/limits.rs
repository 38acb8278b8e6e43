//! Limits on memory, open files and unpacked recordings.
#![cfg(target_os = "linux")]

mod harness;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use std::{fs, thread};

use harness::noise::{send_until_refused, state};
use harness::{Home, Serving, limited, recorded};
use mcap::records::{MessageHeader, Metadata};
use mmsim_tests::{TIMEOUT, ask, connect_to};

const MIB: u64 = 1 << 20;

/// Returns a process's memory use in bytes. `key` is a field such as `VmHWM` (the peak).
fn figure(process: u32, key: &str) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(':'))?;
    Some(line.split_whitespace().next()?.parse::<u64>().unwrap() * 1024)
}

#[test]
fn a_server_that_runs_out_of_memory_refuses_states_until_reset() {
    let home = Home::new();
    // The history limit exceeds the memory limit of the system, so that an allocation fails.
    let options = ["-p", "0", "hedgerow", "--history-limit", "100000", "--record", "r"];
    // Of this, the threads that record take up to 16 MiB.
    let (server, max) = serve_with(&home, &options, 64 * MIB);
    for _ in 0..2 {
        let (mut acknowledged, refusal) = send_until_refused(&server.address, 0, max);
        let refusal = refusal.unwrap_or_else(|| panic!("{acknowledged} states fit"));
        let expected = "error: cannot store another state: out of memory after ";
        assert!(refusal.starts_with(expected), "{refusal}");
        assert!(refusal.ends_with(" states (reset to free memory)"), "{refusal}");
        assert!(acknowledged > 16 * MIB / 518, "{acknowledged} states");
        let socket = connect_to(&server.address, zmq::REQ);
        for number in 0..1000 {
            // Memory freed by other threads may hold a few more states.
            match ask(&socket, &state(number)).as_slice() {
                b"ok" => acknowledged += 1,
                refusal => assert!(refusal.starts_with(expected.as_bytes())),
            }
        }
        assert_eq!(ask(&socket, b"ping"), b"pong");
        let info = String::from_utf8(ask(&socket, b"info")).unwrap();
        assert!(info.contains(&format!("\"states\":{acknowledged},")), "{info}");
        assert_eq!(ask(&socket, b"reset"), b"ok");
    }
    assert_eq!(send_until_refused(&server.address, 0, 1000), (1000, None));
}

/// Starts a server with this much more address space than it needs at the start. Returns also a
/// number of states that do not fit.
fn serve_with(home: &Home, options: &[&str], free: u64) -> (Serving, u64) {
    let server = home.server(&[&["-v"], options].concat());
    let serve = |kib: u64| Serving::start(limited(&server, &format!("-v {kib}")), "states");
    let taken = figure(serve(1 << 20).id(), "VmSize").unwrap() + free;
    (serve(taken / 1024), taken / 518)
}

#[test]
fn a_larger_limit_stores_more_states() {
    let home = Home::new();
    let options = ["-p", "0", "hedgerow", "--history-limit", "100000"];
    let mut fewer = 0;
    // By default, glibc reserves at least 64 MiB for each thread.
    for free in [48, 80, 112, 144] {
        let (server, max) = serve_with(&home, &options, free * MIB);
        let (acknowledged, refusal) = send_until_refused(&server.address, 0, max);
        let expected = fewer + 16 * MIB / 518;
        assert!(acknowledged > expected, "{acknowledged} states in {free} MiB: {refusal:?}");
        fewer = acknowledged;
    }
}

#[test]
fn a_mouse_sees_the_environment_of_the_user() {
    let home = Home::new();
    let mouse = ["run", "-p", "0", "--no-viewer", "--", "sh", "-c", "echo \"<$MALLOC_ARENA_MAX>\""];
    for (arenas, expected) in [(None, "<>\n"), (Some("1"), "<1>\n")] {
        let mut command = home.command(&mouse);
        command.env_remove("MALLOC_ARENA_MAX").envs(arenas.map(|it| ("MALLOC_ARENA_MAX", it)));
        let ended = mmsim_tests::output(&mut limited(&command, "-v 2000000"));
        assert_eq!(String::from_utf8(ended.stdout).unwrap(), expected, "{:?}", ended.stderr);
    }
}

#[test]
fn a_shortage_of_open_files_is_no_verdict_on_a_mouse() {
    let home = Home::new();
    let compare = ["compare", "--strategies", "none", "--jobs", "100", "--mouse", "m=sleep 0"];
    let run = |limit: &str| limited(&home.command(&compare), limit).output().unwrap();
    let (few, none) = (run("-n 64"), run("-n 17"));
    let [results, errors] = [few.stdout, few.stderr].map(|text| String::from_utf8(text).unwrap());
    assert_eq!(few.status.code(), Some(0), "{errors}");
    assert!(!results.contains("Too many open files"), "{results}");
    assert_eq!((none.status.code(), &*none.stdout), (Some(1), &b""[..]));
    let error = String::from_utf8(none.stderr).unwrap();
    assert!(error.contains(": Too many open files"), "{error}");
}

#[test]
fn the_default_limit_is_below_that_of_the_process() {
    let home = Home::new();
    let server = home.server(&["-v", "-p", "0", "hedgerow"]);
    for option in ["-v", "-d"] {
        let limited = limited(&server, &format!("{option} {}", 1 << 20));
        let messages = Serving::start(limited, "half of the free memory").messages.clone();
        let limit = messages.split("keeping up to ").nth(1).unwrap().split(' ').next().unwrap();
        let limit: u64 = limit.parse().unwrap();
        assert!((1..=512).contains(&limit), "{limit} MiB under `ulimit {option}` of 1024");
    }
}

#[test]
fn low_descriptor_limits_are_reported() {
    let home = Home::new();
    // With fewer than 6 files, not even the shared libraries load.
    for files in 6..20 {
        let server = home.server(&["-p", "0", "--record", "r", "--viewer-port", "0"]);
        let mut child = limited(&server, &format!("-n {files}"))
            .stdin(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (mut messages, mut stderr) = (String::new(), child.stderr.take().unwrap());
        let mut piece = [0; 1000];
        while !messages.contains("recording to ") {
            let count = stderr.read(&mut piece).unwrap();
            if count == 0 {
                break;
            }
            messages += &String::from_utf8_lossy(&piece[..count]);
        }
        let _ = child.kill();
        stderr.read_to_string(&mut messages).unwrap();
        child.wait().unwrap();
        assert!(!messages.contains("panicked"), "{files} files: {messages}");
        assert!(
            messages.contains("recording to ") || messages.contains("open files"),
            "{files}: {messages}"
        );
    }
}

/// Writes a small recording with many identical states. Each chunk holds 10,000 states. An unknown
/// record makes the file long enough for a million states.
fn bomb(home: &Home, name: &str, chunks: usize) -> PathBuf {
    const CHUNK: u8 = 6;
    let mut mcap = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    let info = r#"{"maze":"small","width":1,"height":1,"start":[0,0],"heading":"N","goals":[],"states":0,"protocol":1}"#;
    let metadata = [("info".to_string(), info.to_string())].into();
    mcap.write_metadata(&Metadata { name: "mmsim".into(), metadata }).unwrap();
    let channel_id = mcap.add_channel(0, "/state", "mmsim-state", &[].into()).unwrap();
    let header = MessageHeader { channel_id, sequence: 0, log_time: 7, publish_time: 7 };
    for _ in 0..10_000 {
        mcap.write_to_known_channel(&header, b"S\0\0NC\x01C\x0d").unwrap();
    }
    mcap.finish().unwrap();
    let bytes = mcap.into_inner().into_inner();
    let mut at = mcap::MAGIC.len();
    let length = |at: usize| {
        9 + usize::try_from(u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap())).unwrap()
    };
    while bytes[at] != CHUNK {
        at += length(at);
    }
    let chunk = &bytes[at..at + length(at)];
    let unknown = [&[0x80][..], &300_000_u64.to_le_bytes(), &vec![0; 300_000]].concat();
    let path = home.write(name, [&bytes[..at], &unknown, &chunk.repeat(chunks)].concat());
    assert!(fs::metadata(&path).unwrap().len() < 2 * MIB);
    path
}

/// Runs a command. Returns the peak memory, the exit code and the messages.
fn run_measured(mut command: Command) -> (u64, Option<i32>, String) {
    let mut child: Child =
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut peak = 0;
    let status = loop {
        peak = figure(child.id(), "VmHWM").unwrap_or(0).max(peak);
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        thread::sleep(Duration::from_millis(1));
    };
    let mut messages = String::new();
    child.stderr.unwrap().read_to_string(&mut messages).unwrap();
    (peak, status.code(), messages)
}

#[test]
fn a_small_file_with_many_states_takes_no_more_memory_than_the_limit() {
    let home = Home::new();
    let bomb = bomb(&home, "bomb.mcap", 1000);
    let named = home.path().join("named like a maze.txt");
    fs::copy(&bomb, &named).unwrap();
    let (bomb, named) = (bomb.to_str().unwrap(), named.to_str().unwrap());
    for arguments in [
        &["export", bomb, "-o", "bomb.svg"][..],
        &["export", bomb, "-o", "bomb.gif"],
        &["export", named, "-o", "bomb.svg"],
        &["replay", bomb],
        &["replay", bomb, "--json"],
    ] {
        let command = home.command(&[arguments, &["--history-limit", "1"]].concat());
        let (peak, code, messages) = run_measured(command);
        assert_eq!(code, Some(1), "{messages}");
        assert!(
            messages.contains(
                "states fit into the 1 MiB that open recordings share (raise --history-limit)"
            ),
            "{messages}"
        );
        assert!(peak < 64 * MIB, "{arguments:?}: {peak} bytes");
        assert!(!home.path().join("bomb.svg").exists());
    }
}

/// Sends a request to the page. Returns the status and the body.
fn post(page: &str, path: &str, body: &str) -> (u16, String) {
    send(page, "POST", path, body)
}

fn send(page: &str, method: &str, path: &str, body: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(page).unwrap();
    stream.set_read_timeout(Some(TIMEOUT)).unwrap();
    write!(
        stream,
        "{method} {path} HTTP/1.1\r\nhost: {page}\r\norigin: http://{page}\r\nconnection: close\r\n\
         content-type: application/json\r\ncontent-length: {}\r\n\r\n{body}",
        body.len()
    )
    .unwrap();
    let mut reply = String::new();
    stream.read_to_string(&mut reply).unwrap();
    let (head, body) = reply.split_once("\r\n\r\n").unwrap();
    (head.split(' ').nth(1).unwrap().parse().unwrap(), body.into())
}

#[test]
fn open_recordings_share_the_limit() {
    let home = Home::new();
    for name in ["r/a.mcap", "r/b.mcap"] {
        // Each recording takes between half a mebibyte and one mebibyte.
        bomb(&home, name, 60);
    }
    let arguments = ["-p", "0", "--record", "r", "--history-limit", "1", "--viewer-port", "0"];
    let server = home.serve_until(&arguments, "watch at http://");
    let page = server.messages.split("watch at http://").nth(1).unwrap().trim();
    let open = |name: &str| post(page, "/api/recordings/open", &format!("{{\"name\":\"{name}\"}}"));
    let (status, body) = open("a.mcap");
    assert_eq!(status, 200, "{body}");
    let before = figure(server.id(), "VmHWM").unwrap();
    for _ in 0..10 {
        let (status, refusal) = open("b.mcap");
        assert_eq!(status, 400, "{refusal}");
        let expected =
            " 1 MiB that open recordings share (close another recording, or raise --history-limit)";
        assert!(refusal.ends_with(expected), "{refusal}");
    }
    let grown = figure(server.id(), "VmHWM").unwrap() - before;
    assert!(grown < 32 * MIB, "{grown} bytes");
    assert_eq!(post(page, "/api/recordings/close", &body).0, 204);
    let (status, body) = open("b.mcap");
    assert_eq!(status, 200, "{body}");
}

/// One client cannot take the share of another, and the state of any client takes all annotations.
#[test]
fn the_annotations_of_all_clients_are_stored_recorded_and_shown() {
    const LINES: usize = 4;
    let home = Home::new();
    let arguments = ["-p", "0", "hedgerow", "--record", "r", "--viewer-port", "0"];
    let mut server = home.serve_until(&arguments, "watch at http://");
    let page = server.messages.split("watch at http://").nth(1).unwrap().trim().to_string();
    let line = [&b"L\xe8\x03"[..], &[b'x'; 1000]].concat();
    let request = [&b"A"[..], &line.repeat(LINES)].concat();
    let clients = [(); 6].map(|()| connect_to(&server.address, zmq::REQ));
    let per_client = "error: cannot store more annotations before the next state: limit of 64 KiB \
                      per connection reached (send S or reset)";
    let for_all = &per_client.replace("64 KiB per connection", "256 KiB for all connections");
    let requests = [16, 16, 16, 16, 1, 0];
    let errors = [per_client, per_client, per_client, per_client, for_all, for_all];
    let lines = LINES * requests.iter().sum::<usize>();
    for number in 0..2 {
        for ((client, requests), error) in clients.iter().zip(requests).zip(errors) {
            let sent = (0..100).take_while(|_| ask(client, &request) == b"ok").count();
            assert_eq!(sent, requests, "{error}");
            assert_eq!(String::from_utf8_lossy(&ask(client, &request)), error);
        }
        assert_eq!(ask(&clients[5], &state(number)), b"ok");
    }
    for at in 0..2 {
        let log = format!("/api/sources/live/log?run=1&at={at}&from={at}");
        let (status, body) = send(&page, "GET", &log, "");
        let found = body.matches(&format!("[{at},\"x")).count();
        assert_eq!((status, found), (200, lines), "{body:.300}");
        let path = format!("/api/sources/live/moment?run=1&at={at}");
        assert_eq!(send(&page, "GET", &path, "").0, 200);
    }
    server.signal("INT");
    server.wait();
    let file = recorded(&home.path().join("r"));
    let json = home.run(&["replay", file.to_str().unwrap(), "--json"]).json();
    assert_eq!(json["log"].as_array().unwrap().len(), 2 * lines, "{:.300}", json.to_string());
}

/// An empty log line takes three bytes of a request and compresses to nothing.
#[test]
fn empty_log_lines_take_no_more_memory_than_the_limit() {
    const LIMIT_MIB: u64 = 32;
    /// The lines in a request of the maximum length.
    const LINES: u64 = 1365;
    let home = Home::new();
    let limit = LIMIT_MIB.to_string();
    let arguments = ["-p", "0", "hedgerow", "--history-limit", &limit, "--viewer-port", "0"];
    let server = home.serve_until(&arguments, "watch at http://");
    let page = server.messages.split("watch at http://").nth(1).unwrap().trim();
    let before = figure(server.id(), "VmHWM").unwrap();
    let socket = connect_to(&server.address, zmq::REQ);
    let request = [&b"A"[..], &b"L\0\0".repeat(usize::try_from(LINES).unwrap())].concat();
    let (mut lines, mut sent) = (0, 0);
    let refusal = loop {
        let mut pending = 0;
        while ask(&socket, &request) == b"ok" {
            pending += LINES;
        }
        match ask(&socket, &state(sent)).as_slice() {
            b"ok" => (lines, sent) = (lines + pending, sent + 1),
            refusal => break String::from_utf8(refusal.to_vec()).unwrap(),
        }
        // Each line counts at least 32 bytes.
        assert!(lines * 32 < LIMIT_MIB * MIB, "{lines} lines in {sent} states");
    };
    assert!(refusal.contains(" history limit of 32 MiB reached "), "{refusal}");
    assert!(lines > 500_000, "{lines} lines");
    for query in ["at=0", "at=9", "at=1000000", "at=9&from=3", "at=9&max=1", "at=9&filter=none"] {
        let path = format!("/api/sources/live/log?run=1&{query}");
        let (status, body) = send(page, "GET", &path, "");
        assert_eq!(status, 200, "{body}");
    }
    let grown = figure(server.id(), "VmHWM").unwrap() - before;
    assert!(grown < LIMIT_MIB * MIB, "{grown} bytes");
}
