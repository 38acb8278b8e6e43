//! The HTTP API.

mod harness;

use std::io::{Read, Write};
use std::net::TcpStream;

use flate2::read::GzDecoder;
use harness::{WatchedServer, stop_viewer};
use mmsim_maze::{Cell, Heading, Pose};
use mmsim_run::{MovementRules, Phases, Trail};
use mmsim_tests::{ask, connect, stop, wait_for};
use serde_json::{Value, json};

#[test]
fn states_are_returned_unchanged() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let sent = watched.send_states(600);
    let range = |from: usize, count: usize| {
        watched.get(&format!("/api/sources/live/states?run=1&from={from}&count={count}")).body
    };
    for (from, count) in
        [(0, 1), (255, 2), (256, 256), (200, 256), (599, 1), (599, 256), (500, 100)]
    {
        let expected = sent[from..(from + count).min(600)].concat();
        assert_eq!(range(from, count), expected, "{from} {count}");
    }
    assert_eq!(range(0, 100_000), sent[..256].concat());
    let missing = watched.get("/api/sources/live/states?run=1&from=600");
    assert_eq!((missing.status, missing.text()), (404, "state 600 does not exist"));
    let huge = usize::MAX;
    assert_eq!(
        watched.get(&format!("/api/sources/live/states?run=1&from={huge}&count={huge}")).status,
        404
    );
    for resource in [
        "states?run=7&from=0",
        "moment?run=7&at=0",
        "costs?run=7",
        "recording.mcap?run=7",
        "drawing.svg?run=7",
        "picture.svg?run=7",
    ] {
        assert_eq!(watched.get(&format!("/api/sources/live/{resource}")).status, 410, "{resource}");
    }
    for resource in [
        "states",
        "states?run=1",
        "states?run=x&from=0",
        "states?run=1&from=-1",
        "moment?run=1&at=1e3",
    ] {
        assert_eq!(watched.get(&format!("/api/sources/live/{resource}")).status, 400, "{resource}");
    }
    for id in ["1", "lively", "%2e%2e", "-1"] {
        assert_eq!(watched.get(&format!("/api/sources/{id}")).status, 404);
    }
    watched.stop();
}

/// Tests that a history can be read while it grows.
#[test]
fn new_states_of_a_cached_block_are_returned() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let (mut sent, mut states) = (Vec::new(), 0);
    for more in [250, 3, 1, 6, 240, 20] {
        sent.extend(watched.send_states(more));
        states += more;
        let at = states - 1;
        let view = watched.get(&format!("/api/sources/live/moment?run=1&at={at}")).json();
        let (mut trail, mut phases) = (Trail::new(harness::maze().size()), Phases::default());
        let rules = MovementRules::from_maze(&harness::maze());
        for state in &sent {
            let heading = Heading::from_letter(state[3].into()).unwrap();
            let pose = Pose::new(Cell::new(state[1], state[2]), heading);
            phases.add(&rules, pose, false);
            trail.add(&rules, &phases);
        }
        let passages = trail
            .passages()
            .into_iter()
            .map(|Pose { cell, heading }| 4 * (3 * cell.y + cell.x) + heading as u8);
        assert_eq!(view["trail"], json!(passages.collect::<Vec<_>>()), "{states}");
        for from in [0, 245, 256_usize.min(at)] {
            let path = format!("/api/sources/live/states?run=1&from={from}&count=256");
            let expected = sent[from..(from + 256).min(states)].concat();
            assert_eq!(watched.get(&path).body, expected, "{from} of {states}");
        }
    }
    watched.stop();
}

