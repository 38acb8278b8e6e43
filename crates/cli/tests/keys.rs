//! Every key of JSON, CSV, the HTTP API and Python is in docs/keys.md, and every entry there occurs.

mod harness;
#[path = "browser/http.rs"]
#[allow(dead_code, reason = "browser tests use the rest")]
mod http;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use harness::{Home, commands, help, mouse_messages, recorded};
use mmsim_tests::wait_for;
use serde_json::Value;

const MAZE: &str = "o---o---o---o\n|       | G |\no   o   o   o\n| S |       |\no---o---o---o\n";
const CLOSED: &str = "o---o---o\n| S | G |\no---o---o\n";

/// The keys whose values are words that the dictionary lists.
const WORDS: [&str; 9] =
    ["ending", "event", "integrity", "kind", "notation", "phase", "route", "severity", "status"];

/// Mice that fail, as commands of a shell.
const BLOCKED: &str = "printf 'turnRight\\nmoveForward\\nmoveForward\\nmoveForward\\n'";
const TURNS: &str = "yes turnLeft | head -20";
const EXITS: &str = "echo mazeWidth; exit 3";

/// Calls of each command with `--json` or `--csv`. `ADDRESS` stands for the address of a simulator.
const CALLS: &[(&str, &[&str])] = &[
    ("check-server", &["ADDRESS", "--json"]),
    ("compare", &["mazes", "--vehicle", "expert", "--strategies", "flood-fill,swing", "--json"]),
    ("compare", &["mazes", "--vehicle", "expert", "--strategies", "flood-fill", "--csv"]),
    ("compare", &["mazes", "--strategies", "flood-fill", "--against", "base.json", "--json"]),
    ("contest", &["mazes", "--strategies", "swing", "--json"]),
    ("contest", &["mazes", "--strategies", "swing", "--csv"]),
    ("fast-run", &["mazes/a.txt", "--explain", "--json"]),
    ("fast-run", &["mazes/a.txt", "--csv", "-"]),
    ("mazes check", &["mazes", "rows.txt", "bad.txt", "--json"]),
    ("mazes diff", &["mazes/a.txt", "other.txt", "--json"]),
    ("mazes diff", &["mazes/a.txt", "mazes/a.txt", "--json"]),
    ("mazes fetch", &["fetched", "--from", "bundled", "--json"]),
    ("mazes generate", &["--seed", "1", "--json"]),
    ("mazes list", &["mazes", "--json"]),
    ("mazes show", &["mazes/a.txt", "--json"]),
    ("replay", &["run.mcap", "--json"]),
    ("replay", &["mms.mcap", "--json"]),
    ("replay", &["trial.mcap", "--at", "1", "--json"]),
    ("run", &["--port", "0", "--no-viewer", "--json", "--", "echo", "mazeWidth"]),
    (
        "run",
        &["--maze", "mazes/a.txt", "--port", "0", "--no-viewer", "--json", "sh", "-c", BLOCKED],
    ),
    ("run", &["--maze", "mazes/a.txt", "--port", "0", "--no-viewer", "--json", "sh", "-c", TURNS]),
    ("run", &["--maze", "mazes/a.txt", "--port", "0", "--no-viewer", "--json", "sh", "-c", EXITS]),
    ("solve", &["fastest-path-search", "--connect", "ADDRESS", "--json"]),
    ("trial", &["mazes/a.txt", "--robot", "random", "--path", "--json"]),
    ("trial", &["mazes/a.txt", "--json", "--", "false"]),
    ("trial", &["mazes/a.txt", "--compare", "--json"]),
];

