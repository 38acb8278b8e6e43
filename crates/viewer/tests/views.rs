//! What the page shows about one state.

mod harness;

use harness::WatchedServer;
use mmsim_tests::{ask, connect};
use serde_json::json;

/// The first trail of a long run is computed from many blocks.
#[test]
fn the_trail_of_a_long_run_is_complete() {
    let watched = WatchedServer::new("127.0.0.1", None);
    // The mouse passes from (0, 0) to (2, 1) and is put back, again and again.
    let states = 20 * 256 + 3;
    watched.send_states(states);
    let view = |at: usize| watched.get(&format!("/api/sources/live/moment?run=1&at={at}")).json();
    for (at, passages) in [(5122, [17, 0, 13]), (5121, [13, 17, 0]), (5, [13, 17, 0])] {
        assert_eq!(view(at)["trail"], json!(passages), "{at}");
    }
    assert_eq!(watched.get("/api/sources/live/moment?run=1&at=18446744073709551615").status, 404);
    watched.stop();
}

#[test]
fn a_view_contains_the_figures_of_a_state() {
    let watched = WatchedServer::new("127.0.0.1", None);
    assert_eq!(watched.get("/api/sources/live/moment?run=1&at=0").status, 404);
    let source = watched.get("/api/sources/live").json();
    assert_eq!(
        source,
        json!({"id": "live", "run": 1, "title": "small", "maze": "small", "width": 3, "height": 2, "vehicle": "expert", "start": [0, 0],
            "goals": [[2, 0]], "states": 0, "state_bytes": 18, "truth": true, "shortest_path": 4, "route": [0, 3, 4, 5, 2],
            "mouse": null, "race_optimum": null, "integrity": null, "note": null})
    );
    let sent = watched.send_states(700);
    let view = watched.get("/api/sources/live/moment?run=1&at=6").json();
    // From (2, 1), the mouse is put back at the start.
    let ms = &view["phases"]["total"]["wall_time_s"];
    assert!(ms.as_f64().unwrap() >= 0., "{ms}");
    // 5 cells of 180 mm at 600 mm/s.
    let run = json!({"steps": 3 + 2, "turns": 0, "time_s": 1.5, "wall_time_s": ms});
    assert_eq!(
        view,
        json!({"at": 6, "states": 700, "annotations": 0, "state": sent[6],
            "phases": {"search_run": run, "return_run": null, "fast_run": null, "best_run": null,
                "total": run, "fast_runs": 0, "restarts": 1, "jumps": 0},
            "leg": [0, 5], "sentence": "Searching for the goal. The shortest path has at least 4 steps.",
            "fastest_run": {"vehicle": "expert", "known_run_time_s": null, "fastest_run_lower_bound_s": view["fastest_run"]["fastest_run_lower_bound_s"],
                "fastest_run_proven": false},
            "goal_reached": false, "error": null, "trial": null, "event": null, "visited_cells": 1, "unknown_walls": [],
            "optimistic_distance": 4, "pessimistic_distance": null, "proven": false,
            // Passages from (1, 1) to the east, (0, 0) to the north and (0, 1) to the east. Being put
            // back leaves no trail.
            "trail": [17, 0, 13], "plan": [4, 3],
            "mouse": null, "strategy": null, "texts": [], "colours": "", "declared_walls": [], "missed_walls": []})
    );
    let view = watched.get("/api/sources/live/moment?run=1&at=4").json();
    assert_eq!(view["event"], "restart");
    let view = watched.get("/api/sources/live/moment?run=1&at=699").json();
    assert_eq!(view["trail"], json!([0, 13, 17]));
    assert_eq!(view["phases"]["restarts"], 174);
    let events = watched.get("/api/sources/live/events?run=1").json();
    let resets: Vec<usize> = (4..700).step_by(4).collect();
    let reset = json!({"kind": "reset", "count": 174, "every": 1, "states": resets});
    assert_eq!(events["states"], 700);
    assert!(events["events"].as_array().unwrap().contains(&reset), "{events}");
    assert_eq!(watched.get("/api/sources/live/events?run=2").status, 410);
    let distances = watched.get("/api/sources/live/costs?run=1").json();
    assert_eq!((&distances["states"], &distances["stride"]), (&json!(700), &json!(2)));
    assert_eq!(distances["optimistic"].as_array().unwrap(), &vec![json!(4); 350]);
    let drawing = watched.get("/api/sources/live/drawing.svg?run=1");
    assert!(drawing.head.contains("content-type: image/svg+xml"));
    assert!(drawing.text().contains(r#"data-wall="0,0,N""#) && !drawing.text().contains("<style"));
    watched.stop();
}

/// A mouse often logs its result after its last state.
#[test]
fn annotations_after_the_last_state_are_shown_with_it() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let get = |path: &str| watched.get(&format!("/api/sources/live/{path}")).json();
    let shown = |at: usize| {
        let view = get(&format!("moment?run=1&at={at}"));
        (view["annotations"].as_u64().unwrap(), view["texts"].clone())
    };
    watched.send_states(2);
    assert_eq!(shown(1), (0, json!([])));
    let client = connect(&watched.server, zmq::REQ);
    assert_eq!(ask(&client, b"AL\x06\0RESULTT\x01\0\x03end"), b"ok");
    assert_eq!((shown(0), shown(1)), ((1, json!([])), (1, json!([[1, "end"]]))));
    let log = |lines| json!({"lines": lines, "first": 0, "last": 1, "has_later": false});
    for at in [0, 1] {
        assert_eq!(get(&format!("log?run=1&at={at}")), log(json!([[2, "RESULT"]])));
        assert_eq!(get(&format!("log?run=1&at={at}&filter=x")), log(json!([])));
    }
    assert_eq!(get("log?run=1&at=1&from=2")["lines"], json!([[2, "RESULT"]]));
    watched.send_states(1);
    assert_eq!((shown(1).1, shown(2).1), (json!([]), json!([[1, "end"]])));
    assert_eq!(get("log?run=1&at=2")["lines"], json!([[2, "RESULT"]]));
    watched.stop();
}

#[test]
fn the_state_that_corresponds_to_a_state_of_another_run_is_found() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let find = |query: &str| {
        let reply = watched.get(&format!("/api/sources/live/find?{query}"));
        if reply.status == 200 { reply.json() } else { json!(reply.status) }
    };
    assert_eq!(find("run=1&steps=0"), 404);
    // Every fourth state, the mouse is put back at the start: three steps in four states.
    watched.send_states(1000);
    for (steps, at) in [(0, 0), (1, 1), (3, 3), (4, 5), (300, 399)] {
        let expected = json!({"at": at, "reached": true});
        assert_eq!(find(&format!("run=1&steps={steps}")), expected, "{steps}");
        assert_eq!(find(&format!("run=1&steps={steps}&leg=0")), expected, "{steps}");
    }
    let last = json!({"at": 999, "reached": false});
    for query in ["steps=751", "steps=18446744073709551615", "steps=0&leg=1"] {
        assert_eq!(find(&format!("run=1&{query}")), last, "{query}");
    }
    assert_eq!(
        (find("run=2&steps=0"), find("run=1"), find("run=1&steps=-1")),
        (json!(410), json!(400), json!(400))
    );
    watched.stop();
}