#[test]
fn pictures_can_be_downloaded() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let early = watched.get("/api/sources/live/animation.gif?run=1");
    assert_eq!((early.status, early.text()), (409, "cannot animate the run: it has no states yet"));
    assert!(watched.get("/api/sources/live/picture.svg?run=1").text().starts_with("<svg"));
    watched.send_states(9);
    for (picture, kind, prefix) in [
        ("picture.svg?at=7", "svg+xml", &b"<svg"[..]),
        ("picture.png?at=7&theme=dark&heat=true&numbers=false", "png", b"\x89PNG"),
        ("animation.gif?trail=false", "gif", b"GIF89a"),
    ] {
        let separator = if picture.contains('?') { '&' } else { '?' };
        let response = watched.get(&format!("/api/sources/live/{picture}{separator}run=1"));
        assert!(response.body.starts_with(prefix), "{picture}: {}", response.status);
        assert!(response.head.contains(&format!("content-type: image/{kind}")));
        assert!(response.head.contains("content-disposition: attachment; filename=\"small."));
    }
    let invalid = "/api/sources/live/picture.svg?run=1&at=7&theme=blue";
    assert_eq!(watched.get(invalid).status, 400);
    let thumbnail = watched.get("/api/mazes/picture.svg?path=a/small.txt");
    assert!(thumbnail.text().starts_with("<svg") && thumbnail.body.len() < 1500);
    assert_eq!(watched.get("/api/mazes/picture.svg?path=../small.txt").status, 404);
    watched.stop();
}

/// What a client gets that sends an `Accept-Encoding` field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Coding {
    Gzip,
    Identity,
    NotAcceptable,
}

/// The rules are those of RFC 9110, section 12.5.3. The server can send gzip or no coding
/// (`identity`), and prefers gzip.
#[test]
fn the_content_coding_is_the_one_that_the_client_prefers() {
    use Coding::{Gzip, Identity, NotAcceptable};
    let watched = WatchedServer::new("127.0.0.1", None);
    let plain = watched.get("/page.css").body;
    for (fields, expected) in [
        (&[][..], Identity),
        (&[""], Identity),
        (&["gzip"], Gzip),
        (&["GZIP"], Gzip),
        (&["x-gzip"], Gzip),
        (&["gzip, deflate, br, zstd"], Gzip),
        (&["br", "gzip"], Gzip),
        (&["identity", "deflate;q=0.5", "gzip"], Gzip),
        (&["br"], Identity),
        (&["xgzip"], Identity),
        (&["*"], Gzip),
        (&["br;q=1, *;q=0.1"], Gzip),
        (&["*;q=0, gzip"], Gzip),
        (&["gzip;q=0"], Identity),
        (&["gzip; q=0.000, deflate"], Identity),
        (&["gzip;q=0, *"], Identity),
        (&["gzip", "identity;q=0.5"], Gzip),
        (&["gzip;q=0.1"], Gzip),
        (&["gzip ; Q=0.001"], Gzip),
        (&["gzip;q=0.1, identity;q=1"], Identity),
        (&["gzip;q=0.1, identity"], Identity),
        (&["gzip;q=0.5, *;q=0.7"], Identity),
        (&["identity;q=0.5, *;q=0.7"], Gzip),
        (&["identity;q=0, gzip"], Gzip),
        (&["identity;q=0, gzip;q=0.1"], Gzip),
        (&["identity;q=0, *"], Gzip),
        (&["identity, *;q=0"], Identity),
        (&["identity;q=0"], NotAcceptable),
        (&["identity;q=0, br"], NotAcceptable),
        (&["*;q=0"], NotAcceptable),
        // Invalid weights are ignored, together with their codings.
        (&["gzip;x"], Identity),
        (&["gzip;q=2"], Identity),
        (&["gzip;q=-1, *;q=x"], Identity),
    ] {
        let fields: Vec<_> =
            fields.iter().map(|field| format!("accept-encoding: {field}")).collect();
        let fields: Vec<&str> = fields.iter().map(String::as_str).collect();
        let response = watched.send("GET", "/page.css", &fields, b"");
        let is_packed = response.head.contains("\r\ncontent-encoding: gzip\r\n");
        let found = match (response.status, is_packed) {
            (200, true) => Gzip,
            (200, false) => Identity,
            (406, false) => NotAcceptable,
            other => panic!("{other:?} for {fields:?}"),
        };
        assert_eq!(found, expected, "{fields:?}");
        assert!(response.head.contains("\r\nvary: accept-encoding\r\n"), "{fields:?}");
        if is_packed {
            assert!(!response.head.contains("content-length"));
            assert!(response.body.len() < plain.len() / 2);
            let mut unpacked = Vec::new();
            GzDecoder::new(&response.body[..]).read_to_end(&mut unpacked).unwrap();
            assert_eq!(unpacked, plain);
        }
    }
    watched.stop();
}

