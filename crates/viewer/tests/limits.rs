//! Tests that no client can hold a connection forever, even with slow transfers or full queues.

mod harness;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use harness::{Response, WatchedServer};
use mmsim_mouse::{MouseControl, Outcome, Pace};
use mmsim_tests::{TIMEOUT, wait_for, within};
use mmsim_viewer::Limits;
use serde_json::json;

/// Returns limits with short timeouts and at most `connections` connections.
fn limits(connections: usize) -> Limits {
    let timeout = Duration::from_secs(2);
    Limits { connections, header_time: timeout, max_lag: timeout, ..Limits::default() }
}

fn head(watched: &WatchedServer, path: &str, length: usize) -> String {
    let host = &watched.host;
    format!(
        "POST {path} HTTP/1.1\r\nhost: {host}\r\norigin: http://{host}\r\n\
         content-type: application/json\r\ncontent-length: {length}\r\n\r\n"
    )
}

/// Sends one byte at a time until the server closes the connection. Returns the response of the
/// server.
fn trickle(mut stream: TcpStream) -> Vec<u8> {
    let mut sending = stream.try_clone().unwrap();
    let (stop, stopped) = std::sync::mpsc::channel::<()>();
    let sender = thread::spawn(move || {
        while stopped.recv_timeout(Duration::from_millis(20)).is_err() {
            if sending.write_all(b"x").is_err() {
                break;
            }
        }
    });
    let mut response = Vec::new();
    // Fails if a byte arrives after the server closed the connection, which resets the connection.
    let _ = stream.read_to_end(&mut response);
    let _ = stop.send(());
    sender.join().unwrap();
    response
}

#[test]
fn slow_bodies_are_rejected() {
    let watched = WatchedServer::with_limits("127.0.0.1", None, limits(2));
    let slow: Vec<_> = ["/api/maze", "/api/mouse"]
        .map(|path| {
            let mut stream = watched.connect();
            stream.write_all(head(&watched, path, 60_000).as_bytes()).unwrap();
            thread::spawn(|| trickle(stream))
        })
        .into();
    assert_eq!(watched.get("/").status, 200, "the connections are free again");
    for slow in slow {
        let response = Response::parse(&slow.join().unwrap());
        assert_eq!(response.status, 408);
        assert_eq!(
            response.text(),
            "the request body arrived too slowly (minimum 65536 bytes per second, maximum 600 s)"
        );
    }
    watched.stop();
}

#[test]
fn slow_headers_close_the_connection() {
    let watched = WatchedServer::with_limits("127.0.0.1", None, limits(1));
    let mut stream = watched.connect();
    stream.write_all(b"GET / HTTP/1.1\r\nx: ").unwrap();
    let slow = thread::spawn(|| trickle(stream));
    assert_eq!(watched.get("/").status, 200);
    assert_eq!(slow.join().unwrap(), b"");
    watched.stop();
}

#[test]
fn unread_responses_close_the_connection() {
    let watched = WatchedServer::with_limits("127.0.0.1", None, limits(1));
    let mut stream = watched.connect();
    let request = format!("GET /page.css HTTP/1.1\r\nhost: {}\r\n\r\n", watched.host);
    // The responses do not fit into the socket buffers.
    let requests = request.repeat(2000);
    let mut sending = stream.try_clone().unwrap();
    let sender = thread::spawn(move || sending.write_all(requests.as_bytes()));
    assert_eq!(watched.get("/").status, 200);
    // Data in flight still arrives before the connection ends.
    while stream.read(&mut [0; 1 << 12]).is_ok_and(|count| count > 0) {}
    let _ = sender.join().unwrap();
    watched.stop();
}

#[test]
fn slow_uploads_do_not_block_others() {
    let watched = WatchedServer::with_limits("127.0.0.1", None, limits(10));
    watched.send_states(3);
    let saved = watched.get("/api/sources/live/recording.mcap?run=1").body;
    let path = "/api/recordings?name=slow.mcap";
    let slow: Vec<_> = (0..2)
        .map(|_| {
            let mut stream = watched.connect();
            stream.write_all(head(&watched, path, 1_000_000).as_bytes()).unwrap();
            thread::spawn(|| trickle(stream))
        })
        .collect();
    let origin = format!("origin: http://{}", watched.host);
    let fast = watched.send("POST", "/api/recordings?name=fast.mcap", &[&origin], &saved);
    assert_eq!(fast.json(), serde_json::json!({"id": "1"}));
    for slow in slow {
        assert_eq!(Response::parse(&slow.join().unwrap()).status, 408);
    }
    watched.stop();
}

#[test]
fn the_total_time_of_an_upload_is_limited() {
    let limits =
        Limits { body_time: Duration::from_secs(2), max_lag: 10 * TIMEOUT, ..Limits::default() };
    let watched = WatchedServer::with_limits("127.0.0.1", None, limits);
    let mut stream = watched.connect();
    let head = head(&watched, "/api/recordings?name=slow.mcap", 1_000_000);
    stream.write_all(head.as_bytes()).unwrap();
    let response = Response::parse(&trickle(stream));
    assert_eq!(response.status, 408);
    assert!(response.text().ends_with("maximum 2 s)"), "{}", response.text());
    watched.stop();
}