/// A mouse that marks cells as visited before it reads their walls does not know these walls.
#[test]
fn figures_rest_only_on_walls_that_the_mouse_has_read() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let client = connect(&watched.server, zmq::REQ);
    let state = |y: u8, walls: [u8; 6]| [b"S\0", &[y][..], b"NC\0\0\0\0\0\0C", &walls].concat();
    // The start is visited, with walls to the east, south and west. All other cells are marked as
    // visited without walls.
    let walls = [1 | 2 | 4 | 8, 1, 1, 1, 1, 1];
    for (reading, y) in [(b"W\0\0N", 0), (b"W\0\x01N", 1)] {
        assert_eq!(ask(&client, reading).len(), 3);
        assert_eq!(ask(&client, &state(y, walls)), b"ok");
    }
    let view = |at: usize| watched.get(&format!("/api/sources/live/moment?run=1&at={at}")).json();
    let bounds = |view: &serde_json::Value| {
        ["optimistic_distance", "pessimistic_distance"].map(|key| view[key].clone())
    };
    let (first, second) = (view(0), view(1));
    assert_eq!(bounds(&first), [json!(4), json!(null)]);
    // All walls of (0, 0) are known. The east walls of the cells to the north are not: east of
    // (0, 1), no wall has been read.
    let (north, east, south, west) = (1, 2, 4, 8);
    assert_eq!(
        first["unknown_walls"],
        json!([
            [1, north | east],
            [2, north | west],
            [3, east],
            [4, east | south | west],
            [5, south | west]
        ])
    );
    assert_eq!(
        second["unknown_walls"][2],
        json!([4, east | south]),
        "the walls of (0, 1) are known"
    );
    assert_eq!(first["visited_cells"], 6);
    let distances = watched.get("/api/sources/live/costs?run=1").json();
    assert_eq!(
        (&distances["optimistic"], &distances["pessimistic"]),
        (&json!([4, 4]), &json!([null, null]))
    );
    watched.stop();
}