#[test]
fn only_long_texts_are_compressed() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let check = |path: &str, is_packed: bool| {
        let mut stream = watched.connect();
        let host = &watched.host;
        write!(stream, "GET {path} HTTP/1.1\r\nhost: {host}\r\naccept-encoding: gzip\r\n\r\n")
            .unwrap();
        let mut head = Vec::new();
        // The events never end.
        while !head.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).unwrap();
            head.push(byte[0]);
        }
        let head = String::from_utf8(head).unwrap();
        assert!(head.starts_with("HTTP/1.1 200 OK\r\n"), "{path}: {head}");
        assert_eq!(head.contains("\r\ncontent-encoding: gzip\r\n"), is_packed, "{path}: {head}");
        assert_eq!(head.contains("\r\nvary: accept-encoding\r\n"), is_packed, "{path}: {head}");
    };
    watched.send_states(9);
    for path in ["picture.png?run=1&at=7", "animation.gif?run=1", "recording.mcap?run=1"] {
        check(&format!("/api/sources/live/{path}"), false);
    }
    watched.send_states(247);
    for (path, is_packed) in [
        ("/", true),
        ("/map.js", true),
        ("/drawing.json", true),
        ("/api/sources/live/picture.svg?run=1&at=7", true),
        ("/api/sources/live/states?run=1&from=0&count=256", false),
        ("/api/mazes", false),
        ("/events", false),
    ] {
        check(path, is_packed);
    }
    watched.stop();
}

#[test]
fn only_listed_mazes_can_be_loaded() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let list = watched.get("/api/mazes").json();
    let paths: Vec<_> =
        list.as_array().unwrap().iter().map(|maze| maze["path"].as_str().unwrap()).collect();
    assert_eq!(paths, ["a/small.txt", "closed.txt", "invalid.txt"]);
    watched.send_states(2);
    for path in ["../a/small.txt", "small.txt", "/etc/passwd", ""] {
        assert_eq!(watched.post("/api/maze", &json!({"path": path})).status, 404);
    }
    let invalid = watched.post("/api/maze", &json!({"path": "invalid.txt"}));
    assert!(invalid.status == 500 && invalid.text().contains("invalid.txt: line 1"));
    assert_eq!(watched.get("/api/sources/live").json()["states"], 2, "the run continues");
    let loaded = watched.post("/api/maze", &json!({"path": "closed.txt"}));
    assert_eq!(loaded.json(), json!({"run": 2}));
    let source = watched.get("/api/sources/live").json();
    assert_eq!(
        (&source["title"], &source["states"], &source["shortest_path"]),
        (&json!("closed"), &json!(0), &json!(null))
    );
    stop_viewer(watched.viewer);
    assert_eq!(stop(watched.server).info().maze, "closed");
}

