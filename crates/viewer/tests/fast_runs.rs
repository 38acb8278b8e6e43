//! The fast runs that the page plays.

mod harness;

use std::io::Cursor;
use std::net::TcpStream;

use harness::{CLOSED, Response, SMALL, WatchedServer, stop_viewer};
use mmsim_fastrun::{Vehicle, fastest};
use mmsim_maze::Maze;
use mmsim_recording::{Recording, save};
use mmsim_server::Simulation;
use mmsim_tests::{TIMEOUT, ask, connect};
use mmsim_viewer::{Viewer, ViewerConfig};
use serde_json::{Value, json};

/// Asserts that two numbers are equal to millionths.
fn assert_near(found: &Value, expected: f64) {
    assert!((found.as_f64().unwrap() - expected).abs() < 1e-6, "{found} {expected}");
}

#[test]
fn the_runs_are_those_of_the_crate() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let page = watched.get("/api/page").json();
    assert_eq!(page["vehicles"], json!(Vehicle::PRESETS));
    let maze: Maze = SMALL.parse().unwrap();
    for name in Vehicle::PRESETS {
        let vehicle = Vehicle::preset(name).unwrap();
        let best = fastest(maze.walls(), maze.start().cell, maze.goals(), &vehicle).unwrap();
        let trajectory = best.drive(&vehicle).unwrap();
        let runs = watched.get(&format!("/api/sources/live/fast-runs/{name}?run=1")).json();
        let routes: Vec<_> = runs.as_array().unwrap().iter().map(|run| &run["route"]).collect();
        assert_eq!(routes, ["fastest", "fewest-cells", "fewest-turns"]);
        for run in runs.as_array().unwrap() {
            assert_eq!(run["error"], json!(null));
            assert!(run["timed_run"]["time_s"].as_f64().unwrap() > trajectory.duration() - 1e-6);
        }
        let run = &runs[0]["timed_run"];
        assert_eq!(run["moves"], best.to_string());
        assert_near(&run["time_s"], trajectory.duration());
        assert_near(&run["gate_to_gate_s"], trajectory.gate_to_gate(maze.goals()));
        assert_near(&run["length_mm"], trajectory.length());
        assert_eq!(
            (&run["cell_count"], &run["slalom_turns"]),
            (&json!(4), &json!(best.turns().len()))
        );
        assert_eq!(run["half_cell_mm"], json!(vehicle.half_cell()));
        let segments = run["segments"].as_array().unwrap();
        assert_eq!(segments.len(), trajectory.segments().len());
        for (shown, segment) in segments.iter().zip(trajectory.segments()) {
            let entry = &segment.entry;
            for (key, expected) in [
                ("start_s", entry.time),
                ("distance_mm", entry.distance),
                ("x_mm", entry.x),
                ("y_mm", entry.y),
                ("heading_rad", entry.heading),
                ("entry_speed_mm_s", entry.speed),
                ("duration_s", segment.duration),
                ("length_mm", segment.length),
                ("exit_speed_mm_s", segment.exit_speed),
            ] {
                assert_near(&shown[key], expected);
            }
            assert_eq!(shown["pieces"].as_array().unwrap().len(), segment.pieces.len());
        }
        assert!(segments[1]["turn"].as_str().unwrap().ends_with('R'));
        assert!(segments[1]["angle_rad"].as_f64().unwrap() < 0.0);
        assert_eq!(segments[0]["turn"], json!(null));
    }
    watched.stop();
}

#[test]
fn requests_without_an_answer_are_explained() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let reply = |path: &str| {
        let reply = watched.get(&format!("/api/sources/{path}"));
        (reply.status, reply.text().to_string())
    };
    let unknown = "no vehicle has the name \"tank\" (expected ukmars, ares, expert, kerise)";
    assert_eq!(reply("live/fast-runs/tank?run=1"), (404, unknown.into()));
    assert_eq!(reply("live/mouse-fast-runs/tank?run=1&at=0"), (404, unknown.into()));
    assert_eq!(reply("live/fast-runs/expert?run=2").0, 410);
    assert_eq!(reply("live/mouse-fast-runs/expert?run=2&at=0").0, 410);
    assert_eq!(reply("live/fast-runs/expert").0, 400);
    assert_eq!(reply("7/fast-runs/expert?run=0").0, 404);
    assert_eq!(reply("live/mouse-fast-runs/expert?run=1&at=0").0, 404);
    // GET changes nothing, and there is nothing to change.
    assert_eq!(watched.post("/api/sources/live/fast-runs/expert?run=1", &json!({})).status, 405);

    let loaded = watched.post("/api/maze", &json!({ "path": "closed.txt" })).json();
    let runs = watched.get(&format!("/api/sources/live/fast-runs/expert?run={}", loaded["run"]));
    let reason = "Goal unreachable: the start at (0, 0) has walls on all sides.";
    for run in runs.json().as_array().unwrap() {
        assert_eq!((&run["timed_run"], &run["error"]), (&json!(null), &json!(reason)));
    }
    watched.stop();
}