#[test]
fn what_a_mouse_displays_is_returned_with_its_state() {
    let watched = WatchedServer::new("127.0.0.1", None);
    let client = connect(&watched.server, zmq::REQ);
    let displayed = |at: usize| {
        let view = watched.get(&format!("/api/sources/live/moment?run=1&at={at}")).json();
        ["mouse", "strategy", "texts", "colours", "declared_walls", "missed_walls"]
            .map(|name| view[name].clone())
    };
    let log = |query: &str| {
        let reply = watched.get(&format!("/api/sources/live/log?run=1&{query}"));
        if reply.status == 200 { reply.json() } else { json!(reply.status) }
    };
    // The third state has no annotations of its own.
    for (number, annotations) in [
        &b"AM\x07TheseusL\x05\0helloT\x01\x01\x0242C\x02\0GD\0\0N1D\0\0E0"[..],
        b"AtcL\x03\0ByeL\x05\0hallo",
        b"",
    ]
    .into_iter()
    .enumerate()
    {
        if !annotations.is_empty() {
            assert_eq!(ask(&client, annotations), b"ok");
        }
        assert_eq!(ask(&client, &harness::state(number)), b"ok");
    }
    let walls = json!([[0, true], [1, false]]);
    assert_eq!(
        displayed(0),
        [
            json!("Theseus"),
            json!(null),
            json!([[4, "42"]]),
            json!("--G---"),
            walls.clone(),
            json!([1])
        ]
    );
    for at in [1, 2] {
        let expected =
            [json!("Theseus"), json!(null), json!([]), json!(""), walls.clone(), json!([1])];
        assert_eq!(displayed(at), expected);
    }
    let found = |lines: serde_json::Value, first: usize, last: usize, has_later: bool| json!({ "lines": lines, "first": first, "last": last, "has_later": has_later });
    let all = json!([[0, "hello"], [1, "Bye"], [1, "hallo"]]);
    for at in 0..4 {
        assert_eq!(log(&format!("at={at}")), found(all.clone(), 0, 2, false));
    }
    assert_eq!(log("at=2&max=1"), found(json!([[1, "hallo"]]), 2, 2, false));
    let around = json!([[0, "hello"], [1, "Bye"]]);
    assert_eq!(log("at=0&max=1"), found(around, 0, 0, true));
    assert_eq!(log("at=2&from=1"), found(json!([[1, "Bye"], [1, "hallo"]]), 1, 2, false));
    assert_eq!(log("at=2&filter=bY"), found(json!([[1, "Bye"]]), 0, 2, false));
    assert_eq!(log("at=2&filter=none"), found(json!([]), 0, 2, false));
    assert_eq!((log("at=x"), log("max=1")), (json!(400), json!(400)));
    assert_eq!(watched.get("/api/sources/live/log?run=2&at=0").status, 410);
    for (options, texts, colours) in [("", 1, 1), ("&texts=false", 0, 1), ("&colours=false", 1, 0)]
    {
        let path = format!("/api/sources/live/picture.svg?run=1&at=0{options}");
        let svg = watched.get(&path).text().to_string();
        assert_eq!(svg.matches("data-text").count(), texts, "{options}");
        assert_eq!(svg.matches("class=\"colour\"").count(), colours, "{options}");
        assert!(svg.contains(r#"data-wall="0,0,N""#) && svg.contains("mistaken"), "{svg}");
    }
    watched.stop();
}