/// Requests to each route of the API, in this order, with the bodies of POST requests. `RUN` stands for
/// the run number.
const REQUESTS: &[(&str, &str, Option<&str>)] = &[
    ("/api/page", "/api/page", None),
    ("/api/mazes", "/api/mazes", None),
    ("/api/mazes/picture.svg", "/api/mazes/picture.svg?path=training-first-steps.txt", None),
    ("/api/mazes/read", "/api/mazes/read?name=rows.txt", Some("bf\nab\nee\n")),
    ("/api/maze", "/api/maze", Some(r#"{"path":"training-first-steps.txt"}"#)),
    ("/api/mouse", "/api/mouse", Some(r#"{"action":"run","strategy":"swing"}"#)),
    ("/events", "", None),
    ("/api/sources/{id}", "/api/sources/live", None),
    ("/api/sources/{id}/drawing.svg", "/api/sources/live/drawing.svg?run=RUN", None),
    ("/api/sources/{id}/states", "/api/sources/live/states?run=RUN&from=0", None),
    ("/api/sources/{id}/picture.svg", "/api/sources/live/picture.svg?run=RUN&at=1", None),
    ("/api/sources/{id}/picture.png", "/api/sources/live/picture.png?run=RUN&at=1", None),
    ("/api/sources/{id}/animation.gif", "/api/sources/live/animation.gif?run=RUN", None),
    ("/api/sources/{id}/moment", "/api/sources/live/moment?run=RUN&at=1", None),
    ("/api/sources/{id}/costs", "/api/sources/live/costs?run=RUN", None),
    ("/api/sources/{id}/events", "/api/sources/live/events?run=RUN", None),
    ("/api/sources/{id}/result", "/api/sources/live/result?run=RUN", None),
    ("/api/sources/{id}/log", "/api/sources/live/log?run=RUN&at=1", None),
    ("/api/sources/{id}/find", "/api/sources/live/find?run=RUN&steps=1", None),
    ("/api/sources/{id}/fast-runs/{vehicle}", "/api/sources/live/fast-runs/ares?run=RUN", None),
    (
        "/api/sources/{id}/mouse-fast-runs/{vehicle}",
        "/api/sources/live/mouse-fast-runs/ares?run=RUN&at=1",
        None,
    ),
    ("/api/sources/{id}/recording.mcap", "/api/sources/live/recording.mcap?run=RUN", None),
    ("/api/sources/{id}/page.html", "/api/sources/live/page.html?run=RUN", None),
    ("/api/sources/{id}/data.html", "/api/sources/live/data.html?run=RUN", None),
    ("/api/recordings", "/api/recordings", None),
    ("/api/recordings/open", "/api/recordings/open", Some(r#"{"name":"trial.mcap"}"#)),
    ("/api/sources/{id}", "/api/sources/1", None),
    ("/api/sources/{id}/moment", "/api/sources/1/moment?run=0&at=1", None),
    ("/api/recordings/close", "/api/recordings/close", Some(r#"{"id":"1"}"#)),
    ("/api/recordings/summary", "/api/recordings/summary?name=trial.mcap", None),
    (
        "/api/recordings/rename",
        "/api/recordings/rename",
        Some(r#"{"name":"trial.mcap","to":"other"}"#),
    ),
    ("/api/recordings/delete", "/api/recordings/delete", Some(r#"{"name":"other.mcap"}"#)),
];

/// Reads a file of the repository.
fn read(path: &str) -> String {
    fs::read_to_string(format!("{}/../../{path}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// Returns the texts between backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// The entries of docs/keys.md.
struct Dictionary {
    /// The meaning of each key.
    meanings: BTreeMap<String, String>,
    /// The keys of objects whose keys are data.
    maps: BTreeSet<String>,
    /// Other words that may be values.
    words: String,
    found: BTreeSet<String>,
    faults: BTreeSet<String>,
}

impl Dictionary {
    fn read() -> Self {
        let text = read("docs/keys.md");
        let (_, maps) = text.split_once("Some objects are maps").unwrap();
        let maps = maps.split_once("are endings").unwrap().0;
        let (mut meanings, mut faults) = (BTreeMap::new(), BTreeSet::new());
        for row in text.lines().filter(|line| line.starts_with("| `")) {
            let cells: Vec<&str> = row.split(" | ").collect();
            for key in quoted(cells[0]) {
                if meanings.insert(key.to_string(), cells[1].to_string()).is_some() {
                    faults.insert(format!("docs/keys.md has two entries for {key}"));
                }
                if !key.starts_with(|c: char| c.is_ascii_lowercase())
                    || !key.bytes().all(|c| matches!(c, b'a'..=b'z' | b'0'..=b'9' | b'_'))
                {
                    faults.insert(format!("{key} is not in snake case"));
                }
            }
        }
        Self {
            meanings,
            maps: quoted(maps).map(String::from).collect(),
            words: read("docs/formats.md"),
            found: BTreeSet::new(),
            faults,
        }
    }

    fn add_key(&mut self, place: &str, key: &str) {
        if !self.meanings.contains_key(key) {
            self.faults.insert(format!("docs/keys.md has no entry for {key} ({place})"));
        }
        self.found.insert(key.into());
    }

    fn add_word(&mut self, place: &str, key: &str, word: &str) {
        let more = match key {
            "phase" => self.meanings.get("status"),
            "kind" => Some(&self.words),
            _ => None,
        };
        let mut texts = self.meanings.get(key).into_iter().chain(more);
        if !texts.any(|text| quoted(text).any(|listed| listed == word)) {
            self.faults.insert(format!("docs/keys.md does not list {word} for {key} ({place})"));
        }
    }

    fn add(&mut self, place: &str, value: &Value) {
        match value {
            Value::Array(list) => list.iter().for_each(|value| self.add(place, value)),
            Value::Object(object) => {
                for (key, value) in object {
                    self.add_key(place, key);
                    match value {
                        Value::Object(map) if self.maps.contains(key) => {
                            map.values().for_each(|value| self.add(place, value));
                        }
                        Value::String(word) if WORDS.contains(&&**key) => {
                            self.add_word(place, key, word);
                        }
                        value => self.add(place, value),
                    }
                }
            }
            _ => (),
        }
    }
}

/// Returns the address of the page in messages of a server.
fn page(messages: &str) -> String {
    let page = messages.split_whitespace().find(|word| word.starts_with("http://"));
    page.expect("the address of the page").trim_end_matches(['/', ';', ',']).into()
}

/// Adds the keys of what each command prints.
fn add_commands(dictionary: &mut Dictionary, home: &Home, address: &str) {
    for command in commands(home) {
        let help = help(home, &command);
        for option in ["--json", "--csv"] {
            let has_option = help.lines().any(|line| line.trim_start().starts_with(option));
            let is_called = |(name, arguments): &(&str, &[&str])| {
                *name == command && arguments.contains(&option)
            };
            assert_eq!(CALLS.iter().any(is_called), has_option, "a call of {command} {option}");
        }
    }
    for (command, arguments) in CALLS {
        let arguments =
            arguments.iter().map(|&word| if word == "ADDRESS" { address } else { word });
        let words: Vec<&str> = command.split(' ').chain(arguments).collect();
        let (ended, place) = (home.run(&words), words.join(" "));
        if words.contains(&"--json") {
            dictionary.add(&place, &ended.json());
        } else {
            let head = ended.stdout.lines().next().unwrap_or_else(|| panic!("{place}: {ended:?}"));
            head.split(',').for_each(|key| dictionary.add_key(&place, key));
        }
    }
}

/// Adds the keys of the replies of the API.
fn add_api(dictionary: &mut Dictionary, page: &str) {
    let source = read("crates/viewer/src/http/api.rs");
    let (_, routes) = source.split_once("fn buffered_routes").unwrap();
    let (routes, _) = routes.split_once("async fn").unwrap();
    for route in routes.split('"').filter(|text| text.starts_with('/')) {
        assert!(REQUESTS.iter().any(|(asked, ..)| *asked == route), "no request to {route}");
    }
    for (route, path, body) in REQUESTS {
        if *route == "/events" {
            let event = wait_for("the end of the mouse", || {
                let event = http::first_event(page);
                (!event["mouse_status"]["outcome"].is_null()).then_some(event)
            });
            dictionary.add(route, &event);
            continue;
        }
        let run = http::get(&format!("{page}/api/sources/live")).json()["run"].to_string();
        let url = format!("{page}{}", path.replace("RUN", &run));
        let reply = match body {
            None => http::get(&url),
            Some(body) => {
                let headers = [("content-type", "application/json"), ("origin", page)];
                http::request("POST", &url, &headers, body.as_bytes())
            }
        };
        assert!(matches!(reply.status, 200 | 204), "{route}: {} {}", reply.status, reply.text());
        if reply.header("content-type") == Some("application/json") {
            dictionary.add(route, &reply.json());
        }
    }
}

/// Adds the attributes of the classes in Python.
fn add_python(dictionary: &mut Dictionary) {
    let stubs = read("crates/python/python/micromouse_sim/_native.pyi");
    let attributes = stubs.split("    @property\n    def ").skip(1);
    for name in attributes.filter_map(|text| Some(text.split_once('(')?.0)) {
        dictionary.add_key("Python", name);
    }
}

#[test]
fn every_key_is_in_the_dictionary() {
    let home = Home::new();
    home.write("mazes/a.txt", MAZE);
    home.write("mazes/closed.txt", CLOSED);
    home.write("other.txt", MAZE.replace("| S |       |", "| S |   |   |"));
    home.write("rows.txt", "bf\nab\nee\n");
    home.write("bad.txt", "o---o\n");
    let saved = ["compare", "mazes", "--strategies", "flood-fill", "--save", "base.json"];
    assert_eq!(home.run(&saved).code, Some(0));
    let mut saved: Value =
        serde_json::from_slice(&fs::read(home.path().join("base.json")).unwrap()).unwrap();
    saved[0]["mazes"][0]["total_time_s"] = 999.into();
    home.write("base.json", saved.to_string());
    home.write(
        "mazes/b.txt",
        MAZE.replace("o   o   o   o", "o   o---o   o").replace("    | G", "      G"),
    );
    let record = |arguments: &[&str], to: &str| {
        let ended = home.run(arguments);
        assert!(ended.stderr.contains("recording"), "{ended:?}");
        fs::rename(recorded(&home.path().join("new")), home.path().join(to)).unwrap();
    };
    let serve = ["--port", "0", "--no-viewer", "--record", "new"];
    record(&[&["demo", "mazes/a.txt", "--once"], &serve[..]].concat(), "run.mcap");
    let trial = ["trial", "mazes/a.txt", "--robot", "random", "--serve", "--once"];
    record(&[&trial, &serve[..]].concat(), "trial.mcap");
    let mouse = ["--", "printf", r"mazeWidth\nsetColor 0 0 g\nsetText 0 0 a\nmoveForward\n"];
    record(&[&["run", "--maze", "mazes/a.txt"], &serve[..], &mouse].concat(), "mms.mcap");
    fs::create_dir(home.path().join("kept")).unwrap();
    fs::copy(home.path().join("trial.mcap"), home.path().join("kept/trial.mcap")).unwrap();
    let mut dictionary = Dictionary::read();
    for file in ["run.mcap", "trial.mcap"] {
        for message in mouse_messages(&home.path().join(file)) {
            dictionary.add(file, &message);
        }
    }
    let serve = ["--port", "0", "--viewer-port", "0", "--record", "kept", "--json"];
    let mut server = home.serve_until(&serve, "http://");
    add_commands(&mut dictionary, &home, &server.address);
    add_api(&mut dictionary, &page(&server.messages));
    server.kill();
    dictionary.add("mmsim --json", &serde_json::from_str(&server.stdout()).unwrap());
    add_python(&mut dictionary);
    let unused = dictionary.meanings.keys().filter(|key| !dictionary.found.contains(*key));
    let unused: Vec<String> = unused
        .map(|key| format!("docs/keys.md has an entry for {key}, which never occurs"))
        .collect();
    dictionary.faults.extend(unused);
    let faults = Vec::from_iter(dictionary.faults);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