#[test]
fn a_maze_file_is_read_and_then_loaded() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let origin = format!("origin: http://{}", watched.host);
    let read =
        |content: &[u8]| watched.send("POST", "/api/mazes/read?name=a.num", &[&origin], content);
    let file = read(b"0 0 1 0 1 1\n1 0 1 1 1 0\n").json();
    let reading = &file["readings"][0];
    let drawing = "o---o---o\n|SG   G |\no---o---o\n";
    assert_eq!(
        (&file["maze"], &reading["width"], &reading["drawing"]),
        (&json!("a"), &json!(2), &json!(drawing))
    );
    assert!(reading["picture"].as_str().unwrap().starts_with("<svg"));
    assert_eq!(watched.get("/api/sources/live").json()["title"], "small", "only read");
    assert_eq!(read(b"rubbish").status, 400);
    assert_eq!(read(&vec![b'o'; 64 * 1024 + 1]).status, 413);
    assert_eq!(watched.send("GET", "/api/mazes/read?name=a", &[], b"").status, 405);
    let foreign = watched.send("POST", "/api/mazes/read?name=a", &["origin: http://evil"], b"");
    assert_eq!(foreign.status, 403);
    let load = |text: &str| watched.post("/api/maze", &json!({"maze": "a\u{1b}", "drawing": text}));
    assert_eq!(load("rubbish").status, 400);
    for choice in
        [json!({}), json!({"maze": "a"}), json!({"path": "a", "maze": "a", "drawing": "a"})]
    {
        let refused = watched.post("/api/maze", &choice);
        assert_eq!(refused.status, 400, "{choice}");
        assert_eq!(refused.body, b"expected a path, or a maze and a drawing", "{choice}");
    }
    assert_eq!(load(drawing).json(), json!({"run": 2}));
    assert_eq!(watched.get("/api/sources/live").json()["title"], "a");
    watched.stop();
}

#[test]
fn saved_runs_can_be_opened() {
    let folder = tempfile::tempdir().unwrap();
    let watched = WatchedServer::new("127.0.0.1", Some(folder.path()));
    let sent = watched.send_states(300);
    let saved = watched.get("/api/sources/live/recording.mcap?run=1");
    assert!(
        saved.head.contains("content-disposition: attachment; filename=\"small.mcap\""),
        "{}",
        saved.head
    );
    let origin = format!("origin: http://{}", watched.host);
    let upload =
        |body: &[u8]| watched.send("POST", "/api/recordings?name=own.mcap", &[&origin], body);
    assert_eq!(upload(&saved.body).json(), json!({"id": "1"}));
    let source = watched.get("/api/sources/1").json();
    assert_eq!(
        (&source["run"], &source["states"], &source["integrity"]),
        (&json!(0), &json!(300), &json!("closed"))
    );
    assert_eq!(
        watched.get("/api/sources/1/states?run=0&from=0&count=256").body,
        sent[..256].concat()
    );
    let invalid = upload(b"invalid");
    assert_eq!(invalid.status, 400);
    assert!(
        invalid.text().starts_with("own.mcap: expected a description of the maze"),
        "{}",
        invalid.text()
    );

    let listed = watched.get("/api/recordings").json();
    let name = listed[0]["name"].as_str().unwrap();
    assert!(name.ends_with("_small_0001.mcap"), "{name}");
    assert_eq!(
        watched.post("/api/recordings/open", &json!({"name": name})).json(),
        json!({"id": "2"})
    );
    let source = watched.get("/api/sources/2").json();
    assert_eq!((&source["states"], &source["integrity"]), (&json!(300), &json!("cut")));
    assert_eq!(watched.post("/api/recordings/open", &json!({"name": "../own.mcap"})).status, 404);
    for id in 3..=8 {
        assert_eq!(upload(&saved.body).json(), json!({"id": id.to_string()}));
    }
    assert_eq!(upload(&saved.body).status, 409, "the maximum number is open");
    assert_eq!(watched.post("/api/recordings/close", &json!({"id": "1"})).status, 204);
    assert_eq!(watched.get("/api/sources/1").status, 404);
    assert_eq!(upload(&saved.body).json(), json!({"id": "9"}));
    watched.stop();
}