#[test]
fn the_wait_in_a_queue_is_limited() {
    let limits = Limits { queue_time: Duration::ZERO, ..Limits::default() };
    let watched = WatchedServer::with_limits("127.0.0.1", None, limits);
    let origin = format!("origin: http://{}", watched.host);
    // Unfinished uploads, which occupy the queue.
    let slow: Vec<_> = (0..2)
        .map(|_| {
            let mut stream = watched.connect();
            let head = head(&watched, "/api/recordings?name=slow.mcap", 1_000_000);
            stream.write_all(head.as_bytes()).unwrap();
            stream
        })
        .collect();
    let rejected = wait_for("a full queue", || {
        let response = watched.send("POST", "/api/recordings?name=a.mcap", &[&origin], b"?");
        (response.status == 503).then_some(response)
    });
    assert_eq!(rejected.text(), "the server is busy with other uploads (try again later)");
    drop(slow);
    wait_for("a free slot in the queue", || {
        let response = watched.send("POST", "/api/recordings?name=a.mcap", &[&origin], b"?");
        (response.status == 400).then_some(())
    });
    watched.stop();
}

#[test]
fn requests_that_wait_for_a_mouse_to_stop_delay_no_others() {
    let control = Arc::new(MouseControl::new(Pace::UNLIMITED, Some("mouse".into())));
    control.next_run(false);
    let limits = Limits { stop_time: TIMEOUT, ..Limits::default() };
    let watched = WatchedServer::with_mouse("127.0.0.1", None, limits, Arc::clone(&control));
    let send = |path: &str, body: &str| {
        let mut stream = watched.connect();
        let head =
            head(&watched, path, body.len()).replace("\r\n\r\n", "\r\nconnection: close\r\n\r\n");
        stream.write_all((head + body).as_bytes()).unwrap();
        stream
    };
    let mut waiting: Vec<_> = (0..5).map(|_| send("/api/mouse", r#"{"action":"stop"}"#)).collect();
    waiting.extend((0..5).map(|_| send("/api/maze", r#"{"path":"closed.txt"}"#)));
    wait_for("the stop", || control.wait_for_stop(Duration::ZERO));
    // The mouse takes its time.
    assert_eq!(watched.act(&json!({"action": "pause"})).status, 204);
    assert_eq!(watched.get("/api/mazes").status, 200);
    assert!(control.is_own_running());
    control.end(Outcome::default());
    for stream in waiting {
        let status = within("the reply", || Response::read(stream).status);
        assert!(matches!(status, 200 | 204), "{status}");
    }
    watched.stop();
}

/// The time limit for the next header does not apply while a response is being sent.
#[test]
fn event_streams_do_not_time_out() {
    let limits = Limits { header_time: Duration::from_millis(50), ..limits(2) };
    let watched = WatchedServer::with_limits("127.0.0.1", None, limits);
    // A busy machine may take longer to send the request.
    let mut stream = wait_for("an event stream", || {
        let mut stream = watched.connect();
        write!(stream, "GET /events HTTP/1.1\r\nhost: {}\r\n\r\n", watched.host).ok()?;
        matches!(stream.read(&mut [0; 1]), Ok(1)).then_some(stream)
    });
    // Another connection reaches the time limit.
    let mut silent = watched.connect();
    assert_eq!(silent.read_to_end(&mut Vec::new()).unwrap(), 0);
    watched.send_states(1);
    let mut received = Vec::new();
    stream.set_read_timeout(Some(TIMEOUT)).unwrap();
    wait_for("the state", || {
        let mut buffer = [0; 4096];
        let count = stream.read(&mut buffer).unwrap();
        assert_ne!(count, 0, "the stream ended");
        received.extend_from_slice(&buffer[..count]);
        String::from_utf8_lossy(&received).contains(r#""states":1"#).then_some(())
    });
    watched.stop();
}

/// Clients that hold idle connections and event streams, and reconnect when they lose them, cannot
/// close the page.
#[test]
fn the_page_stays_open_to_all() {
    let limits = Limits { streams: 4, connections: 8, ..Limits::default() };
    let watched = WatchedServer::with_limits("127.0.0.1", None, limits);
    let (host, is_stopping) = (watched.host.clone(), Arc::new(AtomicBool::new(false)));
    let attackers: Vec<_> = (0..16)
        .map(|number| {
            let (host, is_stopping) = (host.clone(), Arc::clone(&is_stopping));
            thread::spawn(move || {
                while !is_stopping.load(Ordering::Relaxed) {
                    let Ok(mut stream) = TcpStream::connect(&host) else { continue };
                    let _ = stream.set_read_timeout(Some(Duration::from_millis(500)));
                    if number % 2 == 0 {
                        let _ = write!(stream, "GET /events HTTP/1.1\r\nhost: {host}\r\n\r\n");
                    }
                    // Holds the connection until the server closes it.
                    while !is_stopping.load(Ordering::Relaxed)
                        && !matches!(stream.read(&mut [0; 4096]), Ok(0))
                    {}
                }
            })
        })
        .collect();
    let page = watched.get("/");
    let cookie = page.head.split("set-cookie: ").nth(1).unwrap().split(';').next().unwrap();
    let cookie = format!("cookie: {cookie}");
    let mut events = wait_for("the event stream", || {
        let mut stream = watched.connect();
        write!(stream, "GET /events HTTP/1.1\r\nhost: {host}\r\n{cookie}\r\n\r\n").ok()?;
        let mut status = [0; 12];
        stream.read_exact(&mut status).ok()?;
        (&status == b"HTTP/1.1 200").then_some(stream)
    });
    for _ in 0..10 {
        assert_eq!(watched.send("GET", "/api/page", &[&cookie], b"").status, 200);
    }
    watched.send_states(1);
    let mut received = Vec::new();
    wait_for("the state", || {
        let mut buffer = [0; 4096];
        let count = events.read(&mut buffer).unwrap();
        assert_ne!(count, 0, "the page has lost its event stream");
        received.extend_from_slice(&buffer[..count]);
        String::from_utf8_lossy(&received).contains(r#""states":1"#).then_some(())
    });
    is_stopping.store(true, Ordering::Relaxed);
    watched.stop();
    for attacker in attackers {
        attacker.join().unwrap();
    }
}