#[test]
fn the_run_over_known_walls_follows_what_the_mouse_has_read() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let client = connect(&watched.server, zmq::REQ);
    let known = |at: usize| {
        watched.get(&format!("/api/sources/live/mouse-fast-runs/ares?run=1&at={at}")).json()[0]
            .clone()
    };
    let mut cells = [0; 6];
    // The mouse reads the walls of one cell after the other, on its way to the goal.
    for (at, (x, y, walls)) in
        [(0, 0, 14), (0, 1, 24), (1, 1, 20), (2, 1, 18), (2, 0, 14)].into_iter().enumerate()
    {
        assert_eq!(ask(&client, &[b'W', x, y, b'N']).len(), 3);
        cells[usize::from(y) * 3 + usize::from(x)] = walls + 1;
        let state = [b"S", &[x, y][..], b"NC\0\0\0\0\0\0C", &cells].concat();
        assert_eq!(ask(&client, &state), b"ok", "{at}");
    }
    let first = known(0);
    assert_eq!((&first["route"], &first["timed_run"]), (&json!("known-walls"), &json!(null)));
    let unknown = "The mouse does not know a path to the goal in this state.";
    assert_eq!(first["error"], unknown);
    let last = known(4);
    assert_eq!((&last["error"], &last["timed_run"]["cell_count"]), (&json!(null), &json!(4)));
    let runs = watched.get("/api/sources/live/fast-runs/ares?run=1").json();
    assert_eq!(last["timed_run"], runs[0]["timed_run"]);
    watched.stop();
}

#[test]
fn a_run_in_the_log_is_a_route() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let client = connect(&watched.server, zmq::REQ);
    let mut cells = [0; 6];
    cells[0] = 15;
    let state = [b"S\0\0NC\0\0\0\0\0\0C", &cells[..]].concat();
    let log = |line: &str| {
        let length = u16::try_from(line.len()).unwrap().to_le_bytes();
        assert_eq!(ask(&client, &[b"AL", &length[..], line.as_bytes()].concat()), b"ok");
        assert_eq!(ask(&client, &state), b"ok");
    };
    for line in ["hello", "fast run: N 1 s90R 2 s90R 1", "fast run: N 255", "fast run: x"] {
        log(line);
    }
    let driven = |at: usize, vehicle: &str| {
        let path = format!("/api/sources/live/mouse-fast-runs/{vehicle}?run=1&at={at}");
        watched.get(&path).json()[1].clone()
    };
    assert_eq!(driven(0, "expert"), json!(null));
    for (vehicle, text) in
        [("expert", "N 1 s90R@1050 2 s90R@1050 1"), ("ukmars", "N 1 s90R@500 2 s90R@500 1")]
    {
        let run = driven(1, vehicle);
        assert_eq!((&run["route"], &run["timed_run"]["moves"]), (&json!("driven"), &json!(text)));
    }
    for (at, error) in [(2, "the run leaves the lattice"), (3, "word 1: expected a direction")] {
        assert!(driven(at, "expert")["error"].as_str().unwrap().starts_with(error), "{at}");
    }
    watched.stop();
}

#[test]
fn a_recording_without_the_true_maze_has_no_such_runs() {
    let simulation = Simulation::new("closed", CLOSED.parse().unwrap());
    let mut file = Cursor::new(Vec::new());
    save(&mut file, &simulation.info(), None, [(0, "", ""); 0], &simulation.trailing()).unwrap();
    let recording = Recording::read(&file.into_inner()[..]).unwrap();
    let viewer = Viewer::bind("127.0.0.1", 0).unwrap();
    let viewer = viewer.spawn(ViewerConfig::default().with_recording("r", recording)).unwrap();
    let host = viewer.address().trim_start_matches("http://").to_string();
    let get = |path: &str| {
        let mut stream = TcpStream::connect(&host).unwrap();
        stream.set_read_timeout(Some(TIMEOUT)).unwrap();
        let request = format!("GET {path} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n\r\n");
        std::io::Write::write_all(&mut stream, request.as_bytes()).unwrap();
        Response::read(stream)
    };
    let reply = get("/api/sources/1/fast-runs/expert?run=0");
    let expected = "the recording does not contain the true maze";
    assert_eq!((reply.status, reply.text()), (409, expected));
    stop_viewer(viewer);
}
