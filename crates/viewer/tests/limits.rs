//! Clients that never finish: none of them holds a connection of the page for ever.

mod harness;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread;
use std::time::Duration;

use harness::{Reply, Watched};
use mmsim_tests::{PATIENCE, wait_for};
use mmsim_viewer::Limits;

/// Limits that are soon reached, with this many connections.
fn limits(connections: usize) -> Limits {
    let soon = Duration::from_secs(2);
    Limits { connections, header_time: soon, max_lag: soon, ..Limits::default() }
}

fn head(watched: &Watched, path: &str, length: usize) -> String {
    let host = &watched.host;
    format!(
        "POST {path} HTTP/1.1\r\nhost: {host}\r\norigin: http://{host}\r\n\
         content-type: application/json\r\ncontent-length: {length}\r\n\r\n"
    )
}

/// Sends a byte now and then until the server closes the connection; returns its reply.
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
    let mut reply = Vec::new();
    // The last byte may have come after the end, which resets the connection.
    let _ = stream.read_to_end(&mut reply);
    let _ = stop.send(());
    sender.join().unwrap();
    reply
}

#[test]
fn a_body_that_never_ends_is_refused() {
    let watched = Watched::with_limits("127.0.0.1", None, limits(2));
    let slow: Vec<_> = ["/api/maze", "/api/mouse/run"]
        .map(|path| {
            let mut stream = watched.connect();
            stream.write_all(head(&watched, path, 60_000).as_bytes()).unwrap();
            thread::spawn(|| trickle(stream))
        })
        .into();
    assert_eq!(watched.get("/").status, 200, "there is room again");
    for slow in slow {
        let reply = Reply::parse(&slow.join().unwrap());
        assert_eq!(reply.status, 408);
        assert_eq!(
            reply.text(),
            "the request arrived too slowly: expected at least 65536 bytes per second, and all of \
             it within 600 s"
        );
    }
    watched.stop();
}

#[test]
fn a_header_that_never_ends_closes_its_connection() {
    let watched = Watched::with_limits("127.0.0.1", None, limits(1));
    let mut stream = watched.connect();
    stream.write_all(b"GET / HTTP/1.1\r\nx: ").unwrap();
    let slow = thread::spawn(|| trickle(stream));
    assert_eq!(watched.get("/").status, 200);
    assert_eq!(slow.join().unwrap(), b"");
    watched.stop();
}

#[test]
fn unread_replies_close_their_connection() {
    let watched = Watched::with_limits("127.0.0.1", None, limits(1));
    let mut stream = watched.connect();
    let request = format!("GET /page.css HTTP/1.1\r\nhost: {}\r\n\r\n", watched.host);
    // More than the system holds for a client that does not read.
    let requests = request.repeat(2000);
    let mut sending = stream.try_clone().unwrap();
    let sender = thread::spawn(move || sending.write_all(requests.as_bytes()));
    assert_eq!(watched.get("/").status, 200);
    // What was on its way still comes, and then the end.
    while stream.read(&mut [0; 1 << 12]).is_ok_and(|count| count > 0) {}
    let _ = sender.join().unwrap();
    watched.stop();
}

#[test]
fn slow_uploads_make_way_for_others() {
    let watched = Watched::with_limits("127.0.0.1", None, limits(10));
    watched.states(3);
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
    let good = watched.send("POST", "/api/recordings?name=good.mcap", &[&origin], &saved);
    assert_eq!(good.json(), serde_json::json!({"id": "1"}));
    for slow in slow {
        assert_eq!(Reply::parse(&slow.join().unwrap()).status, 408);
    }
    watched.stop();
}

#[test]
fn an_upload_ends_however_little_it_lags() {
    let limits =
        Limits { body_time: Duration::from_secs(2), max_lag: 10 * PATIENCE, ..Limits::default() };
    let watched = Watched::with_limits("127.0.0.1", None, limits);
    let mut stream = watched.connect();
    let head = head(&watched, "/api/recordings?name=slow.mcap", 1_000_000);
    stream.write_all(head.as_bytes()).unwrap();
    let reply = Reply::parse(&trickle(stream));
    assert_eq!(reply.status, 408);
    assert!(reply.text().ends_with("and all of it within 2 s"), "{}", reply.text());
    watched.stop();
}

#[test]
fn waiting_too_long_for_a_turn_is_refused() {
    let limits = Limits { queue_time: Duration::ZERO, ..Limits::default() };
    let watched = Watched::with_limits("127.0.0.1", None, limits);
    let origin = format!("origin: http://{}", watched.host);
    // They are received until they end.
    let slow: Vec<_> = (0..2)
        .map(|_| {
            let mut stream = watched.connect();
            let head = head(&watched, "/api/recordings?name=slow.mcap", 1_000_000);
            stream.write_all(head.as_bytes()).unwrap();
            stream
        })
        .collect();
    let refused = wait_for("both to be received", || {
        let reply = watched.send("POST", "/api/recordings?name=a.mcap", &[&origin], b"?");
        (reply.status == 503).then_some(reply)
    });
    assert_eq!(refused.text(), "the server is busy with other uploads (try again later)");
    drop(slow);
    wait_for("room for an upload", || {
        let reply = watched.send("POST", "/api/recordings?name=a.mcap", &[&origin], b"?");
        (reply.status == 400).then_some(())
    });
    watched.stop();
}

/// An event stream lasts as long as its page reads it, although nothing more is asked.
#[test]
fn an_event_stream_has_no_end() {
    let limits = Limits { header_time: Duration::from_millis(50), ..limits(2) };
    let watched = Watched::with_limits("127.0.0.1", None, limits);
    let mut stream = watched.connect();
    write!(stream, "GET /events HTTP/1.1\r\nhost: {}\r\n\r\n", watched.host).unwrap();
    thread::sleep(4 * limits.header_time);
    watched.states(1);
    let mut heard = Vec::new();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    wait_for("the state", || {
        let mut buffer = [0; 4096];
        let count = stream.read(&mut buffer).unwrap();
        assert_ne!(count, 0, "the stream has ended");
        heard.extend_from_slice(&buffer[..count]);
        String::from_utf8_lossy(&heard).contains(r#""states":1"#).then_some(())
    });
    watched.stop();
}