#[test]
fn recordings_are_summarized_renamed_and_deleted() {
    let folder = tempfile::tempdir().unwrap();
    let watched = WatchedServer::new("127.0.0.1", Some(folder.path()));
    watched.send_states(4);
    let result = watched.get("/api/sources/live/result?run=1").json();
    assert_eq!((&result["steps_to_goal"], &result["shortest_path"]), (&Value::Null, &json!(4)));
    assert_eq!(result["repeated_steps"], 0);
    let listed = || watched.get("/api/recordings").json();
    let name = listed()[0]["name"].as_str().unwrap().to_string();
    let change =
        |what: &str, body: Value| watched.post(&format!("/api/recordings/{what}"), &body).status;
    assert_eq!(listed()[0]["being_written"], cfg!(unix));
    assert_eq!(change("delete", json!({"name": name})), 409, "it is being written");
    assert_eq!(change("rename", json!({"name": name, "to": "mine"})), 409);
    assert!(folder.path().join(&name).exists());

    let client = connect(&watched.server, zmq::REQ);
    assert_eq!(ask(&client, b"reset"), b"ok");
    assert_eq!(listed()[0]["being_written"], false);
    let summary = watched.get(&format!("/api/recordings/summary?name={name}")).json();
    let result = "goal not reached";
    assert_eq!(summary, json!({"mouse": null, "maze": "small", "result": result}));
    std::fs::write(folder.path().join("bad.mcap"), "bad").unwrap();
    let unreadable = watched.get("/api/recordings/summary?name=bad.mcap").json();
    assert!(unreadable["result"].as_str().unwrap().starts_with("expected a description"));

    assert_eq!(change("rename", json!({"name": name, "to": "../mine"})), 400);
    assert_eq!(change("rename", json!({"name": name, "to": "bad"})), 409, "the name is in use");
    assert_eq!(change("rename", json!({"name": name, "to": "mine"})), 204);
    assert_eq!(change("rename", json!({"name": name, "to": "other"})), 404);
    assert_eq!(change("delete", json!({"name": "../mine.mcap"})), 404);
    assert_eq!(change("delete", json!({"name": "bad.mcap"})), 204);
    let foreign = ["origin: http://evil.example", "content-type: application/json"];
    let body = br#"{"name":"mine.mcap"}"#;
    let refused = watched.send("POST", "/api/recordings/delete", &foreign, body);
    assert_eq!(refused.status, 403);
    assert_eq!(
        (&listed()[0]["name"], listed().as_array().unwrap().len()),
        (&json!("mine.mcap"), 1)
    );
    watched.stop();
}

#[test]
fn bundled_mice_search_the_maze() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let run = |strategy: &str| watched.act(&json!({"action": "run", "strategy": strategy}));
    let set_pace = |pace: Value| watched.act(&json!({"action": "set-pace", "pace": pace})).status;
    assert_eq!(set_pace(Value::Null), 204);
    assert_eq!(run("flood-fill").status, 204);
    wait_for("the last state", || {
        (watched.get("/api/sources/live").json()["states"] == 5).then_some(())
    });
    assert_eq!(set_pace(json!(0.01)), 204);
    wait_for("the search to end", || (run("flood-fill").status == 204).then_some(()));
    let twice = run("left-wall");
    assert_eq!((twice.status, twice.text()), (409, "flood-fill is still running (stop it first)"));
    assert_eq!(watched.act(&json!({"action": "stop"})).status, 204);
    let unknown = run("fly");
    assert!(unknown.status == 400 && unknown.text().contains("expected one of flood-fill"));
    for pace in [json!(0), json!(-1), json!(1e-3)] {
        assert_eq!(set_pace(pace), 400);
    }
    assert_eq!(watched.act(&json!({"action": "fly"})).status, 422);
    assert_eq!(watched.act(&json!({"action": "run-again"})).status, 409, "no mouse of its own");
    watched.stop();
}

#[test]
fn bundled_mice_do_not_disturb_a_client() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let run = || watched.act(&json!({"action": "run", "strategy": "flood-fill"}));
    let states = || watched.get("/api/sources/live").json()["states"].as_u64().unwrap();
    // A client counts as running while it is connected, however long it thinks.
    let searches =
        [&[&b"W\x00\x00N"[..]][..], &[b"reset"], &[&harness::state(0), &harness::state(1)]];
    for requests in searches {
        assert_eq!(ask(&connect(&watched.server, zmq::REQ), b"ping"), b"pong");
        let client = connect(&watched.server, zmq::REQ);
        for request in requests {
            ask(&client, request);
        }
        let refused = run();
        assert_eq!(refused.status, 409);
        let text = "another client is searching the maze";
        assert!(refused.text().starts_with(text), "{}", refused.text());
    }
    assert_eq!(states(), 2);
    wait_for("the client to disconnect", || (run().status == 204).then_some(()));
    wait_for("the mouse to replace the states", || (states() == 1).then_some(()));
    watched.stop();
}

/// Returns a function that waits until the stream of events has contained a text.
fn events(watched: &WatchedServer) -> impl FnMut(&str) + use<> {
    let mut stream = watched.connect();
    write!(stream, "GET /events HTTP/1.1\r\nhost: {}\r\n\r\n", watched.host).unwrap();
    let (mut received, mut buffer) = (String::new(), [0; 4096]);
    move |text| {
        while !received.contains(text) {
            let count = stream.read(&mut buffer).unwrap();
            assert_ne!(count, 0, "the stream ended before {text}: {received}");
            received += std::str::from_utf8(&buffer[..count]).unwrap();
        }
    }
}

#[test]
fn only_states_that_are_not_recorded_are_unsaved() {
    let folder = tempfile::tempdir().unwrap();
    for (recordings, unsaved) in [(None, 3), (Some(folder.path()), 0)] {
        let watched = WatchedServer::new("127.0.0.1", recordings);
        let mut wait_until_received = events(&watched);
        watched.send_states(3);
        wait_until_received(&format!(r#""states":3,"unsaved_states":{unsaved},"#));
        drop(wait_until_received);
        watched.stop();
    }
}

#[test]
fn changes_are_sent_as_events() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let mut wait_until_received = events(&watched);
    wait_until_received(concat!(
        r#","run":1,"states":0,"unsaved_states":0,"annotations":0,"maze":"a/small.txt","mouse_status":null,"pace":20.0,"paused":false,"#,
        r#""client":false,"recordings":2,"opened":[]}"#
    ));
    watched.send_states(3);
    wait_until_received(r#""states":3,"unsaved_states":3"#);
    assert_eq!(ask(&connect(&watched.server, zmq::REQ), b"At"), b"ok");
    wait_until_received(r#""annotations":1"#);
    watched.post("/api/maze", &json!({"path": "closed.txt"}));
    wait_until_received(
        r#","run":2,"states":0,"unsaved_states":0,"annotations":1,"maze":"closed.txt","mouse_status":null"#,
    );
    wait_until_received(r#""client":false"#);
    watched.act(&json!({"action": "pause"}));
    wait_until_received(r#""paused":true"#);
    wait_for("the client to count as ended", || {
        let run = json!({"action": "run", "strategy": "flood-fill"});
        (watched.act(&run).status == 204).then_some(())
    });
    wait_until_received(concat!(
        r#""mouse_status":{"mouse":"flood-fill","own":false,"kind":null,"reason":"","#,
        r#""outcome":{"goal_reached":false,"ending":"gave_up","error":"goal unreachable from (0, 0)","#,
    ));
    watched.stop();
}

#[test]
fn other_sites_can_neither_read_nor_control() {
    let watched = WatchedServer::new("127.0.0.1", None);
    watched.send_states(3);
    let post = |headers: &[&str]| {
        let headers = [headers, &["content-type: application/json"]].concat();
        watched.send("POST", "/api/maze", &headers, br#"{"path":"closed.txt"}"#).status
    };
    let own = format!("origin: http://{}", watched.host);
    let host = watched.host.replace("127.0.0.1", "evil.example");
    for headers in [
        &[][..],
        &["origin: http://evil.example"],
        &["origin: null"],
        &["origin: http://127.0.0.1"],
        &[&own, "sec-fetch-site: cross-site"],
        &[&format!("origin: http://{host}"), &format!("host: {host}")],
    ] {
        assert_eq!(post(headers), 403, "{headers:?}");
    }
    let form = [&*own, "content-type: application/x-www-form-urlencoded"];
    assert_eq!(watched.send("POST", "/api/maze", &form, b"path=closed.txt").status, 415);
    for path in ["/api/maze", "/api/mouse", "/api/recordings/close"] {
        assert_eq!(watched.get(path).status, 405, "{path} changes the state");
    }
    let rejected = watched.send("GET", "/api/mazes", &["origin: http://evil.example"], b"");
    assert_eq!(rejected.status, 403);
    let page = watched.get("/");
    for head in [&page.head, &rejected.head] {
        assert!(head.contains("content-security-policy: default-src 'none'; script-src 'self';"));
        assert!(
            head.contains("x-content-type-options: nosniff") && !head.contains("access-control")
        );
    }
    assert_eq!(watched.get("/api/sources/live").json()["states"], 3);
    watched.stop();
}

#[test]
fn the_token_is_required_on_other_addresses() {
    let watched = WatchedServer::new("0.0.0.0", None);
    let token = watched.viewer.address().split("?token=").nth(1).unwrap().to_string();
    assert_eq!(token.len(), 32);
    for path in [
        "/",
        "/api/mazes",
        "/events",
        "/page.js",
        "/?token=",
        "/?token=00000000000000000000000000000000",
    ] {
        let response = watched.get(path);
        assert_eq!(response.status, 401, "{path}");
        assert!(!response.head.contains(&token) && !response.text().contains(&token));
    }
    let redirect = watched.get(&format!("/?token={token}"));
    assert_eq!(redirect.status, 303);
    let cookie = redirect.head.lines().find_map(|line| line.strip_prefix("set-cookie: ")).unwrap();
    assert!(cookie.contains("httponly") && cookie.contains("samesite=lax"), "{cookie}");
    let cookie = format!("cookie: {}", cookie.split(';').next().unwrap());
    assert_eq!(watched.send("GET", "/api/mazes", &[&cookie], b"").status, 200);
    let own =
        [&*cookie, &format!("origin: http://{}", watched.host), "content-type: application/json"];
    assert_eq!(watched.send("POST", "/api/mouse", &own, br#"{"action":"stop"}"#).status, 204);
    let evil = [&*cookie, "origin: http://evil.example", "content-type: application/json"];
    assert_eq!(watched.send("POST", "/api/mouse", &evil, br#"{"action":"stop"}"#).status, 403);
    watched.stop();
}

#[test]
fn malformed_requests_and_idle_connections_are_harmless() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let idle: Vec<_> = (0..40).map(|_| TcpStream::connect(&watched.host).unwrap()).collect();
    for malformed in [
        &b"\r\n\r\n"[..],
        b"GET",
        b"\xff\xfe\x00",
        b"POST / HTTP/1.1\r\ncontent-length: 99999999999\r\n\r\n",
        &b"a".repeat(100_000),
    ] {
        let mut stream = TcpStream::connect(&watched.host).unwrap();
        let _ = stream.write_all(malformed);
    }
    let big = vec![b'x'; 1 << 20];
    assert!([400, 413].contains(
        &watched.post("/api/maze", &json!({"path": String::from_utf8(big).unwrap()})).status
    ));
    assert_eq!(watched.get("/").status, 200);
    assert_eq!(watched.get("/no-such").status, 404);
    drop(idle);
    watched.stop();
}
